"""Report sections and exports that a campaign gets from `studies: [deng2026_study]`.

The tables and figures of the study are made elsewhere.

Decides: what the report of a campaign says about the paper.
"""

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from deng2026_study.advice import (
    JUDGEMENTS_WITHOUT_CHOICE,
    NO_EQUILIBRIUM,
    OUTSIDE_FILM_FORMULA,
    STAYS_BEST_SHARE,
)
from deng2026_study.audit.audit import UNDOUBTED
from deng2026_study.printed_law import PrintedLaw, printed_law
from deng2026_study.reference import Claim, Claims, read_claims, read_reference
from deng2026_study.settings import NAME, default_settings, study_settings
from oilfilm import tables
from oilfilm.base.home import CONFIG, reference_file
from oilfilm.base.studies import Study, publication
from oilfilm.exports.campaign import export_oils
from oilfilm.exports.description import (
    Description,
    LawVariable,
    PublishedSource,
    constant_meanings,
    make_identifiers,
)
from oilfilm.report.document import FoldedEntry, Section, facts_from_template, show_table
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.config import Box, ExportSettings
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import read_config
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.best_oil import certainty_of_best_oil
from oilfilm.traction import PAPER_LAW
from oilfilm.traction.law import QUANTITIES
from simulated_lab.printed import PrintedCoefficients

# Where the printed constants are from.
_SOURCE = f"{publication(NAME)}, Eqs 11-13"


def describe_printed(path: Path, tested_box: Box, settings: ExportSettings) -> list[Description]:
    """Describe the printed constants of each oil of the paper.

    Args:
        path: data/reference/printed_coefficients.yaml.
        tested_box: What the paper's abstract says was tested (`printed.boxes.tested`).
        settings: Operating points of the ADORE form.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    printed_coefficients = load(path, PrintedCoefficients)
    identifier_of_name = make_identifiers(
        [f"{oil} printed" for oil in printed_coefficients.falling_viscosity]
    )
    adore_points = tuple(point.model_dump() for point in settings.adore_points)
    descriptions = []
    for oil in printed_coefficients.falling_viscosity:
        law_with_constants = printed_law(printed_coefficients, oil, tested_box)
        descriptions.append(
            Description(
                oil=oil,
                identifier=identifier_of_name[f"{oil} printed"],
                campaign=None,
                law_with_constants=law_with_constants,
                law_variables=tuple(_law_variables(law_with_constants)),
                constants_as_json=tuple(_constant_descriptions(law_with_constants)),
                quality=None,
                adore_points=adore_points,
                published=PublishedSource(_SOURCE, tuple(_caveats(law_with_constants))),
            )
        )
    return descriptions


def _caveats(law_with_constants: PrintedLaw) -> Iterator[str]:
    """Sentences for a user of the printed constants."""
    names_by_certainty: dict[str, list[str]] = {}
    for name, certainty in law_with_constants.sign_certainty.items():
        names_by_certainty.setdefault(certainty, []).append(name)
    signs_text = "; ".join(
        f"sign {certainty}: {', '.join(names)}" for certainty, names in names_by_certainty.items()
    )
    yield (
        "They are as printed, not refitted: without errors and intervals. The tested box is that "
        "of the paper's abstract."
    )
    yield "The signs of the exponents are lost in our copy of the paper and are restored."
    yield f"How sure they are: {signs_text}"


def _law_variables(law_with_constants: PrintedLaw) -> Iterator[LawVariable]:
    """The variable of each condition of a law, with its tested range."""
    law = law_with_constants.law
    # the last row of the box is that of the slide-roll ratio
    for index, name in enumerate(law.conditions):
        quantity = QUANTITIES[name]
        lowest, highest = law_with_constants.coefficients.tested_box[index].tolist()
        yield LawVariable(
            name=name,
            symbol=quantity.symbol,
            meaning=quantity.meaning,
            unit=quantity.unit,
            role="argument",
            level=None,
            reference=law.reference[index],
            tested=(lowest, highest),
        )


def _constant_descriptions(law_with_constants: PrintedLaw) -> Iterator[dict[str, Any]]:
    """The description of each constant: a value, but no uncertainty."""
    meanings = constant_meanings(law_with_constants.law)
    values = law_with_constants.coefficients.constants.tolist()
    for constant, value in zip(law_with_constants.law.constants, values, strict=True):
        name = constant.name
        verdict = "printed"
        if name in law_with_constants.sign_certainty:
            verdict = f"printed, sign {law_with_constants.sign_certainty[name]}"
        yield {
            "name": name,
            "meaning": meanings[name],
            "value": value,
            "unit": "1",
            "standard_error": None,
            "interval": [None, None],
            "systematic_standard_error": None,
            "verdict": verdict,
        }


# What a verdict on a claim is based on: the words of the report, by column `basis` of `claims`.
BASIS_LABELS = {
    "refit": "this campaign",
    "printed": "printed constants",
    UNDOUBTED: "printed constants without doubtful oils",
}
# Smallest cage slip whose relative error means something.
_SMALLEST_SLIP_FOR_RELATIVE_ERROR = 0.01
# Where the oil that the paper advises is not the best one, by column `judgement` of `slip_advice`.
DISAGREEMENT_TEXTS = {
    "slips": "The advised oil exceeds the limit of cage slip, and another oil does not,",
    "heats more": "The advised oil gives more friction heat than the best oil",
    "slips more": "The advised oil gives more cage slip than the best oil",
    "rule has none": "None of the oils of the rule has enough film",
}
# Operating points without a choice of oil, by column `judgement` of `slip_advice`.
UNDECIDED_TEXTS = {
    "no film": "no oil has enough film",
    OUTSIDE_FILM_FORMULA: "the choice depends on a film beyond the film formula",
    NO_EQUILIBRIUM: "an oil has no equilibrium",
}
# Verdicts on signs, which `sign_verdicts` computes from the statements of the paper. The words of
# `PrintedLaw.sign_certainty` are others: the file of the printed constants declares them.
_SIGN_VERDICTS = ("settled", "probable", "open", "against", "without effect")
_CLAIM_VERDICTS = ("holds", "by construction", "holds in part", "fails", "cannot be checked")
# What a claim is judged on: the words of the report, by the key `judged_on` of a claim.
_JUDGED_ON_LABELS = {
    "tested": "the box tested by the paper",
    "extrapolated": "the box of figs 7 to 10",
    "data": "the campaign's data",
    "formula": "a formula with numbers that the paper states",
}
# Columns of the worst condition, and how their values are shown.
_WORST_CONDITION = {
    "worst_max_hertz_pressure_gpa": "{:.3g} GPa",
    "worst_entrainment_speed_m_s": "{:.3g} m/s",
    "worst_inlet_temperature_c": "{:.3g} \N{DEGREE SIGN}C",
    "worst_slide_roll_ratio": "S {:.3g}",
}
# Words of the section of claims that need an explanation.
_EXPLANATIONS = {
    "CIRCULAR": "the data were made with the law that they are to test",
    "holds in part": "true at some of the conditions only, or in one of several fair readings",
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
        _claims_section(results, settings),
        _printed_section(results, settings.campaign),
        _choice_section(results),
        _truth_section(results.extrapolation_errors),
    ]


def _claims_section(results: CampaignTables, settings: Settings) -> Section:
    """How many of the paper's claims hold, by basis, and each claim with its numbers."""
    claims = results.claims
    claim_numbers = results.claim_numbers
    if claims.empty:
        return Section("claims", "Claims of the paper")
    paper_claims = read_claims(reference_file("claims"))
    text_of_claim = {claim.id: claim.claim for claim in paper_claims.claims}
    labelled_claims = claims.assign(
        basis=claims["basis"].map(BASIS_LABELS), claim=claims["claim"].map(text_of_claim)
    )
    verdict_table = labelled_claims.pivot(index="claim", columns="basis", values="verdict")
    verdict_table = verdict_table.reindex(
        index=labelled_claims["claim"].unique(), columns=labelled_claims["basis"].unique()
    )
    # without doubtful oils only some of the claims are judged
    verdicts_of_all_claims = verdict_table.drop(columns=BASIS_LABELS[UNDOUBTED], errors="ignore")
    verdict_counts = (
        verdicts_of_all_claims.apply(pd.Series.value_counts).reindex(_CLAIM_VERDICTS).T.fillna(0)
    )
    claims_by_refit = claims[claims["basis"] == "refit"]
    judged_oils = set(claim_numbers.loc[claim_numbers["basis"] == "refit", "oil"])
    reason_codes = [code for code in claims_by_refit["reason_code"].unique() if code]
    facts_on_claims = facts_from_template(
        "deng2026_study/claims.jinja",
        refit=claims_by_refit["verdict"]
        .value_counts()
        .reindex(_CLAIM_VERDICTS)
        .dropna()
        .astype(int),
        reasons=[paper_claims.cannot_be_checked[code] for code in reason_codes],
        campaign=settings.campaign,
        left_out=[oil for oil in settings.oils if oil not in judged_oils],
        doubtful=load(reference_file("printed_coefficients"), PrintedCoefficients).doubtful,
        changed=_changed_without_doubtful(verdict_table),
        audit=study_settings(settings).audit,
    )
    shown_tables = [
        show_table(verdict_counts.astype(int).reset_index(), "claim-counts"),
        show_table(verdict_table.fillna("not judged").reset_index(), "claim-verdicts"),
    ]
    entries = []
    for claim in paper_claims.claims:
        rows_of_claim = claims[claims["claim"] == claim.id]
        numbers_of_claim = claim_numbers[claim_numbers["claim"] == claim.id]
        if len(rows_of_claim):
            entries.append(
                _claim_entry(claim, rows_of_claim, paper_claims, numbers_of_claim, settings)
            )
    return Section(
        "claims", "Claims of the paper", facts_on_claims, shown_tables, entries, _EXPLANATIONS
    )


def _changed_without_doubtful(verdict_table: pd.DataFrame) -> list[tuple[str, str, str]]:
    """Each claim with another verdict without doubtful oils: claim, verdict, verdict without them.

    Args:
        verdict_table: Verdicts by claim, one column per basis of `BASIS_LABELS`.
    """
    if BASIS_LABELS[UNDOUBTED] not in verdict_table:
        return []
    compared = verdict_table[[BASIS_LABELS["printed"], BASIS_LABELS[UNDOUBTED]]].dropna()
    changed_rows = compared[compared.iloc[:, 0] != compared.iloc[:, 1]]
    return list(changed_rows.itertuples(name=None))


def _claim_entry(
    claim: Claim,
    claim_rows: pd.DataFrame,
    paper_claims: Claims,
    claim_numbers: pd.DataFrame,
    settings: Settings,
) -> FoldedEntry:
    """A claim: the paper's words, the test, verdict and finding on each basis, a caveat."""
    verdict_of_basis = []
    paragraphs = [
        f"Section {claim.section}: "
        f"\N{LEFT DOUBLE QUOTATION MARK}{claim.wording.strip()}\N{RIGHT DOUBLE QUOTATION MARK}",
        f"Test: {_fill_in_settings(claim.holds_where, settings)}.",
    ]
    for row in tables.rows(claim_rows):
        basis = BASIS_LABELS[row["basis"]]
        if row["reason_code"]:
            reason = paper_claims.cannot_be_checked[row["reason_code"]]
            finding = f"cannot be checked: {reason}."
        else:
            numbers_of_basis = claim_numbers[claim_numbers["basis"] == row["basis"]]
            finding = _finding_text(row, claim, numbers_of_basis, settings)
        verdict_of_basis.append((basis, row["verdict"]))
        paragraphs.append(f"{basis}, {_JUDGED_ON_LABELS[row['judged_on']]}: {finding}")
    if claim.caveat is not None:
        paragraphs.append(f"Caveat: {claim.caveat}")
    return FoldedEntry(claim.claim, verdict_of_basis, paragraphs)


def _finding_text(
    row: Mapping[str, Any], claim: Claim, claim_numbers: pd.DataFrame, settings: Settings
) -> str:
    """Share, worst case and further numbers of a claim on one basis, in sentences."""
    share = row["share"]
    cases = "1 case" if row["cases"] == 1 else f"{row['cases']} cases"
    sentences = [f"Read strictly, it holds in {_percent(share)} of {cases}."]
    if row["verdict"] == "by construction":
        sentences.append("The equation makes it so for any constants that it allows.")
    condition_texts = [row["worst_oil"]] if row["worst_oil"] else []
    for column, number_format in _WORST_CONDITION.items():
        if not pd.isna(row[column]):
            condition_texts.append(number_format.format(row[column]))
    label_of_worst = "Worst case" if share < 1 else "Case nearest to failing"
    condition_text = f" at {', '.join(condition_texts)}" if condition_texts else ""
    sentences.append(
        f"{label_of_worst}: {claim.quantity.format(row['worst_value'])}{condition_text}."
    )
    further_numbers = _further_numbers(claim, claim_numbers, settings)
    if further_numbers:
        sentences.append(f"Further numbers: {'; '.join(further_numbers)}.")
    return " ".join(sentences)


def _further_numbers(claim: Claim, claim_numbers: pd.DataFrame, settings: Settings) -> list[str]:
    """Each further number of a claim with its meaning, and readings that were not judged.

    Args:
        claim: The claim.
        claim_numbers: Rows of the claim and one basis of the table `claim_numbers`.
        settings: All settings of the campaign.
    """
    labels = {
        "share": "cases in which it holds",
        "share_tested": "the same in the box tested by the paper",
    }
    for reading, text in claim.readings.items():
        labels[reading] = f'read as "{text}"'
    labels.update(claim.numbers)
    number_texts = []
    for name, label in labels.items():
        # a label may end in the format of its number, as in "largest error: {:.1%}"
        meaning, _, number_format = label.partition(": {:")
        numbers_of_oils = [
            _number_of_oil(row["value"], row["oil"], number_format.rstrip("}"))
            for row in tables.rows(claim_numbers[claim_numbers["number"] == name])
        ]
        if numbers_of_oils:
            number_texts.append(
                f"{_fill_in_settings(meaning, settings)}: {', '.join(numbers_of_oils)}"
            )
        elif name in claim.readings:
            number_texts.append(
                f"not judged on these constants: {_fill_in_settings(label, settings)}"
            )
    return number_texts


def _number_of_oil(value: float, oil: str, number_format: str) -> str:
    """A number in its format, or in percent without a format; the oil behind it if it has one."""
    text = format(value, number_format) if number_format else _percent(value)
    return f"{text} ({oil})" if oil else text


def _percent(share: float) -> str:
    """A share in percent; 100 or 0 only where it is all or none."""
    near_an_end = share < 0.01 or share > 0.99
    if near_an_end and share not in (0.0, 1.0):
        return f"{min(max(share, 0.001), 0.999):.1%}"
    return f"{share:.0%}"


def _fill_in_settings(text: str, settings: Settings) -> str:
    """A text of a claim with settings in place of its braces."""
    return text.format(**dict(study_settings(settings)))


def _printed_section(results: CampaignTables, campaign: Campaign) -> Section:
    """The constants printed in the paper: distance from the fit, and how sure their signs are.

    The signs in use are compared with those of the fitted constants. A fit confirms or contradicts
    a sign only where the sign of its own constant is known.
    """
    if results.signs.empty:
        return Section("printed", "Printed constants")
    coefficients = results.configured_fits.coefficients
    coefficients = coefficients[coefficients["law"] == PAPER_LAW.name]
    fitted_constants = coefficients[["oil", "constant", "value", "verdict"]].dropna(subset="value")
    compared_constants = fitted_constants.merge(results.sign_verdicts[["oil", "constant", "sign"]])
    has_same_sign = (compared_constants["value"] < 0) == (compared_constants["sign"] == "-")
    # the other verdicts are `sign unknown`, `no interval`, `at a bound` and so on
    is_known = compared_constants["verdict"] == "known"
    oil_and_constant = compared_constants["oil"] + " " + compared_constants["constant"]
    facts_on_constants = facts_from_template(
        "deng2026_study/printed.jinja",
        confirmed=(is_known & has_same_sign).sum(),
        compared=len(compared_constants),
        turned=oil_and_constant[is_known & ~has_same_sign].tolist(),
        unknown=oil_and_constant[~is_known].tolist(),
        campaign=campaign,
    )
    differences = results.printed_judged.dropna(subset=["tested_difference"])
    columns = ["tested_difference", "extrapolated_difference"]
    differences[columns] = differences[columns].abs()
    constants_of_verdict = results.sign_verdicts.groupby(["oil", "verdict"])["constant"].agg(
        " ".join
    )
    constants_by_verdict = constants_of_verdict.unstack(fill_value="-").reindex(
        columns=_SIGN_VERDICTS, fill_value="-"
    )
    sign_sets_in_use = results.signs[results.signs["in_use"]].drop_duplicates("oil")
    sign_sets_in_use = sign_sets_in_use.join(constants_by_verdict, on="oil", how="inner")
    shown_tables = [
        show_table(differences, "printed_judged"),
        show_table(sign_sets_in_use, "signs"),
    ]
    return Section("printed", "Printed constants", facts_on_constants, shown_tables)


def _choice_section(results: CampaignTables) -> Section:
    """How often the oil that the paper advises is the best oil, over the operating points."""
    advice = results.slip_advice
    judged_points = advice[~advice["judgement"].isin(JUDGEMENTS_WITHOUT_CHOICE)]
    if judged_points.empty:
        return Section("choice", "Choice of oil")
    undecided_counts = advice.loc[
        advice["judgement"].isin(JUDGEMENTS_WITHOUT_CHOICE), "judgement"
    ].value_counts()
    disagreeing = judged_points[judged_points["judgement"] != "agree"]
    disagreements = disagreeing["judgement"].value_counts()
    # one row per choice and scenario: other limits, orders of the rules and temperatures
    scenarios = results.advice_band
    # an oil occurs once for each operating point where it is the best one or nearly so
    good_oils = judged_points["good_oils"].explode().tolist()
    certainty = certainty_of_best_oil(results.cage_slip, STAYS_BEST_SHARE)
    facts_on_choice = facts_from_template(
        "deng2026_study/choice.jinja",
        mapped=len(advice),
        total=len(judged_points),
        undecided={UNDECIDED_TEXTS[str(code)]: count for code, count in undecided_counts.items()},
        agreeing=len(judged_points) - len(disagreeing),
        others={
            DISAGREEMENT_TEXTS[str(judgement)]: count for judgement, count in disagreements.items()
        },
        best=disagreeing["best_oil"].value_counts().to_dict(),
        bands={
            traction: _ends_of_band(scenarios_of_traction)
            for traction, scenarios_of_traction in scenarios.groupby("traction", sort=False)
        },
        varied=scenarios[["limit_factor", "inlet_temperature_c"]].agg(["min", "max"]),
        points_where_good={oil: good_oils.count(oil) for oil in dict.fromkeys(good_oils)},
        truth=choice_by_truth(advice, results.true_cage_slip),
        smallest_slip=_SMALLEST_SLIP_FOR_RELATIVE_ERROR,
        share=STAYS_BEST_SHARE,
        certainty=certainty if certainty["draws_answered"].any() else None,
    )
    return Section("choice", "Choice of oil", facts_on_choice)


def _ends_of_band(scenarios: pd.DataFrame) -> pd.DataFrame:
    """Smallest and largest share of points at which each choice agrees, by choice.

    Args:
        scenarios: Rows of the table `advice_band` of one traction.
    """
    share = scenarios["agreeing_points"] / scenarios["operating_points"]
    return share.groupby(scenarios["choice"], sort=False).agg(["min", "max"])


def choice_by_truth(advice: pd.DataFrame, truth: pd.DataFrame) -> dict[str, float] | None:
    """How well the choice of oil and the map of the bearing agree with the simulated truth.

    The choice is the paper's. The map is calculated with the fitted law.

    Args:
        advice: Table `slip_advice`.
        truth: Table `true_cage_slip`, calculated with the true traction.

    Returns:
        Numbers of operating points, and relative errors of the fitted law in cage slip and torque.
        The error of the slip is NaN where no point slips enough. None where mu was measured, so
        that there is no known truth.
    """
    if truth.empty:
        return None
    judged = advice[~advice["true_judgement"].isin(JUDGEMENTS_WITHOUT_CHOICE)]
    slipping_rows = truth[truth["cage_slip"] > _SMALLEST_SLIP_FOR_RELATIVE_ERROR]
    torque_errors = (truth["law_torque_n_m"] / truth["torque_n_m"] - 1).abs()
    slip_is_inside = slipping_rows["cage_slip_inside"].dropna()
    torque_is_inside = truth["torque_inside"].dropna()
    return {
        "total": len(judged),
        "agreeing": int((judged["true_judgement"] == "agree").sum()),
        "same_best": int((judged["true_best_oil"] == judged["best_oil"]).sum()),
        "slips_with_interval": len(slip_is_inside),
        "slips_in_interval": int(slip_is_inside.sum()),
        "torques_with_interval": len(torque_is_inside),
        "torques_in_interval": int(torque_is_inside.sum()),
        "slipping": len(slipping_rows),
        "median_slip_error": float(
            (slipping_rows["law_cage_slip"] / slipping_rows["cage_slip"] - 1).abs().median()
        ),
        "median_torque_error": float(torque_errors.median()),
        "largest_torque_error": float(torque_errors.max()),
    }


def _truth_section(errors: pd.DataFrame) -> Section:
    """How wrong each law is where the truth was simulated."""
    if errors.empty:
        return Section("truth", "Simulated truth")
    condition_format = "{:g} GPa, {:g} m/s, {:g} degC, S {:g}"
    worst_conditions = errors[list(_WORST_CONDITION)].to_numpy()
    conditions = [condition_format.format(*condition) for condition in worst_conditions]
    error_table = show_table(errors.assign(where=conditions), "truth-errors")
    return Section(
        "truth", "Simulated truth", facts_from_template("deng2026_study/truth.jinja"), [error_table]
    )


# Folder of the printed constants among the exports. Those of fits are named by identifiers, which
# have no hyphen.
_EXPORT_FOLDER = "printed-constants"


def _exports(
    oils: Collection[str], settings: Settings, provenance: Mapping[str, Any]
) -> dict[str, bytes]:
    """The content of the export files of printed constants, by path, for some oils."""
    path = reference_file("printed_coefficients")
    tested_box = study_settings(settings).printed.boxes.tested
    descriptions = describe_printed(path, tested_box, settings.exports)
    chosen_descriptions = [description for description in descriptions if description.oil in oils]
    files = export_oils(chosen_descriptions, provenance) if chosen_descriptions else {}
    return {f"{_EXPORT_FOLDER}/{file}": content for file, content in files.items()}


def _describe_published() -> tuple[list[Description], Path]:
    """The printed constants of every oil, and their file."""
    path = reference_file("printed_coefficients")
    tested_box = default_settings().printed.boxes.tested
    return describe_printed(path, tested_box, read_config(CONFIG).exports), path


STUDY = Study(
    sections=sections,
    exports=_exports,
    exports_sentence="The constants that the paper prints of these oils: "
    f"[{_EXPORT_FOLDER}]({_EXPORT_FOLDER}/README.md).",
    read_reference=read_reference,
    describe_published=_describe_published,
)
