"""Claims about ``modelcast road``."""

import json
from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.io.road import read_roads
from modelcast.io.write_trips import write_parquet
from modelcast.world.drive import generate_drive


@pytest.fixture(scope="module")
def trips(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two generated drives on a local plane."""
    path = tmp_path_factory.mktemp("roads") / "drives.parquet"
    write_parquet([generate_drive(seed, 120.0).truth for seed in (1, 2)], path)
    return path


def test_a_file_is_built_shown_and_drawn(
    trips: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, figure = tmp_path / "roads.parquet", tmp_path / "roads.png"
    assert run(["road", "build", str(trips), "--out", str(out), "--json"]) == 0
    built = json.loads(capsys.readouterr().out)
    survey = read_roads(out)
    assert (built["cells"], built["trips"], built["places"]) == (len(survey), 2, "local plane")
    assert built["length_km"] == pytest.approx(5e-3 * len(survey))
    assert run(["road", "show", str(out), "--json", "--out", str(figure)]) == 0
    assert json.loads(capsys.readouterr().out) == built
    assert figure.read_bytes().startswith(b"\x89PNG")
    assert run(["road", "show", str(out)]) == 0
    assert "local plane" in capsys.readouterr().out


def test_a_file_keeps_no_more_cells_than_asked_for(trips: Path, tmp_path: Path) -> None:
    out = tmp_path / "roads.parquet"
    assert run(["road", "build", str(trips), "--out", str(out), "--cells", "50", "--quiet"]) == 0
    assert len(read_roads(out)) == 50


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["build"], "name the .parquet"),
        (["build", "--out", "roads.parquet"], "name at least one trip"),
        (["build", "TRIPS", "--out", "roads.csv"], "name the .parquet"),
        (["build", "TRIPS", "--out", "roads.parquet", "--cells", "0"], "--cells must be"),
        (["show"], "name one road file"),
        (["show", "TRIPS"], "no road file"),
        (["show", "TRIPS", "--out", "roads.gif"], "end it in .png, .svg or .pdf"),
    ],
)
def test_wrong_use_is_refused(
    arguments: list[str],
    said: str,
    *,
    trips: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["road", *(str(trips) if one == "TRIPS" else one for one in arguments)]) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.glob("roads.*"))


@pytest.mark.slow
def test_evaluate_takes_a_road_file_and_refuses_what_is_none(
    trips: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    roads, out = tmp_path / "roads.parquet", tmp_path / "out"
    assert run(["road", "build", str(trips), "--out", str(roads), "--quiet"]) == 0
    short = ["--threshold", "0.5", "--per", "0.0", "--seeds", "1", "--no-references", "--bank", "ctra"]
    asked = ["evaluate", str(trips), *short, "--out", str(out), "--quiet"]
    assert run([*asked, "--road", str(roads), "--no-leader"]) == 0
    settings = json.loads((out / "summary.json").read_text())["settings"]
    assert settings["context"]["leader"] is False
    assert settings["context"]["road"] == f"survey {read_roads(roads).digest}"
    named = json.loads((out / "run.json").read_text())
    assert "roads.parquet" in json.dumps(named)
    assert (
        run(["evaluate", "--rerun", str(out / "run.json"), "--out", str(tmp_path / "again"), "--quiet"]) == 0
    )
    capsys.readouterr()
    for wrong in (str(tmp_path / "none.parquet"), str(trips)):
        assert run([*asked, "--road", wrong]) == 2
        assert "road" in capsys.readouterr().err
