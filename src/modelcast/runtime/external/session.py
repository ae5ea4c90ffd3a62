"""A session: the stations of another simulator's vehicles, driven at its steps.

Beneath are the fleets that notebooks use and, beneath those, the compiled steps that evaluation and network
run: what a session sends is what is evaluated. A request is checked whole before anything is done, so one
that is refused has changed nothing.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, final

import numpy as np

from modelcast.apps.around import believed_motions, repeated
from modelcast.apps.base import AbstractApplication
from modelcast.apps.registry import get_application
from modelcast.apps.warnings import Level
from modelcast.channel.radio import ORDINARY
from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.exceptions import ConfigError
from modelcast.core.geodesy import Origin
from modelcast.core.kinds import PEOPLE, SIZES_M, Kind
from modelcast.models.bank import Bank
from modelcast.runtime.external.checking import MEASURED_BESIDE, Checked, checked
from modelcast.runtime.external.exchange import (
    MOST_APPLICATIONS,
    HostBeliefs,
    HostWarnings,
    Sent,
    SessionSettings,
    Step,
)
from modelcast.runtime.external.kept_messages import KeptMessages
from modelcast.runtime.external.refusal import FieldError
from modelcast.runtime.external.senders import MakeSender, sender_of
from modelcast.station.banks import calibrations_of, profile_number_of
from modelcast.station.fleet import Fleet, Sending
from modelcast.station.receiver.ears import Ears
from modelcast.station.receiver.local_dynamic_map import Beliefs
from modelcast.station.sender.sender import Sender

__all__ = ["MOST_ROWS", "Session"]

MOST_ROWS = 2**17
"""Most rows of beliefs or of warnings in one answer."""

_KEPT_S = 10.0
"""Maps refuse what is older on arrival."""

_AT_ONCE = 8192
"""Messages that are read at a time: bounds the memory that foreign octets take."""

_BELIEFS = (
    "vehicle", "position_m", "velocity_mps", "speed_mps", "heading_rad", "acceleration_mps2",
    "yaw_rate_radps", "covariance_m2", "information_age_s", "received_s", "kind", "length_m", "width_m",
)  # fmt: skip


@final
class Session:
    """Stations of vehicles, people and roadside units that another simulator moves.

    Parameters
    ----------
    settings
        How it begins.
    make
        Gives what stations of each kind send, and when.

    Raises
    ------
    FieldError
        Where a setting is not what it must be.

    Examples
    --------
    Two vehicles, and a radio that loses nothing:

    >>> session = Session(SessionSettings(2))
    >>> heard: dict = {}
    >>> for step in range(30):
    ...     east = np.array([15.0 * 0.1 * step, 12.0 * 0.1 * step])
    ...     sent = session.step(
    ...         Step(
    ...             0.1 * step,
    ...             np.array([3, 8]),
    ...             position_m=np.stack([east, np.zeros(2)], axis=1),
    ...             speed_mps=np.array([15.0, 12.0]),
    ...             heading_rad=np.full(2, np.pi / 2),
    ...             **heard,
    ...         )
    ...     )
    ...     heard = {
    ...         "receiver": 11 - sent.vehicle,
    ...         "received_s": sent.send_s,
    ...         "message": sent.message,
    ...     }
    >>> around = session.believe(np.array([3]), 3.0)
    >>> around.vehicle.tolist(), around.position_m.round(1).tolist()
    ([8], [[36.0, 0.0]])
    """

    def __init__(self, settings: SessionSettings, make: MakeSender = sender_of) -> None:
        self.settings = settings
        kinds = (Kind.VEHICLE, *PEOPLE) if settings.people_slots else (Kind.VEHICLE,)
        self._senders = {kind: make(settings, kind) for kind in kinds}
        self.origin = Origin(settings.latitude_deg, settings.longitude_deg, settings.altitude_m)
        """Where the plane of positions touches the Earth."""
        self._fleets: dict[Kind, Fleet] = {Kind.VEHICLE: self._fleet(Kind.VEHICLE)}
        self._kind_of: dict[int, Kind] = {}
        self._given: tuple[str, ...] | None = None
        self._last_s = -np.inf
        self._kept = KeptMessages(_KEPT_S)

    def _fleet(self, kind: Kind) -> Fleet:
        """Stations of one kind; each has random numbers of its own, and all hold the same banks."""
        settings, banks = self.settings, _banks(self._senders.values())
        return Fleet(
            self._senders[kind],
            slots=settings.people_slots if kind in PEOPLE else settings.slots,
            dt_s=settings.dt_s,
            origin=self.origin,
            seed=settings.seed + int(kind),
            minute_s=settings.minute_s,
            ears=Ears(
                banks,
                dt_s=settings.dt_s,
                calibrations=tuple(calibrations_of(bank) for bank in banks),
                capacity=settings.capacity,
            ),
            spread_s=settings.spread_s,
        )

    def step(self, step: Step) -> Sent:
        """Take in what was received since the last step and what stations measure now; say what they send.

        The order of the stations in the arrays makes no difference, nor does that of receptions, save of
        foreign messages that one host receives at the same instant.

        Parameters
        ----------
        step
            All stations at one time.

        Raises
        ------
        FieldError
            Where a field is not what it must be; nothing has changed then.
        """
        rows = checked(step, self.settings, before=self._kind_of, given=self._given, last_s=self._last_s)
        sender = self._senders[Kind.VEHICLE]
        if sender.motion is not None and len(rows.columns) < len(MEASURED_BESIDE) and rows.vehicle.size:
            raise FieldError(
                "columns",
                ", ".join(rows.columns) or "none",
                f"{', '.join(MEASURED_BESIDE)}: {sender.name} filters the motion",
            )
        self._kept.check(rows.message[~rows.is_foreign])
        for kind in PEOPLE:
            if kind not in self._fleets and (rows.kind == kind).any():
                self._fleets[kind] = self._fleet(kind)
        receipt = self._hear(rows)
        left = self._leave(rows)
        measured = rows.given is not None
        sent = [one for kind in self._fleets for one in self._sense(kind, rows)] if measured else []
        self._given, self._last_s = rows.given, rows.t_s
        return self._told(rows.t_s, sent, receipt, left)

    def believe(self, hosts: IntArray, t_s: float) -> HostBeliefs:
        """What hosts believe of all their remotes: their local dynamic maps.

        Parameters
        ----------
        hosts
            Temporary ids, each once, (H,).
        t_s
            Not before the newest step [s].

        Raises
        ------
        FieldError
            Where a host is not there or is named twice, the time is before the newest step or no number, or
            there would be more than `MOST_ROWS` rows.
        """
        if not (np.isfinite(t_s) and t_s >= self._last_s):
            raise FieldError("t_s", t_s, f"not before the newest step, {self._last_s!r}")
        found: list[Beliefs] = []
        held = 0
        for host in self._asked(hosts):
            found.append(self._fleet_of(host).believe(host, t_s))
            held = _rows(held + found[-1].vehicle.size, hosts)
        columns: dict[str, Any] = {
            name: np.concatenate([getattr(one, name) for one in found]) if found else _NOTHING[name]
            for name in _BELIEFS
        }
        return HostBeliefs(t_s, np.repeat(hosts, [one.vehicle.size for one in found]), **columns)

    def warnings(self, hosts: IntArray, applications: Sequence[str]) -> HostWarnings:
        """What safety applications say to hosts at the newest step.

        A host whose acceleration or yaw rate is not measured counts as one that has none.

        Parameters
        ----------
        hosts
            Temporary ids of vehicles and people, each once, (H,).
        applications
            Names, as ``fcw``, each once, at most `MOST_APPLICATIONS`.

        Raises
        ------
        FieldError
            Where a host is not there, is named twice or is a roadside unit, there is no such application or
            it is named twice, or there would be more than `MOST_ROWS` rows.
        """
        asked = _applications(applications)
        wanted = self._asked(hosts)
        for host in wanted:
            if self._kind_of[host] == Kind.ROADSIDE:
                raise FieldError("host", host, "a vehicle or a person: a roadside unit is not warned")
        found: list[tuple[IntArray, FloatArray]] = []
        held = 0
        for host in wanted:
            for one in self._warned(host, asked):
                found.append(one)
                held = _rows(held + one[0].shape[0], hosts)
        pairs = np.concatenate([one for one, _ in found]) if found else np.empty((0, 4), dtype=np.int64)
        values = np.concatenate([one for _, one in found]) if found else np.empty((0, 3))
        host, vehicle, application, level = np.ascontiguousarray(pairs.T)
        time_s, margin_m, certainty = np.ascontiguousarray(values.T)
        return HostWarnings(
            self._last_s,
            host,
            vehicle=vehicle,
            application=application,
            level=level,
            time_s=time_s,
            margin_m=margin_m,
            certainty=certainty,
        )

    def _warned(
        self, host: int, applications: Sequence[AbstractApplication]
    ) -> Iterator[tuple[IntArray, FloatArray]]:
        """Of one host and each application: who, which and how urgent, (W, 4); when, margin, (W, 3)."""
        fleet = self._fleets[self._kind_of[host]]
        around = fleet.believe(host, self._last_s)
        own, kind = np.nan_to_num(fleet.own_motion(host)).tolist(), self._kind_of[host]
        length_m, width_m = SIZES_M[kind]
        mine = repeated(
            (own[0], own[1]),
            around.vehicle.size,
            speed_mps=own[2],
            heading_rad=own[3],
            acceleration_mps2=own[4],
            yaw_rate_radps=own[5],
            length_m=length_m,
            width_m=width_m,
            kind=kind,
        )
        others = believed_motions(around)
        for number, application in enumerate(applications):
            said = application.assess(mine, others)
            at = np.flatnonzero(said.level > Level.NONE)
            who = np.stack(
                [np.full(at.size, host), around.vehicle[at], np.full(at.size, number), said.level[at]], axis=1
            )
            yield who, np.stack([said.time_s[at], said.margin_m[at], said.certainty[at]], axis=1)

    def _asked(self, hosts: IntArray) -> list[int]:
        """The hosts of a request, or say which of them cannot be asked."""
        if hosts.ndim != 1 or hosts.size > len(self._kind_of):
            here = f"at most the {len(self._kind_of)} stations of the newest step, each once"
            raise FieldError("host", f"shape {hosts.shape}", here)
        asked: list[int] = hosts.tolist()
        for host in asked:
            if host not in self._kind_of:
                raise FieldError("host", host, "a station of the newest step")
        _check_once("host", asked)
        return asked

    def _fleet_of(self, host: int) -> Fleet:
        return self._fleets[_fleet_kind(self._kind_of[host])]

    def _hear(self, rows: Checked) -> IntArray:
        """Let each host take in what it received, in order of time; the receipts as the rows were given."""
        order = np.lexsort((rows.message, rows.received_s, rows.receiver))
        receipt = np.empty(order.size, dtype=np.int64)
        apart = [order]
        if len(self._fleets) > 1:
            fleet_of = {one: _fleet_kind(kind) for one, kind in self._kind_of.items()}
            mine = np.array([fleet_of[one] for one in rows.receiver[order].tolist()], dtype=np.int64)
            apart = [order[mine == kind] for kind in self._fleets]
        for fleet, own in zip(self._fleets.values(), apart, strict=True):
            octets = self._kept.octets(rows.message, own, rows.foreign)
            for first in range(0, own.size, _AT_ONCE):
                part = own[first : first + _AT_ONCE]
                receipt[part] = fleet.hear_each(
                    rows.receiver[part],
                    octets[first : first + _AT_ONCE],
                    received_s=rows.received_s[part],
                )
        return receipt

    def _leave(self, rows: Checked) -> IntArray:
        """Who was there and is no more; roadside units leave their fleet, and new ones enter it."""
        left = sorted(self._kind_of.keys() - set(rows.vehicle.tolist()))
        vehicles = self._fleets[Kind.VEHICLE]
        for one in left:
            if self._kind_of.pop(one) == Kind.ROADSIDE:
                vehicles.dismiss(one)
        for one, kind in zip(rows.vehicle.tolist(), rows.kind.tolist(), strict=True):
            if one not in self._kind_of:
                self._kind_of[one] = Kind(kind)
                if kind == Kind.ROADSIDE:
                    vehicles.admit(one)
        return np.array(left, dtype=np.int64)

    def _sense(self, kind: Kind, rows: Checked) -> list[Sending]:
        """What the stations of one kind send."""
        mine: BoolArray = rows.kind == kind
        return self._fleets[kind].sense(
            rows.t_s,
            rows.vehicle[mine],
            rows.position_m[mine],
            **{name: column[mine] for name, column in rows.columns.items()},
            channel_busy_ratio=rows.busy_ratio[mine],
            begins=rows.begins[mine],
        )

    def _told(self, t_s: float, sent: list[Sending], receipt: IntArray, left: IntArray) -> Sent:
        """Give messages their numbers, in order of time and then of sender."""
        sent.sort(key=lambda one: (one.send_s, one.vehicle))
        first = self._kept.add(t_s, (one.octets for one in sent))

        def whole(name: str) -> IntArray:
            return np.array([getattr(one, name) for one in sent], dtype=np.int64)

        def real(name: str) -> FloatArray:
            return np.array([getattr(one, name) for one in sent], dtype=np.float64)

        return Sent(
            t_s,
            np.arange(first, first + len(sent)),
            vehicle=whole("vehicle"),
            send_s=real("send_s"),
            frame_bytes=whole("frame_bytes"),
            power_dbm=real("power_dbm"),
            priority=np.full(len(sent), ORDINARY),
            next_s=real("next_s"),
            grant=whole("grant"),
            kind=whole("kind"),
            length=np.array([len(one.octets) for one in sent], dtype=np.int64),
            octets=b"".join(one.octets for one in sent),
            receipt=receipt,
            left=left,
        )


def _banks(senders: Iterable[Sender]) -> tuple[Bank, ...]:
    """What stations must hold to understand all of these; banks of one number on the air count once."""
    found: dict[int, Bank] = {}
    for sender in senders:
        found.setdefault(profile_number_of(sender.bank), sender.bank)
    return tuple(found.values())


def _fleet_kind(kind: Kind) -> Kind:
    """Which fleet stations of a kind are in: roadside units hear as vehicles do."""
    return Kind.VEHICLE if kind == Kind.ROADSIDE else kind


def _rows(held: int, hosts: IntArray) -> int:
    """So many rows, where an answer has room for them."""
    if held > MOST_ROWS:
        raise FieldError("host", f"{hosts.size} hosts", f"fewer: an answer holds {MOST_ROWS} rows")
    return held


def _check_once(field: str, named: Sequence[int] | Sequence[str]) -> None:
    """Refuse what is named twice."""
    seen = set[int | str]()
    for one in named:
        if one in seen:
            raise FieldError(field, one, "there once, not twice")
        seen.add(one)


def _applications(names: Sequence[str]) -> list[AbstractApplication]:
    """The applications of a request, or say which of them cannot be asked."""
    if len(names) > MOST_APPLICATIONS:
        raise FieldError("applications", f"{len(names)} names", f"at most {MOST_APPLICATIONS}")
    _check_once("applications", names)
    return [_application(name) for name in names]


def _application(name: str) -> AbstractApplication:
    try:
        return get_application(name)
    except ConfigError as error:
        raise FieldError("application", name, f"a safety application ({error})") from error


_SHAPES = {"position_m": (0, 2), "velocity_mps": (0, 2), "covariance_m2": (0, 2, 2)}
_NOTHING = {
    name: np.empty(_SHAPES.get(name, (0,)), dtype=np.int64 if name in {"vehicle", "kind"} else np.float64)
    for name in _BELIEFS
}
