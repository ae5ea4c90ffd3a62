"""The public names are typed: user code checks under strict pyright and mypy, wrong user code does not."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
RIGHT = ("api.py", "stations.py")
PLUGINS = ("disc_radio", "following_gap", "forecast_policy")
"""Packages of others, in `examples`; chord's bare `np.ndarray` is too loose for strict mypy."""

WRONG = """from modelcast import AbstractApplication, Bank, ErrorDriven, Motions, Station, evaluate
ErrorDriven(0.3, start="first")
Bank("cv")
evaluate([]).rates.lower()
evaluate(3)
Station("mbc").sense("now", (0.0, 0.0))
Station("mbc").hear([1, 2], received_s=[0.0, 0.0])


class Nothing(AbstractApplication):
    def judge(self, host: Motions, remote: Motions) -> str:
        return "danger"
"""
WRONG_LINES = {2, 3, 4, 5, 6, 7, 11}


def complaints(folder: Path, *words: str) -> dict[str, set[int]]:
    """Lines of each file about which a checker complains."""
    ended = subprocess.run(  # noqa: S603 - our own command
        [sys.executable, "-m", *words, str(folder)], capture_output=True, text=True, check=False, cwd=folder
    )
    found: dict[str, set[int]] = {}
    for line in ended.stdout.splitlines():
        place, told, _ = line.partition(": error: ") if ": error: " in line else line.partition(" - error: ")
        if told:
            name, row = place.strip().split(":")[:2]
            found.setdefault(Path(name).name, set()).add(int(row))
    assert found, ended.stdout + ended.stderr
    return found


@pytest.fixture(name="programs")
def _programs(tmp_path: Path) -> Path:
    """A folder with programs of users, right and wrong."""
    for name in RIGHT:
        shutil.copy(HERE / name, tmp_path)
    (tmp_path / "wrong.py").write_text(WRONG, encoding="utf-8")
    return tmp_path


def test_user_code_type_checks_and_wrong_user_code_does_not(programs: Path) -> None:
    settings = '{"typeCheckingMode": "strict", "pythonVersion": "3.11"}'
    (programs / "pyrightconfig.json").write_text(settings, encoding="utf-8")
    found = complaints(programs, "pyright", "--pythonpath", sys.executable, "-p")
    assert set(found) == {"wrong.py"}
    assert found["wrong.py"] == WRONG_LINES


@pytest.mark.slow
def test_mypy_takes_what_pyright_takes(programs: Path) -> None:
    """Modelcast itself is kept silent, as where it is installed; packages of others check too."""
    for name in PLUGINS:
        shutil.copytree(HERE.parents[1] / "examples" / name / "src", programs, dirs_exist_ok=True)
    followed = ("--follow-imports=silent", "--python-version=3.11", "--no-error-summary")
    found = complaints(programs, "mypy", "--strict", *followed, f"--cache-dir={programs / 'cache'}")
    assert set(found) == {"wrong.py"}
    assert found["wrong.py"] == WRONG_LINES
