"""``modelcast safety``: what messages and models are worth to a safety application."""

from pathlib import Path
from typing import TYPE_CHECKING

from modelcast.cli.executor_options import ExecutorOptions
from modelcast.cli.options import Columns, Format, Paths
from modelcast.cli.safety_options import SafetyOptions

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from modelcast.cli.reading import TripSource
    from modelcast.cli.safety_sweep import SafetyWork
    from modelcast.io.loss_logs import LossLog
    from modelcast.io.run_store import RunStore
    from modelcast.io.safety_runs import SafetyCase
    from modelcast.study.safety.result import RecordingScores
    from modelcast.trips.trajectory import Trajectory

__all__ = ["safety"]


def safety(
    *paths: Path,
    out: Path = Path("out/safety"),
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    streams: int = 0,
    options: SafetyOptions = SafetyOptions(),  # noqa: B008 - frozen
    beside: Paths = (),
    where: ExecutorOptions = ExecutorOptions(),  # noqa: B008 - frozen
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Warn of the vehicle ahead by its messages, against the same application with perfect knowledge.

    For example: `modelcast safety platoon.csv --threshold 0.2`

    Every vehicle of a platoon is a host, the one ahead of it the sender. Writes runs/, summary.json,
    pooled.parquet, events.parquet, table.md, report.html, its figures and run.json. Recordings that are
    scored are kept, also where the command was interrupted.

    Parameters
    ----------
    paths
        Files or folders with recorded platoons, or a corpus: trips of several vehicles on one clock.
    out
        Output folder; one that an earlier run of this command wrote is replaced.
    format
        Name of the files' format; found from their content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v,vehicle=id'.
    trip
        Take only trips whose identifier matches this shell pattern.
    streams
        Simulated roads to score instead of recorded platoons: streams of vehicles whose leaders brake hard.
    options
        What changes the figures.
    beside
        Output folders of 'modelcast network' or 'mixed' with --application, or of 'modelcast capacity': their
        figures are shown in the report too.
    where
        Where recordings are scored, also without a corpus.
    json
        Print summary.json instead of tables.
    quiet
        Print nothing but errors.
    """
    from modelcast.cli.all_trips import recorded_paths
    from modelcast.cli.options import parse_columns
    from modelcast.cli.progress import busy, counted
    from modelcast.cli.reading import PARTLY_FAILED, TripSource
    from modelcast.cli.run_record import write_run
    from modelcast.cli.safety_sweep import gathered, run_options, safety_work, score_all
    from modelcast.cli.terminal import say, say_json, show
    from modelcast.core.version import package_version
    from modelcast.io.output import atomic_folder
    from modelcast.io.run_store import run_store
    from modelcast.io.safety import safety_document, write_safety
    from modelcast.io.safety_runs import SafetyRunFiles
    from modelcast.report.safety import safety_console, write_safety_report
    from modelcast.study.safety.pairs import recordings_of
    from modelcast.trips.fingerprint import known_trips

    _require(paths, streams, options, beside)
    candidates, silent = options.candidates(), quiet or json
    for sensor in options.sensors:
        _ = options.settings(sensor, options.burst[0])
    executor = where.executor()
    logs = _logs(options, quiet=silent)
    source = TripSource(paths, format_name=format, columns=parse_columns(columns), pattern=trip)
    with (
        atomic_folder(out, command="safety", shown=f"--out {out}") as folder,
        run_store(out, SafetyRunFiles(package_version(), run_options(options)), command="safety") as store,
    ):
        trips = _trips(source, paths, streams, options.seed, quiet=silent)
        recordings = recordings_of(trips)
        work = safety_work(recordings, options, logs)
        _tell_outdated(store, work, quiet=silent)
        with counted("recordings", quiet=quiet) as progress:
            scores = score_all(work, options, store, executor=executor, progress=progress)
        with busy("pooling", quiet=quiet):
            found = gathered(
                list(scores.values()),
                recordings,
                options,
                logs,
                failures=source.failures,
                skipped=dict(source.skipped),
            )
        store.publish(scores, folder)
        asked = {
            "paths": [str(path) for path in paths],
            "format": format,
            "columns": columns,
            "trip": trip,
            "streams": streams,
            "beside": [str(path) for path in beside],
            "options": options.as_plain(),
        }
        trained_on = frozenset[str]().union(*(one.trained_on or () for one in candidates))
        known = known_trips(trips, trained_on)
        write_run(
            folder,
            "safety",
            asked,
            (*recorded_paths(paths), *options.files, *options.losses),
            training_trips=known,
            foreign=options.foreign,
        )
        with busy("writing the report", quiet=quiet):
            write_safety(found, folder)
            write_safety_report(
                found,
                folder,
                training_trips=known,
                trips=len(trips),
                beside=beside,
                defaults=SafetyOptions().as_plain(),
            )
    if json:
        say_json(safety_document(found))
    elif not quiet:
        show(safety_console(found))
        say(f"report: {out / 'report.html'}")
    return PARTLY_FAILED if found.failures else 0


def _require(paths: "Sequence[Path]", streams: int, options: SafetyOptions, beside: "Sequence[Path]") -> None:
    """Refuse what could not be done to its end."""
    from modelcast.core.exceptions import ConfigError
    from modelcast.core.installed import require_installed
    from modelcast.report.beside import check_beside

    if bool(paths) == (streams > 0) or streams < 0:
        raise ConfigError(
            "name files or folders with recorded platoons, or --streams and how many simulated roads: one of "
            "the two, since a figure that pools both says nothing of either (modelcast safety --help)"
        )
    if not options.sensors or not options.burst or options.per == ():
        raise ConfigError("--sensors, --burst and --per: name at least one each")
    require_installed("modelcast safety", "network")
    check_beside(beside)


def _logs(options: SafetyOptions, *, quiet: bool) -> "list[LossLog]":
    """The logs whose losses are replayed; what each holds is printed."""
    from modelcast.cli.terminal import say
    from modelcast.io.loss_logs import read_loss_logs

    logs = read_loss_logs(options.losses)
    for log in () if quiet else logs:
        say(f"recorded losses: {log.as_text()}")
    return logs


def _tell_outdated(
    store: "RunStore[SafetyCase, RecordingScores]", work: "Iterable[SafetyWork]", *, quiet: bool
) -> None:
    """Say why recordings that were scored before are scored again."""
    from modelcast.cli.terminal import say

    cases = [case for one in work for case, _ in one.cases]
    for line in () if quiet else store.outdated(case for case in cases if store.find(case) is None):
        say(line)


def _trips(
    source: "TripSource", paths: tuple[Path, ...], streams: int, seed: int, *, quiet: bool
) -> "list[Trajectory]":
    """The recorded trips, or those of so many simulated roads."""
    from modelcast.cli.all_trips import all_trips
    from modelcast.cli.progress import counted
    from modelcast.cli.safety_streams import stream_trips

    if streams:
        with counted("roads", quiet=quiet) as progress:
            return stream_trips(streams, seed, progress=progress)
    reason = "the vehicles of a platoon lie in several partitions; its recordings are shared out"
    return all_trips(source, paths, reason, quiet=quiet)
