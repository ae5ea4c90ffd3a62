"""Compiled rules of whom people track, and who tracks people."""

from math import sqrt

from modelcast.channel.cells_kernels import Cells, cell_span, row_span
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatCube, FloatMatrix, IntVector
from modelcast.station.sender.message_arrays import (
    CONTENT_EAST_M,
    CONTENT_NORTH_M,
    MESSAGES_KEPT,
    SENDER_BITS,
)

__all__ = ["FATES", "READ", "TOO_FAR", "UNREAD", "count_with_people", "find_read"]

READ, UNREAD, TOO_FAR, FATES = range(4)
"""What becomes of a reception: it is read, its sender is nobody that the host keeps, the place that it states
is beyond reach; their number."""

KEEP_VEHICLES, KEEP_ALL, KEEP_NOBODY = range(3)
"""Of whom people keep a map, as `people.Keeps` lists them."""


@kernel(inlined=True)
def _keeps(host_is_person: bool, remote_is_person: bool, keeps: int) -> bool:
    """Whether a host keeps a remote in its map."""
    if not host_is_person:
        return True
    return keeps == KEEP_ALL or (keeps == KEEP_VEHICLES and not remote_is_person)


@kernel
def find_read(
    message_id: IntVector,
    receiver: IntVector,
    person: BoolVector,
    keeps: int,
    seen_m: FloatMatrix,
    rows: FloatCube,
    reach_m: float,
    kept: IntVector,
    counts: IntVector,
) -> int:
    """Write which receptions are read, ``kept`` (R,); return how many, and count the fates of people's.

    ``person`` (V,) says who is one, ``seen_m`` (V, 2) where hosts take themselves to be, ``rows`` what
    messages say, ``counts`` (FATES,). Who wrote a message counts, not who repeated it.
    """
    found = 0
    for k in range(message_id.size):
        host, sender = receiver[k], message_id[k] & ((1 << SENDER_BITS) - 1)
        fate = READ
        if person[host] or person[sender]:
            if not _keeps(bool(person[host]), bool(person[sender]), keeps):
                fate = UNREAD
            else:
                ring = (message_id[k] >> SENDER_BITS) % MESSAGES_KEPT
                east = rows[sender, ring, CONTENT_EAST_M] - seen_m[host, 0]
                north = rows[sender, ring, CONTENT_NORTH_M] - seen_m[host, 1]
                fate = TOO_FAR if east * east + north * north > reach_m * reach_m else READ
        counts[fate] += int(person[host])
        kept[found] = k
        found += int(fate == READ)
    return found


@kernel
def count_with_people(
    cells: Cells,
    part: tuple[int, int],
    person: BoolVector,
    keeps: int,
    reach_m: float,
    distance_bin_m: float,
    counted: BoolVector,
    pairs: IntVector,
) -> None:
    """Count one part of the pairs of host and remote of which one or both are people, ``pairs`` (distances,).

    ``part`` is its number and how many there are; ``counted`` (V,) whose pairs as hosts count. Pairs farther
    apart than the reach, or than the bins, are not counted.
    """
    present, bins = cells.order.size, pairs.size
    most_m, a_bin = min(reach_m, distance_bin_m * bins), 1.0 / distance_bin_m
    most_m2 = most_m * most_m
    for k in range(present * part[0] // part[1], present * (part[0] + 1) // part[1]):
        one = cells.order[k]
        if not person[one]:
            continue
        east, north = cells.place[k, 0], cells.place[k, 1]
        left, right, row_from, row_to = cell_span(cells, east, north, most_m)
        for row in range(row_from, row_to + 1):
            low, high = row_span(cells, row, left, right)
            for n in range(low, high):
                other = cells.order[n]
                a, b = cells.place[n, 0] - east, cells.place[n, 1] - north
                square = a * a + b * b
                distance = int(sqrt(square) * a_bin)
                if other == one or square > most_m2 or distance >= bins:
                    continue
                is_person = bool(person[other])
                pairs[distance] += int(counted[one] and _keeps(True, is_person, keeps))
                pairs[distance] += int(counted[other] and not is_person)
