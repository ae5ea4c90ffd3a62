"""One station: a vehicle, a person or a roadside unit that measures, sends, hears and believes."""

from collections.abc import Sequence

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.geodesy import Origin, geodetic_to_local
from modelcast.core.kinds import Kind
from modelcast.station.fleet import Fleet, Sending
from modelcast.station.receiver.deliveries import Deliveries
from modelcast.station.receiver.ears import Ears
from modelcast.station.receiver.local_dynamic_map import Beliefs
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.station.sensing.sensing import NOWHERE

__all__ = ["Station"]


class Station:
    """One road user; a fleet of one.

    Parameters
    ----------
    sender
        What it sends, and when: a name of `modelcast.station.sender.sender.SENDERS`, or a `Sender`.
    temporary_id
        By which others know it, 0 to 2^32 - 1.
    dt_s
        Time between measurements [s].
    origin
        Of the plane positions are on.
    seed, minute_s, ears
        As in `Fleet`.
    kind
        A vehicle, which speaks basic safety messages, or one of `modelcast.core.kinds.PEOPLE`, who speak
        personal ones; None for what the `Sender` says.

    Raises
    ------
    ValueError
        Where the kind has no message of its own.

    Examples
    --------
    Two cars; what one sends, the other hears:

    >>> front, back = Station("mbc", temporary_id=1), Station("mbc", temporary_id=2)
    >>> for step in range(40):
    ...     t_s = 0.1 * step
    ...     for message in front.sense(t_s, (15.0 * t_s, 0.0), speed_mps=15.0, heading_rad=np.pi / 2):
    ...         receipts = back.hear([message.octets], received_s=[message.send_s])
    ...     sent = back.sense(t_s, (15.0 * t_s - 30.0, 0.0), speed_mps=15.0, heading_rad=np.pi / 2)
    >>> around = back.believe(4.0)
    >>> around.vehicle.tolist(), around.position_m.round(1).tolist(), around.speed_mps.round(1).tolist()
    ([1], [[60.0, 0.0]], [15.0])
    """

    def __init__(
        self,
        sender: str | Sender = "mbc",
        *,
        temporary_id: int = 0,
        dt_s: float = 0.1,
        origin: Origin = NOWHERE,
        seed: int = 0,
        minute_s: float = 0.0,
        ears: Ears | None = None,
        kind: Kind | None = None,
    ) -> None:
        self.temporary_id = temporary_id
        named = named_sender(sender) if isinstance(sender, str) else sender
        own = named if kind is None else named.of_kind(kind)
        self._fleet = Fleet(own, slots=1, dt_s=dt_s, origin=origin, seed=seed, minute_s=minute_s, ears=ears)
        self._fleet.admit(temporary_id)

    def sense(
        self,
        t_s: float,
        position_m: tuple[float, float] | None = None,
        *,
        place_deg: tuple[float, float] | None = None,
        speed_mps: float | None = None,
        heading_rad: float | None = None,
        acceleration_mps2: float | None = None,
        yaw_rate_radps: float | None = None,
        channel_busy_ratio: float = 0.0,
        begins: bool = False,
    ) -> list[Sending]:
        """Take in one measurement, and return what is sent until the next.

        Parameters
        ----------
        t_s
            Its time, later than the last [s].
        position_m
            East and north [m].
        place_deg
            Latitude and longitude, instead [deg].
        speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps, channel_busy_ratio, begins
            As in `Fleet.sense`.

        Raises
        ------
        ValueError
            Where there is not exactly one position, or as for `Fleet.sense`.
        """
        if (position_m is None) == (place_deg is None):
            raise ValueError("give position_m or place_deg, one of the two")
        here = np.array([position_m if position_m is not None else (np.nan, np.nan)], dtype=np.float64)
        if place_deg is not None:
            here = geodetic_to_local(np.array([place_deg], dtype=np.float64), self._fleet.origin)
        return self._fleet.sense(
            t_s,
            np.array([self.temporary_id]),
            here,
            speed_mps=_one(speed_mps),
            heading_rad=_one(heading_rad),
            acceleration_mps2=_one(acceleration_mps2),
            yaw_rate_radps=_one(yaw_rate_radps),
            channel_busy_ratio=np.array([channel_busy_ratio]),
            begins=np.array([begins]),
        )

    def hear(self, octets: Sequence[bytes], *, received_s: Sequence[float] | FloatArray) -> IntArray:
        """Take in messages; returns a `modelcast.station.receiver.local_dynamic_map.Receipt` each, (K,).

        Parameters
        ----------
        octets, received_s
            As in `Fleet.hear`.
        """
        return self._fleet.hear(self.temporary_id, octets, received_s=received_s)

    def believe(self, t_s: float) -> Beliefs:
        """What it believes of all its remotes: its local dynamic map.

        Parameters
        ----------
        t_s
            Any time from the newest message on [s].
        """
        return self._fleet.believe(self.temporary_id, t_s)

    def paths(self, t_s: float, ahead_s: FloatArray) -> FloatArray:
        """Where it believes its remotes to be later, in the order of `believe`, (N, H, 2) [m].

        Parameters
        ----------
        t_s, ahead_s
            As in `Fleet.paths`.
        """
        return self._fleet.paths(self.temporary_id, t_s, ahead_s)

    def deliveries(self, remotes: IntArray, t_s: float) -> Deliveries:
        """How many of the messages of some remotes it has heard of late.

        Parameters
        ----------
        remotes, t_s
            As in `Fleet.deliveries`.
        """
        return self._fleet.deliveries(self.temporary_id, remotes, t_s)

    @property
    def model_names(self) -> tuple[tuple[str, ...], ...]:
        """Names of the sub-models that predict remotes, as in `LocalDynamicMap.model_names`."""
        return self._fleet.model_names

    def rename(self, temporary_id: int) -> None:
        """Take another temporary id, as vehicles do from time to time: its next message begins anew.

        Parameters
        ----------
        temporary_id
            The new one, 0 to 2^32 - 1.
        """
        self._fleet.rename(self.temporary_id, temporary_id)
        self.temporary_id = temporary_id


def _one(value: float | None) -> FloatArray | None:
    return None if value is None else np.array([value], dtype=np.float64)
