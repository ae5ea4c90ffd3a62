"""Roadside units of ``modelcast network``: where they stand, with which antennas, and what they relay."""

import math
from dataclasses import KW_ONLY, dataclass, replace
from typing import TYPE_CHECKING

from modelcast.core.exceptions import ConfigError

if TYPE_CHECKING:
    from modelcast.channel.propagation import Propagation
    from modelcast.runtime.fleet.roadside import Roadside

__all__ = ["CROSSINGS", "RoadsidePlan", "places_of"]

CROSSINGS = "crossings"
"""Word for one unit at every junction."""


@dataclass(frozen=True, slots=True)
class RoadsidePlan:
    """Units of all runs of one call, as plain values.

    Parameters
    ----------
    places_m
        East and north of each [m].
    height_m, gain_db, power_dbm
        Of their antennas.
    relay
        Rate [1/s], reach [m] and age [s] of what they repeat; None for nothing.
    """

    places_m: tuple[tuple[float, float], ...]
    _: KW_ONLY
    height_m: float
    gain_db: float
    power_dbm: float
    relay: tuple[float, float, float] | None = None

    def units(self) -> "Roadside":
        """The units, as a fleet has them beside it.

        Raises
        ------
        ValueError
            Where a value is out of its range.
        """
        import numpy as np

        from modelcast.runtime.fleet.roadside import Roadside
        from modelcast.station.relay import RelayRule

        rule = None
        if self.relay is not None:
            rate_hz, within_m, age_s = self.relay
            rule = RelayRule(rate_hz=rate_hz, within_m=within_m, max_age_s=age_s)
        return Roadside(np.array(self.places_m), rule, power_dbm=self.power_dbm)

    def raise_antennas(self, propagation: "Propagation") -> "Propagation":
        """The propagation, with these antennas.

        Parameters
        ----------
        propagation
            Whose path loss is of WINNER+ B1.

        Raises
        ------
        ValueError
            Where the height is not above 1 m.
        TypeError
            Where the path loss knows no heights.
        """
        from modelcast.channel.path_loss import WinnerB1
        from modelcast.channel.propagation import RaisedAntennas

        if not isinstance(propagation.path_loss, WinnerB1):
            raise TypeError("the path loss knows no height of antennas")
        path_loss = replace(propagation.path_loss, other_antenna_m=self.height_m)
        return replace(propagation, raised=RaisedAntennas(len(self.places_m), path_loss, self.gain_db))


def places_of(words: tuple[str, ...], *, scenario: str, blocks: int) -> tuple[tuple[float, float], ...]:
    """Places of units from the words of a user.

    Parameters
    ----------
    words
        ``EAST,NORTH`` each, or `CROSSINGS`.
    scenario, blocks
        As in `modelcast.cli.network_plan.NetworkPlan`.

    Raises
    ------
    ConfigError
        Where a word is neither, or the scenario has no crossings.

    Examples
    --------
    >>> places_of(("0,250", "10.5,-3"), scenario="highway", blocks=5)
    ((0.0, 250.0), (10.5, -3.0))
    """
    from modelcast.cli.network_traffic import BLOCK_M

    found: list[tuple[float, float]] = []
    for word in words:
        if word == CROSSINGS:
            if scenario not in {"grid", "crossing"}:
                raise ConfigError(
                    f"--roadside crossings goes with --scenario grid or crossing, got {scenario}: "
                    "give places, as 0,250"
                )
            found += [(BLOCK_M * i, BLOCK_M * j) for i in range(blocks) for j in range(blocks)]
            continue
        try:
            east_m, north_m = (float(part) for part in word.split(","))
        except ValueError:
            east_m = north_m = math.nan
        if not (math.isfinite(east_m) and math.isfinite(north_m)):
            raise ConfigError(f"--roadside must be crossings or EAST,NORTH in metres, as 0,250, got {word!r}")
        found.append((east_m, north_m))
    return tuple(found)
