"""Cooperative awareness messages at the intervals that cars kept on roads, whatever a vehicle does itself.

`CooperativeAwareness` sends by the rules of the standard and a vehicle's own motion. `MeasuredCam` sends at
intervals drawn from a chain that was fitted to recorded messages: it loads the channel as those cars do, and
its intervals know nothing of where the vehicle of the simulation turns or brakes.
"""

from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from modelcast.core.arrays import FloatArray, owned
from modelcast.core.markov import MarkovChain
from modelcast.station.policy import dcc_kernels
from modelcast.station.policy import measured_cam_kernels as kernels
from modelcast.station.policy.base import (
    AbstractTransmitPolicy,
    Decisions,
    MessageKind,
    TransmitInputs,
    required,
)
from modelcast.station.policy.dcc import AdaptiveDcc, ReactiveDcc

__all__ = ["MeasuredCam", "MeasuredCamState", "measured_cam_intervals"]


def measured_cam_intervals() -> MarkovChain:
    """Intervals of Volkswagen's test cars on highways: ten states, 100 ms to 1 s.

    The first-order chain of intervals alone, fitted to recorded messages.

    References
    ----------
    R. Molina-Masegosa, M. Sepulcre, J. Gozalvez, F. Berens, V. Martinez, "Empirical models for the realistic
    generation of cooperative awareness messages in vehicular networks", IEEE Transactions on Vehicular
    Technology 2020, DOI 10.1109/TVT.2020.2979232; figures as in its published models.
    """
    return MarkovChain(
        (
            (0.0093458, 0.21495, 0.18692, 0.42056, 0.037383, 0.1028, 0.0093458, 0.018692, 0.0, 0.0),
            (0.014735, 0.62475, 0.088409, 0.24067, 0.0039293, 0.019646, 0.002947, 0.0039293, 0.00098232, 0.0),
            (0.0625, 0.21991, 0.45602, 0.18981, 0.013889, 0.046296, 0.0046296, 0.0023148, 0.0, 0.0046296),
            (0.021044, 0.1936, 0.066498, 0.59848, 0.023569, 0.091751, 0.0016835, 0.0025253, 0.0, 0.00084175),
            (0.33333, 0.074074, 0.074074, 0.27778, 0.12963, 0.092593, 0.0, 0.0, 0.0, 0.018519),
            (0.098361, 0.11475, 0.18033, 0.4918, 0.021858, 0.081967, 0.0054645, 0.0, 0.0054645, 0.0),
            (0.18182, 0.0, 0.81818, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            (0.0, 0.75, 0.0, 0.0, 0.0, 0.083333, 0.0, 0.16667, 0.0, 0.0),
            (0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0),
            (0.0, 0.0, 0.0, 0.0, 0.02, 0.04, 0.02, 0.0, 0.0, 0.92),
        )
    )


@dataclass(frozen=True, slots=True)
class MeasuredCamState:
    """State of B vehicles, as the columns that `measured_cam_kernels` and `dcc_kernels` name.

    Parameters
    ----------
    rows
        Of the chain, (B, 2).
    control
        Of congestion control, (B, 5).
    """

    rows: FloatArray
    control: FloatArray


@dataclass(frozen=True, slots=True)
class MeasuredCam(AbstractTransmitPolicy[MeasuredCamState]):
    """Messages at intervals that follow a Markov chain; congestion control makes them longer, never shorter.

    Parameters
    ----------
    chain
        Of intervals: its states are whole multiples of `step_s`, from one on.
    step_s
        T_GenCamMin, 100 ms [s].
    control
        As in `CooperativeAwareness`; None for no congestion control. What it asks is kept to the longest
        interval of the chain.

    Raises
    ------
    ValueError
        Where the step is not positive.

    Examples
    --------
    >>> round(MeasuredCam().mean_interval_s, 2)
    0.34
    """

    chain: MarkovChain = field(default_factory=measured_cam_intervals)
    _: KW_ONLY
    step_s: float = 0.1
    control: AdaptiveDcc | ReactiveDcc | None = field(default_factory=AdaptiveDcc)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.step_s) and self.step_s > 0.0):
            raise ValueError(f"step_s must be positive, got {self.step_s}")

    @property
    def intervals_s(self) -> FloatArray:
        """Intervals by state, (K,) [s]."""
        return self.step_s * np.arange(1.0, len(self.chain.steps) + 1.0)

    @property
    def mean_interval_s(self) -> float:
        """Mean interval in the long run, without congestion control [s]."""
        return float(self.chain.stationary @ self.intervals_s)

    @property
    def longest_silence_s(self) -> float:
        """The longest interval of the chain [s]."""
        return float(self.intervals_s[-1])

    def init(self, vehicles: int, sub_models: int) -> MeasuredCamState:  # noqa: ARG002 - any bank will do
        """Nothing sent, nothing measured."""
        rows = np.tile([-np.inf, -1.0], (vehicles, 1))
        if self.control is None:
            return MeasuredCamState(rows, np.zeros((vehicles, dcc_kernels.STATE_COLUMNS)))
        return MeasuredCamState(rows, self.control.rows(vehicles, np.zeros(vehicles)))

    def decide(
        self, state: MeasuredCamState, inputs: TransmitInputs, rng: np.random.Generator
    ) -> tuple[Decisions, MeasuredCamState]:
        """Send where the interval is over; one number is drawn a vehicle, whether it sends or not."""
        busy_ratio = airtime_s = np.zeros(inputs.t_s.size)
        code, constants = dcc_kernels.NONE, np.zeros(1)
        if self.control is not None:
            air = required(inputs.air, "air", "MeasuredCam")
            busy_ratio, airtime_s = air.channel_busy_ratio, air.airtime_s
            code, constants = self.control.code, self.control.constants()
        rows, control = state.rows.copy(), state.control.copy()
        sends = np.empty(rows.shape[0], dtype=np.bool_)
        kernels.step_each(
            rows,
            control,
            code,
            (owned(inputs.t_s), owned(busy_ratio), owned(airtime_s)),
            self.intervals_s,
            self.chain.up_to(),
            constants,
            owned(rng.random(rows.shape[0])),
            sends,
        )
        kind = np.where(sends, MessageKind.UPDATE, MessageKind.NOTHING).astype(np.int64)
        chosen = np.full(kind.size, -1, dtype=np.int64)
        return Decisions.at_once(kind, chosen, inputs.t_s), MeasuredCamState(rows, control)
