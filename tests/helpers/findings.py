"""Hold README.md and two pages of docs/explanation against finished runs of `demo` and `thermal`.

    python tests/helpers/findings.py

Each text below must stand in the page with the numbers of the tables of `results`.
"""

import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pandas as pd

from oilfilm.paper.extrapolation import errors_by_law, relative_rms
from oilfilm.torque.torque_control import without_bistable

ROOT = Path(__file__).parents[2]
PAPER_LAW = "deng2026"
CAMPAIGNS = ("demo", "thermal")


def table(campaign: str, name: str) -> pd.DataFrame:
    return pd.read_parquet(ROOT / f"results/{campaign}/tables/{name}.parquet")


demo, thermal = partial(table, "demo"), partial(table, "thermal")


def span(values: "pd.Series[float]", digits: int = 0, factor: float = 100) -> str:
    """The smallest and the largest value, in percent by default."""
    ends = [f"{factor * value:.{digits}f}" for value in (values.min(), values.max())]
    return " to ".join(dict.fromkeys(ends))


def of_advice(campaign: str) -> dict[str, tuple[int, int, str, str]]:
    """By choice: points where it agrees, of how many, its band, and that in the order as set."""
    band = table(campaign, "advice_band")
    share = band["agreeing_points"] / band["operating_points"]
    as_set = share[band["rule_order"] == "as set"]
    found = {}
    for choice, rows in band.groupby("choice"):
        nominal = rows.iloc[0]
        found[str(choice)] = (
            *(int(nominal["agreeing_points"]), int(nominal["operating_points"])),
            *(span(share[rows.index]), span(as_set.reindex(rows.index).dropna())),
        )
    return found


def of_both() -> Iterator[tuple[str, str]]:
    """Page and text: what is said of the advice on oils."""
    first, second = of_advice("demo"), of_advice("thermal")
    for oil in ("4050", "4010", "4102"):
        cells = " | ".join(f"{each[oil][0]} ({each[oil][2]} %)" for each in (first, second))
        yield "findings", f"| always {oil} | {cells} |"
    rules = first["rules"], second["rules"]
    yield (
        "findings",
        "| the rules, as set | {} of {} | {} of {} |".format(
            *(number for each in rules for number in each[:2])
        ),
    )
    yield (
        "findings",
        "| the rules, over the band | {} |".format(
            " | ".join(f"{each[2]} % (in the order as set {each[3]} %)" for each in rules)
        ),
    )
    yield (
        "README",
        f"at {rules[0][0]} of {rules[0][1]} operating points if the paper's law is true, at "
        f"{rules[1][0]} if a heated film is.",
    )
    yield "README", f"it is {rules[0][2]} % and {rules[1][2]} % of the points;"
    yield "README", f"good as the best oil at {first['4050'][2]} % and {second['4050'][2]} %."


def of_demo() -> Iterator[tuple[str, str]]:
    """Page and text: what is said of the printed law."""
    numbers = demo("claim_numbers").query("claim == 'viscosity-order' and basis == 'printed'")
    above = numbers[numbers["number"] == "above_next"].set_index("oil")["value"]
    yield "findings", f"order at {above['4102']:.0%} and {above['4050']:.0%} of".replace("%", " %")
    fits = demo("coefficients").query("law == @PAPER_LAW")
    ratio = span(fits["standard_error"] / fits["naive_standard_error"], factor=1)
    assert ratio == "2 to 7", ratio  # in words on both pages
    quality = demo("fit_quality")
    wang = quality[quality["law"].str.startswith("wang")]
    assert len(wang) == 9
    assert not wang["certified"].any()
    on_load = wang["law"] != "wang-deng-groups"
    zero = wang["zero_slip_traction"].abs()
    yield "findings", f"Its mu(0) of up to {zero[on_load].max():.4f} is the error of the fit"
    yield "findings", f"another law (mu(0) up to {zero[~on_load].max():.4f})"
    slips = demo("cage_slip").query("0.15 <= cage_slip <= 0.8")
    ratio = span(slips["inner_slide_roll_ratio"] / slips["cage_slip"], 2, 1)
    yield "findings", f"S at the inner race is {ratio} times the cage slip"


def of_thermal() -> Iterator[tuple[str, str]]:
    """Page and text: what is said of laws where none is true."""
    quality, truth = thermal("fit_quality"), thermal("extrapolation")
    own, at = quality[quality["law"] == PAPER_LAW], truth[truth["law"] == PAPER_LAW]
    assert own["certified"].all()
    beyond = at[at["beyond"] != ""].groupby("oil")
    errors = pd.Series({oil: relative_rms(rows) for oil, rows in beyond})
    yield "findings", f"fits each oil to {span(own['relative_rms'])} % rms"
    yield "findings", f"it is wrong by {span(errors)} % rms"
    figure = at[at["figure"] == "fig07"]
    off = figure["traction_coefficient"] / figure["true_traction_coefficient"] - 1
    mean = 100 * off.groupby(figure["slide_roll_ratio"].round(2)).mean()
    low = f"{-mean[0.04]:.0f} % too low at S = 0.04 and {mean[0.3]:.0f} % too high at S = 0.3"
    yield "findings", f"it is {low}"
    shares = {}
    for name in ("mean_ci", "obs_ci"):
        true = at["true_traction_coefficient"]
        shares[name] = true.between(at[f"{name}_lower"], at[f"{name}_upper"]).mean()
    yield "findings", f"contains the truth at {100 * shares['mean_ci']:.0f} % of the conditions"
    yield "findings", f"next run contains it at {100 * shares['obs_ci']:.0f} %"
    laws = errors_by_law(truth).set_index("law")[["inside_relative_rms", "beyond_relative_rms"]]
    nearest, worst = laws.loc["eyring"], laws.loc["wang-deng-critical-load"]
    others = laws.drop(["eyring", "wang-deng-critical-load"])
    near = f"{100 * nearest.iloc[0]:.0f} % within the box, {100 * nearest.iloc[1]:.0f} % beyond"
    yield "findings", f"The Eyring law is nearest: {near}"
    ends = span(laws.drop("eyring").iloc[:, 0]), span(others.iloc[:, 1])
    yield "findings", f"have {ends[0]} %, and {ends[1]} % beyond"
    yield "findings", f"critical load has {100 * worst.iloc[1]:.0f} %"
    wang = quality[quality["law"].str.startswith("wang")]
    zero, critical = wang["zero_slip_traction"].abs(), wang["law"] == "wang-deng-critical-load"
    yield "findings", f"up to {zero[~critical].max():.3f}, or {zero[critical].max():.3f} with a"
    growth = quality.assign(growth=quality["left_out_rmse"] / quality["rmse"])
    of_own = growth[growth["law"] == PAPER_LAW].set_index("oil")["growth"]
    more = wang["oil"].map(of_own).rdiv(growth.loc[wang.index, "growth"]).max() - 1
    assert more < 0.01, more  # "within 1 %"


def of_torque() -> Iterator[tuple[str, str]]:
    """Page and text: what is said of the simulated torque."""
    for campaign in ("demo", "thermal"):
        rows = without_bistable(table(campaign, "torque"))
        truth = pd.read_parquet(ROOT / f"results/{campaign}/twin/torque_truth.parquet")
        keys = ["run_id", "speed"]  # levels of speed are thousands of rpm apart
        truth, rows = (
            each.assign(speed=each["inner_speed_rpm"].round(-3)) for each in (truth, rows)
        )
        rows = rows.merge(truth, on=keys, suffixes=("", "_true"), validate="many_to_one")
        error = 100 * rows["relative_error"].abs()
        traction = rows["traction_torque_n_m"] / rows["traction_torque_n_m_true"] - 1
        cells, parts = [], []
        for variable in ("stress", "load"):
            here = rows["load_variable"] == variable
            of_law, part = error[here], 100 * traction[here].abs()
            cells.append(f"{of_law.median():.2g} % and {of_law.max():.2g} %")
            parts.append(f"{part.median():.0f} % and {part.max():.0f} %")
        of_law = error[rows["load_variable"] == "stress"]
        if campaign == "thermal":
            yield "bearing", f"| of the torque | {' | '.join(cells)} |"
            yield "bearing", f"| of the part by traction | {' | '.join(parts)} |"
            within = 100 * (of_law <= 3.79).mean()
            yield "bearing", f"By pressure {within:.0f} % of the points are within"
        else:
            yield "bearing", f"within {of_law.median():.1g} % of the measured one in the median and"
            yield "bearing", f"median and {of_law.max():.1f} % at worst"
            noise_free = (rows["torque_n_m"] / rows["torque_n_m_true"] - 1).abs()
            own = noise_free[rows["load_variable"] == "stress"]
            medians = span(own.groupby(rows["oil"]).median(), 2)
            off = f"{medians} % in the median and by {100 * own.max():.1f} % at worst"
            yield "bearing", f"is off by {off}"
    counts = [table(campaign, "slip_advice")["judgement"].value_counts() for campaign in CAMPAIGNS]
    for judgement, words in (
        ("heats more", "another oil heats less"),
        ("slips more", "no oil holds the cage, and another slips less"),
        ("rule has none", "no oil that the rule prefers has enough film"),
    ):
        cells = [str(count.get(judgement, 0)) for count in counts]
        yield "bearing", f"| {words} | {' | '.join(cells)} |"


def main() -> int:
    pages = {
        "bearing": ROOT / "docs/explanation/bearing.md",
        "README": ROOT / "README.md",
        "findings": ROOT / "docs/explanation/findings.md",
    }
    texts = {name: " ".join(path.read_text("utf-8").split()) for name, path in pages.items()}
    wrong = [
        f"{pages[page].relative_to(ROOT)} must say: {text}"
        for part in (of_both, of_demo, of_thermal, of_torque)
        for page, text in part()
        if text not in texts[page]
    ]
    print(*wrong or ["The pages have the numbers of these runs."], sep="\n")
    return len(wrong) > 0


if __name__ == "__main__":
    sys.exit(main())
