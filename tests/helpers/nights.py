"""Cases of a test that `make test` leaves to `make nightly`, and how many examples a test takes."""

from collections.abc import Collection, Iterable
from typing import Any

import pytest
from hypothesis import settings


def nightly(*values: Any) -> Any:
    """A case for `make nightly` alone."""
    return pytest.param(*values, marks=pytest.mark.nightly)


def quick_ones(cases: Iterable[Any], quick: Collection[Any]) -> list[Any]:
    """All cases; those that are not quick ones are for `make nightly` alone."""
    return [case if case in quick else nightly(case) for case in cases]


def examples(share: float) -> settings:
    """Settings of a test with this share of the usual number of examples.

    The usual number is 30 in `make test` and 300 in `make nightly`.
    """
    return settings(max_examples=round(share * settings().max_examples))
