"""People of ``modelcast network``: how their devices send, with which antennas, and whom they track."""

from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from modelcast.core.exceptions import ConfigError

if TYPE_CHECKING:
    from modelcast.runtime.fleet.people import People
    from modelcast.station.sender.sender import Sender

__all__ = ["PeoplePlan"]


@Parameter(name="*")
@dataclass(frozen=True, slots=True, kw_only=True)
class PeoplePlan:
    """What the devices of people do: phones, where nothing else is said.

    Parameters
    ----------
    policy
        Policy of people, as --policy; that of the vehicles where not given. Their thresholds are those of the
        vehicles.
    bank
        Sub-models of people whose policy sends models, as --bank: by default the shipped profile of people.
    keep_alive_s
        Longest silence of people whose errors call for messages [s]; --keep-alive where not given.
    power_dbm
        Most transmit power [dBm].
    height_m
        Height of their antennas, above 1 m; a vehicle's is 1.5 m. By WINNER+ B1 it counts as a gain, which
        holds beyond 20 m [m].
    antenna_db
        What their antennas add to a vehicle's beside the height, as they hear and as they send, together not
        above 0 [dB].
    reach_m
        People and vehicles farther apart than this keep no track of one another, nor people of people [m].
    keeps
        Of whom people keep a map: vehicles, all, nobody.
    """

    policy: Annotated[str | None, Parameter(name="--people-policy")] = None
    bank: Annotated[str, Parameter(name="--people-bank")] = "people"
    keep_alive_s: Annotated[float | None, Parameter(name="--people-keep-alive")] = None
    power_dbm: Annotated[float, Parameter(name="--people-power")] = 20.0
    height_m: Annotated[float, Parameter(name="--people-height")] = 1.2
    antenna_db: Annotated[float, Parameter(name="--people-gain")] = -3.0
    reach_m: Annotated[float, Parameter(name="--people-reach")] = 150.0
    keeps: Annotated[Literal["vehicles", "all", "nobody"], Parameter(name="--people-map")] = "vehicles"

    @property
    def gain_db(self) -> float:
        """What their antennas add to a vehicle's, the height among it [dB].

        Raises
        ------
        ConfigError
            Where the height is not above 1 m.
        """
        from modelcast.channel.path_loss import WinnerB1

        if not 1.0 < self.height_m < inf:
            raise ConfigError(f"--people-height must be above 1 m, got {self.height_m}")
        return self.antenna_db + WinnerB1().height_gain_db(self.height_m)

    def checked(self, *, there_are: bool) -> "PeoplePlan | None":
        """The plan, before anything runs; None for no people.

        Parameters
        ----------
        there_are
            Whether there are any.

        Raises
        ------
        ConfigError
            Where a value is out of its range, or options speak of people that are not there.
        """
        from modelcast.cli.named_words import check_word
        from modelcast.station.sender.names import check_sender

        if not there_are:
            if self != PeoplePlan():
                raise ConfigError(
                    "--people-... options need people: --pedestrians, --cyclists, their tracks, or --persons"
                )
            return None
        if self.policy is not None:
            check_word("--people-policy", check_sender, self.policy)
        if not (isfinite(self.gain_db) and self.gain_db <= 0.0):
            raise ConfigError(
                "--people-gain and the gain of --people-height must together not be above 0 dB, a vehicle's "
                f"antenna, got {self.gain_db:.1f} dB"
            )
        if not -inf < self.power_dbm <= _MOST_DBM:
            raise ConfigError(f"--people-power must be at most {_MOST_DBM:g} dBm, got {self.power_dbm}")
        if self.keep_alive_s is not None and not self.keep_alive_s > 0.0:
            raise ConfigError(f"--people-keep-alive must be positive, got {self.keep_alive_s}")
        if not self.reach_m > 0.0:
            raise ConfigError(f"--people-reach must be positive, got {self.reach_m}")
        return self

    def devices(self, sender: "Sender") -> "People":
        """The devices of a run.

        Parameters
        ----------
        sender
            What they send, at any power.
        """
        from modelcast.runtime.fleet.people import People

        return People(
            sender.at_power(self.power_dbm), gain_db=self.gain_db, keeps=self.keeps, reach_m=self.reach_m
        )


_MOST_DBM = 23.0
"""Of both radios [dBm]."""
