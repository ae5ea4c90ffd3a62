"""``modelcast demo``: the main job on an embedded default."""

from pathlib import Path

from modelcast.cli.evaluate_options import EvaluateOptions

__all__ = ["demo"]


def demo(
    *,
    out: Path = Path("out/demo"),
    duration: float = 240.0,
    seed: int = 0,
    quiet: bool = False,
) -> int:
    """Evaluate a generated drive, with GPS and CAN as a sender sees them: no data needed.

    Parameters
    ----------
    out
        Output folder; one that an earlier run wrote is replaced.
    duration
        Length of the drive [s].
    seed
        Seed of the drive and of all losses.
    quiet
        Print nothing but errors.
    """
    from rich.console import Console

    from modelcast.cli.evaluation_run import publish
    from modelcast.core.exceptions import ConfigError
    from modelcast.evaluation.case import SensedTrip
    from modelcast.evaluation.evaluate import evaluate
    from modelcast.io.output import atomic_folder
    from modelcast.report.console import console_report
    from modelcast.simulation.drive import generate_drive

    try:
        drive = generate_drive(seed=seed, duration_s=duration)
    except ValueError as error:
        raise ConfigError(str(error)) from error
    settings = EvaluateOptions(seed=seed).settings()
    with atomic_folder(out) as folder:
        result = evaluate([SensedTrip(drive.truth, drive.input)], settings)
        publish(result, folder)
    if not quiet:
        console = Console()
        console.print(console_report(result))
        console.print(f"report: {out / 'report.html'}", highlight=False, soft_wrap=True)
    return 0
