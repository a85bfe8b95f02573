"""The one description of an oil's constants from which every form of export is made.

Its sentences are what every exported file says of itself, as lines of plain text. Names of oils and
sentences of a campaign file are untrusted. As an identifier or in a comment they must not be able
to end it, so only a short list of characters passes (`plain`, `identifiers`).
"""

import hashlib
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
from oilfilm.fits.certificate_words import certificate
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.soundness_words import what_is_wrong
from oilfilm.report.captions import credit
from oilfilm.settings.base import present
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import expression
from oilfilm.traction.expression import Node
from oilfilm.traction.law import QUANTITIES, Law, to_internal

# Letters of an oil's identifier. With the longest word before it (`traction_coefficient_`) a name
# has no more than the 63 that Fortran 2003 and MATLAB allow and that C99 tells apart.
_LONGEST = 40
# No double quote, backslash, asterisk, brace, question mark (trigraphs) or control character, and
# nothing beyond ASCII: no comment of C, Fortran or MATLAB and no string of Modelica can be ended
# by what is left.
_NOT_PLAIN = re.compile(r"[^A-Za-z0-9 .,:;()<>=+/%'_-]")


def plain(text: str) -> str:
    """The text on one line, accents dropped and '_' for all that could end a comment or string.

    Examples:
        >>> plain('*/ int x; /*')
        '_/ int x; /_'
    """
    decomposed = unicodedata.normalize("NFKD", text)
    letters = (letter for letter in decomposed if not unicodedata.combining(letter))
    return _NOT_PLAIN.sub("_", " ".join("".join(letters).split()))


def identifiers(oils: Iterable[str]) -> Mapping[str, str]:
    """What each oil is called inside identifiers and file names.

    Lower case, because Fortran and some file systems know no other; names that would become the
    same, or too long, carry a digest of the whole name.

    Examples:
        >>> identifiers(["4102", "Ester 5"])
        {'4102': '4102', 'Ester 5': 'ester_5'}
    """
    cleaned = {oil: re.sub(r"[^a-z0-9]+", "_", oil.lower()).strip("_") for oil in oils}
    uses = Counter(cleaned.values())
    for oil, name in cleaned.items():
        if not name or uses[name] > 1 or len(name) > _LONGEST:
            digest = hashlib.sha256(oil.encode()).hexdigest()[:8]
            cleaned[oil] = f"{name[: _LONGEST - 9]}_{digest}".strip("_")
    return cleaned


SLIP = "slide_roll_ratio"
SLIP_MEANING = "sliding speed over entrainment speed"
_PRESSURE = "max_hertz_pressure_gpa"
_LOAD = "load_n"
# Fortran ends a line at 132 characters; an editor shows fewer.
_WIDTH = 92
KNOWN_WHERE_TESTED = "mu is known only where it was tested"
NOT_MARKED = (
    "The tested box is a rectangle: inside it, conditions far from every run are not marked "
    "(oilfilm predict marks them)"
)
# Contacts whose load over the cube of the pressure differs by less than this share are one contact.
_SAME_CONTACT = 1e-6


@dataclass(frozen=True)
class Condition:
    """What the law's coefficients are power laws of, or the slide-roll ratio S.

    Attributes:
        name: Column of the tables, with its unit; or a dimensionless group of the law.
        symbol: As in the law's equation.
        meaning: What it is.
        unit: Unit of every value here.
        role: "fixed" where the data give no exponent, so that mu is known where it was tested only.
        level: Its level; None where it is an argument, varies in step with others, or is unknown.
        reference: Value at which its power is 1; None for S.
        tested: Smallest and largest value tested, of |S| for S; None where unknown.
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
    def relative(self) -> str:
        """Name of its value over the reference, in exported code."""
        return f"bar_{self.symbol.lower()}"


@dataclass(frozen=True)
class Published:
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
        oil: Name as in the configuration, untrusted.
        identifier: Its name in file names and identifiers.
        campaign: The campaign behind the fit; None where the constants are published ones.
        fitted: The law with its constants.
        conditions: What the law's coefficients are power laws of, in the law's order.
        constants: All constants in the law's order, as in the JSON file.
        quality: The oil's row of the table `fit_quality`; None for published constants.
        adore_points: Operating points (by column) at which the ADORE form is wanted.
        published: Of published constants; None where they were fitted.
    """

    oil: str
    identifier: str
    campaign: Campaign | None
    fitted: FittedLaw
    conditions: tuple[Condition, ...]
    constants: tuple[Mapping[str, Any], ...]
    quality: Mapping[str, Any] | None
    adore_points: tuple[Mapping[str, float], ...]
    published: Published | None = None

    @property
    def law(self) -> Law:
        """The law that was fitted."""
        return self.fitted.law

    @property
    def data(self) -> Literal["measured", "simulated", "printed"]:
        """What the constants come from."""
        return "printed" if self.campaign is None else self.campaign.data

    @property
    def certified(self) -> bool:
        """Whether there is a fit and all of its searches agree."""
        return self.quality is not None and bool(self.quality["certified"])

    @property
    def identity(self) -> dict[str, Any]:
        """The first columns of every row of a csv file: where the row comes from."""
        return {
            "oil": self.oil,
            "law": self.law.name,
            "campaign": "" if self.campaign is None else self.campaign.name,
            "data": self.data,
            "certified": self.certified,
            "not_sound": "; ".join(self.fitted.wrong),
        }

    @property
    def arguments(self) -> tuple[Condition, ...]:
        """Conditions on which the fitted law depends."""
        return tuple(condition for condition in self.conditions if condition.role == "argument")

    @property
    def where_known(self) -> str:
        """Where the conditions were tested that are no arguments; empty where there are none."""
        return "; ".join(fixed.sentence() for fixed in self.fitted.coefficients.fixed)

    @property
    def limit(self) -> float:
        """Limiting shear stress of the oil over the pressure: no film carries a larger |mu|."""
        return self.fitted.coefficients.limiting_stress_ratio

    @property
    def slip(self) -> Condition:
        """S; |S| counts as tested from 0, because traction is odd in S."""
        tested = (0.0, number_or_none(self.fitted.coefficients.box[-1, 1]))
        meaning = f"{SLIP_MEANING}, of either sign"
        return Condition(SLIP, "S", meaning, "1", "argument", None, None, tested)

    @property
    def argument_names(self) -> list[str]:
        """Arguments of the exported functions."""
        return [*(condition.name for condition in self.arguments), SLIP]

    @property
    def argument_meanings(self) -> str:
        """The arguments before S in a few words: "pressure and speed"."""
        *first, last = (condition.meaning.partition(",")[0] for condition in self.arguments)
        return f"{', '.join(first)} and {last}" if first else last

    def power_law(self, conditions: Sequence[Condition]) -> str:
        """How the coefficients depend on these of the conditions."""
        powers = (
            f"({condition.symbol} / {condition.reference:g} {condition.unit})"
            f"^X{self.conditions.index(condition) + 1}"
            for condition in conditions
        )
        return f"X = X0 {' '.join(powers)} for X = {', '.join(self.law.local_constants)}"

    @property
    def obstacle(self) -> str:
        """Why no function of mu can be written; empty where one can."""
        lost = np.isnan(self.fitted.coefficients.constants).any()
        return certificate(self.quality) if lost and self.quality else ""

    @property
    def values(self) -> dict[str, float]:
        """Every constant by its name, with those that the law gives."""
        names = (constant.name for constant in self.law.constants)
        return dict(zip(names, self.fitted.coefficients.constants.tolist(), strict=True))

    def steps(self, *, named: bool = False) -> list[tuple[str, Node]]:
        """mu in straight-line form: name and value of each step from the arguments to "mu".

        mu is that of |S|; the last thing a function does is to give it the sign of S.

        Args:
            named: Whether the constants are by their names, else by their values.
        """
        written = {name: name if named else repr(value) for name, value in self.values.items()}
        steps = [(each.relative, f"{each.name}/{each.reference!r}") for each in self.arguments]
        for name in self.law.local_constants:
            powers = [
                f"{condition.relative}**{written[f'{name}{number}']}"
                for number, condition in enumerate(self.conditions, 1)
                if condition.role == "argument" and self.values[f"{name}{number}"] != 0
            ]
            steps.append((name, " * ".join([written[f"{name}0"], *powers])))
        steps += [("S", f"abs({SLIP})"), *self.law.steps]
        return expression.parse_steps(steps, (*self.argument_names, *written))

    def coefficients_at(self, groups: FloatArray) -> dict[str, float]:
        """The coefficients, with their signs, at one row of the law's groups."""
        law, known = self.law, self.fitted.coefficients.known
        relative = np.where(known, groups / np.array(law.reference), 1.0)
        design = np.concatenate([[1.0], np.log(relative)])[np.newaxis]
        sizes = law.sizes(to_internal(law, self.fitted.coefficients.constants), design)[:, 0]
        signs = [coefficient.sign for coefficient in law.coefficients]
        return dict(zip(law.local_constants, (sizes * signs).tolist(), strict=True))

    def outside(self, groups: FloatArray) -> bool:
        """Whether a row of the law's groups lies outside the tested box, whatever the slip."""
        # NaN, for an end that is unknown, compares as false
        ends = np.array([condition.tested for condition in self.conditions], dtype=float)
        inside = (ends[:, 0] <= groups) & (groups <= ends[:, 1])
        return not inside[self.fitted.coefficients.known].all()

    # ------------------------------------------------------------ sentences

    def header(self, sentences: Iterable[str], mark: str, *results: str) -> str:
        """The head of a source file, as a comment whose every line begins with `mark`.

        Args:
            sentences: One per argument: name, meaning, unit, range tested.
            mark: What makes a line a comment.
            results: What the functions give back, and for which arguments they give nothing.
        """
        where = f"Not an argument, because {KNOWN_WHERE_TESTED}: {self.where_known}"
        texts = [
            f"Traction coefficient mu (traction force over load) of the oil {plain(self.oil)}",
            "",
            self.origin,
            *self.fit_sentences,
            f"Every constant: traction_{self.identifier}.json and .csv",
            "",
            *self.law_sentences,
            "",
            "Arguments, and the box tested",
            *(f"  {sentence}" for sentence in sentences),
            *([where] if self.where_known else []),
            "",
            *results,
            NOT_MARKED,
        ]
        wrapper = textwrap.TextWrapper(_WIDTH, subsequent_indent="  ")
        lines = [line for text in texts for line in wrapper.wrap(text) or [""]]
        return "\n".join(f"{mark}{line}".rstrip() for line in lines)

    @property
    def origin(self) -> str:
        """Where the constants come from, and whether the data behind them are real."""
        if self.published is not None:
            return f"PRINTED CONSTANTS of {self.published.source}"
        campaign = present(self.campaign, "campaign", "the description of a fit")
        kind = (
            plain(f"Measured data{credit(campaign)}")
            if campaign.data == "measured"
            else "SIMULATED DATA, not for design"
        )
        return f"{kind}. Campaign {plain(campaign.name)}: {plain(campaign.description)}"

    @property
    def fit_sentences(self) -> list[str]:
        """How good the fit is; for published constants, what is not known of them."""
        not_sound = [plain(f"NOT SOUND: {sentence}") for sentence in self.fitted.wrong]
        if self.published is not None:
            return [*self.published.sentences, *not_sound]
        fit = present(self.quality, "quality", "the description of a fit")
        return [
            f"Fit: {fit['n_points']} points of {fit['n_curves']} runs, rms error of mu "
            f"{fit['rmse']:.2g}; {self.certificate}",
            *not_sound,
        ]

    @property
    def certificate(self) -> str:
        """How many searches agree where the fit is certified, else why it is not."""
        fit = self.quality
        if fit is None:
            return "as printed, not refitted: without errors and intervals"
        return plain(certificate(fit))

    @property
    def law_sentences(self) -> list[str]:
        """The law, its powers and its source."""
        given, law = self.arguments, self.law
        return [
            f"Law {law.name}: {law.formula} for S >= 0, and mu(-S) = -mu(S)",
            *([f"with {self.power_law(given)}"] if given else []),
            law.source,
        ]

    @property
    def argument_sentences(self) -> list[str]:
        """One sentence per argument, in the units of the tables."""
        return [
            *(
                f"{condition.name}: {condition.symbol}, {condition.meaning}, {condition.unit}; "
                f"{span(*condition.tested)}"
                for condition in self.arguments
            ),
            f"{SLIP}: {self.slip_range}",
        ]

    @property
    def slip_range(self) -> str:
        """What S is, and how far it was tested."""
        return f"S, {SLIP_MEANING}, either sign; |S| {span(*self.slip.tested)}"


def describe(
    results: CampaignTables, oil: str, identifier: str, law: Law, settings: Settings
) -> Description:
    """Describe one oil's fit.

    Args:
        results: Tables `points` (what was tested), `coefficients`, `fit_quality`, `soundness`.
        oil: The oil.
        identifier: Its name in identifiers (`identifiers`).
        law: The fitted law.
        settings: `campaign` and `exports` of them.
    """
    requested = [point.model_dump() for point in settings.exports.adore_points]
    coefficients, quality, points, judged = (
        table[table["oil"] == oil]
        for table in (results.coefficients, results.fit_quality, results.points, results.soundness)
    )
    wrong = [sentence for row in tables.rows(judged) for sentence in what_is_wrong(row)]
    fitted = FittedLaw.of(coefficients, oil, quality=quality, law=law)
    (row,) = tables.rows(quality[quality["law"] == law.name])
    accepted, meanings = points[points["accepted"]], constant_meanings(law)
    constants = tables.rows(coefficients[coefficients["law"] == law.name])
    return Description(
        oil=oil,
        identifier=identifier,
        campaign=settings.campaign,
        fitted=replace(fitted, wrong=tuple(wrong)),
        conditions=tuple(_conditions(fitted, accepted)),
        constants=tuple(_constant(each, meanings[each["constant"]]) for each in constants),
        quality=row,
        adore_points=_with_load(requested, accepted),
    )


def _conditions(fitted: FittedLaw, accepted: pd.DataFrame) -> Iterator[Condition]:
    law, known = fitted.law, fitted.coefficients.known
    in_step = {fixed.condition for fixed in fitted.coefficients.fixed if fixed.in_step}
    groups = law.group_values(accepted[list(law.conditions)].to_numpy(dtype=float))
    tested = pd.DataFrame(groups, columns=list(law.groups), index=accepted.index)
    levels = tested.groupby(accepted["run_id"]).mean().mean(skipna=False)
    for name, reference, is_argument in zip(law.groups, law.reference, known, strict=True):
        quantity = QUANTITIES[name]
        yield Condition(
            name,
            quantity.symbol,
            quantity.meaning,
            quantity.unit,
            "argument" if is_argument else "fixed",
            None if is_argument or name in in_step else number_or_none(levels[name]),
            reference,
            (number_or_none(tested[name].min()), number_or_none(tested[name].max())),
        )


def _with_load(
    requested: Sequence[Mapping[str, float]], accepted: pd.DataFrame
) -> tuple[Mapping[str, float], ...]:
    """Operating points with the load besides, where all points were measured in one contact.

    W goes with p_max^3 in a circular contact.
    """
    factors = (accepted[_LOAD] / accepted[_PRESSURE] ** 3).to_numpy(dtype=float)
    if not len(factors) or not np.ptp(factors) <= _SAME_CONTACT * factors.max():
        return tuple(requested)
    return tuple({**point, _LOAD: float(factors[0]) * point[_PRESSURE] ** 3} for point in requested)


def number_or_none(value: float) -> float | None:
    """The number as plain Python has it; None for NaN."""
    return None if np.isnan(value) else float(value)


def constant_meanings(law: Law) -> dict[str, str]:
    """What each constant of a law is, by its name."""
    meanings = {}
    for name in law.local_constants:
        meanings[f"{name}0"] = f"{name} at the reference condition"
        meanings[name] = f"{name} where the rest was tested, at the reference of the arguments"
        for number, group in enumerate(law.groups, 1):
            meanings[f"{name}{number}"] = f"exponent of {QUANTITIES[group].symbol} in {name}"
    return meanings


def _constant(row: Mapping[str, Any], meaning: str) -> dict[str, Any]:
    return {
        "name": row["constant"],
        "meaning": meaning + (", along the tested line" if row["verdict"] == "in step" else ""),
        "value": number_or_none(row["value"]),
        "unit": "1",
        "standard_error": number_or_none(row["standard_error"]),
        "interval": [number_or_none(row["lower"]), number_or_none(row["upper"])],
        "systematic_standard_error": number_or_none(row["systematic_standard_error"]),
        "verdict": row["verdict"],
    }


def span(lower: float | None, upper: float | None) -> str:
    """A range in words."""
    return "unknown" if lower is None or upper is None else f"{lower:.4g} to {upper:.4g}"
