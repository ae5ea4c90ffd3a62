"""``modelcast evaluate``: the main job."""

from pathlib import Path

from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.cli.executor_options import ExecutorOptions
from modelcast.cli.options import Columns, Format, Rate

__all__ = ["evaluate"]


def evaluate(
    *paths: Path,
    out: Path = Path("out/evaluate"),
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    rate: Rate = None,
    options: EvaluateOptions = EvaluateOptions(),  # noqa: B008 - frozen
    executor: ExecutorOptions = ExecutorOptions(),  # noqa: B008 - frozen
    trace: Path | None = None,
    rerun: Path | None = None,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Run hybrid bank and baseline over recorded trips: message rates, tracking under loss, figures.

    For example: `modelcast evaluate drive.csv --out out/mine --threshold 0.2 0.5`

    Writes summary.json, events.parquet, samples.parquet, report.html, figures/ and run.json. A corpus
    ('modelcast ingest'), named alone, is shared out among processes; its tables are in parts/. A run of one
    that was interrupted goes on where it stopped: give the same command again.

    Parameters
    ----------
    paths
        Files or folders with recorded trips, or one corpus.
    out
        Output folder; one that an earlier run of this command wrote is replaced.
    format
        Name of the files' format; found from their content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v'; other units
        have meanings of their own, as east_ft, speed_kmh, speed_mph and speed_kn (docs/formats.md).
    trip
        Take only trips whose identifier matches this shell pattern.
    rate
        Take trips as read so many times a second, from no later sample [Hz]; as recorded where not given.
    options
        What changes the figures.
    executor
        Where a corpus is worked on.
    trace
        Also write the messages (time, vehicle, size, kind) to this .csv or .parquet, for other simulators.
    rerun
        Repeat the run that this run.json describes; it names the trips and options.
    json
        Print summary.json instead of tables.
    quiet
        Print nothing but errors.
    """
    from modelcast.cli.evaluation_corpus import corpus_to_share, run_corpus_evaluation
    from modelcast.cli.evaluation_run import run_evaluation
    from modelcast.cli.reading import require_paths
    from modelcast.cli.run_record import EvaluationRun, load_run
    from modelcast.core.exceptions import ConfigError

    if rerun is not None:
        if paths or format or columns or trip != "*" or rate is not None or options != EvaluateOptions():
            raise ConfigError(
                "--rerun takes trips and options from run.json: only --out, --trace, --json and --quiet go "
                "with it"
            )
        asked = load_run(rerun)
    else:
        require_paths(paths, "evaluate")
        asked = EvaluationRun(paths, format, columns, trip, options, rate)
    corpus = corpus_to_share(asked, executor)
    if corpus is not None:
        if trace is not None:
            raise ConfigError(f"--trace {trace}: of a corpus the messages are in parts/*/events.parquet")
        return run_corpus_evaluation(asked, corpus, out, executor, json=json, quiet=quiet)
    if executor.jobs > 1:
        raise ConfigError(
            f"--jobs {executor.jobs} is for a corpus: modelcast ingest makes one of these files"
        )
    return run_evaluation(asked, out, trace=trace, json=json, quiet=quiet)
