"""What is said of laws and of steadiness where no law fits, by the code that fits a user's data.

    python benchmarks/verdicts.py          (all compared laws on 24 runs of each truth)
    python benchmarks/verdicts.py steady   (the heated film of `thermal`, oil 4102, nothing planted)

Printed for each truth: the law on which the surface stands, its misfit, the scatter of runs, and
whether the verdict is that no law fits. Of the truths only `own` has a law that fits. `steady`
names 72 runs in the order of their conditions and in three random orders, and prints the verdict on
the campaign with what is named.

Takes 4 minutes; `steady` takes 1.
"""

import sys

import numpy as np
import pandas as pd
from coverage import conditions_of, truth_of
from threadpoolctl import threadpool_limits

from oilfilm import tables
from oilfilm.base.randomness import generator
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.soundness import soundness_row
from oilfilm.fits.surface_search import surface_tables_of_oil, with_surface
from oilfilm.settings.resolve import resolve
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.table_needs import FIT_TABLES
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS

# `coverage` has put the folder of helpers of the tests on the path
from coverage import ROOT  # isort: skip
from fit_points import accepted_points
from lawless_truths import TRUTHS
from simulated_points import PointCampaign
from surface_campaigns import SLIPS, latin, simulated

OIL = "4102"
RANDOM_ORDERS = 3


def points_of(truth: str) -> pd.DataFrame:
    """24 runs of a truth, as a table of accepted points."""
    random = generator(23, "verdicts", truth)
    measured = simulated(TRUTHS[truth], latin(), random)
    conditions = pd.DataFrame(measured.conditions, columns=list(CONDITIONS))
    conditions = conditions.assign(load_n=80.0 * conditions[CONDITIONS[0]] ** 3)
    return accepted_points(OIL, conditions, SLIPS, measured.mu, 0.0, random).assign(
        traction_coefficient_se=np.nan
    )


def check_laws() -> None:
    """Print the verdict on laws, one truth per row."""
    settings = resolve(ROOT / "config", {"campaign": "demo"})
    quick = settings.fit.model_copy(update={"searches": 2, "bootstrap": 100})
    print("truth            law                      misfit  runs   none fits")
    for truth in TRUTHS:
        points = points_of(truth)
        names = [name for name in settings.compare.laws if name in LAWS]
        fits = [fit_oil(points, OIL, quick, 1, LAWS[name]) for name in names]
        frames = {name: pd.concat([fit.table(name) for fit in fits]) for name in FIT_TABLES}
        quality = frames["fit_quality"]
        frames["fit_quality"] = quality.assign(configured=quality["law"] == settings.fit.law)
        results = CampaignTables.from_frames(points=points, **frames)
        found = surface_tables_of_oil(results, OIL, settings, {})
        (row,) = tables.rows(found.surfaces)
        print(
            f"{truth:16s} {row['law']:24s} {row['misfit']:6.1%} {row['run_scatter']:6.1%} "
            f"{row['no_law_fits']}",
            flush=True,
        )


def check_steady() -> None:
    """Print the verdict on a campaign of the heated film, by the order of the names of its runs."""
    settings = resolve(ROOT / "config", {"campaign": "demo"})
    quick = settings.fit.model_copy(update={"searches": 2, "bootstrap": 100})
    campaign = PointCampaign(truth_of("heated film", OIL), settings.common_contact())
    for order in range(RANDOM_ORDERS + 1):
        random = generator(23, "steady film", str(order))
        points = campaign.points(conditions_of(72), random, OIL)
        if order > 0:
            names = points["run_id"].unique()
            points["run_id"] = points["run_id"].map(
                dict(zip(names, random.permutation(names), strict=True))
            )
        fit = fit_oil(points, OIL, quick, 1).replace(points=points)
        fit = with_surface(fit, OIL, settings)
        (quality,) = tables.rows(fit.fit_quality)
        verdict = soundness_row(quality, FittedLaw.from_results(fit, OIL), points, settings)
        said = {name: verdict[name] for name in ("law_verdict", "campaign_verdict", "change")}
        print("random order" if order else "order of the conditions", said, flush=True)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        if sys.argv[1:] == ["steady"]:
            check_steady()
        elif not sys.argv[1:]:
            check_laws()
        else:
            raise SystemExit(__doc__)
