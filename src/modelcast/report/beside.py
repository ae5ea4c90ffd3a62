"""Figures of other output folders shown in a report: what belongs together is looked at together."""

import shutil
from collections.abc import Sequence
from pathlib import Path

from modelcast.core.cells import escape
from modelcast.core.exceptions import ConfigError
from modelcast.report.figures.files import ENDINGS
from modelcast.report.page import figure

__all__ = ["check_beside", "show_beside"]

_FIGURES = {
    "warnings": "What hosts miss and warn of wrongly with the radio in the loop, and how late they are",
    "warned_map": "Missed and false warnings over the shares of vehicles that send and that read models",
    "penetration": "Tracking errors over the shares of vehicles that send and that read models",
    "capacity": "Vehicles a kilometre up to which hosts keep track",
}


def _there(folder: Path) -> list[str]:
    return [name for name in _FIGURES if (folder / f"{name}.svg").is_file()]


def check_beside(folders: Sequence[Path]) -> None:
    """Refuse folders without any of the figures, before anything runs.

    Parameters
    ----------
    folders
        Output folders of ``modelcast network``, ``mixed`` or ``capacity``.

    Raises
    ------
    ConfigError
        Where one has none of the figures.
    """
    for folder in folders:
        if not _there(folder):
            raise ConfigError(
                f"--beside {folder}: it has none of {', '.join(f'{name}.svg' for name in _FIGURES)}: name "
                "an output folder of modelcast network or mixed with --application, or of modelcast capacity"
            )


def show_beside(folders: Sequence[Path], out: Path) -> list[str]:
    """Copy the figures of some folders beside a report, and return the markup that shows them.

    Parameters
    ----------
    folders
        As for `check_beside`.
    out
        The report's folder.
    """
    found: list[str] = []
    for number, folder in enumerate(folders, start=1):
        found.append(f"<h2>{escape(folder.resolve().name)}</h2>")
        for name in _there(folder):
            for end in ENDINGS:
                if (folder / f"{name}{end}").is_file():
                    shutil.copyfile(folder / f"{name}{end}", out / f"beside_{number}_{name}{end}")
            caption = f"{_FIGURES[name]} ({folder.resolve().name})."
            found.append(figure(f"beside_{number}_{name}.svg", caption))
    return found
