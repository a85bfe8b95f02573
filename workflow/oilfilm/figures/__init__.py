"""One function a figure: finished tables in, a matplotlib Figure and exactly what it draws out."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from oilfilm.figures.claims_page import claims_page
from oilfilm.figures.coefficients import eqs11_13
from oilfilm.figures.coverage_map import coverage_map
from oilfilm.figures.extrapolation import extrapolation
from oilfilm.figures.selection_map import selection_map
from oilfilm.figures.sign_study import sign_study
from oilfilm.figures.traction_curves import Results, curves, fig02, fig03


@dataclass(frozen=True)
class Drawing:
    """How a figure is drawn, and the table model of what it draws."""

    draw: Callable[[Results, Mapping[str, Any]], tuple[Figure, pd.DataFrame]]
    table: str


FIGURES = {
    "fig02": Drawing(fig02, "curves"),
    "fig03": Drawing(fig03, "curves"),
    "curves": Drawing(curves, "curves"),
    "eqs11-13": Drawing(eqs11_13, "coefficient_table"),
    "coverage": Drawing(coverage_map, "coverage_map"),
    "extrapolation": Drawing(extrapolation, "extrapolation_panels"),
    "signs": Drawing(sign_study, "sign_study"),
    "claims": Drawing(claims_page, "claims_page"),
    "selection": Drawing(selection_map, "selection_map"),
}
