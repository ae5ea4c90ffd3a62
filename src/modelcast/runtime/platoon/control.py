"""Cooperative cruise control for vehicles that another simulator moves: frame in, accelerations out."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from modelcast.apps.cruise.acc import Acc
from modelcast.apps.cruise.base import AbstractCruiseLaw, Ranging, following
from modelcast.apps.cruise.fallback import desired
from modelcast.channel.radio import AbstractRadio
from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.platoon.knowledge import Heard, frame_motions
from modelcast.station.sender.message_arrays import MESSAGES
from modelcast.station.sender.sender import Sender
from modelcast.world.platoon.platoons import Platoons
from modelcast.world.scenario.base import STEP_S, FleetFrame

__all__ = ["Asked", "CruiseControl"]


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """What F followers ask their drives for, in the order of their slots.

    Parameters
    ----------
    acceleration_mps2
        Within the limits of their drives, (F,) [m/s²].
    fell_back
        Where the law knew too little, (F,).
    age_s
        Age of what was known of the vehicle ahead, not a number where nothing was, (F,) [s].
    """

    acceleration_mps2: FloatArray
    fell_back: BoolArray
    age_s: FloatArray


class CruiseControl:
    """Platoons on the air whose followers drive by what their local dynamic maps believe.

    Each step everybody asks its map, which knows what was said of earlier frames; then all measure, and say
    what their sender's rule says. Whoever moves the vehicles applies what is asked for until the next frame.

    Parameters
    ----------
    platoons
        How many vehicles in how many platoons: vehicle i of platoon b has slot b N + i, the leader i = 0. Of
        its drive only the limits count.
    law
        Of the followers.
    sender
        What all vehicles send, and when.
    radio
        The channel they share.
    seed
        Of senders and radio.
    fallback
        What speaks where the law knows too little; None for `Acc` with its defaults.
    step_s
        Time between frames [s].
    most_age_s
        What is older is not taken for knowledge [s].
    reach_m
        How far hosts keep others in their maps [m].

    Raises
    ------
    ValueError
        Where a time or reach is not positive.

    Examples
    --------
    >>> from modelcast.apps.cruise.path import PathCacc
    >>> from modelcast.channel.erasure_radio import ErasureRadio
    >>> from modelcast.station.sender.sender import named_sender
    >>> two = Platoons(1, 2)
    >>> state = two.init(np.array([[7.0]]), 20.0)  # two metres behind its place
    >>> control = CruiseControl(two, PathCacc(), named_sender("bsm-10hz"), ErasureRadio(), seed=1)
    >>> control.step(two.frame(state)).fell_back.tolist()  # nobody has said anything yet
    [True]
    """

    def __init__(
        self,
        platoons: Platoons,
        law: AbstractCruiseLaw,
        sender: Sender,
        radio: AbstractRadio[Any],
        *,
        seed: int,
        fallback: Acc | None = None,
        step_s: float = STEP_S,
        most_age_s: float = 5.0,
        reach_m: float = 1000.0,
    ) -> None:
        for name, value in (("step_s", step_s), ("most_age_s", most_age_s), ("reach_m", reach_m)):
            if not value > 0.0:
                raise ValueError(f"{name} must be positive, got {value}")
        self._platoons, self._law, self._fallback = platoons, law, fallback
        self._on_air = sender, radio, NetworkSettings(dt_s=step_s, reach_m=reach_m), seed
        self._step_s, self._most_age_s = step_s, most_age_s
        self._heard: Heard | None = None
        self._commanded = np.zeros(platoons.pairs[0].size)

    @property
    def loop(self) -> FleetLoop | None:
        """The fleet on the air; None before the first step."""
        return None if self._heard is None else self._heard.loop

    @property
    def messages(self) -> int:
        """Messages sent so far, by all vehicles."""
        return 0 if self.loop is None else int(self.loop.sent.total[MESSAGES])

    def step(self, frame: FleetFrame, ranging: Ranging | None = None) -> Asked:
        """Return what followers ask for at a frame, and let everybody say what is to be said of it.

        Parameters
        ----------
        frame
            Where all vehicles are, in the slots of the platoons; one step after the last.
        ranging
            What ranging sensors show of the vehicles ahead; None where gap and speed are by radio too.

        Raises
        ------
        ValueError
            Where the frame has other slots, or is not one step later.
        """
        slots = self._platoons.count * self._platoons.vehicles
        if len(frame) != slots:
            raise ValueError(f"the platoons have {slots} slots, got a frame of {len(frame)}")
        if self._heard is None:
            sender, radio, settings, seed = self._on_air
            loop = FleetLoop(frame, sender, radio, settings, seed=seed)
            self._heard = Heard(self._platoons, loop, most_age_s=self._most_age_s)
        told = self._heard.told(frame)
        self._heard.listen(frame)
        known = following(
            frame_motions(frame, self._platoons.pairs[0]),
            told.ahead,
            told.leader,
            commanded_mps2=self._commanded,
            ranging=ranging,
        )
        asked, fell_back = desired(self._law, known, self._step_s, fallback=self._fallback)
        limits = self._platoons.drive
        self._commanded = np.clip(asked, -limits.hardest_mps2, limits.most_mps2)
        return Asked(self._commanded, fell_back, told.age_s)
