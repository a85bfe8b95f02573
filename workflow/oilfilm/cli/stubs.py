"""The files of a new project: settings with what was found, run sheet, Snakefile, first steps.

Decides: the files that `oilfilm init` writes.
"""

import csv
import io
from collections import Counter
from collections.abc import Iterator

import numpy as np
import yaml

from oilfilm.errors import printable
from oilfilm.home import CONFIG
from oilfilm.logs.base import SET_POINTS
from oilfilm.logs.findings import Findings, shipped
from oilfilm.logs.sniff import VOCABULARY, Sniffed, rows_of_sheet, set_points
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
# So many ways of writing logs are listed; the others are counted.
_FORMS_LISTED = 8

SNAKEFILE = """\
from oilfilm.home import HOME


module oilfilm:
    snakefile: str(HOME / "workflow/Snakefile")
    config: config


use rule * from oilfilm


# Snakemake does not call the handlers of a module by itself.
onstart:
    oilfilm.onstart()


onsuccess:
    oilfilm.onsuccess()


onerror:
    oilfilm.onerror()
"""

README = """\
{name}: traction logs, evaluated by oilfilm

1. Fill in the lines marked FILL IN in config/ (grep -rn "FILL IN" config). Look at those marked
   guess as well; lines marked "for the film" are needed for pressure and film thickness.
   data/raw/{name}/runs.csv says what the headers of the logs do not.
2. oilfilm check data/raw/{name}
   gives a verdict on every log in seconds, says how it was understood, and what to do.
3. oilfilm run
   makes everything (so does snakemake). See results/{name}/summary.txt and report.html beside it.

config/config.yaml: the campaign, and what differs from the defaults of oilfilm
config/campaigns, rigs, oils: what was measured, on which rig, with which oils
data/raw/{name}: your logs; never changed
results/{name}: everything that is made; may be deleted
"""


def config_yaml(name: str) -> str:
    """`config/config.yaml`."""
    return (
        "# What differs from the defaults; all keys: docs/reference/configuration.md of oilfilm.\n"
        f"{_line('campaign', name)}\n"
    )


def campaign_yaml(name: str, found: Findings) -> str:
    """`config/campaigns/<name>.yaml`."""
    return "\n".join([*_campaign(name, found), ""])


def _campaign(name: str, found: Findings) -> Iterator[str]:
    yield "# Written by `oilfilm init`. Fill in what is marked so; look at each guess."
    # names come out of logs: a line end among them would end the comment
    yield from (f"# {printable(line)}" for line in summary(found))
    yield _line("description", f"logs of {name}", "one line: what was measured, where and when")
    yield _line("data", "measured")
    yield _line("rigs", found.rigs, "config/rigs")
    yield from _oils(found)
    yield _line("figures", ["curves", "constants", "coverage"])
    if found.repeats:
        why = "guess: several runs of an oil have the same set points"
        yield _line("repeated_conditions", "accept", why)
    yield from _columns(found)
    yield from _header(found)
    yield from _semantics(found)


def summary(found: Findings) -> Iterator[str]:
    """How the logs are written and what they cover, one line for each way of writing."""
    forms = Counter((log.format, log.form) for log in found.logs).most_common()
    for form, _ in forms[:_FORMS_LISTED]:
        logs = [log for log in found.logs if (log.format, log.form) == form]
        words = [form[0], *([form[1].encoding] if form[1].encoding else [])]
        if form[1].delimiter:
            words += [f"delimiter {form[1].delimiter}", f"decimal {form[1].decimal_mark}"]
        yield f"{len(logs)} {'log' if len(logs) == 1 else 'logs'}: {', '.join(words)}"
    if others := sum(count for _, count in forms[_FORMS_LISTED:]):
        yield f"{others} logs that are written in other ways"
    yield from (f"{log.file} could not be read: {log.problem}" for log in found.logs if log.problem)


def _oils(found: Findings) -> Iterator[str]:
    known = shipped("oils").values()
    yield _line(
        "oils",
        [oil for oil in found.oils if oil in known],
        "config/oils; of shipped oils the properties are stand-ins"
        if any(oil in known for oil in found.oils)
        else "",
    )
    unknown = [oil for oil in found.oils if oil not in known]
    if unknown:
        moved = "move to `oils` when its file in config/oils is filled in"
        unnamed = "guess: no log names its oil; " if found.oils == {"my-oil": []} else ""
        yield _line("oils_without_properties", unknown, unnamed + moved)
    aliases = {oil: labels for oil, labels in found.oils.items() if labels not in ([], [oil])}
    if aliases:
        yield _line("oil_aliases", aliases, "guess: different names are taken for different oils")
    if unknown or any(rig_of(rig).contact() is None for rig in found.rigs):
        yield "# Without the files of oil and rig no film thickness is known; points are refused."
        yield "# Fill in those files, or say why the points may be used all the same:"
        yield "#   film_unjudged: {accept: true, reason: the film was thick enough by experience}"
        yield _line(
            "film_unjudged",
            None,
            f"{FILL_IN}: as above, or fill in those files and remove this line",
        )


def rig_of(name: str) -> Rig:
    """A shipped rig, or one of which nothing is known."""
    if name in shipped("rigs").values():
        rig: Rig = load(CONFIG / f"rigs/{name}.yaml", Rig)
        return rig
    return Rig(name=name, source="unknown")


def _columns(found: Findings) -> Iterator[str]:
    if not (found.columns or found.doubtful):
        return
    yield "columns:"
    for quantity in VOCABULARY.quantities:
        names = found.columns.get(quantity)
        if quantity in found.doubtful:
            choice = ", ".join(found.doubtful[quantity]) or "no column is left"
            sentence = f"{FILL_IN}: the name of the column; perhaps {choice}"
            yield _line(f"  {quantity}", _Blank({"name": names}), sentence)
        elif names:
            unit, unknown = found.unit(quantity)
            if unknown:
                units = " or ".join(VOCABULARY.quantities[quantity])
                sentence = f"{FILL_IN}: the unit, such as {units}; the logs do not say it"
                yield _line(f"  {quantity}", _Blank({"name": names, "unit": None}), sentence)
            else:
                yield _line(
                    f"  {quantity}", {"name": names, **({"unit": unit} if unit else {})}, "guess"
                )


def _header(found: Findings) -> Iterator[str]:
    if found.header:
        yield "header:"
        yield from (_line(f"  {key}", names, "guess") for key, names in found.header.items())


def _semantics(found: Findings) -> Iterator[str]:
    meant = found.semantics
    if meant or found.slip_is_logged:
        yield "semantics:"
    if "slower_body" in meant:
        yield _line("  slower_body", meant["slower_body"], "guess: the slip of the logs shows it")
    if "traction_sign" in meant:
        why = "guess: the force falls where the slip rises"
        yield _line("  traction_sign", meant["traction_sign"], why)
    if "zero" in meant:
        ((source, count),) = found.zeros.most_common(1)
        total = found.zeros.total()
        which = "the runs" if count == total else f"{count} of {total} runs"
        why = _ZEROS[source].format(which=which)
        if found.needs_radii and source in ("rolling_phases", "opening_phase"):
            why += "; true where the radii of the tracks make the beginning pure rolling"
        yield _line("  zero", source, why)
    if found.slip_is_logged:
        why = "guess: over_mean, over_sum or over_faster speed"
        yield _line("  slide_roll_ratio", "over_mean", why)


def rig_yaml(name: str, found: Findings) -> str:
    """`config/rigs/<name>.yaml`."""
    marks = FILL_IN if found.needs_contact else FOR_FILM
    off = "" if found.needs_contact else "# "
    lines = [
        _line("name", f"ball-on-disc rig {name}", "what it is"),
        _line("source", "not documented yet", "where the values below come from"),
    ]
    for body in ("ball", "disc") if found.needs_radii else ():
        why = f"{FILL_IN}: m, from the spindle's axis to the contact on the {body}"
        lines.append(_line(f"{body}_track_radius_m", None, why))
    if off:
        lines.append("# For pressure and film thickness all of these; remove the '# ' before them.")
    lines.append(_line(f"{off}ball_radius_m", None, f"{marks}: m"))
    for body in ("ball", "disc"):
        elastic = _Blank({"youngs_modulus_pa": None, "poisson_ratio": None})
        lines.append(_line(off + body, elastic, f"{marks}: steel has about 206.0e+9 and 0.3"))
        lines.append(_line(f"{off}{body}_roughness_ra_um", None, f"{marks}: Ra in um"))
    limits = "max_hertz_pressure_gpa entrainment_speed_m_s inlet_temperature_c slide_roll_ratio"
    lines.append(_line("# limits", _Blank(dict.fromkeys(limits.split())), "for `oilfilm plan`"))
    return "\n".join([*lines, ""])


def oil_yaml(oil: str, found: Findings) -> str:
    """`config/oils/<id>.yaml`: the shipped template with the numbers left out."""
    label = next(iter(found.oils[oil]), oil)
    numbers = "viscosity", "nominal", "pressure", "density", "specific", "thermal"
    lines = ["# Read when the campaign file lists the oil under `oils`: fill in all of it before."]
    template = (CONFIG / "oils/template.yaml").read_text(encoding="utf-8").splitlines()
    start = next(number for number, line in enumerate(template) if line.startswith("id:"))
    for line in template[start:]:
        key, _, rest = line.partition(":")
        given = {"id": oil, "name": label, "display_name": label}
        if key in given:
            lines.append(_line(key, _Quoted(given[key])))
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
    rows = [row for log in found.logs for row in _rows(log, found)]
    used = [key for key in SET_POINTS if any(key in row for row in rows)]
    parts = ["run"] if any("run" in row for row in rows) else []
    oil = ["oil"] if found.unnamed_oil else []
    text = io.StringIO()
    writer = csv.DictWriter(
        text,
        ["file", *parts, *oil, *used, "exclude", "remarks"],
        delimiter=";" if found.decimal_comma else ",",
        lineterminator="\n",
        restval="",
    )
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _rows(log: Sniffed, found: Findings) -> Iterator[dict[str, str]]:
    for run in rows_of_sheet(log):
        row = {"file": log.file, **({"run": run.part} if run.part else {})}
        given = set_points(run)
        row |= {key: f"{value:g}" for key, value in given.items()}
        if found.decimal_comma:
            row |= {key: row[key].replace(".", ",") for key in given}
        remarks = []
        if set(given) - run.lines.keys():
            remarks.append("guess: set points are medians of the log")
        if found.unnamed_oil and not run.oil:
            remarks.append("FILL IN: the oil")
        yield {**row, "remarks": ". ".join(remarks)}


class _Blank(dict[str, object]):
    """A group in which None is written as nothing, to be filled in."""


class _Quoted(str):
    """Text that is written in quotes, because it may look like a number."""


def _line(key: str, value: object, comment: str = "") -> str:
    """A line of YAML; None is written as nothing, to be filled in."""
    text = "" if value is None else _flow(value)
    line = f"{key}: {text}".rstrip()
    if not comment:
        return line
    comment = printable(comment.removeprefix("# "))
    return f"{line.ljust(_WIDTH)}  # {comment}"


def _flow(value: object) -> str:
    """A value on one line, as YAML reads it back; nothing for what is to be filled in."""
    if isinstance(value, _Blank):
        parts = (f"{name}: {'' if each is None else _flow(each)}" for name, each in value.items())
        return f"{{{', '.join(parts)}}}"
    style = '"' if isinstance(value, _Quoted) else None
    plain = str(value) if isinstance(value, _Quoted) else value
    text = yaml.safe_dump(
        plain, default_flow_style=True, default_style=style, allow_unicode=True, width=np.inf
    )
    return text.removesuffix("\n").removesuffix("\n...")
