"""C++ programs that are compiled against pip's ns-3: once for each text, wheel and compiler."""

import hashlib
import os
import subprocess
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from tempfile import TemporaryDirectory

__all__ = ["build", "environment", "installed_ns3"]

MODULES = ("core", "network", "mobility", "propagation", "spectrum", "antenna", "wifi", "stats", "energy")
"""Modules of ns-3 that its Wi-Fi needs."""


def installed_ns3() -> Path:
    """Return the folder of pip's ns-3: the one that ``NS3_FOLDER`` names, or that of this environment.

    Raises
    ------
    ValueError
        Where it is neither named nor installed.
    """
    if named := os.environ.get("NS3_FOLDER"):
        return Path(named)
    try:
        return Path(str(distribution("ns3").locate_file("ns3")))
    except PackageNotFoundError:
        raise ValueError(
            "ns-3 is not installed: pip install ns3==3.44.*, or name in NS3_FOLDER the folder `ns3` in the "
            "site-packages of another environment"
        ) from None


def environment(ns3: Path) -> dict[str, str]:
    """Return the environment that a program runs in."""
    return {**os.environ, "LD_LIBRARY_PATH": str(ns3 / "lib64")}


def build(source: Path, ns3: Path) -> Path:
    """Compile a program where it is not yet, and return it.

    Parameters
    ----------
    source
        Its one C++ file.
    ns3
        The folder of the wheel.

    Raises
    ------
    ValueError
        Where the folder is no ns-3, or the compiler refuses.

    Notes
    -----
    Programs are kept in ``ns3_radio`` of the user's cache folder (``XDG_CACHE_HOME``).
    """
    cores = sorted((ns3 / "lib64").glob("libns3.*-core.so"))
    if not cores:
        raise ValueError(f"{ns3} has no lib64/libns3.*-core.so: it is not the folder of pip's ns3")
    prefix = cores[-1].name.removeprefix("lib").removesuffix("core.so")
    text = source.read_bytes()
    found = [name for name in MODULES if (ns3 / "lib64" / f"lib{prefix}{name}.so").exists()]
    options = ["-std=c++20", "-O2", f"-I{ns3 / 'include'}", f"-L{ns3 / 'lib64'}"]
    libraries = [f"-l{prefix}{name}" for name in found]
    libraries += [f"-Wl,-rpath,{ns3 / 'lib64'}", "-Wl,--unresolved-symbols=ignore-in-shared-libs"]
    key = hashlib.sha256(text + repr((options, libraries)).encode()).hexdigest()[:16]
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ns3_radio"
    program = folder / f"{source.stem}-{key}"
    if program.exists():
        return program
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(dir=folder) as name:
        made = Path(name) / "program"
        command = ["g++", *options, str(source), "-o", str(made), *libraries]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
        except FileNotFoundError:
            raise ValueError("g++ is needed to compile against ns-3: install it") from None
        if done.returncode != 0:
            raise ValueError(f"g++ refuses {source.name}: {done.stderr.strip()[:500]}")
        made.replace(program)  # whole or not at all, whoever else compiles
    return program
