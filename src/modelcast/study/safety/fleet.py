"""Hosts of a fleet on the air looked at step by step: what they warn of, and what they should.

At the instant of every frame each pair of a host and a remote near it is assessed twice: with the true motion
of both, and with the motion that the host measures of itself and believes of the remote, by what it heard
before that instant. Who has no live track of a remote, or is new, warns of nothing. What a host reads
changes nothing that anybody sends, so every host is assessed once for each reading that is asked for.
"""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, fields, replace
from typing import final

import numpy as np

from modelcast.apps.motions import WIDTH_M, Motions
from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.observer import AbstractObserver
from modelcast.station.receiver.belief_kernels import (
    BELIEF_ACCELERATION,
    BELIEF_HEADING,
    BELIEF_SPEED,
    BELIEF_YAW_RATE,
)
from modelcast.station.receiver.reading import Reading
from modelcast.study.safety.fleet_settings import FleetSafetySettings
from modelcast.world.encounters import near_pairs
from modelcast.world.scenario.base import FleetFrame

__all__ = ["Assessed", "SafetyObserver"]


_SLACK_S = 1e-6
_BELIEVED = (0, 1, BELIEF_SPEED, BELIEF_HEADING, BELIEF_ACCELERATION, BELIEF_YAW_RATE)


@dataclass(frozen=True, slots=True, eq=False)
class Assessed:
    """Instants of pairs of which anything can be said: N rows, by rising time.

    Parameters
    ----------
    t_s
        (N,) [s].
    host, remote
        Identifiers of the vehicles, (N,).
    pairing
        Who speaks and who reads how, as `modelcast.runtime.fleet.mixed.pairing` numbers it, (N,).
    margin_m
        True margin, (N,) [m].
    truly, warned
        Whether perfect knowledge warns, and whether the host does, (N,).
    """

    t_s: FloatArray
    host: IntArray
    remote: IntArray
    pairing: IntArray
    _: KW_ONLY
    margin_m: FloatArray
    truly: BoolArray
    warned: BoolArray

    @classmethod
    def joined(cls, parts: "Sequence[Assessed]") -> "Assessed":
        """All rows of several.

        Parameters
        ----------
        parts
            By rising time; none for no rows.
        """
        none: IntArray = np.zeros(0, dtype=np.int64)
        real: FloatArray = np.zeros(0)
        no: BoolArray = np.zeros(0, dtype=np.bool_)
        return cls(
            np.concatenate([real, *(one.t_s for one in parts)]),
            np.concatenate([none, *(one.host for one in parts)]),
            np.concatenate([none, *(one.remote for one in parts)]),
            np.concatenate([none, *(one.pairing for one in parts)]),
            margin_m=np.concatenate([real, *(one.margin_m for one in parts)]),
            truly=np.concatenate([no, *(one.truly for one in parts)]),
            warned=np.concatenate([no, *(one.warned for one in parts)]),
        )

    def taken(self, rows: IntArray) -> "Assessed":
        """Some rows.

        Parameters
        ----------
        rows
            Their numbers.
        """
        return replace(self, **{field.name: getattr(self, field.name)[rows] for field in fields(self)})


@dataclass(frozen=True, slots=True, eq=False)
class _Waiting:
    """Pairs of a frame before its step: slots, and how hosts believe the remotes to move, by reading."""

    host: IntArray
    remote: IntArray
    motions: dict[Reading, FloatArray]


@final
class SafetyObserver(AbstractObserver):
    """Collects what hosts warn of.

    Parameters
    ----------
    settings
        What warns, and of whom.

    Notes
    -----
    Rows are kept where perfect knowledge or the host warns, or the true margin is below
    `FleetSafetySettings.near_m`: others change no score. Size and kind of a road user are what its
    messages state.
    """

    def __init__(self, settings: FleetSafetySettings) -> None:
        self.settings = settings
        self.host_s = 0.0
        """Time that all hosts were observed [s]."""
        self.end_s = -np.inf
        """Instant of the last frame [s]."""
        self.pairs = 0
        """Pairs assessed, each instant anew."""
        self._waiting: _Waiting | None = None
        self._drawn: dict[int, bool] = {}
        self._rows: dict[str, list[Assessed]] = {name: [] for name in settings.applications}

    def before(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Take what hosts believe of the remotes near them."""
        if frame.t_s < self.settings.warm_up_s - _SLACK_S:
            return
        host, remote = near_pairs(frame.position_m, frame.active, self.settings.radius_m)
        asked = self._asked(frame)[host]
        host, remote = host[asked], remote[asked]
        new = loop.vehicle[: len(frame)] != frame.vehicle_id
        unknown = new[host] | new[remote]
        motions: dict[Reading, FloatArray] = {}
        for reading in self.settings.readings:
            motion = loop.believed(host, remote, reading=reading, t_s=frame.t_s).motion
            motion[unknown] = np.nan
            motions[reading] = motion
        self._waiting = _Waiting(host, remote, motions)

    def after(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Assess those pairs."""
        self.end_s = frame.t_s
        given, self._waiting = self._waiting, None
        if given is None:
            return
        self.host_s += loop.settings.dt_s * int(self._asked(frame).sum())
        self.pairs += given.host.size
        true = _true(frame)
        host, remote = given.host, given.remote
        right = _motions(true[host], frame, host), _motions(true[remote], frame, remote)
        own = _motions(loop.own_motion(host), frame, host)
        who = frame.vehicle_id[host], frame.vehicle_id[remote]
        for name, application in self.settings.applications.items():
            truly = application.assess(*right)
            for reading, motion in given.motions.items():
                believed = _motions(motion[:, _BELIEVED], frame, remote)
                warned = application.assess(own, believed).warned
                kept = truly.warned | warned | (np.abs(truly.margin_m) < self.settings.near_m)
                if kept.any():
                    row = Assessed(
                        np.full(int(kept.sum()), frame.t_s),
                        who[0][kept],
                        who[1][kept],
                        len(Reading) * loop.group[remote][kept] + reading,
                        margin_m=truly.margin_m[kept],
                        truly=truly.warned[kept],
                        warned=warned[kept],
                    )
                    self._rows[name].append(row)

    def assessed(self, application: str) -> Assessed:
        """Rows of an application so far.

        Parameters
        ----------
        application
            Its name.
        """
        return Assessed.joined(self._rows[application])

    def _asked(self, frame: FleetFrame) -> BoolArray:
        """Which slots hold a host, (V,); a vehicle is one as long as it lives, whoever else is there."""
        ratio = self.settings.hosts_ratio
        if ratio >= 1.0:
            return frame.active
        asked = np.zeros(len(frame), dtype=np.bool_)
        for slot in np.flatnonzero(frame.active).tolist():
            vehicle = int(frame.vehicle_id[slot])
            if vehicle not in self._drawn:
                rng = child_generator(self.settings.seed, vehicle, "host")
                self._drawn[vehicle] = bool(rng.random() < ratio)
            asked[slot] = self._drawn[vehicle]
        return asked


def _true(frame: FleetFrame) -> FloatArray:
    """How vehicles truly move, columns as those of `modelcast.station.arrays.MEASURED`, (V, 6)."""
    columns = (frame.speed_mps, frame.heading_rad, frame.acceleration_mps2, frame.yaw_rate_radps)
    return np.column_stack((frame.position_m, *columns))


def _motions(rows: FloatArray, frame: FleetFrame, slots: IntArray) -> Motions:
    """Motions from columns of `modelcast.station.arrays.MEASURED`, (N, 6), of these slots, (N,)."""
    return Motions.of(
        rows[:, :2], speed_mps=rows[:, 2], heading_rad=rows[:, 3],
        acceleration_mps2=rows[:, 4], yaw_rate_radps=rows[:, 5], length_m=frame.length_m[slots],
        width_m=WIDTH_M if frame.width_m is None else frame.width_m[slots],
        kind=None if frame.kind is None else frame.kind[slots],
    )  # fmt: skip
