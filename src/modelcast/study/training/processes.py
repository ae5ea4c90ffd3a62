"""Training of all Gaussian processes of a profile: by name, and one for each driving regime."""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass

from modelcast.core.chance import child_generator
from modelcast.models.base import AbstractSubModel
from modelcast.models.gp import GaussianProcess, VehicleProcess, derivative_process, vehicle_process
from modelcast.models.point_kernels import POSITION_NOISE
from modelcast.models.regimes import Regimes
from modelcast.study.training.families import FixedFamily, VehicleFamily
from modelcast.study.training.hyperparameters import TrainedPair, train_hyperparameters
from modelcast.study.training.regimes import train_regimes
from modelcast.study.training.views import SenderView, played_trips, view_trips
from modelcast.study.training.windows import TrainingWindows, at_commonest_interval, training_windows
from modelcast.trips.trajectory import Trajectory

__all__ = ["ProcessSettings", "TrainedProcesses", "train_processes"]

_VIEWS = (SenderView("recorded"), SenderView("motion", 0.01), SenderView("motion", 0.05))

_FIXED = FixedFamily(GaussianProcess(form="intercept", label="gp-trained"))
"""It has one noise for all windows, so it is trained on clean ones."""

_CLEAN_M = 0.005
_FEWEST_CLEAN = 100

_REGIME = "gp-regime"


@dataclass(frozen=True, slots=True)
class ProcessSettings:
    """How Gaussian processes are trained.

    Parameters
    ----------
    windows
        Windows that hyper-parameters are searched on.
    evaluations
        Of the objective, at most, in each search.
    regimes
        How many driving regimes get a process of their own, 2 or more; 0 for none.
    regime_evaluations
        Of the objective, at most, in each search of a regime.

    Raises
    ------
    ValueError
        Where a number is out of its range.
    """

    windows: int = 2000
    evaluations: int = 100
    _: KW_ONLY
    regimes: int = 3
    regime_evaluations: int = 40

    def __post_init__(self) -> None:
        for name in ("windows", "evaluations", "regime_evaluations"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if self.regimes < 0 or self.regimes == 1:
            raise ValueError(f"regimes must be 0 (none) or at least 2, got {self.regimes}")


@dataclass(frozen=True, slots=True)
class TrainedProcesses:
    """What the searches found.

    Parameters
    ----------
    candidates
        ``gp-vehicle`` and ``gp-derivative``, which serve at any noise.
    fixed
        ``gp-trained``, for clean positions.
    regimes
        Driving regimes with a process each; None where none were asked for.
    pairs
        Both searches of every process, by its name.
    """

    candidates: tuple[AbstractSubModel, ...]
    fixed: AbstractSubModel
    _: KW_ONLY
    regimes: Regimes | None
    pairs: dict[str, TrainedPair]


def train_processes(
    trips: Sequence[Trajectory],
    settings: ProcessSettings,
    *,
    seed: int,
    progress: Callable[[str, int, int], None] | None = None,
) -> TrainedProcesses:
    """Search the hyper-parameters of all processes on windows drawn from several views of the trips.

    Parameters
    ----------
    trips
        As read; those at the commonest sampling interval are used.
    settings
        How.
    seed
        Of all random numbers.
    progress
        Called with a process's name, evaluations done and all.

    Raises
    ------
    ValueError
        Where the trips are too short, or form fewer regimes than asked for.
    """

    def told(name: str) -> Callable[[int, int], None]:
        def tell(done: int, to_do: int) -> None:
            if progress is not None:
                progress(name, done, to_do)

        return tell

    def search(family: VehicleFamily | FixedFamily, cut: TrainingWindows) -> TrainedPair:
        name = family.model.name
        return train_hyperparameters(cut, family, evaluations=settings.evaluations, progress=told(name))

    windows = _windows(trips, settings.windows, seed)
    along = search(VehicleFamily(vehicle_process()), windows)
    derivative = search(VehicleFamily(derivative_process()), windows)
    fixed = search(_FIXED, _clean(windows))
    pairs = {pair.better.model.name: pair for pair in (along, derivative, fixed)}
    regimes: Regimes | None = None
    if settings.regimes:
        found = train_regimes(
            windows,
            _from_common(derivative),
            settings.regimes,
            label=_REGIME,
            rng=child_generator(seed, "regimes"),
            evaluations=settings.regime_evaluations,
            progress=told(f"{_REGIME}s"),
        )
        regimes = found.regimes
        pairs |= {pair.better.model.name: pair for pair in found.pairs}
    return TrainedProcesses(
        (along.better.model, derivative.better.model), fixed.better.model, regimes=regimes, pairs=pairs
    )


def _windows(trips: Sequence[Trajectory], count: int, seed: int) -> TrainingWindows:
    """Windows of all views, of the trips at the commonest sampling interval."""
    _, chosen = at_commonest_interval(trips)
    played = played_trips(chosen)
    seen = [one.seen for view in _VIEWS for one in view_trips(played, view, seed=seed)]
    return training_windows(
        seen,
        samples=vehicle_process().window,
        longest_s=5.0,
        count=count,
        rng=child_generator(seed, "process windows"),
    )


def _clean(windows: TrainingWindows) -> TrainingWindows:
    """The windows without noise to speak of; all where there are few."""
    clean = windows.samples[:, -1, POSITION_NOISE] < _CLEAN_M
    return windows.select(clean) if clean.sum() >= _FEWEST_CLEAN else windows


def _from_common(pair: TrainedPair) -> VehicleFamily:
    """The family whose search starts at what all regimes share."""
    model = pair.better.model
    if not isinstance(model, VehicleProcess):
        raise TypeError(f"{model.name} is no process in the vehicle's frame")
    return VehicleFamily(model)
