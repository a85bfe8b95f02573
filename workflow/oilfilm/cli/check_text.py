"""The verdict on logs as text: the verdict and the advice first, then what was understood."""

import textwrap
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from oilfilm import tables
from oilfilm.cli.checked import CheckedColumn, CheckedLog, CheckedRun, Range
from oilfilm.errors import printable

WIDTH = 100
# More runs of one log, and more logs at once, are shown in less detail.
_RUNS_LISTED = 10
_LOGS_IN_DETAIL = 10
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
Row = Sequence[str]


def report(logs: Sequence[CheckedLog]) -> str:
    """Everything that was found in some logs, at most `WIDTH` columns wide but for long names."""
    lines: list[str] = []
    brief = len(logs) > _LOGS_IN_DETAIL
    for log in logs:
        lines += _verdict(log)
        if not brief or log.verdict == "refused":
            lines += [*_understood(log), ""]
    if len(logs) > 1:
        refused = [log.file for log in logs if log.verdict == "refused"]
        lines.append(f"{len(logs)} logs: {_counted(log.verdict for log in logs)}")
        lines += [f"  {printable(file)}" for file in refused]
        if brief:
            lines.append("Name a log alone to see how it was understood, or add --json.")
    return "\n".join(lines).rstrip()


def _verdict(log: CheckedLog) -> Iterator[str]:
    """The verdict on each run, with the reason and the advice right below it."""
    if log.without_row:
        problem, advice = log.without_row
        yield printable(f"{log.file}: {problem}")
        yield from _wrapped(f"-> {advice}", "    ")
    if not log.runs:
        yield f"{printable(log.file)}: {log.verdict.upper()}"
    accepted = [run for run in log.runs if run.verdict == "accepted"]
    clean = [run for run in accepted if run.accepted_plateaus == run.plateaus and not run.warning]
    listed = log.runs
    if len(clean) > _RUNS_LISTED:
        plateaus = sum(run.plateaus for run in clean)
        yield f"{printable(log.file)}: {len(clean)} runs ACCEPTED with all {plateaus} plateaus"
        listed = [run for run in log.runs if run not in clean]
    listed = sorted(listed, key=lambda run: run.verdict != "refused")
    for run in listed[:_RUNS_LISTED]:
        yield from _verdict_on_run(log, run)
    if more := listed[_RUNS_LISTED:]:
        yield f"{printable(log.file)}: {len(more)} more runs, not shown here; --json shows all"
        rules = _counted(rule for run in more for rule in _rules(log, run))
        yield from _wrapped(rules, "  ")
    if len(log.runs) > _RUNS_LISTED:
        verdicts = _counted(run.verdict for run in log.runs)
        yield f"{printable(log.file)}: {len(log.runs)} runs: {verdicts}"
    shown = {run.run_id for run in log.runs}
    for refused in log.refusals:
        if refused.run_id not in shown:
            where = f"{refused.run_id}: " if refused.run_id else ""
            yield from _sentence(f"{where}{refused.rule}: {refused.reason}", refused.advice)


def _verdict_on_run(log: CheckedLog, run: CheckedRun) -> Iterator[str]:
    yield (
        f"{printable(run.run_id)}: {run.verdict.upper()}, {run.accepted_plateaus} of "
        f"{run.plateaus} plateaus, {run.rows} rows"
    )
    if run.warning:
        yield f"  WARNING: {printable(run.warning)}"
    of_run = [refused for refused in log.refusals if refused.run_id == run.run_id]
    for refused in of_run:
        yield from _sentence(f"{refused.rule}: {refused.reason}", refused.advice)
    explained = {refused.rule for refused in of_run}
    for gate in run.failed_gates:
        if gate.gate not in explained:
            count = f"{gate.plateaus} plateau{'' if gate.plateaus == 1 else 's'}"
            found = f"{gate.gate}: {count}, first at row {gate.first_row}"
            yield from _sentence(found, gate.advice)


def _rules(log: CheckedLog, run: CheckedRun) -> set[str]:
    """Every rule that refused a run or some of its plateaus."""
    of_run = {refused.rule for refused in log.refusals if refused.run_id == run.run_id}
    return of_run | {gate.gate for gate in run.failed_gates}


def _counted(names: Iterable[str]) -> str:
    """Each of some names with how often it comes, in their order."""
    return ", ".join(f"{count} {name}" for name, count in sorted(Counter(names).items()))


def _sentence(found: str, advice: str) -> Iterator[str]:
    yield from _wrapped(printable(found), "  ")
    yield from _wrapped(f"-> {printable(advice)}", "    ")


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
    columns: dict[tuple[str, str], list[CheckedColumn]] = {}
    for run in runs:
        for column in run.columns:
            columns.setdefault((column.name, column.unit), []).append(column)
    head = ("Column", "Unit", "Read as", "Unit", "Smallest", "Largest", "Numbers", "Missing")
    rows = [
        (
            same[0].name,
            same[0].logged_unit,
            same[0].quantity,
            same[0].unit,
            *_ends(same),
            str(sum(column.count for column in same)),
            str(sum(column.missing for column in same)),
        )
        for same in columns.values()
    ]
    yield from _table([head, *rows], (24, 6, 22, 5, 9, 9, 7, 7), right=4)
    unused = dict.fromkeys(name for run in runs for name in run.unused_columns)
    if unused:
        yield from _wrapped(f"Not read: {', '.join(map(printable, unused))}", "  ")


def _ends(ranges: Iterable[Range]) -> tuple[str, str]:
    known = list(ranges)
    low = [each.minimum for each in known if each.minimum is not None]
    high = [each.maximum for each in known if each.maximum is not None]
    return (f"{min(low):.5g}", f"{max(high):.5g}") if low and high else ("-", "-")


def _conditions(log: CheckedLog) -> Iterator[str]:
    """Operating conditions and traction of each run, its set points below."""
    many = len(log.runs) > _RUNS_LISTED
    names = list(log.runs[0].measured)
    rows: list[Row] = [["Plateaus", *map(_head, names)]]
    for group in [log.runs] if many else [[run] for run in log.runs]:
        label = f"{len(group)} runs" if many else group[0].run_id.removeprefix(log.file).strip(":")
        points = {name: [run.set_points.get(name) for run in group] for name in names}
        given = {name: [point for point in points[name] if point] for name in names}
        rows.append([label or "measured", *(_span(_ends_of(group, name), name) for name in names)])
        if any(given.values()):
            values = {name: [point.value for point in given[name]] for name in names}
            sources = {name: sorted({point.source for point in given[name]}) for name in names}
            rows.append(["set point", *(_span(values[name], name) for name in names)])
            rows.append(["from", *(", ".join(sources[name]) or "-" for name in names)])
    widths = [max(map(_columns_of, column)) for column in zip(*rows, strict=True)]
    yield from _table(rows, [min(width, 16) for width in widths], right=len(names))


def _head(name: str) -> str:
    short, unit = _SHORT[name][0], tables.COLUMNS[name].shown_unit
    return f"{short} ({unit})" if unit else short


def _ends_of(runs: Iterable[CheckedRun], name: str) -> list[float]:
    measured = [run.measured[name] for run in runs]
    ends = [end for each in measured for end in (each.minimum, each.maximum)]
    return [end for end in ends if end is not None]


def _span(values: Sequence[float], name: str) -> str:
    """The range of a quantity with its own digits."""
    if not values:
        return "-"
    # no minus before a zero
    low, high = (f"{end:z{_SHORT[name][1]}}" for end in (min(values), max(values)))
    return low if low == high else f"{low}..{high}"


def _gates_not_applied(runs: Sequence[CheckedRun]) -> Iterator[str]:
    """The gates that could not be applied to all runs or to some, by what they lack."""
    by_reason: dict[str, dict[str, int]] = {}
    for run in runs:
        for lacking in run.gates_not_applied:
            gates = by_reason.setdefault(lacking.reason, {})
            gates[lacking.gate] = gates.get(lacking.gate, 0) + 1
    if by_reason:
        yield ""
        yield "  Gates that could not be applied"
    for reason, gates in by_reason.items():
        names = [
            gate if count == len(runs) else f"{gate} ({count} of {len(runs)} runs)"
            for gate, count in gates.items()
        ]
        yield from _wrapped(f"{', '.join(names)}: {reason}", "    ")


def _table(rows: Sequence[Row], widths: Sequence[int], right: int) -> Iterator[str]:
    """Rows of cells in columns; the last `right` columns are aligned to the right."""
    for row in rows:
        cells = [
            _cell(text, width, index >= len(row) - right)
            for index, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield f"  {' '.join(cells)}".rstrip()


def _cell(text: str, width: int, right: bool) -> str:
    """A text in as many columns of a terminal, cut where it is longer."""
    plain = printable(text)
    if _columns_of(plain) > width:
        while _columns_of(plain) >= width:
            plain = plain[:-1]
        plain += "~"
    blanks = " " * (width - _columns_of(plain))
    return blanks + plain if right else plain + blanks


def _columns_of(text: str) -> int:
    """Columns of a terminal that a text takes: Chinese letters take two."""
    return sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)
