"""The description of an oil's constants from which every form of export is made.

Its sentences are the head of every exported file, as lines of plain text. Names of oils and
sentences of a campaign file are untrusted: they must not end an identifier or a comment. Only a
short list of characters passes (`plain_text`, `make_identifiers`).
"""

import hashlib
import math
import re
import textwrap
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base.units import FloatArray
from oilfilm.fits.certificate_sentences import certificate_sentence
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.soundness_sentences import soundness_warnings
from oilfilm.fits.surface_sentences import misfit_sentence
from oilfilm.report.captions import credit_in_brackets
from oilfilm.settings.base import required_value
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CURVE_COLUMNS, CampaignTables
from oilfilm.traction import expression
from oilfilm.traction.expression import Node
from oilfilm.traction.law import QUANTITIES, Law, to_internal

# Largest number of letters of an oil's identifier. With the longest word before it
# (`traction_coefficient_`) a name has at most 63 letters. Fortran 2003 and MATLAB allow no more.
# C99 compares no more.
_IDENTIFIER_LETTERS_MAX = 40
_DIGEST_LETTERS = 8
# No double quote, backslash, asterisk, brace, question mark (trigraphs) or control character, and
# ASCII only: the remaining characters cannot end a comment of C, Fortran or MATLAB or a string of
# Modelica.
_NOT_PLAIN = re.compile(r"[^A-Za-z0-9 .,:;()<>=+/%'_-]")


def plain_text(text: str) -> str:
    """The text on one line, without accents, with '_' for each character that is not allowed.

    Examples:
        >>> plain_text('*/ int x; /*')
        '_/ int x; /_'
    """
    decomposed = unicodedata.normalize("NFKD", text)
    letters = (letter for letter in decomposed if not unicodedata.combining(letter))
    return _NOT_PLAIN.sub("_", " ".join("".join(letters).split()))


def make_identifiers(oil_names: Iterable[str]) -> Mapping[str, str]:
    """The identifier of each oil, for names in code and of files.

    Identifiers are in lower case, because Fortran and some file systems do not distinguish case. If
    an identifier would be empty, too long or the same for two oils, a digest of the oil's name is
    added.

    Examples:
        >>> make_identifiers(["4102", "Ester 5"])
        {'4102': '4102', 'Ester 5': 'ester_5'}
    """
    stem_of_oil = {
        oil_name: re.sub(r"[^a-z0-9]+", "_", oil_name.lower()).strip("_") for oil_name in oil_names
    }
    oil_count_of_stem = Counter(stem_of_oil.values())
    identifier_of_oil = {}
    for oil_name, stem in stem_of_oil.items():
        identifier = stem
        if not stem or oil_count_of_stem[stem] > 1 or len(stem) > _IDENTIFIER_LETTERS_MAX:
            digest = hashlib.sha256(oil_name.encode()).hexdigest()[:_DIGEST_LETTERS]
            start_of_stem = stem[: _IDENTIFIER_LETTERS_MAX - _DIGEST_LETTERS - 1]
            identifier = f"{start_of_stem}_{digest}".strip("_")
        identifier_of_oil[oil_name] = identifier
    return identifier_of_oil


SLIP = "slide_roll_ratio"
SLIP_MEANING = "sliding speed over entrainment speed"
_PRESSURE = "max_hertz_pressure_gpa"
_LOAD = "load_n"
_HEAD_WIDTH = 92  # characters of a line in the head of a file
KNOWN_WHERE_TESTED = "mu is known only where it was tested"
NOT_MARKED = (
    "The tested box is a rectangle: inside it, conditions far from every run are not marked "
    "(oilfilm predict marks them)"
)
# Two contacts are the same if load over pressure cubed differs by less than this share.
_SAME_CONTACT = 1e-6


@dataclass(frozen=True)
class LawVariable:
    """A variable of a law: a group of its power laws, or the slide-roll ratio S.

    Attributes:
        name: A condition (column of the tables, with its unit), or a dimensionless group.
        symbol: As in the law's equation.
        meaning: Its name in words.
        unit: Unit of the values below.
        role: "argument" of the exported functions; "fixed" where the data give no exponent, so that
            mu is known only where the variable was tested.
        level: The one level at which it was tested. None where it is an argument, varies in step
            with other variables, or is unknown.
        reference: Value at which its power is 1; None for S.
        tested: Smallest and largest value tested, of |S| for S. None if it is unknown.
    """

    name: str
    symbol: str
    meaning: str
    unit: str
    role: Literal["argument", "fixed"]
    level: float | None
    reference: float | None
    tested: tuple[float | None, float | None]

    @property
    def relative_name(self) -> str:
        """Name of its value over the reference, in exported code: `bar_p` for P."""
        return f"bar_{self.symbol.lower()}"


@dataclass(frozen=True)
class PublishedSource:
    """Where published constants come from, and what is not known of them.

    Attributes:
        source: The publication.
        sentences: What a user of the constants must know.
    """

    source: str
    sentences: tuple[str, ...]


@dataclass(frozen=True)
class Description:
    """One oil's constants, with everything that their user must know.

    Attributes:
        oil: Name of the oil as in the configuration, untrusted.
        identifier: Its name in names of files and in code, as `make_identifiers` gives it.
        campaign: The campaign behind the fit; None where the constants are published ones.
        law_with_constants: The law with its constants, which are fitted or printed ones.
        law_variables: One variable for each group of the law, in the law's order.
        constants_as_json: All constants in the law's order, each as an object of the JSON file.
        quality: The oil's row of the table `fit_quality`; None for published constants.
        adore_points: Operating points at which the constants of the ADORE form are exported. Each
            is a mapping from column to value.
        misfit_and_scatter: Misfit of the law and scatter of runs, relative; NaN where unknown.
        published: Source of published constants; None where they were fitted.
    """

    oil: str
    identifier: str
    campaign: Campaign | None
    law_with_constants: FittedLaw
    law_variables: tuple[LawVariable, ...]
    constants_as_json: tuple[Mapping[str, Any], ...]
    quality: Mapping[str, Any] | None
    adore_points: tuple[Mapping[str, float], ...]
    misfit_and_scatter: tuple[float, float] = (math.nan, math.nan)
    published: PublishedSource | None = None

    @property
    def law(self) -> Law:
        """The law whose constants these are."""
        return self.law_with_constants.law

    @property
    def kind_of_data(self) -> Literal["measured", "simulated", "printed"]:
        """Whether the constants are from measured or simulated data, or are printed ones."""
        return "printed" if self.campaign is None else self.campaign.data

    @property
    def is_certified(self) -> bool:
        """Whether there is a fit and all of its searches agree."""
        return self.quality is not None and bool(self.quality["certified"])

    @property
    def csv_identity(self) -> dict[str, Any]:
        """The first columns of every row of a csv file: where its constants come from."""
        return {
            "oil": self.oil,
            "law": self.law.name,
            "campaign": "" if self.campaign is None else self.campaign.name,
            "data": self.kind_of_data,
            "certified": self.is_certified,
            "not_sound": "; ".join(self.law_with_constants.warnings),
        }

    @property
    def arguments(self) -> tuple[LawVariable, ...]:
        """Variables of which the fit gives exponents."""
        return tuple(variable for variable in self.law_variables if variable.role == "argument")

    @property
    def where_known(self) -> str:
        """Where each fixed condition was tested, as text. Empty if no condition is fixed."""
        return "; ".join(
            fixed.sentence() for fixed in self.law_with_constants.coefficients.fixed_conditions
        )

    @property
    def limiting_stress_ratio(self) -> float:
        """Limiting shear stress of the oil over the pressure: no film carries a larger |mu|."""
        return self.law_with_constants.coefficients.limiting_stress_ratio

    @property
    def slip_variable(self) -> LawVariable:
        """The slide-roll ratio S. |S| counts as tested from 0, because traction is odd in S."""
        tested = (0.0, number_or_none(self.law_with_constants.coefficients.tested_box[-1, 1]))
        meaning = f"{SLIP_MEANING}, of either sign"
        return LawVariable(SLIP, "S", meaning, "1", "argument", None, None, tested)

    @property
    def argument_names(self) -> list[str]:
        """Arguments of the exported functions."""
        return [argument.name for argument in self.arguments] + [SLIP]

    @property
    def power_arguments(self) -> tuple[LawVariable, ...]:
        """The arguments that enter by a power, which has no value at 0 and below."""
        return tuple(
            argument for argument in self.arguments if argument.name not in self.law.exponential
        )

    @property
    def power_meanings(self) -> str:
        """The names of these arguments in words, as "pressure and speed"; empty without one."""
        meanings = [argument.meaning.partition(",")[0] for argument in self.power_arguments]
        if len(meanings) < 2:
            return "".join(meanings)
        return f"{', '.join(meanings[:-1])} and {meanings[-1]}"

    def power_law(self, variables: Sequence[LawVariable]) -> str:
        """The power law of the coefficients in these variables, as an equation."""
        power_texts = []
        for variable in variables:
            exponent_index = self.law_variables.index(variable) + 1
            relative_text = f"{variable.symbol} / {variable.reference:g} {variable.unit}"
            if variable.name in self.law.exponential:
                power_texts.append(f"exp(X{exponent_index} ({relative_text} - 1))")
            else:
                power_texts.append(f"({relative_text})^X{exponent_index}")
        return f"X = X0 {' '.join(power_texts)} for X = {', '.join(self.law.coefficient_names)}"

    @property
    def obstacle(self) -> str:
        """A sentence on why no function of mu can be written; empty where one can."""
        lacks_constants = np.isnan(self.law_with_constants.coefficients.constants).any()
        return certificate_sentence(self.quality) if lacks_constants and self.quality else ""

    @property
    def value_by_constant(self) -> dict[str, float]:
        """The value of every constant by its name.

        Exponents that the law prescribes are included.
        """
        names = [constant.name for constant in self.law.constants]
        return dict(
            zip(names, self.law_with_constants.coefficients.constants.tolist(), strict=True)
        )

    def steps(self, *, constants_by_name: bool = False) -> list[tuple[str, Node]]:
        """mu as a list of steps, each the name and the expression of an intermediate value.

        The first steps need only the arguments; the last one is "mu".

        mu is that of |S|; the exported functions give it the sign of S.

        Args:
            constants_by_name: Whether expressions have the names of constants, not their values.
        """
        text_of_constant = {
            name: name if constants_by_name else repr(value)
            for name, value in self.value_by_constant.items()
        }
        steps = []
        for argument in self.arguments:
            steps.append((argument.relative_name, f"{argument.name}/{argument.reference!r}"))
        for coefficient in self.law.coefficient_names:
            factors = [text_of_constant[f"{coefficient}0"]]
            for exponent_index, variable in enumerate(self.law_variables, 1):
                exponent_name = f"{coefficient}{exponent_index}"
                if variable.role != "argument" or self.value_by_constant[exponent_name] == 0:
                    continue
                if variable.name in self.law.exponential:
                    factors.append(
                        f"exp({text_of_constant[exponent_name]}*({variable.relative_name} - 1))"
                    )
                else:
                    factors.append(f"{variable.relative_name}**{text_of_constant[exponent_name]}")
            steps.append((coefficient, " * ".join(factors)))
        steps.append(("S", f"abs({SLIP})"))
        steps += self.law.steps
        return expression.parse_steps(steps, (*self.argument_names, *text_of_constant))

    def coefficients_at(self, group_values: FloatArray) -> dict[str, float]:
        """The coefficients, with their signs, by name.

        Args:
            group_values: Value of each group of the law, shape (groups,).
        """
        law = self.law
        group_has_exponent = self.law_with_constants.coefficients.group_has_exponent
        terms = np.where(group_has_exponent, law.log_terms(group_values), 0.0)
        design = np.concatenate([[1.0], terms])[np.newaxis]
        magnitudes = law.magnitudes(
            to_internal(law, self.law_with_constants.coefficients.constants), design
        )[:, 0]
        signs = [coefficient.sign for coefficient in law.coefficients]
        return dict(zip(law.coefficient_names, (magnitudes * signs).tolist(), strict=True))

    def is_outside_tested_box(self, group_values: FloatArray) -> bool:
        """Whether some values of the law's groups are outside the tested box, whatever the slip."""
        # An unknown end is NaN. A comparison with NaN is false, so the point counts as outside.
        tested_ends = np.array([variable.tested for variable in self.law_variables], dtype=float)
        is_inside = (tested_ends[:, 0] <= group_values) & (group_values <= tested_ends[:, 1])
        return not is_inside[self.law_with_constants.coefficients.group_has_exponent].all()

    # ------------------------------------------------------------ sentences

    def header(
        self, argument_sentences: Iterable[str], line_start: str, *result_sentences: str
    ) -> str:
        """The head of a source file, as a comment whose lines begin with `line_start`.

        Args:
            argument_sentences: One sentence for each argument: name, meaning, unit, range tested.
            line_start: What makes a line a comment.
            result_sentences: Sentences on what the functions return.
        """
        texts = [
            f"Traction coefficient mu (traction force over load) of the oil {plain_text(self.oil)}",
            "",
            self.origin,
            *self.fit_sentences,
            f"Every constant: traction_{self.identifier}.json and .csv",
            "",
            *self.law_sentences,
            "",
            "Arguments, and the box tested",
        ]
        texts += [f"  {sentence}" for sentence in argument_sentences]
        if self.where_known:
            texts.append(f"Not an argument, because {KNOWN_WHERE_TESTED}: {self.where_known}")
        texts += ["", *result_sentences, NOT_MARKED]
        wrapper = textwrap.TextWrapper(_HEAD_WIDTH, subsequent_indent="  ")
        lines = []
        for text in texts:
            # the wrapper gives no line for an empty text
            lines += wrapper.wrap(text) or [""]
        return "\n".join(f"{line_start}{line}".rstrip() for line in lines)

    @property
    def origin(self) -> str:
        """The source of the constants, and whether the data behind them are measured."""
        if self.published is not None:
            return f"PRINTED CONSTANTS of {self.published.source}"
        campaign = required_value(self.campaign, "campaign", "the description of a fit")
        data = "SIMULATED DATA, not for design"
        if campaign.data == "measured":
            data = plain_text(f"Measured data{credit_in_brackets(campaign)}")
        return f"{data}. Campaign {plain_text(campaign.name)}: {plain_text(campaign.description)}"

    @property
    def fit_sentences(self) -> list[str]:
        """The quality of the fit; for published constants, what is uncertain about them."""
        if self.published is not None:
            sentences = list(self.published.sentences)
        else:
            quality = required_value(self.quality, "quality", "the description of a fit")
            runs = "1 run" if quality["n_curves"] == 1 else f"{quality['n_curves']} runs"
            sentences = [
                f"Fit: {quality['n_points']} points of {runs}, rms error of mu "
                f"{quality['rmse']:.2g}; {self.certificate_sentence}"
            ]
            misfit = misfit_sentence(*self.misfit_and_scatter)
            if misfit:
                sentences.append(plain_text(misfit))
        return sentences + [
            plain_text(f"NOT SOUND: {sentence}") for sentence in self.law_with_constants.warnings
        ]

    @property
    def certificate_sentence(self) -> str:
        """How many searches agree, or why the fit is not certified."""
        if self.quality is None:
            return "as printed, not refitted: without errors and intervals"
        return plain_text(certificate_sentence(self.quality))

    @property
    def law_sentences(self) -> list[str]:
        """Sentences on the law, its powers and its source."""
        law = self.law
        sentences = [f"Law {law.name}: {law.formula} for S >= 0, and mu(-S) = -mu(S)"]
        if self.arguments:
            sentences.append(f"with {self.power_law(self.arguments)}")
        sentences.append(law.source)
        return sentences

    @property
    def argument_sentences(self) -> list[str]:
        """One sentence per argument, in the units of the tables."""
        sentences = []
        for argument in self.arguments:
            sentences.append(
                f"{argument.name}: {argument.symbol}, {argument.meaning}, {argument.unit}; "
                f"{range_text(*argument.tested)}"
            )
        sentences.append(f"{SLIP}: {self.slip_range}")
        return sentences

    @property
    def slip_range(self) -> str:
        """The slide-roll ratio in words, with its tested range."""
        return f"S, {SLIP_MEANING}, either sign; |S| {range_text(*self.slip_variable.tested)}"


def describe(
    results: CampaignTables, oil: str, identifier: str, law: Law, settings: Settings
) -> Description:
    """Describe one oil's fit.

    Args:
        results: Tables `points`, `coefficients`, `fit_quality` and `soundness`.
        oil: The oil.
        identifier: Its identifier, as of `make_identifiers`.
        law: The fitted law.
        settings: At least `campaign` and `exports`.
    """
    points = results.table("points", CURVE_COLUMNS, oil=oil)
    accepted_points = points[points["accepted"]]
    constant_rows = results.coefficients[results.coefficients["oil"] == oil]
    quality = results.fit_quality[results.fit_quality["oil"] == oil]
    warnings: list[str] = []
    misfit_and_scatter = (float("nan"), float("nan"))
    for row in tables.rows(results.soundness[results.soundness["oil"] == oil]):
        warnings += soundness_warnings(row)
        misfit_and_scatter = (row["misfit"], row["run_scatter"])
    fitted = FittedLaw.from_tables(constant_rows, oil, quality=quality, law=law)
    meanings = constant_meanings(law)
    constants_as_json = [
        _constant_as_json(row, meanings[row["constant"]])
        for row in tables.rows(constant_rows[constant_rows["law"] == law.name])
    ]
    (quality_of_law,) = tables.rows(quality[quality["law"] == law.name])
    requested_points = [point.model_dump() for point in settings.exports.adore_points]
    return Description(
        oil=oil,
        identifier=identifier,
        campaign=settings.campaign,
        law_with_constants=replace(fitted, warnings=tuple(warnings)),
        law_variables=tuple(_law_variables(fitted, accepted_points)),
        constants_as_json=tuple(constants_as_json),
        quality=quality_of_law,
        adore_points=_with_load(requested_points, accepted_points),
        misfit_and_scatter=misfit_and_scatter,
    )


def _law_variables(fitted: FittedLaw, accepted_points: pd.DataFrame) -> Iterator[LawVariable]:
    """The variable of each group of the law, with its tested range.

    Args:
        fitted: The fit.
        accepted_points: Accepted rows of the table of points, of the oil.
    """
    law = fitted.law
    in_step_names = {
        fixed.condition for fixed in fitted.coefficients.fixed_conditions if fixed.varied_in_step
    }
    group_values = law.group_values(accepted_points[list(law.conditions)].to_numpy(dtype=float))
    tested_values = pd.DataFrame(
        group_values, columns=list(law.groups), index=accepted_points.index
    )
    # Mean of the means of runs, so that long runs do not count more. NaN if one run has no value.
    mean_over_runs = tested_values.groupby(accepted_points["run_id"]).mean().mean(skipna=False)
    group_has_exponent = fitted.coefficients.group_has_exponent
    for group, reference, is_argument in zip(
        law.groups, law.reference, group_has_exponent, strict=True
    ):
        quantity = QUANTITIES[group]
        has_level = not is_argument and group not in in_step_names
        yield LawVariable(
            name=group,
            symbol=quantity.symbol,
            meaning=quantity.meaning,
            unit=quantity.unit,
            role="argument" if is_argument else "fixed",
            level=number_or_none(mean_over_runs[group]) if has_level else None,
            reference=reference,
            tested=(
                number_or_none(tested_values[group].min()),
                number_or_none(tested_values[group].max()),
            ),
        )


def _with_load(
    requested_points: Sequence[Mapping[str, float]], accepted_points: pd.DataFrame
) -> tuple[Mapping[str, float], ...]:
    """Operating points with their load, where all points were measured in one contact.

    W/p_max^3 is constant in a circular contact.

    Args:
        requested_points: Operating points, by column.
        accepted_points: Accepted rows of the table of points, of the oil.
    """
    load_over_cubed_pressure = (accepted_points[_LOAD] / accepted_points[_PRESSURE] ** 3).to_numpy(
        dtype=float
    )
    # a comparison with NaN is false
    is_one_contact = (
        len(load_over_cubed_pressure) > 0
        and np.ptp(load_over_cubed_pressure) <= _SAME_CONTACT * load_over_cubed_pressure.max()
    )
    if not is_one_contact:
        return tuple(requested_points)
    points_with_load = []
    for point in requested_points:
        load_n = float(load_over_cubed_pressure[0]) * point[_PRESSURE] ** 3
        points_with_load.append({**point, _LOAD: load_n})
    return tuple(points_with_load)


def number_or_none(value: float) -> float | None:
    """The number as plain Python has it; None for NaN."""
    return None if np.isnan(value) else float(value)


def constant_meanings(law: Law) -> dict[str, str]:
    """The meaning of each constant of a law, by name."""
    meanings = {}
    for coefficient in law.coefficient_names:
        meanings[f"{coefficient}0"] = f"{coefficient} at the reference condition"
        # a fit that does not follow every group names its constant A, not A0
        meanings[coefficient] = (
            f"{coefficient} where the rest was tested, at the reference of the arguments"
        )
        for exponent_index, group in enumerate(law.groups, 1):
            meanings[f"{coefficient}{exponent_index}"] = (
                f"{exponent_meaning(law, group)} in {coefficient}"
            )
    return meanings


def exponent_meaning(law: Law, group: str) -> str:
    """What the exponent of a group is, in words: "exponent of P"."""
    quantity = QUANTITIES[group]
    if group not in law.exponential:
        return f"exponent of {quantity.symbol}"
    reference = law.reference[law.groups.index(group)]
    return f"change of the logarithm per {reference:g} {quantity.unit} of {quantity.symbol}"


def _constant_as_json(row: Mapping[str, Any], meaning: str) -> dict[str, Any]:
    """A constant as an object of the JSON file, from its row of the table `coefficients`."""
    # verdicts: known, sign unknown, no interval, at a bound, in step, not identifiable
    if row["verdict"] == "in step":
        meaning = f"{meaning}, along the tested line"
    return {
        "name": row["constant"],
        "meaning": meaning,
        "value": number_or_none(row["value"]),
        "unit": "1",
        "standard_error": number_or_none(row["standard_error"]),
        "interval": [number_or_none(row["lower"]), number_or_none(row["upper"])],
        "systematic_standard_error": number_or_none(row["systematic_standard_error"]),
        "verdict": row["verdict"],
    }


def range_text(lower: float | None, upper: float | None) -> str:
    """A range in words; "unknown" where an end is not known."""
    if lower is None or upper is None:
        return "unknown"
    return f"{lower:.4g} to {upper:.4g}"
