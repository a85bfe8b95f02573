"""A scheduled run: new logs in, a release, the drift gate against the pin, and a summary."""

import os
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from oilfilm import tables
from oilfilm.atomic_write import write_text
from oilfilm.errors import OilfilmError, printable
from oilfilm.releases.compare import compare
from oilfilm.releases.drift import drift_table
from oilfilm.releases.messages import section_text
from oilfilm.releases.page import page
from oilfilm.releases.rebuild import rebuild
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.releases.tree import PINS
from oilfilm.settings.config import DriftSettings

FOLDER = Path("results/nightly")
# Entries of a list in the summary, and lines of what a failed run printed last.
_LONGEST = 50
EXIT_CODES = {"well": 0, "drift": 1, "failure": 2}
StepName = Literal["release", "drift gate", "rebuild"]
Result = Literal["passed", "failed", "not run"]


class Step(BaseModel):
    """One step of a scheduled run."""

    model_config = ConfigDict(extra="forbid")

    name: StepName = Field(description="release, drift gate or rebuild")
    result: Result = Field(description="passed, failed or not run")
    message: str = Field(description="what was found; why it failed or was not run")


class RefusedLog(BaseModel):
    """A log, or a run of it, that was refused and is new since the release before."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    log: str = Field(description="name of the log, or of its run")
    rule: str = Field(description="the gate that refused it")
    reason: str = Field(description="what was found and what was expected")
    advice: str = Field(description="what to do")


class ChangedLogs(BaseModel):
    """How the raw logs differ from those of the release before."""

    model_config = ConfigDict(extra="forbid")

    total: int = Field(description="raw logs of the release, run sheets included")
    new: int = Field(description="logs that the release before lacks")
    changed: int = Field(description="logs with another content than in the release before")
    removed: int = Field(description="logs that only the release before has")
    named: list[str] = Field(description=f"the first {_LONGEST} of them, by path")


class NightlySummary(BaseModel):
    """What a scheduled run found: results/nightly/<campaign>.json, and what a webhook gets."""

    model_config = ConfigDict(extra="forbid")

    campaign: str = Field(description="name of the campaign")
    outcome: Literal["well", "drift", "failure"] = Field(
        default="failure", description="well, drift or failure"
    )
    text: str = Field(default="", description="the outcome in one sentence")
    started: str = Field(description="date and time in UTC, ISO 8601")
    seconds: float = Field(default=0.0, description="duration")
    steps: list[Step] = Field(default=[], description="the steps in their order")
    release: str | None = Field(
        default=None, description="folder of the release; null where none is made"
    )
    before: str | None = Field(default=None, description="version of the release before it")
    pin: str | None = Field(default=None, description="version that is pinned; null where none is")
    logs: ChangedLogs | None = Field(
        default=None, description="how the raw logs changed; null without a release"
    )
    runs: dict[str, int] = Field(default={}, description="runs by verdict")
    refused: list[RefusedLog] = Field(
        default=[], description=f"newly refused, the first {_LONGEST}"
    )
    moved: list[list[str]] = Field(
        default=[], description="changes beyond the limits: oil, what, pinned, now, change, limit"
    )
    report: str | None = Field(default=None, description="path of the release's report")
    comparison: str | None = Field(default=None, description="path of the page of what moved")

    @property
    def exit_code(self) -> int:
        """0 where all is well, 1 for drift, 2 for a failure."""
        return EXIT_CODES[self.outcome]


@dataclass(frozen=True)
class Night:
    """A scheduled run of a campaign in the working folder.

    Attributes:
        campaign: Name of the campaign.
        drift: `drift` of its configuration.
        cores: For snakemake.
        rebuild: Whether to make the release a second time and compare the bytes.
        show: Gets each line that snakemake prints.
    """

    campaign: str
    drift: DriftSettings
    cores: str
    rebuild: bool
    show: Callable[[str], None]

    def run(self) -> NightlySummary:
        """Run the steps release, drift gate and rebuild; one that fails ends the rest.

        A campaign without a pin passes the gate, with a sentence about how to pin it.
        """
        began = time.time()
        utc = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(began))
        summary = NightlySummary(campaign=self.campaign, started=utc)
        steps: dict[StepName, Callable[[NightlySummary], str]] = {
            "release": self._release,
            "drift gate": self._gate,
            **({"rebuild": self._rebuild} if self.rebuild else {}),
        }
        failed = ""
        for name, step in steps.items():
            done = Step(name=name, result="not run", message=f"{failed} failed")
            if not failed:
                try:
                    done.message, done.result = step(summary), "passed"
                except OilfilmError as mistake:
                    done.message, done.result, failed = str(mistake), "failed", name
            summary.steps.append(done)
        summary.seconds = round(time.time() - began, 1)
        summary.outcome = "drift" if summary.moved else "failure" if failed else "well"
        summary.text = _sentence(summary, failed)
        return summary

    @property
    def _latest(self) -> Path:
        return Path("results/releases", self.campaign, "latest")

    @property
    def _page(self) -> Path:
        return FOLDER / f"{self.campaign}.html"

    def _release(self, summary: NightlySummary) -> str:
        """Run snakemake; say what is new in the release."""
        self._page.unlink(missing_ok=True)  # another night's
        before = StoredRelease.open(self._latest.resolve()) if self._latest.is_dir() else None
        run_workflow(self.campaign, self.cores, self.show)
        now = StoredRelease.open(self._latest.resolve())
        summary.release = now.folder.relative_to(Path.cwd()).as_posix()
        summary.report = f"{summary.release}/report.html" if "report.html" in now.files else None
        summary.before = before.manifest.version if before else None
        summary.logs = _changed_logs(before, now)
        runs = now.table("runs")
        if runs is not None:
            counts = runs["verdict"].value_counts().sort_index()
            summary.runs = {str(verdict): int(count) for verdict, count in counts.items()}
        known = set(_refused(before)) if before else set()
        summary.refused = [each for each in _refused(now) if each not in known][:_LONGEST]
        return summary.release

    def _gate(self, summary: NightlySummary) -> str:
        """Hold the release against the pin."""
        pin = Path(PINS, self.campaign)
        if not pin.is_dir():
            return f"there is no pin: `oilfilm pin {self._latest}` keeps this release as one"
        pinned, now = StoredRelease.open(pin), StoredRelease.open(self._latest)
        summary.pin = pinned.manifest.version
        comparison = compare(pinned, now, self.drift)
        too_far = drift_table(comparison, self.drift)
        text = page(comparison, too_far).encode("utf-8", "backslashreplace").decode()
        write_text(text, self._page)
        summary.comparison = self._page.as_posix()
        summary.moved = [list(row) for row in too_far.rows]
        if too_far.rows:
            raise OilfilmError(section_text(too_far, len(too_far.rows)))
        return f"nothing moved beyond the limits since {pinned.manifest.version}"

    def _rebuild(self, summary: NightlySummary) -> str:
        """Make the release again."""
        if differences := rebuild(self._latest, Path(), self.cores):
            raise OilfilmError("\n".join(map(printable, differences)))
        return "rebuilt from the raw logs: the same bytes"


def run_workflow(campaign: str, cores: str, show: Callable[[str], None]) -> None:
    """Let snakemake make the release of a campaign in the working folder.

    Raises:
        OilfilmError: It failed; the message is what it printed last.
    """
    command = [sys.executable, "-m", "snakemake", "release", "--cores", cores]
    last = deque[str](maxlen=_LONGEST)
    with subprocess.Popen(  # noqa: S603 - a fixed command; campaign and cores are arguments
        [*command, "--config", f"campaign={campaign}"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    ) as process:
        for line in process.stdout or ():
            show(line.rstrip("\n"))
            last.append(line.rstrip("\n"))
    if process.returncode:
        raise OilfilmError("\n".join(last))


def _changed_logs(before: StoredRelease | None, now: StoredRelease) -> ChangedLogs:
    old, new = (
        {record.path: record for record in stored.manifest.raw} if stored else {}
        for stored in (before, now)
    )
    added, removed = new.keys() - old.keys(), old.keys() - new.keys()
    changed = {path for path in old.keys() & new.keys() if old[path] != new[path]}
    named = sorted(added | changed | removed)[:_LONGEST]
    sizes = {"new": len(added), "changed": len(changed), "removed": len(removed)}
    return ChangedLogs(total=len(new), **sizes, named=named)


def _refused(stored: StoredRelease) -> list[RefusedLog]:
    """What a release refused; nothing where its tables are of another schema version."""
    if stored.manifest.made_from["schema_version"] != tables.SCHEMA_VERSION:
        return []
    paths = ("tables/quarantine.parquet", "tables/torque_quarantine.parquet")
    frames = [tables.read("quarantine", stored.file(path)) for path in paths if stored.holds(path)]
    return [
        RefusedLog(
            log=row["run_id"] or row["file"],
            rule=row["rule"],
            reason=row["reason"],
            advice=row["advice"],
        )
        for frame in frames
        for row in tables.rows(frame)
    ]


def _sentence(summary: NightlySummary, failed: str) -> str:
    """The outcome in one sentence."""
    name = f"oilfilm {summary.campaign}"
    logs = f"{summary.logs.new} new logs" if summary.logs else "no release"
    if summary.outcome == "drift":
        return f"{name}: DRIFT: {len(summary.moved)} values beyond the limits; {logs}"
    if failed:
        return f"{name}: FAILED at the step {failed}; {logs}"
    unpinned = "" if summary.pin else ", no pin to compare with"
    return f"{name}: all well{unpinned}; {logs}, {len(summary.refused)} newly refused"


def as_markdown(summary: NightlySummary) -> str:
    """The summary for people."""
    lines = [f"# {printable(summary.text)}", ""]
    if summary.logs:
        changes = summary.logs
        lines.append(
            f"Raw logs: {changes.total}, of them {changes.new} new, {changes.changed} changed; "
            f"{changes.removed} removed."
        )
    if summary.runs:
        runs = ", ".join(f"{count} {verdict}" for verdict, count in summary.runs.items())
        lines.append(f"Runs: {runs}.")
    for name, path in (("Report", summary.report), ("Comparison with the pin", summary.comparison)):
        lines += [f"{name}: `{path}`"] if path else []
    if summary.refused:
        lines += ["", "## Newly refused", ""]
    for each in summary.refused:
        found = f"{each.log}: {each.rule}: {each.reason}"
        lines += _block(f"{printable(found)}\n-> {printable(each.advice)}")
    for step in summary.steps:
        lines += ["", f"## {step.name}: {step.result}", "", *_block(step.message)]
    return "\n".join(lines) + "\n"


def _block(text: str) -> list[str]:
    """A text as it is, fenced by more backquotes than are in it."""
    fence = "`" * 4
    return [fence, *text.replace(fence, "'" * 4).strip().splitlines(), fence]


def write_summary(summary: NightlySummary) -> Path:
    """Write the summary as JSON and as Markdown, and show it where GitHub runs the job."""
    text = as_markdown(summary)
    write_text(text, FOLDER / f"{summary.campaign}.md")
    write_text(summary.model_dump_json(indent=2) + "\n", FOLDER / f"{summary.campaign}.json")
    if "GITHUB_STEP_SUMMARY" in os.environ:
        with Path(os.environ["GITHUB_STEP_SUMMARY"]).open("a", encoding="utf-8") as shown:
            shown.write(text)
    return FOLDER / f"{summary.campaign}.json"
