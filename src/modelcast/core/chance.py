"""Where random numbers come from: one child generator an agent, channel and run."""

import zlib

import numpy as np

__all__ = ["child_generator"]


def child_generator(seed: int, *key: int | str) -> np.random.Generator:
    """Return the generator of one seed and key: the same key always gives the same numbers.

    Parameters
    ----------
    seed
        The run's seed, not negative.
    key
        What the generator is for: run number, vehicle, channel. Names are hashed.

    Examples
    --------
    >>> float(child_generator(0, 1, "car", "loss").random()) == float(
    ...     child_generator(0, 1, "car", "loss").random()
    ... )
    True
    """
    words = tuple(part if isinstance(part, int) else zlib.crc32(part.encode()) for part in key)
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=words)))
