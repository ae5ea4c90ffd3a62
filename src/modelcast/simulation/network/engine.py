"""The closed loop of a fleet on the air, in steps of 100 ms.

In each step every vehicle takes its sample; the tracks of all hosts are set against the truth; every vehicle
decides, at a time of its own within the step; the radio carries what was sent; hosts take in what they heard.
What they heard is what they count, so it changes what is sent in the next step.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import KW_ONLY, dataclass
from itertools import chain
from typing import Any

import numpy as np

from modelcast.channel.radio import AbstractRadio, Receptions, Transmissions
from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.models.base import quiet_function_pointers
from modelcast.models.noise import DEFAULT_NOISE
from modelcast.policy import dcc_kernels, j2945_kernels
from modelcast.policy.belief_kernels import LOCAL_COLUMNS
from modelcast.policy.cam import CooperativeAwareness
from modelcast.policy.dcc import AdaptiveDcc
from modelcast.policy.error_driven import ErrorDriven
from modelcast.policy.j2945 import J2945
from modelcast.policy.neighbours import NeighbourTables, neighbour_tables
from modelcast.policy.periodic import Periodic
from modelcast.simulation.network import deciding_kernels, receiver_kernels, sampling_kernels
from modelcast.simulation.network.arrays import (
    Contents,
    Outbox,
    SenderArrays,
    Tally,
    contents,
    outbox,
    sender_arrays,
    tally,
)
from modelcast.simulation.network.emitting_kernels import CERTIFICATE_RULES
from modelcast.simulation.network.layout_kernels import (
    MESSAGES,
    POWER_DBM,
    RULE_CAM,
    RULE_ERROR_DRIVEN,
    RULE_J2945,
    RULE_PERIODIC,
    SENDER_BITS,
    TRACK_COLUMNS,
)
from modelcast.simulation.network.sender import FleetSender
from modelcast.simulation.scenario.base import FleetFrame
from modelcast.simulation.scenario.sensed import FleetSensor, FleetSensorState

__all__ = ["SERIES", "FleetLoop", "NetworkRun", "NetworkSettings", "run_network"]

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


@dataclass(frozen=True, slots=True, kw_only=True)
class NetworkSettings:
    """What is tracked and counted.

    Parameters
    ----------
    warm_up_s
        Left out of all counts but the series [s].
    dt_s
        Step of the frames [s].
    reach_m
        A host passes over remotes that state a place farther away [m].
    expiry_s
        Silence after which a track counts as lost [s]; at least twice what the sender's rule allows is taken.
    start_spread_s
        The vehicles of the first frame begin to send within this time [s]; None for the longest silence that
        the rule allows. Else all would go on sending together.
    distance_bin_m, distances
        Width [m] and number of the bins of distance.
    middle_bins
        First and end bin of the headline distances, 50 m to 150 m by default; also those of the series of
        tracking errors.

    Raises
    ------
    ValueError
        Where a value is out of its range.
    """

    warm_up_s: float = 5.0
    dt_s: float = 0.1
    reach_m: float = 350.0
    expiry_s: float = 5.0
    start_spread_s: float | None = None
    distance_bin_m: float = 25.0
    distances: int = 12
    middle_bins: tuple[int, int] = (2, 6)

    def __post_init__(self) -> None:
        for name in ("dt_s", "reach_m", "expiry_s", "distance_bin_m", "distances"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if not self.warm_up_s >= 0:
            raise ValueError(f"warm_up_s must not be negative, got {self.warm_up_s}")
        first, end = self.middle_bins
        if not 0 <= first < end <= self.distances:
            raise ValueError(f"middle_bins must be in order within {self.distances}, got {self.middle_bins}")


@dataclass(frozen=True, slots=True)
class NetworkRun:
    """What one run counted, the warm-up left out but in the series.

    Parameters
    ----------
    tally
        Counts of senders and hosts.
    outcomes
        Pairs of frame and vehicle in reach by the radio's bins of distance and cause, (bins, causes).
    expired
        Messages that were never sent.
    vehicle_s
        Time observed, over all vehicles [s].
    busy_ratio
        Mean channel busy ratio over vehicles and time.
    series
        (steps, len(SERIES)), a row a step.
    recent
        Tracking errors at the headline distances, (seconds, BINS), a row a second.
    sender_bytes
        Payload bytes by sub-model, (M,).
    """

    tally: Tally
    outcomes: IntArray
    _: KW_ONLY
    expired: int
    vehicle_s: float
    busy_ratio: float
    series: FloatArray
    recent: IntArray
    sender_bytes: IntArray


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
        self.models = _models(sender, dt_s)
        self.senders: SenderArrays = sender_arrays(
            vehicles,
            window,
            phase,
            members=len(self.models[0]),
            parameters=int(sender.parameter_counts.max()),
        )
        self.contents: Contents = contents(vehicles, int(sender.parameter_counts.max()))
        self.outbox: Outbox = outbox(vehicles)
        capacity = _capacity(first, settings)
        self.tables: NeighbourTables = neighbour_tables(vehicles, capacity, phase_s=phase * 1.0)
        self.tracks = np.full((vehicles, capacity, TRACK_COLUMNS), -1.0)
        self.tally = tally(settings.distances)
        self.number = 0
        self._rng = rng
        self._radio_state: Any = radio.init(vehicles, child_generator(seed, "radio"))
        self._sensor = sensor
        self._sensor_state: FleetSensorState | None = None
        if sensor is not None:
            self._sensor_state = sensor.init(vehicles, child_generator(seed, "sensor"))
        self._constants = _constants(sender, dt_s)
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
        before = self.tally.sums.copy()
        busy_ratio = self.radio.channel_busy_ratio(self._radio_state)
        with quiet_function_pointers():
            truth_m = self._sense_and_track(frame, seen, now_s)
            self._decide(seen, now_s, busy_ratio)
        received = self._carry(truth_m, until_s)
        receiver_kernels.hear_messages(
            received.message_id,
            received.receiver,
            received.t_s,
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

    def _sense_and_track(self, frame: FleetFrame, seen: FleetFrame, now_s: float) -> FloatArray:
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
            self.models,
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

    def _decide(self, seen: FleetFrame, now_s: float, busy_ratio: FloatArray) -> None:
        """Fill the outbox."""
        c = self._constants
        critical = seen.acceleration_mps2 < -c.critical_mps2
        deciding_kernels.decide(
            self.models,
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
            busy_ratio,
            self._rng.random((len(seen), 4)),
            self.tables,
            self.senders,
            self.contents,
            self.outbox,
            self.tally,
            np.empty(LOCAL_COLUMNS),
            np.empty(2 + self.senders.trials.shape[2]),
        )

    def _carry(self, truth_m: FloatArray, until_s: float) -> Receptions:
        """Give the outbox to the radio, in order of time."""
        out = self.outbox
        count = int(out.count[0])
        order = np.argsort(out.ready_s[:count], kind="stable")
        batch = Transmissions(
            out.sender[order],
            np.minimum(out.ready_s[order], np.nextafter(until_s, 0.0)),
            size_bytes=out.size_bytes[order],
            power_dbm=out.power_dbm[order],
            message_id=out.message_id[order],
        )
        carry = getattr(self.radio, "carry", self.radio.step)
        received, self._radio_state = carry(self._radio_state, batch, truth_m, until_s)
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


_SUB_INTERVAL_S = 1.0
"""Of the neighbour tables: vPERSubInterval of SAE J2945/1 [s]."""


@dataclass(frozen=True, slots=True)
class _Constants:
    """What the compiled loop takes of a sender."""

    rule: int
    rule_constants: FloatArray
    _: KW_ONLY
    control: int
    control_constants: FloatArray
    extra: tuple[float, float, float, float]
    stack: FloatArray
    noise: tuple[float, float, float, float, float, float]
    critical_mps2: float


_MEMBERS = 3
_NEVER = 2**31


def _models(sender: FleetSender, dt_s: float) -> tuple[Any, ...]:
    """Members as the compiled loop takes them, at least `_MEMBERS`.

    Numba compiles the loop anew for every number of members. So a short bank is filled up in front with
    members that no window is long enough for.
    """
    bank = sender.bank
    spare = max(0, _MEMBERS - len(bank.members))
    members = (bank.members[0],) * spare + bank.members
    chosen = np.array([0] * spare + list(range(len(bank.members))))
    ready = [member.point_functions(dt_s) for member in members]
    return (
        tuple(one.fit_pointer for one in ready),
        tuple(one.predict_pointer for one in ready),
        tuple(one.constants for one in ready),
        np.concatenate([np.full(spare, _NEVER, dtype=np.int64), bank.windows]),
        sender.parameter_counts[chosen],
        bank.trust[chosen],
        sender.payload_bytes[chosen],
    )


def _constants(sender: FleetSender, dt_s: float) -> _Constants:
    policy, stack = sender.policy, sender.stack
    rule, control, control_constants = RULE_PERIODIC, dcc_kernels.NONE, np.zeros(1)
    interval_s, share, critical_mps2 = 0.0, 0.0, np.inf
    if isinstance(policy, Periodic):
        interval_s = 1.0 / policy.rate_hz
    elif isinstance(policy, ErrorDriven):
        rule = RULE_ERROR_DRIVEN
    elif isinstance(policy, J2945):
        rule, critical_mps2 = RULE_J2945, policy.parameters.critical_deceleration_mps2
    else:
        rule, interval_s = RULE_CAM, policy.triggering.min_inter_transmit_time_s
        control, control_constants, share = _control(policy)
    count, clip, kept, prior_samples, free = DEFAULT_NOISE.step_constants(dt_s)
    signed = stack.certificates != "unsigned"
    around = stack.frame_bytes(np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.bool_))[0]
    return _Constants(
        rule,
        sender.rule_constants(),
        control=control,
        control_constants=control_constants,
        extra=(sender.power_dbm, sender.jitter_s, interval_s, share),
        stack=np.array(
            [
                CERTIFICATE_RULES.index(stack.certificates),
                stack.certificate_interval_s,
                around,
                stack.certificate_bytes - stack.digest_bytes if signed else 0,
                stack.preamble_s,
                stack.symbol_s,
                stack.service_tail_bits,
                stack.bits_per_symbol,
            ],
            dtype=np.float64,
        ),
        noise=(
            kept * DEFAULT_NOISE.prior_m * DEFAULT_NOISE.prior_m,
            count,
            clip,
            kept,
            prior_samples,
            float(free),
        ),
        critical_mps2=critical_mps2,
    )


def _control(policy: CooperativeAwareness) -> tuple[int, FloatArray, float]:
    control = policy.control
    if control is None:
        return dcc_kernels.NONE, np.zeros(1), 0.0
    share = 0.0
    if isinstance(control, AdaptiveDcc):
        share = control.max_share if control.start_share is None else control.start_share
    return control.code, control.constants(), share


def _capacity(first: FleetFrame, settings: NetworkSettings) -> int:
    """Slots of a host: half as many again as the fullest has in reach at first, and some."""
    place = np.where(first.active[:, None], first.position_m, np.nan)
    most = receiver_kernels.most_in_reach(place, settings.reach_m)
    return int(min(len(first) + _SPARE_SLOTS, int(1.5 * most) + _SPARE_SLOTS, 2**15 - 1))


def run_network(
    frames: Iterable[FleetFrame],
    sender: FleetSender,
    radio: AbstractRadio[Any],
    settings: NetworkSettings | None = None,
    *,
    seed: int,
    sensor: FleetSensor | None = None,
    progress: Callable[[int], None] | None = None,
) -> NetworkRun:
    """Run a fleet on the air and return what was counted.

    Parameters
    ----------
    frames
        Frames of one run, `NetworkSettings.dt_s` apart.
    sender
        What every vehicle sends, and when.
    radio
        The channel they share.
    settings
        What is tracked and counted; None for the defaults.
    seed
        Of senders, radio and sensors; frames bring their own chance. Same seed, same counts.
    sensor
        What the vehicles see of themselves; None for the truth.
    progress
        Called after every step with the number of steps done.

    Raises
    ------
    ValueError
        Where there is no frame, frames are not a step apart, or the run ends within the warm-up.

    Examples
    --------
    >>> from modelcast.channel.dsrc import Dsrc
    >>> from modelcast.simulation.network.sender import named_sender
    >>> from modelcast.simulation.scenario.base import run_scenario
    >>> from modelcast.simulation.scenario.highway import Highway
    >>> road = Highway(500.0, 20.0, warm_up_s=0.0)
    >>> frames = run_scenario(road, np.random.default_rng(1), duration_s=2.0)
    >>> run = run_network(frames, named_sender("bsm-10hz"), Dsrc(), NetworkSettings(warm_up_s=1.0), seed=1)
    >>> round(run.vehicle_s, 6), int(run.tally.causes.sum())
    (10.0, 100)
    """
    chosen = NetworkSettings() if settings is None else settings
    pending: Iterator[FleetFrame] = iter(frames)
    first = next(pending, None)
    if first is None:
        raise ValueError("frames must hold at least one frame")
    loop = FleetLoop(first, sender, radio, chosen, seed=seed, sensor=sensor)
    warm_up = round(chosen.warm_up_s / chosen.dt_s)
    a_second = max(1, round(1.0 / chosen.dt_s))
    outcomes: IntArray | None = None
    expired, series, recent = 0, list[FloatArray](), list[IntArray]()
    for number, frame in enumerate(chain([first], pending)):
        if number == warm_up:
            loop.forget_counts()
            outcomes, expired = None, 0
        received, row = loop.step(frame)
        outcomes = received.outcomes.copy() if outcomes is None else outcomes + received.outcomes
        expired += received.expired.size
        series.append(row)
        if (number + 1) % a_second == 0:
            recent.append(loop.tally.recent.copy())
            loop.tally.recent[...] = 0
        if progress is not None:
            progress(number + 1)
    if len(series) <= warm_up or outcomes is None:
        raise ValueError(f"the run must outlast the warm-up of {chosen.warm_up_s} s, got {len(series)} steps")
    rows = np.array(series)
    counted = rows[warm_up:]
    return NetworkRun(
        loop.tally,
        outcomes,
        expired=expired,
        vehicle_s=float(counted[:, 0].sum() * chosen.dt_s),
        busy_ratio=float(np.nansum(counted[:, 3] * counted[:, 0]) / max(counted[:, 0].sum(), 1.0)),
        series=rows,
        recent=np.array(recent, dtype=np.int64).reshape(len(recent), -1),
        sender_bytes=sender.payload_bytes,
    )
