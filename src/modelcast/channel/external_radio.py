"""A radio outside: another simulator carries the frames, and has a clock and a memory of its own.

Other simulators step forward only. `AbstractExternalRadio` is a radio like any other to who uses it; what
stands behind it is an `AbstractRadioSimulator`, which a person writes: transmissions go in, what became of
each pair of frame and station comes out, and how busy every station found the channel.
"""

import abc
from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from modelcast.channel.antennas import checked_gains
from modelcast.channel.radio import OUTCOMES, AbstractRadio, Receptions, Transmissions
from modelcast.core.arrays import BoolArray, FloatArray, IntArray

__all__ = ["AbstractExternalRadio", "AbstractRadioSimulator", "CarriedFrames", "ExternalState"]

_RECEIVED = OUTCOMES.index("received")


@dataclass(frozen=True, slots=True)
class CarriedFrames:
    """What became of frames in one interval, a row for each pair of frame and station.

    Parameters
    ----------
    message_id, receiver
        Which message, and the station that received it or lost it, (P,).
    end_s
        When the last bit arrived; of a lost frame, when it ended, (P,) [s].
    rssi_dbm
        Received power, NaN where it is not known, (P,) [dBm].
    outcome
        Index in `OUTCOMES`, 0 for received, (P,). Of lost frames only those in reach are told; a simulator
        that does not know why takes ``below-sensitivity``.
    ended
        Numbers of the messages whose frames ended in the interval, heard or not, (F,).
    expired
        Numbers of the messages that will never be sent, (E,).
    busy_ratio
        Busy share of the last full measuring window of every station, 0..1, (V,).

    Notes
    -----
    Every message ends or expires once. The rows are those of messages that ended in the interval.
    """

    message_id: IntArray
    receiver: IntArray
    _: KW_ONLY
    end_s: FloatArray
    rssi_dbm: FloatArray
    outcome: IntArray
    ended: IntArray
    expired: IntArray
    busy_ratio: FloatArray


class AbstractRadioSimulator(abc.ABC):
    """Another simulator's channel with its stations, from time 0 on: it only goes forward.

    What it holds (a process, a socket) it frees when it is collected.
    """

    @abc.abstractmethod
    def carry(self, transmissions: Transmissions, position_m: FloatArray, until_t_s: float) -> CarriedFrames:
        """Run on to ``until_t_s`` and say what became of frames since the last call.

        Parameters
        ----------
        transmissions
            Messages ready within the interval.
        position_m
            East and north of all stations, held for the interval, (V, 2) [m]. A station at NaN is absent: it
            neither sends nor hears, and a message that waits at it expires.
        until_t_s
            End of the interval [s]. What is on the air or waits then is told of later.

        Raises
        ------
        ModelcastError
            Where the simulator is lost.
        ValueError
            Where it cannot carry what is asked for.
        """


class _Course:
    """How far a simulator has gone, and what it still owes an answer to."""

    __slots__ = ("pending_id", "pending_sender", "simulator", "steps")

    def __init__(self, simulator: AbstractRadioSimulator) -> None:
        self.simulator = simulator
        self.steps = 0
        self.pending_id: IntArray = np.empty(0, dtype=np.int64)
        self.pending_sender: IntArray = np.empty(0, dtype=np.int64)

    def hand_over(self, transmissions: Transmissions) -> None:
        """Note who sends what, in the order of numbers."""
        number = np.append(self.pending_id, transmissions.message_id)
        order = np.argsort(number, kind="stable")
        self.pending_id = number[order]
        self.pending_sender = np.append(self.pending_sender, transmissions.sender)[order]

    def places(self, number: IntArray, named: str) -> IntArray:
        """Where messages stand among those that are owed."""
        at = np.searchsorted(self.pending_id, number)
        known = at < self.pending_id.size
        known[known] = self.pending_id[at[known]] == number[known]
        if not known.all():
            raise ValueError(f"{named} must name messages on their way, got {int(number[~known][0])}")
        return at

    def settle(self, done: IntArray) -> None:
        """Forget the messages at these places: they are answered."""
        if np.unique(done).size != done.size:
            raise ValueError("a message must end or expire once")
        left: BoolArray = np.ones(self.pending_id.size, dtype=np.bool_)
        left[done] = False
        self.pending_id, self.pending_sender = self.pending_id[left], self.pending_sender[left]


@dataclass(frozen=True, slots=True)
class ExternalState:
    """An instant of an external radio, good until the radio goes on.

    Parameters
    ----------
    t_s
        Now [s].
    steps
        Intervals carried.
    busy_ratio
        Of every station, (V,).
    """

    t_s: float
    steps: int
    busy_ratio: FloatArray
    _: KW_ONLY
    course: _Course = field(repr=False, compare=False)


@dataclass(frozen=True, slots=True)
class AbstractExternalRadio(AbstractRadio[ExternalState]):
    """A radio that another simulator is.

    Parameters
    ----------
    max_power_dbm
        No transmission may exceed it [dBm].
    distance_bin_m, bins
        Width and number of the distance bins of `Receptions.outcomes`; lost frames are counted within them
        [m].

    Raises
    ------
    ValueError
        Where a width or number of bins is not positive.

    Notes
    -----
    Another simulator cannot go back, so `step` uses its state up as `carry` does; a state that is used again
    is refused. All antennas are those of vehicles. What the simulator says is checked before it is believed.

    Examples
    --------
    A simulator in which all hear all, with no delay but 1 ms:

    >>> class Ether(AbstractRadioSimulator):
    ...     def __init__(self, stations):
    ...         self.stations = stations
    ...
    ...     def carry(self, transmissions, position_m, until_t_s):
    ...         message, receiver = np.divmod(np.arange(transmissions.size * self.stations), self.stations)
    ...         other = receiver != transmissions.sender[message]
    ...         message, receiver = message[other], receiver[other]
    ...         return CarriedFrames(
    ...             transmissions.message_id[message],
    ...             receiver,
    ...             end_s=transmissions.ready_s[message] + 1e-3,
    ...             rssi_dbm=np.full(message.size, np.nan),
    ...             outcome=np.zeros(message.size, dtype=np.int64),
    ...             ended=transmissions.message_id,
    ...             expired=np.empty(0, dtype=np.int64),
    ...             busy_ratio=np.zeros(self.stations),
    ...         )
    >>> class EtherRadio(AbstractExternalRadio):
    ...     def start(self, stations, seed):
    ...         return Ether(stations)
    >>> radio = EtherRadio()
    >>> state = radio.init(3, np.random.default_rng(1))
    >>> one = Transmissions(
    ...     np.array([1]),
    ...     np.array([0.01]),
    ...     size_bytes=np.array([300]),
    ...     power_dbm=np.array([20.0]),
    ...     message_id=np.array([7]),
    ... )
    >>> heard, state = radio.step(state, one, np.array([[0.0, 0.0], [9.0, 0.0], [70.0, 0.0]]), 0.1)
    >>> heard.receiver.tolist(), heard.outcomes[:2, 0].tolist()
    ([0, 2], [1, 1])
    """

    _: KW_ONLY
    max_power_dbm: float = 23.0
    distance_bin_m: float = 50.0
    bins: int = 10

    def __post_init__(self) -> None:
        if not (np.isfinite(self.distance_bin_m) and self.distance_bin_m > 0.0 and self.bins >= 1):
            raise ValueError(
                f"distance_bin_m and bins must be positive, got {self.distance_bin_m} and {self.bins}"
            )

    @property
    def bin_m(self) -> float:
        """Width of the bins of distance of its outcomes [m]."""
        return self.distance_bin_m

    @property
    def reach_m(self) -> float:
        """Distance within which lost frames are counted [m]."""
        return self.distance_bin_m * self.bins

    @abc.abstractmethod
    def start(self, stations: int, seed: int) -> AbstractRadioSimulator:
        """Start the simulator, its clock at 0 and its channel silent.

        Parameters
        ----------
        stations
            Number V of stations; places come with every interval.
        seed
            Of all its random numbers, 1..2³¹ - 1.
        """

    def init(self, vehicles: int, rng: np.random.Generator) -> ExternalState:
        """State of a silent channel at time 0."""
        if vehicles < 1:
            raise ValueError(f"vehicles must be at least 1, got {vehicles}")
        seed = int(rng.integers(1, 2**31))
        return ExternalState(0.0, 0, np.zeros(vehicles), course=_Course(self.start(vehicles, seed)))

    def fit_antennas(self, state: ExternalState, gain_db: FloatArray) -> ExternalState:
        """The state as it is: antennas weaker than a vehicle's are refused."""
        if checked_gains(gain_db, state.busy_ratio.size).any():
            raise ValueError(f"{type(self).__name__} has no antennas weaker than a vehicle's")
        return state

    def step(
        self, state: ExternalState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, ExternalState]:
        """Carry one interval; the given state is used up.

        Raises
        ------
        ValueError
            Where the state was used before, the interval does not fit it, or the simulator says what cannot
            be.
        """
        vehicles, course = state.busy_ratio.size, state.course
        if course.steps != state.steps:
            raise ValueError(
                f"{type(self).__name__} has gone on from {state.t_s} s and cannot go back: use the last state"
            )
        transmissions.check(state.t_s, until_t_s, position_m, vehicles, self.max_power_dbm)
        course.steps += 1
        course.hand_over(transmissions)
        carried = course.simulator.carry(transmissions, position_m, until_t_s)
        try:
            receptions = self._receptions(carried, course, position_m, until_t_s)
        except ValueError as error:
            raise ValueError(f"{type(self).__name__} at {until_t_s} s: {error}") from error
        after = ExternalState(until_t_s, course.steps, carried.busy_ratio.astype(np.float64), course=course)
        return receptions, after

    def channel_busy_ratio(self, state: ExternalState) -> FloatArray:
        """Busy share of the last full measuring window, as the simulator says, 0..1, (V,)."""
        return state.busy_ratio.copy()

    def _receptions(
        self, carried: CarriedFrames, course: _Course, position_m: FloatArray, until_t_s: float
    ) -> Receptions:
        """What the simulator says, checked, in order of time, and counted by distance."""
        _check(carried, position_m.shape[0], until_t_s)
        at = course.places(carried.message_id, "message_id")
        ended = course.places(carried.ended, "ended")
        if not np.isin(at, ended).all():
            raise ValueError("rows must be those of messages in ended")
        sender = course.pending_sender[at]
        if (sender == carried.receiver).any():
            raise ValueError("no station receives its own message")
        if np.unique(at * position_m.shape[0] + carried.receiver).size != at.size:
            raise ValueError("each pair of message and receiver must have one row")
        course.settle(np.append(ended, course.places(carried.expired, "expired")))
        got = np.flatnonzero(carried.outcome == _RECEIVED)
        got = got[np.argsort(carried.end_s[got], kind="stable")]
        return Receptions(
            carried.message_id[got],
            sender[got],
            receiver=carried.receiver[got],
            t_s=carried.end_s[got],
            rssi_dbm=carried.rssi_dbm[got],
            outcomes=self._outcomes(carried, position_m[sender] - position_m[carried.receiver]),
            expired=carried.expired,
        )

    def _outcomes(self, carried: CarriedFrames, apart_m: FloatArray) -> IntArray:
        """Pairs within the bins by distance and outcome, (bins, len(OUTCOMES))."""
        distance_m = np.hypot(apart_m[:, 0], apart_m[:, 1])
        near = distance_m < self.reach_m
        counts: IntArray = np.zeros((self.bins, len(OUTCOMES)), dtype=np.int64)
        np.add.at(counts, ((distance_m[near] / self.bin_m).astype(np.int64), carried.outcome[near]), 1)
        return counts


def _check(carried: CarriedFrames, vehicles: int, until_t_s: float) -> None:
    """Refuse columns that do not fit each other, the fleet or the interval."""
    columns = ("message_id", "receiver", "end_s", "rssi_dbm", "outcome")
    sizes = {getattr(carried, name).shape for name in columns}
    if len(sizes) != 1 or len(carried.message_id.shape) != 1:
        raise ValueError(f"{', '.join(columns)} must have one length, got {sorted(sizes)}")
    if carried.busy_ratio.shape != (vehicles,):
        raise ValueError(f"busy_ratio must be ({vehicles},), got {carried.busy_ratio.shape}")
    if not ((carried.busy_ratio >= 0.0) & (carried.busy_ratio <= 1.0)).all():
        raise ValueError("busy_ratio must lie within 0..1")
    for name, most in (("receiver", vehicles - 1), ("outcome", len(OUTCOMES) - 1)):
        column = getattr(carried, name)
        if column.size and not (column.min() >= 0 and column.max() <= most):
            raise ValueError(f"{name} must lie within 0..{most}, got {column.min()}..{column.max()}")
    if not (np.isfinite(carried.end_s) & (carried.end_s <= until_t_s)).all():
        raise ValueError(f"end_s must be finite and not after {until_t_s} s")
