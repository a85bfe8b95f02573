"""One function a figure: finished tables in, a matplotlib Figure and exactly what it draws out."""

from oilfilm.figures.claims_page import claims_page
from oilfilm.figures.coefficients import eqs11_13
from oilfilm.figures.coverage_map import coverage_map
from oilfilm.figures.drawing import Drawing
from oilfilm.figures.extrapolation import extrapolation
from oilfilm.figures.fig04 import fig04
from oilfilm.figures.selection_map import selection_map
from oilfilm.figures.sign_study import sign_study
from oilfilm.figures.traction_curves import Results, curves, fig02, fig03

_ALL = (
    Drawing("fig02", fig02, "curves"),
    Drawing("fig03", fig03, "curves"),
    Drawing("fig04", fig04, "law_panels"),
    Drawing("curves", curves, "curves"),
    Drawing("eqs11-13", eqs11_13, "coefficient_table"),
    Drawing("coverage", coverage_map, "coverage_map"),
    Drawing("extrapolation", extrapolation, "extrapolation_panels"),
    Drawing("signs", sign_study, "sign_study"),
    Drawing("claims", claims_page, "claims_page"),
    Drawing("selection", selection_map, "selection_map"),
)
FIGURES: dict[str, Drawing[Results]] = {drawing.name: drawing for drawing in _ALL}
