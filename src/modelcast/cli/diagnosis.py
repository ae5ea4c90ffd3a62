"""What ``modelcast doctor`` finds, as plain values, and what is wrong with it."""

import json
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, cast

from modelcast.cli.installation import (
    InstalledPackage,
    checkout,
    extra_packages,
    required_packages,
    source_version,
    stale_remedy,
)
from modelcast.cli.kernel_cache import kernel_cache
from modelcast.core.extras import EXTRAS, install_command
from modelcast.core.version import package_version

__all__ = ["Problem", "diagnose"]

_FOLDERS = {
    "MODELCAST_DATA": "the real trips that tests and benchmarks read",
    "MODELCAST_REFERENCE": "the reference figures that make validate reads",
}
_VARIABLES = (
    "MODELCAST_REQUIRE_DATA",
    "MODELCAST_NS3_PYTHON",
    "MODELCAST_CACHE_DIR",
    "NUMBA_CPU_NAME",
    "NUMBA_DISABLE_JIT",
    "SUMO_HOME",
)
_ENCODINGS = frozenset({"utf-8", "utf8"})


@dataclass(frozen=True, slots=True)
class Problem:
    """Something that is broken.

    Parameters
    ----------
    what
        What is broken.
    remedy
        What to do about it, in a line.
    """

    what: str
    remedy: str


def diagnose() -> tuple[dict[str, Any], list[Problem]]:
    """Look at the installation and return what was found, as plain values, and what is broken.

    An extra that is missing is no problem; one that is there and too old or faulty is.
    """
    required, extras = required_packages(), extra_packages()
    problems = [
        *_stale_problems(package_version(), checkout()),
        *_package_problems(required),
        *_extra_problems(extras.items()),
    ]
    document: dict[str, Any] = {
        "modelcast": {
            "version": package_version(),
            "source_version": source_version(checkout()),
            "place": str(Path(__file__).resolve().parent.parent),
            "python": platform.python_version(),
            "interpreter": sys.executable,
            "system": platform.platform(),
        },
        "packages": {one.name: one.installed for one in required},
        "processor": _processor(broken=any(one.name == "numba" and one.problem for one in required)),
        "extras": {
            name: {
                "installed": {one.name: one.installed for one in packages},
                "present": not any(one.problem for one in packages),
                "needed_by": EXTRAS[name].needed_by,
                "install": install_command(one.name for one in packages if one.problem),
            }
            for name, packages in extras.items()
        },
        "variables": {name: os.environ.get(name) for name in (*_FOLDERS, *_VARIABLES)},
        "terminal": {
            "terminal": sys.stdout.isatty(),
            "encoding": sys.stdout.encoding,
            "TERM": os.environ.get("TERM"),
            "NO_COLOR": os.environ.get("NO_COLOR"),
        },
    }
    document["brought"], broken = _brought()
    problems += broken
    document["cache"], found = _cache()
    problems += [*found, *_profile_problems(), *_folder_problems(), *_terminal_problems()]
    return {**document, "problems": [asdict(one) for one in problems]}, problems


def _stale_problems(installed: str, folder: Path | None) -> list[Problem]:
    """Whether the checkout that runs is another version than what was installed of it.

    The sources run either way; what the installation states of them (version, packages needed) is old.
    """
    source = source_version(folder)
    if folder is None or source in {None, installed}:
        return []
    return [Problem(f"modelcast is installed as {installed}, its source is {source}", stale_remedy(folder))]


def _package_problems(required: Sequence[InstalledPackage]) -> list[Problem]:
    if not required:
        return [Problem("modelcast is not installed", "install it: pip install . in its folder")]
    return [
        Problem(f"{one.name} {one.problem}", install_command([_enough(one)], upgrade=True))
        for one in required
        if one.problem
    ]


def _extra_problems(extras: Any) -> list[Problem]:
    return [
        Problem(f"{one.name} (extra {name}) {one.problem}", install_command([_enough(one)], upgrade=True))
        for name, packages in extras
        for one in packages
        if one.installed is not None and one.problem
    ]


def _enough(package: InstalledPackage) -> str:
    """The package in a version that is enough, as a requirement."""
    return f"{package.name}>={package.least}" if package.least else package.name


def _brought() -> tuple[list[dict[str, str]], list[Problem]]:
    """What other packages bring; nothing where what it takes to load them is broken."""
    try:
        from modelcast.cli.brought import brought

        found = list(brought())
    except ImportError as error:
        return [], [Problem(f"what other packages bring: {error}", "mend what is named above")]
    remedy = "mend or uninstall"
    broken = [Problem(one.problem, f"{remedy} {one.package}") for one in found if one.problem]
    return [asdict(one) for one in found], broken


def _processor(*, broken: bool) -> dict[str, Any]:
    """What compiled code is made for, and the cores this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    cores = len(affinity(0)) if affinity is not None else os.cpu_count()
    found: dict[str, Any] = {"machine": platform.machine(), "cores": cores, "name": None, "features": []}
    if not broken:
        from llvmlite import binding

        features = cast("dict[str, bool]", binding.get_host_cpu_features())
        found["name"] = binding.get_host_cpu_name()
        found["features"] = sorted(name for name, has in features.items() if has)
    return found


def _cache() -> tuple[dict[str, Any] | None, list[Problem]]:
    try:
        cache = kernel_cache()
    except (ImportError, OSError) as error:
        return None, [Problem(f"the cache of compiled code: {error}", "mend what is named above")]
    found = {"place": str(cache.place), "size_bytes": cache.size_bytes, "writable": cache.writable}
    if cache.writable:
        return found, []
    remedy = "set MODELCAST_CACHE_DIR to a folder that can be written to; until then every run compiles anew"
    return found, [Problem(f"compiled code cannot be kept in {cache.place}", remedy)]


def _profile_problems() -> list[Problem]:
    """Whether the profile that ships with modelcast is there and whole; nothing is compiled for that."""
    try:
        json.loads((files("modelcast") / "profiles" / "default.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        return [
            Problem(
                f"the profile that ships with modelcast cannot be read: {error}",
                "install modelcast anew: pip install --force-reinstall --no-deps . in its folder",
            )
        ]
    return []


def _folder_problems() -> list[Problem]:
    return [
        Problem(
            f"{name} names {os.environ[name]}, which is no folder", f"name the folder of {what}, or unset it"
        )
        for name, what in _FOLDERS.items()
        if os.environ.get(name) and not Path(os.environ[name]).is_dir()
    ]


def _terminal_problems() -> list[Problem]:
    encoding = sys.stdout.encoding
    if encoding.lower() in _ENCODINGS:
        return []
    return [Problem(f"the output is written as {encoding}: tables lose their signs", "set PYTHONUTF8=1")]
