"""What the project takes from others: no pickle, no network."""

import os
import re
import sys
from pathlib import Path

import pytest

from campaigns import ROOT
from command_line import outcome

GUARD = ROOT / "tests/guard"
# urllib.parse only takes addresses apart
UNSAFE = re.compile(
    r"(?m)^\s*(?:import|from) (?:c?pickle|cloudpickle|dill|joblib|marshal|shelve|socket|ssl|urllib"
    r"(?!\.parse)|urllib3|http|ftplib|smtplib|asyncio|requests|httpx|aiohttp|websockets|fsspec"
    r"|smart_open|boto3|botocore)\b"
)


def test_no_module_unpickles_or_opens_a_connection() -> None:
    paths = (ROOT / "workflow").rglob("*.py")
    assert not [path for path in paths if UNSAFE.search(path.read_text(encoding="utf-8"))]


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
def test_guard_refuses_what_it_should(program: str, refused: str, tmp_path: Path) -> None:
    log = tmp_path / "guard.log"
    environment = {**os.environ, "PYTHONPATH": str(GUARD), "OILFILM_GUARD": str(log)}
    _, text = outcome([sys.executable, "-c", program], env=environment)
    written = log.read_text(encoding="utf-8") if log.exists() else ""
    assert refused in written
    assert bool(refused) == bool(written) == ("refused by the tests' guard" in text)
