"""A whole node whose clock is told what to be: ``soak_clock.py CONFIG``, then a line an offset [s].

The machine's clock is not touched: the node is given one of its own, which is steered towards the machine's
UTC plus the offset, as a service that sets clocks would do.
"""

import asyncio
import gc
import sys
import time
from pathlib import Path

from modelcast.cli.node import sender_of_config
from modelcast.cli.stopping import stopped_by_signals
from modelcast.node.clock import SteeredClock, read_together
from modelcast.node.config import read_config
from modelcast.node.journal import Journal
from modelcast.node.live import LiveNode

__all__ = ["main"]


async def _follow(clock: SteeredClock) -> None:
    """Steer the clock by every offset that comes in."""
    reader = asyncio.StreamReader()
    await asyncio.get_running_loop().connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(reader), sys.stdin
    )
    while line := await reader.readline():
        counted_s, utc_s = read_together(time.monotonic, time.time)
        clock.steer(counted_s, utc_s=utc_s + float(line))


def _clock() -> SteeredClock:
    """As the machine's is now."""
    counted_s, utc_s = read_together(time.monotonic, time.time)
    return SteeredClock(utc_s - counted_s)


async def _run(path: Path) -> None:
    config, clock = read_config(path), _clock()
    live = LiveNode(config, sender_of_config(config), Journal(sys.stderr, time.time), clock=clock)
    following = asyncio.create_task(_follow(clock))
    with stopped_by_signals(0.0) as stop:
        await live.run(stop)
    following.cancel()


def main() -> int:
    """Run until SIGTERM."""
    gc.freeze()
    asyncio.run(_run(Path(sys.argv[1])))
    return 0


if __name__ == "__main__":
    sys.exit(main())
