"""What each sub-model and each estimate of the velocity is, in a few words: for captions and tables."""

import re
from collections.abc import Iterable

__all__ = ["coasting", "sub_model_words", "velocity_words"]

_COASTING = {
    "cv": "at constant velocity",
    "stop-and-go": "by the stop-and-go switch, a steady pace or a short change of it",
    "ca": "with their acceleration too",
    "ctra": "with their acceleration and turn as well",
    "free": "with their acceleration and turn as well",
}
"""How a plain message is coasted, by the name of the sub-model."""

_SUB_MODELS = {
    "cv": "constant velocity",
    "ca": "constant acceleration",
    "ctrv": "constant speed and turn rate",
    "ctra": "constant acceleration and turn rate",
    "imm": "cv, ca, ctrv or ctra, whichever the last samples fit",
    "free": "constant acceleration and turn rate from a plain message, estimated from the window",
    "free-predictive": "as free, the values stated moved by a network",
    "free-context": "as free-predictive, the network knows the vehicle ahead and the road too",
    "learned": "as ctra, corrected by a network",
    "stop-and-go": "a steady pace, or a short change of it",
    "gp-anchored": "a Gaussian process through the last sample, the paper's",
    "gp-intercept": "a Gaussian process with a free constant",
    "gp-adaptive": "as gp-intercept, with the noise of the moment",
    "gp-linear": "a regression line of position on time",
    "gp-vehicle": "a trained Gaussian process along and across the course",
    "gp-derivative": "a trained Gaussian process of positions and velocities",
    "gp-trained": "a trained Gaussian process on east and north",
    "shs": "trained modes of acceleration and turning that switch",
    "hdp-hmm": "as shs, with as many modes as the data ask for",
}
_REGIME = re.compile(r"^gp-regime-\d+$")

_VELOCITY = {
    "reported": "reported speed and heading",
    "slope-2": "the last two positions",
    "quadratic-4": "a quadratic through the last four positions",
}


def coasting(names: Iterable[str]) -> str:
    """Return how plain messages are coasted, by sub-models of these names.

    Parameters
    ----------
    names
        Of the bank that coasts them.

    Examples
    --------
    >>> coasting(["cv"]), coasting(["kerb"])
    ('at constant velocity', 'by kerb')
    """
    own = list(names)
    if len(own) == 1 and own[0] in _COASTING:
        return _COASTING[own[0]]
    return f"by {' or '.join(own)}"


def sub_model_words(names: Iterable[str]) -> str:
    """Return what sub-models of these names are; those of other packages and expressions are left out.

    Parameters
    ----------
    names
        In the bank's order.

    Examples
    --------
    >>> sub_model_words(["cv", "chord", "gp-regime-2"])
    'cv: constant velocity; gp-regime-2: a trained Gaussian process of one driving regime'
    """
    told: list[str] = []
    for name in dict.fromkeys(names):
        words = _SUB_MODELS.get(name)
        if _REGIME.match(name):
            words = "a trained Gaussian process of one driving regime"
        told += [] if words is None else [f"{name}: {words}"]
    return "; ".join(told)


def velocity_words(name: str) -> str:
    """Return where an estimate of the velocity comes from.

    Parameters
    ----------
    name
        Of the estimator; one without words stands for itself.

    Examples
    --------
    >>> velocity_words("quadratic-4")
    'a quadratic through the last four positions'
    """
    return _VELOCITY.get(name, name)
