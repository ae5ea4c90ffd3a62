"""NR-V2X sidelink mode 2: vehicles that hear what others reserve, and choose among what is left.

`Nr` simulates one pool of sub-channels slot by slot. A vehicle holds one message at most; a newer one takes
its place, and one that was not sent by then is lost at the sender. Periodic traffic suits resources that come
back; messages at uneven times do better with a dynamic grant (`NrParameters.dynamic`, or `Grant.ONE_SHOT`).
"""

from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Self

import numpy as np

from modelcast.channel.antennas import antennas, checked_gains
from modelcast.channel.copies_kernels import PAIR_COLUMNS, Copies
from modelcast.channel.error_models import AbstractErrorModel, ThresholdErrorModel
from modelcast.channel.frame_errors import FrameErrors, frame_errors
from modelcast.channel.frame_kernels import Heard
from modelcast.channel.frame_radio import (
    AbstractFrameRadio,
    asked,
    told_of_fading_twice,
    without_second_fading,
)
from modelcast.channel.in_band_emission import in_band_emission
from modelcast.channel.nr_kernels import COPIES, GRANT_COLUMNS, LENGTH, MESSAGE, SlotMemory, advance
from modelcast.channel.nr_parameters import INTERVALS_MS, RESERVED_SPAN, NrParameters
from modelcast.channel.nr_selection_kernels import NrConstants
from modelcast.channel.pair_kernels import Pairs, empty_pairs
from modelcast.channel.pool_air_kernels import find_reach
from modelcast.channel.pool_constants import pool_constants
from modelcast.channel.propagation import Propagation
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.radio import Transmissions
from modelcast.channel.shadow_sweep import renew_pairs
from modelcast.channel.shadowing_kernels import lay_out
from modelcast.core.arrays import FloatArray, IntArray, SingleArray
from modelcast.core.parts import Parts

__all__ = ["Nr", "NrState"]


@dataclass(frozen=True, slots=True)
class NrState:
    """A pool at one instant: plain arrays.

    Parameters
    ----------
    t_s
        Now; a whole slot [s].
    random
        Word of the random generator, and the seed of shadowing, (2,).
    grant
        Waiting message of every vehicle, and what its resources are, (V, GRANT_COLUMNS).
    slots, bands
        Next slot and first sub-channel of the resource of each copy, slots -1 for none, (V, copies).
    power_dbm
        Power of the waiting message, (V,) [dBm].
    reserved
        What each vehicle knows of coming slots, by slot modulo their number: power of 15 kHz of the strongest
        reservation, infinite where it cannot know, (ahead, V, sub-channels) [mW].
    copy_pair, copy_span
        What became so far of messages of which copies are still to come, as `Copies` has it, (P, 3), (V, 2).
    busy
        Busy sub-channels and own transmissions since the window began, (V, 2).
    busy_ratio
        Of the last full window, (V,).
    pairs, pair_count
        Shadowing of pairs, as `Pairs` has it, (V, S, 4), (V,).
    gain_db
        Of the antennas, beside a vehicle's, (V,) [dB].
    """

    t_s: float
    random: np.ndarray[tuple[int], np.dtype[np.uint64]]
    _: KW_ONLY
    grant: IntArray
    slots: IntArray
    bands: IntArray
    power_dbm: FloatArray
    reserved: SingleArray
    copy_pair: IntArray
    copy_span: IntArray
    busy: IntArray
    busy_ratio: FloatArray
    pairs: SingleArray
    pair_count: IntArray
    gain_db: FloatArray

    @property
    def vehicles(self) -> int:
        """Number of vehicles V."""
        return self.grant.shape[0]


@dataclass(frozen=True, slots=True)
class Nr(AbstractFrameRadio[NrState]):
    """NR-V2X sidelink mode 2 of a fleet on one pool.

    Parameters
    ----------
    parameters
        Constants of the radio.
    propagation
        What becomes of the power. The default has no fast fading, as the steps of the default errors and the
        curves expect.
    error_model
        Packet error against SINR; None for a step at what the message's own rate needs
        (`NrParameters.threshold_db`).

    Notes
    -----
    Steps must end on whole slots. A message that becomes ready in a slot goes out T1 to T2 later. Of a
    transmission ``grant`` is heeded: `Grant.ONE_SHOT` chooses resources for this message alone, whatever the
    vehicle holds; `Grant.PERIODIC` ones that come back, and if ``next_s`` is known, after the shortest
    interval for which the next message is ready, `NrParameters.longest_ms` at most. A held resource takes the
    interval of each message that it carries, and is left after it where the vehicle knows of others then.
    ``priority`` is not heeded. A receiver has a message if it decodes any of its copies; copies are not added
    up. Of lost frames, ``concurrent`` means that the strongest interferer was near enough to hear the
    sender's reservations (median power), ``hidden`` that it was not; of lost copies the last one counts.

    Examples
    --------
    >>> import numpy as np
    >>> radio = Nr(NrParameters(transmissions=2))
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

    parameters: NrParameters = field(default_factory=NrParameters)
    propagation: Propagation = field(default_factory=lambda: Propagation(fading=None))
    error_model: AbstractErrorModel | None = None
    constants: NrConstants = field(init=False, repr=False, compare=False)
    lengths: IntArray = field(init=False, repr=False, compare=False)
    errors: FrameErrors = field(init=False, repr=False, compare=False)
    leak: FloatArray = field(init=False, repr=False, compare=False)
    tables: PropagationTables = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        p = self.parameters
        if self.error_model is not None:
            told_of_fading_twice(self.propagation, self.error_model)
        constants = self._constants()
        size_bytes = np.maximum(np.arange(p.largest_bytes + 1), 1)
        leak = in_band_emission(p.sub_channels, p.blocks, mask=p.emission, total_blocks=p.channel_blocks)
        object.__setattr__(self, "constants", constants)
        object.__setattr__(self, "lengths", p.length(size_bytes))
        object.__setattr__(self, "errors", self._errors(size_bytes))
        object.__setattr__(self, "leak", leak)
        object.__setattr__(self, "tables", self.propagation.tables(constants.pool.range_m))

    @property
    def range_m(self) -> float:
        """Distance beyond which nothing is heard or disturbed [m]."""
        return self.constants.pool.range_m

    def _constants(self) -> NrConstants:
        p, slots = self.parameters, self.parameters.slots_a_ms
        last = round(p.last_ms * slots)
        return NrConstants(
            pool=pool_constants(p, self.propagation, slots_a_ms=slots),
            overlapping=p.overlapping,
            slots_a_ms=slots,
            first=round(p.first_ms * slots),
            last=last,
            interval=p.interval_ms * slots,
            longest=p.longest_ms * slots,
            ahead=max(-(-last // (ms * slots)) * ms * slots for ms in INTERVALS_MS if ms <= p.longest_ms),
            span=RESERVED_SPAN,
            copies=p.transmissions,
            dynamic=p.dynamic,
            keep_ratio=p.keep_ratio,
            reselect_after=p.reselect_after,
            free_ratio=p.free_ratio,
            reserved_by_total=p.reserved_by_total,
        )

    def _errors(self, size_bytes: IntArray) -> FrameErrors:
        if self.error_model is not None:
            return frame_errors(self.error_model, size_bytes)
        return frame_errors(ThresholdErrorModel(0.0), size_bytes, self.parameters.threshold_db(size_bytes))

    @property
    def bin_m(self) -> float:
        """Width of the bins of distance of its outcomes [m]."""
        return self.parameters.bin_m

    def within(self, propagation: Propagation) -> Self:
        """The radio with this propagation, without fast fading where the errors hold it: the steps do."""
        if self.error_model is None:
            return replace(self, propagation=replace(propagation, fading=None))
        return replace(self, propagation=without_second_fading(propagation, self.error_model))

    def silent(self, vehicles: int, random: np.ndarray[tuple[int], np.dtype[np.uint64]]) -> NrState:
        """State at time 0 of V vehicles."""
        p, copies = self.parameters, self.parameters.transmissions
        grant = np.zeros((vehicles, GRANT_COLUMNS), dtype=np.int64)
        grant[:, MESSAGE], grant[:, COPIES] = -1, 0
        pairs = empty_pairs(vehicles, 16)
        return NrState(
            0.0,
            random,
            grant=grant,
            slots=np.full((vehicles, copies), -1, dtype=np.int64),
            bands=np.zeros((vehicles, copies), dtype=np.int64),
            power_dbm=np.zeros(vehicles),
            reserved=np.zeros((self.constants.ahead, vehicles, p.sub_channels), dtype=np.float32),
            copy_pair=np.empty((0, PAIR_COLUMNS), dtype=np.int64),
            copy_span=np.zeros((vehicles, 2), dtype=np.int64),
            busy=np.zeros((vehicles, 2), dtype=np.int64),
            busy_ratio=np.zeros(vehicles),
            pairs=pairs.held,
            pair_count=pairs.owned,
            gain_db=np.zeros(vehicles),
        )

    def fit_antennas(self, state: NrState, gain_db: FloatArray) -> NrState:
        """The state with these antennas, from the next slot on."""
        return replace(state, gain_db=checked_gains(gain_db, state.vehicles))

    def advance(
        self,
        state: NrState,
        transmissions: Transmissions,
        position_m: FloatArray,
        until_t_s: float,
        parts: Parts,
    ) -> tuple[Heard, NrState]:
        """Check what is asked for and carry one interval; the state is used up."""
        self._check(state, transmissions, position_m, until_t_s)
        sent, fitted = asked(transmissions), antennas(state.gain_db)
        slots_a_s = 1e3 * self.parameters.slots_a_ms
        memory = SlotMemory(
            state.grant,
            state.slots,
            state.bands,
            state.power_dbm,
            state.reserved,
            Copies(state.copy_pair, state.copy_span, np.full(state.vehicles, -1, dtype=np.int64)),
            state.busy,
            state.busy_ratio,
        )
        reach_m2 = find_reach(
            sent.sender,
            self.lengths[sent.size_bytes].astype(np.float64),
            sent.power_dbm,
            np.where(state.grant[:, MESSAGE] >= 0, state.grant[:, LENGTH], -1).astype(np.float64),
            state.power_dbm,
            position_m,
            fitted,
            self.tables,
            self.constants.pool,
        )
        sweep = lay_out(reach_m2, position_m, fitted.weak, self.range_m)
        pairs = renew_pairs(sweep, Pairs(state.pairs, state.pair_count), state.random[1], self.tables, parts)
        heard, copy_pair, copy_span = parts.beside(
            lambda: advance(
                round(state.t_s * slots_a_s),
                round(until_t_s * slots_a_s),
                state.random,
                memory,
                sent,
                self.lengths,
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
            copy_pair=copy_pair,
            copy_span=copy_span,
            pairs=pairs.held,
            pair_count=pairs.owned,
        )
        return heard, after

    def channel_busy_ratio(self, state: NrState) -> FloatArray:
        """Share of sub-channels above the threshold in the last full window of every vehicle, 0..1, (V,)."""
        return state.busy_ratio.copy()

    def _check(
        self, state: NrState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> None:
        slots = until_t_s * 1e3 * self.parameters.slots_a_ms
        if abs(slots - round(slots)) > 1e-6:
            raise ValueError(
                f"until_t_s must be a whole number of slots of {1e3 / self.parameters.slots_a_ms:g} us, "
                f"got {until_t_s} s"
            )
        transmissions.check(state.t_s, until_t_s, position_m, state.vehicles, self.parameters.max_power_dbm)
        most = self.lengths.size - 1
        if transmissions.size > 0 and int(transmissions.size_bytes.max()) > most:
            raise ValueError(
                f"size_bytes must fit into {self.parameters.sub_channels} sub-channels, "
                f"{most} bytes at most, got {int(transmissions.size_bytes.max())}"
            )
