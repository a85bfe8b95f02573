"""Sections of the report about the paper: its claims, printed constants, rules, and the truth.

Decides: what the report of a campaign tells about the paper.
"""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.home import reference_file
from oilfilm.paper.audit.reasons import REASONS
from oilfilm.paper.extrapolation import errors_by_law
from oilfilm.paper.reference import Claim, read_claims
from oilfilm.paper.selection import OUTSIDE
from oilfilm.report.document import Entry, Section, facts
from oilfilm.report.shown_table import Column, ShownTable, number, percent, show
from oilfilm.report.words import law_name
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
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
# Levels of the worst case, by the end of their column's name.
LEVEL_FORMS = {
    "max_hertz_pressure_gpa": "{:.3g} GPa",
    "entrainment_speed_m_s": "{:.3g} m/s",
    "inlet_temperature_c": "{:.3g} \N{DEGREE SIGN}C",
    "slide_roll_ratio": "S {:.3g}",
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


def circular(campaign: Campaign) -> str:
    """What verdicts on the claims are worth where the points were simulated; empty elsewhere."""
    if campaign.truth_is_law:
        return (
            "CIRCULAR on the refit: the points were SIMULATED with the printed constants. "
            "The verdicts are about these constants, not about the oils."
        )
    if campaign.data == "simulated":
        return "The points were SIMULATED: verdicts on the refit say nothing of the real oils."
    return ""


def _claims(results: CampaignTables, settings: Settings) -> Section:
    """How many of the paper's claims hold, by basis, and each claim with its numbers."""
    claims = results.claims
    if claims.empty:
        return Section("claims", "Claims of the paper")
    counts = pd.crosstab(claims["basis"], claims["verdict"])
    counts = counts.reindex(columns=_CLAIM_VERDICTS, fill_value=0).loc[claims["basis"].unique()]
    refit = claims[claims["basis"] == "refit"]
    by_oil = results.claim_numbers[results.claim_numbers["basis"] == "refit"]
    made = facts(
        "paper/claims.jinja",
        refit=refit["verdict"].value_counts().reindex(_CLAIM_VERDICTS).dropna().astype(int),
        reasons=[REASONS[code] for code in refit["reason_code"].unique() if code],
        circular=circular(settings.campaign),
        left_out=[oil for oil in settings.oils if oil not in set(by_oil["oil"])],
    )
    shown = ShownTable(
        "claim-counts",
        "Verdicts on the claims",
        [Column("basis", "Constants"), *(Column(each, each) for each in _CLAIM_VERDICTS)],
        [
            [BASES[basis], *map(str, row)]
            for basis, row in zip(counts.index, counts.values, strict=True)
        ],
        in_text=True,
    )
    said = {claim.id: claim for claim in read_claims(reference_file("claims"))}
    entries = [
        _entry(rows, said[str(claim)], results.claim_numbers, settings)
        for claim, rows in claims.groupby("claim", sort=False)
    ]
    shown_tables = [shown, _failing(claims, said)]
    downloads = {"claims.csv": claims, "claim_numbers.csv": results.claim_numbers}
    return Section("claims", "Claims of the paper", made, shown_tables, entries, downloads, _WORDS)


def _entry(rows: pd.DataFrame, claim: Claim, numbers: pd.DataFrame, settings: Settings) -> Entry:
    judged = list(tables.rows(rows))
    of_claim = numbers[numbers["claim"] == claim.id]
    paragraphs = [
        f"{BASES[row['basis']]}, {_JUDGED_ON[row['judged_on']]}: "
        f"{_finding(row, claim, of_claim[of_claim['basis'] == row['basis']], settings)}"
        for row in judged
    ]
    source = (
        f"Holds where {_filled(claim.holds_where, settings)}. Section {claim.section}: "
        f"\N{LEFT DOUBLE QUOTATION MARK}{claim.wording.strip()}\N{RIGHT DOUBLE QUOTATION MARK}"
    )
    verdicts = [(BASES[row["basis"]], row["verdict"]) for row in judged]
    return Entry(claim.claim, verdicts, [*paragraphs, source])


def _finding(
    row: Mapping[str, Any], claim: Claim, numbers: pd.DataFrame, settings: Settings
) -> str:
    """Share, worst case and further numbers of a claim on one basis, in sentences."""
    if row["reason_code"]:
        return f"cannot be checked: {REASONS[row['reason_code']]}."
    sentences = [f"Holds in {share_text(row['share'])} of {row['cases']} cases."]
    if row["verdict"] == "by construction":
        sentences.append("The equation makes it so for any constants that it allows.")
    head = "Worst case" if row["share"] < 1 else "Case nearest to failing"
    sentences.append(f"{head}: {worst_case(row, claim)}.")
    labels = {"share": "cases in which it holds", **claim.numbers}
    listed = [
        _numbers(label, of_name, settings)
        for name, label in labels.items()
        if len(of_name := numbers[numbers["number"] == name])
    ]
    return " ".join([*sentences, f"Further numbers: {'; '.join(listed)}."] if listed else sentences)


def _numbers(label: str, rows: pd.DataFrame, settings: Settings) -> str:
    """A number of a claim, or one per oil: its label and the values in its format."""
    meaning, _, form = label.partition(": {:")
    values = [
        (f"{value:{form.rstrip('}')}}" if form else share_text(value))
        + (f" ({oil})" if oil else "")
        for value, oil in zip(rows["value"], rows["oil"], strict=True)
    ]
    return f"{_filled(meaning, settings)}: {', '.join(values)}"


def worst_case(row: Mapping[str, Any], claim: Claim) -> str:
    """What was found in the worst case of a claim, and where that is."""
    known = [row["worst_oil"]] if row["worst_oil"] else []
    known += [
        form.format(row[f"worst_{name}"])
        for name, form in LEVEL_FORMS.items()
        if not pd.isna(row[f"worst_{name}"])
    ]
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


def _failing(claims: pd.DataFrame, said: Mapping[str, Claim]) -> ShownTable:
    """Claims that fail for some constants, with the verdict for each; the page has all claims."""
    verdicts = claims.pivot(index="claim", columns="basis", values="verdict")
    verdicts = verdicts.loc[claims["claim"].unique(), list(claims["basis"].unique())]
    verdicts.index = pd.Index([said[str(claim)].claim for claim in verdicts.index], name="claim")
    failing = verdicts[(verdicts == "fails").any(axis=1)].fillna("not judged")
    columns = [Column(basis, BASES[basis], is_verdict=True) for basis in failing.columns]
    rows = failing.reset_index().to_numpy().tolist()
    caption = "Claims that fail"
    return ShownTable(
        "failing-claims", caption, [Column("claim", "Claim"), *columns], rows, in_text=True
    )


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
    return Section("printed", "Printed constants", made, [_apart(results), _signs(results)])


def _apart(results: CampaignTables) -> ShownTable:
    known = results.printed_judged.dropna(subset=["tested_difference"])
    sum_of_squares, difference = number(".3e"), number(".1e")
    return show(
        known.assign(
            **{name: known[name].abs() for name in ("tested_difference", "extrapolated_difference")}
        ),
        "printed_judged",
        "Printed constants beside the fitted ones: sum of squared errors (SSE), and the largest "
        "difference of mu at tested conditions and beyond them",
        [
            Column("oil", "Oil"),
            Column("printed_sse", "SSE, printed", sum_of_squares),
            Column("fitted_sse", "SSE, fitted", sum_of_squares),
            Column("tested_difference", "Largest difference, tested", difference),
            Column("extrapolated_difference", "beyond them", difference),
        ],
        in_text=True,
    )


def _signs(results: CampaignTables) -> ShownTable:
    """Rank of the signs in use, and how sure each of them is, one row per oil."""
    used = results.signs[results.signs["in_use"]].drop_duplicates("oil")
    named = (
        results.sign_verdicts.groupby(["oil", "verdict"])["constant"]
        .agg(" ".join)
        .unstack("verdict", fill_value="-")
        .reindex(columns=_SIGN_VERDICTS, fill_value="-")
    )
    return show(
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
    )


def _choice(results: CampaignTables) -> Section:
    """The paper's choice of oil by cage slip beside the best oil, over operating points."""
    advice, band = results.slip_advice, results.advice_band
    judged = advice[~advice["judgement"].isin(["no film", OUTSIDE])]
    if judged.empty:
        return Section("choice", "Choice of oil")
    others = judged[judged["judgement"] != "agree"]
    made = facts(
        "paper/choice.jinja",
        total=len(judged),
        agreeing=len(judged) - len(others),
        others={
            OTHER_CHOICES[str(judgement)]: count
            for judgement, count in others["judgement"].value_counts().items()
        },
        best=others["best_oil"].value_counts().to_dict(),
        band=band,
        certain=(judged["best_oil_share"] == 1).sum(),
    )
    return Section("choice", "Choice of oil", made)


def _truth(extrapolation: pd.DataFrame) -> Section:
    """How wrong each law is where the truth was simulated."""
    rows = errors_by_law(extrapolation)
    if not rows:
        return Section("truth", "Simulated truth")
    share, whole, short = percent(2), percent(0), number(".4g")
    columns = [
        Column("law", "Law"),
        Column("inside", "Error in the tested box"),
        Column("beyond", "beyond it"),
        Column("in_interval", "Truth in the interval of the next run, beyond it"),
        Column("mu", "Worst mu"),
        Column("true_mu", "True mu"),
        Column("where", "Worst condition"),
    ]
    shown = [
        [
            law_name(row["law"]),
            share(row["inside_relative_rms"]),
            share(row["beyond_relative_rms"]),
            whole(row["beyond_obs_ci_ratio"]),
            short(row["worst_traction_coefficient"]),
            short(row["worst_true_traction_coefficient"]),
            _condition(row),
        ]
        for row in rows
    ]
    caption = "Errors against the SIMULATED truth at the conditions of Figs 7-10, rms of mu"
    table = ShownTable("truth-errors", caption, columns, shown, in_text=True)
    return Section("truth", "Simulated truth", facts("paper/truth.jinja"), [table])


def _condition(row: dict[str, Any]) -> str:
    return (
        f"{row['worst_max_hertz_pressure_gpa']:g} GPa, {row['worst_entrainment_speed_m_s']:g} m/s, "
        f"{row['worst_inlet_temperature_c']:g} degC, S {row['worst_slide_roll_ratio']:g}"
    )
