"""Training of switching models: modes of a given number by climbing a likelihood, or found by a sampler.

`fit_modes` climbs the likelihood of a stochastic hybrid system with so many modes; `sample_modes` draws modes
of a sticky hierarchical Dirichlet process and keeps what the best draw used. Both take `Sequences`, and are
called by `train_switching`.
"""

from modelcast.study.training.switching.expectation import FitSettings, fit_modes
from modelcast.study.training.switching.sampler import SamplerSettings, sample_modes
from modelcast.study.training.switching.sequences import Sequences, sequences_of
from modelcast.study.training.switching.training import (
    SWITCHING_NAMES,
    SwitchingSettings,
    TrainedSwitching,
    add_switching,
    train_switching,
)

__all__ = [
    "SWITCHING_NAMES",
    "FitSettings",
    "SamplerSettings",
    "Sequences",
    "SwitchingSettings",
    "TrainedSwitching",
    "add_switching",
    "fit_modes",
    "sample_modes",
    "sequences_of",
    "train_switching",
]
