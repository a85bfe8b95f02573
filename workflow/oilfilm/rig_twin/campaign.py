"""A whole simulated campaign: the logs of every planned run and the table of the truth."""

from collections.abc import Iterator, Mapping
from typing import Any

from oilfilm.randomness import generator
from oilfilm.rig_twin.plan import PlannedRun, planned_runs
from oilfilm.rig_twin.simulate import simulate_log
from oilfilm.rig_twin.truth import known_contact, true_tractions
from oilfilm.settings.base import present
from oilfilm.settings.resolved import Settings
from oilfilm.units import FloatArray


def simulate_campaign(
    settings: Settings, constants: Mapping[str, FloatArray]
) -> Iterator[tuple[PlannedRun, bytes, dict[str, Any]]]:
    """Each planned run with the bytes of its log and its row of the truth table.

    `constants` are the printed ones, which are true unless the campaign's twin has another truth.
    The random numbers of a run depend on the seed and the run's name alone, so that a run is the
    same whichever others are simulated with it.
    """
    tractions, contact = true_tractions(settings, constants), known_contact(settings)
    ((name, rig),) = settings.rigs.items()
    for key in ("full_scale", "ball_track_radius_m", "disc_track_radius_m"):
        present(getattr(rig, key), key, f"config/rigs/{name}.yaml")
    twin = present(settings.campaign.twin, "twin", "the campaign")
    for run in planned_runs(settings.campaign):
        random = generator(settings.seed, "rig twin", run.name)
        content, truth = simulate_log(run, tractions[run.oil], contact, twin, rig, random)
        yield run, content, truth
