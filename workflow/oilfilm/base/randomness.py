"""Random numbers: all come from the seed of the configuration, one stream for each purpose.

Decides: where every random number comes from.
"""

import zlib

import numpy as np


def generator(seed: int, *purpose: object) -> np.random.Generator:
    """A random generator that depends on the seed and the words of the purpose only.

    Streams of different purposes are independent. A stream stays the same when others are added.
    """
    key = tuple(zlib.crc32(str(word).encode()) for word in purpose)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
