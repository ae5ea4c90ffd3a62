"""An event loop whose time is not the wall's: whoever waits is served at once, and time has passed."""

import asyncio
import selectors
from collections.abc import Coroutine
from typing import Any, TypeVar

from modelcast.node.clock import AbstractClock

__all__ = ["LoopClock", "run_in_virtual_time"]

Result = TypeVar("Result")


class _Selector(selectors.DefaultSelector):
    """Looks at sockets without waiting; where none is ready, time passes as if it had waited."""

    passed_s = 0.0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        ready = super().select(0 if timeout is None or timeout > 0 else timeout)
        if not ready and timeout:
            self.passed_s += timeout
        return ready


class _Loop(asyncio.SelectorEventLoop):
    def __init__(self) -> None:
        self._own = _Selector()
        super().__init__(self._own)

    def time(self) -> float:
        return self._own.passed_s


class LoopClock(AbstractClock):
    """The time of the running loop, plus what every look at it costs."""

    def __init__(self, costs_s: float = 0.0) -> None:
        self.costs_s, self._spent_s = costs_s, 0.0

    def spend(self, time_s: float) -> None:
        """Let time pass in which nobody else runs."""
        self._spent_s += time_s

    def now_s(self) -> float:
        """Now."""
        self._spent_s += self.costs_s
        return asyncio.get_running_loop().time() + self._spent_s


def run_in_virtual_time(main: Coroutine[Any, Any, Result]) -> Result:
    """Run a coroutine to its end."""
    with asyncio.Runner(loop_factory=_Loop) as runner:
        return runner.run(main)
