"""User code with stations and fleets that must type-check under pyright strict and mypy; it is not run."""

from typing import assert_type

import numpy as np
import polars as pl
from matplotlib.figure import Figure

import modelcast
from modelcast import Fleet, NetworkSimulation, Station


def meet() -> Figure:
    """Let one station hear another over a lossy medium."""
    medium = modelcast.VirtualMedium(modelcast.IndependentErasure(0.4), seed=1)
    front, back = Station("mbc", temporary_id=1), Station("mbc", temporary_id=2)
    assert_type(front, Station)
    way, other = medium.join(), medium.join()
    for step in range(40):
        t_s = 0.1 * step
        for message in front.sense(t_s, (15.0 * t_s, 0.0), speed_mps=15.0, heading_rad=np.pi / 2):
            assert_type(message.octets, bytes)
            way.send(message.octets, sent_s=message.send_s)
        arrived = other.receive(t_s)
        back.hear([one.octets for one in arrived], received_s=[one.received_s for one in arrived])
    around = back.believe(4.0)
    return modelcast.plot_remotes(around, host_m=around.position_m[0])


def drive_many(vehicles: int) -> list[bytes]:
    """Drive the stations of a fleet for one instant."""
    fleet = Fleet("j2945-mbc", slots=vehicles, seed=1)
    numbers = np.arange(vehicles)
    places_m = np.zeros((vehicles, 2))
    places_m[:, 0] = 20.0 * numbers
    speed_mps = np.full(vehicles, 25.0)
    sent = fleet.sense(0.0, numbers, places_m, speed_mps=speed_mps, heading_rad=np.zeros(vehicles))
    return [message.octets for message in sent]


def simulate() -> pl.DataFrame:
    """Simulate a highway."""
    road = modelcast.Highway(1000.0, 100.0)
    result = modelcast.simulate_network(road, ["j2945", "j2945-mbc"], runs=modelcast.FleetRuns(10.0))
    assert_type(result, NetworkSimulation)
    return result.headline
