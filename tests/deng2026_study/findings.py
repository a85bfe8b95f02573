"""Hold README.md and two pages of docs/study against finished runs of `demo` and `thermal`.

    python tests/deng2026_study/findings.py

Each text of `findings.yaml` must stand in its page with the numbers of the tables of `results`.
"""

import sys
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from deng2026_study.advice import NO_CHOICE
from deng2026_study.extrapolation import relative_rms
from oilfilm.torque.torque_control import without_bistable

ROOT = Path(__file__).parents[2]
PAPER_LAW = "deng2026"
# What names of numbers begin with.
CAMPAIGNS = {"demo": "", "thermal": "hot_"}
PAGES = {
    "bearing": ROOT / "docs/study/bearing.md",
    "README": ROOT / "README.md",
    "findings": ROOT / "docs/study/findings.md",
}


def table(campaign: str, name: str, folder: str = "tables") -> pd.DataFrame:
    return pd.read_parquet(ROOT / f"results/{campaign}/{folder}/{name}.parquet")


demo, thermal = partial(table, "demo"), partial(table, "thermal")


def span(values: "pd.Series[float]", digits: int = 0, factor: float = 100) -> str:
    """The smallest and the largest value, in percent by default."""
    ends = [f"{factor * value:.{digits}f}" for value in (values.min(), values.max())]
    return " to ".join(dict.fromkeys(ends))


def of_advice(campaign: str) -> dict[str, Any]:
    """By choice: points where it agrees, of how many, its band, and that in the order as set."""
    band = table(campaign, "advice_band")
    band["share"] = band["agreeing_points"] / band["operating_points"]
    judged = table(campaign, "slip_advice")["judgement"].value_counts()
    others = ("heats more", "slips more", "rule has none")
    found = dict.fromkeys(others, 0) | dict(judged)
    by_truth = table(campaign, "slip_advice")["true_judgement"].value_counts()
    by_truth = by_truth.drop(list(NO_CHOICE), errors="ignore")
    found |= {f"true_{other}": by_truth.get(other, 0) for other in others}
    found["true_rules"] = (by_truth.get("agree", 0), by_truth.sum())
    of_truth = band[band["traction"] == "truth"].groupby("choice")["share"]
    found |= {f"true_band_{choice}": span(share) for choice, share in of_truth}
    band = band[band["traction"] == "law"]
    for choice, rows in band.groupby("choice"):
        as_set = rows.loc[rows["rule_order"] == "as set", "share"]
        counts = rows.iloc[0][["agreeing_points", "operating_points"]]
        name = f"oil{choice}" if choice.isdigit() else choice
        found[name] = (*counts, span(rows["share"]), span(as_set))
    return found


def of_demo() -> dict[str, Any]:
    """What is said of the printed law."""
    numbers = demo("claim_numbers").query("claim == 'viscosity-order' and basis == 'printed'")
    above = numbers[numbers["number"] == "above_next"].set_index("oil")["value"]
    fits = demo("coefficients").query("law == @PAPER_LAW")
    ratio = span(fits["standard_error"] / fits["naive_standard_error"], factor=1)
    assert ratio == "2 to 7", ratio  # in words on both pages
    wang = demo("fit_quality").query("law.str.startswith('wang')")
    assert (len(wang), wang["certified"].any()) == (9, False)
    zero, on_load = wang["zero_slip_traction"].abs(), wang["law"] != "wang-deng-groups"
    slips = demo("cage_slip").query("0.15 <= cage_slip <= 0.8")
    return {
        **{f"above_{oil}": f"{100 * above[oil]:.0f}" for oil in ("4102", "4050")},
        "zero_on_load": zero[on_load].max(),
        "zero_of_groups": zero[~on_load].max(),
        "race_slip": span(slips["inner_slide_roll_ratio"] / slips["cage_slip"], 2, 1),
    }


def of_thermal() -> dict[str, Any]:
    """What is said of laws where none is true."""
    quality, truth = thermal("fit_quality"), thermal("extrapolation")
    own, at = quality[quality["law"] == PAPER_LAW], truth[truth["law"] == PAPER_LAW]
    assert own["certified"].all()
    beyond = at[at["beyond"].map(len) > 0].groupby("oil")
    off = at[at["figure"] == "fig07"].eval("traction_coefficient / true_traction_coefficient - 1")
    mean = 100 * off.groupby(at["slide_roll_ratio"].round(2)).mean()
    inside = {
        name: at["true_traction_coefficient"].between(at[f"{name}_lower"], at[f"{name}_upper"])
        for name in ("mean_ci", "obs_ci")
    }
    is_supported = at["obs_ci_lower"].notna()
    inside["obs_ci"] = inside["obs_ci"][is_supported]
    inside["supported"] = is_supported
    laws = thermal("extrapolation_errors").set_index("law")
    laws = laws[["inside_relative_rms", "beyond_relative_rms"]]
    others = laws.drop("eyring")
    wang = quality[quality["law"].str.startswith("wang")]
    zero, critical = wang["zero_slip_traction"].abs(), wang["law"] == "wang-deng-critical-load"
    growth = quality.assign(growth=quality["left_out_rmse"] / quality["rmse"])
    of_own = growth[growth["law"] == PAPER_LAW].set_index("oil")["growth"]
    more = wang["oil"].map(of_own).rdiv(growth.loc[wang.index, "growth"]).max() - 1
    assert more < 0.01, more  # "within 1 %"
    return {
        "own_rms": span(own["relative_rms"]),
        "beyond_rms": span(pd.Series({oil: relative_rms(rows) for oil, rows in beyond})),
        **{"low": -mean[0.04], "high": mean[0.3]},
        **{name: 100 * share.mean() for name, share in inside.items()},
        "eyring": 100 * laws.loc["eyring"].to_numpy(),
        "critical": 100 * laws.loc["wang-deng-critical-load"].to_numpy(),
        "others_inside": span(others.iloc[:, 0]),
        "others_beyond": span(others.drop("wang-deng-critical-load").iloc[:, 1]),
        **{"hot_zero": zero[~critical].max(), "hot_zero_critical": zero[critical].max()},
    }


def of_torque(campaign: str) -> dict[str, Any]:
    """By load variable: median and largest error of torque and of traction's part, in percent."""
    rows = without_bistable(table(campaign, "torque"))
    truth = table(campaign, "torque_truth", "twin")
    # levels of speed are thousands of rpm apart
    truth, rows = (each.assign(speed=each["inner_speed_rpm"].round(-3)) for each in (truth, rows))
    keys = ["run_id", "speed"]
    rows = rows.merge(truth, on=keys, suffixes=("", "_true"), validate="many_to_one")
    rows = rows.assign(
        error=100 * rows["relative_error"].abs(),
        part=100 * (rows["traction_torque_n_m"] / rows["traction_torque_n_m_true"] - 1).abs(),
        own=(rows["torque_n_m"] / rows["torque_n_m_true"] - 1).abs(),
    )
    found: dict[str, Any] = {}
    for variable, here in rows.groupby("load_variable"):
        ends = [f(here[name]) for name in ("error", "part") for f in (pd.Series.median, max)]
        found[str(variable)] = (*ends, 100 * (here["error"] <= 3.79).mean())
    own = rows[rows["load_variable"] == "stress"].groupby("oil")["own"]
    return found | {"own_medians": span(own.median(), 2), "own_worst": 100 * own.max().max()}


def main() -> int:
    numbers = of_demo() | of_thermal()
    for campaign, begins in CAMPAIGNS.items():
        found = of_advice(campaign) | of_torque(campaign)
        numbers |= {f"{begins}{name}": value for name, value in found.items()}
    wanted = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"))
    wrong = []
    for page, texts in wanted.items():
        content = " ".join(PAGES[page].read_text("utf-8").split())
        stated = (text.format_map(numbers) for text in texts)
        wrong += [
            f"{PAGES[page].relative_to(ROOT)} must say: {t}" for t in stated if t not in content
        ]
    print(*wrong or ["The pages have the numbers of these runs."], sep="\n")
    return len(wrong) > 0


if __name__ == "__main__":
    sys.exit(main())
