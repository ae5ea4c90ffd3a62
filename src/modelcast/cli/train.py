"""``modelcast train``: what all vehicles share, learned from trips."""

import inspect
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from modelcast.cli.options import Columns, Format

if TYPE_CHECKING:
    from collections.abc import Callable

    from modelcast.models.profile import Profile
    from modelcast.study.training.free_members import FreeMembersSettings
    from modelcast.study.training.learned import LearnedSettings
    from modelcast.study.training.profile import ProfileSettings
    from modelcast.trips.trajectory import Trajectory

__all__ = ["train"]


def train(
    *paths: Path,
    out: Path = Path("profile.json"),
    bank: str | None = None,
    validate: bool = False,
    hidden: Annotated[tuple[int, int], Parameter(consume_multiple=True)] = (96, 96),
    coefficients: int = 3,
    steps: int | None = None,
    windows: int | None = None,
    regimes: int = 3,
    modes: int = 4,
    also: Annotated[tuple[str, ...], Parameter(consume_multiple=True)] = (),
    add: Annotated[tuple[str, ...], Parameter(consume_multiple=True)] = (),
    profile: Path | None = None,
    seed: int = 0,
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Train a profile: the sub-models of its bank, calibrations, and how often each would speak.

    For example: `modelcast train monday.csv tuesday.csv --out mine.json`

    The bank is free-predictive, which states in a plain message what predicts longest, and free, where not
    said otherwise. The file is canonical JSON; its SHA-256 is the profile's identity. Use it with --bank
    FILE. Needs the extra train (JAX and optax). The same trips, options and package versions give the same
    bytes.

    Parameters
    ----------
    paths
        Files or folders with recorded trips to learn from, or a corpus.
    out
        The profile's file; its folder must exist.
    bank
        Members of the bank in order, joined by '+', among free, free-predictive, free-context, learned,
        gp-vehicle, gp-derivative, gp-trained, shs, hdp-hmm, gp-regime-1 and so on, ctra, ctrv, ca and cv;
        their families are trained; what other packages register joins as it is, as NAME or
        NAME:KEY=VALUE,KEY=VALUE. Where not given, with
        --validate chosen among what is trained, but for free-context, gp-trained, shs, hdp-hmm and the
        regimes', by the messages they save; else free-predictive and free. cv joins as guard.
    validate
        Train once more without each route and count messages there: the record then holds honest figures, and
        the bank's members follow from them. Takes that many times longer.
    hidden
        Sizes of the networks' two hidden layers.
    coefficients
        Coefficients of the learned path on each axis: its payload is twice as many numbers.
    steps
        Batches each network is trained on; where not given, 1000 for the free sub-models, 2500 for learned.
    windows
        Windows of the trips that networks learn from: for the free sub-models of every kind of sender (24,000
        where not given), for learned in all (150,000 for each range of noise).
    regimes
        Driving regimes that get a Gaussian process of their own, for the bank 'regimes'; 0 for none.
    modes
        Linear modes of the stochastic hybrid system, shs, 1 to 10; those of hdp-hmm are found, up to 10. 0
        for neither.
    also
        Families to train beside those the bank names, for banks of one's own: free, learned, processes (the
        gp- ones) and switching (shs and hdp-hmm).
    add
        Train these sub-models alone, of free, shs and hdp-hmm, and write --profile with them beside its
        others, which stay as they are. free stands for the three that plain messages carry: free,
        free-predictive and free-context. Options of a full training (bank, also, validate, coefficients,
        regimes) are refused beside it; --hidden, --steps and --windows are for free, and --modes 0 is
        refused beside shs and hdp-hmm.
    profile
        With --add, the profile that it adds to; the shipped one where not given. Without, a profile whose
        sub-models of other families go to the new one's shelf as they are; none where not given.
    seed
        Seed of all random numbers.
    format
        Name of the files' format; found from their content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v'; other units
        have meanings of their own, as east_ft, speed_kmh, speed_mph and speed_kn (docs/formats.md).
    trip
        Take only trips whose identifier matches this shell pattern.
    json
        Print the training record instead of a table; what was added later is under added.
    quiet
        Print nothing but errors.
    """
    from modelcast.cli.all_trips import all_trips
    from modelcast.cli.options import parse_columns
    from modelcast.cli.progress import staged
    from modelcast.cli.reading import TripSource, require_paths
    from modelcast.cli.terminal import say, say_json, show
    from modelcast.core.exceptions import ConfigError
    from modelcast.core.installed import require_installed
    from modelcast.io.output import atomic_file
    from modelcast.report.training import training_report
    from modelcast.station.banks import parts_of
    from modelcast.study.training.processes import ProcessSettings
    from modelcast.study.training.profile import ProfileSettings
    from modelcast.study.training.switching import FitSettings, SwitchingSettings

    require_paths(paths, "train")
    if not (bank or add):
        require_installed("modelcast train", "train")
    _require_addable(
        add,
        modes,
        bank=bank,
        also=also,
        validate=validate,
        coefficients=coefficients,
        regimes=regimes,
        **({} if "free" in add else {"hidden": hidden, "steps": steps, "windows": windows}),
    )
    source = TripSource(paths, format_name=format, columns=parse_columns(columns), pattern=trip)
    silent = quiet or json
    try:
        names = tuple(parts_of(bank)) if bank else ()
        _require_trainable(names)
        learned, free = _networks(hidden, steps, windows, coefficients)
        settings = ProfileSettings(
            learned,
            free=free,
            processes=ProcessSettings(regimes=regimes),
            switching=SwitchingSettings(FitSettings(modes)) if modes else None,
            names=names,
            also=also,
            validate=validate,
            seed=seed,
        )
        with atomic_file(out, inputs=paths, shown=f"--out {out}") as file:
            trips = all_trips(source, paths, "one fit is made to all of them", quiet=silent)
            if not trips:
                raise ConfigError("no usable trip")
            with staged(quiet=quiet) as progress:
                trained = _trained(profile, trips, add, settings, progress)
            file.write(trained.text.encode("utf-8"))
    except ValueError as error:
        raise ConfigError(str(error)) from error
    if json:
        added = {"added": trained.added_record} if trained.added_record else {}
        document = {"profile": str(out), "sha256": trained.identity, **trained.record, **added}
        say_json(document)
    elif not quiet:
        show(training_report(trained))
        say(f"profile: {out}, sha256 {trained.identity}")
        source.tell_skipped()
    return source.exit_code


def _networks(
    hidden: tuple[int, int], steps: int | None, windows: int | None, coefficients: int
) -> "tuple[LearnedSettings, FreeMembersSettings]":
    """How the networks of both families are trained."""
    from modelcast.study.training.descent import Descent
    from modelcast.study.training.free import FREE_STEPS, FreeSettings
    from modelcast.study.training.free_members import FreeMembersSettings
    from modelcast.study.training.learned import LearnedSettings

    long, brief = (
        Descent(hidden=hidden, steps=own if steps is None else steps) for own in (Descent().steps, FREE_STEPS)
    )
    learned = LearnedSettings(coefficients=coefficients, descent=long)
    free = FreeMembersSettings(FreeSettings(descent=brief))
    if windows is None:
        return learned, free
    return replace(learned, rows=windows), replace(free, rows=windows)


def _trained(
    given: Path | None,
    trips: "list[Trajectory]",
    add: tuple[str, ...],
    settings: "ProfileSettings",
    progress: "Callable[[str, int, int], None]",
) -> "Profile":
    """Train a profile, or what --add names."""
    from modelcast.cli.banks import profile_in_use
    from modelcast.study.training.profile import train_profile

    if add:
        return _added(profile_in_use(given), trips, add, settings, progress)
    beside = None if given is None else profile_in_use(given)
    return train_profile(trips, settings, beside=beside, progress=progress)


def _added(
    profile: "Profile",
    trips: "list[Trajectory]",
    add: tuple[str, ...],
    settings: "ProfileSettings",
    progress: "Callable[[str, int, int], None]",
) -> "Profile":
    """Train what --add names, and add it."""
    from modelcast.study.training.free_members import add_free
    from modelcast.study.training.switching import add_switching

    switching = tuple(name for name in add if name != "free")
    if switching:
        profile = add_switching(
            profile, trips, settings.switching, names=switching, seed=settings.seed, progress=progress
        )
    if "free" in add:
        free = replace(settings.free, free=replace(settings.free.free, seed=settings.seed))
        profile = add_free(profile, trips, free, progress=progress)
    return profile


def _require_addable(add: tuple[str, ...], modes: int, **unused: object) -> None:
    """Refuse beside --add what it leaves unused and is not at its default."""
    from modelcast.core.exceptions import ConfigError

    if not add:
        return
    if modes == 0 and set(add) != {"free"}:
        raise ConfigError("--modes 0 trains neither shs nor hdp-hmm: leave it out, or leave out --add")
    defaults = inspect.signature(train).parameters
    for name, value in unused.items():
        if value != defaults[name].default:
            raise ConfigError(f"--{name} is for a full training: --add trains {', '.join(add)} alone")


def _require_trainable(names: tuple[str, ...]) -> None:
    """Refuse members before hours of training that no profile could hold."""
    from modelcast.cli.banks import profile_in_use
    from modelcast.core.near_names import near
    from modelcast.models.sub_models import names_registered
    from modelcast.station.banks import member_names
    from modelcast.study.training.profile import MOST_NAMES

    known = member_names(profile_in_use(None))
    unknown = [
        name
        for name in names
        if name not in known and not name.startswith("gp-regime-") and not names_registered(name)
    ]
    if unknown:
        meant = near(unknown[0], known)
        raise ValueError(f"--bank: no sub-model is named {unknown[0]}{meant}; there are {', '.join(known)}")
    if len(names) > MOST_NAMES:
        raise ValueError(f"--bank names at most {MOST_NAMES} sub-models, got {len(names)}")
