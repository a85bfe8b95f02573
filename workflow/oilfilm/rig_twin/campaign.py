"""A whole simulated campaign: the logs of every planned run and the table of the truth."""

from collections.abc import Iterator, Mapping
from typing import Any

from oilfilm.errors import OilfilmError
from oilfilm.randomness import generator
from oilfilm.rig_twin.plan import PlannedRun, planned_runs
from oilfilm.rig_twin.simulate import simulate_log
from oilfilm.rig_twin.truth import known_contact, true_tractions
from oilfilm.units import FloatArray


def simulate_campaign(
    config: Mapping[str, Any], constants: Mapping[str, FloatArray]
) -> Iterator[tuple[PlannedRun, bytes, dict[str, Any]]]:
    """Each planned run with the bytes of its log and its row of the truth table.

    `constants` are the printed ones, which are true unless the campaign's twin has another truth.
    The random numbers of a run depend on the seed and the run's name alone, so that a run is the
    same whichever others are simulated with it.
    """
    campaign = config["campaign"]
    tractions, contact = true_tractions(config, constants), known_contact(config)
    ((name, rig),) = config["rigs"].items()
    if "full_scale" not in rig:
        raise OilfilmError(
            f"config/rigs/{name}.yaml: the rig twin needs the key `full_scale`. Add it."
        )
    for run in planned_runs(campaign):
        random = generator(config["seed"], "rig twin", run.name)
        content, truth = simulate_log(
            run, tractions[run.oil], contact, campaign["twin"], rig, random
        )
        yield run, content, truth
