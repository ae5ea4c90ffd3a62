"""`docs/upgrading.md`: its new names are there, its old ones are not, and their error names the new."""

import importlib
import re
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

import pytest

import modelcast
from modelcast.core.renamed import RENAMED

PAGE = (Path(__file__).parent.parent / "docs" / "upgrading.md").read_text(encoding="utf-8")
NAME = re.compile(r"`(modelcast(?:\.\w+)+)`")


def pairs(heading: str) -> list[tuple[str, list[str]]]:
    """The rows of the table below a heading: an old name, and the new ones."""
    section = PAGE.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    rows = [line.strip("|").split(" | ") for line in section.splitlines() if line.startswith("| `")]
    return [(NAME.findall(old)[0], NAME.findall(new)) for old, new in rows]


def is_there(name: str) -> bool:
    """Whether a module, or something in one, has this name."""
    home, _, last = name.rpartition(".")
    with suppress(ModuleNotFoundError):
        return hasattr(importlib.import_module(home), last) or find_spec(name) is not None
    return False


@pytest.mark.parametrize("heading", ["Imports", "Modules"])
def test_every_new_name_is_there_and_no_old_one_is(heading: str) -> None:
    rows = pairs(heading)
    assert len(rows) > 10
    for old, new in rows:
        assert new, old
        assert [name for name in new if not is_there(name)] == []
        assert not is_there(old), old


def test_new_imports_are_public_names() -> None:
    for _, new in pairs("Imports"):
        assert {name.removeprefix("modelcast.") for name in new} <= set(dir(modelcast))


def test_a_sub_package_that_is_gone_is_answered_with_what_took_its_place() -> None:
    gone = {old.removeprefix("modelcast."): new for old, new in pairs("Modules") if old.count(".") == 1}
    assert set(gone) == set(RENAMED)
    for old, new in gone.items():
        with pytest.raises(AttributeError, match=f"has no attribute '{old}': since 0.2.0 it is {new[0]}"):
            getattr(modelcast, old)
