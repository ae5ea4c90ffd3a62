"""IEEE 802.11p broadcast: senders that listen first, count down in slots, and still collide.

`Dsrc` simulates EDCA of one channel event by event for a whole fleet. A vehicle holds one message at most; a
newer one takes its place (awareness messages age). There is no acknowledgement, no retry and no window
growth.
"""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Self

import numpy as np

from modelcast.channel.antennas import antennas, checked_gains
from modelcast.channel.dsrc_kernels import advance, begin_interval, end_interval, find_reach
from modelcast.channel.dsrc_link_kernels import Links
from modelcast.channel.dsrc_parameters import DsrcParameters, power_ratio
from modelcast.channel.dsrc_station_kernels import BUSY_RATIO, DsrcConstants, silent_station
from modelcast.channel.error_models import AbstractErrorModel, NistErrorModel, safe_ratio
from modelcast.channel.frame_kernels import Heard
from modelcast.channel.frame_radio import (
    AbstractFrameRadio,
    asked,
    error_units,
    has_shadowing,
    receptions_of,
    told_of_fading_twice,
    without_second_fading,
)
from modelcast.channel.pair_kernels import Pairs, empty_pairs
from modelcast.channel.propagation import Propagation
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.radio import Receptions, Transmissions
from modelcast.channel.shadow_sweep import renew_pairs
from modelcast.channel.shadowing_kernels import lay_out
from modelcast.core.arrays import FloatArray, IntArray, SingleArray
from modelcast.core.parts import Parts

__all__ = ["Dsrc", "DsrcState"]

TOLD_AT = (0.5, 0.9)
"""Shares of an interval after which receptions are told of, before its end. Who reads them beside has other
work at first, and what comes last is read by all threads. A host's table is fetched once a span: more of them
cost more than they hide."""


@dataclass(frozen=True, slots=True)
class DsrcState:
    """A channel at one instant: plain arrays, whose columns are named in ``dsrc_station_kernels``.

    Parameters
    ----------
    t_s
        Now [s].
    random
        Word of the random generator, and the seed of shadowing, (2,).
    station
        Receiver, medium access and frame of every vehicle, (V, COLUMNS).
    message
        Messages that wait, that are on the air, and their chance, (V, 3).
    air_receiver, air_mw, air_flag
        Links of the frames on the air, (L,), (L,), (L, 2).
    pairs, pair_count
        Shadowing of pairs, as `Pairs` has it, (V, S, 4), (V,).
    gain_db
        Of the antennas, beside a vehicle's, (V,) [dB].
    """

    t_s: float
    random: np.ndarray[tuple[int], np.dtype[np.uint64]]
    _: KW_ONLY
    station: FloatArray
    message: IntArray
    air_receiver: np.ndarray[tuple[int], np.dtype[np.int32]]
    air_mw: FloatArray
    air_flag: np.ndarray[tuple[int, int], np.dtype[np.int16]]
    pairs: SingleArray
    pair_count: IntArray
    gain_db: FloatArray

    @property
    def vehicles(self) -> int:
        """Number of vehicles V."""
        return self.station.shape[0]


@dataclass(frozen=True, slots=True)
class Dsrc(AbstractFrameRadio[DsrcState]):
    """IEEE 802.11p broadcast of a fleet on one channel.

    Parameters
    ----------
    parameters
        Constants of the radio.
    propagation
        What becomes of the power.
    error_model
        Packet error against SINR; None for the NIST model of the bit rate.

    Notes
    -----
    A receiver locks on to a frame that is strong enough and stands out of what is on the air at its
    beginning. It stays locked to the end, save for capture in the preamble, or its own countdown ending
    before it has sensed the frame. Interference is all other power in range, over the payload. Preamble and
    SIGNAL fail only at their beginning. A vehicle's queue holds one message. Pairs of frame and station of
    which one has a weak antenna (`fit_antennas`) are among the outcomes only as far as such a frame may be
    noticed. Of what a transmission may say,
    ``priority``, ``next_s`` and ``grant`` are not heeded: all messages have the access category of the
    parameters.

    Examples
    --------
    >>> import numpy as np
    >>> radio = Dsrc()
    >>> state = radio.init(2, np.random.default_rng(1))
    >>> one = Transmissions(
    ...     np.array([0]),
    ...     np.array([0.01]),
    ...     size_bytes=np.array([300]),
    ...     power_dbm=np.array([20.0]),
    ...     message_id=np.array([7]),
    ... )
    >>> heard, state = radio.step(state, one, np.array([[0.0, 0.0], [50.0, 0.0]]), 0.1)
    >>> heard.message_id.tolist(), heard.receiver.tolist(), heard.t_s.round(6).tolist()
    ([7], [1], [0.010448])
    """

    parameters: DsrcParameters = field(default_factory=DsrcParameters)
    propagation: Propagation = field(default_factory=Propagation)
    error_model: AbstractErrorModel | None = None
    constants: DsrcConstants = field(init=False, repr=False, compare=False)
    hazard: FloatArray = field(init=False, repr=False, compare=False)
    tables: PropagationTables = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        error_model = self.error_model
        if error_model is None:
            rate = self.parameters.bit_rate
            error_model = NistErrorModel(rate.bits_per_subcarrier, rate.code_rate)
        told_of_fading_twice(self.propagation, error_model)
        constants = self._constants(error_model)
        object.__setattr__(self, "constants", constants)
        object.__setattr__(self, "hazard", np.ascontiguousarray(error_model.hazards()))
        object.__setattr__(self, "tables", self.propagation.tables(constants.range_m))

    @property
    def range_m(self) -> float:
        """Distance beyond which nothing is heard or disturbed [m]."""
        return self.constants.range_m

    def _constants(self, error_model: AbstractErrorModel) -> DsrcConstants:
        p = self.parameters
        loudest_dbm = p.max_power_dbm + 2.0 * p.antenna_gain_db
        range_m = self.propagation.range_m(loudest_dbm - (p.noise_dbm - p.margin_db))
        units_fixed, units_per_byte = error_units(error_model)
        return DsrcConstants(
            slot_s=p.slot_s,
            aifs_s=p.aifs_s,
            extended_s=p.extended_s,
            window=p.access.window,
            sensing_s=p.sensing_s,
            immediate=p.immediate_access,
            arrival_aifs_s=p.aifs_s if p.aifs_on_arrival else 0.0,
            preamble_s=p.preamble_s,
            symbol_s=p.symbol_s,
            bits_per_symbol=p.bit_rate.bits_per_symbol,
            capture_s=p.capture_s,
            capture_ratio=power_ratio(p.capture_db),
            ties_spoil=p.ties_spoil,
            preamble_ratio=power_ratio(p.preamble_db),
            noise_mw=power_ratio(p.noise_dbm),
            sensitivity_mw=power_ratio(p.sensitivity_dbm),
            decodable_mw=power_ratio(p.decodable_dbm),
            energy_mw=power_ratio(p.energy_dbm),
            load_mw=power_ratio(p.load_dbm),
            quiet_mw=power_ratio(p.noise_dbm - p.margin_db),
            weak_quiet_mw=power_ratio(p.noise_dbm - p.weak_margin_db),
            gain_db=2.0 * p.antenna_gain_db,
            range_m=range_m,
            bin_m=p.bin_m,
            bins=p.bins,
            window_s=p.busy_window_s,
            by_stretch=error_model.by_stretch,
            units_fixed=units_fixed,
            units_per_byte=units_per_byte,
            shadowed=has_shadowing(self.propagation),
            safe_ratio=safe_ratio(error_model.hazards()),
        )

    @property
    def bin_m(self) -> float:
        """Width of the bins of distance of its outcomes [m]."""
        return self.parameters.bin_m

    def within(self, propagation: Propagation) -> Self:
        """The radio with this propagation, without fast fading where the error model holds it."""
        model = self.error_model
        return replace(self, propagation=without_second_fading(propagation, model) if model else propagation)

    def silent(self, vehicles: int, random: np.ndarray[tuple[int], np.dtype[np.uint64]]) -> DsrcState:
        """State at time 0 of V vehicles."""
        pairs = empty_pairs(vehicles, 16)
        return DsrcState(
            0.0,
            random,
            station=silent_station(vehicles),
            message=np.full((vehicles, 3), -1, dtype=np.int64),
            air_receiver=np.empty(0, dtype=np.int32),
            air_mw=np.empty(0),
            air_flag=np.empty((0, 2), dtype=np.int16),
            pairs=pairs.held,
            pair_count=pairs.owned,
            gain_db=np.zeros(vehicles),
        )

    def fit_antennas(self, state: DsrcState, gain_db: FloatArray) -> DsrcState:
        """The state with these antennas, of frames that begin from here on."""
        return replace(state, gain_db=checked_gains(gain_db, state.vehicles))

    def advance(
        self,
        state: DsrcState,
        transmissions: Transmissions,
        position_m: FloatArray,
        until_t_s: float,
        parts: Parts,
    ) -> tuple[Heard, DsrcState]:
        """Check what is asked for and carry one interval; the state is used up."""
        return self._carry_spans(state, transmissions, position_m, (until_t_s,), parts)

    def carry_and_tell(  # noqa: PLR0917 - as `carry`, and whom to tell
        self,
        state: DsrcState,
        transmissions: Transmissions,
        position_m: FloatArray,
        until_t_s: float,
        parts: Parts,
        told: Callable[[Receptions], None],
    ) -> tuple[Receptions, DsrcState]:
        """Carry one interval, and tell of receptions as its spans end."""
        nothing, pieces = np.empty(0, dtype=np.int64), list[Receptions]()

        def tell(who: IntArray, when: FloatArray, outcomes: IntArray) -> None:
            def give() -> None:
                pieces.append(receptions_of(Heard(who, when, outcomes, nothing)))
                told(pieces[-1])

            parts.hand_over(give)

        place_m = np.ascontiguousarray(position_m, dtype=np.float64)
        length_s = until_t_s - state.t_s
        stops_s = (*(state.t_s + share * length_s for share in TOLD_AT), until_t_s)
        heard, after = self._carry_spans(state, transmissions, place_m, stops_s, parts, tell)
        parts.finish()
        return Receptions.joined(pieces, outcomes=heard.outcomes, expired=heard.expired), after

    def _carry_spans(  # noqa: PLR0917 - as `advance`, and whom to tell
        self,
        state: DsrcState,
        transmissions: Transmissions,
        position_m: FloatArray,
        stops_s: tuple[float, ...],
        parts: Parts,
        tell: Callable[[IntArray, FloatArray, IntArray], None] | None = None,
    ) -> tuple[Heard, DsrcState]:
        """Carry an interval, halted at some times to tell what was heard, the last of them its end."""
        transmissions.check(state.t_s, stops_s[-1], position_m, state.vehicles, self.parameters.max_power_dbm)
        sent = asked(transmissions)
        fitted = antennas(state.gain_db)
        reach_m2 = find_reach(
            state.station, state.message, sent, position_m, fitted, self.tables, self.constants
        )
        sweep = lay_out(reach_m2, position_m, fitted.weak, self.constants.range_m)
        pairs = renew_pairs(sweep, Pairs(state.pairs, state.pair_count), state.random[1], self.tables, parts)

        def carried() -> tuple[Heard, Links]:
            air = Links(state.air_receiver, state.air_mw, state.air_flag)
            course = begin_interval(state.t_s, state.station, state.message, air, sent, self.constants)
            for stop_s in stops_s:
                before = course.received
                course = advance(
                    course,
                    stop_s,
                    stop_s == stops_s[-1],
                    state.random,
                    state.station,
                    state.message,
                    sent,
                    sweep,
                    fitted,
                    self.hazard,
                    self.tables,
                    self.constants,
                )
                if tell is not None:
                    span, heard = slice(before, course.received), course.heard
                    tell(heard.who[span], heard.when[span], heard.outcomes)
            return end_interval(state.station, state.message, course)

        heard, air = parts.beside(carried)
        after = replace(
            state,
            t_s=stops_s[-1],
            air_receiver=air.receiver,
            air_mw=air.mw,
            air_flag=air.flag,
            pairs=pairs.held,
            pair_count=pairs.owned,
        )
        return heard, after

    def channel_busy_ratio(self, state: DsrcState) -> FloatArray:
        """Busy share of the last full 100 ms of every vehicle, 0..1, (V,)."""
        return state.station[:, BUSY_RATIO].copy()
