"""Claims about golden octets of updates and identifications (`make_model_vectors.py` made them)."""

import json
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from modelcast.messages.bsm import BsmCore
from modelcast.messages.mbc_codec import UpdateCodec
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import UpdateMessage, UpdateReading, read_update
from modelcast.messages.mbc_wire import (
    IdentificationMessage,
    decode_identification,
    encode_identification,
)
from modelcast.models.profile import default_profile
from modelcast.station.banks import bank_from_text, member_names

HERE = Path(__file__).parent
VECTORS: dict[str, Any] = json.loads((HERE / "vectors" / "models.json").read_text(encoding="utf-8"))
NUMBER = int(VECTORS["profile"], 16)
ONE_CODE = 1
"""A value on the edge between two codes may fall to the other side on another machine."""

updates = pytest.mark.parametrize("vector", VECTORS["updates"], ids=lambda vector: vector["bank"])


@pytest.fixture(scope="module", name="sent")
def _sent() -> Callable[..., tuple[UpdateMessage, WireProfile, Any]]:
    return runpy.run_path(str(HERE / "make_model_vectors.py"))["sent"]


def message_of(vector: dict[str, Any]) -> UpdateMessage:
    codes = tuple(tuple(own.values()) for own in vector["coefficients"].values())
    return UpdateMessage(BsmCore(tuple(vector["part_i"])), 0, carries_all=vector["carries_all"], codes=codes)


@updates
def test_an_update_has_its_golden_octets_and_comes_back_from_them(vector: dict[str, Any]) -> None:
    wire = WireProfile.of(bank_from_text(vector["bank"]), NUMBER)
    octets = bytes.fromhex(vector["octets"])
    assert UpdateCodec(wire).encode(message_of(vector)) == octets
    found = read_update(octets, {NUMBER: wire})
    assert found.reading is UpdateReading.MODEL
    assert found.update == message_of(vector)


@updates
def test_a_window_gives_its_golden_codes(
    vector: dict[str, Any], sent: Callable[..., tuple[UpdateMessage, WireProfile, Any]]
) -> None:
    message, _, _ = sent(vector["bank"], carries_all=vector["carries_all"])
    wanted = message_of(vector)
    found = [code for codes in (message.core.codes, *message.codes) for code in codes]
    golden = [code for codes in (wanted.core.codes, *wanted.codes) for code in codes]
    assert len(found) == len(golden)
    assert max(abs(one - other) for one, other in zip(found, golden, strict=True)) <= ONE_CODE


def test_every_kind_of_sub_model_has_its_vector() -> None:
    assert {vector["bank"].removesuffix("+cv") for vector in VECTORS["updates"]} >= set(
        member_names(default_profile())
    )


@pytest.mark.parametrize("vector", VECTORS["identifications"], ids=lambda vector: vector["octets"])
def test_an_identification_has_its_golden_octets(vector: dict[str, Any]) -> None:
    message = IdentificationMessage(
        vector["temporary_id"], vector["sequence"], sub_model=vector["sub_model"], age=vector["age"]
    )
    octets = bytes.fromhex(vector["octets"])
    assert encode_identification(message) == octets
    assert decode_identification(octets) == message
