"""Damages of another kind than those of the fuzz tests, and rows counted without a reader."""

from collections.abc import Callable

import pytest
from numpy.random import Generator

from attacks import MUTATORS, attack, rows_written
from damages import SOUND
from formats import WRITERS
from mutations import carry
from oilfilm.curation.curate import check_logs
from oilfilm.randomness import generator

Mutator = Callable[[bytes, bytes, Generator], bytes]


@pytest.mark.parametrize("mutator", MUTATORS, ids=lambda mutator: mutator.__name__.strip("_"))
@pytest.mark.parametrize("rig", SOUND)
def test_every_row_of_a_damaged_log_is_accepted_or_refused(rig: str, mutator) -> None:
    """`make bench-attack` takes 10 000 logs."""
    log, random = SOUND[rig], generator(1, "attack", rig)
    donor = SOUND["torque" if rig == "traction" else "traction"].text()
    content = mutator(log.text(), donor, random)
    runs = check_logs([("log", content)], log.config, log.kind).runs
    written = rows_written(content)
    if len(runs) and written is not None:
        samples = runs["samples"].sum()
        # a line of blanks may be listed as a refused row
        assert samples <= written <= samples + runs["refused_rows"].sum()


@pytest.mark.parametrize("name", WRITERS)
def test_several_damages_end_in_a_verdict(name: str) -> None:
    log, random = SOUND["traction"], generator(1, "attacks", name)
    content, donor = log.written(name), log.text()
    verdicts = {carry(attack(content, donor, random), log.config) for _ in range(5)}
    assert len(verdicts) >= 2
