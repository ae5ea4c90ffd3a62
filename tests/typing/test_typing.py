"""The public names are typed: user code checks under pyright strict, and wrong user code does not."""

import subprocess
import sys
from pathlib import Path

WRONG = """from modelcast import Bank, ErrorDriven, evaluate
ErrorDriven(0.3, start="first")
Bank("cv")
evaluate([]).rates.lower()
"""


def complaints(folder: Path) -> list[str]:
    """What pyright strict says about the files of a folder."""
    (folder / "pyrightconfig.json").write_text('{"typeCheckingMode": "strict", "pythonVersion": "3.11"}')
    ended = subprocess.run(  # noqa: S603 - our own command
        [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, "-p", str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    return [line for line in ended.stdout.splitlines() if " - error: " in line]


def test_user_code_type_checks_and_wrong_user_code_does_not(tmp_path: Path) -> None:
    (tmp_path / "right.py").write_text(Path(__file__).with_name("api.py").read_text())
    (tmp_path / "wrong.py").write_text(WRONG)
    found = complaints(tmp_path)
    assert [line for line in found if "right.py" in line] == []
    assert {int(line.split(":")[1]) for line in found if "wrong.py" in line} == {2, 3, 4}
