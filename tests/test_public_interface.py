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


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_nothing_inside_the_package_imports_from_its_top(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, "absolute imports only"
            assert node.module != "modelcast"
        if isinstance(node, ast.Import):
            assert "modelcast" not in {alias.name for alias in node.names}


@pytest.mark.parametrize("path", [path for path in MODULES if path.name != "__init__.py"], ids=name_of)
def test_every_module_states_what_it_offers_and_has_it(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    offered = [
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
    ]
    assert len(offered) == 1
    kinds = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
    defined = {node.name for node in tree.body if isinstance(node, kinds)}
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
        defined |= {item.id for target in targets for item in ast.walk(target) if isinstance(item, ast.Name)}
    assert set(offered[0]) <= defined
    assert len(set(offered[0])) == len(offered[0])
    assert ast.get_docstring(tree)


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_kernels_live_in_kernel_modules_and_nothing_else_compiles(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    decorated = re.search(r"(?m)^@kernel\b", text) is not None
    assert not decorated or path.stem.endswith("_kernels")
    compiles = re.search(r"(?<!jax\.)\b(njit|cfunc|vectorize|guvectorize|jit)\b\(?", text)
    assert not compiles or path.name == "kernel.py"
