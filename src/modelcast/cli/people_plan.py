"""People of ``modelcast network``: how their devices send, with which antennas, and whom they track."""

from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING, Literal

from modelcast.core.exceptions import ConfigError

if TYPE_CHECKING:
    from modelcast.runtime.fleet.people import People
    from modelcast.station.sender.sender import Sender

__all__ = ["PeoplePlan"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PeoplePlan:
    """Devices of all runs of one call, as plain values.

    Parameters
    ----------
    policy, keep_alive_s
        How they send; None for as vehicles [s].
    bank
        Sub-models of those who send models.
    power_dbm
        Most power [dBm].
    height_m, antenna_db
        Height of their antennas, and what these add to a vehicle's beside it [m], [dB].
    reach_m, keeps
        As in `modelcast.runtime.fleet.people.People`.
    """

    policy: str | None
    bank: str
    keep_alive_s: float | None
    power_dbm: float
    height_m: float
    antenna_db: float
    reach_m: float
    keeps: Literal["vehicles", "all", "nobody"]

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

    def check(self) -> None:
        """Refuse what cannot be, before anything runs.

        Raises
        ------
        ConfigError
            Where a value is out of its range.
        """
        from modelcast.cli.named_words import check_word
        from modelcast.station.sender.names import check_sender

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
