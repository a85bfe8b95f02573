"""The page of `oilfilm watch`: what to run next, coverage of the test matrix, and all verdicts."""

from collections.abc import Iterator, Sequence
from datetime import datetime
from html import escape
from itertools import islice

import pandas as pd

from oilfilm import tables
from oilfilm.cli.watching import Problem, Verdict, Watcher
from oilfilm.curation.coverage import (
    SET_POINTS,
    coverage,
    describe_condition,
    open_conditions,
    planned_states,
    with_levels,
)
from oilfilm.errors import printable
from oilfilm.settings.resolved import Settings

# How often a browser reloads the page, and after how long without a new one it warns.
_REFRESH_S, _STALE_S = 5, 60
# More are counted, not listed.
_STEPS_LISTED, _LOGS_LISTED = 5, 200
_MARKS = {"accepted": "✓", "refused": "✗", "missing": "·", "not judged": "?", "being written": "…"}
_PRESSURE, _, _SPEED, _TEMPERATURE = SET_POINTS
_STYLE = """
:root { color-scheme: light; }
body { font: 1rem/1.5 system-ui, sans-serif; color: #1b1b1b; background: #fff; margin: 0 auto;
  max-width: 60rem; padding: 1rem; overflow-wrap: anywhere; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
.next { border: 2px solid #1b1b1b; padding: .5rem 1rem; }
.what { font-size: 1.15rem; font-weight: bold; }
.note, .stale { border-left: .4rem solid #9a5b00; padding-left: .6rem; }
.scroll { overflow-x: auto; position: relative; }
table { border-collapse: collapse; margin: .5rem 0 1rem; }
caption { text-align: left; font-weight: bold; }
th, td { border: 1px solid #8a8a8a; padding: .15rem .45rem; text-align: center;
  overflow-wrap: normal; }
thead th, tbody th { background: #f0f0f0; font-weight: normal; white-space: nowrap; }
.accepted { background: #d9f0dc; } .refused { background: #f9d6d2; }
.not-judged, .being-written { background: #fdeec8; }
ul.logs { list-style: none; padding: 0; }
ul.logs > li { border-top: 1px solid #bbb; padding: .4rem 0; }
.badge { padding: 0 .4rem; font-weight: bold; }
.hidden { position: absolute; clip-path: inset(50%); width: 1px; height: 1px; overflow: hidden;
  white-space: nowrap; }
@media (max-width: 30rem) {
  table { font-size: .85rem; } th, td { padding: .1rem .25rem; }
  tbody th, thead th { white-space: normal; }
}
"""
# A browser shows the last page for ever; only its age tells that nobody watches any more. Whoever
# reads the page can keep it as it is: the address remembers that.
_SCRIPT = f"""
const renew = document.getElementById("renew");
const age = Date.now() / 1000 - Number(document.body.dataset.written);
document.getElementById("stale").hidden = !(age > {_STALE_S});
renew.checked = location.hash !== "#paused";
renew.onchange = () => {{ location.hash = renew.checked ? "" : "paused"; }};
setInterval(() => {{ if (renew.checked) location.reload(); }}, {1000 * _REFRESH_S});
"""


def watch_page(
    watcher: Watcher, notes: Sequence[str], now: datetime, *, stopped: bool = False
) -> str:
    """The page as HTML, without anything from elsewhere.

    Args:
        watcher: What was found.
        notes: What hinders, in sentences.
        now: When the watcher last looked.
        stopped: Whether it looks no more.
    """
    name = _text(watcher.settings.campaign.name)
    refresh = f'<noscript><meta http-equiv="refresh" content="{_REFRESH_S}"></noscript>'
    runs = watcher.runs()
    covered = coverage(runs, watcher.settings)
    written = "" if stopped else f' data-written="{int(now.timestamp())}"'
    return "\n".join(
        [
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"{refresh}<title>{name}: verdicts on logs</title>",
            f"<style>{_STYLE}</style>\n</head>",
            f"<body{written}>\n<main>",
            f"<h1>Campaign {name}</h1>",
            *_head(watcher, notes, now, stopped),
            *_next(watcher, runs, covered),
            *_coverage(covered, watcher.settings),
            *_verdicts(watcher),
            f"</main>\n<script>{_SCRIPT}</script>\n</body>\n</html>\n",
        ]
    )


def _head(watcher: Watcher, notes: Sequence[str], now: datetime, stopped: bool) -> Iterator[str]:
    if watcher.settings.campaign.data == "simulated":
        yield "<p><b>SIMULATED data, not a measurement.</b></p>"
    at = f"{now:%Y-%m-%d %H:%M:%S}"
    renew = '<label><input type="checkbox" id="renew" checked> Renew this page</label>'
    yield f"<p>Last look: {at}. {renew}</p>"
    if stopped:
        yield '<p class="note">Stopped. Start <code>oilfilm watch</code> again.</p>'
    yield (
        '<p class="stale" id="stale" role="alert" hidden>This page is no longer renewed. Is '
        "<code>oilfilm watch</code> running?</p>"
    )
    for note in notes:
        yield f'<p class="note">{_text(note)}</p>'


def _next(watcher: Watcher, runs: pd.DataFrame, covered: pd.DataFrame) -> Iterator[str]:
    """The run to do or to repeat next, and why; then the ones after it."""
    steps = list(_steps(watcher, runs, covered))
    yield '<h2>Next</h2>\n<div class="next">'
    if steps:
        what, why = steps[0]
        yield f'<p><span class="what">{what}</span><br>{why}</p>'
    elif watcher.settings.campaign.matrix is None:
        yield "<p>Nothing: the campaign file has no <code>matrix</code>, and no log is refused.</p>"
    else:
        yield "<p>Nothing: every condition of the matrix has an accepted run.</p>"
    yield "</div>"
    if len(steps) > 1:
        yield "<p>Then:</p>\n<ol>"
        yield from (f"<li>{what}<br>{why}</li>" for what, why in steps[1 : 1 + _STEPS_LISTED])
        yield "</ol>"
        if len(steps) > 1 + _STEPS_LISTED:
            yield f"<p>And {len(steps) - 1 - _STEPS_LISTED} more.</p>"


def _steps(
    watcher: Watcher, runs: pd.DataFrame, covered: pd.DataFrame
) -> Iterator[tuple[str, str]]:
    """What to do, and why: refused conditions, logs that may have been for one, missing ones."""
    settings = watcher.settings
    refused = {each.log: each for each in watcher.newest_first() if each.verdict != "accepted"}
    to_do = open_conditions(covered, settings)
    at = with_levels(runs, settings)[["log", "verdict", "oil", *SET_POINTS]]
    at = at[at["verdict"] == "refused"].drop(columns="verdict")
    explained = set()
    for row in tables.rows(to_do[to_do["state"] == "refused"]):
        # merged, because a null set point differs from itself
        logs = list(at.merge(pd.DataFrame([row]), on=["oil", *SET_POINTS])["log"])
        explained |= set(logs)
        yield f"Repeat {_condition(row)}", _why(refused[logs[0]])
    accepted = _logs_of_accepted_conditions(runs, settings)
    for log, verdict in refused.items():
        if log not in explained | accepted:
            yield f"Mend or repeat {_text(log)}", _why(verdict)
    for row in tables.rows(to_do[to_do["state"] == "missing"]):
        yield f"Run {_condition(row)}", "No log of this condition has been read."


def _logs_of_accepted_conditions(runs: pd.DataFrame, settings: Settings) -> set[str]:
    """Logs of which every run is at a condition that has an accepted run as well."""
    at = with_levels(runs, settings)
    good = at.groupby(["oil", *SET_POINTS], dropna=False)["verdict"].transform(
        lambda verdicts: (verdicts == "accepted").any()
    )
    known = at[list(SET_POINTS)].notna().any(axis=1)
    done = (good.astype(bool) & known).groupby(at["log"]).all()
    return set(done.index[done])


def _why(verdict: Verdict) -> str:
    about = f"{_text(verdict.log)} was {verdict.verdict}"
    return f"{about}: {_problem(verdict.problems[0])}" if verdict.problems else f"{about}."


def _coverage(covered: pd.DataFrame, settings: Settings) -> Iterator[str]:
    """One table per oil: pressure and speed of the matrix down, temperature across."""
    planned = planned_states(covered)
    yield "<h2>Coverage of the test matrix</h2>"
    others = covered[~covered["planned"]]
    if planned.empty:
        yield "<p>The campaign file has no <code>matrix</code>.</p>"
    else:
        counts = planned["state"].value_counts()
        yield (
            "<p>"
            + ", ".join(
                f"{_mark(state)} {counts.get(state, 0)} {state}"
                for state in ("accepted", "refused", "missing")
            )
            + f", of {len(planned)} conditions.</p>"
        )
        for oil in settings.oils:
            yield from _matrix(oil, planned[planned["oil"] == oil])
    if len(others):
        yield f"<details><summary>Conditions outside the matrix ({len(others)})</summary>\n<ul>"
        for row in tables.rows(others):
            tested = f"{row['runs_accepted']} accepted, {row['runs_refused']} refused"
            yield f"<li>{_condition(row)}: {tested}</li>"
        yield "</ul></details>"
    yield (
        "<p>Copies of logs and contradictions between logs are found by the workflow only: run "
        "<code>snakemake</code>.</p>"
    )


def _matrix(oil: str, states: pd.DataFrame) -> Iterator[str]:
    label = f"Oil {_text(oil)}"
    yield f'<div class="scroll" role="region" aria-label="{label}" tabindex="0"><table>'
    yield f"<caption>{label}</caption>"
    temperatures = sorted(states[_TEMPERATURE].unique())
    heads = "".join(f'<th scope="col">{value:g} °C</th>' for value in temperatures)
    yield f'<thead><tr><th scope="col">P, U</th>{heads}</tr></thead>\n<tbody>'
    for (pressure, speed), row in states.groupby([_PRESSURE, _SPEED]):
        by_temperature = dict(zip(row[_TEMPERATURE], row["state"], strict=True))
        cells = "".join(_cell(by_temperature[value]) for value in temperatures)
        yield f'<tr><th scope="row">{pressure:g} GPa, {speed:g} m/s</th>{cells}</tr>'
    yield "</tbody></table></div>"


def _cell(state: str) -> str:
    return f'<td class="{state}">{_mark(state)}<span class="hidden">{state}</span></td>'


def _verdicts(watcher: Watcher) -> Iterator[str]:
    """Every log: those that are being written, then the newest first."""
    verdicts = watcher.newest_first()
    yield f'<h2>Verdicts</h2>\n<p>{len(verdicts)} logs judged.</p>\n<ul class="logs">'
    for log in watcher.writing:
        yield f"<li>{_badge('being written')} {_text(log)}</li>"
    for verdict in islice(verdicts, _LOGS_LISTED):
        at = datetime.fromtimestamp(verdict.changed)
        found = f", {verdict.plateaus}" if verdict.plateaus else ""
        yield f"<li>{_badge(verdict.verdict)} {_text(verdict.log)}{found}"
        yield f"<br><small>written {at:%Y-%m-%d %H:%M:%S}</small>"
        if verdict.problems:
            problems = "".join(f"<li>{_problem(each)}</li>" for each in verdict.problems)
            yield f"<ul>{problems}</ul>"
        yield "</li>"
    yield "</ul>"
    if len(verdicts) > _LOGS_LISTED:
        older = len(verdicts) - _LOGS_LISTED
        yield f"<p>{older} older logs are judged and not listed: <code>oilfilm check</code>.</p>"


def _badge(verdict: str) -> str:
    return f'<span class="badge {verdict.replace(" ", "-")}">{_mark(verdict)} {verdict}</span>'


def _mark(state: str) -> str:
    return f'<span aria-hidden="true">{_MARKS[state]}</span>'


def _problem(problem: Problem) -> str:
    advice = f"<br><b>{_text(problem.advice)}</b>" if problem.advice else ""
    return f"{_text(problem.found)}{advice}"


def _condition(row: dict[str, object]) -> str:
    return _text(f"oil {row['oil']} at {describe_condition(row)}")


def _text(text: str) -> str:
    """Text of logs and names, which may hold anything."""
    return escape(printable(text))
