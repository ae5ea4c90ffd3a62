"""What a bank that reads context is let know, as users name it."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from modelcast.runtime.trip.context import ContextSettings

__all__ = ["context_settings", "road_files"]

_WORDS = ("own", "none")


def road_files(road: str) -> tuple[Path, ...]:
    """The road file, where ``--road`` names one.

    Parameters
    ----------
    road
        As users name it.
    """
    return () if road in _WORDS else (Path(road),)


def context_settings(road: str, *, leader: bool) -> "ContextSettings":
    """The settings that ``--road`` and ``--leader`` mean.

    Parameters
    ----------
    road
        ``own``, ``none`` or a road file.
    leader
        Whether the vehicle ahead is known.

    Raises
    ------
    ConfigError
        Where there is no such file.
    DataFormatError
        Where it is no road file.
    """
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.road import read_roads
    from modelcast.runtime.trip.context import ContextSettings

    if road == "own" or road == "none":  # noqa: PLR1714 - the type checker follows these
        return ContextSettings(road, leader)
    if not Path(road).is_file():
        raise ConfigError(f"--road: '{road}' is neither own nor none nor a road file")
    return ContextSettings(read_roads(road), leader)
