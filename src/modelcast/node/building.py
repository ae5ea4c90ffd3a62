"""A node made from its configuration and the seeds of its names: on the road, and again from a recording."""

from typing import TYPE_CHECKING

import numpy as np

from modelcast.apps.base import AbstractApplication
from modelcast.apps.registry import get_application
from modelcast.core.geodesy import Origin
from modelcast.core.kinds import PEOPLE, SIZES_M, Kind
from modelcast.messages.belonging import psid_of_kind
from modelcast.models.bank import Bank
from modelcast.models.profile import default_profile
from modelcast.node.config import NodeConfig, Roadside, Security
from modelcast.node.envelope import AbstractEnvelope, Unsecured
from modelcast.node.node import Node, Watch
from modelcast.node.pseudonyms import Pseudonyms
from modelcast.node.recording.record import AbstractRecord
from modelcast.node.relaying import Relaying
from modelcast.runtime.transport.base import AbstractTransport
from modelcast.station.banks import calibrations_of, profile_number_of
from modelcast.station.receiver.ears import Ears
from modelcast.station.relay import RelayRule
from modelcast.station.sender.sender import Sender
from modelcast.station.station import Station

if TYPE_CHECKING:
    from modelcast.node.credentials import Credentials

__all__ = ["applications_of", "credentials_of", "envelope_of", "node_of"]


def node_of(
    config: NodeConfig,
    sender: Sender,
    transport: AbstractTransport,
    envelope: AbstractEnvelope,
    *,
    origin: Origin,
    names_seed: int,
    station_seed: int,
    watch: Watch | None = None,
    record: AbstractRecord | None = None,
) -> Node:
    """The node that a configuration asks for.

    Parameters
    ----------
    config
        Its configuration.
    sender
        What it sends, and when.
    transport
        How frames leave and arrive.
    envelope
        What goes round messages.
    origin
        Of its plane.
    names_seed, station_seed
        Of temporary ids and of the station; on the road ones that nobody can guess.
    watch, record
        As in `Node`.
    """
    names = Pseudonyms(config.pseudonyms.least_s, config.pseudonyms.most_s, np.random.default_rng(names_seed))
    site, kind = config.roadside, config.station.speaks
    station = Station(
        sender,
        temporary_id=names.temporary_id,
        dt_s=config.sending.tick_s,
        origin=origin,
        seed=station_seed,
        ears=_ears_of_people(sender.bank, config.sending.tick_s) if kind in PEOPLE else None,
    )
    return Node(
        station,
        transport,
        envelope,
        applications=applications_of(config),
        size_m=SIZES_M[kind] if kind in PEOPLE else (config.vehicle.length_m, config.vehicle.width_m),
        kind=kind,
        pseudonyms=None if site.on else names,
        relaying=_relaying(site, config.sending.tick_s) if site.on and site.relay else None,
        watch=watch,
        record=record,
    )


def applications_of(config: NodeConfig) -> dict[str, AbstractApplication]:
    """What a node warns of, by name.

    Parameters
    ----------
    config
        Its configuration.
    """
    alone = config.station.speaks in PEOPLE
    asked = {name: get_application(name) for name in config.applications.names}
    return {name: one for name, one in asked.items() if one.of_people or not alone}


def _ears_of_people(own: Bank, dt_s: float) -> Ears:
    """How a person's device hears: it holds the shipped bank of vehicles, whom it warns of, and its own."""
    vehicles = default_profile().bank
    banks = (vehicles,) if profile_number_of(own) == profile_number_of(vehicles) else (vehicles, own)
    return Ears(banks, dt_s=dt_s, calibrations=tuple(calibrations_of(bank) for bank in banks))


def _relaying(site: Roadside, tick_s: float) -> Relaying:
    """What a unit repeats."""
    rule = RelayRule(rate_hz=site.relay_rate_hz, within_m=site.relay_within_m, max_age_s=site.relay_age_s)
    return Relaying(rule, tick_s)


def credentials_of(security: Security) -> "Credentials | None":
    """What a configuration says the node signs with, and whom it trusts; None where nothing is signed.

    Parameters
    ----------
    security
        Its table.

    Raises
    ------
    ConfigError, MissingExtraError
        Where credentials cannot be read, or the library for signatures is not installed.
    """
    if security.mode == "none":
        return None
    from modelcast.node.credentials import read_credentials  # noqa: PLC0415 - the extra is needed here

    return read_credentials(security.folder)


def envelope_of(
    credentials: "Credentials | None",
    security: Security,
    *,
    utc_at_zero_s: float,
    names_seed: int,
    kind: Kind = Kind.VEHICLE,
) -> AbstractEnvelope:
    """What goes round the messages of a node.

    Parameters
    ----------
    credentials
        What it signs with, and whom it trusts; None where nothing is signed.
    security
        Table of its configuration.
    utc_at_zero_s
        UTC at the clock's 0, since 1970 [s].
    names_seed
        As for `node_of`; it says which certificate is the first.
    kind
        Of the road user that speaks.
    """
    psid = psid_of_kind(kind)
    if credentials is None:
        return Unsecured(psid)
    from modelcast.node.signed import Signed  # noqa: PLC0415 - the extra is needed here

    return Signed(
        credentials.trusted,
        credentials.own,
        utc_at_zero_s=utc_at_zero_s,
        first=names_seed,
        psid=psid,
        required=security.required,
    )
