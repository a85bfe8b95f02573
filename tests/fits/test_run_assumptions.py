"""What is known of the runs before the data: from files of rigs and the configuration, and back."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import pytest

from fit_points import LAW
from lawless_truths import TRUTHS
from oilfilm import tables
from oilfilm.fits.run_assumptions import RunAssumptions
from oilfilm.fits.surface_search import searched_surface_tables
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Calibration, ErrorsBetweenRuns, Rig
from oilfilm.surface.effects import ErrorPriors
from surface_campaigns import PlantedErrors, fitted_law, latin, simulated


def rig(**errors: float) -> Rig:
    """A rig that states some errors between runs."""
    stated = ErrorsBetweenRuns(**errors) if errors else None
    return Rig(name="rig", source="a test", errors_between_runs=stated)


def of_rigs(config: Settings, *rigs: Rig) -> RunAssumptions:
    """What is known of the runs of some rigs."""
    return of_runs(config, rigs, None)


def of_runs(
    config: Settings, rigs: Sequence[Rig], rig_name_of_run: Sequence[str] | None
) -> RunAssumptions:
    """What is known of runs on some of the rigs a, b, c."""
    return RunAssumptions.from_settings(
        config.same_condition, dict(zip("abc", rigs, strict=False)), rig_name_of_run
    )


def test_a_size_that_no_rig_states_is_that_of_usual_rigs(config: Settings) -> None:
    assumed = of_rigs(config, rig(inlet_temperature_k=2.0))
    assert assumed.error_sizes.temperature_k.median == 2.0
    assert assumed.error_sizes.gain == ErrorPriors().gain
    assert "temperature_k" not in assumed.usual_error_names
    assert "gain" in assumed.usual_error_names


def test_without_a_rig_all_sizes_are_usual(config: Settings) -> None:
    assumed = of_rigs(config)
    assert assumed.error_sizes == ErrorPriors()
    assert len(assumed.usual_error_names) == 5


def test_of_two_rigs_the_mean_square_counts(config: Settings) -> None:
    slow, fast = rig(slip_relative=0.003), rig(slip_relative=0.004)
    assumed = of_rigs(config, slow, fast)
    assert assumed.error_sizes.slip_scale.median == pytest.approx(np.sqrt(12.5e-6))
    # a rig that states nothing has the usual size, and its size is named as usual
    mixed = of_rigs(config, slow, rig())
    assert "slip_scale" in mixed.usual_error_names


def test_a_rig_that_ran_no_test_of_the_oil_does_not_count(config: Settings) -> None:
    rigs = rig(slip_relative=0.003), rig(slip_relative=0.1), rig()
    assumed = of_runs(config, rigs, ["a", "a"])
    assert assumed.error_sizes.slip_scale.median == pytest.approx(0.003)
    assert "slip_scale" not in assumed.usual_error_names


def test_a_surface_from_its_tables_rests_on_the_same_assumptions(config: Settings) -> None:
    assumed = of_rigs(config, rig(inlet_temperature_k=2.0, zero_as_traction_coefficient=1e-4))
    row = {**assumed.surface_columns()}
    sizes = pd.DataFrame(assumed.size_rows("4050"))
    again = RunAssumptions.from_tables(row, sizes)
    assert again.level_widths == assumed.level_widths
    assert again.usual_error_names == assumed.usual_error_names
    for name in ("gain", "zero", "slip_scale", "temperature_k", "noise"):
        median = getattr(assumed.error_sizes, name).median
        assert getattr(again.error_sizes, name).median == pytest.approx(median, rel=1e-12)


def calibrated(force: float, load: float) -> Rig:
    """A rig with a calibration."""
    calibration = Calibration(
        traction_force_relative=force, load_relative=load, speed_relative=0.01, temperature_c=1.0
    )
    return Rig(name="rig", source="a test", calibration=calibration)


def test_rigs_are_expected_to_differ_by_their_calibration(config: Settings) -> None:
    # mu is force over load: 0.003 and 0.004 together are 0.005
    rigs = [calibrated(0.003, 0.004), calibrated(0.004, 0.003)]
    assumed = of_runs(config, rigs, ["b", "a"])
    assert assumed.error_sizes.rig_gain.median == pytest.approx(0.005)
    assert "rig_gain" not in assumed.usual_error_names
    assert assumed.rig_names == ("a", "b")
    # the usual 1 % stands for the rig without a calibration, as with the other sizes
    mixed = of_runs(config, [*rigs, rig()], ["b", "a", "c"])
    expected_gain = np.sqrt((2 * 0.005**2 + 0.01**2) / 3)
    assert mixed.error_sizes.rig_gain.median == pytest.approx(expected_gain)
    assert "rig_gain" in mixed.usual_error_names


@pytest.mark.parametrize(("accepted", "expected"), [(0.2, 0.2), (1e-5, 1e-4)])
def test_every_accepted_calibration_gives_a_difference_of_rigs(
    config: Settings, accepted: float, expected: float
) -> None:
    rigs = [calibrated(accepted, accepted)] * 2
    assumed = of_runs(config, rigs, ["a", "b"])
    assert assumed.error_sizes.rig_gain.median == expected
    again = RunAssumptions.from_tables(
        assumed.surface_columns(), pd.DataFrame(assumed.size_rows("4050"))
    )
    assert again.error_sizes.rig_gain.median == pytest.approx(expected, rel=1e-12)


def test_stated_size_at_its_limit_survives_the_tables(config: Settings) -> None:
    # exp(log(0.005)) is larger than 0.005
    assumed = of_rigs(config, rig(zero_as_traction_coefficient=5e-3, slip_relative=1e-4))
    again = RunAssumptions.from_tables(
        assumed.surface_columns(), pd.DataFrame(assumed.size_rows("4050"))
    )
    assert again.error_sizes.zero.median == pytest.approx(5e-3, rel=1e-12)


def test_one_rig_is_not_expected_to_differ(config: Settings) -> None:
    assumed = of_runs(config, [rig()], ["a", "a"])
    assert "rig_gain" not in assumed.usual_error_names
    assert "rig_gain" not in {row["size"] for row in assumed.size_rows("4050")}


@pytest.mark.parametrize("rig_of_runs", [None, ["a", "a"], ["a", "b"]])
def test_rigs_of_runs_survive_their_tables(config: Settings, rig_of_runs: list[str] | None) -> None:
    rigs = [calibrated(0.003, 0.004), calibrated(0.004, 0.003)]
    assumed = of_runs(config, rigs, rig_of_runs)
    again = RunAssumptions.from_tables(
        assumed.surface_columns(), pd.DataFrame(assumed.size_rows("4050"))
    )
    assert again.rig_name_of_run == assumed.rig_name_of_run
    assert again.error_sizes.rig_gain.median == pytest.approx(assumed.error_sizes.rig_gain.median)


@pytest.mark.slow
def test_a_stated_temperature_error_counts_where_no_run_is_repeated(config: Settings) -> None:
    # runs scatter by 3 K, and the usual 0.5 K is a prior that 24 runs do not outweigh in full
    errors = PlantedErrors(temperature_k=3.0)
    points = simulated(TRUTHS["own"], latin(), np.random.default_rng(7), errors)
    law = fitted_law(points)
    found = {}
    for name, assumed in {
        "usual": of_rigs(config),
        "stated": of_rigs(config, rig(inlet_temperature_k=3.0)),
    }.items():
        surface = searched_surface_tables("own", LAW.name, law, points, config.surface, assumed)
        (row,) = tables.rows(surface.surfaces)
        found[name] = row["temperature_sd_k"]
    assert abs(found["stated"] - 3.0) < abs(found["usual"] - 3.0)
    assert found["stated"] == pytest.approx(3.0, rel=0.3)
