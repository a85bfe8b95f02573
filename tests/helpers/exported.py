"""Descriptions of oils whose constants are planted, for the tests of exports."""

import numpy as np
import pandas as pd

from law_points import EVERY_LAW, PLAUSIBLE_CONSTANTS
from oilfilm.exports.description import SLIP, Description, describe
from oilfilm.fits.conditions import FixedCondition, fixed_conditions_to_json
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS, Law
from planted_fits import planted_tables

# Ends of the tested box: P in GPa, U in m/s and T in degC.
LOWER, UPPER = np.array([1.0, 25.0, 25.0]), np.array([1.5, 40.0, 120.0])
LOAD_AT_1_GPA = 42.0  # N, of the 20 mm ball
# Names of oils that would end a comment, a string or an identifier.
HOSTILE = [
    *("*/ int x; /*", "two\nlines\r\nend module", "\" quote ' and \\", "%{\n%}\nsystem('true')"),
    *("trigraph ??/", '</pre></html>"; end Traction;', "=1+1", "\N{LINE SEPARATOR}\u00e9\u6cb9"),
    *("", "9" * 300),
]


def tables_of(
    law: Law, oils: list[str], values: dict[str, float], unknown: tuple[str, ...] = ()
) -> CampaignTables:
    """Points, coefficients and quality of oils whose constants are planted."""
    corners = pd.DataFrame([LOWER, UPPER], columns=list(CONDITIONS))
    corners["load_n"] = LOAD_AT_1_GPA * corners["max_hertz_pressure_gpa"] ** 3
    points = corners.assign(run_id=["a", "b"], accepted=True)
    wild = points.assign(max_hertz_pressure_gpa=9.0, accepted=False)
    names = [constant.name for constant in law.constants if constant.prescribed is None]
    constants = dict.fromkeys(names, np.nan) | values
    fixed = [
        FixedCondition(name, None if name in unknown else corners[name].mean(), 0.02)
        for name in law.conditions
        if name in law.groups and not _has_exponents(law, name, values)
    ]
    quality = {
        **{"n_points": 62, "n_curves": 2, "rmse": 1e-4, "max_error": 5e-4},
        **{
            "searches": 5,
            "searches_agreeing": 5,
            "fixed_conditions": fixed_conditions_to_json(fixed),
        },
        "tested_min_slide_roll_ratio": 0.002,
        **corners.min().add_prefix("tested_min_"),
        **corners.max().add_prefix("tested_max_"),
    }
    coefficients, quality_table = planted_tables(law, dict.fromkeys(oils, constants), **quality)
    value = coefficients["value"]
    errors = {"standard_error": value.abs() / 100, "lower": value - 0.01, "upper": value + 0.01}
    return CampaignTables.from_frames(
        points=pd.concat([frame.assign(oil=oil) for oil in oils for frame in (points, wild)]),
        coefficients=coefficients.assign(**errors),
        fit_quality=quality_table,
    )


def _has_exponents(law: Law, group: str, values: dict[str, float]) -> bool:
    names = [constant.name for constant in law.constants if constant.group == group]
    return any(not np.isnan(values.get(name, np.nan)) for name in names)


def describe_law(config: Settings, name: str, left_out: int | None = None) -> Description:
    """A law with plausible constants; the exponents of one of its groups left out."""
    law = EVERY_LAW[name]
    planted = {}
    for constant, value in zip(law.constants, PLAUSIBLE_CONSTANTS[name], strict=True):
        if constant.prescribed is not None:
            continue
        planted[constant.name] = value
        if left_out is not None and constant.group in (None, law.groups[left_out]):
            planted[constant.name] = np.nan
        if left_out is not None and constant.group is None:
            planted[constant.name[:-1]] = value * 0.9
    return describe(tables_of(law, ["4050"], planted), "4050", "4050", law, config)


def grid() -> pd.DataFrame:
    """P, U, T, W and S within and far beyond the tested box, both signs of S and 0."""
    axes = ([0.8, 1.0, 1.37, 2.5], [1.0, 25.0, 33.0, 200.0], [5.0, 25.0, 99.0, 140.0])
    slips = [-1.0, -0.3, -0.017, 0.0, 1e-3, 0.05, 0.21, 0.31]
    columns = np.meshgrid(*axes, slips)
    names = (*CONDITIONS, SLIP)
    rows = pd.DataFrame({name: axis.ravel() for name, axis in zip(names, columns, strict=True)})
    return rows.assign(load_n=LOAD_AT_1_GPA * rows["max_hertz_pressure_gpa"] ** 3)


def arguments_of(fit: Description, rows: pd.DataFrame) -> np.ndarray:
    """Columns that the exported functions take: the law's groups that it follows, and S."""
    groups = fit.law.group_values(rows[list(fit.law.conditions)].to_numpy())
    return np.column_stack(
        [groups[:, fit.law_with_constants.coefficients.group_has_exponent], rows[SLIP]]
    )


def expected(fit: Description, rows: pd.DataFrame) -> np.ndarray:
    """mu by the library's own prediction, not by anything of the exports."""
    coefficients = fit.law_with_constants.coefficients
    fixed = [fixed_condition.condition for fixed_condition in coefficients.fixed_conditions]
    conditions = rows.assign(**dict.fromkeys(fixed, np.nan))[list(fit.law.conditions)].to_numpy()
    return fit.law_with_constants.predict(conditions, rows[SLIP].to_numpy()).traction_coefficient


def beyond(fit: Description, arguments: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """Outside the tested box, or above the limiting shear stress of 0.12 of the pressure."""
    inside = (np.abs(arguments[:, -1]) <= 0.3) & (np.abs(mu) <= 0.12)
    for condition, column in zip(fit.arguments, arguments.T[:-1], strict=True):
        lower, upper = condition.tested
        inside &= (column >= lower) & (column <= upper)
    return ~inside
