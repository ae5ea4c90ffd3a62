"""Inputs of the networks, cut from the samples of one trip."""

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray, owned
from modelcast.models.learned.features import FeatureMap
from modelcast.models.learned.learned_trajectory import feature_constants
from modelcast.study.training.cut_kernels import trip_features

__all__ = ["window_inputs"]


def window_inputs(
    samples: FloatArray, rows: IntArray, window: int, features: FeatureMap, dt_s: float
) -> FloatArray:
    """Inputs of the windows that end at some samples of a trip, (B, I).

    Parameters
    ----------
    samples
        Of the trip, (T, 7).
    rows
        Where windows end, (B,).
    window
        Samples of each window.
    features
        What is taken of a window.
    dt_s
        Sampling interval [s].

    Raises
    ------
    ValueError
        Where a window does not reach back as far as the features do.
    """
    out = np.empty((rows.size, features.inputs))
    short = trip_features(samples, owned(rows, np.int64), window, feature_constants(features, dt_s), out)
    if short >= 0:
        raise ValueError(f"the window of {window} samples that ends at sample {short} is too short")
    return out
