"""What traffic of one's own holds, found out before any of it is used: of a file, or of a run of SUMO."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from math import inf
from pathlib import Path
from typing import Any

from modelcast.trips.trajectory import Reading

__all__ = ["TrafficSurvey", "survey_document"]


@dataclass(frozen=True, slots=True)
class TrafficSurvey:
    """What traffic holds, whatever it comes from.

    Parameters
    ----------
    path
        The file.
    reading
        Rows, one a road user and time, and those that are none of the traffic's, by what they are.
    vehicles, most
        Road users, by name, and how many there are at most at one time.
    start_s, end_s, step_s
        First and last time and the median step [s]; the step is infinite where there is one time only.
    notes
        What else should be known of it, in sentences.
    pedestrians, cyclists
        How many of the road users are people.
    people
        Whether its persons are taken.
    """

    path: str
    reading: Reading
    _: KW_ONLY
    vehicles: int
    most: int
    start_s: float
    end_s: float
    step_s: float
    notes: tuple[str, ...]
    pedestrians: int = 0
    cyclists: int = 0
    people: bool = False

    @property
    def taken(self) -> int:
        """Rows of the traffic."""
        return self.reading.rows - sum(self.reading.skipped.values())


def survey_document(found: TrafficSurvey) -> Mapping[str, Any]:
    """Return a survey as plain values, for a result.

    Parameters
    ----------
    found
        The survey.
    """
    return {
        "file": Path(found.path).name,
        "rows": found.reading.rows,
        "taken": found.taken,
        "skipped": dict(found.reading.skipped),
        "repaired": dict(found.reading.repaired),
        "vehicles": found.vehicles,
        "pedestrians": found.pedestrians,
        "cyclists": found.cyclists,
        "most_at_once": found.most,
        "duration_s": found.end_s - found.start_s,
        "step_s": None if found.step_s == inf else found.step_s,
        "notes": list(found.notes),
    }
