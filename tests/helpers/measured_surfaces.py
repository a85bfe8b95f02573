"""Fits that read the surface of their points, without tables of a campaign."""

from dataclasses import replace
from functools import partial

import pandas as pd

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw, given_surface
from oilfilm.fits.measured_surface import (
    LawConstants,
    MeasuredContact,
    free_law,
    surface_from_tables,
    usable_measurements,
)
from oilfilm.fits.run_assumptions import RunAssumptions
from oilfilm.fits.surface_search import searched_surface_tables
from oilfilm.settings.config import SurfaceSettings


def with_measured_surface(
    fitted: FittedLaw, points: pd.DataFrame, settings: SurfaceSettings, oil: str = "4050"
) -> FittedLaw:
    """The fit with the surface of some points about its law; the fit alone if they are too few."""
    constants = fitted.coefficients.constants
    has_exponent = fitted.coefficients.group_has_exponent
    contact = MeasuredContact.from_points(points[points["accepted"]])
    law = free_law(fitted.law, constants, has_exponent, contact)
    runs, measurements = usable_measurements(points, law, contact, RunAssumptions())
    if len(runs) < settings.fewest_curves:
        return fitted
    found = searched_surface_tables(
        oil, fitted.law.name, law, measurements, settings, RunAssumptions()
    )
    (row,) = tables.rows(found.surfaces)
    fit = LawConstants(fitted.law, constants, has_exponent)
    surface = surface_from_tables(row, found.surface_sizes, points, fit)
    return replace(fitted, read_surface=partial(given_surface, surface))
