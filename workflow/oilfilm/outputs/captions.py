"""The words of every figure: title, caption and category, for the figure, the report and Snakemake.

Nothing is imported here, because the Snakefile reads the names each time it is parsed.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

_PAPER = "Deng et al., Lubricants 14 (2026) 33"
_REFIT = (
    " Full lines: the refit in its 95 % interval; thin dashed lines: the constants printed in the "
    "paper, signs restored; shaded: beyond the conditions tested."
)
_TEMPERATURES = " The temperatures are ours: the paper does not print its own." + _REFIT


@dataclass(frozen=True)
class Caption:
    """What a figure is called and what it draws.

    Attributes:
        title: A few words.
        words: A sentence or a few: what is drawn, with units.
        category: Where it belongs among the others.
        paper: What it stands for in the paper, as "Fig. 2"; empty where the paper has no such one.
        shows_data: False where nothing comes from the campaign's logs.
    """

    title: str
    words: str
    category: str
    paper: str = ""
    shows_data: bool = True


# In the order in which they are shown.
CAPTIONS: dict[str, Caption] = {
    "fig01": Caption(
        "Traction rig",
        "(a) Ball-on-disc rig with its drives and sensors; (b) contact of ball and disc with the "
        "speeds, load and force that are measured. Drawn by code from the description in the "
        "text, dimensions as configured (mm); not to scale.",
        "Paper",
        "Fig. 1",
        shows_data=False,
    ),
    "tab01": Caption(
        "Properties of the oils",
        "Density, viscosity, pressure-viscosity coefficient, thermal conductivity and specific "
        "heat at 100 \N{DEGREE SIGN}C and 1 bar, each as configured with its source. The paper's "
        "own values are lost; stand-ins are marked.",
        "Paper",
        "Table 1",
        shows_data=False,
    ),
    "tab02": Caption(
        "Test matrix",
        "Levels of maximum Hertz pressure (GPa), entrainment speed (m/s), inlet temperature "
        "(\N{DEGREE SIGN}C), the slide-roll ratios of accepted points, and the curves that were "
        "accepted. The paper's own table is lost; what its text still says stands beside it.",
        "Paper",
        "Table 2",
    ),
    "fig02": Caption(
        "Traction curves of one oil",
        "Traction coefficient against slide-roll ratio at three inlet temperatures: by maximum "
        "Hertz pressure (left) and by entrainment speed (right). Symbols: plateau means with 95 % "
        "intervals of their random part; lines: the fitted law.",
        "Paper",
        "Fig. 2",
    ),
    "fig03": Caption(
        "Traction curves of all oils at one temperature",
        "Traction coefficient against slide-roll ratio, a panel a pressure. Symbols: plateau means "
        "with 95 % intervals of their random part; lines: the fitted law.",
        "Paper",
        "Fig. 3",
    ),
    "eqs11-13": Caption(
        "Fitted constants beside the printed ones",
        "Each oil's constants: fitted, with the standard error from resampling whole curves, and, "
        "where the paper has the oil, as printed, signs restored. P in GPa, U over 20 m/s, T over "
        "20 \N{DEGREE SIGN}C.",
        "Paper",
        "Eqs 11-13",
    ),
    "fig04": Caption(
        "What the paper says of the Wang-Deng law",
        "(a) Traction coefficient that a law leaves at no slip, at every tested condition; (b) "
        "each law's relative errors: on the fitted curves, on curves left out, and on the lowest "
        "and highest levels left out.",
        "Paper",
        "Fig. 4",
    ),
    "tab03": Caption(
        "Parameters of the bearing",
        "Geometry, materials and cage of the bearing as configured, each with its source. The "
        "paper's own table is partly lost: what its text still says stands beside it.",
        "Paper",
        "Table 3",
        shows_data=False,
    ),
    "fig05": Caption(
        "Torque rig",
        "Rig for the friction torque of a bearing: inner ring driven, pure axial load, oil fed "
        "under the race, torque of the outer ring measured. Drawn by code from the description in "
        "the text; not to scale.",
        "Paper",
        "Fig. 5",
        shows_data=False,
    ),
    "fig06": Caption(
        "Friction torque of the bearing",
        "Above: measured torque (N m; bars: 95 %, random errors alone) and the torque that turns "
        "the inner ring by the law on stress, on load and on dimensionless load, against speed of "
        "the inner ring; below: their relative errors (%).",
        "Paper",
        "Fig. 6",
    ),
    "fig07": Caption(
        "Traction against slip at 200 m/s",
        "Traction coefficient of all oils against slide-roll ratio, a panel a pressure, at several "
        "inlet temperatures." + _TEMPERATURES,
        "Paper",
        "Fig. 7",
    ),
    "fig08": Caption(
        "Traction against entrainment speed",
        "Traction coefficient of all oils against entrainment speed (m/s) at 1.5 GPa, a panel a "
        "slide-roll ratio, at several inlet temperatures." + _TEMPERATURES,
        "Paper",
        "Fig. 8",
    ),
    "fig09": Caption(
        "Traction against pressure",
        "Traction coefficient of all oils against maximum Hertz pressure (GPa), fast and slow, at "
        "little and at much slip, at several inlet temperatures." + _TEMPERATURES,
        "Paper",
        "Fig. 9",
    ),
    "fig10": Caption(
        "Traction against temperature",
        "Traction coefficient of all oils against inlet temperature (\N{DEGREE SIGN}C), light and "
        "heavy, fast and slow, at several slide-roll ratios. These are ours: the paper does not "
        "print its own." + _REFIT,
        "Paper",
        "Fig. 10",
    ),
    "coverage": Caption(
        "Coverage of the test matrix",
        "Conditions that were accepted, refused or never measured, an oil a column and a "
        "temperature a row, over entrainment speed (m/s) and maximum Hertz pressure (GPa) or load "
        "(N). In each cell: runs accepted of all.",
        "Data quality",
    ),
    "curves": Caption(
        "All curves",
        "Every accepted plateau of every oil, traction coefficient against slide-roll ratio, and "
        "the fitted law at each of its conditions.",
        "Data quality",
    ),
    "residuals": Caption(
        "Residuals of the fit",
        "Measured minus fitted traction coefficient of every accepted plateau against pressure "
        "(GPa), speed (m/s), temperature (\N{DEGREE SIGN}C) and slide-roll ratio, with the mean at "
        "each level: where it leaves zero, the law lacks something.",
        "Fits",
    ),
    "identifiability": Caption(
        "How well the data tell the constants apart",
        "Above: correlation of each pair of constants over refits to curves drawn again. Below: "
        "profile of each constant, the signed root of the rise of the squared error over its "
        "distance from the optimum in naive standard errors; a straight line is a well-posed "
        "constant.",
        "Fits",
    ),
    "extrapolation": Caption(
        "Fitted laws beside the truth of the simulation",
        "(a-d) One oil along one cut through the conditions of each of Figs 7-10; (e) each law's "
        "rms error within the tested box and beyond it. It decides nothing about the real oils.",
        "Fits",
    ),
    "claims": Caption(
        "Claims of the paper",
        "Each claim by the refit and by the printed constants: its verdict, the share of the "
        "conditions where it holds, and the worst case.",
        "Claims",
    ),
    "signs": Caption(
        "The signs that were lost",
        "All 512 sets of signs of the printed exponents of each oil, scored by the paper's text: "
        "totals by rank, statements of the set in use, and the margin of each sign.",
        "Claims",
        shows_data=False,
    ),
    "selection": Caption(
        "Which oil to choose",
        "Over entrainment speed (m/s) and maximum Hertz pressure (GPa): fields have the colour of "
        "the oil that the paper's rules advise, symbols show where traction and film prefer "
        "another.",
        "Claims",
    ),
    "cage-slip": Caption(
        "Cage slip, and the oil that it speaks for",
        "Slip of the cage (%) at friction equilibrium over the product of pitch diameter and speed "
        "(million mm rpm) and over axial load (kN), an oil a panel; the line is the paper's limit. "
        "Last panel: fields have the colour of the oil that the paper's rules advise, symbols show "
        "where the slip speaks for another.",
        "Bearing",
    ),
    "size-effect": Caption(
        "Size effect of laws on load",
        "Traction torque of the laws on load, as excess over that of the law on stress (%), by "
        "ball diameter (mm; all lengths in proportion, the same stress and surface speed) and by "
        "conformity (the same load and speed).",
        "Bearing",
    ),
    "power-loss": Caption(
        "A published power loss",
        "Calculated power loss (W), term by term, beside a published one against speed of the "
        "inner ring: plausibility alone. Published: NASA TP-2275, second-hand, by a third party's "
        "transcription.",
        "Bearing",
    ),
}


def provenance(campaign: Mapping[str, Any]) -> str:
    """Whether a campaign's data were simulated or measured, in words.

    Args:
        campaign: The campaign file's content, at least `name` and `data`.
    """
    words = (
        f"SIMULATED data (rig twin, campaign {campaign['name']!r}), not a measurement"
        if campaign["data"] == "simulated"
        else f"Measured data, campaign {campaign['name']!r}"
    )
    if campaign.get("film_unjudged", {}).get("accept"):
        words += "; film thickness NOT JUDGED"
    return words


def caption(figure: str, campaign: Mapping[str, Any]) -> str:
    """The whole caption of a figure of a campaign: words, place in the paper, provenance.

    Args:
        figure: Name of the figure, a key of `CAPTIONS`.
        campaign: As in `provenance`.
    """
    known = CAPTIONS[figure]
    parts = [known.words]
    if known.paper:
        parts.append(f"{known.paper} of {_PAPER}.")
    if known.shows_data:
        parts.append(f"{provenance(campaign)}.")
    return " ".join(parts)
