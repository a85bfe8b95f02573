"""The command `oilfilm fit`: a law fitted to a table of mu."""

import argparse
import shlex
from collections.abc import Iterator
from pathlib import Path

import oilfilm
from oilfilm.api.arrays import ArrayFit
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.cli.arguments import typed_conditions, typed_quantity
from oilfilm.cli.parser import CONDITION_OPTIONS
from oilfilm.cli.plot_file import refuse_plot, write_plot
from oilfilm.fits.fitted import SLIP
from oilfilm.traction.law import QUANTITIES


def run(options: argparse.Namespace) -> int:
    """Run the command; exit code 1 where nothing could be fitted.

    Args:
        options: What `parser.py` declares for `fit`. `oil` selects one oil of a table that has
            several; else it names the oil.
    """
    # before anything is computed: a plot that could not be written
    refuse_plot(options.plot)
    if options.save is not None and options.save.exists():
        raise OilfilmError(f"{options.save}: exists already. Name a new folder with --save.")
    ball_radius_m = None
    if options.ball_radius is not None:
        ball_radius_m = typed_quantity(options.ball_radius, "m", "--ball-radius")
    fit = oilfilm.fit_table(
        options.table,
        ball_radius_m=ball_radius_m,
        materials=options.materials,
        law=options.law,
        oil=options.oil,
        # column -> value in its unit: the conditions that all rows have
        at=typed_conditions(options),
        # a text on what columns mean
        columns=options.columns,
        simulated=options.simulated,
    )
    is_fitted = bool(fit.constants["value"].notna().any())
    print("\n".join(map(printable, _summary_lines(fit))))
    if options.plot:
        write_plot(fit.plot().figure, options.plot)
        print(f"Written: {printable(options.plot)}")
    if options.save:
        fit.save(options.save)
        print(f"Written: {printable(options.save)}: tables, exports, summary.txt, report.html")
        if is_fitted:
            print(f"Then, as an example: {_predict_command(fit, options.save)}")
    return 0 if is_fitted else 1


def _predict_command(fit: ArrayFit, folder: Path) -> str:
    """The command that predicts mu of a saved fit in the middle of its tested conditions."""
    words = ["oilfilm", "predict", "--results", str(folder), "--oil", fit.oil]
    # `fit.law` is the fitted law, its `law` the form
    conditions = fit.law.law.conditions
    for option, (condition, _, _) in CONDITION_OPTIONS.items():
        if condition in conditions:
            words += [option, f"{fit.points[condition].median():.3g}{QUANTITIES[condition].unit}"]
    words += ["--slip", f"{fit.points[SLIP].median():.2g}"]
    return shlex.join(words)


def _summary_lines(fit: ArrayFit) -> Iterator[str]:
    """What was read, how it was understood, and the summary of the fit."""
    curve_count = fit.points["run_id"].nunique()
    yield f"{fit.source}: {len(fit.points)} points in {curve_count} curves"
    for note in fit.notes:
        yield f"  {note}"
    yield from fit.summary().splitlines()
