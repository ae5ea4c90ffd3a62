"""The film of ``modelcast network --film``: a meeting of the first run, without roadside units and with."""

from dataclasses import replace
from pathlib import Path

from modelcast.cli.network_case import propagation_of, simulated
from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.network_traffic import traffic
from modelcast.core.exceptions import ConfigError
from modelcast.io.meeting import write_meeting
from modelcast.report.meeting import draw_meeting
from modelcast.study.network.meeting import Meeting, MeetingObserver, Seen, hidden_meeting
from modelcast.study.network.rows import NetworkCase

__all__ = ["find_meeting", "write_film"]


def find_meeting(plan: NetworkPlan, case: NetworkCase) -> Meeting:
    """Who comes from behind a building in the traffic of a run.

    Parameters
    ----------
    plan
        What all runs share.
    case
        The run.

    Raises
    ------
    ConfigError
        Where the scenario has no people or no buildings, or nobody meets.
    """
    if plan.people is None or propagation_of(plan).streets is None:
        raise ConfigError(
            "--film needs people and buildings: --scenario grid or crossing, --pedestrians, --cyclists"
        )
    with traffic(plan, case) as frames:
        found = hidden_meeting(list(frames), propagation_of(plan), since_s=plan.warm_up_s)
    if found is None:
        raise ConfigError(
            f"--film: in {plan.duration_s:g} s nobody comes from behind a building so near to a vehicle that "
            "drives: give more --cyclists, a longer --duration, or another --seed"
        )
    return found


def write_film(plan: NetworkPlan, case: NetworkCase, meeting: Meeting, folder: Path) -> None:
    """Run the case for the film, and write it: the figure ``film`` as PNG, SVG and PDF, and ``film.parquet``.

    Parameters
    ----------
    plan, case
        As for `find_meeting`.
    meeting
        As it gave it.
    folder
        Where to.

    Raises
    ------
    ConfigError
        Where there are no buildings.
    """
    arms = {"no unit": replace(plan, roadside=None)}
    if plan.roadside is not None:
        arms["units relay" if plan.roadside.relay is not None else "units hear"] = plan
    propagation = propagation_of(plan)
    streets = propagation.streets
    if streets is None:
        raise ConfigError("--film needs buildings: --scenario grid or crossing")
    runs: dict[str, Seen] = {}
    for words, own in arms.items():
        observer = MeetingObserver(meeting, propagation)
        simulated(own, case, observer=observer)
        runs[words] = observer.seen()
    write_meeting(runs, folder / "film.parquet")
    draw_meeting(meeting, runs, streets, folder)
