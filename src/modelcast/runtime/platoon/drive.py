"""The closed loop of platoons: frame, what followers know of it, what they ask for, next frame."""

from collections.abc import Callable, Iterator
from dataclasses import KW_ONLY, dataclass, field, replace

import numpy as np

from modelcast.apps.cruise.acc import Acc
from modelcast.apps.cruise.base import AbstractCruiseLaw, Following, Ranging, following
from modelcast.apps.cruise.fallback import desired
from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.runtime.platoon.knowledge import AbstractKnowledge, Told, carried_on, frame_motions
from modelcast.world.platoon.dynamics import PlatoonState, driven
from modelcast.world.platoon.leaders import BEGINS_S, AbstractLeader
from modelcast.world.platoon.platoons import Platoons
from modelcast.world.scenario.base import STEP_S, FleetFrame

__all__ = ["DriveSettings", "PlatoonTrace", "drive_platoons", "platoon_frames"]


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveSettings:
    """How platoons are driven.

    Parameters
    ----------
    duration_s
        Time driven [s].
    frame_s
        Between two frames, at which vehicles measure, speak and ask their maps [s].
    moments
        Steps between two frames, in which a law sees its own motion and its ranging sensor anew and carries
        on what it was told: 10 of 10 ms, as Plexe's laws are called.
    ranging
        Whether a ranging sensor shows gap and speed of the vehicle ahead, as in Plexe; else all is by radio.
    fallback
        What speaks where the law knows too little.
    settle_s
        So long nobody falls back: who knows too little keeps its speed [s].

    Raises
    ------
    ValueError
        Where a value is out of its range.
    """

    duration_s: float = 60.0
    frame_s: float = STEP_S
    moments: int = 10
    ranging: bool = True
    fallback: Acc = field(default_factory=Acc)
    settle_s: float = BEGINS_S

    def __post_init__(self) -> None:
        for name in ("duration_s", "frame_s"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if self.moments < 1:
            raise ValueError(f"moments must be at least 1, got {self.moments}")
        if not self.settle_s >= 0.0:
            raise ValueError(f"settle_s must not be negative, got {self.settle_s}")


@dataclass(frozen=True, slots=True, eq=False)
class PlatoonTrace:
    """What B platoons of N vehicles drove, frame by frame.

    Parameters
    ----------
    t_s
        (T,) [s].
    speed_mps, acceleration_mps2
        (T, B, N) [m/s], [m/s²].
    gap_m
        Before each follower; not above 0 where it has run into the vehicle ahead, (T, B, N - 1) [m].
    too_near_m
        Gap that the law wants at that speed less the gap, (T, B, N - 1) [m].
    fell_back
        Where the law knew too little, (T, B, N - 1).
    age_s
        Age of what was known of the vehicle ahead, not a number where nothing was, (T, B, N - 1) [s].
    """

    t_s: FloatArray
    speed_mps: FloatArray
    acceleration_mps2: FloatArray
    _: KW_ONLY
    gap_m: FloatArray
    too_near_m: FloatArray
    fell_back: BoolArray
    age_s: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Moment:
    """Platoons at a frame, who of their followers knew too little, and how old was what they knew."""

    state: PlatoonState
    fell_back: BoolArray
    age_s: FloatArray


def drive_platoons(
    platoons: Platoons,
    leader: AbstractLeader,
    law: AbstractCruiseLaw,
    knowledge: AbstractKnowledge,
    settings: DriveSettings | None = None,
    *,
    progress: Callable[[int], None] | None = None,
) -> PlatoonTrace:
    """Drive platoons that begin at the law's gap, and return what they drove.

    Parameters
    ----------
    platoons, leader, law
        Who follows, what the leaders drive, and by which law.
    knowledge
        Where followers have theirs from.
    settings
        None for the defaults.
    progress
        Called after every frame with the number of frames done.

    Examples
    --------
    >>> from modelcast.apps.cruise.path import PathCacc
    >>> from modelcast.runtime.platoon.knowledge import Perfect
    >>> from modelcast.world.platoon.leaders import Steady
    >>> two = Platoons(1, 2)
    >>> trace = drive_platoons(two, Steady(), PathCacc(), Perfect(two), DriveSettings(duration_s=2.0))
    >>> trace.t_s.size, trace.gap_m.min().round(9), trace.gap_m.max().round(9)
    (20, np.float64(5.0), np.float64(5.0))
    """
    chosen = DriveSettings() if settings is None else settings
    moments = list[_Moment]()
    for moment in _moments(platoons, leader, law, knowledge, chosen):
        moments.append(moment)
        if progress is not None:
            progress(len(moments))
    speed = np.array([one.state.speed_mps for one in moments])
    gap = np.array([platoons.gap_m(one.state) for one in moments])
    return PlatoonTrace(
        np.array([one.state.t_s for one in moments]),
        speed,
        np.array([one.state.acceleration_mps2 for one in moments]),
        gap_m=gap,
        too_near_m=law.gap_m(speed[:, :, 1:]) - gap,
        fell_back=np.array([one.fell_back for one in moments]),
        age_s=np.array([one.age_s for one in moments]),
    )


def platoon_frames(
    platoons: Platoons,
    leader: AbstractLeader,
    law: AbstractCruiseLaw,
    knowledge: AbstractKnowledge,
    settings: DriveSettings | None = None,
) -> Iterator[FleetFrame]:
    """Yield the frames of driven platoons, each after everybody has heard what the last one gave to say.

    Parameters
    ----------
    platoons, leader, law, knowledge, settings
        As for `drive_platoons`.
    """
    chosen = DriveSettings() if settings is None else settings
    for moment in _moments(platoons, leader, law, knowledge, chosen):
        yield platoons.frame(moment.state)


def _moments(
    platoons: Platoons,
    leader: AbstractLeader,
    law: AbstractCruiseLaw,
    knowledge: AbstractKnowledge,
    settings: DriveSettings,
) -> Iterator[_Moment]:
    shape = (platoons.count, platoons.vehicles - 1)
    frames = round(settings.duration_s / settings.frame_s)
    step_s = settings.frame_s / settings.moments
    times = np.arange(frames * settings.moments + 1, dtype=np.float64)
    times *= step_s
    speeds = leader.speed_mps(times)
    first_mps = float(speeds[0])
    state = platoons.init(law.gap_m(np.full(shape, first_mps)), first_mps)
    for number in range(frames):
        # A time that is no sum of roundings.
        state = replace(state, t_s=round(number * settings.frame_s, 9))
        frame = platoons.frame(state)
        told = knowledge.told(frame)
        knowledge.listen(frame)
        before, fell_back = state, np.zeros(shape, dtype=np.bool_)
        for moment in range(settings.moments):
            known_s = moment * step_s
            known = _known(platoons, state, told, known_s, ranging=settings.ranging)
            asked, lost = desired(law, known, step_s, fallback=settings.fallback)
            if state.t_s < settings.settle_s:
                asked = np.where(lost, 0.0, asked)
            asked, lost = asked.reshape(shape), lost.reshape(shape)
            fell_back |= lost
            reached_mps = float(speeds[number * settings.moments + moment + 1])
            state = driven(state, asked, reached_mps, step_s, platoons.drive)
        yield _Moment(before, fell_back, told.age_s.reshape(shape))


def _known(
    platoons: Platoons, state: PlatoonState, told: Told, since_s: float, *, ranging: bool
) -> Following:
    """What the followers know now: what they were told at the frame, carried on, and what they see."""
    own, _, _ = platoons.pairs
    seen = None
    if ranging:
        closing = state.speed_mps[:, 1:] - state.speed_mps[:, :-1]
        seen = Ranging(platoons.gap_m(state).ravel(), closing.ravel())
    return following(
        frame_motions(platoons.frame(state), own),
        carried_on(told.ahead, since_s),
        carried_on(told.leader, since_s),
        commanded_mps2=state.commanded_mps2[:, 1:].ravel(),
        ranging=seen,
    )
