"""What the page shows of one host at one time, built from what the host believes. Pure functions."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Final

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.kinds import Kind
from modelcast.station.receiver.local_dynamic_map import Beliefs
from modelcast.station.station import Station

__all__ = [
    "AHEAD_S",
    "NOBODY",
    "Counters",
    "Host",
    "Remotes",
    "Snapshot",
    "WarningShown",
    "ellipses",
    "remotes_of",
    "snapshot_of",
]

AHEAD_S = np.array([0.4, 0.8, 1.2, 1.6, 2.0])
"""How far ahead of the snapshot the points of a predicted path are [s]."""


@dataclass(frozen=True, slots=True)
class Host:
    """The vehicle whose map it is.

    Parameters
    ----------
    temporary_id
        As others know it.
    position_m
        East and north [m].
    heading_rad, speed_mps
        Heading clockwise from north; NaN where unknown [rad], [m/s].
    inputs
        What it knows its motion from, in words, as ``GNSS and CAN``.
    """

    temporary_id: int
    position_m: tuple[float, float]
    _: KW_ONLY
    heading_rad: float
    speed_mps: float
    inputs: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Remotes:
    """N remotes as columns, by rising id.

    Parameters
    ----------
    vehicle
        Temporary ids, (N,).
    position_m
        Where each is believed to be, east and north, (N, 2) [m].
    heading_rad, speed_mps
        NaN where unknown, (N,).
    semi_axes_m, angle_rad
        Of the ellipse of one standard deviation, the greater first, (N, 2) [m]; direction of the greater,
        anticlockwise from east, in (-π/2, π/2], (N,) [rad].
    ahead_s, path_m
        How much later, rising, (H,) [s]; where each is believed to be then, (N, H, 2) [m].
    names, model
        Names of sub-models, and which of them predicts each remote, (N,).
    age_s, silent_s
        Since the fit, and since the last message that renewed the track, (N,) [s].
    messages, loss_ratio, error_m
        Messages taken from each, share of its messages that were lost, distance from the truth; NaN where
        not known, (N,).
    kind
        Of road user, values of `modelcast.core.kinds.Kind`, (N,); None where nobody said.

    Raises
    ------
    ValueError
        Where shapes differ.
    """

    vehicle: IntArray
    position_m: FloatArray
    _: KW_ONLY
    heading_rad: FloatArray
    speed_mps: FloatArray
    semi_axes_m: FloatArray
    angle_rad: FloatArray
    ahead_s: FloatArray
    path_m: FloatArray
    names: tuple[str, ...]
    model: IntArray
    age_s: FloatArray
    silent_s: FloatArray
    messages: FloatArray
    loss_ratio: FloatArray
    error_m: FloatArray
    kind: IntArray | None = None

    def __post_init__(self) -> None:
        count = self.vehicle.size
        wanted: dict[str, tuple[int, ...]] = {"position_m": (count, 2), "semi_axes_m": (count, 2)}
        wanted["path_m"] = (count, self.ahead_s.size, 2)
        for name in (
            "heading_rad", "speed_mps", "angle_rad", "model", "age_s", "silent_s", "messages", "loss_ratio",
            "error_m",
        ):  # fmt: skip
            wanted[name] = (count,)
        if self.kind is not None and self.kind.shape != (count,):
            raise ValueError(f"kind must have shape {(count,)}, got {self.kind.shape}")
        for name, shape in wanted.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} must have shape {shape}, got {getattr(self, name).shape}")
        if count and not (self.model.min() >= 0 and self.model.max() < len(self.names)):
            raise ValueError(f"model must be from 0 to {len(self.names) - 1}, one of the names")


NOBODY: Final = Remotes(
    np.zeros(0, dtype=np.int64),
    np.zeros((0, 2)),
    heading_rad=np.zeros(0),
    speed_mps=np.zeros(0),
    semi_axes_m=np.zeros((0, 2)),
    angle_rad=np.zeros(0),
    ahead_s=AHEAD_S,
    path_m=np.zeros((0, AHEAD_S.size, 2)),
    names=("Part I",),
    model=np.zeros(0, dtype=np.int64),
    age_s=np.zeros(0),
    silent_s=np.zeros(0),
    messages=np.zeros(0),
    loss_ratio=np.zeros(0),
    error_m=np.zeros(0),
)
"""What a host knows of others before it hears any."""


@dataclass(frozen=True, slots=True)
class WarningShown:
    """What an application says of one remote.

    Parameters
    ----------
    level
        A value of `modelcast.apps.warnings.Level`, 1 for caution, 2 for warning.
    kind
        Which application, as ``fcw``.
    vehicle
        Temporary id of the remote.
    begun_s
        Since when it has been said without a break [s].
    """

    level: int
    kind: str
    vehicle: int
    begun_s: float


@dataclass(frozen=True, slots=True)
class Counters:
    """How much is said and heard now; NaN where not known.

    Parameters
    ----------
    sent_per_s, received_per_s
        Messages a second [1/s].
    sent_bytes_per_s, received_bytes_per_s
        Bytes of frames a second [B/s].
    loss_ratio
        Share of the remotes' messages that did not arrive.
    channel_busy_ratio
        As the radio measured it.
    rejected
        Messages refused so far, by reason.
    """

    sent_per_s: float = 0.0
    received_per_s: float = 0.0
    _: KW_ONLY
    sent_bytes_per_s: float = 0.0
    received_bytes_per_s: float = 0.0
    loss_ratio: float = np.nan
    channel_busy_ratio: float = np.nan
    rejected: Mapping[str, int] = field(default_factory=dict[str, int])


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """Everything shown at one time.

    Parameters
    ----------
    t_s
        The time [s].
    host
        None for a host that does not know where it is, or none.
    remotes
        What it believes of others.
    warnings
        The most urgent first.
    counters
        Messages and bytes.
    """

    t_s: float
    host: Host | None
    _: KW_ONLY
    remotes: Remotes
    warnings: tuple[WarningShown, ...] = ()
    counters: Counters = field(default_factory=Counters)


def ellipses(covariance_m2: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Semi-axes of ellipses of one standard deviation, and the direction of the greater.

    Parameters
    ----------
    covariance_m2
        Symmetric, (N, 2, 2) [m²].

    Returns
    -------
    tuple[FloatArray, FloatArray]
        Greater and smaller, (N, 2) [m]; anticlockwise from east, in (-π/2, π/2], (N,) [rad].

    Notes
    -----
    With a and c on the diagonal and b beside it the squares are (a + c)/2 ± hypot((a - c)/2, b), and the
    angle of the greater is atan2(2b, a - c)/2. A square below zero counts as zero.

    Examples
    --------
    >>> axes, angle = ellipses(np.array([[[4.0, 0.0], [0.0, 9.0]]]))
    >>> axes.tolist(), float(angle[0] / np.pi)
    ([[3.0, 2.0]], 0.5)
    """
    east, cross, north = covariance_m2[:, 0, 0], covariance_m2[:, 0, 1], covariance_m2[:, 1, 1]
    middle, half = 0.5 * (east + north), np.hypot(0.5 * (east - north), cross)
    squares = np.stack([middle + half, middle - half], axis=1)
    return np.sqrt(np.maximum(squares, 0.0)), 0.5 * np.arctan2(2.0 * cross, east - north)


def remotes_of(
    beliefs: Beliefs,
    path_m: FloatArray,
    t_s: float,
    *,
    model_names: Sequence[Sequence[str]],
    ahead_s: FloatArray = AHEAD_S,
    messages: Mapping[int, int] | None = None,
    loss_ratio: Mapping[int, float] | None = None,
    truth_m: Mapping[int, tuple[float, float]] | None = None,
    kinds: Mapping[int, int] | None = None,
) -> Remotes:
    """What is believed of N remotes, as columns of the page.

    Parameters
    ----------
    beliefs, path_m
        As `Station.believe` and `Station.paths` give them at one time.
    t_s
        That time [s].
    model_names
        As `Station.model_names` has them.
    ahead_s
        Of the path's points, (H,) [s].
    messages, loss_ratio, truth_m, kinds
        By temporary id, what is known of them; without kinds as heard, and who has none among them is a
        vehicle.
    """
    firsts = np.cumsum([0, *(len(names) for names in model_names)])
    vehicles: list[int] = beliefs.vehicle.tolist()
    true_m = np.array([(truth_m or {}).get(one, (np.nan, np.nan)) for one in vehicles]).reshape(-1, 2)
    semi_axes_m, angle_rad = ellipses(beliefs.covariance_m2)
    return Remotes(
        beliefs.vehicle,
        beliefs.position_m,
        heading_rad=beliefs.heading_rad,
        speed_mps=beliefs.speed_mps,
        semi_axes_m=semi_axes_m,
        angle_rad=angle_rad,
        ahead_s=ahead_s,
        path_m=path_m,
        names=("Part I", *(name for names in model_names[1:] for name in names)),
        model=np.where(beliefs.profile < 0, 0, firsts[beliefs.profile + 1] - firsts[1] + 1 + beliefs.in_use),
        age_s=beliefs.information_age_s,
        silent_s=t_s - beliefs.received_s,
        messages=_column(messages, vehicles),
        loss_ratio=_column(loss_ratio, vehicles),
        error_m=np.hypot(*(beliefs.position_m - true_m).T),
        kind=beliefs.kind
        if kinds is None
        else np.array([kinds.get(one, Kind.VEHICLE) for one in vehicles], dtype=np.int64),
    )


def snapshot_of(
    station: Station,
    t_s: float,
    host: Host | None,
    *,
    counters: Counters,
    warnings: Sequence[WarningShown] = (),
    messages: Mapping[int, int] | None = None,
    loss_ratio: Mapping[int, float] | None = None,
    truth_m: Mapping[int, tuple[float, float]] | None = None,
    kinds: Mapping[int, int] | None = None,
) -> Snapshot:
    """What the page shows of a station at one time; the station is only asked.

    Parameters
    ----------
    station
        The host.
    t_s
        Any time from its newest message on [s].
    host, counters, warnings
        As in `Snapshot`.
    messages, loss_ratio, truth_m, kinds
        As in `remotes_of`.
    """
    remotes = remotes_of(
        station.believe(t_s),
        station.paths(t_s, AHEAD_S),
        t_s,
        model_names=station.model_names,
        messages=messages,
        loss_ratio=loss_ratio,
        truth_m=truth_m,
        kinds=kinds,
    )
    urgent = tuple(sorted(warnings, key=lambda one: (-one.level, one.begun_s, one.vehicle)))
    return Snapshot(t_s, host, remotes=remotes, warnings=urgent, counters=counters)


def _column(known: Mapping[int, float] | None, vehicles: Sequence[int]) -> FloatArray:
    values = known or {}
    return np.array([values.get(one, np.nan) for one in vehicles], dtype=np.float64)
