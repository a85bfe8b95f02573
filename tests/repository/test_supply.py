"""What the project takes from others: licences, no pickle, no network."""

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from campaigns import ROOT

GUARD = ROOT / "tests/guard"
UNSAFE = {
    *("pickle", "cPickle", "cloudpickle", "dill", "joblib", "marshal", "shelve"),
    *("socket", "ssl", "urllib", "http", "ftplib", "smtplib", "asyncio", "requests", "urllib3"),
    *("httpx", "aiohttp", "websockets", "fsspec", "smart_open", "boto3", "botocore"),
}


def imported(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


def test_no_module_unpickles_or_opens_a_connection() -> None:
    for path in (ROOT / "workflow").rglob("*.py"):
        modules = set(imported(ast.parse(path.read_text(encoding="utf-8"))))
        # urllib.parse only takes addresses apart
        unsafe = {name for name in modules - {"urllib.parse"} if name.split(".")[0] in UNSAFE}
        assert not unsafe, path


@pytest.mark.parametrize(
    ("program", "refused"),
    [
        ("import socket; socket.create_connection(('192.0.2.1', 80), 1)", "192.0.2.1"),
        ("import pickle; pickle.loads(b'cos\\nsystem\\n(S\"true\"\\ntR.')", "os.system"),
        (
            "import pickle, socket; socket.socket().bind(('127.0.0.1', 0))\n"
            "pickle.loads(pickle.dumps([1, 'a']))",
            "",
        ),
    ],
    ids=["address", "pickle", "harmless"],
)
def test_guard_of_the_workflow_tests_refuses_what_it_should(
    program: str, refused: str, tmp_path: Path
) -> None:
    log = tmp_path / "guard.log"
    environment = {**os.environ, "PYTHONPATH": str(GUARD), "OILFILM_GUARD": str(log)}
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    written = log.read_text(encoding="utf-8") if log.exists() else ""
    assert refused in written
    assert bool(refused) == bool(written) == ("refused by the tests' guard" in done.stderr)
