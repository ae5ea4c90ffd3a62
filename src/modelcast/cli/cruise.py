"""``modelcast cruise``: platoons that drive by what they hear."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from modelcast.cli.options import Columns, Count, Format, Numbers, Words

if TYPE_CHECKING:
    from modelcast.apps.cruise.base import AbstractCruiseLaw
    from modelcast.world.platoon.leaders import AbstractLeader

__all__ = ["cruise"]


def cruise(
    *,
    out: Path = Path("out/cruise"),
    leader: str = "sinusoid",
    speed: float = 100.0,
    deceleration: float = 3.0,
    law: Literal["path", "ploeg", "acc"] = "path",
    ranging: Annotated[bool, Parameter(negative="--no-ranging")] = True,
    policy: Words = ("bsm-10hz", "baseline", "free", "mbc", "j2945", "j2945-mbc"),
    threshold: Numbers = (0.2,),
    keep_alive: float = 1.0,
    approach: float = 0.0,
    budget: float = 4.0 / 3.0,
    bank: str = "default",
    profile: str | None = None,
    loss: Numbers = (0.0, 0.2, 0.4, 0.6, 0.8, 0.9),
    burst: Numbers = (0.0,),
    vehicles: int = 8,
    seeds: Count = 8,
    seed: Count = 0,
    duration: float = 60.0,
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Drive platoons by cooperative adaptive cruise control, in a closed loop with what they hear.

    For example: `modelcast cruise --leader braking --loss 0 0.4`

    What followers believe of the vehicle ahead and of the leader drives them, and what they drive is what
    they say next. Counts how a disturbance grows along the platoon, the least gap, collisions, comfort,
    messages and airtime, against loss. Writes summary.json, runs.parquet, table.md and the figure
    cruise as PNG, SVG and PDF.

    Parameters
    ----------
    out
        Output folder; one that an earlier run of this command wrote is replaced.
    leader
        What the leaders drive: sinusoid (0.2 Hz, 5 km/h), braking, steady, or a file with a recorded trip
        whose speed they drive.
    speed
        Mean speed of sinusoid, braking and steady [km/h].
    deceleration
        Of braking [m/s²].
    law
        path (constant spacing of 5 m, after Rajamani), ploeg (headway 0.5 s), acc (headway 1.2 s, no radio).
    ranging
        An on-board sensor shows gap and speed of the vehicle ahead; without it all is by radio.
    policy
        Senders as in 'modelcast network', several after one another; also bsm-Nhz and free-Nhz, N messages a
        second by the clock.
    threshold
        Tracking errors that call for messages of baseline, free and mbc, several after one another [m].
    keep_alive
        Longest silence of these [s].
    approach
        Way that two vehicles may come closer between two messages of these [m]; 0 for none.
    budget
        Messages that free and mbc aim at under loss, over those of a channel without losses.
    bank
        Sub-models of mbc and j2945-mbc, as in 'modelcast evaluate'.
    profile
        File of the profile in use, as in 'modelcast evaluate'.
    loss
        Shares of messages lost, several after one another.
    burst
        Mean times for which a link is gone, several after one another [s]; 0 for independent losses.
    vehicles
        Vehicles of a platoon, the leader among them.
    seeds
        Platoons driven, each with its own chance.
    seed
        Seed of all random numbers.
    duration
        Time driven [s]; disturbances begin after 5 s.
    format
        Name of the format of the leader's file; found from its content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v'; other units
        have meanings of their own, as east_ft, speed_kmh, speed_mph and speed_kn (docs/formats.md).
    trip
        Take the first trip of the leader's file whose identifier matches this shell pattern.
    json
        Print summary.json instead of the table.
    quiet
        Print nothing but errors.
    """
    import sys

    from modelcast.cli.banks import bank_in_use, profile_in_use
    from modelcast.cli.progress import busy, counted
    from modelcast.cli.terminal import say, show
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.cruise import write_cruise
    from modelcast.io.output import atomic_folder
    from modelcast.report.cruise import cruise_lines, cruise_report
    from modelcast.report.figures.cruise import plot_cruise
    from modelcast.report.figures.files import drawn, write_drawings
    from modelcast.report.style import style
    from modelcast.runtime.platoon.drive import DriveSettings
    from modelcast.study.cruise.run import run_cruise
    from modelcast.study.cruise.settings import CruiseSettings, Loss

    options: dict[str, Any] = {
        "leader": Path(leader).name, "speed": speed, "deceleration": deceleration, "law": law,
        "ranging": ranging, "policy": list(policy), "threshold": list(threshold), "keep_alive": keep_alive,
        "approach": approach, "budget": budget, "bank": bank, "loss": list(loss), "burst": list(burst),
        "vehicles": vehicles, "seeds": seeds, "seed": seed, "duration": duration, "trip": trip,
    }  # fmt: skip
    try:
        named = bank_in_use(bank, profile=profile_in_use(profile)).bank
        leads = _leader(
            leader,
            speed_mps=speed / 3.6,
            deceleration_mps2=deceleration,
            format_name=format,
            columns=columns,
            pattern=trip,
        )
        settings = CruiseSettings(
            senders=tuple(policy),
            thresholds_m=tuple(threshold),
            losses=tuple(
                dict.fromkeys(Loss(ratio, gone if ratio else 0.0) for gone in burst for ratio in loss)
            ),
            platoons=seeds,
            vehicles=vehicles,
            leader=leads,
            law=_law(law),
            drive=DriveSettings(duration_s=duration, ranging=ranging),
            keep_alive_s=keep_alive,
            approach_m=approach or float("inf"),
            budget=budget,
            seed=seed,
        )
        with atomic_folder(out, command="cruise", shown=f"--out {out}") as folder:
            with counted("runs", quiet=quiet) as progress:
                result = run_cruise(settings, bank=named, progress=progress)
            summary, _ = write_cruise(result, folder, options=options)
            text = summary.read_text(encoding="utf-8")
            lines = "\n".join(cruise_lines(result.rows))
            (folder / "table.md").write_text(lines + "\n", encoding="utf-8", newline="\n")
            with busy("drawing", quiet=quiet), style():
                write_drawings([drawn("cruise", plot_cruise(result))], folder)
    except ValueError as error:
        raise ConfigError(str(error)) from error
    if json:
        sys.stdout.write(text)
    elif not quiet:
        show(cruise_report(result))
        say(f"figure: {out}/cruise.png")
    return 0


def _law(name: str) -> "AbstractCruiseLaw":
    from modelcast.apps.cruise.acc import Acc
    from modelcast.apps.cruise.path import PathCacc
    from modelcast.apps.cruise.ploeg import Ploeg

    laws: dict[str, type[AbstractCruiseLaw]] = {one.name: one for one in (PathCacc, Ploeg, Acc)}
    return laws[name]()


def _leader(
    name: str,
    *,
    speed_mps: float,
    deceleration_mps2: float,
    format_name: str | None,
    columns: str | None,
    pattern: str,
) -> "AbstractLeader":
    """The leader of that name, or the first trip of a file of it."""
    from modelcast.cli.options import parse_columns
    from modelcast.cli.reading import TripSource
    from modelcast.core.exceptions import ConfigError
    from modelcast.world.platoon.leaders import Braking, Sinusoid, Steady, recorded_leader

    if name == "sinusoid":
        return Sinusoid(speed_mps)
    if name == "braking":
        return Braking(speed_mps, deceleration_mps2)
    if name == "steady":
        return Steady(speed_mps)
    if not Path(name).exists():
        raise ConfigError(f"--leader must be sinusoid, braking, steady, or a file with a trip, got {name!r}")
    source = TripSource(
        [Path(name)], format_name=format_name, columns=parse_columns(columns), pattern=pattern
    )
    found = next(iter(source), None)
    if found is None:
        raise ConfigError(f"--leader {name}: no usable trip matches {pattern!r}")
    return recorded_leader(found)
