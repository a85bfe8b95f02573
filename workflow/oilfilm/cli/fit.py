"""The command `oilfilm fit`: a law fitted to a table of mu."""

import argparse
from collections.abc import Iterator

import oilfilm
from oilfilm.api.arrays import ArrayFit
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.cli.arguments import quantity, typed_conditions


def run(options: argparse.Namespace) -> int:
    """Run the command; exit code 1 where nothing could be fitted."""
    radius = options.ball_radius
    if options.save is not None and options.save.exists():
        raise OilfilmError(f"{options.save}: exists already. Name a new folder with --save.")
    fit = oilfilm.fit_table(
        options.table,
        ball_radius_m=None if radius is None else quantity(radius, "m", "--ball-radius"),
        materials=options.materials,
        law=options.law,
        oil=options.oil,
        at=typed_conditions(options),
        columns=options.columns,
    )
    print("\n".join(map(printable, _lines(fit))))
    if options.plot:
        fit.plot().figure.savefig(options.plot)
        print(f"Written: {printable(options.plot)}")
    if options.save:
        fit.save(options.save)
        print(f"Written: {printable(options.save)}: tables, exports, summary.txt, report.html")
        print(f"Then: oilfilm predict --results {options.save} --oil {fit.oil} --help")
    return int(fit.constants["value"].isna().all())


def _lines(fit: ArrayFit) -> Iterator[str]:
    n_curves = fit.points["run_id"].nunique()
    yield f"{fit.source}: {len(fit.points)} points in {n_curves} curves"
    for note in fit.notes:
        yield f"  {note}"
    yield f"mu = {fit.law.law.equation}"
    yield from repr(fit).splitlines()
