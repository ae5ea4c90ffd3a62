"""Work that is repeated at whole multiples of a period, by a clock that is an argument."""

import asyncio
import math
from collections.abc import Callable

__all__ = ["at_every"]


async def at_every(period_s: float, utc_s: Callable[[], float], work: Callable[[float], None]) -> None:
    """Call something at every multiple of a period until it is cancelled; what comes too late is left out.

    Parameters
    ----------
    period_s
        Between two calls, positive [s].
    utc_s
        The clock [s].
    work
        Takes the multiple that has come [s].
    """
    number = math.floor(utc_s() / period_s) + 1
    while True:
        while (wait_s := number * period_s - utc_s()) > 0.0:  # noqa: ASYNC110 - a clock tells nobody
            await asyncio.sleep(wait_s)
        number = max(number, math.floor(utc_s() / period_s))
        work(number * period_s)
        number += 1
