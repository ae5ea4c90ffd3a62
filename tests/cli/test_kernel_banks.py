"""Kernel expressions on the command line: how a bank's text is split, and banks of kernels evaluated."""

import json
from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.core.exceptions import ConfigError
from modelcast.io.write_trips import write_csv
from modelcast.models.gp import GaussianProcess, KernelProcess
from modelcast.station.banks import PAPER_NOISE_FLOOR_M, bank_from_text, named_bank, parts_of
from modelcast.world.drive import generate_drive

PROCESSES = "gp(linear+rbf)+gp(matern32)+gp(linear*rq)"
"""One process with several kernels: the set that Algorithm 1 chooses from."""


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("cv", ["cv"]),
        ("cv + gp(linear + rbf)", ["cv", "gp(linear + rbf)"]),
        ("gp((rbf+rq)*linear)+cv", ["gp((rbf+rq)*linear)", "cv"]),
        ("gp(rbf))+cv", ["gp(rbf))", "cv"]),
        ("gp(rbf+cv", ["gp(rbf+cv"]),
    ],
)
def test_a_plus_inside_parentheses_is_the_kernels(text: str, parts: list[str]) -> None:
    assert parts_of(text) == parts


def test_window_and_noise_floor_hold_for_expressions() -> None:
    members = bank_from_text("gp(rbf+linear)+gp(matern32)", window=12, noise_floor_m=0.02).members
    assert members == (
        GaussianProcess(12, "anchored", noise_floor_m=0.02, label="gp(rbf+linear)"),
        KernelProcess("matern32", 12, 0.02),
    )
    closed, general = bank_from_text("gp(linear+rbf)+gp(matern32)").members
    assert isinstance(closed, GaussianProcess)
    assert isinstance(general, KernelProcess)
    assert (closed.noise_floor_m, general.noise_floor_m) == (PAPER_NOISE_FLOOR_M, 0.001)


def test_expressions_need_no_training() -> None:
    assert named_bank("cv+gp(matern32)").trained_on == frozenset()


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("cv+gp(linear", r"a \) is missing in 'gp\(linear'"),
        (
            "gp(lienar+rbf)",
            r"character 1 of 'lienar\+rbf': no kernel is named 'lienar'; there are linear, rbf",
        ),
        ("gp(rbf)+gp( rbf )", "distinct names"),
        ("gp(rbf))", r"character 4 of 'rbf\)'"),
        ("gp-nothing", r"and gp\(\.\.\.\) of a kernel"),
    ],
)
def test_what_is_no_bank_is_refused_with_the_place(text: str, why: str) -> None:
    with pytest.raises(ConfigError, match=f"^--bank .*{why}"):
        bank_from_text(text)


@pytest.fixture(scope="module", name="trip")
def _trip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A generated drive as a file."""
    path = tmp_path_factory.mktemp("trips") / "drive.csv"
    write_csv([generate_drive(seed=5, duration_s=90.0).truth], path)
    return path


def summary(out: Path, trip: Path, bank: str) -> str:
    """What `modelcast evaluate` says of a bank."""
    words = f"--threshold 0.2 0.4 --per 0 --seeds 1 --quiet --noise-floor 0.001 --bank {bank} --out {out}"
    assert run(["evaluate", str(trip), *words.split()]) == 0
    return (out / "summary.json").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_bank_of_several_kernels_is_evaluated(tmp_path: Path, trip: Path) -> None:
    told = summary(tmp_path / "out", trip, f"cv+{PROCESSES}")
    assert json.loads(told)
    for name in ("gp(linear+rbf)", "gp(matern32)", "gp(linear*rq)"):
        assert name in told


@pytest.mark.slow
@pytest.mark.parametrize(("rate_hz", "code"), [(1.0, 0), (0.2, 2)])
def test_a_kernel_that_grows_over_the_window_is_evaluated_or_refused(
    rate_hz: float, code: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "slow.csv"
    write_csv([generate_drive(seed=5, duration_s=100.0 / rate_hz, rate_hz=rate_hz).truth], path)
    bank = f"gp({'*'.join(['linear'] * 6)})"
    words = f"--per 0 --seeds 1 --quiet --window 60 --bank {bank} --out {tmp_path / 'out'}"
    assert run(["evaluate", str(path), *words.split()]) == code
    refused = f"the kernel {bank[3:-1]} grows too much over 60 samples every 5 s"
    assert (refused in capsys.readouterr().err) == bool(code)


@pytest.mark.slow
def test_the_papers_kernel_as_an_expression_sends_what_the_paper_does(tmp_path: Path, trip: Path) -> None:
    named, expression = (
        summary(tmp_path / str(at), trip, bank) for at, bank in enumerate(("gp-anchored", "gp(linear+rbf)"))
    )
    labelled = named.replace("gp-anchored", "gp(linear+rbf)").replace("label=''", "label='gp(linear+rbf)'")
    assert labelled == expression
