"""Whether the tests notice a changed rule: mutants of the station's rules against the tests that run them.

A mutant is the package with one small change in a file of `TARGETS`. Kernels run uncompiled
(``NUMBA_DISABLE_JIT=1``). Every test of `TESTS` is run once to learn which lines it runs and how long it
takes; a mutant then meets the tests that run its lines, the quickest first, until one fails. Tests that fail
uncompiled, or take longer than `LONGEST_TEST_S`, are left out. What was found is kept in ``out/mutate`` by a
hash of the changed function and its tests, so that the next run only does what is new.

The score is the share killed of those judged, a test that never ends counted as one that fails. Exit code 1
where it is under `LEAST_SCORE`. Survivors are listed, but for those in ``tools/mutants_accepted.toml``, each
of which has a reason there. Order and sample follow from the seed.

A function is changed where it lies, in a process that has imported and collected all tests; for a changed
constant or class everything is imported anew.

Why not a library: mutmut 3 leaves decorated functions alone, and every kernel is decorated; cosmic-ray 8
changes files where they lie, knows one test command for all mutants, and neither sample nor time limit. Both
would compile nothing but also import everything anew for every mutant; here a process forks with NumPy, Numba
and pytest imported.
"""

import argparse
import ast
import concurrent.futures
import contextlib
import difflib
import functools
import hashlib
import importlib
import inspect
import itertools
import json
import multiprocessing
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

TARGETS = (
    "src/modelcast/apps/*.py",
    "src/modelcast/station/policy/*.py",
    "src/modelcast/station/receiver/*.py",
    "src/modelcast/station/sender/*.py",
)
TESTS = (
    "tests/apps/test_*.py",
    "tests/station/**/test_*.py",
    "tests/runtime/**/test_*.py",
    "tests/messages/test_station_codec.py",
    "tests/study/test_evaluate.py",
    "tests/study/test_guard.py",
    "tests/study/test_reference.py",
    "tests/study/test_trip_messages.py",
)
LEAST_SCORE = 0.9
LONGEST_TEST_S = 5.0
SECONDS_A_MUTANT = 6.0
"""Quickest tests are chosen until they take so long together."""

ROOT = Path(__file__).parents[1]
COPIED = ("src", "tests", "pyproject.toml", "README.md", "CHANGELOG.md", "docs", "benchmarks", "fuzz")
ACCEPTED = ROOT / "tools" / "mutants_accepted.toml"
KEPT = ROOT / "out" / "mutate"

COMPARED: dict[type[ast.AST], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
}
REPLACED: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.And: ast.Or,
    ast.Or: ast.And,
}
SWAPPED = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}


@dataclass(frozen=True)
class Mutant:
    """One change: the text of ``path`` from ``start`` to ``end`` becomes ``text``."""

    path: str
    function: str
    operator: str
    lines: tuple[int, int]
    start: int
    end: int
    text: str
    name: str
    inside_function: bool


class Finder(ast.NodeVisitor):
    """All mutants of one file."""

    def __init__(self, path: str, source: str) -> None:
        self.path, self.source = path, source
        self.starts = [0]
        for line in source.encode().splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))
        self.found: list[Mutant] = []
        self.function: list[str] = []
        self.inside_function = False
        self.statement: ast.stmt | None = None
        self.counts: Counter[str] = Counter()
        self.families = numbered_families(ast.parse(source))
        self.visit(ast.parse(source))

    def add(self, node: ast.expr | ast.stmt, operator: str, text: str) -> None:
        """Note a mutant: a node replaced by a text."""
        statement: Any = self.statement or node
        start = self.starts[node.lineno - 1] + node.col_offset
        end = self.starts[(node.end_lineno or node.lineno) - 1] + (node.end_col_offset or 0)
        function = ".".join(self.function)
        inside = ast.unparse(statement).partition("\n")[0]
        key = f"{operator}|{inside}|{ast.unparse(node).partition(chr(10))[0]}|{text}"
        label = f"{Path(self.path).stem}.{function or 'module'}"
        self.counts[f"{label}|{key}"] += 1
        turn = self.counts[f"{label}|{key}"]
        name = f"{label}#{hashlib.sha256(f'{key}|{turn}'.encode()).hexdigest()[:6]}"
        body = getattr(statement, "body", None)
        last = body[0].lineno - 1 if body else statement.end_lineno or statement.lineno
        lines = (statement.lineno, max(statement.lineno, last))
        self.found.append(
            Mutant(self.path, function, operator, lines, start, end, text, name, self.inside_function)
        )

    def visit(self, node: ast.AST) -> None:
        """Visit a node, with its statement in mind; decorators, annotations and messages are left alone."""
        if self.is_left_alone(node):
            return
        if isinstance(node, ast.stmt):
            self.statement = node
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            self.function.append(node.name)
            outside, self.inside_function = (
                self.inside_function,
                self.inside_function or isinstance(node, ast.FunctionDef),
            )
            for child in node.body:
                self.visit(child)
            self.function.pop()
            self.inside_function = outside
        elif isinstance(node, ast.AnnAssign):
            if node.value is not None:
                self.visit(node.value)
        else:
            self.mutate(node)
            for child in ast.iter_child_nodes(node):
                if isinstance(child, ast.Constant) and isinstance(node, ast.UnaryOp) and child.value == 1:
                    continue
                if isinstance(node, ast.stmt):
                    self.statement = node
                self.visit(child)

    def is_left_alone(self, node: ast.AST) -> bool:
        """Whether nothing in a node is a rule: messages, imports, names, types, tables, sizes of scratch."""
        match node:
            case ast.Raise() | ast.Import() | ast.ImportFrom() | ast.Assert() | ast.JoinedStr():
                return True
            case ast.Call(func=called) if ast.unparse(called) == "np.empty":
                return True
            case ast.ClassDef(bases=bases):
                return any("NamedTuple" in ast.unparse(base) for base in bases)
            case ast.AnnAssign(value=ast.Call(func=called)):
                return ast.unparse(called) == "np.dtype"
            case ast.Assign(value=value):
                sizes = ast.unparse(node.targets[0]).endswith(("COLUMNS", "STATUSES", "EVENTS"))
                return not self.function and (sizes or not self.is_number(value))
            case _:
                return False

    @staticmethod
    def is_number(node: ast.expr) -> bool:
        """Whether a module's assignment is a number or some."""
        return all(
            isinstance(
                one, (ast.Constant, ast.Tuple, ast.UnaryOp, ast.USub, ast.BinOp, ast.operator, ast.Load)
            )
            and not (isinstance(one, ast.Constant) and isinstance(one.value, str))
            for one in ast.walk(node)
        )

    def mutate(self, node: ast.AST) -> None:
        """Note what can be changed at one node."""
        if isinstance(node, ast.stmt):
            self.mutate_statement(node)
        elif isinstance(node, (ast.Constant, ast.Name)):
            self.mutate_atom(node)
        else:
            self.mutate_expression(node)

    def mutate_expression(self, node: ast.AST) -> None:
        """Note what can be changed at an operator or a call."""
        match node:
            case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in COMPARED:
                for other in COMPARED[type(op)]:
                    self.add(node, "comparison", f"({ast.unparse(ast.Compare(left, [other()], [right]))})")
            case ast.Call(func=ast.Name(id=name) as called) if name in SWAPPED:
                self.add(called, "min-max", SWAPPED[name])
            case ast.Call(func=ast.Attribute(attr=name) as called) if name in SWAPPED:
                self.add(called, "min-max", f"{ast.unparse(called.value)}.{SWAPPED[name]}")
            case ast.BinOp(left=left, op=op, right=right) if type(op) in REPLACED:
                swapped: Any = REPLACED[type(op)]()
                self.add(node, "arithmetic", f"({ast.unparse(ast.BinOp(left, swapped, right))})")
            case ast.BoolOp(op=op, values=values):
                swapped = REPLACED[type(op)]()
                self.add(node, "and-or", f"({ast.unparse(ast.BoolOp(swapped, values))})")
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                self.add(node, "not", f"({ast.unparse(operand)})")
            case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=1)):
                self.add(node, "constant", "0")  # "none" becomes the first of all
            case _:
                pass

    def mutate_atom(self, node: ast.Constant | ast.Name) -> None:
        """Note what can be changed at a constant."""
        match node:
            case ast.Constant(value=bool() as value):
                self.add(node, "true-false", str(not value))
            case ast.Constant(value=int() | float() as value):
                self.add(node, "constant", f"({value} + 1)")
                if value not in (0, 1):
                    self.add(node, "constant", f"({value} * 2)")
            case ast.Name(id=name, ctx=ast.Load()) if name in self.families:
                self.add(node, "numbered", self.families[name])
            case _:
                pass

    def mutate_statement(self, node: ast.stmt) -> None:
        """Note what can be changed at a statement."""
        match node:
            case ast.AugAssign(target=target, op=op, value=value):
                if type(op) in REPLACED:
                    other: Any = REPLACED[type(op)]()
                    self.add(node, "arithmetic", ast.unparse(ast.AugAssign(target, other, value)))
                self.add(node, "removed", "pass")
            case ast.Assign() if self.function:
                self.add(node, "removed", "pass")
            case ast.Continue() | ast.Break():
                self.add(node, "removed", "pass")
            case _:
                pass


def numbered_families(tree: ast.Module) -> dict[str, str]:
    """Map each constant of ``A, B, C = range(3)`` or of an import of several to the next of its family."""
    families: list[list[str]] = []
    for node in tree.body:
        if isinstance(node, ast.ImportFrom):
            families.append(values_apart(node))
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple):
            families.append([ast.unparse(one) for one in node.targets[0].elts])
    return {
        one: family[(k + 1) % len(family)]
        for family in families
        if len(family) > 1
        for k, one in enumerate(family)
    }


def values_apart(node: ast.ImportFrom) -> list[str]:
    """Return the constants that an import names, each of another value than the one before it."""
    path = ROOT / "src" / f"{(node.module or '').replace('.', '/')}.py"
    values = numbered(ast.parse(path.read_text())) if path.exists() else {}
    found, last = list[str](), None
    for one in node.names:
        value = values.get(one.name)
        if one.name.isupper() and (value is None or value != last):
            found.append(one.asname or one.name)
            last = value
    return found


def numbered(tree: ast.Module) -> dict[str, int]:
    """Return the values of a module's constants that are numbered by ``range``."""
    values: dict[str, int] = {}
    for node in tree.body:
        match node:
            case ast.Assign(
                targets=[ast.Tuple(elts=names)], value=ast.Call(func=ast.Name("range"), args=args)
            ):
                first = args[0].value if len(args) > 1 and isinstance(args[0], ast.Constant) else 0
                values |= {ast.unparse(one): int(str(first)) + at for at, one in enumerate(names)}
            case _:
                pass
    return values


def mutated(source: str, mutant: Mutant) -> str:
    """Return the changed text."""
    octets = source.encode()
    return (octets[: mutant.start] + mutant.text.encode() + octets[mutant.end :]).decode()


def uncompiled(source: str) -> str:
    """Return a text that means uncompiled what it means compiled.

    There a record's fields are attributes, and a sum of a short integer and a long one is long.
    """
    calls = [
        node
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call)
        and ast.unparse(node.func) == "np.dtype"
        and isinstance(node.args[0], ast.List)
    ]
    for node in sorted(calls, key=lambda one: -one.lineno):
        whole = ast.get_source_segment(source, node) or ""
        source = source.replace(whole, f"np.dtype((np.record, {whole}))")
    return source.replace("dtype=np.int32", "dtype=np.int64").replace('"i4"', '"i8"')


class Recorder:
    """A pytest plugin: which lines of the targets each test runs, how long it takes, whether it passes."""

    def __init__(self, folder: Path, targets: Iterable[str]) -> None:
        self.files = {str(folder / one): one for one in targets}
        self.tests: dict[str, dict[str, Any]] = {}
        self.lines: dict[str, set[int]] = defaultdict(set)
        self.always: dict[CodeType, bool] = {}

    def trace(self, frame: FrameType, event: str, _: Any) -> Any:
        """Follow the functions of the targets only."""
        if event == "line":
            self.lines[frame.f_code.co_filename].add(frame.f_lineno)
            return self.trace
        if event == "call" and frame.f_code.co_filename in self.files:
            self.lines[frame.f_code.co_filename].add(frame.f_lineno)
            return self.trace
        return None

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """Begin a test."""
        self.lines.clear()
        self.tests[nodeid] = {"passed": False, "begun": time.process_time(), "lines": {}}
        signal.setitimer(signal.ITIMER_PROF, LONGEST_TEST_S)
        sys.settrace(self.trace)

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Note how a part of it went."""
        if report.when == "call":
            self.tests[report.nodeid]["passed"] = report.passed

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        """End it."""
        sys.settrace(None)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        one = self.tests[nodeid]
        one["seconds"] = time.process_time() - one.pop("begun")
        one["lines"] = {self.files[name]: sorted(at) for name, at in self.lines.items() if name in self.files}


class Chooser:
    """A pytest plugin: run these tests alone, in this order."""

    def __init__(self, order: list[str]) -> None:
        self.order = {name: k for k, name in enumerate(order)}

    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        """Drop the others."""
        items[:] = sorted(
            (one for one in items if one.nodeid in self.order), key=lambda one: self.order[one.nodeid]
        )

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Note which test failed."""
        note_failed(report)


def note_failed(report: Any) -> None:
    """Write a failed test's file into the folder, which is the working folder."""
    if report.failed:
        Path("failed").write_text(report.nodeid.partition("::")[0])


class Server:
    """A pytest plugin: all tests are collected once; then every job forks, changes a function, runs some."""

    def __init__(self, folder: Path, pipe: Any) -> None:
        self.folder, self.pipe = folder, pipe

    def pytest_runtestloop(self, session: Any) -> bool:
        """Do jobs until the pipe is closed."""
        items = {one.nodeid: one for one in session.items}
        with contextlib.suppress(EOFError):
            while True:
                source, mutant, tests = self.pipe.recv()
                chosen = [items[name] for _, name in tests]

                def work(source: str = source, mutant: Mutant = mutant, chosen: Any = chosen) -> int:
                    put_in(self.folder, source, mutant)
                    for one, after in itertools.zip_longest(chosen, chosen[1:]):
                        session.config.hook.pytest_runtest_protocol(item=one, nextitem=after)
                        if session.testsfailed:
                            return 1
                    return 0

                self.pipe.send(in_child(self.folder, work, limit_s=time_limit_s(tests)))
        return True

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Note which test failed."""
        note_failed(report)


def module_of(mutant: Mutant) -> Any:
    """Return the imported module that a mutant changes."""
    name = mutant.path.removeprefix("src/").removesuffix(".py").replace("/", ".")
    return importlib.import_module(name)


def put_in(folder: Path, source: str, mutant: Mutant) -> None:
    """Give the function that a mutant changes its changed code, whoever holds that function."""
    function = function_of(mutant)
    text = uncompiled(mutated(source, mutant))
    wanted = function.__code__.co_qualname
    (code,) = (
        one
        for one in codes_in(compile(text, str(folder / mutant.path), "exec", dont_inherit=True))
        if one.co_qualname == wanted
    )
    function.__code__ = code


def codes_in(code: CodeType) -> Iterator[CodeType]:
    """Yield a code and all in it."""
    yield code
    for one in code.co_consts:
        if isinstance(one, CodeType):
            yield from codes_in(one)


def function_of(mutant: Mutant) -> Any:
    """Return the function of a module or class that a mutant changes."""
    value: Any = module_of(mutant)
    for part in mutant.function.split("."):
        value = inspect.unwrap(vars(value)[part])
        if isinstance(value, property):
            value = value.fget
        elif isinstance(value, functools.cached_property):
            value = value.func
        value = getattr(value, "__func__", value)
        if inspect.isfunction(value):
            return value
    raise LookupError(mutant.name)


class TooLongError(BaseException):
    """A test was stopped."""


def too_long(*_: object) -> None:
    """Stop a test; the signal handler."""
    raise TooLongError


def in_child(folder: Path, work: Any, *, limit_s: float) -> str:
    """Run a function in a forked process in a folder: ``passed``, ``failed`` or ``timeout``."""
    child = os.fork()
    if child == 0:
        code = 3
        try:
            os.chdir(folder)
            sys.path[:0] = [str(folder / "src")]
            os.setsid()
            resource.setrlimit(resource.RLIMIT_CPU, (round(limit_s), round(limit_s) + 2))
            resource.setrlimit(resource.RLIMIT_DATA, (6 << 30, 6 << 30))
            quiet = os.open(folder / "log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(quiet, 1)
            os.dup2(quiet, 2)
            code = int(work())
        finally:
            os._exit(code)
    until = time.monotonic() + 8.0 * limit_s
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            break
        if time.monotonic() > until:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child, signal.SIGKILL)
            _, status = os.waitpid(child, 0)
            break
        time.sleep(0.002)
    if os.WIFSIGNALED(status):
        return "timeout"
    return "passed" if os.WEXITSTATUS(status) == 0 else "failed"


def run_tests(files: list[str], plugin: Any, *options: str) -> int:
    """Run pytest in this process."""
    import pytest  # noqa: PLC0415 - known to the processes that fork only

    quiet = ("-q", "--no-header", "--tb=line", "-p", "no:cacheprovider", "-W", "ignore")
    return int(
        pytest.main([*quiet, "-o", "addopts=--import-mode=importlib", *options, *files], plugins=[plugin])
    )


def record(folder: Path, file: str, targets: list[str]) -> dict[str, Any]:
    """Run a file of tests once; its tests by name."""
    where = folder / "recorded.json"
    where.unlink(missing_ok=True)

    def work() -> int:
        signal.signal(signal.SIGPROF, too_long)
        recorder = Recorder(folder, targets)
        with contextlib.suppress(TooLongError):
            run_tests([file], recorder, "-m", "not slow")
        sys.settrace(None)
        where.write_text(json.dumps({name: one for name, one in recorder.tests.items() if "seconds" in one}))
        return 0

    in_child(folder, work, limit_s=900.0)
    return json.loads(where.read_text()) if where.exists() else {}


def time_limit_s(tests: list[tuple[float, str]]) -> float:
    """Return the processor time that some tests may take in a mutant."""
    return 5.0 + 2.0 * sum(seconds for seconds, _ in tests)


def judge(folder: Path, source: str, mutant: Mutant, tests: list[tuple[float, str]]) -> tuple[str, list[str]]:
    """Run a mutant's tests: ``killed``, ``survived`` or ``timeout``, and the files of tests that say so."""
    failed = folder / "failed"
    failed.unlink(missing_ok=True)
    if mutant.inside_function:
        pipe = server(folder)
        pipe.send((source, mutant, tests))
        took = pipe.recv()
    else:
        took = judge_imported(folder, source, mutant, tests)
    files = [failed.read_text()] if took == "failed" and failed.exists() else files_of(tests)
    return {"passed": "survived", "failed": "killed"}.get(took, took), files


def files_of(tests: list[tuple[float, str]]) -> list[str]:
    """Return the files of some tests."""
    return list(dict.fromkeys(name.partition("::")[0] for _, name in tests))


def judge_imported(folder: Path, source: str, mutant: Mutant, tests: list[tuple[float, str]]) -> str:
    """Run the tests of a changed constant or class, which others may hold: all is imported anew."""
    path = folder / mutant.path
    order = [name for _, name in tests]
    files = files_of(tests)

    def work() -> int:
        sys.dont_write_bytecode = True
        return run_tests(files, Chooser(order), "-x", "-p", "no:xdist")

    path.write_text(uncompiled(mutated(source, mutant)))
    try:
        return in_child(folder, work, limit_s=time_limit_s(tests))
    finally:
        path.write_text(uncompiled(source))


def server(folder: Path) -> Any:
    """Return the pipe to this worker's process that has collected all tests; it is made at first use."""
    if "pipe" not in _held:
        ours, theirs = multiprocessing.Pipe()
        if os.fork() == 0:
            ours.close()
            try:
                os.chdir(folder)
                sys.path[:0] = [str(folder / "src")]
                quiet = os.open(folder / "server.log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
                os.dup2(quiet, 1)
                os.dup2(quiet, 2)
                run_tests(_held["tests"], Server(folder, theirs), "-m", "not slow", "-p", "no:xdist")
            finally:
                os._exit(0)
        theirs.close()
        _held["pipe"] = ours
    return _held["pipe"]


def chosen_tests(mutant: Mutant, tests: dict[str, dict[str, Any]]) -> list[tuple[float, str]]:
    """Return (seconds, name) of tests that run the mutant's lines, the quickest first.

    Lines outside functions are run by imports, so any test that runs something of their file serves.
    """
    first, last = mutant.lines
    fitting: list[tuple[float, str]] = []
    for name, one in tests.items():
        at = one["lines"].get(mutant.path, ())
        if at and (not mutant.inside_function or any(first <= line <= last for line in at)):
            fitting.append((one["seconds"], name))
    kept: list[tuple[float, str]] = []
    for seconds, name in sorted(fitting):
        if kept and sum(one for one, _ in kept) + seconds > SECONDS_A_MUTANT:
            break
        kept.append((seconds, name))
    return kept


def digest(*texts: str) -> str:
    """Return a short hash."""
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:24]


def function_text(source: str, mutant: Mutant) -> str:
    """Return the source of the function a mutant is in; the whole file's for a module's constant."""
    top = mutant.function.partition(".")[0]
    for node in ast.parse(source).body:
        if top and getattr(node, "name", None) == top:
            return ast.unparse(node)
    return source


def make_copy(folder: Path) -> None:
    """Copy the project to a folder, with records that work uncompiled."""
    for name in COPIED:
        where = ROOT / name
        if where.is_dir():
            shutil.copytree(
                where, folder / name, ignore=shutil.ignore_patterns("__pycache__", ".numba_cache")
            )
        elif where.exists():
            shutil.copy(where, folder / name)
    for layer in ("station", "runtime", "channel"):
        for path in (folder / "src").glob(f"*/{layer}/**/*.py"):
            path.write_text(uncompiled(path.read_text()))
    import compileall  # noqa: PLC0415 - once
    import py_compile  # noqa: PLC0415 - once

    by_hash = py_compile.PycInvalidationMode.CHECKED_HASH
    compileall.compile_dir(folder / "src", quiet=2, invalidation_mode=by_hash)


class Fleet:
    """So many processes, each with a copy of the project, that fork for every piece of work."""

    def __init__(self, workers: int, folder: Path, tests: list[str]) -> None:
        self.pool = concurrent.futures.ProcessPoolExecutor(
            workers, initializer=prepare, initargs=(folder, tests)
        )
        self.workers = workers


_held: dict[str, Any] = {}
"""Of this worker: its copy's folder, the files of tests, the pipe to its `Server`."""


def prepare(folder: Path, tests: list[str]) -> None:
    """Make a worker's copy and import what mutants have in common."""
    os.environ |= {"NUMBA_DISABLE_JIT": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    os.environ["PYTHONHASHSEED"] = "0"
    _held["folder"] = folder / str(os.getpid())
    _held["tests"] = tests
    _held["folder"].mkdir()
    make_copy(_held["folder"])
    os.environ["PYTHONPATH"] = str(_held["folder"] / "src")
    sys.path[:] = [one for one in sys.path if Path(one or ".").resolve() != ROOT / "src"]
    for name in ("hypothesis", "numba", "pytest", "scipy.optimize", "scipy.stats"):
        importlib.import_module(name)


def record_here(file: str, targets: list[str]) -> tuple[str, dict[str, Any]]:
    """`record` in this worker's copy."""
    return file, record(_held["folder"], file, targets)


def judge_here(
    source: str, mutant: Mutant, tests: list[tuple[float, str]], until: float
) -> tuple[str, list[str]]:
    """`judge` in this worker's copy, nothing where the time is up."""
    return judge(_held["folder"], source, mutant, tests) if time.time() < until else ("", [])


def read_json(path: Path) -> dict[str, Any]:
    """Return what is kept in a file, or nothing."""
    return json.loads(path.read_text()) if path.exists() else {}


def globbed(patterns: Iterable[str]) -> list[str]:
    """Return the files of some patterns, relative to the project."""
    found = {path.relative_to(ROOT).as_posix() for one in patterns for path in ROOT.glob(one)}
    return sorted(one for one in found if not one.endswith("__init__.py"))


def all_tests(fleet: Fleet, targets: list[str], patterns: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Learn what the tests run, or remember it; the usable ones."""
    sources = digest(*(path.read_text() for path in sorted((ROOT / "src").rglob("*.py"))))
    kept, now = read_json(KEPT / "tests.json"), dict[str, Any]()
    waiting: list[concurrent.futures.Future[tuple[str, dict[str, Any]]]] = []
    keys: dict[str, str] = {}
    for file in globbed(patterns):
        keys[file] = digest(sources, (ROOT / file).read_text(), *targets)
        if kept.get(file, {}).get("key") == keys[file]:
            now[file] = kept[file]
        else:
            waiting.append(fleet.pool.submit(record_here, file, targets))
    for one in concurrent.futures.as_completed(waiting):
        file, tests = one.result()
        now[file] = {"key": keys[file] if tests else "", "tests": tests}
        (KEPT / "tests.json").write_text(json.dumps(kept | now))
        passed = sum(test["passed"] for test in tests.values())
        print(f"  {file}: {passed} of {len(tests)} tests serve", flush=True)
    every = {name: one for file in now.values() for name, one in file["tests"].items()}
    return {n: one for n, one in every.items() if one["passed"] and one["seconds"] < LONGEST_TEST_S}


def difference(source: str, mutant: Mutant) -> list[str]:
    """Return the changed lines."""
    lines = difflib.unified_diff(source.splitlines(), mutated(source, mutant).splitlines(), n=0, lineterm="")
    return [line for line in list(lines)[2:] if not line.startswith("@@")]


def show(
    found: dict[str, str], mutants: dict[str, Mutant], sources: dict[str, str], accepted: set[str]
) -> float:
    """Print the survivors and a table by file; returns the score."""
    table: dict[str, Counter[str]] = defaultdict(Counter)
    for name, verdict in sorted(found.items(), key=lambda one: (mutants[one[0]].path, mutants[one[0]].start)):
        mutant = mutants[name]
        fine = "accepted" if verdict in ("survived", "not run") and name in accepted else verdict
        table[mutant.path][fine] += 1
        if fine in ("survived", "not run"):
            line = sources[mutant.path].encode()[: mutant.start].count(b"\n") + 1
            print(f"{fine}: {name} {mutant.path}:{line} ({mutant.operator})")
            print("\n".join(f"    {text}" for text in difference(sources[mutant.path], mutant)))
    heads = ("killed", "timeout", "accepted", "survived", "not run")
    print("".join(f"{head:>10s}" for head in ("mutants", *heads, "score")), "  file")
    table["all"] = sum(table.values(), Counter[str]())
    for path, counts in sorted(table.items(), key=lambda one: (one[0] == "all", one[0])):
        numbers = "".join(f"{number:10d}" for number in (counts.total(), *(counts[head] for head in heads)))
        print(f"{numbers}{score_of(counts):10.1%}   {path}")
    return score_of(table["all"])


def score_of(counts: Counter[str]) -> float:
    """Return the share of mutants that the tests noticed."""
    return (counts["killed"] + counts["timeout"]) / max(1, counts.total())


def work_through(
    fleet: Fleet, order: list[Mutant], sources: dict[str, str], tests: dict[str, dict[str, Any]], until: float
) -> dict[str, str]:
    """Judge mutants in order until the time is up; verdicts by name."""
    kept, found = read_json(KEPT / "verdicts.json"), dict[str, str]()
    stamps = {name.partition("::")[0]: "" for name in tests}
    stamps = {file: digest((ROOT / file).read_text()) for file in stamps}
    keys: dict[concurrent.futures.Future[tuple[str, list[str]]], tuple[str, str]] = {}
    for mutant in order:
        chosen = chosen_tests(mutant, tests)
        if not chosen:
            found[mutant.name] = "not run"
            continue
        key = digest(function_text(sources[mutant.path], mutant), mutant.name)
        before = kept.get(key, {"verdict": "", "tests": {}})
        same = all(stamps.get(file) == stamp for file, stamp in before["tests"].items())
        whole = before["verdict"] == "killed" or set(before["tests"]) == set(files_of(chosen))
        if before["verdict"] and same and whole:
            found[mutant.name] = before["verdict"]
        else:
            job = fleet.pool.submit(judge_here, sources[mutant.path], mutant, chosen, until)
            keys[job] = mutant.name, key
    for done, job in enumerate(concurrent.futures.as_completed(keys), 1):
        name, key = keys[job]
        verdict, files = job.result()
        if verdict:
            found[name] = verdict
            kept[key] = {"verdict": verdict, "tests": {file: stamps[file] for file in files}}
        if done % 25 == 0 or done == len(keys):
            (KEPT / "verdicts.json").write_text(json.dumps(kept))
            print(f"  {done} of {len(keys)} judged now, {until - time.time():.0f} s are left", flush=True)
    # Up to the first that no time was left for: what was known before would not be a fair sample of the rest.
    reached = itertools.takewhile(lambda one: one.name in found, order)
    return {one.name: found[one.name] for one in reached}


def found_mutants(targets: list[str]) -> Iterator[tuple[str, str, list[Mutant]]]:
    """Yield every target, its text and its mutants."""
    for path in targets:
        source = (ROOT / path).read_text()
        yield path, source, Finder(path, source).found


def main() -> int:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60.0, help="time for everything")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0, help="of the order, and so of the sample")
    parser.add_argument("--most", type=int, default=None, help="how many mutants at most")
    parser.add_argument("--only", nargs="+", default=("",), help="mutants whose name begins so")
    parser.add_argument("--tests", nargs="+", default=TESTS, metavar="GLOB", help="files of tests")
    parser.add_argument("--fresh", action="store_true", help="forget what earlier runs found")
    given = parser.parse_args()
    until = time.time() + 60.0 * given.minutes
    if given.fresh:
        shutil.rmtree(KEPT, ignore_errors=True)
    KEPT.mkdir(parents=True, exist_ok=True)
    targets = globbed(TARGETS)
    sources: dict[str, str] = {}
    mutants: dict[str, Mutant] = {}
    for path, source, some in found_mutants(targets):
        sources[path] = source
        mutants |= {one.name: one for one in some if one.name.startswith(tuple(given.only))}
    order = sorted(mutants.values(), key=lambda one: one.name)
    random.Random(given.seed).shuffle(order)  # noqa: S311 - a sample
    order = order[: given.most]
    print(
        f"{len(mutants)} mutants in {len(targets)} files, seed {given.seed}, {given.minutes:g} minutes",
        flush=True,
    )
    accepted = tomllib.loads(ACCEPTED.read_text()) if ACCEPTED.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        fleet = Fleet(given.workers, Path(folder), globbed(given.tests))
        try:
            tests = all_tests(fleet, targets, given.tests)
            print(f"{len(tests)} tests serve; {until - time.time():.0f} s are left", flush=True)
            found = work_through(fleet, order, sources, tests, until)
        finally:
            fleet.pool.shutdown(cancel_futures=True)
    for name in sorted(set(accepted) - set(mutants)):
        if given.only == ("",):
            print(f"accepted, but there is no such mutant: {name}")
    score = show(found, mutants, sources, set(accepted))
    print(
        f"{score:.1%} of {len(found)} judged, of {len(mutants)}, seed {given.seed}; {LEAST_SCORE:.0%} must be"
    )
    return 0 if score >= LEAST_SCORE else 1


if __name__ == "__main__":
    sys.exit(main())
