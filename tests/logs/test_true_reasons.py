"""A log is refused for its true reason: the sentence names what is wrong, first of all."""

import numpy as np
import pytest

import formats
from bad_logs import CONFIG, GOOD, KEYS, UNITS, csv, good
from oilfilm.curation.curate import check_logs
from oilfilm.settings.resolved import Settings


def reason(content: bytes, settings: Settings = CONFIG) -> tuple[str, str]:
    """Rule and sentence of the refusal of a run, or of the file where there is none."""
    verdict = check_logs([("log", content)], settings)
    assert not verdict.points["accepted"].any()
    for run in verdict.runs.to_dict("records"):
        return run["rule"], run["reason"]
    first = verdict.quarantine.iloc[0]
    return first["rule"], first["reason"]


@pytest.mark.parametrize(
    ("logged", "given", "contradicts"),
    [("N", "lbf", True), ("N", "N", False), ("N", "newton", False), ("", "lbf", False)],
)
def test_unit_of_the_campaign_that_contradicts_the_log_is_refused(
    logged: str, given: str, contradicts: bool
) -> None:
    """A load of 82 N would be 365 N, and mu a fourth of what it is."""
    name = f"Normalkraft [{logged}]" if logged else "Normalkraft"
    content = GOOD.replace(b"load [N]", name.encode())
    columns = {"load": {"name": "Normalkraft", "unit": given}}
    settings = CONFIG.with_changes({"campaign": {"columns": columns}})
    quarantine = check_logs([("log", content)], settings).quarantine
    told = quarantine["reason"].str.contains("is in 'N' by the log itself and in 'lbf' by").any()
    assert told == contradicts


@pytest.mark.parametrize("factor", [5, 0.2, 2])
def test_change_of_the_sampling_rate_is_told(factor: float) -> None:
    values = good(seconds=12.0)
    half = len(values["time"]) // 2
    steps = np.where(np.arange(len(values["time"])) < half, 0.05, 0.05 * factor)
    rule, sentence = reason(csv({**values, "time": np.cumsum(steps)}))
    assert rule == "sampling_rate"
    assert f"every 0.05 s at first and every {0.05 * factor:.3g} s from about row" in sentence


@pytest.mark.parametrize("resolution", [0.05, 0.02, 0.1, 1.0])
def test_coarse_time_stamps_are_no_change_of_the_rate(resolution: float) -> None:
    values = good(seconds=12.0)
    coarse = np.floor(values["time"] / resolution + 1e-9) * resolution
    runs = check_logs([("log", csv({**values, "time": coarse}))], CONFIG).runs
    assert "sampling_rate" not in set(runs["rule"])


def test_row_of_units_of_another_rig_is_seen() -> None:
    """As a wear rig writes it: the first is a mass, not a force."""
    names = "Fx,load,Y Position,disc_speed,Time"
    rows = "\n".join(f"12.1,8.2,3.0,10.0,{n / 10}" for n in range(20))
    log = f"# oil: 4102\n{names}\ng,kg,mm,mm/sec,sec\n{rows}\n".encode()
    columns = {"traction_force": {"name": "Fx"}, "time": {"name": "Time"}}
    rule, sentence = reason(log, CONFIG.with_changes({"campaign": {"columns": columns}}))
    assert rule == "columns"
    assert "has no unit" not in sentence
    # speeds are what it lacks, whatever its units
    assert "lacks the columns inlet_temperature, ball_speed" in sentence
    assert "without both speeds nothing rolls" in sentence


def test_tail_of_zero_bytes_is_told() -> None:
    rule, sentence = reason(GOOD + bytes(4096))
    assert rule == "truncated"
    assert "4096 zero bytes" in sentence


def test_half_of_the_rows_with_another_decimal_mark_is_told() -> None:
    lines = GOOD.decode().splitlines()
    rows = [line.replace(",", ";") for line in lines if not line.startswith("#")]
    german = [rows[0], *(row.replace(".", ",") for row in rows[1 : len(rows) // 2])]
    log = "\n".join(["# oil: 4102", *german, *rows[len(rows) // 2 :], ""])
    rule, sentence = reason(log.encode())
    assert rule == "decimal_marks"
    assert "most other rows have a decimal comma" in sentence


@pytest.mark.parametrize("value", ["900", "1250"])
def test_pressure_in_mpa_that_is_labelled_gpa_is_told(value: str) -> None:
    rule, sentence = reason(csv(max_hertz_pressure_gpa=value))
    assert (rule, "below 10 (in GPa, not MPa)" in sentence) == ("header", True)
    values = {**good(), "load": np.full(len(good()["load"]), float(value))}
    content = formats.csv(values, {**UNITS, "load": "GPa"}, KEYS)
    assert check_logs([("log", content)], CONFIG).points.empty
