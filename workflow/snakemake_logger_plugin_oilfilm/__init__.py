"""What a run prints: progress with the time left, then mistakes; Snakemake's log has the details.

Snakemake finds this module by its name. `logger: oilfilm` in profiles/default chooses it, and
`snakemake --logger rich` another one.
"""

import shutil
import sys
import time
from collections import Counter
from logging import INFO, LogRecord
from typing import Any, TextIO

from snakemake.logging import ColorizingTextHandler, DefaultFormatter
from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

# Seconds that a step of the demonstration took on two cores; only their ratios count.
_SECONDS = {
    **{"bearing_maps": 51, "compare": 35, "law_figures": 29, "torque": 27, "heat_balance": 22},
    **{"bearing_figures": 20, "refused": 17, "claims_figures": 15, "data_figures": 14},
    **{"report": 13, "audit": 7, "release": 7, "twin": 7, "fit": 6, "ingest": 5, "curate": 5},
}
_SECONDS_ELSE = 3

# Without a terminal: at most so many lines.
_LINES = 8
# An estimate from less time than this is a guess.
_SECONDS_BEFORE_ESTIMATE = 5

# What Snakemake says at every run.
_USUAL = (
    "Using workflow specific profile",
    "Assuming unrestricted shared filesystem usage",
    "Building DAG of jobs",
    "Using shell:",
    "Provided cores:",
    "Rules claiming more threads",
    "Provided resources:",
    "Select jobs to execute",
    "Updating checkpoint dependencies",
    "DAG of jobs will be updated",
    "Removing output files of failed job",
    "Storing in storage:",
    "Finished upload.",
    "Retrieving from storage:",
    "Finished download.",
    "Removing local copy of storage file:",
    "Complete log(s):",
    "Elapsed time:",
    "SLURM run ID:",
    "Cleaning up SLURM log files",
)
_SUBMITTED = "has been submitted with SLURM jobid"
# to the logs, which the same line names
_POINTER = "For further error details"
_RETRY = "Trying to restart job"


class Progress:
    """Which steps of a run are done, which are active, and about how long the others take."""

    def __init__(self) -> None:
        self.done = 0
        self.total = 0
        self.active: dict[int, str] = {}
        self._of_rule: dict[int, str] = {}
        self._planned: Counter[str] = Counter()
        self._finished: Counter[str] = Counter()
        self._started = time.monotonic()

    def plan(self, stats: dict[str, int]) -> None:
        """Take the number of steps of each rule, as Snakemake counts them before it starts."""
        self._planned = Counter({rule: n for rule, n in stats.items() if rule != "total"})
        self.total = self._planned.total()

    def start(self, job: int, rule: str, label: str) -> None:
        """A step begins."""
        self._of_rule[job] = rule
        self.active[job] = label

    def finish(self, job: int) -> None:
        """A step is done."""
        self._finished[self._of_rule.get(job, "")] += 1
        self.active.pop(job, None)

    def time_left(self) -> str:
        """About how long the run takes from now on; empty where nobody can tell yet."""
        elapsed = time.monotonic() - self._started
        left = self._planned - self._finished
        # a checkpoint may have added steps that nobody counted
        more = max(self.total - self.done - left.total(), 0) * _SECONDS_ELSE
        work_left, work_done = _work(left) + more, _work(self._finished)
        if elapsed < _SECONDS_BEFORE_ESTIMATE or not work_done or not work_left:
            return ""
        seconds = elapsed * work_left / work_done
        about = f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"
        return f", about {about} left"


def _work(steps: Counter[str]) -> float:
    return sum(count * _SECONDS.get(rule, _SECONDS_ELSE) for rule, count in steps.items())


class LogHandler(LogHandlerBase):
    """Shows progress, and every message of Snakemake that is not said at each run."""

    def __post_init__(self) -> None:
        """Choose the stream, and whether a line can be written anew."""
        common = self.common_settings
        self.stream: TextIO = sys.stdout if common.stdout else sys.stderr
        self.plain = ColorizingTextHandler(nocolor=common.nocolor, stream=self.stream)
        self.plain.setFormatter(DefaultFormatter(common.quiet, common.show_failed_logs))
        # who asks for details gets them as Snakemake prints them
        self.as_usual = common.dryrun or common.verbose or common.printshellcmds or common.debug_dag
        self.live = self.plain.can_color_tty()
        self.progress = Progress()
        self.lines_written = 0

    def emit(self, record: LogRecord) -> None:
        """Show a record; called in a thread of its own, one record at a time."""
        try:
            self._show(record)
        except Exception:
            self.handleError(record)

    def _show(self, record: LogRecord) -> None:
        event = getattr(record, "event", None)
        shown = {
            LogEvent.RUN_INFO: self._plan,
            LogEvent.JOB_INFO: self._start,
            LogEvent.JOB_FINISHED: self._finish,
            LogEvent.PROGRESS: self._count,
            LogEvent.JOB_ERROR: self._fail,
            LogEvent.GROUP_ERROR: self._fail_group,
        }
        if self.as_usual:
            self.plain.emit(record)
        elif event in shown:
            shown[event](record)
        elif record.levelno > INFO:
            # a script has printed its own reason
            if "CalledProcessError in file" not in record.getMessage():
                self._erase()
                self.plain.emit(record)
        elif event is None:
            self._say(record.getMessage().strip())

    def _say(self, text: str) -> None:
        if text.startswith(_RETRY):
            self._write("It is tried again.")
        elif not text.startswith(_USUAL) and _SUBMITTED not in text:
            self._erase()
            print(text, file=self.stream, flush=True)

    def _plan(self, record: Any) -> None:
        self.progress.plan(record.stats)
        self._write(f"{self.progress.total} steps")

    def _start(self, record: Any) -> None:
        of = ", ".join(str(value) for value in record.wildcards.values())
        self.progress.start(record.jobid, record.rule_name, f"{record.rule_name} {of}".strip())
        self._draw()

    def _finish(self, record: Any) -> None:
        self.progress.finish(record.job_id)

    def _count(self, record: Any) -> None:
        progress = self.progress
        progress.done, progress.total = record.done, record.total
        self._draw()
        lines = _LINES * progress.done // max(progress.total, 1)
        if not self.live and lines > self.lines_written:
            self.lines_written = lines
            self._write(f"{progress.done} of {progress.total} steps done{progress.time_left()}")

    def _fail(self, record: Any) -> None:
        label = self.progress.active.pop(record.jobid, record.rule_name)
        if getattr(record, "indent", False):
            return  # a member of a group, which is named as a whole
        message = (getattr(record, "rule_msg", None) or "").partition(_POINTER)[0]
        reason = f" ({message})" if message else ""
        self._write(f"FAILED: {label}{reason}; its log: {', '.join(record.log) or 'none'}")

    def _fail_group(self, record: Any) -> None:
        rules = ", ".join(dict.fromkeys(job["rule_name"] for job in record.job_error_info))
        logs = ", ".join(record.aux_logs) or "none"
        self._write(f"FAILED: one of {rules} (group {record.groupid}); the log of all: {logs}")

    def _write(self, text: str) -> None:
        self._erase()
        print(f"[{time.strftime('%H:%M:%S')}] {text}", file=self.stream, flush=True)

    def _draw(self) -> None:
        """Write the line of progress anew. A job that prints something overwrites it."""
        if self.live:
            progress = self.progress
            steps = f"{progress.done} of {progress.total} steps done{progress.time_left()}"
            text = f"{steps}: {', '.join(progress.active.values())}".removesuffix(": ")
            width = shutil.get_terminal_size().columns - 1
            print(f"\x1b[2K{text[:width]}\r", end="", file=self.stream, flush=True)

    def _erase(self) -> None:
        if self.live:
            print("\x1b[2K", end="", file=self.stream, flush=True)

    def close(self) -> None:
        """End the line of progress."""
        self._erase()
        self.live = False
        super().close()

    @property
    def writes_to_stream(self) -> bool:
        """It takes the place of Snakemake's own output."""
        return True

    @property
    def writes_to_file(self) -> bool:
        """Snakemake's own log has the details."""
        return False

    @property
    def has_filter(self) -> bool:
        """`--quiet` counts."""
        return False

    @property
    def has_formatter(self) -> bool:
        """It has one for Snakemake's own messages."""
        return True

    @property
    def needs_rulegraph(self) -> bool:
        """No graph is shown."""
        return False
