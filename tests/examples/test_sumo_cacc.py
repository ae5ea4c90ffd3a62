"""The example of a two-way loop with SUMO: installed as its users do, and short."""

import importlib.util
import json
import math
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

INSTALLED = importlib.util.find_spec("libsumo") is not None and importlib.util.find_spec("sumo") is not None
pytestmark = pytest.mark.skipif(not INSTALLED, reason="needs SUMO: pip install eclipse-sumo libsumo")

Python = Callable[..., "subprocess.CompletedProcess[str]"]

PROGRAM = """
import json
from dataclasses import asdict
from sumo_cacc.loop import Case, drive, study
rows = [study(Case(*case), vehicles=4, duration_s=12.0, seeds=1)[0] for case in {cases}]
gaps = [drive(Case("mbc", 0.4, 0.02), vehicles=3, duration_s=6.0, seed=7)[0].gap_m.tolist() for _ in range(2)]
print("FOUND", json.dumps([[asdict(row) for row in rows], gaps[0] == gaps[1]]))
"""


def test_maps_drive_vehicles_in_sumo(python_with: Python) -> None:
    cases = [("bsm-10hz", 0.0), ("bsm-10hz", 1.0), ("mbc", 0.0, 0.02)]
    done = python_with(("sumo_cacc",), "-c", PROGRAM.format(cases=cases))
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("FOUND ")]
    (often, deaf, model), same = json.loads(line.removeprefix("FOUND "))
    assert same  # the same seed drives the same
    # Five metres are asked for; messages 0.1 s old and their rounding cost decimetres.
    assert 4.0 < often["gap_min_m"] < 5.0
    assert (often["collisions"], model["collisions"]) == (0, 0)
    assert often["rate_hz"] == pytest.approx(10.0, rel=0.03)
    assert model["rate_hz"] < 5.0
    # Who hears nothing knows nothing, and keeps its speed: the leader swings away and back.
    assert math.isnan(deaf["age_s"])
    assert deaf["gap_min_m"] == pytest.approx(5.0, abs=1e-6)
    assert deaf["rate_hz"] == pytest.approx(10.0, rel=0.03)


def test_the_program_prints_a_line_a_case_and_draws(python_with: Python, tmp_path: Path) -> None:
    picture = tmp_path / "figure.png"
    options = ["--vehicles", "3", "--duration", "7", "--seeds", "1", "--loss", "0", "0.4"]
    done = python_with(("sumo_cacc",), "-m", "sumo_cacc", *options, "--out", str(picture))
    lines = [line.split() for line in done.stdout.splitlines() if line[:4].strip().endswith("%")]
    assert [(line[0], line[1]) for line in lines] == [
        (loss, sender) for loss in ("0%", "40%") for sender in ("bsm-10hz", "bsm-2hz", "mbc")
    ]
    assert picture.read_bytes()[:4] == b"\x89PNG"
