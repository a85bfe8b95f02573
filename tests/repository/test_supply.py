"""What the project takes from others: licences, no pickle, no network."""

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from lint import licences

from campaigns import ROOT

GUARD = ROOT / "tests/guard"
# The clients of object storage open connections of their own.
LIBRARY = list((ROOT / "workflow").rglob("*.py"))
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


@pytest.mark.parametrize("path", LIBRARY, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_no_module_unpickles_or_opens_a_connection(path: Path) -> None:
    modules = set(imported(ast.parse(path.read_text(encoding="utf-8"))))
    # urllib.parse only takes addresses apart
    assert not {name for name in modules - {"urllib.parse"} if name.split(".")[0] in UNSAFE}


def test_licences_are_those_that_the_locked_packages_state() -> None:
    assert licences.TABLE.read_text(encoding="utf-8") == licences.table(), "run `make licences`"


def guarded(program: str, tmp_path: Path) -> tuple[str, str]:
    """What the guard refuses to a program, and what the program says."""
    log = tmp_path / "guard.log"
    environment = {**os.environ, "PYTHONPATH": str(GUARD), "OILFILM_GUARD": str(log)}
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    return log.read_text(encoding="utf-8") if log.exists() else "", done.stderr


@pytest.mark.parametrize(
    ("program", "refused"),
    [
        ("import socket; socket.create_connection(('192.0.2.1', 80), 1)", "192.0.2.1"),
        ("import socket; socket.getaddrinfo('example.invalid', 80)", "example.invalid"),
        ("import pickle; pickle.loads(b'cos\\nsystem\\n(S\"true\"\\ntR.')", "os.system"),
        ("import socket; s = socket.socket(); s.bind(('127.0.0.1', 0))", ""),
        ("import pickle; pickle.loads(pickle.dumps([1, 'a']))", ""),
    ],
    ids=["address", "name", "pickle", "loopback", "plain values"],
)
def test_guard_of_the_workflow_tests_refuses_what_it_should(
    program: str, refused: str, tmp_path: Path
) -> None:
    log, message = guarded(program, tmp_path)
    assert refused in log
    assert bool(refused) == bool(log) == ("refused by the tests' guard" in message)
