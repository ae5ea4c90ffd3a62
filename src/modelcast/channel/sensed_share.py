"""The share of frames that a vehicle senses: those above a bound of power, over shadowing and fading."""

import numpy as np

from modelcast.channel.propagation import Propagation
from modelcast.core.arrays import FloatArray
from modelcast.core.scientific import scientific

__all__ = ["MARGIN_DB", "sensed_shares"]

MARGIN_DB = 30.0
"""Medians so far below the bound are never sensed, and so far above it always [dB]."""

_STEP_DB = 0.5
_NODES = 48


def sensed_shares(propagation: Propagation) -> FloatArray:
    """Shares of frames above a bound by how far their median power is above it, (2, 3, K).

    Of a line of sight and of none, in the three ranges of fading, at K evenly spaced margins from
    ``-MARGIN_DB`` to ``MARGIN_DB``.

    Parameters
    ----------
    propagation
        Its shadowing and fading count.

    Notes
    -----
    With shadowing of deviation s and Nakagami's m the share at a margin of x dB is the mean over a normal z
    of Q(m, m·10^(-(x + s·z)/10)), Q the regularised upper incomplete gamma function; the mean is by Gauss
    and Hermite. Without fading it is the normal law of x/s, and without both a step.

    Examples
    --------
    Rayleigh fading alone leaves exp(-1) at the bound:

    >>> from modelcast.channel.propagation import NakagamiFading
    >>> alone = Propagation(shadowing=None, fading=NakagamiFading((1.0, 1.0, 1.0)))
    >>> shares = sensed_shares(alone)
    >>> float(shares[0, 0, shares.shape[2] // 2].round(6))
    0.367879
    """
    margin_db = np.arange(-MARGIN_DB, MARGIN_DB + _STEP_DB / 2, _STEP_DB)
    shadowing, fading = propagation.shadowing, propagation.fading
    sigmas_db = (0.0, 0.0) if shadowing is None else (shadowing.los_db, shadowing.nlos_db)
    shares = np.empty((2, 3, margin_db.size))
    for sight, sigma_db in enumerate(sigmas_db):
        for near in range(3):
            if fading is not None:
                shares[sight, near] = _faded(margin_db, sigma_db, fading.shapes[near])
            elif sigma_db > 0:
                special = scientific("special", "shadowing")
                shares[sight, near] = special.ndtr(margin_db / sigma_db)
            else:
                shares[sight, near] = margin_db >= 0.0
    return shares


def _faded(margin_db: FloatArray, sigma_db: float, shape: float) -> FloatArray:
    """Shares at margins under both, (K,)."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(_NODES)
    needed = 10.0 ** (-0.1 * (margin_db[:, None] + sigma_db * nodes))
    special = scientific("special", "fading")
    above: FloatArray = np.asarray(special.gammaincc(shape, shape * needed), dtype=np.float64)
    return above @ (weights / weights.sum())
