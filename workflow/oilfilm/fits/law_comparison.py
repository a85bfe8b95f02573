"""Fits of every law to the same points by the same engine, judged by points not seen."""

from collections.abc import Iterable, Mapping

import pandas as pd

from oilfilm import tables
from oilfilm.fits.fit import OilFit, fit_oil
from oilfilm.fits.fit_tables import tables_without_fit
from oilfilm.settings.resolved import Settings
from oilfilm.table_needs import OF_FIT
from oilfilm.traction import LAWS, laws_for
from oilfilm.traction.law import Law

# Why the laws' comparison says nothing of Wang-Deng where the paper's law made the points.
TIE = (
    "a tie by construction: Eq. 7 made the SIMULATED points, and for one ball size load-based "
    "Wang-Deng with D = -A is Eq. 7. Dimensionless Wang-Deng is another law. It is at a "
    "disadvantage, because Eq. 7 made the points"
)


def fit_law(
    points: pd.DataFrame,
    oil: str,
    name: str,
    settings: Settings,
) -> OilFit:
    """Fit one law to one oil's accepted points, and judge it by curves left out of the fit.

    Points, settings, seeds and the curves that are left out are the same for every law.

    Args:
        points: Table of points.
        oil: Oil to fit.
        name: The law.
        settings: `compare`, `fit` and `seed`; for a law that needs properties of the oil and the
            contact, `oils` and `rigs` as well.

    Returns:
        The tables of the fit. Data that cannot be fitted, or a law that needs unknown properties,
        give rows without values, with the reason.
    """
    law = LAWS[name] if name in LAWS else laws_of(oil, settings).get(name)
    if law is None:
        return _without_properties(oil, name)
    return fit_oil(points, oil, settings.fit, settings.seed, law)


def compare_laws(
    points: pd.DataFrame, oil: str, laws: Iterable[str], settings: Settings
) -> dict[str, pd.DataFrame]:
    """The tables of the fits of several laws to one oil, as of `fit_law`, by their names."""
    return joined([fit_law(points, oil, law, settings).tables for law in laws], settings.fit.law)


def joined(fits: Iterable[Mapping[str, pd.DataFrame]], configured: str) -> dict[str, pd.DataFrame]:
    """The tables of several fits, with the configured law marked."""
    frames = list(fits)
    together = {
        name: pd.concat([tables.empty(name), *filled], ignore_index=True)
        if (filled := [each[name] for each in frames if len(each[name])])
        else tables.empty(name)
        for name in OF_FIT
    }
    quality = together["fit_quality"]
    quality["configured"] = quality["law"] == configured
    return together


def laws_of(oil: str, settings: Settings) -> dict[str, Law]:
    """Every law whose needs an oil of a campaign and its rigs meet, by name."""
    return laws_for(settings.properties_of(oil), settings.common_contact())


def _without_properties(oil: str, law: str) -> OilFit:
    quality = {"oil": oil, "law": law, "configured": True}
    reason = "the law needs the oil's properties and one known contact (config)"
    return OilFit(tables_without_fit([], quality, reason), None)
