"""LTE-V2X mode 4: vehicles that listen for a second, reserve a resource, and come back to it.

`Sidelink` simulates sensing-based semi-persistent scheduling of one pool of sub-channels. A vehicle holds one
message at most; a newer one takes its place. Periodic traffic suits it; for messages at uneven times there
is the one-shot grant (`Grant.ONE_SHOT`, `SidelinkParameters.one_shot`), chosen by the same sensing and never
announced, and the interval that is announced by when the next message is expected. SAE J3161/1 interleaves
one-shots with reservations and sends every message twice (`j3161_sidelink_parameters`).
"""

from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Self

import numpy as np

from modelcast.channel.antennas import antennas, checked_gains
from modelcast.channel.copies_kernels import PAIR_COLUMNS, Copies
from modelcast.channel.error_models import AbstractErrorModel, TabulatedErrorModel
from modelcast.channel.frame_errors import FrameErrors, frame_errors
from modelcast.channel.frame_kernels import Heard
from modelcast.channel.frame_radio import (
    AbstractFrameRadio,
    asked,
    told_of_fading_twice,
    without_second_fading,
)
from modelcast.channel.in_band_emission import in_band_emission
from modelcast.channel.pair_kernels import Pairs, empty_pairs
from modelcast.channel.pool_air_kernels import find_reach
from modelcast.channel.pool_constants import pool_constants
from modelcast.channel.propagation import Propagation
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.radio import Transmissions
from modelcast.channel.shadow_sweep import renew_pairs
from modelcast.channel.shadowing_kernels import lay_out
from modelcast.channel.sidelink_grant_kernels import BAND, BYTES, GRANT_COLUMNS, MESSAGE, TURNS
from modelcast.channel.sidelink_kernels import Memory, advance
from modelcast.channel.sidelink_parameters import (
    COUNTER,
    COUNTERS,
    MEMORY,
    STEP,
    SidelinkParameters,
)
from modelcast.channel.sidelink_selection_kernels import SidelinkConstants
from modelcast.core.arrays import FloatArray, IntArray, SingleArray
from modelcast.core.parts import Parts

__all__ = ["Sidelink", "SidelinkState"]


@dataclass(frozen=True, slots=True)
class SidelinkState:
    """A pool at one instant: plain arrays.

    Parameters
    ----------
    t_s
        Now; a whole millisecond [s].
    random
        Word of the random generator, and the seed of shadowing, (2,).
    grant
        Resource and waiting message of every vehicle, (V, GRANT_COLUMNS).
    power_dbm
        Power of the waiting message, (V,) [dBm].
    sensed
        S-RSSI of the last 1000 subframes, infinite where the vehicle sent, (100, V, 10 sub-channels) [mW]:
        those 100 subframes apart lie side by side, since they are averaged.
    reserved
        Power of an element of the strongest reservation by phase of the longest interval, (interval, V,
        sub-channels); one that excludes nothing may be left out [mW].
    busy
        Busy sub-channels and own transmissions since the window began, (V, 2).
    busy_ratio
        Of the last full window, (V,).
    pairs, pair_count
        Shadowing of pairs, as `Pairs` has it, (V, S, 4), (V,).
    gain_db
        Of the antennas, beside a vehicle's, (V,) [dB].
    copy_pair, copy_span
        Messages of which a copy is still to come at their receivers, as `Copies` has them, (P, 3), (V, 2).
    """

    t_s: float
    random: np.ndarray[tuple[int], np.dtype[np.uint64]]
    _: KW_ONLY
    grant: IntArray
    power_dbm: FloatArray
    sensed: SingleArray
    reserved: SingleArray
    busy: IntArray
    busy_ratio: FloatArray
    pairs: SingleArray
    pair_count: IntArray
    gain_db: FloatArray
    copy_pair: IntArray
    copy_span: IntArray

    @property
    def vehicles(self) -> int:
        """Number of vehicles V."""
        return self.grant.shape[0]


@dataclass(frozen=True, slots=True)
class Sidelink(AbstractFrameRadio[SidelinkState]):
    """LTE-V2X mode 4 of a fleet on one pool.

    Parameters
    ----------
    parameters
        Constants of the radio.
    propagation
        What becomes of the power. The default has no fast fading: the error curve holds it.
    error_model
        Packet error against SINR.

    Notes
    -----
    Time runs in subframes of 1 ms; steps must end on one. A message ready in subframe n is looked at when n
    is over and sent in n + T1 to n + T2. ``grant`` of a transmission is heeded, ``next_s`` where the
    parameters say so (`SidelinkParameters.interval_by_next`, ``grant_by_next``), ``priority`` not at all. Of
    lost frames, ``concurrent`` means that the strongest interferer was near enough to hear the sender's
    reservations (median power), ``hidden`` that it was not. Of a message sent twice a pair counts once, when
    the second copy has gone out: as received, or by what became of that one.

    Examples
    --------
    >>> import numpy as np
    >>> radio = Sidelink()
    >>> state = radio.init(2, np.random.default_rng(1))
    >>> one = Transmissions(
    ...     np.array([0]),
    ...     np.array([0.01]),
    ...     size_bytes=np.array([300]),
    ...     power_dbm=np.array([23.0]),
    ...     message_id=np.array([7]),
    ... )
    >>> heard, state = radio.step(state, one, np.array([[0.0, 0.0], [50.0, 0.0]]), 0.2)
    >>> heard.message_id.tolist(), bool(0.012 <= heard.t_s[0] <= 0.111)
    ([7], True)
    """

    parameters: SidelinkParameters = field(default_factory=SidelinkParameters)
    propagation: Propagation = field(default_factory=lambda: Propagation(fading=None))
    error_model: AbstractErrorModel = field(default_factory=TabulatedErrorModel.sidelink_mcs5)
    constants: SidelinkConstants = field(init=False, repr=False, compare=False)
    lengths: IntArray = field(init=False, repr=False, compare=False)
    filled: FloatArray = field(init=False, repr=False, compare=False)
    errors: FrameErrors = field(init=False, repr=False, compare=False)
    leak: FloatArray = field(init=False, repr=False, compare=False)
    tables: PropagationTables = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        told_of_fading_twice(self.propagation, self.error_model)
        p, constants = self.parameters, self._constants()
        size_bytes = np.maximum(np.arange(p.largest_bytes + 1), 1)
        object.__setattr__(self, "constants", constants)
        object.__setattr__(self, "lengths", p.length(size_bytes))
        object.__setattr__(self, "filled", p.blocks_of(size_bytes) / p.blocks)
        object.__setattr__(self, "errors", frame_errors(self.error_model, size_bytes))
        object.__setattr__(self, "leak", in_band_emission(p.sub_channels, p.blocks))
        object.__setattr__(self, "tables", self.propagation.tables(constants.pool.range_m))

    @property
    def range_m(self) -> float:
        """Distance beyond which nothing is heard or disturbed [m]."""
        return self.constants.pool.range_m

    def _constants(self) -> SidelinkConstants:
        p = self.parameters
        low, high = COUNTERS.get(p.interval_ms, COUNTER)
        return SidelinkConstants(
            pool=pool_constants(p, self.propagation, noise_counts=p.noise_counts),
            overlapping=p.overlapping,
            first=p.first_ms,
            last=p.last_ms if p.interval_by_next else min(p.last_ms, p.interval_ms),
            interval=p.interval_ms,
            longest=p.horizon_ms,
            horizon=p.horizon_ms,
            copies=p.transmissions,
            one_shot=p.one_shot,
            interleaved=p.interleaved,
            interval_by_next=p.interval_by_next,
            grant_by_next=p.grant_by_next,
            shots_low=p.one_shot_least,
            shots_high=p.one_shot_most,
            counter_low=low,
            counter_high=high,
            keep_ratio=p.keep_ratio,
            reselect_after=p.reselect_after,
            best_ratio=p.best_ratio,
            best_of_possible=p.best_of_possible,
            reserved_by_mean=p.reserved_by_mean,
            first_by_chance=p.first_by_chance,
        )

    @property
    def bin_m(self) -> float:
        """Width of the bins of distance of its outcomes [m]."""
        return self.parameters.bin_m

    def within(self, propagation: Propagation) -> Self:
        """The radio with this propagation, without fast fading where the error model holds it."""
        return replace(self, propagation=without_second_fading(propagation, self.error_model))

    def silent(self, vehicles: int, random: np.ndarray[tuple[int], np.dtype[np.uint64]]) -> SidelinkState:
        """State at time 0 of V vehicles."""
        p = self.parameters
        grant = np.zeros((vehicles, GRANT_COLUMNS), dtype=np.int64)
        grant[:, BAND : BAND + TURNS] = -1
        grant[:, MESSAGE] = -1
        pairs = empty_pairs(vehicles, 16)
        quiet_mw = self.constants.pool.noise_mw if p.noise_counts else 0.0
        return SidelinkState(
            0.0,
            random,
            grant=grant,
            power_dbm=np.zeros(vehicles),
            sensed=np.full((STEP, vehicles, MEMORY // STEP * p.sub_channels), quiet_mw, dtype=np.float32),
            reserved=np.zeros((p.horizon_ms, vehicles, p.sub_channels), dtype=np.float32),
            busy=np.zeros((vehicles, 2), dtype=np.int64),
            busy_ratio=np.zeros(vehicles),
            pairs=pairs.held,
            pair_count=pairs.owned,
            gain_db=np.zeros(vehicles),
            copy_pair=np.empty((0, PAIR_COLUMNS), dtype=np.int64),
            copy_span=np.zeros((vehicles, 2), dtype=np.int64),
        )

    def fit_antennas(self, state: SidelinkState, gain_db: FloatArray) -> SidelinkState:
        """The state with these antennas, from the next subframe on."""
        return replace(state, gain_db=checked_gains(gain_db, state.vehicles))

    def advance(
        self,
        state: SidelinkState,
        transmissions: Transmissions,
        position_m: FloatArray,
        until_t_s: float,
        parts: Parts,
    ) -> tuple[Heard, SidelinkState]:
        """Check what is asked for and carry one interval; the state is used up."""
        self._check(state, transmissions, position_m, until_t_s)
        sent, fitted = asked(transmissions), antennas(state.gain_db)
        reach_m2 = find_reach(
            sent.sender,
            self.filled[sent.size_bytes],
            sent.power_dbm,
            np.where(state.grant[:, MESSAGE] >= 0, self.filled[state.grant[:, BYTES]], -1.0),
            state.power_dbm,
            position_m,
            fitted,
            self.tables,
            self.constants.pool,
        )
        sweep = lay_out(reach_m2, position_m, fitted.weak, self.constants.pool.range_m)
        pairs = renew_pairs(sweep, Pairs(state.pairs, state.pair_count), state.random[1], self.tables, parts)
        copies = Copies(state.copy_pair, state.copy_span, np.full(state.vehicles, -1, dtype=np.int64))
        memory = Memory(
            state.grant,
            state.power_dbm,
            state.sensed,
            state.reserved,
            state.busy,
            state.busy_ratio,
            copies,
        )
        heard, copy_pair, copy_span = parts.beside(
            lambda: advance(
                round(state.t_s * 1e3),
                round(until_t_s * 1e3),
                state.random,
                memory,
                sent,
                self.lengths,
                self.filled,
                sweep,
                fitted,
                self.errors,
                self.leak,
                self.tables,
                self.constants,
            )
        )
        after = replace(
            state,
            t_s=until_t_s,
            pairs=pairs.held,
            pair_count=pairs.owned,
            copy_pair=copy_pair,
            copy_span=copy_span,
        )
        return heard, after

    def channel_busy_ratio(self, state: SidelinkState) -> FloatArray:
        """Share of sub-channels above -94 dBm in the last full 100 subframes of every vehicle, 0..1, (V,)."""
        return state.busy_ratio.copy()

    def _check(
        self, state: SidelinkState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> None:
        if abs(until_t_s * 1e3 - round(until_t_s * 1e3)) > 1e-6:
            raise ValueError(f"until_t_s must be a whole number of milliseconds, got {until_t_s} s")
        transmissions.check(state.t_s, until_t_s, position_m, state.vehicles, self.parameters.max_power_dbm)
        if transmissions.size > 0:
            longest = int(self.parameters.length(transmissions.size_bytes).max())
            if longest > self.parameters.sub_channels:
                raise ValueError(
                    f"size_bytes must fit into {self.parameters.sub_channels} sub-channels, "
                    f"got {int(transmissions.size_bytes.max())} bytes, which take {longest}"
                )
