"""Inputs of the networks: cut from the samples of one trip, and varied for each batch."""

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray, owned
from modelcast.models.learned.features import FeatureMap
from modelcast.models.learned.learned_kernels import CONTEXT_AT
from modelcast.models.learned.learned_trajectory import feature_constants
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.study.training.cut_kernels import trip_features

__all__ = ["varied", "window_inputs"]


def window_inputs(
    samples: FloatArray, rows: IntArray, window: int, features: FeatureMap, dt_s: float
) -> FloatArray:
    """Inputs of the windows that end at some samples of a trip, (B, I).

    Parameters
    ----------
    samples
        Of the trip, (T, 9), or (T, 22) with its context behind.
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
    constants = feature_constants(features, dt_s)
    if features.context and samples.shape[1] > SAMPLE_COLUMNS:
        constants[CONTEXT_AT] = SAMPLE_COLUMNS
    short = trip_features(samples, owned(rows, np.int64), window, constants, out)
    if short >= 0:
        raise ValueError(f"the window of {window} samples that ends at sample {short} is too short")
    return out


def varied(
    inputs: FloatArray, features: FeatureMap, resize: float, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Half the windows mirrored, each on a road somewhat larger or smaller.

    Parameters
    ----------
    inputs
        (B, I); they stay as they are.
    features
        The map they are of.
    resize
        Greatest logarithm of the factor by which a road is resized.
    rng
        What draws.

    Returns
    -------
    tuple
        The inputs (B, I); -1 for a window that was mirrored and 1 for the others, and the factor of its road,
        (B,) both.
    """
    mirrored = rng.random(len(inputs)) < 0.5
    size = np.exp(resize * rng.uniform(-1.0, 1.0, len(inputs)))
    out = np.where(mirrored[:, None], inputs * features.mirrors, inputs)
    out[:, : -features.fixed] *= size[:, None]
    return out, np.where(mirrored, -1.0, 1.0), size
