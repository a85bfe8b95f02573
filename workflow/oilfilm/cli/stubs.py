"""The files of a new project: settings with what was found, run sheet, Snakefile, first steps.

Decides: the files that `oilfilm init` writes.
"""

import re
from collections import Counter
from collections.abc import Iterator

import numpy as np
import pandas as pd
import yaml
from jinja2 import Environment, PackageLoader, StrictUndefined

from oilfilm.errors import printable
from oilfilm.home import CONFIG
from oilfilm.logs.base import SET_POINTS
from oilfilm.logs.sniff import VOCABULARY, Findings, Sniffed, rows_of_sheet, set_points, shipped
from oilfilm.settings.messages import load
from oilfilm.settings.rig import Rig

# Marks what only the laboratory knows: the run stops without it. Behind "for the film" it does not.
FILL_IN, FOR_FILM = "# FILL IN", "# for the film"
_WIDTH = 34
# Why a source of the zero of the force suits some runs.
_ZEROS = {
    "rolling_phases": "guess: {which} begin and end with pure rolling",
    "opening_phase": "guess: {which} begin with pure rolling and do not end with it",
    "standstill": "guess: {which} stand still before the first level and have no pure rolling; is "
    "that the sensor's zero?",
    None: f"{FILL_IN}: {{which}} have neither pure rolling nor standstill; already_removed if the "
    "logger took the zero of the force off",
}

Line = tuple[str, object, str]


def template(file: str, /, **values: object) -> str:
    """The text of a file from its template."""
    environment = Environment(
        loader=PackageLoader("oilfilm.cli"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # noqa: S701 - YAML, whose values and comments `_line` writes
    )
    return environment.get_template(file).render(line=_line, schema=schema_line, **values)


def schema_line(kind: str) -> str:
    """The line by which an editor checks a settings file and completes its keys."""
    folder = "schemas" if kind == "config" else "../schemas"
    return f"# yaml-language-server: $schema={folder}/{kind}.schema.json"


def campaign_yaml(name: str, found: Findings) -> str:
    """`config/campaigns/<name>.yaml`."""
    known = shipped("oils").values()
    own = [oil for oil in found.oils if oil not in known]
    return template(
        "campaign.yaml.jinja",
        name=name,
        found=found,
        # names come out of logs: a line end among them would end the comment
        summary=[*map(printable, summary(found))],
        shipped=[oil for oil in found.oils if oil in known],
        own=own,
        unnamed="guess: no log names its oil; " if found.oils == {"my-oil": []} else "",
        aliases={oil: labels for oil, labels in found.oils.items() if labels not in ([], [oil])},
        no_film=bool(own) or any(rig_of(rig).contact() is None for rig in found.rigs),
        groups={
            "columns": [*_columns(found)],
            "header": [(key, names, "guess") for key, names in found.header.items()],
            "semantics": [*_semantics(found)],
        },
    )


def summary(found: Findings) -> Iterator[str]:
    """How the logs are written and what they cover, one line for each way of writing."""
    forms = Counter((log.format, log.form) for log in found.logs).most_common()
    for (name, form), count in forms:
        words = [name, *([form.encoding] if form.encoding else [])]
        if form.delimiter:
            words += [f"delimiter {form.delimiter}", f"decimal {form.decimal_mark}"]
        yield f"{count} {'log' if count == 1 else 'logs'}: {', '.join(words)}"
    for log in found.logs:
        if log.problem:
            yield f"{log.file} could not be read: {log.problem}"


def rig_of(name: str) -> Rig:
    """A shipped rig, or one of which nothing is known."""
    if name in shipped("rigs").values():
        rig: Rig = load(CONFIG / f"rigs/{name}.yaml", Rig)
        return rig
    return Rig(name=name, source="unknown")


def _columns(found: Findings) -> Iterator[Line]:
    for quantity in VOCABULARY.quantities:
        names = found.columns.get(quantity)
        unit, unknown = found.unit(quantity)
        if quantity in found.doubtful:
            choice = ", ".join(found.doubtful[quantity]) or "no column is left"
            sentence = f"{FILL_IN}: the name of the column; perhaps {choice}"
            yield quantity, {"name": names}, sentence
        elif names and unknown:
            units = " or ".join(VOCABULARY.quantities[quantity])
            sentence = f"{FILL_IN}: the unit, such as {units}; the logs do not say it"
            yield quantity, {"name": names, "unit": None}, sentence
        elif names:
            yield quantity, {"name": names, **({"unit": unit} if unit else {})}, "guess"


def _semantics(found: Findings) -> Iterator[Line]:
    whys = {"slower_body": "the slip of the logs shows it"}
    whys |= {"traction_sign": "the force falls where the slip rises"}
    yield from ((key, value, f"guess: {whys[key]}") for key, value in found.semantics.items())
    if found.zeros:
        ((source, count),) = found.zeros.most_common(1)
        total = found.zeros.total()
        which = "the runs" if count == total else f"{count} of {total} runs"
        why = _ZEROS[source].format(which=which)
        if found.needs_radii and source in ("rolling_phases", "opening_phase"):
            why += "; true where the radii of the tracks make the beginning pure rolling"
        yield "zero", source, why
    if found.slip_is_logged:
        yield "slide_roll_ratio", "over_mean", "guess: over_mean, over_sum or over_faster speed"


def oil_yaml(oil: str, found: Findings) -> str:
    """`config/oils/<id>.yaml`: the shipped template with the numbers left out."""
    label = next(iter(found.oils[oil]), oil)
    numbers = "viscosity", "nominal", "pressure", "density", "specific", "thermal"
    lines = [
        schema_line("oil"),
        "# Read when the campaign file lists the oil under `oils`: fill in all of it before.",
    ]
    template = (CONFIG / "oils/template.yaml").read_text(encoding="utf-8").splitlines()
    start = next(number for number, line in enumerate(template) if line.startswith("id:"))
    for line in template[start:]:
        key, _, rest = line.partition(":")
        given = {"id": oil, "name": label, "display_name": label}
        if key in given:
            lines.append(_line(key, given[key]))
        elif key in ("note", "source"):
            lines.append(_line(key, "not documented yet", rest.strip()))
        elif key.strip().startswith(numbers):
            comment = rest.partition("#")[2].strip() or f"as{rest}"
            lines.append(_line(key, None, f"{FOR_FILM}: {comment}"))
        elif not key.startswith("# aliases"):
            lines.append(line)
    return "\n".join([*lines, ""])


def run_sheet(found: Findings) -> str:
    """`data/raw/<name>/runs.csv`: what the headers of the logs do not say."""
    rows = pd.DataFrame([row for log in found.logs for row in _rows(log, found)])
    used = [name for name in ("run", "oil", "log_kind", *SET_POINTS) if name in rows]
    columns = ["file", *used, "exclude", "remarks"]
    sep, decimal = (";", ",") if found.decimal_comma else (",", ".")
    return rows.reindex(columns=columns).to_csv(
        index=False, sep=sep, decimal=decimal, float_format="%g", lineterminator="\n"
    )


def _rows(log: Sniffed, found: Findings) -> Iterator[dict[str, object]]:
    for run in rows_of_sheet(log):
        given = set_points(run)
        row = {"file": log.file, **({"run": run.part} if run.part else {}), **given}
        row |= {"oil": ""} if found.unnamed_oil else {}
        # the rows of a table of mu are settled readings, which such a table does not say
        row |= {"log_kind": "steps"} if run.settled and not run.log_kind else {}
        remarks = ["guess: set points are medians of the log"] if given else []
        if found.unnamed_oil and not run.oil:
            remarks.append("FILL IN: the oil")
        yield {**row, "remarks": ". ".join(remarks)}


def _line(key: str, value: object, comment: str = "") -> str:
    """A line of YAML; None is written as nothing, to be filled in."""
    line = f"{key}: {_flow(value)}".rstrip()
    comment = printable(comment.removeprefix("# "))
    return f"{line.ljust(_WIDTH)}  # {comment}" if comment else line


def _flow(value: object) -> str:
    """A value on one line, as YAML reads it back."""
    if value is None:
        return ""
    text = yaml.safe_dump(
        value, default_flow_style=True, allow_unicode=True, sort_keys=False, width=np.inf
    )
    # a last key without a value is to be filled in
    return re.sub(r" null}$", " }", text.removesuffix("\n").removesuffix("\n..."))
