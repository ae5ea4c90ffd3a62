"""The one decorator: one signature a kernel, kept code that is that of the sources, nothing swallowed."""

import ast
import importlib
import inspect
import multiprocessing
import os
import pickle
import pkgutil
import re
import subprocess
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import modelcast
from modelcast.core import kernel as kernel_module
from modelcast.core.kernel import Kernel, kernel, kernels
from modelcast.core.kernel_cache import CACHE_VARIABLE, KernelFile, sources_of
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.address_kernels import FIT_TYPES, point_address
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.predicted_path import PredictedPath
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.world.drive import generate_drive

SOURCE = Path(modelcast.__file__).parent


def all_kernels() -> tuple[Kernel, ...]:
    for found in pkgutil.walk_packages([str(SOURCE)], "modelcast."):
        if found.name.endswith("_kernels"):
            importlib.import_module(found.name)
    return tuple(one for one in kernels() if one.label.startswith("modelcast."))


@kernel
def doubled(values: FloatVector, out: FloatVector) -> int:
    for i in range(values.size):
        out[i] = 2.0 * values[i]
    return values.size


@kernel
def divided(over: float) -> float:
    return 1.0 / over


def test_every_kernel_has_one_signature_from_its_annotations() -> None:
    found = all_kernels()
    assert len(found) > 200
    for one in found:
        assert one.declared is not None
        assert len({*one.nopython_signatures, one.declared}) == 1


def test_an_argument_without_a_type_is_named() -> None:
    @kernel
    def loose(values, out: FloatVector) -> None:  # type: ignore[no-untyped-def]
        out[0] = values[0]

    with pytest.raises(TypeError, match=r"loose: no type for values"):
        _ = loose.declared


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (np.arange(8.0)[::2], "values must be .* got array.float64, 1d, A."),
        (np.arange(4), "values must be .* got array.int64"),
        (np.zeros((2, 2)), "values must be .* got array.float64, 2d"),
        (np.frombuffer(bytes(32)), "values must be .* got readonly"),
        ([1.0, 2.0], "values must be"),
    ],
)
def test_another_layout_is_refused_and_not_compiled(values: object, said: str) -> None:
    with pytest.raises(TypeError, match=said):
        doubled(values, np.empty(4))
    assert doubled.ready() is doubled.ready()
    assert not doubled.overloads  # no kernel calls it


def test_a_division_by_zero_is_infinite_and_raises_nothing() -> None:
    assert divided(0.0) == np.inf


def test_a_kernel_travels_by_name() -> None:
    assert pickle.loads(pickle.dumps(divided)) is divided  # noqa: S301 - our own bytes


def _walked(bank: TripRuntime) -> tuple[list[int], list[int]]:
    walk = bank.run(ErrorDriven(0.3, start="hindsight"))
    return walk.kind.tolist(), walk.in_use.tolist()


def test_a_bank_made_here_walks_in_another_process_as_it_does_here() -> None:
    """Addresses do not travel, though a quantised path of a Gaussian process holds two, one in the other."""
    drive = generate_drive(seed=3, duration_s=100.0).input
    members = (PredictedPath(GaussianProcess(form="intercept")), ConstantVelocity())
    bank = TripRuntime(drive, Bank(members), velocity_estimator_for(drive), quantised=True)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        there = pool.apply(_walked, (bank,))
    assert there == _walked(bank)


ANSWERS_NOT_NEEDED = {
    # Called for what they write; the number they return beside it cannot mean "declined".
    "modelcast.channel.dsrc_station_kernels.sense_medium": "which way the medium turned; nobody waits yet",
    "modelcast.trips.conditioning_kernels.negative_log_likelihood": "the value, where the sums are wanted",
    "modelcast.trips.conditioning_kernels._update": "innovation and its variance, where the state is wanted",
    "modelcast.study.clairvoyant_kernels._squared_errors": "the greatest, where all are wanted",
    "modelcast.station.policy.neighbours_kernels.forget": "how many went; the caller looks at the free list",
}
"""The closed list of kernels whose answer a caller may leave, and why nothing is lost."""


def _called(module: object, name: str) -> object:
    found = module
    for part in name.split("."):
        found = getattr(found, part, None)
    return found


def test_nothing_a_kernel_answers_is_dropped() -> None:
    """A kernel that returns something is not called as a statement: what declines is always looked at."""
    all_kernels()
    dropped: set[str] = set()
    for path in sorted(SOURCE.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if "kernel" not in text or path.name == "__main__.py":
            continue
        module = importlib.import_module(
            ".".join(("modelcast", *path.relative_to(SOURCE).with_suffix("").parts))
        )
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
                found = _called(module, ast.unparse(node.value.func))
                if isinstance(found, Kernel) and str(found.declared.return_type) != "none":
                    dropped.add(found.label)
    assert dropped == set(ANSWERS_NOT_NEEDED)


def test_no_kernel_raises_but_those_that_call_python() -> None:
    for path in sorted(SOURCE.rglob("*_kernels.py")):
        if path == SOURCE / "models" / "python_kernels.py":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and any(
                "kernel" in ast.unparse(d) for d in node.decorator_list
            ):
                raised = [one for one in ast.walk(node) if isinstance(one, ast.Raise | ast.Assert)]
                assert not raised, f"{path.name}:{node.name}"


def test_a_kernel_that_borrows_arrays_calls_none_of_their_methods() -> None:
    """Numba compiles such a method with the flags of who is first to call it, and some cannot do with these.

    Whether another kernel was first depends on what is in the cache.
    """
    for path in sorted(SOURCE.rglob("*_kernels.py")):
        module = importlib.import_module(
            ".".join(("modelcast", *path.relative_to(SOURCE).with_suffix("").parts))
        )
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.FunctionDef):
                continue
            if not any("inlined=True" in ast.unparse(one) for one in node.decorator_list):
                continue
            for call in ast.walk(node):
                if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute):
                    owner = getattr(module, ast.unparse(call.func.value), None)
                    of_number = call.func.attr == "view"  # the bits of a number
                    assert inspect.ismodule(owner) or of_number, f"{path.name}: {ast.unparse(call)}"


# --- kept code, in processes of its own ---------------------------------------------------------------------

CALLER = """
from fixture_package.callee import scaled
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector

@kernel
def total(values: FloatVector) -> float:
    most = 0.0
    for value in values:
        most += scaled(value)
    return most
"""

CALLEE = """
from modelcast.core.kernel import kernel

FACTOR = {factor}

@kernel
def scaled(value: float) -> float:
    return FACTOR * value
"""


def fixture_package(folder: Path, factor: float) -> None:
    package = folder / "fixture_package"
    package.mkdir(exist_ok=True)
    (package / "__init__.py").write_text("")
    (package / "caller.py").write_text(CALLER)
    (package / "callee.py").write_text(CALLEE.format(factor=factor))


def run_fixture(
    folder: Path, code: str = "", cache: Path | None = None, **variables: str
) -> "subprocess.CompletedProcess[str]":
    program = textwrap.dedent(code) or (
        "import numpy as np\nfrom fixture_package.caller import total\nprint(total(np.arange(4.0)))"
    )
    known = {
        **os.environ,
        "PYTHONPATH": f"{folder}{os.pathsep}{SOURCE.parent}",
        "PYTHONDONTWRITEBYTECODE": "1",
        CACHE_VARIABLE: str(cache or folder / "cache"),
        **variables,
    }
    return subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", program], env=known, capture_output=True, text=True, check=False
    )


@pytest.mark.slow
def test_a_changed_callee_compiles_its_callers_anew(tmp_path: Path) -> None:
    fixture_package(tmp_path, 2.0)
    assert run_fixture(tmp_path).stdout == "12.0\n"
    assert run_fixture(tmp_path).stdout == "12.0\n"
    fixture_package(tmp_path, 3.0)
    assert run_fixture(tmp_path).stdout == "18.0\n"


def test_what_is_kept_is_loaded_and_not_compiled(tmp_path: Path) -> None:
    fixture_package(tmp_path, 2.0)
    watching = """
    import numpy as np
    from modelcast.core.compiling import watch
    watch(lambda one: print("compiles", one.label, one.left) if one.label else None)
    from fixture_package.caller import total
    print(total(np.arange(4.0)))
    """
    first = run_fixture(tmp_path, watching).stdout.splitlines()
    assert first == [
        "compiles fixture_package.caller.total 2",
        "compiles fixture_package.callee.scaled 1",
        "12.0",
    ]
    assert run_fixture(tmp_path, watching).stdout == "12.0\n"


@pytest.mark.slow
def test_what_callers_took_in_is_kept_and_python_gets_the_whole(tmp_path: Path) -> None:
    """One process compiles a caller; the next takes the callee from what was kept, and calls it itself."""
    fixture_package(tmp_path, 2.0)

    def kept() -> list[str]:
        return sorted(file.name for file in (tmp_path / "cache").rglob("*.kernel"))

    run_fixture(tmp_path)
    assert kept() == ["scaled.part.kernel", "total.kernel"]
    (tmp_path / "fixture_package" / "other.py").write_text(CALLER.replace("def total", "def again"))
    other = """
    import numpy as np
    from modelcast.core.compiling import watch
    watch(lambda one: print("compiles", one.label.rpartition(".")[2]) if one.label else None)
    from fixture_package.callee import scaled
    from fixture_package.other import again
    print(again(np.arange(4.0)), scaled(1.5))
    """
    assert run_fixture(tmp_path, other).stdout.split() == [
        "compiles",
        "again",
        "compiles",
        "scaled",
        "12.0",
        "3.0",
    ]
    assert kept() == ["again.kernel", "scaled.kernel", "scaled.part.kernel", "total.kernel"]
    assert run_fixture(tmp_path, other).stdout == "12.0 3.0\n"


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["empty", "cut", "bent"])
def test_a_damaged_file_is_compiled_anew(tmp_path: Path, damage: str) -> None:
    fixture_package(tmp_path, 2.0)
    run_fixture(tmp_path)
    for file in (tmp_path / "cache").rglob("*.kernel"):
        data = file.read_bytes()
        file.write_bytes({"empty": b"", "cut": data[:-100], "bent": data[:200] + b"\0" + data[201:]}[damage])
    found = run_fixture(tmp_path)
    assert (found.stdout, found.returncode) == ("12.0\n", 0)


def test_a_place_that_cannot_be_written_costs_one_line(tmp_path: Path) -> None:
    fixture_package(tmp_path, 2.0)
    (tmp_path / "file").write_text("")
    found = run_fixture(tmp_path, cache=tmp_path / "file" / "cache")
    assert found.stdout == "12.0\n"
    assert len(found.stderr.splitlines()) == 1
    assert CACHE_VARIABLE in found.stderr


READY = """
import numpy as np
from fixture_package.caller import total
print(total.is_ready, total.is_kept)
total(np.arange(4.0))
print(total.is_ready, total.is_kept)
"""


@pytest.mark.slow
def test_whether_a_kernel_is_ready_and_kept_is_known(tmp_path: Path) -> None:
    fixture_package(tmp_path, 2.0)
    assert run_fixture(tmp_path, READY).stdout.splitlines() == ["False False", "True True"]
    assert run_fixture(tmp_path, READY).stdout.splitlines() == ["False True", "True True"]
    (tmp_path / "file").write_text("")
    cache = tmp_path / "file" / "cache"
    assert run_fixture(tmp_path, READY, cache=cache).stdout.splitlines() == ["False False", "True False"]


def test_a_folder_that_others_may_write_is_not_trusted(tmp_path: Path) -> None:
    fixture_package(tmp_path, 2.0)
    cache = tmp_path / "cache"
    cache.mkdir()
    cache.chmod(0o777)
    found = run_fixture(tmp_path)
    assert found.stdout == "12.0\n"
    assert "may be written by others" in found.stderr
    assert not list(cache.iterdir())


@pytest.mark.slow
def test_folders_of_older_sources_go(tmp_path: Path) -> None:
    fixture_package(tmp_path, 2.0)
    cache = tmp_path / "cache"
    cache.mkdir(mode=0o700)
    for number in range(9):
        old = cache / f"fixture_package.caller-{number:024x}"
        old.mkdir()
        os.utime(old, (number, number))
    run_fixture(tmp_path)
    run_fixture(tmp_path)
    assert len([one for one in cache.iterdir() if one.name.startswith("fixture_package.caller-")]) == 4


def test_the_interpreter_alone_gives_the_same(tmp_path: Path) -> None:
    fixture_package(tmp_path, 2.0)
    assert run_fixture(tmp_path, NUMBA_DISABLE_JIT="1").stdout == "12.0\n"
    assert not (tmp_path / "cache").exists()


@pytest.mark.slow
def test_an_evaluation_runs_with_the_interpreter_alone(tmp_path: Path) -> None:
    """The same messages, compiled or not, by a bank whose functions call each other by address."""
    program = """
    from modelcast.runtime.trip.runtime import TripRuntime
    from modelcast.models.bank import Bank
    from modelcast.models.constant_velocity import ConstantVelocity
    from modelcast.models.kinematic import ConstantTurnRateAcceleration
    from modelcast.station.sensing.velocity import velocity_estimator_for
    from modelcast.station.policy.error_driven import ErrorDriven
    from modelcast.world.drive import generate_drive
    drive = generate_drive(seed=3, duration_s=90.0).input
    bank = Bank((ConstantTurnRateAcceleration(), ConstantVelocity()))
    sender = TripRuntime(drive, bank, velocity_estimator_for(drive), quantised=True)
    walk = sender.run(ErrorDriven(0.3, start="hindsight"))
    print(walk.kind.tolist(), walk.in_use.tolist())
    """
    compiled = run_fixture(tmp_path, program)
    plain = run_fixture(tmp_path, program, NUMBA_DISABLE_JIT="1")
    assert compiled.stdout == plain.stdout != ""


@pytest.mark.slow
def test_an_exception_in_a_point_function_is_not_swallowed(tmp_path: Path) -> None:
    """A kernel of somebody else's that raises after all ends the call, and is not printed and passed over."""
    package = tmp_path / "fixture_package"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "points.py").write_text(
        textwrap.dedent(
            """
            import numpy as np
            from modelcast.core.kernel import kernel
            from modelcast.core.kernel_types import FloatMatrix, FloatVector

            @kernel
            def fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
                out[:] = np.zeros(window.shape[0] + 1)  # of another size
            """
        )
    )
    found = run_fixture(
        tmp_path,
        """
        import numpy as np
        from fixture_package.points import fit
        from modelcast.models.address_kernels import FIT_TYPES, point_address
        from modelcast.models.point_kernels import fit_batch
        fit_batch(point_address(fit, FIT_TYPES), np.zeros((2, 3, 7)), np.zeros(1), np.zeros((2, 2)))
        print("went on")
        """,
    )
    assert found.returncode == 1
    assert "went on" not in found.stdout
    assert "ignored" not in found.stderr
    assert re.search(r"ValueError: cannot assign slice", found.stderr)


def test_the_closure_holds_what_a_kernel_calls_and_where_its_constants_come_from() -> None:
    importlib.import_module("modelcast.models.predicted_path_kernels")
    names = {text.partition("\n")[0] for text in sources_of("modelcast.models.predicted_path_kernels") or ()}
    assert {
        "modelcast.models.address_kernels",
        "modelcast.models.point_kernels",
        "modelcast.core.kernel",
        "modelcast.core.kernel_types",
    } <= names


def test_a_kept_file_is_what_was_written_or_nothing(tmp_path: Path) -> None:
    file = KernelFile(tmp_path / "deep" / "one.kernel")
    assert file.read() is None
    file.write(b"code")
    assert file.read() == b"code"
    file.path.write_bytes(file.path.read_bytes()[:-1] + b"x")
    assert file.read() is None


def start_together(folder: Path, count: int) -> list[str]:
    """Answers of so many processes begun at once."""
    program = "import numpy as np\nfrom fixture_package.caller import total\nprint(total(np.arange(4.0)))"
    known = {
        **os.environ,
        "PYTHONPATH": f"{folder}{os.pathsep}{SOURCE.parent}",
        CACHE_VARIABLE: str(folder / "cache"),
    }
    running = [
        subprocess.Popen([sys.executable, "-c", program], env=known, stdout=subprocess.PIPE, text=True)  # noqa: S603 - our own interpreter
        for _ in range(count)
    ]
    return [one.communicate()[0] for one in running]


@pytest.mark.slow
@pytest.mark.parametrize("times", [1, pytest.param(50, marks=pytest.mark.slow)])
def test_processes_that_meet_a_cold_cache_at_once_agree(tmp_path: Path, times: int) -> None:
    fixture_package(tmp_path, 2.0)
    for _ in range(times):
        for file in (tmp_path / "cache").rglob("*"):
            if file.is_file():
                file.unlink()
        assert start_together(tmp_path, 2) == ["12.0\n"] * 2
        assert run_fixture(tmp_path).stdout == "12.0\n"


THREADS = """
import threading
import numpy as np
from fixture_package.callee import scaled
from fixture_package.caller import total

begin, said = threading.Barrier(4), []

def call(one):
    begin.wait()
    said.append(total(np.arange(4.0)) if one % 2 else scaled(6.0))

threads = [threading.Thread(target=call, args=(one,)) for one in range(4)]
for one in threads:
    one.start()
for one in threads:
    one.join()
print(said)
"""


@pytest.mark.slow
@pytest.mark.parametrize("times", [1, pytest.param(20, marks=pytest.mark.slow)])
def test_threads_of_processes_that_meet_a_cold_cache_at_once_agree(tmp_path: Path, times: int) -> None:
    fixture_package(tmp_path, 2.0)
    for _ in range(times):
        for file in (tmp_path / "cache").rglob("*"):
            if file.is_file():
                file.unlink()
        with ThreadPoolExecutor(2) as pool:
            found = list(pool.map(lambda _: run_fixture(tmp_path, THREADS), range(2)))
        assert [(one.stdout, one.stderr) for one in found] == [("[12.0, 12.0, 12.0, 12.0]\n", "")] * 2


HANDED_OVER = """
import signal
import numpy as np
from numba.core import codegen

inner, met = codegen.JITCodeLibrary._object_compiled_hook, []

def hook(module, octets):
    if "total" in module.name and not met:
        met.append(module)
        {problem}
    inner(module, octets)

codegen.JITCodeLibrary._object_compiled_hook = hook
from fixture_package.caller import total
try:
    print(total(np.arange(4.0)), total.is_kept)
except KeyboardInterrupt:
    print("interrupted")
print(total(np.arange(4.0)), total.is_kept)
"""


@pytest.mark.skipif(os.name == "nt", reason="a console's Ctrl-C is another thing there")
def test_an_interrupt_while_code_is_handed_over_is_one(tmp_path: Path) -> None:
    """LLVM calls back with what it made: what a signal's handler raises there, Python passes over."""
    fixture_package(tmp_path, 2.0)
    found = run_fixture(tmp_path, HANDED_OVER.format(problem="signal.raise_signal(signal.SIGINT)"))
    assert (found.stdout, found.stderr) == ("interrupted\n12.0 True\n", "")


def test_code_that_was_lost_when_it_was_handed_over_runs_and_is_not_kept(tmp_path: Path) -> None:
    fixture_package(tmp_path, 2.0)
    found = run_fixture(tmp_path, HANDED_OVER.format(problem="raise MemoryError"))
    assert found.stdout == "12.0 False\n12.0 False\n"
    assert run_fixture(tmp_path, READY).stdout.splitlines() == ["False False", "True True"]


def test_a_point_function_of_other_types_is_refused() -> None:
    with pytest.raises(TypeError, match=r"doubled must be"):
        point_address(doubled, FIT_TYPES)
    with pytest.raises(TypeError, match="decorated with kernel"):
        point_address(len, FIT_TYPES)


def test_fast_kernels_keep_nan_and_infinity() -> None:
    @kernel(fast=True)
    def kept(matrix: FloatMatrix) -> bool:
        return bool(np.isnan(matrix[0, 0]) and np.isinf(matrix[0, 1]))

    assert kept(np.array([[np.nan, np.inf]]))


def test_nobody_is_told_of_compilation_without_a_terminal(tmp_path: Path) -> None:
    fixture_package(tmp_path, 2.0)
    assert run_fixture(tmp_path).stderr == ""
    assert kernel_module.COMPILES
