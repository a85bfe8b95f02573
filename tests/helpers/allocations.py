"""The largest memory that a block of a test had allocated at one time."""

import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def peak_bytes() -> Iterator[Callable[[], int]]:
    """Count the allocations of a block; yields a function that gives their peak after it."""
    peak = 0
    tracemalloc.start()
    try:
        yield lambda: peak
    finally:
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
