"""What a run prints: few lines, the time left, each mistake."""

import io
import logging
import re
from typing import Any

import pytest
from snakemake.settings.types import OutputSettings
from snakemake_interface_logger_plugins.common import LogEvent

import snakemake_logger_plugin_oilfilm as plugin


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time in seconds, which a test sets."""
    now = [0.0]
    monkeypatch.setattr(plugin.time, "monotonic", lambda: now[0])
    return now


def handler(
    monkeypatch: pytest.MonkeyPatch, stream: io.StringIO, **settings: Any
) -> plugin.LogHandler:
    monkeypatch.setattr(plugin.sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    return plugin.LogHandler(OutputSettings(**settings), None)


def send(to: plugin.LogHandler, message: str | None = None, level: int = 20, **more: Any) -> None:
    to.emit(logging.makeLogRecord({"msg": message, "levelno": level, "levelname": "INFO", **more}))


def start(to: plugin.LogHandler, job: int, rule: str, **wildcards: str) -> None:
    event = LogEvent.JOB_INFO
    send(to, event=event, jobid=job, rule_name=rule, wildcards=wildcards, input=["x" * 9000])


def finish(to: plugin.LogHandler, job: int, total: int) -> None:
    send(to, event=LogEvent.JOB_FINISHED, job_id=job)
    send(to, event=LogEvent.PROGRESS, done=job, total=total)


def test_long_run_prints_few_lines_without_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    to = handler(monkeypatch, stream)
    send(to, event=LogEvent.RUN_INFO, stats={"curate": 500, "total": 500})
    for job in range(1, 501):
        send(to, "Select jobs to execute...")
        start(to, job, "curate", shard=str(job))
        finish(to, job, 500)
    lines = stream.getvalue().splitlines()
    assert len(lines) <= 10
    assert max(map(len, lines)) < 100
    assert "500 of 500 steps done" in lines[-1]


def test_time_left_weighs_slow_steps(monkeypatch: pytest.MonkeyPatch, clock: list[float]) -> None:
    """A figure of maps takes 17 times as long as a step that nobody timed: 51 s against 3 s."""
    stream = io.StringIO()
    to = handler(monkeypatch, stream)
    send(to, event=LogEvent.RUN_INFO, stats={"fits": 1, "bearing_maps": 1, "total": 2})
    start(to, 1, "fits")
    clock[0] = 6.0
    finish(to, 1, 2)
    assert "1 of 2 steps done, about 2 min left" in stream.getvalue()  # 6 s * 51 / 3 = 102 s


def test_terminal_has_one_line_of_progress_no_wider_than_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stream = Terminal()
    monkeypatch.setenv("COLUMNS", "60")
    to = handler(monkeypatch, stream)
    send(to, event=LogEvent.RUN_INFO, stats={"fit": 9, "total": 9})
    for job in range(1, 10):
        start(to, job, "fit", oil="an-oil-with-a-long-name")
    finish(to, 1, 9)
    to.close()
    shown = stream.getvalue()
    assert shown.count("\n") == 1  # the number of steps; the rest is written over
    drawn = re.findall(r"\x1b\[2K([^\x1b\r\n]+)\r", shown)
    assert drawn[-1].startswith("1 of 9 steps done: fit an-oil")
    assert max(map(len, drawn)) < 60
    assert shown.endswith("\x1b[2K")


def test_failed_step_is_named_with_its_log(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    to = handler(monkeypatch, stream)
    start(to, 7, "fit", oil="4102")
    noise = "RuleException:\nCalledProcessError in file fit.smk, line 3:\nCommand 'python fit.py'"
    send(to, noise, 40, event=LogEvent.ERROR, exception="RuleException")
    log = ["results/june/logs/fit-4102.log"]
    send(to, event=LogEvent.JOB_ERROR, level=40, jobid=7, rule_name="fit", log=log)
    send(to, "Missing input files for rule fit: points.parquet", 40, event=LogEvent.ERROR)
    text = stream.getvalue()
    assert "FAILED: fit 4102; its log: results/june/logs/fit-4102.log" in text
    assert "CalledProcessError" not in text
    assert "Missing input files for rule fit" in text


def test_failed_job_of_a_cluster_says_why_and_that_it_is_tried_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stream = io.StringIO()
    to = handler(monkeypatch, stream)
    start(to, 7, "fit", oil="4102")
    send(to, "Job 7 has been submitted with SLURM jobid 31 (log: slurm/31.log).")
    log, why = ["results/june/logs/fit-4102.log", "slurm/31.log"], "status is: 'OUT_OF_MEMORY'"
    told = f"{why}For further error details see the log files."
    error = {"event": LogEvent.JOB_ERROR, "level": 40, "indent": False, "rule_msg": told}
    send(to, **error, jobid=7, rule_name="fit", log=log)
    send(to, "Trying to restart job 7.")
    lines = [line.partition("] ")[2] for line in stream.getvalue().splitlines()]
    assert lines == [f"FAILED: fit 4102 ({why}); its log: {', '.join(log)}", "It is tried again."]


def test_failed_group_is_named_once_with_the_log_that_has_the_reason(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stream = io.StringIO()
    to = handler(monkeypatch, stream)
    jobs = [{"rule_name": rule, "indent": True, "jobid": 1, "log": []} for rule in "abb"]
    group = {"groupid": "share", "aux_logs": ["slurm/5.log"], "job_error_info": jobs}
    send(to, "Error in group share", 40, event=LogEvent.GROUP_ERROR, **group)
    for job in jobs:
        send(to, "Error in rule", 40, event=LogEvent.JOB_ERROR, **job)
    text = stream.getvalue()
    assert "FAILED: one of a, b (group share); the log of all: slurm/5.log" in text
    assert text.count("\n") == 1


def test_what_is_not_said_at_every_run_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    to = handler(monkeypatch, stream)
    send(to, "Nothing to be done (all requested files are present and up to date).")
    send(to, "Building DAG of jobs...")
    send(to, "the lock of a network folder is slow", 30)
    assert stream.getvalue().splitlines() == [
        "Nothing to be done (all requested files are present and up to date).",
        "the lock of a network folder is slow",
    ]


def test_dry_run_prints_what_snakemake_prints(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    to = handler(monkeypatch, stream, dryrun=True)
    send(to, "Job stats:\nfit 1", event=LogEvent.RUN_INFO, stats={"fit": 1, "total": 1})
    assert "Job stats:" in stream.getvalue()
