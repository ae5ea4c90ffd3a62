"""Options of roadside units beside a fleet."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from cyclopts import Parameter

from modelcast.cli.options import Words

if TYPE_CHECKING:
    from modelcast.cli.roadside_plan import RoadsidePlan

__all__ = ["RoadsideOptions"]


@Parameter(name="*")
@dataclass(frozen=True)
class RoadsideOptions:
    """Fixed stations that hear, keep the map, and may relay.

    Parameters
    ----------
    roadside
        Where units stand: EAST,NORTH in metres, several after one another; or crossings, one at every
        junction of grid and crossing. None where not given.
    roadside_height
        Height of their antennas over the road; above 1 m. Path loss by it is per link [m].
    roadside_gain
        What their antennas add to a vehicle's, as they hear and as they send [dB].
    roadside_power
        Transmit power of what they relay [dBm].
    relay
        Repeat unchanged what they heard, once, where no other unit did.
    relay_rate
        At most so many a second and unit [1/s].
    relay_within
        Only messages sent so near to the unit [m].
    relay_age
        Only messages younger than this [s].
    """

    roadside: Words = ()
    roadside_height: float = 6.0
    roadside_gain: float = 0.0
    roadside_power: float = 20.0
    relay: bool = False
    relay_rate: float = 200.0
    relay_within: float = 200.0
    relay_age: float = 0.3

    def plan(self, *, scenario: str, blocks: int) -> "RoadsidePlan | None":
        """What units there are; None for none.

        Parameters
        ----------
        scenario, blocks
            As in `modelcast.cli.network_plan.NetworkPlan`.

        Raises
        ------
        ConfigError
            Where a place cannot be read, the scenario has no crossings, or relays have no unit.
        """
        from modelcast.cli.roadside_plan import RoadsidePlan, places_of
        from modelcast.core.exceptions import ConfigError

        if not self.roadside:
            if self.relay:
                raise ConfigError("--relay needs units that relay: --roadside crossings, or EAST,NORTH")
            return None
        return RoadsidePlan(
            places_of(tuple(self.roadside), scenario=scenario, blocks=blocks),
            height_m=self.roadside_height,
            gain_db=self.roadside_gain,
            power_dbm=self.roadside_power,
            relay=(self.relay_rate, self.relay_within, self.relay_age) if self.relay else None,
        )
