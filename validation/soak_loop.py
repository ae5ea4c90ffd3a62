"""An event loop that does nothing but wake ten times a second; how late it does is printed at SIGTERM [ms].

What a node's steps are late by beyond this is the node's own.
"""

import asyncio
import contextlib
import sys
import time

from modelcast.cli.stopping import stopped_by_signals
from modelcast.node.run import Lateness
from modelcast.node.trials.pacing import at_every

__all__ = ["main"]

TICK_S = 0.1


async def _run() -> Lateness:
    late = Lateness()
    waking = asyncio.create_task(at_every(TICK_S, time.time, lambda due_s: late.add(time.time() - due_s)))
    with stopped_by_signals(0.0) as stop:
        await stop.wait()
    waking.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await waking
    return late


def main() -> int:
    """Run until SIGTERM."""
    late = asyncio.run(_run())
    print(f"{1e3 * late.quantile_s(0.5):.3f} {1e3 * late.quantile_s(0.99):.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
