"""Claims about ``modelcast profile``: it shows what the profile holds, and tells all differences."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from modelcast.cli.app import USAGE, run
from modelcast.io.profile import write_profile
from modelcast.messages.sizes import SizeModel
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.profile import Profile, default_profile
from modelcast.models.trusted import Trusted
from modelcast.report.profile import profile_differences, profile_document


def test_it_shows_members_horizons_sizes_and_the_record(capsys: pytest.CaptureFixture[str]) -> None:
    profile = default_profile()
    assert run(["profile", "show", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document == json.loads(json.dumps(profile_document(profile)))
    assert document["sha256"] == profile.identity
    assert document["wire_number"] == profile.identity[:6]
    members = document["members"]
    assert [one["name"] for one in members] == [one.name for one in profile.bank.members]
    sizes = SizeModel().each_update_bytes(profile.bank, profile.identify)
    assert [one["update_octets"] for one in members] == sizes.tolist()
    ctra = next(one for one in members if one["name"] == "ctra")
    assert (ctra["kind"], ctra["carried"], ctra["bits"]) == ("ConstantTurnRateAcceleration", "by Part I", 0)
    assert ctra["trusted_horizon_s"] == profile.bank.members[2].trusted_horizon_s
    others = [one["name"] for where in ("shelf", "regimes", "added") for one in document[where]]
    assert [*(one["name"] for one in members), *others] == [one.name for one in profile.sub_models]
    assert document["training"]["trips"] == len(profile.record["trips"]) == 50
    assert sum(document["training"]["formats"].values()) == 50
    assert document["training"]["settings"]["seed"] == profile.record["seed"]


def test_the_tables_name_every_sub_model(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    assert run(["profile", "show", "default"]) == 0
    shown = capsys.readouterr().out
    assert all(f" {one.name} " in shown for one in default_profile().sub_models)
    assert "trained on 50 trips" in shown
    assert default_profile().identity in shown


def test_nothing_differs_from_itself_and_every_change_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = default_profile()
    assert profile_differences(first, first) == ()
    cv = first.bank.members[3]
    bank = Bank((*first.bank.members[:2], Trusted(ConstantVelocity(2.0), 3.0)), "", first.bank.plain)
    second = replace(
        first,
        bank=bank,
        calibrations={},
        selector=None,
        costs={},
        start="order",
        shelf=first.shelf[1:],
        record={**first.record, "seed": 7},
    )
    write_profile(second, tmp_path / "second.json")
    assert run(["profile", "diff", "default", str(tmp_path / "second.json"), "--json"]) == 0
    told = {one["place"]: (one["first"], one["second"]) for one in json.loads(capsys.readouterr().out)}
    assert isinstance(cv, ConstantVelocity)
    assert told["members.ctra"] == ("Trusted", "")
    assert told["members.cv.is"] == ("ConstantVelocity", "Trusted")
    assert told["start"] == ("guarded", "order")
    assert told["shelf.free-context"] == ("FreeMotion", "")
    assert told["record.seed"] == ("0", "7")
    assert told["calibrations.cv"][1] == ""
    assert "members.free.estimates" not in told


def test_arrays_are_told_by_how_far_they_are_apart() -> None:
    profile = default_profile()
    learned = profile.sub_model("learned")
    weights = learned.networks[0].weights_1.copy()  # type: ignore[union-attr]
    weights[0, 0] += 0.5
    networks = (replace(learned.networks[0], weights_1=weights), *learned.networks[1:])  # type: ignore[union-attr]
    at = profile.shelf.index(learned)  # type: ignore[arg-type]
    changed = replace(learned, networks=networks)  # type: ignore[type-var]
    other = replace(profile, shelf=(*profile.shelf[:at], changed, *profile.shelf[at + 1 :]))
    (found,) = profile_differences(profile, other)
    assert found.place.startswith("shelf.learned.networks")
    assert found.first in found.second
    assert np.isfinite(weights).all()


def test_two_that_hold_the_same_are_said_to(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    write_profile(default_profile(), tmp_path / "copy.json")
    assert run(["profile", "diff", "default", str(tmp_path / "copy.json")]) == 0
    assert "hold the same" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("words", [["show", "nowhere.json"], ["diff", "default", "nowhere.json"], ["diff"]])
def test_mistakes_are_refused(words: list[str]) -> None:
    assert run(["profile", *words]) == USAGE


def test_a_profile_without_a_record_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_profile(Profile(Bank((ConstantVelocity(),))), tmp_path / "bare.json")
    assert run(["profile", "show", str(tmp_path / "bare.json")]) == 0
    assert "no training trips are recorded" in capsys.readouterr().out
