"""The one way to compile: a function over numbers and arrays, with one signature, kept between runs.

A kernel's annotations are its signature (`modelcast.core.kernel_types`). It is compiled when it is first
called, or loaded where an earlier run kept it (`modelcast.core.kernel_cache`); importing it costs nothing. A
caller gives the arrays that the signature names, contiguous where it says so, or gets a ``TypeError``:
nothing is compiled a second time for another layout. Division by zero gives infinity or NaN, and a kernel
raises nothing: what can fail returns a status.

Where Numba is told not to compile (``NUMBA_DISABLE_JIT=1``), a kernel is the plain function.
"""

import functools
import importlib
import inspect
import pickle
import sys
import typing
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from typing import Any, ParamSpec, TypeVar, overload

from numba.core import compiler, config, registry, serialize
from numba.core.compiler_lock import global_compiler_lock

from modelcast.core import kernel_cache
from modelcast.core.kernel_types import numba_type

__all__ = ["COMPILES", "Kernel", "kernel", "kernels", "watch"]

_settings: Any = config

COMPILES: bool = not _settings.DISABLE_JIT
"""Whether kernels are compiled; else they are plain functions."""

_FAST = {"contract", "reassoc", "nsz", "arcp"}  # not nnan, ninf: NaN and infinity keep their meaning

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")

# Numba's own parts have no useful types.
_Dispatcher: Any = registry.CPUDispatcher
_CompileResult: Any = compiler.CompileResult
_lock: Any = global_compiler_lock
_serialize: Any = serialize

_made: "list[Kernel]" = []


class Kernel(registry.CPUDispatcher):  # type: ignore[misc]
    """A compiled function with one signature; made by `kernel`.

    To Numba it is a compiled function like any other: one kernel calls another by its name.

    Parameters
    ----------
    py_func
        The function.
    locals, targetoptions
        As Numba has them.
    """

    def __init__(self, py_func: Callable[..., Any], *, targetoptions: dict[str, Any]) -> None:
        super().__init__(py_func, targetoptions=targetoptions)
        _made.append(self)

    @property
    def label(self) -> str:
        """Module and name."""
        return f"{self.py_func.__module__}.{self.py_func.__qualname__}"

    @property
    def declared(self) -> Any:
        """The one signature, from the annotations.

        Raises
        ------
        TypeError
            Where an argument has no annotation, or one that no kernel can have.
        """
        hints = typing.get_type_hints(self.py_func, include_extras=True)
        names = list(inspect.signature(self.py_func).parameters)
        missing = [name for name in (*names, "return") if name not in hints]
        if missing:
            raise TypeError(f"{self.label}: no type for {', '.join(missing)}")
        try:
            return numba_type(hints["return"])(*(numba_type(hints[name]) for name in names))
        except TypeError as error:
            raise TypeError(f"{self.label}: {error}") from None

    def ready(self) -> Any:
        """Load the kernel or compile it, once; returns Numba's result."""
        if not self.overloads:
            with _lock:
                if not self.overloads:
                    self._make()
        return next(iter(self.overloads.values()))

    def _make(self) -> None:
        signature = self.declared
        file = _file_of(self)
        if not self._load(file):
            with _locked(file):
                if not self._load(file):
                    with _announcing.around(self.label):
                        super().compile(signature)
                    self._keep(file)
        self.disable_compile()

    def _load(self, file: kernel_cache.KernelFile | None) -> bool:
        """Take what is kept; whether there was anything."""
        payload = None if file is None else file.read()
        if file is None or payload is None:
            return False
        self.targetctx.refresh()
        loaded = _CompileResult._rebuild(self.targetctx, *pickle.loads(payload))  # noqa: S301, SLF001
        self.targetctx.insert_user_function(loaded.entry_point, loaded.fndesc, [loaded.library])
        self.add_overload(loaded)
        file.used()
        return True

    def _keep(self, file: kernel_cache.KernelFile | None) -> None:
        compiled: Any = next(iter(self.overloads.values()))
        if compiled.library.has_dynamic_globals:
            raise TypeError(f"{self.label} holds an address or a large array: give it as an argument")
        if file is not None:
            try:
                file.write(_serialize.dumps(compiled._reduce()))  # noqa: SLF001
            except OSError as error:
                _not_kept(error)

    def compile(self, sig: Any) -> Any:
        """Compile what is declared, whatever is asked for: a kernel has one signature."""
        del sig
        return self.ready().entry_point

    @property
    def address(self) -> int:
        """Address of the native function in this process; it never travels in data."""
        compiled = self.ready()
        return int(compiled.library.get_pointer_to_function(compiled.fndesc.mangled_name))

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return how a compiled caller calls it."""
        self.ready()
        return super().get_call_template(args, kws)

    def _compile_for_args(self, *args: Any, **kws: Any) -> Any:
        """Answer the first call from Python: Numba calls what is returned, and now finds a match."""
        del args, kws
        self.ready()
        return self

    def _explain_matching_error(self, *args: Any, **_: Any) -> None:
        """Say which argument is not what the signature says."""
        names = list(inspect.signature(self.py_func).parameters)
        wanted = self.ready().signature.args
        wrong = [
            f"{name} must be {want}, got {have}"
            for name, want, have in zip(names, wanted, map(self.typeof_pyval, args), strict=False)
            if self.typingctx.can_convert(have, want) is None
        ]
        raise TypeError(f"{self.label}: {'; '.join(wrong) or f'takes {len(wanted)} arguments'}")

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel to another process by name."""
        return _named, (self.py_func.__module__, self.py_func.__qualname__)


@overload
def kernel(function: Callable[_Parameters, _Result], /) -> Callable[_Parameters, _Result]: ...
@overload
def kernel(
    *, fast: bool = False, inlined: bool = False, copied: bool = False
) -> Callable[[Callable[_Parameters, _Result]], Callable[_Parameters, _Result]]: ...
def kernel(
    function: Callable[..., Any] | None = None,
    /,
    *,
    fast: bool = False,
    inlined: bool = False,
    copied: bool = False,
) -> Any:
    """Compile a function when it is first called.

    Parameters
    ----------
    function
        Annotated with the types of `modelcast.core.kernel_types`.
    fast
        Whether sums may be regrouped. Results then differ in their last bits from one caller to another.
    inlined
        Whether it becomes part of its callers, and borrows the arrays it is given: it counts no references to
        them, which for a function called for every pair of vehicles is most of the time. Such a function
        creates no array, nor does what it calls; assigning a slice counts as creating one.
    copied
        Whether its text is put into its callers before they are compiled: for loops whose lengths a caller
        states as constants.

    Examples
    --------
    >>> from modelcast.core.kernel_types import FloatVector
    >>> @kernel
    ... def total(values: FloatVector) -> float:
    ...     most = 0.0
    ...     for value in values:
    ...         most += value
    ...     return most
    >>> import numpy as np
    >>> float(total(np.arange(4.0)))
    6.0
    """
    if function is None:
        return functools.partial(_kernel_of, fast=fast, inlined=inlined, copied=copied)
    return _kernel_of(function, fast=fast, inlined=inlined, copied=copied)


def _kernel_of(function: Callable[..., Any], *, fast: bool, inlined: bool, copied: bool) -> Any:
    """Return the kernel of a function; itself where nothing is compiled."""
    if not COMPILES:
        return function
    options: dict[str, Any] = {"nopython": True, "nogil": True, "error_model": "numpy", "boundscheck": None}
    if fast:
        options["fastmath"] = set(_FAST)
    if inlined:
        options |= {"_nrt": False, "forceinline": True}
    if copied:
        options["inline"] = "always"
    return Kernel(function, targetoptions=options)


def kernels() -> tuple[Kernel, ...]:
    """All kernels of the modules imported so far, in order of their names."""
    return tuple(sorted(_made, key=lambda one: one.label))


def watch(listener: Callable[[str], None] | None) -> None:
    """Have compilation announced.

    Parameters
    ----------
    listener
        Called with the name of each kernel that is about to be compiled, and with an empty one when the
        outermost of them is done; None for the one line that a terminal gets otherwise.
    """
    _announcing.listener = listener


class _Announcing:
    """What is being compiled, and who is told."""

    def __init__(self) -> None:
        self.listener: Callable[[str], None] | None = None
        self.depth = 0
        self.told: set[str] = set()

    def tell(self, text: str) -> None:
        """Write a line to the terminal, once a process."""
        if text not in self.told:
            self.told.add(text)
            sys.stderr.write(f"modelcast: {text}\n")

    @contextmanager
    def around(self, label: str) -> Generator[None]:
        """Announce one compilation."""
        if self.listener is not None:
            self.listener(label)
        elif sys.stderr.isatty():
            self.tell("compiling for this machine, once; the next run starts at once")
        self.depth += 1
        try:
            yield
        finally:
            self.depth -= 1
            if self.listener is not None and not self.depth:
                self.listener("")


_announcing = _Announcing()


def _not_kept(error: OSError) -> None:
    _announcing.tell(
        f"compiled code cannot be kept, so every process compiles anew ({error}); "
        f"set {kernel_cache.CACHE_VARIABLE} to a folder of your own"
    )


def _file_of(one: Kernel) -> kernel_cache.KernelFile | None:
    """Return where a kernel is kept, or None where it cannot be."""
    try:
        return kernel_cache.kernel_file(one.py_func.__module__, one.py_func.__qualname__)
    except OSError as error:
        _not_kept(error)
        return None


@contextmanager
def _locked(file: kernel_cache.KernelFile | None) -> Generator[None]:
    """Hold the kernel's lock, where there is a folder for one."""
    with ExitStack() as held:
        if file is not None:
            try:
                held.enter_context(file.lock())
            except OSError as error:
                _not_kept(error)
        yield


def _named(module: str, name: str) -> Any:
    """Return the kernel of this name in this process."""
    found: Any = importlib.import_module(module)
    for part in name.split("."):
        found = getattr(found, part)
    return found
