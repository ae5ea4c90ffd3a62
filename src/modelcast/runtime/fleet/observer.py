"""Who looks on while a fleet is on the air: sees every frame before and after its step, changes nothing."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.world.scenario.base import FleetFrame

__all__ = ["AbstractObserver", "Observers"]


class AbstractObserver(ABC):
    """Looks at the loop around every step.

    At the instant of a frame hosts believe by what they heard before it, and know of themselves what they
    measure at it. The first is there before the step, the second after it.
    """

    @abstractmethod
    def before(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Look at what hosts believe at the instant of a frame; not called for the first.

        Parameters
        ----------
        loop
            After the step of the frame before.
        frame
            The truth.
        """

    @abstractmethod
    def after(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Look at what vehicles know of themselves at that instant.

        Parameters
        ----------
        loop
            After the step of the frame.
        frame
            The same truth.
        """


@dataclass(frozen=True, slots=True)
class Observers(AbstractObserver):
    """Several who look on, one after another.

    Parameters
    ----------
    each
        They.
    """

    each: tuple[AbstractObserver, ...]

    def before(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Let each look before the step."""
        for one in self.each:
            one.before(loop, frame)

    def after(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Let each look after it."""
        for one in self.each:
            one.after(loop, frame)
