"""The verdict on logs as text: the verdict and the advice first, then what was understood."""

import textwrap
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain

from oilfilm import tables
from oilfilm.cli.checked import CheckedColumn, CheckedLog, CheckedRun, Problem, Range
from oilfilm.errors import printable
from oilfilm.text_table import text_table

WIDTH = 100
# More runs of one log, and more logs at once, are shown in less detail.
_RUNS_LISTED = 10
_LOGS_IN_DETAIL = 10
# A longer cell of a table is cut.
_WIDEST_CELL = 22
# How the head of a table calls what is measured, and with how many digits it is shown.
_SHORT = {
    "max_hertz_pressure_gpa": ("P", ".3f"),
    "load_n": ("load", ".4g"),
    "entrainment_speed_m_s": ("U", ".4g"),
    "inlet_temperature_c": ("T", ".1f"),
    "slide_roll_ratio": ("S", ".3f"),
    "traction_coefficient": ("mu", ".4f"),
    "lambda_ratio": ("lambda", ".1f"),
    "axial_load_n": ("axial load", ".0f"),
    "inner_speed_rpm": ("speed", ".0f"),
    "oil_temperature_c": ("oil", ".1f"),
    "outer_ring_temperature_c": ("ring", ".1f"),
    "torque_n_m": ("torque", "#.3g"),
}


def report(logs: Sequence[CheckedLog]) -> str:
    """Everything that was found in some logs, at most `WIDTH` columns wide but for long names."""
    lines: list[str] = []
    brief = len(logs) > _LOGS_IN_DETAIL
    for log in logs:
        lines += _verdict(log)
        if not brief or log.verdict == "refused":
            lines += [*_understood(log), ""]
    if len(logs) > 1:
        lines.append(f"{len(logs)} logs: {_counted(log.verdict for log in logs)}")
        lines += [f"  {printable(log.file)}" for log in logs if log.verdict == "refused"]
        if brief:
            lines.append("Name a log alone to see how it was understood, or add --json.")
    return "\n".join(lines).rstrip()


def _verdict(log: CheckedLog) -> Iterator[str]:
    """The verdict on each run, with the reason and the advice right below it."""
    of_run: dict[str, list[Problem]] = defaultdict(list)
    shown = {run.run_id for run in log.runs}
    for problem in log.problems:
        of_run[problem.run_id if problem.run_id in shown else ""].append(problem)
    runs = sorted(log.runs, key=lambda run: run.verdict != "refused")
    if not runs:
        yield f"{printable(log.file)}: {log.verdict.upper()}"
    if len(runs) > _RUNS_LISTED:
        verdicts = _counted(run.verdict for run in runs)
        yield f"{printable(log.file)}: {len(runs)} runs: {verdicts}; --json shows all"
        rules = {(problem.run_id, problem.rule) for problem in chain(*of_run.values())}
        yield from _wrapped(_counted(rule for _, rule in rules), "  ")
        runs = [run for run in runs if run.run_id in of_run][:_RUNS_LISTED]
    for run in runs:
        yield (
            f"{printable(run.run_id)}: {run.verdict.upper()}, {run.accepted_plateaus} of "
            f"{run.plateaus} plateaus, {run.rows} rows"
        )
        yield from _sentences(of_run[run.run_id])
    yield from _sentences(of_run[""])


def _counted(names: Iterable[str]) -> str:
    """Each of some names with how often it comes, in their order."""
    return ", ".join(f"{count} {name}" for name, count in sorted(Counter(names).items()))


def _sentences(problems: Iterable[Problem]) -> Iterator[str]:
    for problem in problems:
        yield from _wrapped(printable(problem.found), "  ")
        if problem.advice:
            yield from _wrapped(f"-> {printable(problem.advice)}", "    ")


def _wrapped(text: str, indent: str) -> list[str]:
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=indent,
        subsequent_indent=f"{indent}  ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def _understood(log: CheckedLog) -> Iterator[str]:
    """How a log was understood: format, columns, conditions, gates that could not be applied."""
    form = [log.format]
    if log.encoding:
        form.append(f"{log.encoding}, delimiter {log.delimiter}, decimal {log.decimal_mark}")
    refused = f" ({log.refused_rows} refused)" if log.refused_rows else ""
    form.append(f"{log.rows} rows{refused}")
    read_as = f"Read as {log.rig_kind} log of campaign {log.campaign}: {', '.join(form)}"
    yield from _wrapped(read_as, "  ")
    if not log.runs:
        return
    rig = "rig" if log.rig_kind == "traction" else "bearing"
    oils = {f"{run.oil} ({run.oil_source})" for run in log.runs}
    rigs = {f"{run.rig} ({run.rig_source})" for run in log.runs}
    yield f"  Oil {', '.join(sorted(oils))}; {rig} {', '.join(sorted(rigs))}"
    yield ""
    yield from _columns(log.runs)
    yield ""
    yield from _conditions(log)
    yield from _gates_not_applied(log.runs)


def _columns(runs: Sequence[CheckedRun]) -> Iterator[str]:
    """Each column of a log with its range over all runs."""
    columns: dict[tuple[str, str], list[CheckedColumn]] = defaultdict(list)
    for column in chain.from_iterable(run.columns for run in runs):
        columns[column.name, column.unit].append(column)
    head = ("Column", "Unit", "Read as", "Unit", "Smallest", "Largest", "Numbers", "Missing")
    rows = [
        (
            same[0].name,
            same[0].logged_unit,
            same[0].quantity,
            same[0].unit,
            *([f"{ends[0]:.5g}", f"{ends[-1]:.5g}"] if (ends := _ends(same)) else "--"),
            str(sum(column.count for column in same)),
            str(sum(column.missing for column in same)),
        )
        for same in columns.values()
    ]
    yield from text_table([head, *rows], right=4, most=_WIDEST_CELL, indent="  ", gap=" ")
    unused = dict.fromkeys(name for run in runs for name in run.unused_columns)
    if unused:
        yield from _wrapped(f"Not read: {', '.join(map(printable, unused))}", "  ")


def _ends(ranges: Iterable[Range]) -> list[float]:
    """The known ends of ranges, the smallest first."""
    ends = chain.from_iterable((each.minimum, each.maximum) for each in ranges)
    return sorted(end for end in ends if end is not None)


def _conditions(log: CheckedLog) -> Iterator[str]:
    """Operating conditions and traction of each run, its set points below."""
    names = list(log.runs[0].measured)
    units = [tables.COLUMNS[name].shown_unit for name in names]
    heads = [
        f"{_SHORT[name][0]} ({unit})" if unit else _SHORT[name][0]
        for name, unit in zip(names, units, strict=True)
    ]
    rows = [["Plateaus", *heads]]
    groups = [log.runs] if len(log.runs) > _RUNS_LISTED else [[run] for run in log.runs]
    for runs in groups:
        label = runs[0].run_id.removeprefix(log.file).strip(":") or "measured"
        measured = {name: _ends(run.measured[name] for run in runs) for name in names}
        points = [(name, point) for run in runs for name, point in run.set_points.items() if point]
        set_points: dict[str, list[float]] = defaultdict(list)
        sources: dict[str, set[str]] = defaultdict(set)
        for name, point in points:
            set_points[name].append(point.value)
            sources[name].add(point.source)
        rows.append([label if len(runs) == 1 else f"{len(runs)} runs", *_spans(measured, names)])
        if points:
            rows.append(["set point", *_spans(set_points, names)])
            rows.append(["from", *(", ".join(sorted(sources[name])) or "-" for name in names)])
    yield from text_table(rows, right=len(names), most=_WIDEST_CELL, indent="  ", gap=" ")


def _spans(values: dict[str, list[float]], names: Iterable[str]) -> Iterator[str]:
    """The range of each quantity with its own digits."""
    for name in names:
        # no minus before a zero
        ends = [f"{end:z{_SHORT[name][1]}}" for end in sorted(values[name])] or ["-"]
        yield ends[0] if ends[0] == ends[-1] else f"{ends[0]}..{ends[-1]}"


def _gates_not_applied(runs: Sequence[CheckedRun]) -> Iterator[str]:
    """The gates that could not be applied to all runs or to some, by what they lack."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for lacking in chain.from_iterable(run.gates_not_applied for run in runs):
        counts[lacking.reason][lacking.gate] += 1
    if counts:
        yield ""
        yield "  Gates that could not be applied"
    for reason, gates in counts.items():
        names = [
            gate if count == len(runs) else f"{gate} ({count} of {len(runs)} runs)"
            for gate, count in gates.items()
        ]
        yield from _wrapped(f"{', '.join(names)}: {reason}", "    ")
