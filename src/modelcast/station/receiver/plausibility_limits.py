"""How far the statements of one remote may be from one another."""

from dataclasses import KW_ONLY, dataclass, fields

import numpy as np

from modelcast.station.receiver.plausibility_kernels import Limits

__all__ = ["DEFAULT_LIMITS", "PlausibilityLimits"]


@dataclass(frozen=True, slots=True)
class PlausibilityLimits:
    """How far a sender's statements may be from one another.

    None of these is a standard's. Where a source is named the number follows from it; the false alarms of all
    together on recorded trips are in ``docs/receiver.md``.

    Parameters
    ----------
    max_ahead_s
        Farthest a message may be dated ahead of its arrival [s]. Ours: GNSS clocks agree to milliseconds
        (vTimeAccuracy of SAE J2945/1 is 1 ms); the rest is for a receiver's own clock.
    max_age_s
        Oldest message on arrival [s]. Ours: well above channel access and queues, some tenths of a second.
    max_speed_mps
        No vehicle is faster [m/s]. Ours: cars limited to 250 km/h do 69.4 m/s.
    max_acceleration_mps2
        Largest acceleration in any direction [m/s²]. Physics: tyres on a dry road hold about one g.
    position_tolerance_m
        What the errors of two positions may add to the displacement [m]. Twice the 1.5 m that J2945/1 asks of
        a position in 68 % of cases, as commonly quoted; the standard's text was not at hand.
    speed_tolerance_mps
        How far a stated speed may be off for long [m/s]. Ours: about three times the 1 km/h that J2945/1 asks
        in 68 % of cases, as commonly quoted; the standard's text was not at hand.
    window_s
        How long stated velocities are added up before they are compared anew [s]. Ours: some steps of 10 Hz.
    stuck_after_s
        A speed that fails and has been the same for so long is called stuck [s]. Ours: real recorders hold a
        speed for up to a second.
    stuck_window_s
        The window goes on for so long while the speed is the same [s]. Ours.
    speed_step_mps
        Speeds closer than this are the same [m/s]: half a step of J2735 (0.02 m/s).

    Raises
    ------
    ValueError
        Where one is not positive and finite.
    """

    max_ahead_s: float = 0.1
    _: KW_ONLY
    max_age_s: float = 2.0
    max_speed_mps: float = 70.0
    max_acceleration_mps2: float = 10.0
    position_tolerance_m: float = 3.0
    speed_tolerance_mps: float = 0.8
    window_s: float = 1.0
    stuck_after_s: float = 2.0
    stuck_window_s: float = 10.0
    speed_step_mps: float = 0.01

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not 0 < value < np.inf:
                raise ValueError(f"{item.name} must be positive and finite, got {value}")

    @property
    def numbers(self) -> Limits:
        """All limits, as the compiled loop takes them."""
        return Limits(**{item.name: float(getattr(self, item.name)) for item in fields(self)})


DEFAULT_LIMITS = PlausibilityLimits()
"""Those of a receiver that is told no others."""
