"""Every traction law with plausible constants, and tables of points whose truth it is."""

from collections.abc import Iterable
from itertools import product

import numpy as np
import pandas as pd

from campaigns import oil_of, printed, rig_contact
from fit_points import accepted_points
from oilfilm import tables
from oilfilm.base.randomness import generator
from oilfilm.base.units import FloatArray
from oilfilm.fits.fit import fit_law
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.table_needs import FIT_TABLES
from oilfilm.traction import laws_for
from oilfilm.traction.law import CONDITIONS, Law, Observations, to_internal

OIL, CONTACT = oil_of("4050"), rig_contact()
EVERY_LAW = laws_for(OIL, CONTACT)
SLIP = np.linspace(0, 0.3, 31)
LEVELS = (1.0, 1.15, 1.3, 1.5), (25.0, 30.0, 40.0), (25.0, 50.0, 85.0, 120.0)
MATRIX = pd.DataFrame(product(*LEVELS), columns=list(CONDITIONS))
MATRIX["load_n"] = CONTACT.load_n(MATRIX["max_hertz_pressure_gpa"].to_numpy())

# Plausible constants of each law: mu of some 0.03 with a peak or a level near S = 0.05. Those of a
# Wang-Deng law on load are those of the law of Deng et al., and constants of a coefficient D.
PLAUSIBLE_CONSTANTS: dict[str, list[float]] = {
    "deng2026": list(printed()["4050"]),
    # b = -X3/20 per K: A falls by 0.3 %, B by 3 % and C by 1 % per K
    "deng-exponential": [
        *(-0.030, 0.43, -0.47, -0.06),
        *(0.92, 1.80, -0.58, -0.60),
        *(27.0, 0.69, 0.01, -0.20),
    ],
    "wang-deng-load": [
        *(-0.030, 0.14, -0.47, -0.28),
        *(0.92, 0.60, -0.58, -1.31),
        *(27.0, 0.23, 0.01, -0.87),
        *(0.033, 0.15, -0.45, -0.25),
    ],
    "wang-deng-critical-load": [
        *(-0.015, 0.6, -0.47, -0.28),
        *(0.92, 0.60, -0.58, -1.31),
        *(27.0, 0.23, 0.01, -0.87),
        *(0.033, 0.15, -0.45, -0.25),
        *(3.0, -1, 0, 0),
    ],
    "wang-deng-groups": [
        *(-0.020, 0.15, 0.9, -0.6),
        *(0.06, 0.6, 2.6, -1.5),
        *(8.0, 0.2, 1.0, -0.5),
        *(0.021, 0.15, 0.85, -0.55),
    ],
    "eyring": [
        *(13.7, 3.0, 0.3, -1.9),
        *(0.01, -1, 0, 0),
        *(0.040, 0.5, -0.1, -0.3),
        *(66.0, 1.6, 0.6, -1.3),
    ],
    "circular": [*(8.0, 3.0, 0.5, -0.45), *(0.050, 0.6, -0.1, -0.08), *(300.0, 1.8, 0.7, -0.30)],
    "rational-viscosity": [*(1.5, 3.0, 0.6, 0.9), *(66.0, 2.6, 0.7, 0.7), *(0.5, 1.6, 0.5, 0.8)],
    "carreau": [
        *(6.0, 2.5, 0.3, -1.5),
        *(0.02, -1, 0, 0),
        *(0.4, 0, 0, 0),
        *(0.045, 0.4, -0.1, -0.2),
    ],
    "tanh": [*(0.030, 0.5, -0.3, -0.25), *(3.0, 1.5, -0.4, -1.2)],
}


def compare_laws(
    points: pd.DataFrame, oil: str, laws: Iterable[str], settings: Settings
) -> CampaignTables:
    """The tables of the fits of several laws to one oil, with the configured law marked."""
    fits = [fit_law(points, oil, law, settings) for law in laws]
    joined = {}
    for name in FIT_TABLES:
        filled = [fit.table(name) for fit in fits if len(fit.table(name))]
        joined[name] = pd.concat(filled or [tables.empty_table(name)], ignore_index=True)
    quality = joined["fit_quality"]
    quality["configured"] = quality["law"] == settings.fit.law
    return CampaignTables.from_frames(points=points, **joined)


def internal_of(law: Law) -> FloatArray:
    """Its plausible constants in the internal form of the law."""
    return to_internal(law, np.array(PLAUSIBLE_CONSTANTS[law.name]))


def observe(law: Law) -> Observations:
    """Observations of the law at every condition of `MATRIX` and every slip of `SLIP`."""
    curve = np.repeat(np.arange(len(MATRIX)), len(SLIP))
    design = law.design(MATRIX[list(law.conditions)].to_numpy())
    return Observations(design, curve, np.tile(SLIP, len(MATRIX)))


def points_of(law: Law, noise: float = 0.0) -> pd.DataFrame:
    """A table of points whose truth is the law."""
    mu = law.traction(internal_of(law), observe(law))
    return accepted_points("4050", MATRIX, SLIP, mu, noise, generator(17, "laws", law.name))
