"""The verdict on logs as text: the verdict and the advice first, then what was understood."""

import textwrap
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from math import isnan

import pandas as pd

from oilfilm.cli.checked import Plain, Problem, problems
from oilfilm.errors import printable
from oilfilm.text_table import text_table

WIDTH = 100
# More runs of one log, and more logs at once, are shown in less detail.
_RUNS_LISTED = 10
_LOGS_IN_DETAIL = 10
# A longer cell of a table is cut.
_WIDEST_CELL = 22
_COLUMNS = ["Column", "Unit", "Read as", "Unit", "Smallest", "Largest", "Numbers", "Missing"]


def report(logs: Sequence[Plain]) -> str:
    """Everything that was found in some logs, at most `WIDTH` columns wide but for long names."""
    lines: list[str] = []
    brief = len(logs) > _LOGS_IN_DETAIL
    for log in logs:
        lines += _verdict(log)
        if not brief or log["verdict"] == "refused":
            lines += [*_understood(log), ""]
    if len(logs) > 1:
        lines.append(f"{len(logs)} logs: {_counted(log['verdict'] for log in logs)}")
        lines += [f"  {printable(log['file'])}" for log in logs if log["verdict"] == "refused"]
        if brief:
            lines.append("Name a log alone to see how it was understood, or add --json.")
    return "\n".join(lines).rstrip()


def _verdict(log: Plain) -> Iterator[str]:
    """The verdict on each run, with the reason and the advice right below it."""
    runs, file = log["runs"], printable(log["file"])
    of_run: dict[str, list[Problem]] = {run["run_id"]: [] for run in runs}
    of_file: list[Problem] = []
    for problem in problems(log):
        of_run.get(problem.run_id, of_file).append(problem)
    if not runs:
        yield f"{file}: {log['verdict'].upper()}"
    if len(runs) > _RUNS_LISTED:
        verdicts = _counted(run["verdict"] for run in runs)
        yield f"{file}: {len(runs)} runs: {verdicts}; --json shows all"
        runs = [run for run in runs if of_run[run["run_id"]]]
    for run in sorted(runs, key=lambda run: run["verdict"] != "refused")[:_RUNS_LISTED]:
        plateaus = f"{run['accepted_plateaus']} of {run['plateaus']} plateaus"
        verdict = run["verdict"].upper()
        yield f"{printable(run['run_id'])}: {verdict}, {plateaus}, {run['rows']} rows"
        yield from _sentences(of_run[run["run_id"]])
    yield from _sentences(of_file)


def _counted(names: Iterable[str]) -> str:
    """Each of some names with how often it comes, in their order."""
    return ", ".join(f"{count} {name}" for name, count in sorted(Counter(names).items()))


def _sentences(found: Iterable[Problem]) -> Iterator[str]:
    for problem in found:
        yield from _wrapped(printable(problem.found), "  ")
        if problem.advice:
            yield from _wrapped(f"-> {printable(problem.advice)}", "    ")


def _wrapped(text: str, indent: str) -> list[str]:
    wrapper = textwrap.TextWrapper(WIDTH, indent, f"{indent}  ")
    wrapper.break_long_words = wrapper.break_on_hyphens = False
    return wrapper.wrap(text)


def _understood(log: Plain) -> Iterator[str]:
    """How a log was understood: format, columns, conditions, gates that could not be applied."""
    form = [log["format"]]
    if log["encoding"]:
        form += [log["encoding"], f"delimiter {log['delimiter']}", f"decimal {log['decimal_mark']}"]
    refused = f" ({log['refused_rows']} refused)" if log["refused_rows"] else ""
    read_as = f"Read as {log['rig_kind']} log of campaign {log['campaign']}: {', '.join(form)}"
    yield from _wrapped(f"{read_as}, {log['rows']} rows{refused}", "  ")
    runs = log["runs"]
    if not runs:
        return
    rig = "rig" if log["rig_kind"] == "traction" else "bearing"
    oils = sorted({f"{run['oil']} ({run['oil_source']})" for run in runs})
    rigs = sorted({f"{run['rig']} ({run['rig_source']})" for run in runs})
    yield f"  Oil {', '.join(oils)}; {rig} {', '.join(rigs)}"
    yield from ("", *_columns(runs), *_conditions(log), *_gates_not_applied(runs))


def _columns(runs: Sequence[Plain]) -> Iterator[str]:
    """Each column of a log with its range over all runs."""
    every = pd.DataFrame([column for run in runs for column in run["columns"]])
    if len(every):
        by = ["name", "logged_unit", "quantity", "unit"]
        found = every.groupby(by, sort=False, as_index=False).agg(
            {"minimum": "min", "maximum": "max", "count": "sum", "missing": "sum"}
        )
        for end in ("minimum", "maximum"):
            found[end] = ["-" if pd.isna(value) else f"{value:.5g}" for value in found[end]]
        rows = found.astype(str).to_numpy().tolist()
        yield from text_table([_COLUMNS, *rows], right=4, most=_WIDEST_CELL, indent="  ", gap=" ")
    unused = dict.fromkeys(name for run in runs for name in run["unused_columns"])
    if unused:
        yield from _wrapped(f"Not read: {', '.join(map(printable, unused))}", "  ")


def _conditions(log: Plain) -> Iterator[str]:
    """Operating conditions and traction of each run, or of many runs together."""
    runs = log["runs"]
    together = len(runs) > _RUNS_LISTED
    for group in [runs] if together else [[run] for run in runs]:
        rows = []
        for name in runs[0]["measured"]:
            ends = [end for run in group for end in run["measured"][name].values()]
            points = [point for run in group if (point := run["set_points"].get(name))]
            sources = ", ".join(sorted({point["source"] for point in points}))
            set_point = _span([point["value"] for point in points], measured=False)
            rows.append([name, _span(ends), f"{set_point} ({sources})" if points else "-"])
        label = group[0]["run_id"].removeprefix(log["file"]).strip(":") or "Plateaus"
        head = [f"{len(runs)} runs" if together else label, "Measured", "Set point"]
        yield from ("", *text_table([head, *rows], right=2, indent="  "))


def _span(values: Sequence[float], *, measured: bool = True) -> str:
    """The range of some numbers; small ones that were measured with a fixed count of decimals."""
    known = sorted(value for value in values if not isnan(value))
    if not known:
        return "-"
    # no minus before a zero
    form = "z.4f" if measured and max(map(abs, known)) < 10 else ".4g"
    lowest, highest = (f"{known[end]:{form}}" for end in (0, -1))
    return lowest if lowest == highest else f"{lowest}..{highest}"


def _gates_not_applied(runs: Sequence[Plain]) -> Iterator[str]:
    """The gates that could not be applied to all runs or to some, by what they lack."""
    of_reason: dict[str, dict[str, None]] = {}
    for lacking in chain.from_iterable(run["gates_not_applied"] for run in runs):
        of_reason.setdefault(lacking["reason"], {})[lacking["gate"]] = None
    if of_reason:
        yield from ("", "  Gates that could not be applied")
    for reason, gates in of_reason.items():
        yield from _wrapped(f"{', '.join(gates)}: {reason}", "    ")
