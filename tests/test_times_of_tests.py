"""Claims about the tool that tells which tests take the time."""

import runpy
from pathlib import Path
from typing import Any

import pytest

TOOL = runpy.run_path(str(Path(__file__).parents[1] / "tools" / "times_of_tests.py"))

RUN = """<testsuites><testsuite>
<testcase classname="tests.a" name="one[1]" time="1.5"/>
<testcase classname="tests.a" name="two" time="0.25"/>
<testcase classname="tests.b" name="one" time="4.0"><skipped/></testcase>
</testsuite></testsuites>"""


@pytest.fixture
def run(tmp_path: Path) -> Path:
    path = tmp_path / "run.xml"
    path.write_text(RUN)
    return path


def test_times_are_those_of_each_test_and_of_its_module(run: Path) -> None:
    times = TOOL["read_times"](run)
    assert times == {"tests.a::one[1]": 1.5, "tests.a::two": 0.25, "tests.b::one": 4.0}
    assert TOOL["times_by_file"](times) == {"tests.a": 1.75, "tests.b": 4.0}


@pytest.mark.parametrize(("limit", "code", "named"), [("4", 0, ()), ("3.9", 1, ("tests.b::one",))])
def test_a_test_over_the_limit_is_named(
    run: Path, limit: str, code: int, named: tuple[str, ...], capsys: pytest.CaptureFixture[Any]
) -> None:
    assert TOOL["main"]([str(run), "--limit", limit, "--most", "1"]) == code
    shown = capsys.readouterr()
    assert shown.out.splitlines() == [
        "3 tests, 6 s in all processes together",
        "     4.0 s  tests.b",
        "",
        "     4.0 s  tests.b::one",
    ]
    assert shown.err == "".join(f"over {limit} s: shorten {name}, or mark it slow\n" for name in named)
