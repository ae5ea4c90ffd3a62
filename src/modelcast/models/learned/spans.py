"""Which learned sub-models of a bank look back too short a time at a sampling interval."""

from modelcast.models.bank import Bank
from modelcast.models.free import FreeMotion
from modelcast.models.learned.features import LAG_STEP_S, SHORTEST_SPAN
from modelcast.models.learned.learned_trajectory import LearnedTrajectory
from modelcast.models.wrapped import unwrapped

__all__ = ["short_at"]


def short_at(bank: Bank, dt_s: float) -> str:
    """What is to be said of learned members whose windows are too short; empty where there are none.

    Parameters
    ----------
    bank
        The bank, its members wrapped or not.
    dt_s
        Sampling interval [s].

    Examples
    --------
    >>> from modelcast.models.profile import default_profile
    >>> short_at(default_profile().bank, 0.1)
    ''
    >>> print(short_at(default_profile().bank, 0.02))  # doctest: +NORMALIZE_WHITESPACE
    free-predictive looks back 2 s, its window of 21 samples spans 0.4 s at 50 Hz: it corrects nothing and
    predicts as constant turn rate and acceleration (ctra)
    """
    for member in bank.members:
        inner = unwrapped(member)
        if isinstance(inner, LearnedTrajectory | FreeMotion):
            lags = inner.features.lags if isinstance(inner, FreeMotion) else inner.lags
            needed_s, spanned_s = lags * LAG_STEP_S, (inner.window - 1) * dt_s
            if spanned_s < needed_s * SHORTEST_SPAN:
                return (
                    f"{member.name} looks back {needed_s:.3g} s, its window of {inner.window} samples spans "
                    f"{spanned_s:.3g} s at {1.0 / dt_s:.3g} Hz: it corrects nothing and predicts as constant "
                    "turn rate and acceleration (ctra)"
                )
    return ""
