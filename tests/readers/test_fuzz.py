"""Whatever happens to a file: a verdict, never a traceback, and no row lost."""

from collections import Counter
from typing import Any

import pytest

import bad_logs
from campaigns import ROOT, Campaign
from mutations import carry, mutate, other_formats
from oilfilm.randomness import generator
from oilfilm.settings.load import resolve
from oilfilm.settings.resolved import Settings

FILES = 100  # of each of five formats; `make bench-fuzz` takes 20 000


def test_damaged_csv_logs_end_in_a_verdict(demo: Campaign, config: Settings) -> None:
    good = (demo.folder / "4102_P1.25_U25_T070.csv").read_bytes()
    short = b"".join(good.splitlines(keepends=True)[:1200])
    random = generator(1, "fuzz csv")
    verdicts = Counter(carry(mutate(short, random), config) for _ in range(FILES))
    assert len(verdicts) >= 4, verdicts  # the damages are not all of one kind


def test_damaged_pcs_logs_end_in_a_verdict(real_pcs: Any) -> None:
    config = resolve(ROOT / "config", {"campaign": "etm-slim"})
    random = generator(1, "fuzz pcs")
    etm = b"".join((real_pcs / "ETM_slim_mapper.txt").read_bytes().splitlines(True)[:220])
    ehd = (real_pcs / "demo_12.txt").read_bytes()
    verdicts = Counter(
        carry(mutate(etm if number % 2 else ehd, random), config) for number in range(FILES)
    )
    assert len(verdicts) >= 4, verdicts


@pytest.mark.parametrize("name", ["tdms", "lvm", "parquet"])
def test_damaged_logs_of_other_formats_end_in_a_verdict(name: str) -> None:
    whole, random = other_formats(bad_logs.good()), generator(1, f"fuzz {name}")
    verdicts = Counter(carry(mutate(whole[name], random), bad_logs.CONFIG) for _ in range(FILES))
    assert len(verdicts) >= 3, verdicts


@pytest.mark.parametrize("content", [b"", b"\n", b"\0", b"#", b"# oil: 4102", b"\xef\xbb\xbf"])
def test_next_to_nothing_ends_in_a_verdict(config: Settings, content: bytes) -> None:
    assert carry(content, config) in {"unknown_format", "columns"}
