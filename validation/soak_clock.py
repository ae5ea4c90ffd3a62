"""A whole node whose clock is told what to be: ``soak_clock.py CONFIG``, then a line an offset [s].

The machine's clock is not touched: the node is given one of its own, which is steered towards the machine's
UTC plus the offset, as a service that sets clocks would do.
"""

import asyncio
import sys
import time
from pathlib import Path

from modelcast.cli.node import sender_of_config, stopped_by_signals
from modelcast.node.clock import SteeredClock
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
        clock.steer(time.monotonic(), utc_s=time.time() + float(line))


async def _run(path: Path) -> None:
    config, clock = read_config(path), SteeredClock(time.time() - time.monotonic())
    clock.steer(time.monotonic(), utc_s=time.time())
    live = LiveNode(config, sender_of_config(config), Journal(sys.stderr, time.time), clock=clock)
    following = asyncio.create_task(_follow(clock))
    await live.run(stopped_by_signals(0.0))
    following.cancel()


def main() -> int:
    """Run until SIGTERM."""
    asyncio.run(_run(Path(sys.argv[1])))
    return 0


if __name__ == "__main__":
    sys.exit(main())
