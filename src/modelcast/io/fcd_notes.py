"""What a user should know of a file of floating-car data before any figure is made of it, in sentences."""

from collections.abc import Iterator
from math import pi

import numpy as np

from modelcast.core.geodesy import Origin
from modelcast.io.fcd_columns import FcdColumns
from modelcast.io.fcd_gathered import Gathered
from modelcast.trips.trajectory import GAP_STEPS
from modelcast.world.scenario.motion import MotionCheck

__all__ = ["notes"]


def notes(
    columns: FcdColumns | None,
    found: Gathered,
    *,
    origin: Origin | None,
    turn_rad: float,
    shifted: bool,
    length_m: float,
) -> Iterator[str]:
    """Yield the sentences.

    Parameters
    ----------
    columns
        Of a table; None for XML.
    found
        What the file holds.
    origin, turn_rad, shifted
        As in `modelcast.io.fcd_survey.FcdSurvey`.
    length_m
        Taken where the file has no length [m].
    """
    if origin is not None:
        yield (
            "x and y are longitude and latitude: laid out in metres about "
            f"{origin.latitude_deg:.6f}, {origin.longitude_deg:.6f}"
        )
    if turn_rad:
        yield f"headings turned by {turn_rad * 180.0 / pi:.2f}° from the grid's north to true north"
    if shifted:
        yield "positions are front bumpers, as SUMO's: moved back by half a length"
    else:
        yield "positions are taken for the middles of vehicles"
    counts = {kind.name.lower(): len(names) for kind, names in sorted(found.people.items())}
    if counts:
        yield f"people among them, by kind: {', '.join(f'{count} {name}' for name, count in counts.items())}"
    if found.unknown[2]:
        yield f"{found.unknown[2]} rows without a length: {length_m:g} m taken"
    if columns is not None and not columns.tells_vehicles:
        yield _vehicles_not_told(columns)
    for name, count in zip(("speed", "heading (angle)"), found.unknown[:2], strict=True):
        if count:
            yield f"{count} rows without a {name}: taken from motion"
    yield from _motion(found, found.metres if origin is None else found.degrees)


def _vehicles_not_told(columns: FcdColumns) -> str:
    if "type" in columns.found:
        return (
            "neither tag, lane nor edge says which rows are vehicles: persons and containers are known by "
            "SUMO's own types only"
        )
    return (
        "neither tag, lane, edge nor type says which rows are vehicles: persons and containers, if there are "
        "any, are taken for vehicles"
    )


def _motion(found: Gathered, check: MotionCheck) -> Iterator[str]:
    if found.unknown[0] and check.time_s > 0.0:
        yield f"the mean speed by positions is {check.way_m / check.time_s:.3g} m/s"
    steps = np.diff(found.times)
    gaps = int((steps > GAP_STEPS * np.median(steps)).sum()) if steps.size else 0
    if gaps:
        yield f"{gaps} gaps in time: who comes after one is a new vehicle"
    if check.jumps:
        yield f"{check.jumps} jumps no vehicle makes: who jumps is a new vehicle from there on"
    if check.off:
        yield (
            f"positions and speeds differ by a factor of 2 or more in {check.off} of {check.stretches} "
            "stretches of a way"
        )
