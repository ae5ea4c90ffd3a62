"""How badly an air carries frames, as a value."""

import math
from dataclasses import KW_ONLY, dataclass, fields

__all__ = ["CLEAR", "Impairment"]


@dataclass(frozen=True, slots=True)
class Impairment:
    """What happens to frames between stations.

    Parameters
    ----------
    loss_ratio
        Share that is lost.
    burst_s
        Mean time in which all is lost at a stretch (Gilbert-Elliott, `modelcast.channel.erasure`); 0 for
        losses each by itself [s].
    copies
        How often each arrives.
    late_ratio, late_s
        Share that is held up, evenly by up to so long: later ones overtake it [s].
    altered_ratio
        Share in which one octet is another one.
    parted
        Stations that hear each other and nobody else, and are heard by nobody else; none where empty.
    again_s
        Every frame arrives once more after so long, as where somebody records and replays; 0 for never [s].

    Raises
    ------
    ValueError
        Where a share is not 0..1, a time negative, or there is no copy.

    Examples
    --------
    >>> Impairment(0.3, burst_s=1.0).copies
    1
    """

    loss_ratio: float = 0.0
    _: KW_ONLY
    burst_s: float = 0.0
    copies: int = 1
    late_ratio: float = 0.0
    late_s: float = 0.0
    altered_ratio: float = 0.0
    parted: frozenset[int] = frozenset()
    again_s: float = 0.0

    def __post_init__(self) -> None:
        for one in fields(self):
            value = getattr(self, one.name)
            if one.name.endswith("_ratio") and not 0.0 <= value <= 1.0:
                raise ValueError(f"{one.name} must lie in 0..1, got {value}")
            if one.name.endswith("_s") and not 0.0 <= value < math.inf:
                raise ValueError(f"{one.name} must be finite and not negative, got {value}")
        if self.copies < 1:
            raise ValueError(f"copies must be at least 1, got {self.copies}")


CLEAR = Impairment()
"""Everything arrives."""
