"""Every random number comes from the seed of the configuration, one stream for each purpose.

Decides: where every random number comes from.
"""

import zlib

import numpy as np


def generator(seed: int, *purpose: object) -> np.random.Generator:
    """A random generator that depends on the seed and the purpose's words alone.

    Streams of different purposes are independent, and one does not change when others come or go.
    """
    key = tuple(zlib.crc32(str(word).encode()) for word in purpose)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
