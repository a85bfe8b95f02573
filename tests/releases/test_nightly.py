"""A scheduled run: what is new, what moved, and who is told."""

import json
import shutil
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any, ClassVar

import jsonschema
import pytest

from command_line import SCHEMAS
from oilfilm import tables
from oilfilm.cli import main
from oilfilm.errors import OilfilmError
from oilfilm.releases import nightly
from oilfilm.releases.hook import send
from oilfilm.releases.pin import pin
from oilfilm.releases.tree import PINS
from oilfilm.settings.resolved import Settings
from releases import made, project, released, runs_of

SCHEMA = json.loads((SCHEMAS / "nightly.schema.json").read_text(encoding="utf-8"))
Rig = Callable[[Mapping[str, bytes]], None]


@pytest.fixture
def rig(config: Settings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Rig:
    """Sets the logs of a project, of which the last one is refused; the night releases them."""
    root = project(tmp_path / "p")
    shutil.rmtree(root / PINS)
    monkeypatch.chdir(root)
    monkeypatch.delenv("GITHUB_STEP_SUMMARY", raising=False)
    logs: dict[str, bytes] = {}

    def run(campaign: str, cores: str, show: Callable[[str], None]) -> None:
        show("2 of 2 steps done")
        last = max(logs)
        refused = {name: "" for name in tables.columns("quarantine")} | {
            **{"campaign": "demo", "file": last, "run_id": last, "stage": "curate"},
            **{"rule": "truncated", "reason": "ends in a row", "advice": "Repeat the run."},
            **{"first_row": 1, "last_row": 2, "refused_rows": 1},
        }
        frames = {
            "runs": runs_of(logs, root),
            "quarantine": tables.from_rows([refused], "quarantine"),
        }
        released(made(root, config, logs, frames))

    monkeypatch.setattr(nightly, "run_workflow", run)
    return logs.update


def night(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, Any]]:
    """The exit code of `oilfilm nightly`, and its summary."""
    capsys.readouterr()
    code = main(["nightly", "--json", *arguments])
    summary = json.loads(capsys.readouterr().out)
    jsonschema.validate(summary, SCHEMA)
    return code, summary


def test_new_logs_and_new_refusals_are_named(rig: Rig, capsys: pytest.CaptureFixture[str]) -> None:
    rig({"a.csv": b"1\n"})
    code, first = night(capsys)
    assert (code, first["outcome"], first["before"]) == (0, "well", None)
    rig({"b.csv": b"2\n", "a.csv": b"1.1\n"})
    code, second = night(capsys)
    assert (code, second["before"]) == (0, Path(first["release"]).name)
    assert second["logs"] == {
        **{"total": 2, "new": 1, "changed": 1, "removed": 0},
        "named": ["data/raw/demo/a.csv", "data/raw/demo/b.csv"],
    }
    assert [each["log"] for each in second["refused"]] == ["b.csv"]
    assert second["runs"] == {"accepted": 2}
    kept = json.loads(Path("results/nightly/demo.json").read_text(encoding="utf-8"))
    assert kept == second
    assert "b.csv: truncated" in Path("results/nightly/demo.md").read_text(encoding="utf-8")


def test_unpinned_campaign_is_told_the_command_that_pins_it(
    rig: Rig, capsys: pytest.CaptureFixture[str]
) -> None:
    rig({"a.csv": b"1\n"})
    _, first = night(capsys)
    (gate,) = (step for step in first["steps"] if step["name"] == "drift gate")
    command = gate["message"].split("`")[1].split()
    assert command[0] == "oilfilm"
    assert main(command[1:]) == 0
    _, second = night(capsys)
    assert second["pin"] == Path(first["release"]).name
    assert "nothing moved" in second["steps"][1]["message"]


def test_failed_workflow_is_a_failure_with_what_it_printed_last(
    rig: Rig, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(*_: Any) -> None:
        raise OilfilmError("campaign 'demo': too few accepted runs")

    monkeypatch.setattr(nightly, "run_workflow", run)
    code, summary = night(capsys, "--rebuild")
    assert (code, summary["outcome"], summary["release"]) == (2, "failure", None)
    assert [step["result"] for step in summary["steps"]] == ["failed", "not run", "not run"]
    assert "too few accepted runs" in summary["steps"][0]["message"]


def test_release_that_cannot_be_compared_with_its_pin_is_a_failure(
    rig: Rig, capsys: pytest.CaptureFixture[str]
) -> None:
    rig({"a.csv": b"1\n"})
    _, summary = night(capsys)
    (pin(Path(summary["release"]), Path()) / "pinned-manifest.json").write_text("{}")
    code, summary = night(capsys)
    assert (code, summary["outcome"]) == (2, "failure")
    assert "pinned-manifest.json" in summary["steps"][1]["message"]


class Webhook(BaseHTTPRequestHandler):
    """Answers with the status that the path names, and keeps what it gets."""

    bodies: ClassVar[list[bytes]] = []

    def do_POST(self) -> None:
        status = int(self.path.rpartition("/")[2])
        self.bodies.append(self.rfile.read(int(self.headers["Content-Length"])))
        self.send_response(status)
        if status == 302:
            self.send_header("Location", "/200")
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *_: Any) -> None:
        pass


@pytest.fixture
def webhook() -> Iterator[str]:
    """Address of a server on this computer."""
    Webhook.bodies.clear()
    server = HTTPServer(("127.0.0.1", 0), Webhook)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}/secret"
    server.shutdown()
    thread.join()
    server.server_close()


def test_webhook_gets_the_summary(
    rig: Rig, webhook: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    rig({"a.csv": b"1\n"})
    monkeypatch.setenv("OILFILM_HOOK", f"{webhook}/200")
    code, summary = night(capsys)
    assert code == 0
    assert [json.loads(body) for body in Webhook.bodies] == [summary]


def test_hook_that_fails_fails_the_night_and_not_silently(
    rig: Rig, webhook: str, capsys: pytest.CaptureFixture[str]
) -> None:
    rig({"a.csv": b"1\n"})
    assert main(["nightly", "--hook", f"{webhook}/500"]) == 2
    errors = capsys.readouterr().err
    assert "127.0.0.1 answers 500" in errors
    assert "secret" not in errors


@pytest.mark.parametrize(
    ("hook", "reason"),
    [
        ("http://lab.example/x", "expected https://HOST"),
        ("file:///etc/hosts", "expected https://HOST"),
        ("ftp://127.0.0.1/x", "expected https://HOST"),
        ("https://[bad/x", "expected https://HOST"),
        ("http://127.0.0.1:1/x", "cannot be reached"),
        ("http://127.0.0.1:1/a b", "without blanks"),
        ("no-such-mail-program -s x", "cannot be run"),
        ("mail 'lab", "cannot be run"),
        (f"{sys.executable} -c 'raise SystemExit(3)'", "ends with exit code 3"),
    ],
)
def test_hook_that_cannot_work_is_refused_in_a_sentence(hook: str, reason: str) -> None:
    with pytest.raises(OilfilmError, match=r"^--hook: ") as refused:
        send(hook, "{}", "text")
    assert reason in str(refused.value)


def test_redirect_is_not_followed(webhook: str) -> None:
    with pytest.raises(OilfilmError, match="answers 302"):
        send(f"{webhook}/302", "{}", "text")
    assert len(Webhook.bodies) == 1


def test_command_reads_the_text_and_no_shell_runs(tmp_path: Path) -> None:
    script = "import sys; open(sys.argv[1], 'w').write(sys.stdin.read() + sys.argv[2])"
    kept = tmp_path / "mail.txt"
    send(f'{sys.executable} -c "{script}" {kept} $(date)', "{}", "all well; ")
    assert kept.read_text() == "all well; $(date)"
