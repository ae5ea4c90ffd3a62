"""What model-based communication puts on the air, as values; the codec comes below, the policy above."""

from dataclasses import KW_ONLY, dataclass

from modelcast.core.arrays import FloatArray

__all__ = ["ModelUpdate", "SubModelIdentification"]


@dataclass(frozen=True, slots=True)
class ModelUpdate:
    """A vehicle's sub-models, all fitted at one instant, and the one in use.

    Parameters
    ----------
    vehicle
        Temporary id of the sender.
    sequence
        Counts the sender's model updates.
    t_s
        Instant of the fit [s].
    position_m
        East and north of the window's last sample, (2,) [m].
    in_use
        Index of the sub-model in use.
    parameters
        All sub-models' parameters in the bank's order, (P,).
    dt_s
        Sampling interval of the windows [s].
    """

    vehicle: int
    sequence: int
    t_s: float
    _: KW_ONLY
    position_m: FloatArray
    in_use: int
    parameters: FloatArray
    dt_s: float


@dataclass(frozen=True, slots=True)
class SubModelIdentification:
    """Another sub-model of the last update is in use from now on.

    Parameters
    ----------
    vehicle
        Temporary id of the sender.
    sequence
        The model update it speaks of.
    t_s
        Instant of the decision [s].
    in_use
        Index of the sub-model in use.
    """

    vehicle: int
    sequence: int
    t_s: float
    _: KW_ONLY
    in_use: int
