"""What a file of floating-car data holds, found out before any of it is used.

The file is read once. That tells how many vehicles there are, how many of its rows are vehicles, which
columns have to be taken from motion, and whether x and y are metres or, as with SUMO's ``--fcd-output.geo``,
longitude and latitude: in one of the two vehicles move as their speeds say
(`modelcast.world.scenario.motion`). Where they do in neither, or where it cannot be told, the file is
refused.
"""

from dataclasses import KW_ONLY, dataclass
from itertools import islice
from math import inf

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.core.kinds import Kind
from modelcast.io.fcd_columns import FcdColumns
from modelcast.io.fcd_gathered import Gathered
from modelcast.io.fcd_notes import notes
from modelcast.io.fcd_rows import read_columns
from modelcast.io.fcd_times import by_time
from modelcast.io.traffic_survey import TrafficSurvey

__all__ = ["FcdSurvey", "survey"]

_FASTEST_MPS = 150.0
_SLOWEST_MPS = 0.01
_EXTENT_M = 0.5
_TURN_RAD = 0.0005
_REMEDY = "Check units and columns; SUMO's own files are right with or without --fcd-output.geo."


@dataclass(frozen=True, slots=True)
class FcdSurvey(TrafficSurvey):
    """What a file holds.

    Parameters
    ----------
    path, reading, vehicles, most, start_s, end_s, step_s, notes, pedestrians, cyclists, people
        As in `TrafficSurvey`.
    origin
        Where x and y are longitude and latitude: what they are laid out about.
    turn_rad
        What headings are turned by, so that they point where vehicles move: from SUMO's grid north to true
        north [rad].
    front_bumper
        Whether positions are those of the front bumper.
    unknown
        Rows of vehicles without a speed, a heading, a length.
    """

    _: KW_ONLY
    origin: Origin | None
    turn_rad: float
    front_bumper: bool
    unknown: tuple[int, int, int]


def survey(
    path: str,
    *,
    front_bumper: bool | None = None,
    vehicle_length_m: float = 4.5,
    times: int | None = None,
    people: bool = False,
) -> FcdSurvey:
    """Return what a file holds; none of it is kept.

    Parameters
    ----------
    path
        The file.
    front_bumper
        Whether positions are those of the front bumper; where None, in SUMO's files they are.
    vehicle_length_m
        Length of vehicles whose length the file does not say [m], for the notes.
    times
        How many time steps are looked at; None for all.
    people
        Whether its persons are taken.

    Raises
    ------
    DataFormatError
        Where the file is not what it should be, holds no vehicle, or its vehicles do not move as it says.
    """
    columns = read_columns(path)
    found = Gathered()
    for rows in islice(by_time(path, people=people), times):
        found.add(rows)
    found.finish()
    reading = found.tally.reading(found.rows, found.rows - found.tally.left_out)
    if not found.names:
        counts = ", ".join(f"{count} {what}" for what, count in reading.skipped.items())
        raise DataFormatError(
            path, f"no vehicle in the file ({counts or 'no rows'})", remedy="Check that it is complete."
        )
    _require_one_clock(path, found)
    origin = _origin(path, columns, found)
    turn = 0.0 if origin is None else found.degrees.turn_rad
    turn = turn if abs(turn) > _TURN_RAD else 0.0
    shifted = (columns is None or columns.is_sumo) if front_bumper is None else front_bumper
    told = notes(columns, found, origin=origin, turn_rad=turn, shifted=shifted, length_m=vehicle_length_m)
    steps = np.diff(found.times)
    return FcdSurvey(
        path,
        reading,
        vehicles=len(found.names),
        most=found.most,
        start_s=found.times[0],
        end_s=found.times[-1],
        step_s=float(np.median(steps)) if steps.size else inf,
        origin=origin,
        turn_rad=turn,
        front_bumper=shifted,
        unknown=found.unknown,
        notes=tuple(told),
        pedestrians=len(found.people.get(Kind.PEDESTRIAN, ())),
        cyclists=len(found.people.get(Kind.CYCLIST, ())),
        people=people,
    )


def _require_one_clock(path: str, found: Gathered) -> None:
    """Refuse files whose vehicles are measured at times of their own: nobody is there twice in a row."""
    if found.visits > 2 * len(found.names) and found.alone > 0.5 * found.visits:
        raise DataFormatError(
            path,
            f"most vehicles are missing at the time after each of their rows ({found.alone} of "
            f"{found.visits} times): every vehicle has times of its own",
            remedy="Write all vehicles at the same times.",
        )


def _origin(path: str, columns: FcdColumns | None, found: Gathered) -> Origin | None:
    """Return what degrees are laid out about, None for metres; refuse what moves as said in neither."""
    named = columns is not None and columns.is_geographic
    if named:
        if not found.inside:
            raise DataFormatError(
                path, "longitude or latitude is beyond 180 or 90 degrees", remedy="Check the columns."
            )
        told = found.degrees.fault()
    else:
        told = found.metres.fault()
    if told:
        swapped = found.inside and not named
        if swapped and found.degrees.has_evidence and not found.degrees.fault():
            return found.origin
        hint = ", nor do they as longitude and latitude" if swapped else ""
        raise DataFormatError(path, told + hint, remedy=_REMEDY)
    if named:
        return found.origin
    if found.inside and not found.metres.has_evidence:
        _require_metres(path, found)
    return None


def _require_metres(path: str, found: Gathered) -> None:
    """Refuse small coordinates that nothing shows to be metres: no speeds, or nobody moves."""
    pace_m, pace_deg = (
        check.way_m / check.time_s if check.time_s > 0.0 else 0.0 for check in (found.metres, found.degrees)
    )
    still = pace_m < _SLOWEST_MPS <= pace_deg <= _FASTEST_MPS and found.unknown[0] > 0
    if still or (found.most > 1 and pace_m < _SLOWEST_MPS and found.extent < _EXTENT_M):
        raise DataFormatError(
            path,
            "positions do not move as the speeds say, or there are no speeds (attribute speed of SUMO): at "
            f"{pace_m:.2g} m/s on average, within {found.extent:.2g} m, they may be longitude and latitude",
            remedy="Write speeds too, or name the columns longitude and latitude.",
        )
