"""The closed loop between two frames: what it owns, and the order of one step of 100 ms.

In each step every vehicle takes its sample; the tracks of all hosts are set against the truth; every vehicle
decides, at a time of its own within the step; the radio carries what was sent; hosts take in what they heard.
What they heard is what they count, so it changes what is sent in the next step.
"""

from typing import Any

import numpy as np

from modelcast.channel.radio import AbstractRadio, Receptions, Transmissions
from modelcast.core.arrays import FloatArray, owned
from modelcast.core.chance import child_generator
from modelcast.models.members import ReadyBank
from modelcast.runtime.fleet import deciding_kernels, receiver_kernels, sampling_kernels
from modelcast.runtime.fleet.arrays import (
    Contents,
    Outbox,
    SenderArrays,
    contents,
    outbox,
    sender_arrays,
    tally,
)
from modelcast.runtime.fleet.composing_kernels import LoopModels
from modelcast.runtime.fleet.layout_kernels import (
    MESSAGES,
    POWER_DBM,
    RULE_J2945,
    SENDER_BITS,
    TRACK_COLUMNS,
)
from modelcast.runtime.fleet.loop_constants import loop_constants
from modelcast.runtime.fleet.sender import FleetSender
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.policy import j2945_kernels
from modelcast.station.policy.belief_kernels import LOCAL_COLUMNS
from modelcast.station.policy.j2945 import J2945
from modelcast.station.policy.j2945_parameters import J2945Parameters
from modelcast.station.policy.neighbours import neighbour_tables
from modelcast.station.policy.neighbours_kernels import NeighbourTables
from modelcast.station.sensing.noise import DEFAULT_NOISE
from modelcast.world.scenario.base import FleetFrame
from modelcast.world.scenario.filtered import FleetFilter, FleetFilterState
from modelcast.world.scenario.sensed import FleetSensor, FleetSensorState

__all__ = ["SERIES", "FleetLoop"]

SERIES = (
    "vehicles",
    "messages",
    "receptions",
    "busy_ratio",
    "power_dbm",
    "density",
    "inter_transmit_time_s",
    "channel_quality",
)
"""Columns of `NetworkRun.series`: vehicles there, messages sent, receptions, means of channel busy ratio and
transmit power; and of J2945/1's state: smoothed density, longest time between messages, believed loss."""

_STEP_SLACK_S = 1e-6
_SPARE_SLOTS = 64

_SUB_INTERVAL_S = 1.0
"""Of the neighbour tables: vPERSubInterval of SAE J2945/1 [s]."""


class FleetLoop:
    """A fleet on the air between two frames; it owns its arrays, and `step` writes them.

    Parameters
    ----------
    first
        The first frame, from which sizes are taken; it is not stepped.
    sender, radio, settings
        As for `run_network`.
    seed
        Of all random numbers.
    sensor
        What the vehicles see of themselves; None for the truth.
    """

    def __init__(
        self,
        first: FleetFrame,
        sender: FleetSender,
        radio: AbstractRadio[Any],
        settings: NetworkSettings,
        *,
        seed: int,
        sensor: FleetSensor | None = None,
    ) -> None:
        vehicles = len(first)
        if vehicles >= 1 << SENDER_BITS:
            raise ValueError(f"a fleet has fewer than {1 << SENDER_BITS} slots, got {vehicles}")
        rng = child_generator(seed, "senders")
        phase = rng.random(vehicles)
        bank, dt_s = sender.bank, settings.dt_s
        window = max(int(bank.windows.max()), DEFAULT_NOISE.order + 1)
        self.sender, self.radio, self.settings = sender, radio, settings
        self.expiry_s = max(settings.expiry_s, 2.0 * sender.longest_silence_s)
        self._ready = ReadyBank.of(bank, dt_s)
        self._payload_bytes = sender.payload_bytes
        self.senders: SenderArrays = sender_arrays(
            vehicles,
            window,
            phase,
            members=len(bank.members),
            parameters=int(sender.parameter_counts.max()),
        )
        self.contents: Contents = contents(vehicles, int(sender.parameter_counts.max()))
        self.outbox: Outbox = outbox(vehicles)
        capacity = _capacity(first, settings)
        self.tables: NeighbourTables = neighbour_tables(
            vehicles, capacity, sub_intervals=_sub_intervals(sender), phase_s=phase * 1.0
        )
        self.tracks = np.full((vehicles, capacity, TRACK_COLUMNS), -1.0)
        self.tally = tally(settings.distances)
        self.number = 0
        self._rng = rng
        self._radio_state: Any = radio.init(vehicles, child_generator(seed, "radio"))
        self._sensor = sensor
        self._sensor_state: FleetSensorState | None = None
        if sensor is not None:
            self._sensor_state = sensor.init(vehicles, child_generator(seed, "sensor"))
        self._filter = None if sender.motion is None else FleetFilter(sender.motion)
        self._filter_state: FleetFilterState | None = None
        if self._filter is not None:
            self._filter_state = self._filter.init(vehicles)
        self._constants = loop_constants(sender, dt_s)
        spread_s = settings.start_spread_s
        self._spread_s = sender.longest_silence_s if spread_s is None else spread_s
        self._last_s = -np.inf

    def step(self, frame: FleetFrame) -> tuple[Receptions, FloatArray]:
        """Carry one step; returns what was received in it, and its row of `SERIES`.

        Parameters
        ----------
        frame
            The truth, one step after the last.

        Raises
        ------
        ValueError
            Where the frame is not one step later.
        """
        dt_s, t_s = self.settings.dt_s, frame.t_s
        if np.isfinite(self._last_s) and abs(t_s - self._last_s - dt_s) > _STEP_SLACK_S:
            raise ValueError(
                f"frames must be {dt_s} s apart, got one at {t_s} s after {self._last_s} s: resample them"
            )
        self._last_s = t_s
        # The radio's clock counts steps, so that both ends of every interval are the same numbers.
        now_s, until_s = round(self.number * dt_s, 6), round((self.number + 1) * dt_s, 6)
        seen = frame
        if self._sensor is not None and self._sensor_state is not None:
            seen, self._sensor_state = self._sensor.sense(self._sensor_state, frame)
        if self._filter is not None and self._filter_state is not None:
            seen, self._filter_state = self._filter.estimate(self._filter_state, seen)
        before = self.tally.sums.copy()
        busy_ratio = self.radio.channel_busy_ratio(self._radio_state)
        models = LoopModels(self._ready.members, self._payload_bytes)
        truth_m = self._sense_and_track(models, frame, seen, now_s)
        self._decide(models, seen, now_s, busy_ratio)
        received = self._carry(truth_m, until_s)
        receiver_kernels.hear_messages(
            owned(received.message_id, np.int64),
            owned(received.receiver, np.int64),
            owned(received.t_s),
            self.senders.vehicle,
            seen.position_m,
            truth_m,
            self.settings.reach_m,
            _SUB_INTERVAL_S,
            self.settings.distance_bin_m,
            self.tables,
            self.contents,
            self.tracks,
            self.tally,
        )
        self.number += 1
        return received, self._series_row(frame, busy_ratio, before, received)

    def _sense_and_track(
        self, models: LoopModels, frame: FleetFrame, seen: FleetFrame, now_s: float
    ) -> FloatArray:
        """Take samples in, let new vehicles begin anew, and set all tracks against the truth."""
        s, settings = self.senders, self.settings
        self._started = np.zeros(len(frame), dtype=np.bool_)
        sampling_kernels.take_samples(
            now_s,
            self._place,
            seen.position_m,
            seen.speed_mps,
            seen.heading_rad,
            seen.acceleration_mps2,
            seen.yaw_rate_radps,
            frame.vehicle_id,
            frame.active,
            s,
            DEFAULT_NOISE.order,
            self._constants.noise,
            self._started,
        )
        receiver_kernels.clear_hosts(self._started, self.tables, self.tracks)
        truth_m = np.where(frame.active[:, None], frame.position_m, np.nan)
        receiver_kernels.sample_tracks(
            models,
            now_s,
            self.number,
            self.expiry_s,
            settings.distance_bin_m,
            settings.middle_bins,
            s.vehicle,
            truth_m,
            self.tables,
            self.contents,
            self.tracks,
            self.tally,
            np.empty(2),
        )
        receiver_kernels.count_pairs(truth_m, settings.distance_bin_m, self.tally.pairs)
        return truth_m

    @property
    def _place(self) -> int:
        """Where in the rings the newest sample goes."""
        return self.number % (self.senders.times.size // 2)

    def _decide(self, models: LoopModels, seen: FleetFrame, now_s: float, busy_ratio: FloatArray) -> None:
        """Fill the outbox."""
        c = self._constants
        critical = seen.acceleration_mps2 < -c.critical_mps2
        deciding_kernels.decide(
            models,
            self.sender.limits,
            c.stack,
            c.rule,
            c.rule_constants,
            c.control,
            c.control_constants,
            (*c.extra, self._spread_s if self.number == 0 else 0.0),
            now_s,
            self.settings.dt_s,
            self._place,
            self._started,
            critical,
            owned(busy_ratio),
            self._rng.random((len(seen), 4)),
            self.tables,
            self.senders,
            self.contents,
            self.outbox,
            self.tally,
            np.empty(LOCAL_COLUMNS),
            np.empty(3 + int(self.sender.parameter_counts.max())),
        )

    def _carry(self, truth_m: FloatArray, until_s: float) -> Receptions:
        """Give the outbox to the radio, in order of time."""
        out = self.outbox
        count = int(out.filled[0])
        order = np.argsort(out.ready_s[:count], kind="stable")
        batch = Transmissions(
            out.sender[order],
            np.minimum(out.ready_s[order], np.nextafter(until_s, 0.0)),
            size_bytes=out.size_bytes[order],
            power_dbm=out.power_dbm[order],
            message_id=out.message_id[order],
        )
        received, self._radio_state = self.radio.carry(self._radio_state, batch, truth_m, until_s)
        return received

    def _series_row(
        self, frame: FleetFrame, busy_ratio: FloatArray, before: FloatArray, received: Receptions
    ) -> FloatArray:
        here = frame.active
        gained = self.tally.sums - before
        rows = self.senders.rows[here] if self._constants.rule == RULE_J2945 else None
        row = np.full(len(SERIES), np.nan)
        row[0], row[1], row[2] = here.sum(), gained[MESSAGES], received.size
        row[3] = busy_ratio[here].mean() if here.any() else np.nan
        row[4] = gained[POWER_DBM] / gained[MESSAGES] if gained[MESSAGES] > 0 else np.nan
        if rows is not None and len(rows):
            row[5] = rows[:, j2945_kernels.DENSITY].mean()
            row[6] = rows[:, j2945_kernels.INTER_TRANSMIT_TIME_S].mean()
            row[7] = rows[:, j2945_kernels.CHANNEL_QUALITY].mean()
        return row

    def forget_counts(self) -> None:
        """Set all counts to zero: the warm-up is over."""
        for counts in self.tally:
            counts[...] = 0


def _sub_intervals(sender: FleetSender) -> int:
    """Sub-intervals that the sender's rule counts packet errors over."""
    rule = sender.policy
    return (rule.parameters if isinstance(rule, J2945) else J2945Parameters()).sub_intervals


def _capacity(first: FleetFrame, settings: NetworkSettings) -> int:
    """Slots of a host: half as many again as the fullest has in reach at first, and some.

    Where slots are empty at first, as in traffic that comes and goes, as many more as if all were taken.
    """
    place = np.where(first.active[:, None], first.position_m, np.nan)
    most = receiver_kernels.most_in_reach(place, settings.reach_m) * len(first) / max(first.active.sum(), 1)
    return int(min(len(first) + _SPARE_SLOTS, int(1.5 * most) + _SPARE_SLOTS, 2**15 - 1))
