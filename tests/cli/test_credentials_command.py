"""Claims about ``modelcast credentials``, and a node that is told to sign with them."""

from pathlib import Path

import pytest

from modelcast.cli.app import run


def test_new_makes_what_show_tells_and_a_node_takes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, config = tmp_path / "keys", tmp_path / "node.toml"
    assert run(["credentials", "new", str(folder), "--count", "2", "--days", "3"]) == 0
    made = capsys.readouterr().out
    assert "2 pseudonym certificates, 2 of them good now" in made
    assert run(["credentials", "show", str(folder)]) == 0
    assert capsys.readouterr().out == made
    config.write_text(f'[security]\nmode = "signed"\nfolder = "{folder}"\n', encoding="utf-8")
    assert run(["node", str(config), "--check"]) == 0
    assert "all is as it should be" in capsys.readouterr().out


def test_a_node_whose_certificates_end_soon_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, config = tmp_path / "keys", tmp_path / "node.toml"
    assert run(["credentials", "new", str(folder), "--count", "1", "--days", "1"]) == 0
    config.write_text(f'[security]\nmode = "signed"\nfolder = "{folder}"\n', encoding="utf-8")
    assert run(["node", str(config), "--check"]) == 0
    assert "the last certificate ends in 2" in capsys.readouterr().err


def test_a_person_signs_with_a_persons_certificate(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for speaks, fine in (("people", True), ("vehicles", False), ("both", True)):
        folder, config = tmp_path / speaks, tmp_path / "node.toml"
        assert run(["credentials", "new", str(folder), "--count", "1", "--speaks", speaks]) == 0
        security = f'[security]\nmode = "signed"\nfolder = "{folder}"\n'
        config.write_text(f'[station]\nkind = "cyclist"\n{security}', encoding="utf-8")
        assert run(["node", str(config), "--check"]) == (0 if fine else 2)
        told = capsys.readouterr().err
        assert ("credentials new --speaks people" in told) is not fine


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["credentials", "show", "nowhere"], "nowhere is no folder: make one"),
        (["credentials", "new", "keys", "--days", "0"], "--days must be from 1"),
        (["credentials", "new", "keys", "--count", "5000"], "count must be from 1 to 1000"),
    ],
)
def test_mistakes_are_told(
    arguments: list[str],
    told: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(arguments) == 2
    assert told in capsys.readouterr().err


def test_a_node_without_the_folder_it_signs_with_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "node.toml"
    config.write_text('\n[security]\nmode = "signed"\n', encoding="utf-8")
    assert run(["node", str(config), "--check"]) == 2
    assert "folder must name credentials" in capsys.readouterr().err
