"""The learned sub-model: a small network over the last two seconds corrects a turn with acceleration.

Only the sender runs the network. What it sends are a few coefficients of the correction against time, so that
a host needs neither the network nor the window.
"""

from modelcast.models.learned.features import FeatureMap
from modelcast.models.learned.learned_trajectory import LearnedTrajectory
from modelcast.models.learned.perceptron import Perceptron
from modelcast.models.learned.selector import Selector

__all__ = ["FeatureMap", "LearnedTrajectory", "Perceptron", "Selector"]
