"""Where compiled kernels are kept, and when a kept one may answer.

A kept kernel is good for exactly the sources that it was compiled from and the machine it was compiled for.
So each module's kernels lie in a folder named by a hash of the module, of all it imports, and of the versions
of Python, Numba, llvmlite, NumPy and the processor. Files appear whole or not at all; one process compiles
while the others wait for its lock; folders of older sources go.
"""

import ast
import functools
import hashlib
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import suppress
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import Any

import llvmlite
import numba
import numpy as np
from filelock import FileLock
from numba.core import config, registry
from platformdirs import user_cache_path

__all__ = ["CACHE_VARIABLE", "KernelFile", "cache_folder", "kernel_file", "sources_of"]

CACHE_VARIABLE = "MODELCAST_CACHE_DIR"
"""Environment variable that names another folder for compiled kernels."""

_LAYOUT = "1"
"""Version of what a file holds; part of every hash."""

_VERSIONS_KEPT = 4
"""Folders of one module that are kept, the most recently used ones."""

_DIGEST_BYTES = 32
_PLAIN = {"llvmlite", "numba", "numpy", "scipy"}
"""Packages whose version says it all: those of the first three are in every hash."""


class KernelFile:
    """A kept kernel: bytes with their own checksum.

    Parameters
    ----------
    path
        Its file; the folder is made when something is written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def read(self) -> bytes | None:
        """The bytes; None where there are none or they are damaged."""
        try:
            data = self.path.read_bytes()
        except OSError:
            return None
        digest, payload = data[:_DIGEST_BYTES], data[_DIGEST_BYTES:]
        return payload if hashlib.sha256(payload).digest() == digest else None

    def write(self, payload: bytes) -> None:
        """Keep the bytes.

        Raises
        ------
        OSError
            Where the folder cannot be written.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        partial = self.path.with_suffix(f".{os.getpid()}.partial")
        try:
            partial.write_bytes(hashlib.sha256(payload).digest() + payload)
            partial.replace(self.path)
        finally:
            partial.unlink(missing_ok=True)

    def lock(self) -> FileLock:
        """A lock that one process holds while it compiles this kernel.

        Raises
        ------
        OSError
            Where the folder cannot be written.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        return FileLock(self.path.with_suffix(".lock"))

    def used(self) -> None:
        """Note that the folder is in use, and let old ones of the same module go."""
        _use(self.path.parent)


def cache_folder() -> Path:
    """Return the folder that holds all compiled kernels.

    The one that `CACHE_VARIABLE` names, or ``kernels`` in the user's cache folder for modelcast.
    """
    named = os.environ.get(CACHE_VARIABLE)
    return Path(named) if named else user_cache_path("modelcast", appauthor=False) / "kernels"


def kernel_file(module: str, name: str) -> KernelFile | None:
    """Return where a kernel is kept; None where it cannot be, since its module has no source.

    Parameters
    ----------
    module
        Name of the module, which is imported.
    name
        Qualified name of the kernel.

    Raises
    ------
    OSError
        Where the folder belongs to another user: what it holds is run.
    """
    sources = sources_of(module)
    if sources is None:
        return None
    folder = cache_folder()
    _check_owner(folder)
    return KernelFile(folder / f"{module}-{_digest(module)}" / f"{name.replace('<locals>.', '')}.kernel")


@functools.cache
def _use(folder: Path) -> None:
    with suppress(OSError):
        os.utime(folder)
        module = folder.name.rpartition("-")[0]
        versions = [one for one in folder.parent.iterdir() if one.name.rpartition("-")[0] == module]
        versions.sort(key=lambda one: one.stat().st_mtime, reverse=True)
        for old in versions[_VERSIONS_KEPT:]:
            shutil.rmtree(old, ignore_errors=True)


def _check_owner(folder: Path) -> None:
    """Refuse a folder that others own or may write to."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if not hasattr(os, "getuid"):
        return
    found = folder.stat()
    if found.st_uid != os.getuid() or found.st_mode & 0o022:
        raise PermissionError(f"{folder} belongs to another user or may be written by others")


@functools.cache
def _digest(module: str) -> str:
    """Hash of a module's sources and of everything else that compiled code depends on."""
    total = hashlib.sha256()
    for part in (_LAYOUT, *_machine(), *(sources_of(module) or ())):
        data = part.encode("utf-8", "surrogatepass")
        total.update(len(data).to_bytes(8, "big") + data)
    return total.hexdigest()[:24]


@functools.cache
def _machine() -> tuple[str, ...]:
    """Versions of what compiles, the processor, and the settings that change code."""
    versions = (sys.version, numba.__version__, llvmlite.__version__, np.__version__)
    settings: Any = config
    chosen = sorted(
        f"{name}={getattr(settings, name)}"
        for name in dir(settings)
        if name.startswith(("OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "BOUNDSCHECK", "DEBUGINFO", "LLVM_"))
    )
    target: Any = registry.cpu_target
    return (*versions, str(target.target_context.codegen().magic_tuple()), *chosen)


@functools.cache
def sources_of(module: str) -> tuple[str, ...] | None:
    """Names and texts of a module and of everything it imports; None where the module has no source.

    Imports are followed within the module's own package and modelcast's; of another distribution the version
    stands for its text.
    """
    if _source(module) is None:
        return None
    followed = {module.partition(".")[0], __name__.partition(".")[0]}
    seen: dict[str, str] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in seen:
            continue
        package = name.partition(".")[0]
        if package in sys.stdlib_module_names or package in _PLAIN:
            continue
        if package not in followed:
            seen[package] = _version(package)
            continue
        text = _source(name) or ""
        seen[name] = text
        waiting.extend(_imports(name, text))
    return tuple(f"{name}\n{text}" for name, text in sorted(seen.items()))


def _source(name: str) -> str | None:
    """Text of an imported module, or None."""
    loader: Any = getattr(getattr(sys.modules.get(name), "__spec__", None), "loader", None)
    if not hasattr(loader, "get_source"):
        return None
    try:
        text: str | None = loader.get_source(name)
    except (ImportError, OSError):
        return None
    return text


def _version(package: str) -> str:
    """Version of a distribution, or that of its module."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return str(getattr(sys.modules.get(package), "__version__", ""))


def _imports(name: str, text: str) -> Iterator[str]:
    """Names of the modules that a module's text imports; those of a package may be modules or not."""
    own: ModuleType | None = sys.modules.get(name)
    package: str = getattr(own, "__package__", None) or name.rpartition(".")[0]
    for level, module, names in _import_statements(text):
        if module is None and not level:
            yield from names
            continue
        above = package.split(".")[: len(package.split(".")) - level + 1] if level else []
        base = ".".join([*above, *([module] if module else [])])
        yield base
        for one in names:
            if f"{base}.{one}" in sys.modules:
                yield f"{base}.{one}"


@functools.cache
def _import_statements(text: str) -> tuple[tuple[int, str | None, tuple[str, ...]], ...]:
    """Level, module and names of every import; a text that many kernels come from is parsed once."""
    return tuple(
        (getattr(node, "level", 0), getattr(node, "module", None), tuple(one.name for one in node.names))
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Import | ast.ImportFrom)
    )
