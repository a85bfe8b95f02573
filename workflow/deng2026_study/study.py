"""What a campaign with `studies: [deng2026_study]` has beside tables and figures.

Decides: what the report of a campaign tells about the paper.
"""

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from deng2026_study.advice import NO_CHOICE, NO_EQUILIBRIUM, OUTSIDE
from deng2026_study.printed_law import PrintedLaw, printed, printed_law
from deng2026_study.reference import Claim, Claims, read_claims, read_reference
from deng2026_study.settings import NAME, default_settings, study_settings
from oilfilm import tables
from oilfilm.base.home import CONFIG, reference_file
from oilfilm.base.studies import Study, publication
from oilfilm.exports.campaign import in_folders
from oilfilm.exports.description import (
    Condition,
    Description,
    Published,
    constant_meanings,
    identifiers,
)
from oilfilm.report.document import Entry, Section, facts, show_table
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.config import Box, ExportSettings
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import read_config
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.best_oil import stays_best
from oilfilm.traction import PAPER_LAW
from oilfilm.traction.law import QUANTITIES
from simulated_lab.printed import PrintedCoefficients

# Where the printed constants are from.
_SOURCE = f"{publication(NAME)}, Eqs 11-13"


def describe_printed(path: Path, tested: Box, settings: ExportSettings) -> list[Description]:
    """Describe the printed constants of each oil of the paper.

    Args:
        path: data/reference/printed_coefficients.yaml.
        tested: What the paper's abstract says was tested (`printed.boxes.tested`).
        settings: Operating points of the ADORE form.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    printed = load(path, PrintedCoefficients)
    names = identifiers([f"{oil} printed" for oil in printed.falling_viscosity])
    points = tuple(point.model_dump() for point in settings.adore_points)
    described = []
    for oil, name in zip(printed.falling_viscosity, names.values(), strict=True):
        fitted = printed_law(printed, oil, tested)
        described.append(
            Description(
                oil=oil,
                identifier=name,
                campaign=None,
                fitted=fitted,
                conditions=tuple(_conditions(fitted)),
                constants=tuple(_constants(fitted)),
                quality=None,
                adore_points=points,
                published=Published(_SOURCE, tuple(_what_is_not_known(fitted))),
            )
        )
    return described


def _what_is_not_known(fitted: PrintedLaw) -> Iterator[str]:
    """Sentences for a user of the printed constants."""
    constants_by_sign: dict[str, list[str]] = {}
    for constant, how_sure in fitted.signs.items():
        constants_by_sign.setdefault(f"sign {how_sure}", []).append(constant)
    signs = "; ".join(f"{sign}: {', '.join(names)}" for sign, names in constants_by_sign.items())
    yield (
        "They are as printed, not refitted: without errors and intervals. The tested box is that "
        "of the paper's abstract."
    )
    yield "The signs of the exponents were lost in the available text and are restored."
    yield f"How sure they are: {signs}"


def _conditions(fitted: PrintedLaw) -> Iterator[Condition]:
    law, box = fitted.law, fitted.coefficients.box.tolist()
    for name, reference, (low, high) in zip(law.conditions, law.reference, box, strict=False):
        about = QUANTITIES[name].symbol, QUANTITIES[name].meaning, QUANTITIES[name].unit
        yield Condition(name, *about, "argument", None, reference, (low, high))


def _constants(fitted: PrintedLaw) -> Iterator[dict[str, Any]]:
    """What the description has of each constant: a value, but no uncertainty."""
    meanings, signs = constant_meanings(fitted.law), fitted.signs
    unknown = {"standard_error": None, "interval": [None, None], "systematic_standard_error": None}
    values = fitted.coefficients.constants.tolist()
    for constant, value in zip(fitted.law.constants, values, strict=True):
        name = constant.name
        sure = f"printed, sign {signs[name]}" if name in signs else "printed"
        about = {"name": name, "meaning": meanings[name], "value": value, "unit": "1"}
        yield {**about, **unknown, "verdict": sure}


# What the verdict on a claim is based on.
BASES = {"refit": "this campaign", "printed": "printed constants"}
# Where the oil that the paper advises is not the best one, by column `judgement` of `slip_advice`.
OTHER_CHOICES = {
    "slips": "The advised oil exceeds the limit of cage slip, and another oil does not,",
    "heats more": "The advised oil gives more friction heat than the best oil",
    "slips more": "The advised oil gives more cage slip than the best oil",
    "rule has none": "None of the oils of the rule has enough film",
}
# Operating points without a choice of oil, by column `judgement` of `slip_advice`.
UNDECIDED = {
    "no film": "no oil has enough film",
    OUTSIDE: "the choice depends on a film beyond the film formula",
    NO_EQUILIBRIUM: "an oil has no equilibrium",
}
# Share of the draws in which an oil that stays best is the best one.
_STAYS_BEST = 0.95
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
        _truth(results.extrapolation_errors),
    ]


def _claims(results: CampaignTables, settings: Settings) -> Section:
    """How many of the paper's claims hold, by basis, and each claim with its numbers."""
    claims, numbers = results.claims, results.claim_numbers
    if claims.empty:
        return Section("claims", "Claims of the paper")
    of_paper = read_claims(reference_file("claims"))
    stated = {claim.id: claim.claim for claim in of_paper.claims}
    named = claims.assign(basis=claims["basis"].map(BASES), claim=claims["claim"].map(stated))
    verdicts = named.pivot(index="claim", columns="basis", values="verdict")
    verdicts = verdicts.reindex(index=named["claim"].unique(), columns=named["basis"].unique())
    counts = verdicts.apply(pd.Series.value_counts).reindex(_CLAIM_VERDICTS).T.fillna(0)
    failing = verdicts[(verdicts == "fails").any(axis=1)].fillna("not judged")
    refit = claims[claims["basis"] == "refit"]
    judged = set(numbers.loc[numbers["basis"] == "refit", "oil"])
    made = facts(
        "deng2026_study/claims.jinja",
        refit=refit["verdict"].value_counts().reindex(_CLAIM_VERDICTS).dropna().astype(int),
        reasons=[
            of_paper.cannot_be_checked[code] for code in refit["reason_code"].unique() if code
        ],
        campaign=settings.campaign,
        left_out=[oil for oil in settings.oils if oil not in judged],
    )
    shown = [
        show_table(counts.astype(int).reset_index(), "claim-counts"),
        show_table(failing.reset_index(), "failing-claims"),
    ]
    entries = [
        _entry(claim, rows, of_paper, numbers[numbers["claim"] == claim.id], settings)
        for claim in of_paper.claims
        if len(rows := claims[claims["claim"] == claim.id])
    ]
    return Section("claims", "Claims of the paper", made, shown, entries, _WORDS)


def _entry(
    claim: Claim, rows: pd.DataFrame, of_paper: Claims, numbers: pd.DataFrame, settings: Settings
) -> Entry:
    """A claim with its verdicts, what was found on each basis, and the paper's words."""
    verdicts, paragraphs = [], []
    for row in tables.rows(rows):
        basis, own = BASES[row["basis"]], numbers[numbers["basis"] == row["basis"]]
        finding = f"cannot be checked: {of_paper.cannot_be_checked.get(row['reason_code'])}."
        if not row["reason_code"]:
            finding = _finding(row, claim, own, settings)
        verdicts.append((basis, row["verdict"]))
        paragraphs.append(f"{basis}, {_JUDGED_ON[row['judged_on']]}: {finding}")
    paragraphs.append(
        f"Holds where {_filled(claim.holds_where, settings)}. Section {claim.section}: "
        f"\N{LEFT DOUBLE QUOTATION MARK}{claim.wording.strip()}\N{RIGHT DOUBLE QUOTATION MARK}"
    )
    return Entry(claim.claim, verdicts, paragraphs)


def _finding(
    row: Mapping[str, Any], claim: Claim, numbers: pd.DataFrame, settings: Settings
) -> str:
    """Share, worst case and further numbers of a claim on one basis, in sentences."""
    share = row["share"]
    found = f"Holds strictly in {_share(share)} of {row['cases']} cases."
    if row["verdict"] == "by construction":
        found += " The equation makes it so for any constants that it allows."
    known = [row["worst_oil"]] if row["worst_oil"] else []
    known += [form.format(row[name]) for name, form in _LEVELS.items() if not pd.isna(row[name])]
    found += f" {'Worst case' if share < 1 else 'Case nearest to failing'}: "
    found += claim.quantity.format(row["worst_value"])
    found += f" at {', '.join(known)}." if known else "."
    readings = {name: f'read as "{text}"' for name, text in claim.readings.items()}
    labels = {"share": "cases in which it holds", **readings, **claim.numbers}
    listed = []
    for name, label in labels.items():
        meaning, _, form = label.partition(": {:")
        values = [
            (f"{value:{form.rstrip('}')}}" if form else _share(value))
            + (f" ({oil})" if oil else "")
            for value, oil in numbers.loc[numbers["number"] == name, ["value", "oil"]].to_numpy()
        ]
        if values:
            listed.append(f"{_filled(meaning, settings)}: {', '.join(values)}")
        elif name in readings:
            listed.append(f"not judged on these constants: {_filled(label, settings)}")
    return f"{found} Further numbers: {'; '.join(listed)}." if listed else found


def _share(share: float) -> str:
    """A share in percent, 100 or 0 only where it is all or none."""
    near = not 0.01 <= share <= 0.99 and share not in (0.0, 1.0)
    return f"{min(max(share, 0.001), 0.999):.1%}" if near else f"{share:.0%}"


def _filled(text: str, settings: Settings) -> str:
    """A text of a claim with settings in place of its braces."""
    return text.format(**dict(study_settings(settings)))


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
        "deng2026_study/printed.jinja",
        confirmed=(known & same).sum(),
        judged=len(judged),
        turned=names[known & ~same].tolist(),
        unknown=names[~known].tolist(),
        campaign=campaign,
    )
    apart = results.printed_judged.dropna(subset=["tested_difference"])
    sizes = ["tested_difference", "extrapolated_difference"]
    apart[sizes] = apart[sizes].abs()
    signs = results.sign_verdicts.groupby(["oil", "verdict"])["constant"].agg(" ".join)
    named = signs.unstack(fill_value="-").reindex(columns=_SIGN_VERDICTS, fill_value="-")
    used = results.signs[results.signs["in_use"]].drop_duplicates("oil")
    used = used.join(named, on="oil", how="inner")
    shown = [show_table(apart, "printed_judged"), show_table(used, "signs")]
    return Section("printed", "Printed constants", made, shown)


def _choice(results: CampaignTables) -> Section:
    """The paper's choice of oil by cage slip beside the best oil, over operating points."""
    advice = results.slip_advice
    judged = advice[~advice["judgement"].isin(NO_CHOICE)]
    if judged.empty:
        return Section("choice", "Choice of oil")
    undecided = advice.loc[advice["judgement"].isin(NO_CHOICE), "judgement"].value_counts()
    others = judged[judged["judgement"] != "agree"]
    counts, band = others["judgement"].value_counts(), results.advice_band
    share = band["agreeing_points"] / band["operating_points"]
    advised = judged["good_oils"].explode().tolist()
    drawn = stays_best(results.cage_slip, _STAYS_BEST)
    made = facts(
        "deng2026_study/choice.jinja",
        total=len(judged),
        undecided={UNDECIDED[str(code)]: count for code, count in undecided.items()},
        agreeing=len(judged) - len(others),
        others={OTHER_CHOICES[str(judgement)]: count for judgement, count in counts.items()},
        best=others["best_oil"].value_counts().to_dict(),
        band=share.groupby(band["choice"], sort=False).agg(["min", "max"]),
        varied=band[["limit_factor", "inlet_temperature_c"]].agg(["min", "max"]),
        always={oil: advised.count(oil) for oil in dict.fromkeys(advised)},
        share=_STAYS_BEST,
        drawn=drawn if drawn["draws_answered"].any() else None,
    )
    return Section("choice", "Choice of oil", made)


def _truth(errors: pd.DataFrame) -> Section:
    """How wrong each law is where the truth was simulated."""
    if errors.empty:
        return Section("truth", "Simulated truth")
    where = "{:g} GPa, {:g} m/s, {:g} degC, S {:g}"
    conditions = [where.format(*condition) for condition in errors[list(_LEVELS)].to_numpy()]
    table = show_table(errors.assign(where=conditions), "truth-errors")
    return Section("truth", "Simulated truth", facts("deng2026_study/truth.jinja"), [table])


# Beside the folders of fits; no identifier has a hyphen.
_FOLDER = "printed-constants"


def _exports(
    oils: Collection[str], settings: Settings, provenance: Mapping[str, Any]
) -> dict[str, bytes]:
    """The printed constants of these oils, in every form."""
    path = reference_file("printed_coefficients")
    tested = study_settings(settings).printed.boxes.tested
    described = describe_printed(path, tested, settings.exports)
    chosen = [each for each in described if each.oil in oils]
    files = in_folders(chosen, provenance) if chosen else {}
    return {f"{_FOLDER}/{file}": content for file, content in files.items()}


def _describe_published() -> tuple[list[Description], Path]:
    """The printed constants of every oil, and their file."""
    path = reference_file("printed_coefficients")
    tested = default_settings().printed.boxes.tested
    return describe_printed(path, tested, read_config(CONFIG).exports), path


STUDY = Study(
    sections=sections,
    exports=_exports,
    exported="The constants that the paper prints of these oils: "
    f"[{_FOLDER}]({_FOLDER}/README.md).",
    read_reference=read_reference,
    published_law=printed,
    describe_published=_describe_published,
)
