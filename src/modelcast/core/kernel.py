"""The one way to compile: a function over numbers and arrays, with one signature, kept between runs.

A kernel's annotations are its signature (`modelcast.core.kernel_types`). It is compiled when it is first
called, or loaded where an earlier run kept it (`modelcast.core.kernel_cache`); importing it costs nothing.
What only other kernels call is compiled as far as they need: they take it in, optimise it and translate it. A
caller gives the arrays that the signature names, contiguous where it says so, or gets a ``TypeError``:
nothing is compiled a second time for another layout. Division by zero gives infinity or NaN, and a kernel
raises nothing: what can fail returns a status.

Where Numba is told not to compile (``NUMBA_DISABLE_JIT=1``), a kernel is the plain function.
"""

import functools
import importlib
import inspect
import pickle
import typing
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, ParamSpec, TypeVar, overload

from llvmlite import binding
from numba.core import codegen, compiler, config, registry, serialize
from numba.core.compiler_lock import global_compiler_lock

from modelcast.core import compiling, kernel_cache
from modelcast.core.kernel_types import numba_type

__all__ = ["COMPILES", "Kernel", "kernel", "kernels"]

_settings: Any = config

COMPILES: bool = not _settings.DISABLE_JIT
"""Whether kernels are compiled; else they are plain functions."""

_FAST = {"contract", "reassoc", "nsz", "arcp"}  # not nnan, ninf: NaN and infinity keep their meaning

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")

# Numba's own parts have no useful types.
_Dispatcher: Any = registry.CPUDispatcher
_CompileResult: Any = compiler.CompileResult
_compiler: Any = compiler
_binding: Any = binding
_lock: Any = global_compiler_lock
_serialize: Any = serialize

_made: "list[Kernel]" = []


class _PartLibrary(codegen.JITCodeLibrary):  # type: ignore[misc]
    """Code that its callers take in; neither optimised nor translated on its own."""

    def _optimize_final_module(self) -> None:
        """Leave it to the callers."""

    def take(self, bitcode: bytes) -> None:
        """Take in what was kept."""
        self._final_module = _binding.parse_bitcode(bitcode)
        self._finalize_final_module()

    def _finalize_final_module(self) -> None:
        """Make it ready to be linked, not to be run."""
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


class Kernel(registry.CPUDispatcher):  # type: ignore[misc]
    """A compiled function with one signature; made by `kernel`.

    To Numba it is a compiled function like any other: one kernel calls another by its name. It has two forms,
    each made when it is first asked for: one that Python calls and that has an address, and a part that other
    kernels take in, unless the first is there already.

    Parameters
    ----------
    py_func
        The function.
    locals, targetoptions
        As Numba has them.
    """

    def __init__(self, py_func: Callable[..., Any], *, targetoptions: dict[str, Any]) -> None:
        super().__init__(py_func, targetoptions=targetoptions)
        self._own: Any = None
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

    @property
    def is_ready(self) -> bool:
        """Whether it was loaded or compiled, so that Python calls it without delay."""
        return self._own is not None

    @property
    def is_kept(self) -> bool:
        """Whether the next process finds it in the cache."""
        file = _file_of(self, _Own.suffix)
        return file is not None and file.read() is not None

    def ready(self) -> Any:
        """Load or compile, once, what Python calls; returns Numba's result."""
        if self._own is None:
            with _lock:
                if self._own is None:
                    self._own = made = self._made_or_kept(_Own(self))
                    codes = [one._code for one in made.signature.args]  # noqa: SLF001 - as Numba does it
                    numba: Any = self
                    numba._insert(codes, made.entry_point, False)  # noqa: SLF001
                    self._can_compile = False
        return self._own

    def _part(self) -> Any:
        """Load or compile, once, what other kernels take in; returns Numba's result."""
        if not self.overloads:
            with _lock:
                if not self.overloads:
                    made = self._own or self._made_or_kept(_Part(self))
                    self.overloads[tuple(made.signature.args)] = made
        return next(iter(self.overloads.values()))

    def _made_or_kept(self, form: "_Own | _Part") -> Any:
        signature = self.declared
        file = _file_of(self, form.suffix)
        kept = _kept(form, file)
        if kept is not None:
            return kept
        with _locked(file):
            kept = _kept(form, file)
            if kept is not None:
                return kept
            with compiling.announced(self.label, self._missing), compiling.interrupts_raised():
                made = form.compiled(signature)
            if made.library.has_dynamic_globals:
                raise TypeError(f"{self.label} holds an address or a large array: give it as an argument")
            if file is not None and form.is_whole(made):
                try:
                    file.write(_serialize.dumps(form.reduced(made)))
                except OSError as error:
                    _not_kept(error)
        return made

    def _missing(self) -> int:
        """How many functions have to be compiled before it can be called, itself among them."""
        seen: set[Kernel] = {self}
        waiting: list[Kernel] = [self]
        while waiting:
            for one in _called_by(waiting.pop().py_func):
                if one not in seen and not one.is_part_ready:
                    seen.add(one)
                    waiting.append(one)
        return sum(one.targetoptions.get("inline") != "always" for one in seen)

    @property
    def is_part_ready(self) -> bool:
        """Whether other kernels can take it in without its being compiled, by this process or an earlier."""
        if self.overloads or self._own is not None:
            return True
        file = _file_of(self, _Part.suffix)
        return file is not None and file.path.exists()

    def flags(self) -> Any:
        """Numba's flags, from the options."""
        flags = _compiler.Flags()
        self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
        return flags

    def compile(self, sig: Any) -> Any:
        """Compile what is declared, whatever is asked for: a kernel has one signature."""
        del sig
        return self._part().entry_point

    @property
    def address(self) -> int:
        """Address of the native function in this process; it never travels in data."""
        compiled = self.ready()
        return int(compiled.library.get_pointer_to_function(compiled.fndesc.mangled_name))

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return how a compiled caller calls it."""
        self._part()
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


class _Own:
    """The form that Python calls and that has an address."""

    suffix = ""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel

    def compiled(self, signature: Any) -> Any:
        """Compile it."""
        one = self.kernel
        return _compiler.compile_extra(
            one.typingctx, one.targetctx, one.py_func, args=signature.args,
            return_type=signature.return_type, flags=one.flags(), locals={},
        )  # fmt: skip

    def is_whole(self, made: Any) -> bool:
        """Whether LLVM has handed the code over: it calls back for that, where errors are passed over."""
        return made.library._compiled_object is not None  # noqa: SLF001

    def reduced(self, made: Any) -> Any:
        """Return what is kept of it."""
        return made._reduce()  # noqa: SLF001

    def rebuilt(self, kept: Any) -> Any:
        """Make it of what was kept."""
        context = self.kernel.targetctx
        context.refresh()
        made = _CompileResult._rebuild(context, *kept)  # noqa: SLF001
        context.insert_user_function(made.entry_point, made.fndesc, [made.library])
        return made


class _Part(_Own):
    """The form that other kernels take in. It has no address; a key of its own stands for that."""

    suffix = ".part"

    def compiled(self, signature: Any) -> Any:
        one = self.kernel
        flags = one.flags()
        flags.no_compile = flags.no_cpython_wrapper = True
        made = _compiler.compile_extra(
            one.typingctx, one.targetctx, one.py_func, args=signature.args,
            return_type=signature.return_type, flags=flags, locals={}, library=self._library(),
        )  # fmt: skip
        return self._entered(made._replace(entry_point=object()))

    def is_whole(self, made: Any) -> bool:
        del made  # nothing is translated
        return True

    def reduced(self, made: Any) -> Any:
        made.fndesc.typemap = made.fndesc.calltypes = None
        return made.library.serialize_using_bitcode()[2], made.fndesc, made.signature

    def rebuilt(self, kept: Any) -> Any:
        self.kernel.targetctx.refresh()
        library, made = self._library(), dict.fromkeys(_CompileResult._fields)
        bitcode, made["fndesc"], made["signature"] = kept
        library.take(bitcode)
        made |= {"library": library, "objectmode": False, "entry_point": object()}
        return self._entered(_CompileResult(**made))

    def _library(self) -> _PartLibrary:
        context: Any = self.kernel.targetctx
        return _PartLibrary(context.codegen(), self.kernel.label)

    def _entered(self, made: Any) -> Any:
        self.kernel.targetctx.insert_user_function(made.entry_point, made.fndesc, [made.library])
        return made


def _called_by(function: Any) -> Iterator[Kernel]:
    """Kernels that a function names."""
    code = function.__code__
    cells = zip(code.co_freevars, function.__closure__ or (), strict=True)
    known = {name: function.__globals__.get(name) for name in code.co_names}
    for one in (*known.values(), *(cell.cell_contents for _, cell in cells)):
        if isinstance(one, Kernel):
            yield one


def _kept(form: _Own, file: kernel_cache.KernelFile | None) -> Any:
    """Return what an earlier run kept; None where there is nothing."""
    payload = None if file is None else file.read()
    if file is None or payload is None:
        return None
    made = form.rebuilt(pickle.loads(payload))  # noqa: S301 - our own file, of a folder of this user
    file.used()
    return made


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
    options["no_cfunc_wrapper"] = True  # nobody calls one: addresses are those of the native functions
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


def _not_kept(error: OSError) -> None:
    compiling.tell(
        f"compiled code cannot be kept, so every process compiles anew ({error}); "
        f"set {kernel_cache.CACHE_VARIABLE} to a folder of your own"
    )


def _file_of(one: Kernel, form: str) -> kernel_cache.KernelFile | None:
    """Return where a kernel is kept, or None where it cannot be."""
    try:
        return kernel_cache.kernel_file(one.py_func.__module__, one.py_func.__qualname__ + form)
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
