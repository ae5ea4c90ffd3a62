"""Traffic by SUMO, run inside this process through libsumo: an iterator of frames.

Needs the extra ``sumo`` (eclipse-sumo and libsumo). Vehicles follow by EIDM, because SUMO's default (Krauss)
jerks, and move sideways in the sublane model with a resolution of 0.8 m, because a change of lane is a jump
or a kink otherwise. SUMO's x and y are the middle of the front bumper; frames hold the middles of vehicles.
One simulation runs in a process at a time.
"""

# libsumo's stubs leave most results open.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingImports=false

import contextlib
import io
import os
from collections.abc import Iterator
from importlib import import_module
from math import cos, nan, radians, sin
from typing import Any

import numpy as np

from modelcast.core.exceptions import ConfigError, MissingExtraError
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.io.fleet_slots import FleetSlots
from modelcast.io.sumo_roads import SumoInput, sumo_home
from modelcast.world.scenario.base import STEP_S, FleetFrame
from modelcast.world.scenario.completion import completed

__all__ = ["require_sumo", "run_sumo"]

_LATERAL_M = 0.8


def run_sumo(
    source: SumoInput, *, slots: int, duration_s: float, seed: int = 0, warm_up_s: float = 0.0
) -> Iterator[FleetFrame]:
    """Yield a frame every `STEP_S`, from t = 0 at the end of the warm-up.

    Speed and acceleration are SUMO's, those along the lane; heading is the vehicle's angle, which turns in a
    change of lane; the yaw rate is its central difference.

    Parameters
    ----------
    source
        Network and routes: `modelcast.io.sumo_roads`, or files of one's own.
    slots
        Number of slots V: as many vehicles may be there at a time.
    duration_s
        Length of the run [s].
    seed
        SUMO's seed: same seed, same frames.
    warm_up_s
        Driven before t = 0 [s].

    Raises
    ------
    MissingExtraError
        Where the extra ``sumo`` is not installed.
    ConfigError
        Where SUMO refuses the input, or there are more vehicles than slots.
    """
    library = _library()
    steps, warm_up = round(duration_s / STEP_S), round(warm_up_s / STEP_S)
    return completed(_frames(library, source, slots, steps=steps, seed=seed, warm_up=warm_up))


def require_sumo() -> None:
    """Refuse where SUMO cannot run.

    Raises
    ------
    MissingExtraError
        Where the extra ``sumo`` is not installed.
    """
    _library()


def _library() -> Any:
    """Return libsumo, imported without the notice that it prints on some versions of pyarrow."""
    home = sumo_home()
    os.environ.setdefault("SUMO_HOME", str(home))
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            return import_module("libsumo")
    except ImportError as error:
        raise MissingExtraError("Traffic by SUMO", "sumo") from error


def _frames(
    library: Any, source: SumoInput, slots: int, *, steps: int, seed: int, warm_up: int
) -> Iterator[FleetFrame]:
    seats = FleetSlots(slots)
    try:
        library.start(
            [
                "sumo", "-n", str(source.network), "-r", str(source.routes), "--step-length", str(STEP_S),
                "--lateral-resolution", str(_LATERAL_M),
                "--seed", str(seed), "--no-step-log", "true", "--no-warnings", "true",
                "--time-to-teleport", "-1", "--collision.action", "none",
            ]
        )  # fmt: skip
    except library.TraCIException as error:
        raise ConfigError(f"SUMO refuses {source.network} with {source.routes}: {error}") from error
    lengths: dict[str, float] = {}
    try:
        for step in range(warm_up + steps):
            library.simulationStep()
            if step < warm_up:
                continue
            labels = list(library.vehicle.getIDList())
            rows = np.empty((len(labels), 7))
            for at, label in enumerate(labels):
                rows[at] = _row(library.vehicle, label, lengths)
            rows[:, 3] = wrap_angle_rad(rows[:, 3])
            t_s = round((step - warm_up) * STEP_S, 6)
            frame = seats.frame(t_s, labels, rows)
            if frame is None:
                raise ConfigError(
                    f"{len(labels)} vehicles at {t_s} s do not fit into {slots} slots: raise slots"
                )
            yield frame
    finally:
        library.close()


def _row(vehicle: Any, label: str, lengths: dict[str, float]) -> tuple[float, ...]:
    """Return a vehicle's numbers, in the order of `RAW_COLUMNS`."""
    length = lengths.get(label)
    if length is None:
        length = lengths[label] = float(vehicle.getLength(label))
    east, north = vehicle.getPosition(label)
    heading = radians(vehicle.getAngle(label))
    return (
        east - 0.5 * length * sin(heading),
        north - 0.5 * length * cos(heading),
        max(float(vehicle.getSpeed(label)), 0.0),
        heading,
        float(vehicle.getAcceleration(label)),
        nan,
        length,
    )
