"""Sections of the report about the paper: its claims, printed constants, rules, and the truth.

Decides: what the report of a campaign tells about the paper.
"""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.home import reference_file
from oilfilm.paper.advice import NO_CHOICE
from oilfilm.paper.extrapolation import errors_by_law
from oilfilm.paper.reference import Claim, Claims, read_claims
from oilfilm.report.document import Entry, Section, facts
from oilfilm.report.shown_table import Column, number, percent, show
from oilfilm.report.words import law_name
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.best_oil import OPERATING_POINT
from oilfilm.traction import PAPER_LAW

# What the verdict on a claim is based on.
BASES = {"refit": "this campaign", "printed": "printed constants"}
# Where the oil that the paper advises is not the best one, by column `judgement` of `slip_advice`.
OTHER_CHOICES = {
    "slips": "The advised oil exceeds the limit of cage slip, and another oil does not,",
    "heats more": "The advised oil gives more friction heat than the best oil",
    "slips more": "The advised oil gives more cage slip than the best oil",
    "rule has none": "None of the oils of the rule has enough film",
}
_SIGN_VERDICTS = ("settled", "probable", "open", "against", "without effect")
_CLAIM_VERDICTS = ("holds", "by construction", "holds in part", "fails", "cannot be checked")
_JUDGED_ON = {
    "tested": "the box tested by the paper",
    "extrapolated": "the box of figs 7 to 10",
    "data": "the campaign's data",
    "formula": "the paper's Eq. 1",
}
_LEVELS = {
    "worst_max_hertz_pressure_gpa": "{:.3g} GPa",
    "worst_entrainment_speed_m_s": "{:.3g} m/s",
    "worst_inlet_temperature_c": "{:.3g} \N{DEGREE SIGN}C",
    "worst_slide_roll_ratio": "S {:.3g}",
}
_WORDS = {
    "CIRCULAR": "the data were made with the law that they are to test",
    "holds in part": "true at some of the conditions only",
    "by construction": "true for any constants, because the law's equation makes it so",
    "cannot be checked": "the campaign lacks what the claim is about",
}


def sections(results: CampaignTables, settings: Settings) -> list[Section]:
    """The paper's sections of a campaign's report.

    Args:
        results: The finished tables.
        settings: All settings of the campaign.
    """
    return [
        _claims(results, settings),
        _printed(results, settings.campaign),
        _choice(results),
        _truth(results.extrapolation),
    ]


def _claims(results: CampaignTables, settings: Settings) -> Section:
    """How many of the paper's claims hold, by basis, and each claim with its numbers."""
    claims, numbers = results.claims, results.claim_numbers
    if claims.empty:
        return Section("claims", "Claims of the paper")
    of_paper = read_claims(reference_file("claims"))
    stated = {claim.id: claim.claim for claim in of_paper.claims}
    verdicts = claims.assign(basis=claims["basis"].map(BASES), claim=claims["claim"].map(stated))
    verdicts = verdicts.pivot(index="claim", columns="basis", values="verdict").reindex(
        index=[stated[each] for each in claims["claim"].unique()],
        columns=[BASES[each] for each in claims["basis"].unique()],
    )
    counts = verdicts.apply(pd.Series.value_counts).reindex(_CLAIM_VERDICTS).T.fillna(0)
    failing = verdicts[(verdicts == "fails").any(axis=1)].fillna("not judged")
    refit = claims[claims["basis"] == "refit"]
    own = numbers[numbers["basis"] == "refit"]
    made = facts(
        "paper/claims.jinja",
        refit=refit["verdict"].value_counts().reindex(_CLAIM_VERDICTS).dropna().astype(int),
        reasons=[
            of_paper.cannot_be_checked[code] for code in refit["reason_code"].unique() if code
        ],
        campaign=settings.campaign,
        left_out=[oil for oil in settings.oils if oil not in set(own["oil"])],
    )
    shown = [
        show(
            counts.astype(int).rename_axis("basis").reset_index(),
            "claims",
            "Verdicts on the claims",
            [Column("basis", "Constants"), *(Column(each, each) for each in _CLAIM_VERDICTS)],
            name="claim-counts",
            in_text=True,
        ),
        show(
            failing.reset_index(),
            "claims",
            "Claims that fail",
            [
                Column("claim", "Claim", meaning=""),
                *(Column(basis, basis, is_verdict=True) for basis in failing.columns),
            ],
            name="failing-claims",
            in_text=True,
        ),
    ]
    entries = [
        _entry(claim, claims[claims["claim"] == claim.id], of_paper, numbers, settings)
        for claim in of_paper.claims
        if claim.id in set(claims["claim"])
    ]
    downloads = {"claims.csv": claims, "claim_numbers.csv": numbers}
    return Section("claims", "Claims of the paper", made, shown, entries, downloads, _WORDS)


def _entry(
    claim: Claim, rows: pd.DataFrame, of_paper: Claims, numbers: pd.DataFrame, settings: Settings
) -> Entry:
    """A claim with its verdicts, what was found on each basis, and the paper's words."""
    judged, paragraphs = tables.rows(rows), []
    for row in judged:
        if reason := row["reason_code"]:
            sentences = [f"cannot be checked: {of_paper.cannot_be_checked[reason]}."]
        else:
            own = (numbers["claim"] == claim.id) & (numbers["basis"] == row["basis"])
            sentences = _finding(row, claim, numbers[own], settings)
        on = f"{BASES[row['basis']]}, {_JUDGED_ON[row['judged_on']]}"
        paragraphs.append(f"{on}: {' '.join(sentences)}")
    paragraphs.append(
        f"Holds where {_filled(claim.holds_where, settings)}. Section {claim.section}: "
        f"\N{LEFT DOUBLE QUOTATION MARK}{claim.wording.strip()}\N{RIGHT DOUBLE QUOTATION MARK}"
    )
    verdicts = [(BASES[row["basis"]], row["verdict"]) for row in judged]
    return Entry(claim.claim, verdicts, paragraphs)


def _finding(
    row: Mapping[str, Any], claim: Claim, numbers: pd.DataFrame, settings: Settings
) -> list[str]:
    """Share, worst case and further numbers of a claim on one basis, in sentences."""
    sentences = [f"Holds strictly in {share_text(row['share'])} of {row['cases']} cases."]
    if row["verdict"] == "by construction":
        sentences.append("The equation makes it so for any constants that it allows.")
    head = "Worst case" if row["share"] < 1 else "Case nearest to failing"
    sentences.append(f"{head}: {worst_case(row, claim)}.")
    listed = []
    readings = {name: f'read as "{text}"' for name, text in claim.readings.items()}
    labels = {"share": "cases in which it holds", **readings, **claim.numbers}
    for name, label in labels.items():
        meaning, _, form = label.partition(": {:")
        values = [
            (f"{value:{form.rstrip('}')}}" if form else share_text(value))
            + (f" ({oil})" if oil else "")
            for value, oil in numbers.loc[numbers["number"] == name, ["value", "oil"]].to_numpy()
        ]
        if values:
            listed.append(f"{_filled(meaning, settings)}: {', '.join(values)}")
        elif name in readings:
            listed.append(f"not judged on these constants: {_filled(label, settings)}")
    return [*sentences, f"Further numbers: {'; '.join(listed)}."] if listed else sentences


def worst_case(row: Mapping[str, Any], claim: Claim) -> str:
    """What was found in the worst case of a claim, and where that is."""
    known = [row["worst_oil"]] if row["worst_oil"] else []
    known += [form.format(row[name]) for name, form in _LEVELS.items() if not pd.isna(row[name])]
    condition = f" at {', '.join(known)}" if known else ""
    return f"{claim.quantity.format(row['worst_value'])}{condition}"


def share_text(share: float) -> str:
    """A share in percent, 100 or 0 only where it is all or none."""
    near = not 0.01 <= share <= 0.99 and share not in (0.0, 1.0)
    return f"{min(max(share, 0.001), 0.999):.1%}" if near else f"{share:.0%}"


def _filled(text: str, settings: Settings) -> str:
    """A text of a claim with settings in place of its braces."""
    keys = {name: getattr(settings, name) for name in ("audit", "printed", "selection")}
    return text.format(**keys)


def _printed(results: CampaignTables, campaign: Campaign) -> Section:
    """The constants printed in the paper: distance from the fit, and how sure their signs are."""
    if results.signs.empty:
        return Section("printed", "Printed constants")
    fits = results.configured.coefficients
    fits = fits[fits["law"] == PAPER_LAW.name]
    fitted = fits[["oil", "constant", "value", "verdict"]].dropna(subset="value")
    judged = fitted.merge(results.sign_verdicts[["oil", "constant", "sign"]])
    same = (judged["value"] < 0) == (judged["sign"] == "-")
    known, names = judged["verdict"] == "known", judged["oil"] + " " + judged["constant"]
    made = facts(
        "paper/printed.jinja",
        confirmed=(known & same).sum(),
        judged=len(judged),
        turned=names[known & ~same].tolist(),
        unknown=names[~known].tolist(),
        campaign=campaign,
    )
    apart = results.printed_judged.dropna(subset=["tested_difference"])
    sizes = ["tested_difference", "extrapolated_difference"]
    apart[sizes] = apart[sizes].abs()
    sum_of_squares, difference = number(".3e"), number(".1e")
    used = results.signs[results.signs["in_use"]].drop_duplicates("oil")
    named = (
        results.sign_verdicts.groupby(["oil", "verdict"])["constant"]
        .agg(" ".join)
        .unstack("verdict", fill_value="-")
        .reindex(columns=_SIGN_VERDICTS, fill_value="-")
    )
    shown = [
        show(
            apart,
            "printed_judged",
            "Printed constants beside the fitted ones: sum of squared errors (SSE), and the "
            "largest difference of mu at tested conditions and beyond them",
            [
                Column("oil", "Oil"),
                Column("printed_sse", "SSE, printed", sum_of_squares),
                Column("fitted_sse", "SSE, fitted", sum_of_squares),
                Column("tested_difference", "Largest difference, tested", difference),
                Column("extrapolated_difference", "beyond them", difference),
            ],
            in_text=True,
        ),
        show(
            used.join(named, on="oil", how="inner"),
            "signs",
            "Signs of the printed exponents, and how sure each of them is",
            [
                Column("oil", "Oil"),
                Column("rank", "Rank of the set in use"),
                Column("rank_at_figures", "at slips of Figs 8 and 9"),
                *(Column(verdict, verdict) for verdict in _SIGN_VERDICTS),
            ],
            in_text=True,
        ),
    ]
    return Section("printed", "Printed constants", made, shown)


def _choice(results: CampaignTables) -> Section:
    """The paper's choice of oil by cage slip beside the best oil, over operating points."""
    advice = results.slip_advice
    judged = advice[~advice["judgement"].isin(NO_CHOICE)]
    if judged.empty:
        return Section("choice", "Choice of oil")
    others = judged[judged["judgement"] != "agree"]
    counts, band = others["judgement"].value_counts(), results.advice_band
    share = band["agreeing_points"] / band["operating_points"]
    advised = [oil for oils in judged["good_oils"] for oil in oils.split("; ") if oil]
    of_points = results.cage_slip.groupby(OPERATING_POINT)["best_share"].max()
    made = facts(
        "paper/choice.jinja",
        total=len(judged),
        agreeing=len(judged) - len(others),
        others={OTHER_CHOICES[str(judgement)]: count for judgement, count in counts.items()},
        best=others["best_oil"].value_counts().to_dict(),
        band=share.groupby(band["choice"], sort=False).agg(["min", "max"]),
        varied=band[["limit_factor", "inlet_temperature_c"]].agg(["min", "max"]),
        always={oil: advised.count(oil) for oil in dict.fromkeys(advised)},
        certain=(of_points >= 0.95).sum(),
        drawn=of_points.count(),
    )
    return Section("choice", "Choice of oil", made)


def _truth(extrapolation: pd.DataFrame) -> Section:
    """How wrong each law is where the truth was simulated."""
    errors = errors_by_law(extrapolation)
    if errors.empty:
        return Section("truth", "Simulated truth")
    where = "{:g} GPa, {:g} m/s, {:g} degC, S {:g}"
    conditions = [where.format(*condition) for condition in errors[list(_LEVELS)].to_numpy()]
    share, whole, short = percent(2), percent(0), number(".4g")
    table = show(
        errors.assign(where=conditions),
        "extrapolation_errors",
        "Errors against the SIMULATED truth at the conditions of Figs 7-10, rms of mu",
        [
            Column("law", "Law", law_name),
            Column("inside_relative_rms", "Error in the tested box", share),
            Column("beyond_relative_rms", "beyond it", share),
            Column(
                "beyond_obs_ci_ratio", "Truth in the interval of the next run, beyond it", whole
            ),
            Column("worst_traction_coefficient", "Worst mu", short),
            Column("worst_true_traction_coefficient", "True mu", short),
            Column("where", "Worst condition"),
        ],
        name="truth-errors",
        in_text=True,
    )
    return Section("truth", "Simulated truth", facts("paper/truth.jinja"), [table])
