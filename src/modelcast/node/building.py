"""A node made from its configuration and the seeds of its names: on the road, and again from a recording."""

import numpy as np

from modelcast.apps.registry import get_application
from modelcast.core.geodesy import Origin
from modelcast.node.config import NodeConfig
from modelcast.node.envelope import Unsecured
from modelcast.node.node import Node, Watch
from modelcast.node.pseudonyms import Pseudonyms
from modelcast.node.recording.record import AbstractRecord
from modelcast.runtime.transport.base import AbstractTransport
from modelcast.station.sender.sender import Sender
from modelcast.station.station import Station

__all__ = ["node_of"]


def node_of(
    config: NodeConfig,
    sender: Sender,
    transport: AbstractTransport,
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
    origin
        Of its plane.
    names_seed, station_seed
        Of temporary ids and of the station; on the road ones that nobody can guess.
    watch, record
        As in `Node`.
    """
    names = Pseudonyms(config.pseudonyms.least_s, config.pseudonyms.most_s, np.random.default_rng(names_seed))
    station = Station(
        sender,
        temporary_id=names.temporary_id,
        dt_s=config.sending.tick_s,
        origin=origin,
        seed=station_seed,
    )
    return Node(
        station,
        transport,
        Unsecured(),
        applications={name: get_application(name) for name in config.applications.names},
        size_m=(config.vehicle.length_m, config.vehicle.width_m),
        pseudonyms=names,
        watch=watch,
        record=record,
    )
