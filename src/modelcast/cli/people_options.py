"""Options of the devices of people beside a fleet."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from cyclopts import Parameter

if TYPE_CHECKING:
    from modelcast.cli.people_plan import PeoplePlan

__all__ = ["PeopleOptions"]


@Parameter(name="*")
@dataclass(frozen=True)
class PeopleOptions:
    """What the devices of people do: phones, where nothing else is said.

    Parameters
    ----------
    people_policy
        Policy of people, as --policy; that of the vehicles where not given. Their thresholds are those of the
        vehicles.
    people_bank
        Sub-models of people whose policy sends models, as --bank: by default the shipped profile of people.
    people_keep_alive
        Longest silence of people whose errors call for messages [s]; --keep-alive where not given.
    people_power
        Most transmit power [dBm].
    people_height
        Height of their antennas, above 1 m; a vehicle's is 1.5 m. By WINNER+ B1 it counts as a gain, which
        holds beyond 20 m [m].
    people_gain
        What their antennas add to a vehicle's beside the height, as they hear and as they send, together not
        above 0 [dB].
    people_reach
        People and vehicles farther apart than this keep no track of one another, nor people of people [m].
    people_map
        Of whom people keep a map: vehicles, all, nobody.
    """

    people_policy: str | None = None
    people_bank: str = "people"
    people_keep_alive: float | None = None
    people_power: float = 20.0
    people_height: float = 1.2
    people_gain: float = -3.0
    people_reach: float = 150.0
    people_map: Literal["vehicles", "all", "nobody"] = "vehicles"

    def plan(self, *, there_are: bool) -> "PeoplePlan | None":
        """What people do; None for no people.

        Parameters
        ----------
        there_are
            Whether there are any.

        Raises
        ------
        ConfigError
            Where a value is out of its range, or options speak of people that are not there.
        """
        from modelcast.cli.people_plan import PeoplePlan
        from modelcast.core.exceptions import ConfigError

        if not there_are:
            if self != PeopleOptions():
                raise ConfigError(
                    "--people-... options need people: --pedestrians, --cyclists, their tracks, or --persons"
                )
            return None
        found = PeoplePlan(
            policy=self.people_policy,
            bank=self.people_bank,
            keep_alive_s=self.people_keep_alive,
            power_dbm=self.people_power,
            height_m=self.people_height,
            antenna_db=self.people_gain,
            reach_m=self.people_reach,
            keeps=self.people_map,
        )
        found.check()
        return found
