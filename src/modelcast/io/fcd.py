"""Floating-car data of any origin as frames: CSV, Parquet or SUMO's XML, read as a stream.

`modelcast.io.fcd_columns` has the table of columns. Rows are in order of time; each vehicle has one row a
time. Speed, heading, acceleration and yaw rate are taken from the frames around where the file has none. In
SUMO's files x and y are the middle of the front bumper: positions are moved back by half a length. Longitude
and latitude are laid out in metres (`modelcast.io.fcd_survey`).

A vehicle that is missing from a frame, or jumps as no vehicle does, is a new one from there on; and after a
gap in time, over `GAP_STEPS` median steps, all are.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import heading_to_velocity, wrap_angle_rad
from modelcast.core.kinds import SIZES_M, Kind
from modelcast.io.base import Tally
from modelcast.io.fcd_columns import FcdRow
from modelcast.io.fcd_survey import FcdSurvey, survey
from modelcast.io.fcd_times import by_time, in_metres
from modelcast.io.fleet_slots import RAW_COLUMNS, FleetSlots, Jumps
from modelcast.trips.trajectory import GAP_STEPS
from modelcast.world.scenario.base import NOBODY, FleetFrame
from modelcast.world.scenario.completion import with_course, with_rates
from modelcast.world.scenario.motion import checked

__all__ = ["most_vehicles", "read_fcd", "survey_fcd"]

_HEADING, _LENGTH = (RAW_COLUMNS.index(name) for name in ("heading_rad", "length_m"))
_HEAD_TIMES = 500
_NO_HEADING = "no heading (attribute angle of SUMO), and no motion yet to take it from"


def survey_fcd(
    path: str | Path,
    *,
    vehicle_length_m: float = 4.5,
    front_bumper: bool | None = None,
    people: bool = False,
) -> FcdSurvey:
    """Return what a file holds, and how many of its rows `read_fcd` takes.

    Parameters
    ----------
    path, vehicle_length_m, front_bumper, people
        As for `read_fcd`.

    Raises
    ------
    DataFormatError
        As `read_fcd`.
    """
    found = survey(str(path), front_bumper=front_bumper, vehicle_length_m=vehicle_length_m, people=people)
    if not found.unknown[1]:
        return found
    # Which rows have no heading shows only when the motion around them is known.
    tally = Tally()
    for _ in _frames(found, found.most, vehicle_length_m, tally):
        pass
    late = tally.reading(tally.left_out, 0)
    reading = replace(
        found.reading, skipped={**found.reading.skipped, **late.skipped}, repaired=late.repaired
    )
    return replace(found, reading=reading)


def read_fcd(
    path: str | Path,
    *,
    slots: int | None = None,
    vehicle_length_m: float = 4.5,
    front_bumper: bool | None = None,
    found: FcdSurvey | None = None,
    people: bool = False,
) -> Iterator[FleetFrame]:
    """Yield a file's frames at the file's own times, counted from its first.

    Only a few frames are held at a time. A step of 0.1 s is what senders need; `resampled`, in
    `modelcast.world.scenario.resampling`, makes it of a coarser one.

    Parameters
    ----------
    path
        The file.
    slots
        Number of slots V; where None the file is read once more beforehand to count its vehicles. Where it
        is given, the first 500 times of the file alone tell what its positions are.
    vehicle_length_m
        Length of vehicles whose length the file does not say [m].
    front_bumper
        Whether positions are those of the front bumper; where None, in SUMO's files they are.
    found
        What `survey_fcd` found, to spare reading the file once more; it says whether people are taken.
    people
        Whether SUMO's persons are taken, as pedestrians; else they are skipped. Bicycles are cyclists in any
        case.

    Raises
    ------
    DataFormatError
        Where the file is not what it should be, with file, row and value: among others time that runs back,
        a vehicle twice at one time, more vehicles than slots, positions that do not move as the speeds say.
    """
    at = str(path)
    if found is None:
        times = None if slots is None else _HEAD_TIMES
        found = survey(
            at, front_bumper=front_bumper, vehicle_length_m=vehicle_length_m, times=times, people=people
        )
    places = found.most if slots is None else slots
    return _checked(at, _frames(found, places, vehicle_length_m, Tally()))


def most_vehicles(path: str | Path) -> int:
    """Return how many vehicles a file has at most at one time; it is read whole, and held not at all.

    Parameters
    ----------
    path
        The file.
    """
    return max((sum(not row.skipped for row in rows) for rows in by_time(str(path))), default=0)


def _checked(path: str, frames: Iterable[FleetFrame]) -> Iterator[FleetFrame]:
    try:
        yield from checked(frames)
    except ValueError as error:
        raise DataFormatError(path, str(error), remedy="Check units and columns.") from error


def _frames(found: FcdSurvey, slots: int, length_m: float, tally: Tally) -> Iterator[FleetFrame]:
    """Yield complete frames, and count the rows they leave out or put right."""
    raw = _RawFrames(found, slots, length_m)
    moved = _middles(with_course(raw), tally, shifted=found.front_bumper)
    taken = 0
    for frame in with_rates(moved):
        taken += int(frame.active.sum())
        yield frame
    if not taken and raw.headless:
        raise DataFormatError(
            found.path,
            "no vehicle moves or has a heading (attribute angle of SUMO), which is needed to find its middle",
            row=raw.headless,
            remedy="Add the heading, or say front_bumper=False.",
        )


class _RawFrames:
    """Frames as the file has them, in metres.

    Parameters
    ----------
    found
        What the file holds.
    slots, length_m
        As for `read_fcd`.
    """

    def __init__(self, found: FcdSurvey, slots: int, length_m: float) -> None:
        self.headless = 0
        self._found, self._slots = found, slots
        self._seats = FleetSlots(slots)
        self._lengths_m = {**{kind: size_m[0] for kind, size_m in SIZES_M.items()}, Kind.VEHICLE: length_m}
        self._jumps = Jumps()

    def __iter__(self) -> Iterator[FleetFrame]:
        gap_s = GAP_STEPS * self._found.step_s
        start_s, last_s = inf, inf
        for rows in by_time(self._found.path, people=self._found.people):
            t_s = rows[0].t_s
            start_s = min(start_s, t_s)
            if t_s - last_s > gap_s:
                self._jumps.forget()
                between = last_s + 0.5 * self._found.step_s - start_s
                yield self._seated(round(between, 6), [], np.zeros((0, len(RAW_COLUMNS))), rows)
            here = [row for row in rows if not row.skipped]
            numbers = self._numbers(here)
            labels = self._jumps.labels([row.vehicle for row in here], numbers, t_s - last_s)
            yield self._seated(round(t_s - start_s, 6), labels, numbers, rows)
            last_s = t_s

    def _numbers(self, rows: Sequence[FcdRow]) -> FloatArray:
        """Return rows' numbers in metres, with lengths, headings from true north."""
        numbers = np.array([row.numbers for row in rows]).reshape(-1, len(RAW_COLUMNS))
        numbers[:, :2] = in_metres(numbers, self._found.origin)
        unknown = np.isnan(numbers[:, _LENGTH])
        usual = np.array([self._lengths_m[row.kind] for row in rows])
        numbers[unknown, _LENGTH] = usual[unknown]
        numbers[:, _HEADING] = wrap_angle_rad(numbers[:, _HEADING] + self._found.turn_rad)
        if not self.headless and np.isnan(numbers[:, _HEADING]).any():
            self.headless = rows[int(np.argmax(np.isnan(numbers[:, _HEADING])))].row
        return numbers

    def _seated(
        self, t_s: float, labels: Sequence[str], numbers: FloatArray, rows: Sequence[FcdRow]
    ) -> FleetFrame:
        kinds = [row.kind for row in rows if not row.skipped] if labels else []
        frame = self._seats.frame(t_s, labels, numbers, kinds)
        if frame is None:
            raise DataFormatError(
                self._found.path,
                f"{len(labels)} vehicles at time {rows[0].t_s} do not fit into {self._slots} slots",
                row=rows[-1].row,
                remedy="Raise slots, or leave it out.",
            )
        return frame


def _middles(frames: Iterable[FleetFrame], tally: Tally, *, shifted: bool) -> Iterator[FleetFrame]:
    """Yield frames of vehicles' middles.

    Who has no heading yet is left out where positions are front bumpers, for its middle is not known; else
    its heading is zero.
    """
    for frame in frames:
        headless = frame.active & np.isnan(frame.heading_rad)
        heading = np.where(headless, 0.0, frame.heading_rad)
        if not shifted:
            tally.repair("heading not known before the vehicle moves, north taken", int(headless.sum()))
            yield replace(frame, heading_rad=heading)
            continue
        tally.skip(_NO_HEADING, int(headless.sum()))
        here = frame.active & ~headless
        # SUMO's persons are points: half of their 0.2 m is less than what its positions mean.
        walks = frame.kind == Kind.PEDESTRIAN if frame.kind is not None else np.zeros_like(here)
        back = heading_to_velocity(np.where(walks, 0.0, 0.5 * frame.length_m), heading)
        yield replace(
            frame,
            position_m=(frame.position_m - back) * here[:, None],
            speed_mps=frame.speed_mps * here,
            heading_rad=heading * here,
            acceleration_mps2=frame.acceleration_mps2 * here,
            yaw_rate_radps=frame.yaw_rate_radps * here,
            length_m=frame.length_m * here,
            vehicle_id=np.where(here, frame.vehicle_id, NOBODY),
            active=here,
        )
