"""Training of both switching sub-models: their data, the two searches, and what a profile gets of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.chance import child_generator
from modelcast.models.profile import Profile
from modelcast.models.switching import LinearMode, StochasticHybridSystem
from modelcast.study.training.adding import with_added
from modelcast.study.training.switching.expectation import FitSettings, fit_modes
from modelcast.study.training.switching.sampler import SamplerSettings, sample_modes
from modelcast.study.training.switching.sequences import Sequences, sequences_of
from modelcast.trips.trajectory import Trajectory

__all__ = ["SWITCHING_NAMES", "SwitchingSettings", "TrainedSwitching", "add_switching", "train_switching"]

SWITCHING_NAMES = ("shs", "hdp-hmm")
"""The two: modes of a given number, and of a number found."""

_LARGEST = 1.0 - 1e-9

Told = Callable[[str, int, int], None]


@dataclass(frozen=True, slots=True)
class SwitchingSettings:
    """How both are trained.

    Parameters
    ----------
    fit
        Of ``shs``.
    sampler
        Of ``hdp-hmm``.
    """

    fit: FitSettings = field(default_factory=FitSettings)
    sampler: SamplerSettings = field(default_factory=SamplerSettings)


@dataclass(frozen=True, slots=True)
class TrainedSwitching:
    """What was found.

    Parameters
    ----------
    models
        The sub-models asked for, in the order of `SWITCHING_NAMES`.
    record
        What a profile says of how they came about, by name. Plain values.
    """

    models: tuple[StochasticHybridSystem, ...]
    record: dict[str, Any]


def train_switching(
    trips: Sequence[Trajectory],
    settings: SwitchingSettings | None = None,
    *,
    names: Sequence[str] = SWITCHING_NAMES,
    seed: int,
    progress: Told | None = None,
) -> TrainedSwitching:
    """Train switching sub-models on trips as they were recorded.

    Parameters
    ----------
    trips
        As read; those at the commonest sampling interval are used, which is the step of modes and chains.
    settings
        How.
    names
        Which, of `SWITCHING_NAMES`.
    seed
        Of all random numbers; each search has its own.
    progress
        Called with the name, what is done and all.

    Raises
    ------
    ValueError
        Where a name is another, or no car moves for a second at a time.
    """
    settings = SwitchingSettings() if settings is None else settings
    foreign = [name for name in names if name not in SWITCHING_NAMES]
    if foreign or not names:
        raise ValueError(f"names must be some of {', '.join(SWITCHING_NAMES)}, got {', '.join(names)}")
    data = sequences_of(trips)

    def told(name: str) -> Callable[[int, int], None]:
        def tell(done: int, to_do: int) -> None:
            if progress is not None:
                progress(name, done, to_do)

        return tell

    models: list[StochasticHybridSystem] = []
    record: dict[str, Any] = {}
    for name in (one for one in SWITCHING_NAMES if one in names):
        rng, common = child_generator(seed, name), _common(data)
        if name == "shs":
            fitted = fit_modes(data, settings.fit, rng=rng, progress=told(name))
            models.append(_system(name, fitted.chain, fitted.weights, fitted.covariance, data.step_s))
            record[name] = {
                **common,
                "rounds": len(fitted.score),
                "log_likelihood_a_step": round(fitted.log_likelihood / len(data), 6),
            }
        else:
            drawn = sample_modes(data, settings.sampler, rng=rng, progress=told(name))
            models.append(_system(name, drawn.chain, drawn.weights, drawn.covariance, data.step_s))
            record[name] = {
                **common,
                "rounds": len(drawn.score),
                "log_likelihood_a_step": round(drawn.log_likelihood / len(data), 6),
                "best_round": int(np.argmax(drawn.score)) + 1,
                "shares": [round(float(share), 4) for share in drawn.shares],
            }
    return TrainedSwitching(tuple(models), record)


def add_switching(
    profile: Profile,
    trips: Sequence[Trajectory],
    settings: SwitchingSettings | None = None,
    *,
    names: Sequence[str] = SWITCHING_NAMES,
    seed: int,
    progress: Told | None = None,
) -> Profile:
    """A profile with switching sub-models added; all else in it stays as it is, its identity too.

    Those of the same name that were added before are replaced. Trips that the profile was not trained on join
    its training trips.

    Parameters
    ----------
    profile
        Any profile.
    trips, settings, names, seed, progress
        As for `train_switching`.

    Raises
    ------
    ValueError
        As for `train_switching`, or where the profile was itself trained with a sub-model of the name.
    """
    found = train_switching(trips, settings, names=names, seed=seed, progress=progress)
    return with_added(profile, found.models, found.record, trips)


def _common(data: Sequences) -> dict[str, Any]:
    return {"steps": len(data), "step_s": data.step_s, "trips_of_another_step": list(data.left_out)}


def _system(
    name: str, chain: FloatArray, weights: FloatArray, covariance: FloatArray, step_s: float
) -> StochasticHybridSystem:
    """The sub-model of these modes; dynamics that would grow are held at the edge."""
    modes = tuple(_mode(_stable(w[:, :2]), w[:, 2], q) for w, q in zip(weights, covariance, strict=True))
    rows = tuple(tuple(float(chance) for chance in row) for row in chain)
    return StochasticHybridSystem(name, modes, rows, step_s=step_s)


def _stable(dynamics: FloatArray) -> FloatArray:
    largest = float(np.abs(np.linalg.eigvals(dynamics)).max())
    return dynamics / max(largest / _LARGEST, 1.0)


def _mode(dynamics: FloatArray, offset: FloatArray, covariance: FloatArray) -> LinearMode:
    (a, b), (c, d) = dynamics.tolist()
    (first, mixed), (_, second) = covariance.tolist()
    along, turn = offset.tolist()
    return LinearMode(((a, b), (c, d)), (along, turn), ((first, mixed), (mixed, second)))
