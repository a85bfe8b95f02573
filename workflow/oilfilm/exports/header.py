"""What every exported function says of itself, as lines of plain text."""

import textwrap
from collections.abc import Iterable

from oilfilm.exports.description import SLIP, SLIP_MEANING, Description
from oilfilm.exports.names import plain
from oilfilm.report.captions import PAPER, credit

# Fortran ends a line at 132 characters; an editor shows fewer.
_WIDTH = 92
KNOWN_WHERE_TESTED = "mu is known only where it was tested"
NOT_MARKED = (
    "The tested box is a rectangle: inside it, conditions far from every run are not marked "
    "(oilfilm predict marks them)"
)


def header(description: Description, sentences: Iterable[str], mark: str, *results: str) -> str:
    """The head of a source file, as a comment whose every line begins with `mark`.

    Args:
        description: The fit.
        sentences: One per argument: name, meaning, unit, range tested.
        mark: What makes a line a comment.
        results: What the functions give back, and for which arguments they give nothing.
    """
    oil, where_known = plain(description.oil), description.where_known
    lines = [
        *_lines(f"Traction coefficient mu (traction force over load) of the oil {oil}"),
        "",
        *_lines(
            origin(description),
            *fit_sentences(description),
            f"Every constant: traction_{description.identifier}.json and .csv",
        ),
        "",
        *_lines(*law_sentences(description)),
        "",
        "Arguments, and the box tested",
        *_lines(*sentences, indent="  "),
        *_lines(where_known and f"Not an argument, because {KNOWN_WHERE_TESTED}: {where_known}"),
        "",
        *_lines(*results, NOT_MARKED),
    ]
    return "\n".join(f"{mark}{line}".rstrip() for line in lines)


def origin(description: Description) -> str:
    """Where the constants come from, and whether the data behind them are real."""
    campaign = description.campaign
    if campaign is None:
        return f"PRINTED CONSTANTS of {PAPER}, Eqs 11-13"
    kind = (
        plain(f"Measured data{credit(campaign)}")
        if campaign.data == "measured"
        else "SIMULATED DATA, not for design"
    )
    return f"{kind}. Campaign {plain(campaign.name)}: {plain(campaign.description)}"


def fit_sentences(description: Description) -> list[str]:
    """How good the fit is; of the paper's constants, what is not known of them."""
    fit = description.quality
    if fit is None:
        by_verdict: dict[str, list[str]] = {}
        for constant in description.constants:
            _, _, sure = str(constant["verdict"]).partition(", ")
            by_verdict.setdefault(sure, []).append(str(constant["name"]))
        by_verdict.pop("", None)
        sure = "; ".join(f"{verdict}: {', '.join(names)}" for verdict, names in by_verdict.items())
        return [
            f"They are {certificate(description)}. The tested box is that of the paper's abstract.",
            "The signs of the exponents were lost in the available text and are restored.",
            f"How sure they are: {sure}",
            *(f"NOT SOUND: {sentence}" for sentence in description.fitted.wrong),
        ]
    return [
        f"Fit: {fit['n_points']} points of {fit['n_curves']} runs, rms error of mu "
        f"{fit['rmse']:.2g}; {certificate(description)}",
        *(plain(f"NOT SOUND: {each}") for each in description.fitted.wrong),
    ]


def certificate(description: Description) -> str:
    """How many searches agree where the fit is certified, else why it is not."""
    fit = description.quality
    if fit is None:
        return "as printed, not refitted: without errors and intervals"
    if fit["certified"]:
        return f"certified: {fit['searches_agreeing']} of {fit['searches']} searches agree"
    return plain(str(fit["certificate"]))


def law_sentences(description: Description) -> list[str]:
    """The law, its powers and its source."""
    given, law = description.arguments, description.law
    return [
        f"Law {law.name}: {law.formula} for S >= 0, and mu(-S) = -mu(S)",
        *([f"with {description.power_law(given)}"] if given else []),
        law.source,
    ]


def argument_sentences(description: Description) -> list[str]:
    """One sentence per argument, in the units of the tables."""
    return [
        *(
            f"{condition.name}: {condition.symbol}, {condition.meaning}, {condition.unit}; "
            f"{span(*condition.tested)}"
            for condition in description.arguments
        ),
        f"{SLIP}: {slip_range(description)}",
    ]


def marked(description: Description) -> str:
    """Where the functions mark mu, in words."""
    return (
        f"mu is extrapolated or its size is above {description.limit:g}, the oil's limiting shear "
        f"stress over the pressure"
    )


def slip_range(description: Description) -> str:
    """What S is, and how far it was tested."""
    return f"S, {SLIP_MEANING}, either sign; |S| {span(*description.slip.tested)}"


def span(lower: float | None, upper: float | None) -> str:
    """A range in words."""
    return "unknown" if lower is None or upper is None else f"{lower:.4g} to {upper:.4g}"


def _lines(*texts: str, indent: str = "") -> list[str]:
    wrapper = textwrap.TextWrapper(_WIDTH, initial_indent=indent, subsequent_indent=indent + "  ")
    return [line for text in texts for line in wrapper.wrap(text)]
