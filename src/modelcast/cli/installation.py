"""What ``modelcast doctor`` looks at: installed packages, extras, and whether they can be imported."""

import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

from modelcast.core.extras import EXTRAS, install_command
from modelcast.core.version import package_version

__all__ = [
    "InstalledPackage",
    "checkout",
    "extra_packages",
    "required_packages",
    "source_version",
    "stale_remedy",
    "version_text",
]

_REQUIREMENT = re.compile(
    r"(?P<name>[\w.-]+)\s*(?:>=\s*(?P<least>[\d.]+))?[^;]*(?:;.*extra\s*==\s*'(?P<extra>\w+)')?"
)

_BROUGHT = "llvmlite"
"""numba's compiler, which comes with numba in the version that fits it."""

_PROBE = """
import contextlib, importlib, sys
for name in sys.argv[1:]:
    sys.stdout.write(name + " ")
    sys.stdout.flush()
    try:
        with contextlib.redirect_stdout(sys.stderr):  # what a module prints is no fault
            importlib.import_module(name)
    except Exception as error:
        sys.stdout.write(f"{type(error).__name__}: {error}".replace("\\n", " "))
    sys.stdout.write("\\n")
    sys.stdout.flush()
"""


@dataclass(frozen=True, slots=True)
class InstalledPackage:
    """A package that modelcast needs, always or for an extra.

    Parameters
    ----------
    name
        As it is installed by.
    installed
        Its version, None where it is missing.
    least
        The lowest version that is enough, empty where any is.
    fault
        Why it cannot be imported; empty where it can.
    """

    name: str
    installed: str | None
    least: str
    fault: str = ""

    @property
    def problem(self) -> str:
        """What is wrong with it; empty where nothing is."""
        if self.installed is None:
            return "is not installed"
        if self.least and _numbers(self.installed) < _numbers(self.least):
            return f"is {self.installed}, older than {self.least}"
        return f"cannot be imported: {self.fault}" if self.fault else ""


def checkout(package: Path = Path(__file__).parents[1]) -> Path | None:
    """Return the folder of the checkout that this modelcast runs from, None where it runs from no checkout.

    Parameters
    ----------
    package
        The folder of the package.
    """
    folder = package.parents[1]
    return folder if package.parent.name == "src" and (folder / "pyproject.toml").is_file() else None


def source_version(folder: Path | None) -> str | None:
    """Return the version that a checkout states, None where it states none.

    Parameters
    ----------
    folder
        The checkout, if there is one.
    """
    try:
        text = "" if folder is None else (folder / "pyproject.toml").read_text(encoding="utf-8")
        stated = tomllib.loads(text).get("project", {}).get("version")
    except (OSError, ValueError):
        return None
    return stated if isinstance(stated, str) else None


def stale_remedy(folder: Path) -> str:
    """Return what to run where a checkout is newer than what was installed of it.

    Parameters
    ----------
    folder
        The checkout.
    """
    return f"install it anew: {install_command(['-e', str(folder)])}"


def version_text() -> str:
    """Return the installed version; where a checkout of another one runs, both and what to do."""
    installed, folder = package_version(), checkout()
    source = source_version(folder)
    if folder is None or source in {None, installed}:
        return installed
    return f"{source}, installed as {installed}; {stale_remedy(folder)}"


def required_packages() -> list[InstalledPackage]:
    """Return the packages that every command needs; imported in another process, to see them work."""
    wanted = {name: least for name, (least, extra) in _requirements().items() if not extra}
    if wanted:
        wanted[_BROUGHT] = ""
    faults = _import_faults(name for name in wanted if _version(name) is not None)
    return [
        InstalledPackage(name, _version(name), least, faults.get(name, ""))
        for name, least in sorted(wanted.items())
    ]


def extra_packages() -> Mapping[str, list[InstalledPackage]]:
    """Return the packages of every extra; those that are there are imported, in another process."""
    wanted = _requirements()
    present = {
        name: module
        for extra in EXTRAS.values()
        for name, module in extra.packages.items()
        if _version(name) is not None
    }
    faults = _import_faults(present.values())
    return {
        extra: [
            InstalledPackage(name, _version(name), wanted.get(name, ("", ""))[0], faults.get(module, ""))
            for name, module in EXTRAS[extra].packages.items()
        ]
        for extra in EXTRAS
    }


def _requirements() -> Mapping[str, tuple[str, str]]:
    """Return the lowest version and the extra of every requirement, by name; none where not installed."""
    try:
        stated = requires("modelcast") or []
    except PackageNotFoundError:
        return {}
    found = (_REQUIREMENT.match(one) for one in stated)
    return {one["name"]: (one["least"] or "", one["extra"] or "") for one in found if one}


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", text.split("+", maxsplit=1)[0])[:3])


def _import_faults(modules: Iterable[str]) -> dict[str, str]:
    """Return why modules cannot be imported; one that takes the process down is named, and the rest tried."""
    left = list(modules)
    faults: dict[str, str] = {}
    while left:
        ended = subprocess.run(  # noqa: S603 - our own interpreter and text
            [sys.executable, "-c", _PROBE, *left], capture_output=True, text=True, check=False
        )
        lines = [line.split(" ", 1) for line in ended.stdout.splitlines() if line.split(" ", 1)[0] in left]
        faults |= {name: (rest[0] if rest else "").strip() for name, *rest in lines}
        if ended.returncode == 0:
            break
        last = lines[-1][0] if lines else left[0]
        faults[last] = f"the interpreter ended with code {ended.returncode}"
        left = left[left.index(last) + 1 :]
    return {name: fault for name, fault in faults.items() if fault}
