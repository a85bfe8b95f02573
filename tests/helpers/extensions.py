"""What docs/how-to/extend.md tells a newcomer to write, by section of that page.

Each extension is small and does something: a law that can be fitted, a gate that refuses, a format
that is read. The places that it changes are those that the page lists.
"""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from campaigns import ROOT

PAGE = ROOT / "docs/how-to/extend.md"
SCHEMAS = "make schemas"


class Edit(NamedTuple):
    """One change of a file: `old` is replaced by `new`. A new file has no `old`."""

    path: str
    old: str
    new: str

    def apply(self, project: Path) -> None:
        """Change the file in a project.

        Raises:
            AssertionError: It is there already, or has not the text that is replaced.
        """
        file = project / self.path
        if not self.old:
            assert not file.exists(), file
            file.write_text(self.new, encoding="utf-8")
            return
        text = file.read_text(encoding="utf-8")
        assert self.old in text, f"{self.path} has no {self.old!r}"
        file.write_text(text.replace(self.old, self.new, 1), encoding="utf-8")


def after(path: str, line: str, added: str) -> Edit:
    """A text added behind a line."""
    return Edit(path, line, f"{line}{added}")


def before(path: str, line: str, added: str) -> Edit:
    """A text added before a line."""
    return Edit(path, line, f"{added}{line}")


def apply(edits: Iterable[Edit], project: Path) -> None:
    """Change a project; files of tests and pages only where it has them."""
    for edit in edits:
        beside_workflow = edit.path.startswith(("tests/", "docs/", "data/"))
        if not beside_workflow or (project / edit.path).exists():
            edit.apply(project)


def listed(section: str) -> list[str]:
    """The places that a section of the page lists, in order; `make schemas` may be among them."""
    text = PAGE.read_text("utf-8").partition(f"\n## {section}\n")[2].partition("\n## ")[0]
    return re.findall(r"(?m)^\d+\. [^`]*`([^`]+)`", text)


LAW = '''"""A straight start and a level, as a hyperbola."""

from oilfilm.traction.law import Coefficient, Law

CONDITIONS = ("load_n", "entrainment_speed_m_s", "inlet_temperature_c")
HYPERBOLA = Law(
    name="hyperbola",
    source="a test",
    equation="A*abs(K - 1)*h",
    parts=(("h", "B*S/(B*S + 1)"),),
    coefficients=(
        Coefficient("A", +1, 1e-4, 1.0),
        Coefficient("B", +1, 1.0, 1e4, multiplies_slip=True),
        Coefficient("K", +1, 1e-3, 1e3, exponents=(-1.0, 0.0, 0.0)),
    ),
    conditions=CONDITIONS,
    groups=CONDITIONS,
    reference=(100.0, 20.0, 20.0),
    varied_conditions_needed=("load_n",),
)
'''

READER = '''"""Logs of one JSON object per line: first the header keys, then one row per instant."""

import json
from collections.abc import Sequence

import numpy as np

from oilfilm.base.plain_key import plain_key
from oilfilm.base.units import FloatArray
from oilfilm.logs.base import NO_DIALECT, UnreadableLogError, check_text_size
from oilfilm.logs.columns import text_of_value
from oilfilm.logs.log_schema import Vocabulary
from oilfilm.logs.logged_table import LoggedTable, TablesOfFile


def recognises(first_bytes: bytes) -> bool:
    """True for an object of JSON."""
    return first_bytes.startswith(b"{")


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `Reader.tables`."""
    check_text_size(content)
    try:
        header, *rows = map(json.loads, content.splitlines())
        names, units = list(header["units"]), list(header["units"].values())
        columns = [np.array([row[name] for row in rows], dtype=float) for name in names]
    except (ValueError, KeyError, TypeError) as error:
        raise UnreadableLogError(f"a line is no row of JSON ({error})") from error

    def values(indices: Sequence[int]) -> list[FloatArray]:
        return [columns[index] for index in indices]

    keys = {plain_key(name): text_of_value(value) for name, value in header["keys"].items()}
    return NO_DIALECT, [LoggedTable(keys, names, units, values, len(rows))]
'''

WRITER = """
def jsonl(values: Columns, units: Units = UNITS, keys: Keys = KEYS) -> bytes:
    header = {"keys": dict(keys), "units": {name: units[name] for name in values}}
    rows = np.column_stack(list(values.values())).tolist()
    lines = [header, *(dict(zip(values, row, strict=True)) for row in rows)]
    return ("\\n".join(map(json.dumps, lines)) + "\\n").encode()


WRITERS = {"jsonl": jsonl, """

GATE = '''@gate
def too_long(points: pd.DataFrame, rig_kind: RigKind) -> "pd.Series[bool]":
    """A level is held for so long that the oil may change."""
    return points["duration_s"] > rig_kind.gate_limits.duration_max_s


'''

RULE = """  too_long:
    rig_kinds: traction torque
    finds: 'a level is held for up to {most[duration_s]:.0f} s; expected at most
      {gates.duration_max_s:g} s'
    advice: Hold each {level} for a shorter time.
    blames_run: false
    needs: duration_s
"""

DAMAGE = '''def held_longer(log: SoundLog) -> bytes:
    """One level is held 20 times as long."""
    start, stop = log.held.start, log.held.stop
    rows = [log.row_index[:start], *[log.row_index[start:stop]] * 20, log.row_index[stop:]]
    values = {name: column[np.concatenate(rows)] for name, column in log.values.items()}
    step = log.values["time"][1] - log.values["time"][0]
    return log.text({**values, "time": step * np.arange(len(values["time"]))})


'''

FIGURE = '''"""How the tested slips are spread."""

from oilfilm.report.figures.sheet import Sheet, declare_figure
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables


@declare_figure(family="data", tables=("points",))
def tested_slips(results: CampaignTables, settings: Settings) -> Sheet:
    """Tested slips.

    Slide-roll ratio of all plateaus in ascending order.
    """
    sheet = Sheet()
    slips = results.points["slide_roll_ratio"].sort_values()
    sheet.panel(title=None).dots("measured", range(len(slips)), slips, {"marker": "."})
    sheet.label_axes("Plateau", "Slide-roll ratio S")
    return sheet
'''

COMMAND = '''def laws(command: Command) -> None:
    """List the traction laws.

    Example: oilfilm laws
    """


'''

COMMAND_RUN = '''"""The command `oilfilm laws`: the names of the traction laws."""

import argparse

from oilfilm.traction import LAW_NAMES


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    print(*LAW_NAMES, sep="\\n")
    return 0
'''

OIL = (ROOT / "config/oils/4102.yaml").read_text("utf-8").replace("4102", "4199")
_LIBRARY, _CAMPAIGN = "workflow/oilfilm", "config/campaigns/small.yaml"
_LIMIT = "  duration_max_s: 60            # of a level\n"

# By the title of the section.
EXTENSIONS = {
    "A law": (
        Edit(f"{_LIBRARY}/traction/laws/hyperbola.py", "", LAW),
        before(
            f"{_LIBRARY}/traction/laws/__init__.py",
            "from oilfilm.traction.laws.eyring",
            "from oilfilm.traction.laws.hyperbola import HYPERBOLA as HYPERBOLA\n",
        ),
        after(
            "tests/helpers/law_points.py",
            "PLAUSIBLE_CONSTANTS: dict[str, list[float]] = {\n",
            '    "hyperbola": [0.01, 0.1, -0.3, -0.2, 100.0, 0.1, 0.2, 0.3, 4.0, -1, 0, 0],\n',
        ),
    ),
    "A log format": (
        Edit(f"{_LIBRARY}/logs/jsonl.py", "", READER),
        Edit(f"{_LIBRARY}/logs/ingest.py", '"pcs": pcs,', '"pcs": pcs, "jsonl": jsonl,'),
        Edit(
            f"{_LIBRARY}/logs/ingest.py",
            "    delimited_text,\n",
            "    delimited_text,\n    jsonl,\n",
        ),
        Edit("tests/helpers/formats.py", "\nWRITERS = {", WRITER),
        Edit("tests/helpers/formats.py", "import io\n", "import io\nimport json\n"),
        after("data/raw/README.md", "# Raw logs\n", "\nLogs of JSON lines are read.\n"),
    ),
    "A gate": (
        before(f"{_LIBRARY}/curation/plateau_gates.py", "@gate\ndef load_off_nominal", GATE),
        before(f"{_LIBRARY}/curation/rules.yaml", "  load_off_nominal:\n", RULE),
        before(
            f"{_LIBRARY}/settings/config.py",
            '    clock_jump_intervals: q.Positive = key("Longest gap',
            '    duration_max_s: q.DurationS = key("Longest plateau.")\n',
        ),
        before("config/config.yaml", "  load_change_max: 0.03 ", _LIMIT),
        before("config/config.yaml", "    load_change_max: 0.03 ", f"  {_LIMIT}"),
        before("tests/helpers/damages.py", "class Damage(NamedTuple)", DAMAGE),
        after(
            "tests/helpers/damages.py",
            "DAMAGES = {\n",
            '    "level_held_20_times_as_long": Damage(held_longer, "too_long", spares=True),\n',
        ),
    ),
    "A figure": (
        Edit(f"{_LIBRARY}/report/figures/slips.py", "", FIGURE),
        after(_CAMPAIGN, "figures:\n", "- tested-slips\n"),
    ),
    "A column": (
        after(
            f"{_LIBRARY}/tables/fits.yaml",
            "    meaning: conditions that several runs have\n",
            "  n_judged:\n    type: count\n    meaning: points whose residuals are judged\n",
        ),
        after(
            f"{_LIBRARY}/tables/fits.yaml", "      - n_repeated_conditions\n", "      - n_judged\n"
        ),
        before(
            f"{_LIBRARY}/fits/soundness.py",
            '        "relative_rms": quality_row["relative_rms"],',
            '        "n_judged": len(residual),\n',
        ),
        before(
            "docs/reference/table_examples.json",
            '  "relative_rms": 0.007942,\n  "repeat_relative_rms"',
            '  "n_judged": 310,\n',
        ),
    ),
    "A command": (
        before(f"{_LIBRARY}/cli/parser.py", "COMMANDS = (", COMMAND),
        Edit(f"{_LIBRARY}/cli/parser.py", "    pin,\n", "    pin,\n    laws,\n"),
        Edit(f"{_LIBRARY}/cli/laws.py", "", COMMAND_RUN),
    ),
    "An oil": (Edit("config/oils/4199.yaml", "", OIL), after(_CAMPAIGN, "oils:\n", "- '4199'\n")),
}
# Sections that end with `make schemas`, because a generated file shows what is new.
SHOWN = {"A law", "A gate", "A figure", "A column", "A command"}
