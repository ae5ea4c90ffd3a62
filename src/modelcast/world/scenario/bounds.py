"""What the fields of every scenario must be."""

import numpy as np

__all__ = ["check_positive", "check_range", "vehicle_count"]


def check_positive(scenario: object, *names: str) -> None:
    """Refuse a scenario with a field that is not a positive, finite number.

    Parameters
    ----------
    scenario
        It has the fields.
    names
        Of the fields.

    Raises
    ------
    ValueError
        With name and value.
    """
    for name in names:
        value: float = getattr(scenario, name)
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} must be positive and finite, got {value}")


def check_range(scenario: object, name: str, least: float, most: float) -> None:
    """Refuse a scenario with a range that is empty or leaves its bounds.

    Parameters
    ----------
    scenario
        It has the field, a pair of numbers, low first.
    name
        Of the field.
    least, most
        What the numbers may be, both included.

    Raises
    ------
    ValueError
        With name, value and bounds.
    """
    low, high = getattr(scenario, name)
    if not least <= low <= high <= most:
        raise ValueError(f"{name} must be a range within {least}..{most}, low first, got ({low}, {high})")


def vehicle_count(density_per_km: float, length_m: float) -> int:
    """Number of vehicles that a density makes on a length.

    Parameters
    ----------
    density_per_km
        Vehicles a kilometre [1/km].
    length_m
        Length of all roads [m].

    Examples
    --------
    >>> vehicle_count(20.0, 1500.0)
    30
    """
    return round(density_per_km * length_m / 1000.0)
