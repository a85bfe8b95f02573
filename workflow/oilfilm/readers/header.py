"""What the header lines of a log mean, in whatever language their keys are."""

import difflib
from collections.abc import Iterable, Mapping

from oilfilm.readers.base import SET_POINTS, Refusal
from oilfilm.settings.resolved import Settings

FORMAT_ADVICE = "data/raw/README.md describes the format."
# Keys that resemble a set point's by more than this are taken for slips of the pen.
_RESEMBLANCE = 0.85


def plain_key(text: str) -> str:
    """A key or name in lower case, its words joined by underscores."""
    return "_".join(text.lower().split())


def header_keys(logged: Mapping[str, str], settings: Settings) -> dict[str, str]:
    """Header lines by the project's keys, the oil by its id.

    Two lines with the same meaning and different values give both, which no gate takes.

    Args:
        logged: Header lines by the keys of the log, as `plain_key` makes them.
        settings: Its campaign's `header` lists names of keys, its oils may have aliases.
    """
    names = {
        plain_key(name): key for key, listed in settings.campaign.header for name in listed or ()
    }
    keys: dict[str, str] = {}
    for own, text in logged.items():
        key = names.get(own, own)
        keys[key] = text if keys.get(key, text) == text else f"{keys[key]} / {text}"
    if len(settings.oils) == 1:
        keys.setdefault("oil", next(iter(settings.oils)))
    if "oil" in keys:
        keys["oil"] = settings.oil_ids.get(keys["oil"], keys["oil"])
    return keys


def misspelt_key(keys: Mapping[str, str]) -> Refusal | None:
    """A header key that resembles the key of a set point, which the log then lacks."""
    for key in keys:
        near = difflib.get_close_matches(key, SET_POINTS, 1, _RESEMBLANCE)
        if key not in SET_POINTS and near and near[0] not in keys:
            return Refusal(
                "unknown_header_key",
                f"the header has the unknown key {key[:60]!r}; did you mean {near[0]!r}?",
                f"Correct the header, or list the key under `header` of the campaign file. "
                f"{FORMAT_ADVICE}",
            )
    return None


def oil_problem(keys: Mapping[str, str], settings: Settings) -> Refusal | None:
    """Why the oil of a log's header cannot be used."""
    if "oil" not in keys:
        reason = "the header has no line `# oil: ...` and no property `oil`"
        return Refusal("header", reason, f"Add it. {FORMAT_ADVICE}")
    return unknown("oil", keys["oil"], settings.oils)


def unknown(kind: str, name: str, known: Iterable[str]) -> Refusal | None:
    """Why the name of an oil or a rig in a log's header cannot be used."""
    if name in known:
        return None
    return Refusal(
        f"unknown_{kind}",
        f"the header says {kind} {name[:60]!r}; the campaign knows {', '.join(known)}",
        f"Correct the header, or add the {kind} to the campaign file.",
    )


def simulation_problem(keys: Mapping[str, str], settings: Settings) -> Refusal | None:
    """Why a simulated log cannot be used in a campaign of measured ones."""
    if keys.get("simulated", "no") == "no" or settings.campaign.data != "measured":
        return None
    return Refusal(
        "simulated_log",
        "the header says that the log is simulated; the campaign file says data: measured",
        "Take the log out, or say data: simulated in the campaign file.",
    )
