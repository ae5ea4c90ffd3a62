"""``modelcast coverage``: how honest the covariances are on trips they were not learnt from."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from modelcast.cli.options import Columns, Count, Format

if TYPE_CHECKING:
    from modelcast.cli.reading import TripSource
    from modelcast.study.case import TripCase
    from modelcast.study.settings import EvaluationSettings

__all__ = ["coverage"]


def coverage(
    *paths: Path,
    out: Path = Path("out/coverage"),
    train: Annotated[tuple[Path, ...], Parameter(consume_multiple=True, negative="")] = (),
    bank: str = "cv+ctrv+ctra+gp-intercept",
    profile: str | None = None,
    start: Literal["order", "hindsight"] | None = None,
    noise_floor: float | None = None,
    trusted_horizon: float = 0.0,
    protocol: Literal["auto", "recorded", "sensor"] = "auto",
    threshold: Annotated[tuple[float, ...], Parameter(consume_multiple=True, negative="")] = (0.2, 0.5),
    seed: Count = 0,
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Calibrate each sub-model's covariance, and count errors of other trips inside its ellipses.

    For example: `modelcast coverage monday.csv tuesday.csv`

    Every file is tested with what the other files taught, or all with what --train taught. A bank that starts
    in hindsight, as default and regimes do, is counted as a hybrid too. Writes coverage.json and
    the figures coverage and times as PNG, SVG and PDF.

    Parameters
    ----------
    paths
        Files or folders with recorded trips to test on.
    out
        Output folder; one that an earlier run of this command wrote is replaced.
    train
        Files to learn from instead; put the tested trips before this option.
    bank
        Sub-models, joined by '+', as in 'modelcast evaluate'; 'default' and a profile's file stand for the
        members of their banks.
    profile
        File of the profile in use, as in 'modelcast evaluate'.
    start
        Count the sub-models together too: at each instant the one that an update would start with, the first
        in order or the one that did best (hindsight); the bank's own rule where not given.
    noise_floor
        Smallest position noise a Gaussian process may assume [m].
    trusted_horizon
        Age beyond which sub-models are damped [s]; 0 for never.
    protocol
        As in 'modelcast evaluate'.
    threshold
        Tracking errors that end the times compared [m].
    seed
        Seed of the sensor noise.
    format
        Name of the files' format; found from their content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v'; other units
        have meanings of their own, as east_ft, speed_kmh, speed_mph and speed_kn (docs/formats.md).
    trip
        Take only trips whose identifier matches this shell pattern.
    json
        Print coverage.json instead of tables.
    quiet
        Print nothing but errors.
    """
    import sys

    from modelcast.cli.banks import bank_in_use, profile_in_use
    from modelcast.cli.options import parse_columns
    from modelcast.cli.progress import busy, counted
    from modelcast.cli.reading import TripSource, require_paths
    from modelcast.cli.terminal import say, show
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.coverage import coverage_document, write_coverage
    from modelcast.io.output import atomic_folder
    from modelcast.report.coverage import coverage_report, write_coverage_figures
    from modelcast.report.training_trips import training_note
    from modelcast.station.policy.guard import unguarded
    from modelcast.study.coverage import Hybrid, measure_coverage
    from modelcast.study.settings import EvaluationSettings
    from modelcast.trips.fingerprint import known_trips

    require_paths(paths, "coverage")
    named = bank_in_use(
        bank,
        noise_floor_m=noise_floor,
        trusted_horizon_s=trusted_horizon or None,
        profile=profile_in_use(profile),
    )
    members = named.bank.members
    rule = start or ("hindsight" if unguarded(named.start) == "hindsight" else None)
    hybrid = Hybrid(named.bank.name, rule) if rule and len(members) > 1 else None
    names = parse_columns(columns)
    tested = TripSource(paths, format_name=format, columns=names, pattern=trip)
    taught = TripSource(train, format_name=format, columns=names)
    try:
        settings = EvaluationSettings(tuple(threshold), protocol=protocol, seed=seed)
        with atomic_folder(out, command="coverage", shown=f"--out {out}") as folder:
            groups = _cases(tested, settings, quiet=quiet or json)
            training = _cases(taught, settings, quiet=quiet or json) if train else {}
            with counted("trips", quiet=quiet) as progress:
                result = measure_coverage(
                    groups,
                    members,
                    train=[case for cases in training.values() for case in cases],
                    thresholds_m=settings.thresholds_m,
                    hybrid=hybrid,
                    progress=progress,
                )
            judged = [case.recorded for cases in groups.values() for case in cases]
            known = known_trips(judged, named.trained_on)
            document = coverage_document(
                result,
                protocol=protocol,
                bank=bank,
                tested={name: [case.truth.trip_id for case in cases] for name, cases in groups.items()},
                failures={**tested.failures, **taught.failures},
                training_trips=known,
            )
            path = write_coverage(document, folder)
            text = path.read_text(encoding="utf-8")
            with busy("drawing", quiet=quiet):
                write_coverage_figures(result, folder)
    except ValueError as error:
        raise ConfigError(str(error)) from error
    if json:
        sys.stdout.write(text)
    elif not quiet:
        for line in training_note(known, len(judged)):
            say(line)
        show(coverage_report(result))
        say(f"figures: {out}")
        for source in (tested, taught):
            source.tell_skipped()
    return max(tested.exit_code, taught.exit_code)


def _cases(
    source: "TripSource", settings: "EvaluationSettings", *, quiet: bool
) -> dict[str, list["TripCase"]]:
    """The trips made ready, by the first part of their identifier: the file, unless a table names trips."""
    from modelcast.cli.progress import watched
    from modelcast.core.exceptions import ConfigError
    from modelcast.study.case import make_case

    groups: dict[str, list[TripCase]] = {}
    with watched(source, quiet=quiet) as trips:
        for one in trips:
            groups.setdefault(one.trip_id.partition("/")[0], []).append(make_case(one, settings))
    if not groups:
        raise ConfigError("no usable trip")
    return groups
