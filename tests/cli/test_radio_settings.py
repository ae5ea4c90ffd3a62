"""Claims about settings of radios on the command line."""

import json
from pathlib import Path

import pytest

from modelcast.channel.radio_presets import PRESETS
from modelcast.channel.radio_words import radio_keys
from modelcast.cli.app import USAGE, run

SMALL = (
    "network --density 20 --length 300 --duration 2 --warm-up 1 --seeds 1 --policy bsm-10hz --jobs 1 --quiet"
)


@pytest.mark.slow
def test_settings_make_another_radio_of_the_same_traffic(tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = ("dsrc", "dsrc:sensitivity_dbm=-60")
    assert run([*SMALL.split(), "--radio", *words, "--out", str(out)]) == 0
    rows = json.loads((out / "summary.json").read_text())["runs"]
    assert [row["radio"] for row in rows] == list(words)
    assert rows[0]["delivery_ratio"] > rows[1]["delivery_ratio"] + 0.3
    assert rows[0]["message_rate_hz"] == rows[1]["message_rate_hz"]


def test_a_setting_that_does_not_exist_ends_before_anything_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert run([*SMALL.split(), "--radio", "dsrc:noise_figure=3", "--out", str(out)]) == USAGE
    told = capsys.readouterr().err
    assert "--radio: The radio 'dsrc' refuses its settings: there is no setting 'noise_figure'" in told
    assert "is noise_figure_db meant?" in told
    assert not out.exists()


@pytest.mark.parametrize("radio", ["sidelink:keep_ratio=0.4", "nr"])
def test_a_relay_is_refused_on_a_radio_that_reserves_with_settings_too(
    radio: str, capsys: pytest.CaptureFixture[str]
) -> None:
    more = ["--roadside", "50,0", "--relay", "--radio", "dsrc", radio, "--density", "5"]
    assert run([*SMALL.split(), *more]) == USAGE
    assert f"a station of --radio {radio} holds one" in " ".join(capsys.readouterr().err.split())


def test_two_words_for_one_policy_end_before_anything_runs(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["network", "--policy", "j3161:power_control=yes", "j3161:power_control=true"]) == USAGE
    assert "is 'j3161:power_control=yes': name it once" in " ".join(capsys.readouterr().err.split())


def test_a_path_loss_without_heights_is_refused_beside_units_before_anything_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    more = ["--roadside", "50,0", "--radio", "dsrc", "dsrc:path_loss=log-distance", "--out", str(out)]
    assert run([*SMALL.split(), *more]) == USAGE
    assert "--radio: The radio 'dsrc' refuses its settings: antennas are raised" in capsys.readouterr().err
    assert not out.exists()


def test_all_settings_and_presets_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["network", "--radio-settings", "--radio", "dsrc", "ideal"]) == 0
    told = capsys.readouterr().out
    for name in ("dsrc", "ideal"):
        assert all(f"\n  {one.key} " in told for one in radio_keys(name))
    assert all(f"preset={name}: " in told for name in PRESETS["dsrc"])
    assert run(["network", "--radio-settings", "--radio", "dsrc", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["dsrc"]["presets"]["wilab"]["settings"]["antenna_gain_db"] == 3.0
    assert [one["key"] for one in document["dsrc"]["settings"]] == [one.key for one in radio_keys("dsrc")]
