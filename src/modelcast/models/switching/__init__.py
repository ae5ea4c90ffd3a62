"""Switching models: linear modes of motion, and a hidden Markov chain that chooses among them.

`StochasticHybridSystem` serves both of the paper's predecessors: the stochastic hybrid system whose number of
modes is given (``shs``), and the one whose number was found by a sticky hierarchical Dirichlet process
(``hdp-hmm``). They differ in how `modelcast.study.training` finds their modes, not in how they are served.
"""

from modelcast.models.switching.hybrid_system import MOST_MODES, StochasticHybridSystem
from modelcast.models.switching.mode import LinearMode

__all__ = ["MOST_MODES", "LinearMode", "StochasticHybridSystem"]
