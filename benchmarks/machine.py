"""What a benchmark ran on: processor, memory, versions, and how busy the machine was. No name of the host."""

import os
import platform
from pathlib import Path
from typing import Any

from modelcast.core.version import installed_versions, package_version

__all__ = ["load_average", "machine", "versions"]

CPU_INFO, MEMORY_INFO = Path("/proc/cpuinfo"), Path("/proc/meminfo")
PACKAGES = ("numpy", "numba", "llvmlite", "scipy", "polars")


def machine() -> dict[str, Any]:
    """Cores this process may use, processor, whether that is virtual, instructions, system, memory [GiB].

    Where the system tells no memory, it is None; Linux alone tells that a machine is virtual.
    """
    affinity = getattr(os, "sched_getaffinity", None)
    return {
        "cores": len(affinity(0)) if affinity is not None else os.cpu_count(),
        "processor": _told(CPU_INFO, "model name") or platform.processor() or "unknown",
        "virtual": "hypervisor" in _told(CPU_INFO, "flags").split(),
        "architecture": platform.machine(),
        "system": platform.system(),
        "memory_gib": _memory_gib(),
    }


def versions(*more: str) -> dict[str, str]:
    """Versions of Python, modelcast, what it computes with, and others; what is absent is left out."""
    own = {"python": platform.python_version(), "modelcast": package_version()}
    return own | installed_versions((*PACKAGES, *more))


def load_average() -> float | None:
    """Processes that ran or waited to run, mean over the last minute; None where the system does not tell."""
    return round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None


def _told(file: Path, key: str) -> str:
    """The first value of a key in a file of lines ``key : value``; empty where there is none."""
    if not file.is_file():
        return ""
    for line in file.read_text(encoding="utf-8").splitlines():
        name, _, value = line.partition(":")
        if name.strip() == key:
            return value.strip()
    return ""


def _memory_gib() -> float | None:
    told = _told(MEMORY_INFO, "MemTotal").removesuffix(" kB")
    return round(int(told) / 2**20, 1) if told else None
