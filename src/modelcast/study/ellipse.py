"""A Kalman filter's uncertainty ellipse sent in place of a path: a rival of sub-models, for people.

The sender runs a filter of constant velocity over its positions. A message carries the filter's place and
velocity, and how sure it is of both: the ellipse of the place as ``posConfidenceEllipse`` of an ETSI VAM has
it (two semi-axes in centimetres and the orientation, 12 bits each, 36 together), and the spread of the
velocity (the VAM's confidences of speed and heading, 7 bits each). SAE J2735 has ``PositionalAccuracy`` in
every basic and personal safety message: semi-axes of one standard deviation in steps of 5 cm, an octet each,
and two octets of orientation. All of these stand in every such message, used or not, so that the rival's
messages are as long as anybody's. The receiver lets the ellipse move at the velocity and grow with its age.

References
----------
ETSI TS 103 300-3, VRU awareness service; ETSI TS 102 894-2, DE_SemiAxisLength; SAE J2735,
DF_PositionalAccuracy.
"""

from dataclasses import KW_ONLY, dataclass
from typing import Annotated, Literal

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.rules import Number, check_fields
from modelcast.study import ellipse_kernels as kernels
from modelcast.trips.trajectory import Trajectory

__all__ = ["AXIS_STEP_M", "EllipseFilter", "EllipseMessages", "Ellipses", "ellipse_messages"]

AXIS_STEP_M = 0.01
"""What one code of a semi-axis is worth (``SemiAxisLength``, 1 to 4093) [m]."""

_MOST_CODE = 4093
_CHI2_95 = -2.0 * np.log(0.05)
"""Square of the Mahalanobis distance that 95 % of two normal numbers lie within."""


@dataclass(frozen=True, slots=True)
class Ellipses:
    """What the filter of one trip holds at every sample.

    Parameters
    ----------
    position_m, velocity_mps
        Place and velocity, (T, 2).
    place_m2, velocity_m2ps2
        Their covariances, (T, 2, 2).
    """

    position_m: FloatArray
    velocity_mps: FloatArray
    place_m2: FloatArray
    velocity_m2ps2: FloatArray


@dataclass(frozen=True, slots=True)
class EllipseFilter:
    """A filter of constant velocity and white acceleration, more of it along the course than across.

    Parameters
    ----------
    along, across
        Roots of the spectral densities of the acceleration along the course and across it [m/s² over √Hz].
    noise_m
        Noise of a position, of an axis [m].
    prior_mps
        Spread of the first velocity, of an axis [m/s].

    Raises
    ------
    ValueError
        Where a number is out of its range.

    Notes
    -----
    Who stands has no course and takes the greater density on both axes.

    Examples
    --------
    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t_s = 0.1 * np.arange(100)
    >>> walk = build_trajectory("made/1", t_s, np.stack([1.4 * t_s, 0.0 * t_s], axis=1))
    >>> found = EllipseFilter().follow(walk)
    >>> found.velocity_mps[-1].round(2).tolist(), np.sqrt(np.diag(found.place_m2[-1])).round(3).tolist()
    ([1.4, 0.0], [0.024, 0.022])
    """

    along: Annotated[float, Number(1e-4, 100.0)] = 0.5
    across: Annotated[float, Number(1e-4, 100.0)] = 0.3
    _: KW_ONLY
    noise_m: Annotated[float, Number(1e-4, 10.0)] = 0.03
    prior_mps: Annotated[float, Number(1e-3, 100.0)] = 1.0

    def __post_init__(self) -> None:
        check_fields(self)

    def follow(self, trip: Trajectory) -> Ellipses:
        """Filter the positions of a trip; every gapless part begins anew.

        Parameters
        ----------
        trip
            What the sender sees.
        """
        count = len(trip)
        place, velocity = np.empty((count, 2)), np.empty((count, 2))
        place_m2, velocity_m2ps2 = np.empty((count, 2, 2)), np.empty((count, 2, 2))
        numbers = np.array([self.along, self.across, self.noise_m, self.prior_mps])
        seen = (trip.t_s, trip.position_m, trip.segments)
        kernels.follow(*seen, numbers, place, velocity, place_m2, velocity_m2ps2)
        return Ellipses(place, velocity, place_m2, velocity_m2ps2)


@dataclass(frozen=True, slots=True)
class EllipseMessages:
    """Messages of a sender of ellipses, on a channel without losses.

    Parameters
    ----------
    starts
        Samples at which it sent, (N,).
    error_m
        Distance of the person from the middle of what the receiver held before the sample, (T,); zero where a
        part begins.
    within
        Share of the samples at which the person was within that receiver's ellipse of 95 %.
    """

    starts: IntArray
    error_m: FloatArray
    within: float


def ellipse_messages(
    trip: Trajectory,
    threshold_m: float,
    *,
    model: EllipseFilter,
    rule: Literal["error", "ellipse"],
    held: Ellipses | None = None,
) -> EllipseMessages:
    """Messages of a trip whose sender follows what its receivers hold.

    Parameters
    ----------
    trip
        What the sender sees.
    threshold_m
        See ``rule`` [m].
    model
        The filter; receivers know its densities.
    rule
        When a message is due. ``error``: the place is the threshold away from the ellipse's middle, as for
        all other senders. ``ellipse``: the place leaves the ellipse of 95 %, or that ellipse's greater
        semi-axis reaches the threshold; so receivers always have an ellipse no larger than that, and the
        person in it.
    held
        What ``model.follow`` gave for the trip, where it was asked before.

    Raises
    ------
    ValueError
        Where the threshold is not positive.

    Examples
    --------
    Someone who walks straight on and then stands, told by error and by ellipse:

    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t_s = 0.1 * np.arange(200)
    >>> east = 1.4 * np.minimum(t_s, 10.0)
    >>> walk = build_trajectory("made/1", t_s, np.stack([east, 0.0 * east], axis=1))
    >>> model = EllipseFilter()
    >>> [ellipse_messages(walk, 0.5, model=model, rule=one).starts.size for one in ("error", "ellipse")]
    [3, 31]
    """
    if not (threshold_m > 0 and np.isfinite(threshold_m)):
        raise ValueError(f"threshold_m must be positive, got {threshold_m}")
    own = model.follow(trip) if held is None else held
    count = len(trip)
    sent, inside = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
    error_m = np.zeros(count)
    numbers = np.array([model.along, model.across, threshold_m, _CHI2_95])
    told = (own.position_m, own.velocity_mps, _told(own.place_m2), own.velocity_m2ps2)
    seen = (trip.t_s, trip.position_m, trip.segments)
    kernels.send(*seen, *told, numbers, rule == "ellipse", sent, error_m, inside)
    return EllipseMessages(np.flatnonzero(sent), error_m, float(inside.mean()) if count else 1.0)


def _told(place_m2: FloatArray) -> FloatArray:
    """Ellipses of places as messages state them: semi-axes rounded up to whole codes, (T, 2, 2) [m²]."""
    variance, axes = np.linalg.eigh(place_m2)
    codes = np.clip(np.ceil(np.sqrt(variance) / AXIS_STEP_M), 1, _MOST_CODE)
    return np.ascontiguousarray((axes * (codes * AXIS_STEP_M)[:, None, :] ** 2) @ axes.swapaxes(1, 2))
