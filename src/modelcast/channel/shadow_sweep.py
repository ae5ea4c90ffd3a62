"""Shadowing of a step, renewed in parts that threads may share."""

import numpy as np

from modelcast.channel.pair_kernels import Pairs, grow_pairs
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.shadowing_kernels import Sweep, sweep_part
from modelcast.core.parts import Parts

__all__ = ["renew_pairs"]


def renew_pairs(
    sweep: Sweep, pairs: Pairs, seed: np.uint64, tables: PropagationTables, parts: Parts
) -> Pairs:
    """Renew the shadowing of all pairs with a sender, once each: written into the rows of the sweep.

    Parameters
    ----------
    sweep
        As laid out for the step.
    pairs
        The store, which is used up.
    seed
        What chance depends on, beside the pair, its last value and its place.
    tables
        Of the propagation.
    parts
        Owners of pairs are divided among; what comes out does not depend on it. Where a table is full, its
        part is done again with room for more, which leaves alone what was renewed: nothing has moved since.
    """
    short = [True] * parts.number
    while True:

        def renewed(part: int, held: Pairs = pairs, due: list[bool] = short) -> bool:
            return due[part] and sweep_part(sweep, held, seed, tables, part, parts.number)

        short = parts.each(renewed)
        if not any(short):
            return pairs
        pairs = grow_pairs(pairs, sweep.position_m, sweep.range_m)
