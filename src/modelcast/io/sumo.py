"""Traffic by SUMO, run inside this process through libsumo: an iterator of frames.

Needs the extra ``sumo`` (eclipse-sumo and libsumo). What runs is a network and routes of ours
(`modelcast.io.sumo_roads`) or any configuration (``.sumocfg``).

In traffic of ours vehicles follow by EIDM, because SUMO's default (Krauss) jerks, and move sideways in the
sublane model with a resolution of 0.8 m, because a change of lane is a jump or a kink otherwise. A
configuration is run as it is, with its own step, begin and end; only its seed and its outputs are ours:
what it asks for by options is not written, and what its other files ask for (detectors, mean data, devices)
goes into a folder that is removed.
SUMO's x and y are the middle of the front bumper; frames hold the middles of vehicles. One simulation runs in
a process at a time.
"""

# libsumo's stubs leave most results open.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingImports=false

import contextlib
import io
import os
import subprocess
import tempfile
from collections.abc import Generator, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass
from importlib import import_module, metadata
from itertools import takewhile
from math import ceil, inf
from pathlib import Path
from typing import Any

from modelcast.core.exceptions import ConfigError, MissingExtraError
from modelcast.core.kinds import Kind
from modelcast.io.fleet_slots import FleetSlots
from modelcast.io.sumo_config import SumoConfig
from modelcast.io.sumo_roads import SumoInput, sumo_home
from modelcast.io.sumo_users import RoadUsers, UserCounts, Users
from modelcast.io.traffic_survey import TrafficSurvey
from modelcast.world.scenario.base import STEP_S, FleetFrame
from modelcast.world.scenario.completion import completed
from modelcast.world.scenario.resampling import resampled

__all__ = ["SumoSurvey", "require_sumo", "run_sumo", "survey_sumo"]

_LATERAL_M = 0.8
_SLACK_S = 1e-6
_WARNINGS_TOLD = 5
_ERROR_LOG, _ERRORS = "error-log", "modelcast-errors.txt"
_UPWARDS = 64
"""More folders than any file lies deep: so many steps up lead to the root."""


_At = tuple[RoadUsers, float]
"""Who is there at one of SUMO's steps, and how long those are [s]."""


@dataclass(frozen=True, slots=True)
class SumoSurvey(TrafficSurvey):
    """What a run of a configuration holds; its times are counted from its own begin.

    Parameters
    ----------
    path, reading, vehicles, most, start_s, end_s, step_s, notes, pedestrians, cyclists, people
        As in `TrafficSurvey`.
    seed
        SUMO's seed.
    """

    _: KW_ONLY
    seed: int


def survey_sumo(
    source: SumoConfig, *, duration_s: float, seed: int = 0, warm_up_s: float = 0.0, people: bool = False
) -> SumoSurvey:
    """Run a configuration once and return what it holds, and how many slots it needs (`most`).

    Parameters
    ----------
    source, duration_s, seed, warm_up_s, people
        As for `run_sumo`.

    Raises
    ------
    MissingExtraError
        Where the extra ``sumo`` is not installed.
    ConfigError
        Where SUMO refuses it, with what it says, or nobody is on the roads in that time.
    """
    library = _library()
    users = Users(library, people=people)
    with tempfile.TemporaryDirectory(prefix="modelcast-") as folder:
        apart = Path(folder)
        steps = _run(
            library, users, source, duration_s=duration_s, seed=seed, warm_up_s=warm_up_s, apart=apart
        )
        step_s = [step_s for _, step_s in steps][-1:]
        warnings = list(_warnings(apart / _ERRORS))
    counts = users.counts
    if not counts.names:
        skipped = counts.tally.reading(counts.rows, 0).skipped
        what = ", ".join(f"{count} {reason}" for reason, count in skipped.items())
        raise ConfigError(
            f"{source.path}: nobody is on the roads within {duration_s:g} s, beginning {warm_up_s:g} s after "
            f"its begin ({what or 'it has ended, or nobody came yet'}): choose another time"
        )
    return SumoSurvey(
        str(source.path),
        counts.tally.reading(counts.rows, counts.rows - counts.tally.left_out),
        vehicles=len(counts.names),
        most=counts.most,
        start_s=counts.times[0],
        end_s=counts.times[-1],
        step_s=step_s[0],
        notes=(*_notes(counts, step_s[0], seed), *warnings),
        pedestrians=counts.of(Kind.PEDESTRIAN),
        cyclists=counts.of(Kind.CYCLIST),
        people=people,
        seed=seed,
    )


def _notes(counts: UserCounts, step_s: float, seed: int) -> Iterator[str]:
    """Yield what should be known of a run, in sentences."""
    how = "as they are" if abs(step_s - STEP_S) < _SLACK_S else f"resampled to {STEP_S:g} s"
    yield f"SUMO {metadata.version('eclipse-sumo')}, seed {seed}, its steps of {step_s:g} s {how}"
    yield "positions are front bumpers, as SUMO's: moved back by half a length"
    people = {kind: counts.of(kind) for kind in (Kind.PEDESTRIAN, Kind.CYCLIST) if counts.of(kind)}
    if people:
        told = ", ".join(f"{count} {kind.name.lower()}" for kind, count in people.items())
        yield f"people among them, by kind: {told}"
    if counts.teleports:
        yield f"SUMO teleported {counts.teleports} vehicles: each is a new one where it comes back"
    if counts.jumps:
        yield f"{counts.jumps} jumps no vehicle makes: who jumps is a new vehicle from there on"
    if counts.collisions:
        yield f"SUMO counts {counts.collisions} vehicles in collisions"


def _warnings(log: Path) -> Iterator[str]:
    """Yield what SUMO warned of, in sentences."""
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines() if log.exists() else []
    warned = [line.removeprefix("Warning:").strip() for line in lines if line.startswith("Warning:")]
    for words in warned[:_WARNINGS_TOLD]:
        yield f"SUMO warns: {words}"
    if len(warned) > _WARNINGS_TOLD:
        yield f"SUMO warns {len(warned) - _WARNINGS_TOLD} times more"


def run_sumo(
    source: SumoInput | SumoConfig,
    *,
    slots: int,
    duration_s: float,
    seed: int = 0,
    warm_up_s: float = 0.0,
    people: bool = False,
) -> Iterator[FleetFrame]:
    """Yield a frame every `STEP_S`, from t = 0 at the end of the warm-up.

    Speed and acceleration are SUMO's, those along the lane; heading is the vehicle's angle, which turns in a
    change of lane; the yaw rate is its central difference. Where a configuration has another step, frames are
    those of `modelcast.world.scenario.resampling.resampled`. They end early where a configuration does: at
    its end, or when nobody is left or to come.

    Parameters
    ----------
    source
        Network and routes: `modelcast.io.sumo_roads`, or files of one's own; or a configuration.
    slots
        Number of slots V: as many road users may be there at a time.
    duration_s
        Length of the run [s].
    seed
        SUMO's seed: same seed, same frames.
    warm_up_s
        Driven before t = 0 [s].
    people
        Whether the persons of a configuration are taken, as pedestrians; else they are skipped. Bicycles are
        cyclists in any case.

    Raises
    ------
    MissingExtraError
        Where the extra ``sumo`` is not installed.
    ConfigError
        Where SUMO refuses the input, or there are more road users than slots.
    """
    library = _library()
    users = Users(library, people=people)
    steps = _run_apart(library, users, source, duration_s=duration_s, seed=seed, warm_up_s=warm_up_s)
    frames = resampled(completed(_frames(steps, slots, kinds=isinstance(source, SumoConfig))))
    return takewhile(lambda frame: frame.t_s < duration_s - _SLACK_S, frames)


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


def _frames(steps: Iterator[_At], slots: int, *, kinds: bool) -> Iterator[FleetFrame]:
    """Yield frames at SUMO's own steps, the first at t = 0."""
    seats = FleetSlots(slots)
    start_s = inf
    for found, _ in steps:
        start_s = min(start_s, found.t_s)
        t_s = round(found.t_s - start_s, 6)
        own = (found.kinds, found.widths_m) if kinds else (None, None)
        frame = seats.frame(t_s, found.labels, found.rows, *own)
        if frame is None:
            raise ConfigError(
                f"{len(found.labels)} vehicles at {t_s} s do not fit into {slots} slots: raise slots"
            )
        yield frame


def _run_apart(library: Any, users: Users, source: SumoInput | SumoConfig, **settings: Any) -> Iterator[_At]:
    """Yield what `_run` yields; what SUMO writes goes into a folder of this run, which is removed."""
    with tempfile.TemporaryDirectory(prefix="modelcast-") as folder:
        yield from _run(library, users, source, apart=Path(folder), **settings)


def _run(
    library: Any,
    users: Users,
    source: SumoInput | SumoConfig,
    *,
    duration_s: float,
    seed: int,
    warm_up_s: float,
    apart: Path,
) -> Iterator[_At]:
    """Yield who is on the roads at every step after the warm-up, and SUMO's step [s].

    SUMO puts its prefix of outputs before the last part of a name: one that leads up to the root and down
    into another folder takes there whatever is asked for, wherever that was to be.
    """
    there = apart.resolve()
    away = f"{'../' * _UPWARDS}{there.relative_to(there.anchor).as_posix()}/"
    arguments = [*_arguments(source), "--seed", str(seed), "--no-step-log", "true", "--no-warnings", "true"]
    arguments += ["--output-prefix", away, f"--{_ERROR_LOG}", str(apart / _ERRORS)]
    with _running(library, source, arguments):
        step_s = float(library.simulation.getDeltaT())
        until_s = float(library.simulation.getEndTime())
        until_s = inf if until_s < 0.0 or isinstance(source, SumoInput) else until_s
        first = ceil(warm_up_s / step_s - _SLACK_S)
        # One step beyond the duration: what lies between two steps needs both.
        for step in range(first + ceil(duration_s / step_s - _SLACK_S) + 1):
            if library.simulation.getTime() > until_s - 0.5 * step_s:
                return
            library.simulationStep()
            if step >= first:
                yield users.look(), step_s
            if library.simulation.getMinExpectedNumber() == 0:
                return


@contextlib.contextmanager
def _running(library: Any, source: SumoInput | SumoConfig, arguments: Sequence[str]) -> Generator[None]:
    """SUMO, started and closed.

    Raises
    ------
    ConfigError
        Where it refuses the input, also while it runs.
    """
    try:
        library.start(["sumo", *arguments])
        yield
    except (library.TraCIException, library.FatalTraCIError) as error:
        where = source.path if isinstance(source, SumoConfig) else f"{source.network} with {source.routes}"
        raise ConfigError(f"SUMO refuses {where}: {_complaint(arguments) or error}") from error
    finally:
        if library.isLoaded():
            library.close()


def _arguments(source: SumoInput | SumoConfig) -> Iterator[str]:
    """Yield what SUMO is told to run."""
    if isinstance(source, SumoConfig):
        yield from ("-c", str(source.path), "--random", "false", "--duration-log.disable", "true")
        for option in source.outputs:
            if option != _ERROR_LOG:
                yield from (f"--{option}", os.devnull)
        return
    yield from (
        "-n", str(source.network), "-r", str(source.routes), "--step-length", str(STEP_S),
        "--lateral-resolution", str(_LATERAL_M), "--time-to-teleport", "-1", "--collision.action", "none",
    )  # fmt: skip


def _complaint(arguments: Sequence[str]) -> str:
    """Return what SUMO says to input that it refuses; libsumo prints that and does not tell."""
    home = sumo_home()
    said = subprocess.run(  # noqa: S603 - SUMO's own program
        [str(home / "bin" / "sumo"), *arguments],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "SUMO_HOME": str(home)},
    ).stderr
    lines = [line.strip().removeprefix("Error: ") for line in said.splitlines()]
    return " ".join(line for line in lines if line and not line.startswith("Quitting"))
