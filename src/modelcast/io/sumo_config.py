"""SUMO's configuration files (``.sumocfg``): which files they read, and what they would write.

A configuration is XML: an element an option, its attribute ``value`` the value. Names of files are relative
to the folder of the configuration; several are parted by commas or spaces.
"""

import re
from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from xml.parsers import expat

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.io.regular import read_document

__all__ = ["SUMO_CONFIG", "SumoConfig", "read_sumo_config"]

SUMO_CONFIG = ".sumocfg"
"""How the name of a configuration ends."""

_READ = frozenset(
    {
        *("net-file", "net", "n", "route-files", "routes", "r", "additional-files", "additional", "a"),
        *("weight-files", "weights", "w", "load-state", "device.fcd-replay.file", "device.fcd-replay.files"),
        *("astar.all-distances", "astar.landmark-distances"),
    }
)
_WRITTEN = frozenset(
    {
        *("netstate-dump", "ndump", "netstate", "summary", "tripinfo", "personinfo", "vehroutes"),
        *("personroutes", "person-fcd", "log", "log-file", "l", "message-log", "error-log"),
        *("device.rerouting.output", "device.taxi.idle-algorithm.output"),
        *("device.taxi.dispatch-algorithm.output", "pedestrian.jupedsim.wkt", "pedestrian.jupedsim.py"),
    }
)
"""Options of SUMO 1.28 by which one file is written, under all names, beside those that end in -output."""

_ENDS_AT_ONCE = frozenset({"save-configuration", "save-config", "C", "save-template", "save-schema"})
"""Options by which SUMO writes its own settings and ends."""


@dataclass(frozen=True, slots=True)
class SumoConfig:
    """A configuration of SUMO.

    Parameters
    ----------
    path
        The file.
    inputs
        Files that it names to be read: network, routes, additional files.
    outputs
        Options by which it asks for files to be written.
    """

    path: Path
    _: KW_ONLY
    inputs: tuple[Path, ...] = ()
    outputs: tuple[str, ...] = ()


def read_sumo_config(path: str | Path) -> SumoConfig:
    """Read which files a configuration names; whether they are there, SUMO says when it runs.

    Parameters
    ----------
    path
        The ``.sumocfg``.

    Raises
    ------
    ConfigError
        Where the file cannot be read, names no network, or tells SUMO to write its settings and end.
    DataFormatError
        Where it is no configuration of SUMO, with file and line.
    """
    at = Path(path)
    options = dict(_options(at))
    inputs = [at.parent / name for key, value in options.items() if key in _READ for name in _names(value)]
    outputs = [key for key in options if key.endswith("-output") or key in _WRITTEN]
    ending = sorted(_ENDS_AT_ONCE & options.keys())
    if ending:
        raise ConfigError(
            f"{at}: {ending[0]} ({options[ending[0]]}) makes SUMO write its settings and end: leave it out"
        )
    return SumoConfig(at, inputs=tuple(inputs), outputs=tuple(outputs))


def _names(value: str) -> list[str]:
    """Return the names of a list of files."""
    return [name for name in re.split(r"[,;\s]+", value) if name]


def _options(path: Path) -> Iterator[tuple[str, str]]:
    """Yield the options of a configuration and their values."""
    found: list[tuple[str, str]] = []
    roots: list[str] = []

    def begin(name: str, attributes: dict[str, str]) -> None:
        if not roots:
            roots.append(name)
        value = attributes.get("value", attributes.get("v"))
        if value is not None:
            found.append((name, value))

    parser = expat.ParserCreate()
    parser.StartElementHandler = begin
    try:
        parser.Parse(read_document(path), True)
    except expat.ExpatError as error:
        raise DataFormatError(
            str(path),
            f"is not well-formed XML: {expat.ErrorString(error.code)}",
            row=error.lineno,
            remedy="Check that it is complete.",
        ) from error
    if not roots[0].lower().endswith("configuration"):
        raise DataFormatError(
            str(path),
            f"the root is {roots[0]!r}, not configuration",
            row=1,
            remedy="Give the file that sumo -c takes; a file of --fcd-output is read under another name.",
        )
    if not any(name in _READ for name, _ in found):
        raise ConfigError(f"{path}: a configuration of SUMO names a network (net-file), this one does not")
    yield from found
