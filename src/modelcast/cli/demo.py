"""``modelcast demo``: the main job on an embedded default."""

from pathlib import Path

from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.cli.options import Count

__all__ = ["demo"]


def demo(
    *,
    out: Path = Path("out/demo"),
    duration: float = 240.0,
    seed: Count = 0,
    trips: Path | None = None,
    quiet: bool = False,
) -> int:
    """Evaluate a generated drive, with GPS and CAN as a sender sees them: no data needed.

    For example: `modelcast demo --out out/demo`

    With --trips: evaluate nothing, and write six drives as CSV files instead, to try other commands on.

    Parameters
    ----------
    out
        Output folder; one that an earlier run of this command wrote is replaced.
    duration
        Length of the drive [s].
    seed
        Seed of the drive and of all losses.
    trips
        Folder for six drives, each as its receiver and its vehicle bus recorded it, of --duration and of
        seeds from --seed on; one that an earlier run wrote is replaced.
    quiet
        Print nothing but errors.
    """
    from dataclasses import replace

    from modelcast.cli.evaluation_run import publish, show
    from modelcast.cli.progress import busy
    from modelcast.cli.run_record import write_run
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.output import atomic_folder
    from modelcast.study.case import SensedTrip
    from modelcast.study.evaluate import evaluate
    from modelcast.world.drive import generate_drive

    if trips is not None:
        return _drives(trips, duration, seed, quiet=quiet)
    try:
        with busy("generating a drive", quiet=quiet):
            drive = generate_drive(seed=seed, duration_s=duration)
    except ValueError as error:
        raise ConfigError(str(error)) from error
    settings = replace(EvaluateOptions(seed=seed).settings(), protocol="sensor", sensor=drive.sensor)
    with atomic_folder(out, command="demo", shown=f"--out {out}") as folder:
        with busy("evaluating a generated drive", quiet=quiet):
            result = evaluate([SensedTrip(drive.truth, drive.input)], settings)
        write_run(folder, "demo", {"duration": duration, "seed": seed})
        with busy("writing the report", quiet=quiet):
            publish(result, folder)
    if not quiet:
        show(result, out)
    return 0


def _drives(out: Path, duration_s: float, seed: int, *, quiet: bool) -> int:
    from modelcast.cli.demo_trips import write_drives
    from modelcast.cli.progress import busy
    from modelcast.cli.terminal import say
    from modelcast.core.exceptions import ConfigError

    try:
        with busy("generating drives", quiet=quiet):
            names = write_drives(out, duration_s=duration_s, seed=seed, shown=f"--trips {out}")
    except ValueError as error:
        raise ConfigError(str(error)) from error
    if not quiet:
        say(f"{len(names)} generated drives of {duration_s:g} s in {out}: {names[0]} to {names[-1]}")
    return 0
