"""Claims about what users import, and about who imports whom inside the package."""

import ast
import inspect
import pydoc
import re
import subprocess
import sys
from pathlib import Path

import pytest

import modelcast
from modelcast.core.public_names import summary_of

PACKAGE = Path(modelcast.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))
PROMISED = {"read_trips", "Trajectory", "Bank", "ErrorDriven", "Periodic", "evaluate", "EvaluationResult"}


def name_of(path: Path) -> str:
    return path.relative_to(PACKAGE).with_suffix("").as_posix().replace("/", ".")


@pytest.fixture(scope="module")
def trees() -> dict[str, ast.Module]:
    """Every module of the package by its name, parsed once."""
    return {name_of(path): ast.parse(path.read_text(encoding="utf-8")) for path in MODULES}


def test_every_public_name_can_be_imported_and_is_listed() -> None:
    names = [name for name in dir(modelcast) if not name.startswith("_")]
    assert set(names) >= PROMISED
    for name in names:
        found = getattr(modelcast, name)
        assert getattr(found, "__name__", name) == name


def test_help_lists_every_public_name_with_the_first_line_of_its_docstring() -> None:
    shown = pydoc.plain(pydoc.render_doc(modelcast))
    text = modelcast.__doc__
    assert text is not None
    for name, home in modelcast._HOMES.items():
        line = re.search(rf"(?m)^{name}  +(\S.*)$", text)
        assert line is not None, name
        assert line[1] == summary_of(name, home)
        assert line[0] in shown
        docstring = inspect.getdoc(getattr(modelcast, name))
        assert name.isupper() or (docstring or "").startswith(line[1])


def test_a_public_name_without_a_docstring_is_refused() -> None:
    with pytest.raises(LookupError, match=r"modelcast.core.exceptions defines no Nothing"):
        summary_of("Nothing", "core.exceptions")


def test_what_type_checkers_see_is_what_is_imported() -> None:
    """The lazy names and the block for type checkers are two lists: they must not drift apart."""
    tree = ast.parse((PACKAGE / "__init__.py").read_text())
    shown = {
        alias.asname: f"{node.module}"
        for block in tree.body
        if isinstance(block, ast.If)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    homes = {name: f"modelcast.{home}" for name, home in modelcast._HOMES.items()}
    assert shown == homes


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = modelcast.nothing


def test_the_version_is_that_of_the_installed_package() -> None:
    assert modelcast.__version__[0].isdigit()


@pytest.mark.parametrize("module", ["modelcast", "modelcast.__main__", "modelcast.cli.app"])
def test_importing_pulls_in_no_heavy_library_and_prints_nothing(module: str) -> None:
    script = (
        f"import sys, {module}\n"
        "print(*sorted({'numba', 'polars', 'matplotlib', 'scipy', 'pyarrow', 'pandas'} & set(sys.modules)))"
    )
    ended = subprocess.run(  # noqa: S603 - our own script
        [sys.executable, "-W", "error", "-c", script], capture_output=True, text=True, check=True
    )
    assert (ended.stdout.strip(), ended.stderr) == ("", "")


def imports_of_the_top(tree: ast.Module) -> list[str]:
    """Imports that go through the package's own front door, or that are relative."""
    return [
        ast.unparse(node)
        for node in ast.walk(tree)
        if (isinstance(node, ast.ImportFrom) and (node.level or node.module == "modelcast"))
        or (isinstance(node, ast.Import) and "modelcast" in {alias.name for alias in node.names})
    ]


@pytest.mark.slow
def test_nothing_inside_the_package_imports_from_its_top(trees: dict[str, ast.Module]) -> None:
    found = {name: imports_of_the_top(tree) for name, tree in trees.items()}
    assert {name: imports for name, imports in found.items() if imports} == {}


def faults_of_offer(tree: ast.Module) -> list[str]:
    """What is wrong with a module's `__all__` and its docstring."""
    offered = [
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
    ]
    if len(offered) != 1:
        return [f"states __all__ {len(offered)} times"]
    kinds = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
    defined = {node.name for node in tree.body if isinstance(node, kinds)}
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
        defined |= {item.id for target in targets for item in ast.walk(target) if isinstance(item, ast.Name)}
    faults = [f"does not define {name}" for name in offered[0] if name not in defined]
    if len(set(offered[0])) != len(offered[0]):
        faults.append("offers a name twice")
    return faults if ast.get_docstring(tree) else [*faults, "has no docstring"]


def test_every_module_states_what_it_offers_and_has_it(trees: dict[str, ast.Module]) -> None:
    found = {name: faults_of_offer(tree) for name, tree in trees.items() if not name.endswith("__init__")}
    assert {name: faults for name, faults in found.items() if faults} == {}


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ('"""One."""\n__all__ = ["a"]\na: int = 1\n', []),
        ('"""One."""\na = 1\n', ["states __all__ 0 times"]),
        ('"""One."""\n__all__ = ["a", "b"]\na = 1\n', ["does not define b"]),
        ('"""One."""\n__all__ = ["a", "a"]\na = 1\n', ["offers a name twice"]),
        ('__all__ = ["a"]\ndef a(): ...\n', ["has no docstring"]),
    ],
)
def test_a_module_that_offers_wrongly_is_told(text: str, fault: list[str]) -> None:
    assert faults_of_offer(ast.parse(text)) == fault


def test_kernels_live_in_kernel_modules() -> None:
    decorated = {path for path in MODULES if re.search(r"(?m)^@kernel\b", path.read_text(encoding="utf-8"))}
    assert len(decorated) > 1
    assert {name_of(path) for path in decorated if not path.stem.endswith("_kernels")} == set()


def test_nothing_but_the_kernel_decorator_compiles() -> None:
    compiling = re.compile(r"(?<!jax\.)\b(njit|cfunc|vectorize|guvectorize|jit)\b\(?")
    found = [name_of(path) for path in MODULES if compiling.search(path.read_text(encoding="utf-8"))]
    assert [name for name in found if name.rpartition(".")[2] != "kernel"] == []
