"""Whatever happens to a file: a verdict, never a traceback, and no row lost."""

from collections import Counter
from typing import Any

import pytest

from campaigns import ROOT
from damages import SOUND
from formats import WRITERS
from mutations import carry, mutate
from oilfilm.randomness import generator
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings

FILES = 100  # of each format; `make bench-fuzz` takes 20 000


def test_damaged_pcs_logs_end_in_a_verdict(real_pcs: Any) -> None:
    config = resolve(ROOT / "config", {"campaign": "etm-slim"})
    random = generator(1, "fuzz pcs")
    etm = b"".join((real_pcs / "ETM_slim_mapper.txt").read_bytes().splitlines(True)[:220])
    ehd = (real_pcs / "demo_12.txt").read_bytes()
    verdicts = Counter(
        carry(mutate(etm if number % 2 else ehd, random), config) for number in range(FILES)
    )
    assert len(verdicts) >= 4, verdicts


@pytest.mark.parametrize("rig", SOUND)
@pytest.mark.parametrize("name", WRITERS)
def test_damaged_logs_of_every_format_end_in_a_verdict(rig: str, name: str) -> None:
    log, random = SOUND[rig], generator(1, f"fuzz {rig} {name}")
    content = log.written(name)
    damaged = [content[: int(share * len(content))] for share in (0.03, 0.5, 0.9, 0.999)]
    damaged += [mutate(content, random) for _ in range(FILES // 2)]
    verdicts = Counter(carry(each, log.config, log.kind) for each in damaged)
    assert len(verdicts) >= 3, verdicts


@pytest.mark.parametrize("content", [b"", b"\n", b"\0", b"#", b"# oil: 4102", b"\xef\xbb\xbf"])
def test_next_to_nothing_ends_in_a_verdict(config: Settings, content: bytes) -> None:
    assert carry(content, config) in {"unknown_format", "columns"}
