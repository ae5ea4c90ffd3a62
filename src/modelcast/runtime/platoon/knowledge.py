"""Where followers have their knowledge from: the truth, or what they heard."""

import abc
from dataclasses import dataclass

import numpy as np

from modelcast.apps.motions import Motions
from modelcast.core.arrays import FloatArray, IntArray
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.station.receiver.belief_kernels import (
    BELIEF_ACCELERATION,
    BELIEF_HEADING,
    BELIEF_SPEED,
    BELIEF_YAW_RATE,
)
from modelcast.world.platoon.platoons import Platoons
from modelcast.world.scenario.base import FleetFrame

__all__ = ["AbstractKnowledge", "Heard", "Perfect", "Told", "carried_on", "frame_motions"]


@dataclass(frozen=True, slots=True)
class Told:
    """What each of F followers takes to be so at one instant, NaN where it takes nothing to be.

    Parameters
    ----------
    ahead, leader
        The vehicle ahead, and the platoon's leader, F rows.
    age_s
        Age of what is known of the vehicle ahead, (F,) [s].
    """

    ahead: Motions
    leader: Motions
    age_s: FloatArray


class AbstractKnowledge(abc.ABC):
    """What followers know of those ahead, asked and renewed once a frame."""

    @abc.abstractmethod
    def told(self, frame: FleetFrame) -> Told:
        """What followers know at the time of a frame, before anything of that frame is said.

        Parameters
        ----------
        frame
            The truth.
        """

    @abc.abstractmethod
    def listen(self, frame: FleetFrame) -> None:
        """Let vehicles say what they have to say of a frame, and hear each other, until the next.

        Parameters
        ----------
        frame
            The truth.
        """


def frame_motions(frame: FleetFrame, slots: IntArray) -> Motions:
    """Vehicles of a frame as applications take them.

    Parameters
    ----------
    frame
        Any frame.
    slots
        Which, (N,).
    """
    return Motions.of(
        frame.position_m[slots],
        speed_mps=frame.speed_mps[slots],
        heading_rad=frame.heading_rad[slots],
        acceleration_mps2=frame.acceleration_mps2[slots],
        yaw_rate_radps=frame.yaw_rate_radps[slots],
        length_m=frame.length_m[slots],
    )


def carried_on(motions: Motions, ahead_s: float) -> Motions:
    """Motions a moment later, straight on at their acceleration; nobody reverses.

    Parameters
    ----------
    motions
        Any.
    ahead_s
        The moment [s].
    """
    if ahead_s == 0.0:
        return motions
    speed = np.maximum(motions.speed_mps + motions.acceleration_mps2 * ahead_s, 0.0)
    course = np.stack([np.sin(motions.heading_rad), np.cos(motions.heading_rad)], axis=1)
    way = 0.5 * (motions.speed_mps + speed) * ahead_s
    return Motions.of(
        motions.position_m + course * way[:, None],
        speed_mps=speed,
        heading_rad=motions.heading_rad,
        acceleration_mps2=motions.acceleration_mps2,
        yaw_rate_radps=motions.yaw_rate_radps,
        length_m=motions.length_m,
    )


class Perfect(AbstractKnowledge):
    """Everybody knows the truth of every frame, at once.

    Parameters
    ----------
    platoons
        Whose.
    """

    def __init__(self, platoons: Platoons) -> None:
        self._pairs = platoons.pairs

    def told(self, frame: FleetFrame) -> Told:
        """The truth."""
        _, ahead, leader = self._pairs
        return Told(frame_motions(frame, ahead), frame_motions(frame, leader), np.zeros(ahead.size))

    def listen(self, frame: FleetFrame) -> None:
        """Nothing is said."""
        del frame


class Heard(AbstractKnowledge):
    """Followers know what the messages of a fleet on the air make them believe.

    Parameters
    ----------
    platoons
        Whose.
    loop
        The fleet on the air; it is stepped.
    most_age_s
        What is older is not taken for knowledge [s].
    """

    def __init__(self, platoons: Platoons, loop: FleetLoop, *, most_age_s: float = np.inf) -> None:
        self.loop = loop
        self._pairs, self._most_age_s = platoons.pairs, most_age_s

    def told(self, frame: FleetFrame) -> Told:
        """What they believe now."""
        own, ahead, leader = self._pairs
        first, age_s = self._believed(frame, own, ahead)
        return Told(first, self._believed(frame, own, leader)[0], age_s)

    def _believed(self, frame: FleetFrame, own: IntArray, remotes: IntArray) -> tuple[Motions, FloatArray]:
        """Motions of one remote each, and how old they are; lengths are known to all."""
        held = self.loop.believed(own, remotes, t_s=frame.t_s)
        known = held.held & (held.age_s <= self._most_age_s)
        motion = np.where(known[:, None], held.motion, np.nan)
        found = Motions.of(
            motion[:, :2],
            speed_mps=motion[:, BELIEF_SPEED],
            heading_rad=motion[:, BELIEF_HEADING],
            acceleration_mps2=motion[:, BELIEF_ACCELERATION],
            yaw_rate_radps=motion[:, BELIEF_YAW_RATE],
            length_m=frame.length_m[remotes],
        )
        return found, np.where(known, held.age_s, np.nan)

    def listen(self, frame: FleetFrame) -> None:
        """One step of the fleet."""
        self.loop.step(frame)
