"""What every law misses on a campaign, within the box and at end temperatures, and what it costs.

Fits all laws to the accepted points of a finished campaign, whatever its `compare.laws`. Printed
for each law: its constants; by oil the rms error relative to mu, in % where it was fitted and at
the lowest and highest levels of temperature, each left out of the fit; the searches that agree; and
the CPU time. The truth of `thermal` is no law, that of `demo` is deng2026.

    snakemake --config campaign=thermal
    python benchmarks/laws.py [campaign ...]

Takes 2 minutes for each campaign.
"""

import os
import sys
import time
from pathlib import Path

# As Snakemake does for its jobs.
os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"

ROOT = Path(__file__).parents[1]

from oilfilm import tables  # noqa: E402
from oilfilm.fits.fit import fit_law  # noqa: E402
from oilfilm.settings.resolve import resolve  # noqa: E402
from oilfilm.traction import LAW_NAMES  # noqa: E402


def main(*campaigns: str) -> None:
    """Print a row per campaign and law."""
    print("campaign  law                      constants  fitted %  T ends out %  agree  CPU s")
    for campaign in campaigns:
        settings = resolve(ROOT / "config", {"campaign": campaign})
        path = ROOT / f"results/{campaign}/tables/points.parquet"
        points = tables.read("points", path)
        for law in LAW_NAMES:
            fitted, at_ends, agreeing = [], [], []
            start = time.process_time()
            for oil in settings.campaign.oils:
                (quality,) = tables.rows(fit_law(points, oil, law, settings).fit_quality)
                constants = quality["n_constants"]
                fitted.append(f"{100 * quality['relative_rms']:.1f}")
                at_ends.append(f"{100 * quality['temperature_end_out_relative_rms']:.1f}")
                agreeing.append(f"{quality['searches_agreeing']}/{quality['searches']}")
            seconds = time.process_time() - start
            print(
                f"{campaign:9s} {law:24s} {constants:9d}  {' '.join(fitted)}  {' '.join(at_ends)}  "
                f"{' '.join(agreeing)}  {seconds:.1f}",
                flush=True,
            )


if __name__ == "__main__":
    main(*(sys.argv[1:] or ("thermal", "demo")))
