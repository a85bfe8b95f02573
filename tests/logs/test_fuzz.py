"""Whatever happens to a file: a verdict, never a traceback, and no row lost."""

from collections import Counter

import pytest

from bad_logs import PCS_CONFIG
from damages import SOUND
from formats import WRITERS
from mutations import carry, mutate
from nights import nightly
from oilfilm.randomness import generator
from oilfilm.settings.resolved import Settings
from pcs_exports import film_export, traction_export

# How many files of each format are damaged; `make bench-fuzz` takes 20 000.
NUMBERS = pytest.mark.parametrize("files", [12, nightly(200)])


@pytest.mark.no_cover
@NUMBERS
def test_damaged_pcs_logs_end_in_a_verdict(files: int) -> None:
    random = generator(1, "fuzz pcs")
    etm, ehd = traction_export(range(1, 6)), film_export()
    verdicts = Counter(
        carry(mutate(etm if number % 2 else ehd, random), PCS_CONFIG) for number in range(2 * files)
    )
    assert len(verdicts) >= 4, verdicts


@pytest.mark.no_cover
@NUMBERS
@pytest.mark.parametrize("rig", SOUND)
@pytest.mark.parametrize("name", WRITERS)
def test_damaged_logs_of_every_format_end_in_a_verdict(rig: str, name: str, files: int) -> None:
    log, random = SOUND[rig], generator(1, f"fuzz {rig} {name}")
    content = log.written(name)
    damaged = [content[: int(share * len(content))] for share in (0.03, 0.5, 0.9, 0.999)]
    damaged += [mutate(content, random) for _ in range(files)]
    verdicts = Counter(carry(each, log.config, log.kind) for each in damaged)
    assert len(verdicts) >= 3, verdicts


@pytest.mark.parametrize("content", [b"", b"\n", b"\0", b"#", b"# oil: 4102", b"\xef\xbb\xbf"])
def test_next_to_nothing_ends_in_a_verdict(config: Settings, content: bytes) -> None:
    assert carry(content, config) in {"unknown_format", "columns"}
