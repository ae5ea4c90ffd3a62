"""Inputs for SUMO: a highway, a Manhattan grid and a signalised junction, written and built on the spot.

Networks are built by SUMO's own netconvert and netgenerate from a few lines of ours; routes are drawn here,
from a seed. Edges are at most 400 m long: SUMO's sublane model slows down on longer ones.
"""

import os
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from modelcast.core.chance import child_generator
from modelcast.core.exceptions import ConfigError, MissingExtraError

__all__ = ["SumoInput", "grid_input", "highway_input", "junction_input", "sumo_home"]

_LONGEST_EDGE_M = 400.0
_SMOOTH = (
    "--junctions.corner-detail",
    "10",
    "--junctions.internal-link-detail",
    "20",
    "--no-turnarounds",
    "true",
)
_TYPE = (
    '<vType id="car" carFollowModel="EIDM" laneChangeModel="SL2015" length="4.6" width="1.8" minGap="2.0" '
    'tau="1.2" accel="1.5" decel="2.0" emergencyDecel="8.0" maxSpeed="50" '
    'speedFactor="normc(1.0,0.1,0.75,1.25)"/>'
)


@dataclass(frozen=True, slots=True)
class SumoInput:
    """A network and its traffic.

    Parameters
    ----------
    network, routes
        The files.
    """

    network: Path
    routes: Path


def sumo_home() -> Path:
    """Return the folder of the installed SUMO.

    Raises
    ------
    MissingExtraError
        Where the extra ``sumo`` is not installed.
    """
    try:
        return Path(str(import_module("sumo").SUMO_HOME))
    except ImportError as error:
        raise MissingExtraError("Traffic by SUMO", "sumo") from error


def highway_input(
    folder: str | Path, *, length_m: float = 2000.0, density_per_km: float = 60.0, lanes: int = 3,
    seed: int = 0, duration_s: float = 300.0,
) -> SumoInput:  # fmt: skip
    """Highway in both directions, begun at a density and kept near it by what flows in at both ends.

    Parameters
    ----------
    folder
        Where the files go; it is made where it does not exist.
    length_m
        Length of the road [m].
    density_per_km
        Vehicles a kilometre of road at t = 0, all lanes of both directions [1/km].
    lanes
        Lanes in each direction.
    seed
        Of places and speeds.
    duration_s
        How long vehicles flow in [s].

    Raises
    ------
    MissingExtraError
        Where SUMO is not installed.
    ConfigError
        Where the density does not fit, or SUMO refuses the network.
    """
    per_lane = density_per_km / (2.0 * lanes)
    spacing_m = 1000.0 / per_lane
    if spacing_m < 8.0:
        raise ConfigError(f"{per_lane:.0f} vehicles/km and lane leave {spacing_m:.1f} m each: at least 8 m")
    speed_mps = min(33.3, max(1.0, (spacing_m - 6.6) / 1.2))
    edges = int(np.ceil(length_m / _LONGEST_EDGE_M))
    piece_m = length_m / edges
    nodes = [f'<node id="n{k}" x="{k * piece_m:.3f}" y="0"/>' for k in range(edges + 1)]
    lines = [
        f'<edge id="{way}{k}" from="n{k if way == "e" else k + 1}" to="n{k + 1 if way == "e" else k}" '
        f'numLanes="{lanes}" speed="33.3" priority="3"/>'
        for way in "ew"
        for k in range(edges)
    ]
    at = _prepared(folder)
    network = _converted(at, nodes, lines)
    rng = child_generator(seed, "sumo", "highway")
    ways = {"e": [f"e{k}" for k in range(edges)], "w": [f"w{k}" for k in reversed(range(edges))]}
    out = [f'<route id="{way}" edges="{" ".join(names)}"/>' for way, names in ways.items()]
    number = 0
    for way in ways:
        for lane in range(lanes):
            count = int(length_m / spacing_m)
            places = (np.arange(count) + rng.uniform(0.2, 0.8, count)) * length_m / max(count, 1)
            for place in places:
                edge, pos = divmod(float(place), piece_m)
                out.append(
                    f'<vehicle id="v{number}" type="car" route="{way}" depart="0" departEdge="{int(edge)}" '
                    f'departPos="{max(pos, 5.0):.2f}" departLane="{lane}" '
                    f'departSpeed="{0.8 * speed_mps:.2f}"/>'
                )
                number += 1
        rate = max(per_lane * lanes * speed_mps / 1000.0, 1e-3)
        out.append(
            f'<flow id="{way}f" type="car" route="{way}" begin="0" end="{duration_s}" '
            f'period="exp({rate:.5f})" departLane="best" departSpeed="desired"/>'
        )
    return SumoInput(network, _routes(at, out))


def grid_input(
    folder: str | Path, *, columns: int = 5, rows: int = 5, density_per_km: float = 20.0,
    block_m: float = 200.0, seed: int = 0, duration_s: float = 300.0,
) -> SumoInput:  # fmt: skip
    """Manhattan grid with signals; vehicles wander at random and nobody leaves before the end.

    Parameters
    ----------
    folder, seed
        As for `highway_input`.
    columns, rows
        Junctions from west to east and from south to north.
    density_per_km
        Vehicles a kilometre of street, both directions [1/km].
    block_m
        Distance between junctions [m].
    duration_s
        Routes are long enough for this [s].

    Raises
    ------
    MissingExtraError
        Where SUMO is not installed.
    ConfigError
        Where SUMO refuses the network.
    """
    at = _prepared(folder)
    network = at / "grid.net.xml"
    _run(
        "netgenerate", "--grid", "--grid.x-number", str(columns), "--grid.y-number", str(rows),
        "--grid.length", str(block_m), "--default-junction-type", "traffic_light", *_SMOOTH,
        "--default.speed", "13.9", "-o", str(network),
    )  # fmt: skip
    follows: dict[str, list[str]] = {}
    for link in ET.parse(network).getroot().iter("connection"):  # noqa: S314 - our own file
        origin, to = link.attrib["from"], link.attrib["to"]
        if not origin.startswith(":"):
            follows.setdefault(origin, []).append(to)
    rng = child_generator(seed, "sumo", "grid")
    edges = sorted(follows)
    street_m = block_m * (columns * (rows - 1) + rows * (columns - 1))
    out: list[str] = []
    hops = int(duration_s * 13.9 / block_m) + 2
    for number in range(round(density_per_km * street_m / 1000.0)):
        route = [edges[number % len(edges)]]
        for _ in range(hops):
            ways = follows[route[-1]]
            route.append(ways[int(rng.integers(len(ways)))])
        out.append(
            f'<vehicle id="v{number}" type="car" depart="0" departPos="random_free" departSpeed="0">'
            f'<route edges="{" ".join(route)}"/></vehicle>'
        )
    return SumoInput(network, _routes(at, out))


def junction_input(
    folder: str | Path, *, arm_m: float = 300.0, flow_per_h: float = 500.0, lanes: int = 2, seed: int = 0,
    duration_s: float = 300.0,
) -> SumoInput:  # fmt: skip
    """One signalised junction of four arms.

    Parameters
    ----------
    folder, seed, duration_s
        As for `highway_input`.
    arm_m
        Length of an arm [m].
    flow_per_h
        Vehicles that come in on each arm [1/h]: half go straight on, a quarter each way turn.
    lanes
        Lanes in each direction.

    Raises
    ------
    MissingExtraError
        Where SUMO is not installed.
    ConfigError
        Where SUMO refuses the network.
    """
    ends = {"E": (1, 0), "N": (0, 1), "W": (-1, 0), "S": (0, -1)}
    nodes = ['<node id="c" x="0" y="0" type="traffic_light"/>'] + [
        f'<node id="{arm}" x="{x * arm_m}" y="{y * arm_m}"/>' for arm, (x, y) in ends.items()
    ]
    lines = [
        f'<edge id="{name}" from="{a}" to="{b}" numLanes="{lanes}" speed="13.9" priority="2"/>'
        for arm in ends
        for name, a, b in ((f"in{arm}", arm, "c"), (f"out{arm}", "c", arm))
    ]
    at = _prepared(folder)
    network = _converted(at, nodes, lines)
    rng = child_generator(seed, "sumo", "junction")
    arms = list(ends)
    out: list[str] = []
    for k, arm in enumerate(arms):
        for turn, share in ((2, 0.5), (1, 0.25), (3, 0.25)):
            rate = share * flow_per_h / 3600.0
            out.append(
                f'<flow id="f{arm}{turn}" type="car" from="in{arm}" to="out{arms[(k + turn) % 4]}" '
                f'begin="{rng.uniform(0.0, 5.0):.1f}" end="{duration_s}" period="exp({rate:.6f})" '
                'departLane="best" departSpeed="desired"/>'
            )
    return SumoInput(network, _routes(at, sorted(out, key=_begin)))


def _begin(flow: str) -> float:
    """Return when a flow begins: SUMO wants them in this order."""
    return float(flow.partition('begin="')[2].partition('"')[0])


def _prepared(folder: str | Path) -> Path:
    sumo_home()
    at = Path(folder)
    at.mkdir(parents=True, exist_ok=True)
    return at


def _routes(folder: Path, lines: Iterable[str]) -> Path:
    path = folder / "traffic.rou.xml"
    path.write_text("<routes>\n" + "\n".join([_TYPE, *lines]) + "\n</routes>\n", encoding="utf-8")
    return path


def _converted(folder: Path, nodes: Iterable[str], edges: Iterable[str]) -> Path:
    """Return the network that netconvert makes of nodes and edges."""
    node_file, edge_file, network = folder / "in.nod.xml", folder / "in.edg.xml", folder / "road.net.xml"
    node_file.write_text("<nodes>" + "\n".join(nodes) + "</nodes>\n", encoding="utf-8")
    edge_file.write_text("<edges>" + "\n".join(edges) + "</edges>\n", encoding="utf-8")
    _run("netconvert", "-n", str(node_file), "-e", str(edge_file), *_SMOOTH, "-o", str(network))
    return network


def _run(program: str, *arguments: str) -> None:
    """Run one of SUMO's programs.

    Raises
    ------
    ConfigError
        Where it fails, with what it said.
    """
    home = sumo_home()
    ended = subprocess.run(  # noqa: S603 - SUMO's own program, arguments of ours
        [str(home / "bin" / program), *arguments],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "SUMO_HOME": str(home)},
    )
    if ended.returncode != 0:
        raise ConfigError(f"SUMO's {program} refused the network: {ended.stderr.strip()}")
