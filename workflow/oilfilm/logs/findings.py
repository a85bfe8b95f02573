"""What the logs of one project have in common: columns, oils, rigs, set points.

Decides: what `oilfilm init` finds in a folder of logs.
"""

import re
import unicodedata
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from oilfilm.home import CONFIG
from oilfilm.logs.header import FULL_WIDTH, apart
from oilfilm.logs.sniff import VOCABULARY, Run, Sniffed, set_points
from oilfilm.logs.words import unit_in_name
from oilfilm.settings.base import plain_key
from oilfilm.settings.campaign import Semantics

_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss"})
_FEWEST_GUESSES = 3


def shipped(kind: str) -> dict[str, str]:
    """Names of the rigs or oils that are part of oilfilm, by their plain form."""
    paths = (CONFIG / kind).glob("*.yaml")
    return {plain_key(path.stem): path.stem for path in paths if path.stem != "template"}


@dataclass(frozen=True)
class Findings:
    """What was found in all logs together."""

    logs: Sequence[Sniffed]

    @property
    def runs(self) -> Iterator[Run]:
        """The runs of all logs."""
        return (run for log in self.logs for run in log.runs)

    @property
    def _named(self) -> list[Sniffed]:
        """The logs whose columns were recognised, at least in part."""
        return [log for log in self.logs if log.runs or len(log.guesses) >= _FEWEST_GUESSES]

    @cached_property
    def columns(self) -> dict[str, list[str]]:
        """Names of columns by the quantity that they seem to mean."""
        names: dict[str, dict[str, None]] = {}
        for log in self._named:
            for quantity, columns in log.guesses.items():
                if len(columns) == 1:
                    ((name, unit),) = columns
                    bare = apart(name.translate(FULL_WIDTH))[0]
                    # a unit in brackets is read; without one the name is as the log writes it
                    names.setdefault(quantity, {})[bare if unit else name] = None
        return {quantity: list(of) for quantity, of in names.items()}

    @property
    def doubtful(self) -> dict[str, list[str]]:
        """Quantities that no column seems to mean, or several: the names to choose from."""
        doubtful: dict[str, dict[str, None]] = {}
        for log in self._named:
            several = {q: [n for n, _ in each] for q, each in log.guesses.items() if len(each) > 1}
            for quantity in {*log.missing, *several}:
                names = several.get(quantity, [name for name in log.names if _is_left(name, log)])
                doubtful.setdefault(quantity, {}).update(dict.fromkeys(names))
        return {quantity: list(names) for quantity, names in sorted(doubtful.items())}

    def unit(self, quantity: str) -> tuple[str, bool]:
        """The unit for the campaign file, empty where the logs give it; whether it is unknown."""
        units = {
            unit_in_name(name, quantity, VOCABULARY)
            for log in self._named
            for name, unit in log.guesses.get(quantity, [])[:1]
            if not unit
        }
        known = next(iter(units)) if len(units) == 1 else ""
        return known, bool(units) and not known

    @property
    def header(self) -> dict[str, list[str]]:
        """Names of header lines by the project's key, without those that are the key itself."""
        names: dict[str, dict[str, None]] = {}
        for run in self.runs:
            if run.oil_key not in ("", "oil"):
                names.setdefault("oil", {})[run.oil_key.replace("_", " ")] = None
            for key, line in run.lines.items():
                if line.listed and plain_key(line.name) != key:
                    names.setdefault(key, {})[line.name] = None
        return {key: list(of) for key, of in names.items()}

    @cached_property
    def oils(self) -> dict[str, list[str]]:
        """What the logs call each oil, by the id that it gets; one id where no log says it."""
        oils: dict[str, list[str]] = {}
        for number, label in enumerate(dict.fromkeys(run.oil for run in self.runs if run.oil), 1):
            oils.setdefault(_oil_id(label) or f"oil-{number}", []).append(label)
        return oils or {"my-oil": []}

    def oil_of(self, label: str) -> str:
        """The id of an oil by what a log calls it."""
        return next(oil for oil, labels in self.oils.items() if label in labels)

    @property
    def unnamed_oil(self) -> bool:
        """Whether some logs name an oil and others do not, so that these need it of the sheet."""
        return len(self.oils) > 1 and any(not run.oil for run in self.runs)

    @cached_property
    def rigs(self) -> list[str]:
        """Rigs by the names that the logs give them; one of its own where none does."""
        known = shipped("rigs")
        named = [known.get(plain_key(run.rig), _slug(run.rig)) for run in self.runs if run.rig]
        pcs = [log for log in self.logs if log.format == "pcs"]
        if pcs and not named:
            return ["pcs-etm" if all("etm" in log.file.lower() for log in pcs) else "pcs-rig"]
        return list(dict.fromkeys(name for name in named if name)) or ["my-rig"]

    @property
    def needs_radii(self) -> bool:
        """Whether speeds are those of spindles, so that the radii of the tracks are needed."""
        return any(run.units.get("ball_speed") == "rpm" for run in self.runs)

    @property
    def needs_contact(self) -> bool:
        """Whether the load is logged as a pressure, so that geometry and materials are needed."""
        return any(run.units.get("load") == "GPa" for run in self.runs)

    @property
    def semantics(self) -> dict[str, str | int]:
        """How the signals seem to be meant, where it differs from the defaults."""
        runs = [run for run in self.runs if not run.settled]
        found: dict[str, str | int] = {}
        for key in ("slower_body", "traction_sign"):
            most = Counter(value for run in runs if (value := getattr(run, key))).most_common(1)
            default = Semantics.model_fields[key].default
            if most and most[0][0] != default:
                found[key] = most[0][0]
        return found

    @cached_property
    def zeros(self) -> Counter[str | None]:
        """How many runs each source of the zero suits; None: none does."""
        return Counter(run.zero for run in self.runs if run.zero != "")

    @property
    def slip_is_logged(self) -> bool:
        """Whether the slip comes from a logged slide-roll ratio, whose definition is not known."""
        return any(run.units and "ball_speed" not in run.units for run in self.runs)

    @property
    def repeats(self) -> bool:
        """Whether two runs of one oil have the same set points."""
        levels = (
            (run.oil, set_points(run) | {key: line.value for key, line in run.lines.items()})
            for run in self.runs
            if run.measured
        )
        conditions = [(oil, *sorted(of_run.items())) for oil, of_run in levels]
        return len(set(conditions)) < len(conditions)

    @property
    def decimal_comma(self) -> bool:
        """Whether the laboratory writes numbers with a comma."""
        return any(log.form.decimal_mark == "comma" for log in self.logs)


def _is_left(name: str, log: Sniffed) -> bool:
    """Whether nothing is known of a column of a log."""
    taken = {other for columns in log.guesses.values() for other, _ in columns}
    return name not in taken and VOCABULARY.meaning(name) is None


def _oil_id(label: str) -> str:
    """The shipped oil that a label names as a word of its own, else the label as an id."""
    words = re.findall(r"\w+", plain_key(label).replace("_", " "))
    known = shipped("oils")
    return next((known[word] for word in words if word in known), _slug(label))


def _slug(label: str) -> str:
    """A name as an id: ASCII letters, digits and '-'; empty where it has others."""
    plain = unicodedata.normalize("NFKD", label.casefold().translate(_UMLAUTS))
    plain = "".join(letter for letter in plain if not unicodedata.combining(letter))
    if not plain.isascii():
        return ""
    return re.sub(r"[^a-z0-9]+", "-", plain).strip("-")[:60]
