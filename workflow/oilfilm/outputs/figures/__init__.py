"""One function a figure: finished tables in, a matplotlib Figure and exactly what it draws out."""

from oilfilm.outputs.figures.bearing import cage_slip, fig06, power_loss, size_effect
from oilfilm.outputs.figures.claims_page import claims_page
from oilfilm.outputs.figures.coefficients import eqs11_13
from oilfilm.outputs.figures.coverage_map import coverage_map
from oilfilm.outputs.figures.drawing import Drawing
from oilfilm.outputs.figures.extrapolation import extrapolation
from oilfilm.outputs.figures.fig04 import fig04
from oilfilm.outputs.figures.identifiability import identifiability
from oilfilm.outputs.figures.model_curves import fig07, fig08, fig09, fig10
from oilfilm.outputs.figures.residuals import residuals
from oilfilm.outputs.figures.schematics import fig01, fig05
from oilfilm.outputs.figures.selection_map import selection_map
from oilfilm.outputs.figures.sign_study import sign_study
from oilfilm.outputs.figures.stated import tab01, tab02, tab03
from oilfilm.outputs.figures.traction_curves import curves, fig02, fig03

_ALL = (
    Drawing("fig01", fig01, "schematic"),
    Drawing("tab01", tab01, "stated_values"),
    Drawing("tab02", tab02, "stated_values"),
    Drawing("fig02", fig02, "curves"),
    Drawing("fig03", fig03, "curves"),
    Drawing("fig04", fig04, "law_panels"),
    Drawing("tab03", tab03, "stated_values"),
    Drawing("fig06", fig06, "torque_drawn"),
    Drawing("fig05", fig05, "schematic"),
    Drawing("fig07", fig07, "model_curves"),
    Drawing("fig08", fig08, "model_curves"),
    Drawing("fig09", fig09, "model_curves"),
    Drawing("fig10", fig10, "model_curves"),
    Drawing("curves", curves, "curves"),
    Drawing("eqs11-13", eqs11_13, "coefficient_table"),
    Drawing("residuals", residuals, "residuals_drawn"),
    Drawing("identifiability", identifiability, "identifiability"),
    Drawing("coverage", coverage_map, "coverage_map"),
    Drawing("extrapolation", extrapolation, "extrapolation_panels"),
    Drawing("signs", sign_study, "sign_study"),
    Drawing("claims", claims_page, "claims_page"),
    Drawing("selection", selection_map, "selection_map"),
    Drawing("cage-slip", cage_slip, "cage_slip_map"),
    Drawing("size-effect", size_effect, "size_effect"),
    Drawing("power-loss", power_loss, "power_loss"),
)
FIGURES = {drawing.name: drawing for drawing in _ALL}

__all__ = ["FIGURES", "Drawing"]
