"""Figures as people speak of them."""

__all__ = ["centimetres"]


def centimetres(value_m: float) -> str:
    """Return a threshold as it is spoken of.

    Parameters
    ----------
    value_m
        The threshold [m].

    Examples
    --------
    >>> centimetres(0.2)
    '20 cm'
    """
    return f"{100 * value_m:.4g} cm"
