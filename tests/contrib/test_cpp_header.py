"""Claims about the C++ header that need no compiler: it speaks the protocol of the schema, and is short."""

import re
from math import prod
from pathlib import Path

import pytest

pytest.importorskip("msgpack", reason="the extra `node` brings MessagePack")

from modelcast.core.kinds import Kind
from modelcast.node.serving.schema import step_protocol
from modelcast.runtime.external.exchange import FOREIGN, SessionSettings

HEADER = (Path(__file__).parents[2] / "contrib" / "cpp" / "modelcast_client.hpp").read_text("utf-8")
ELEMENTS = {"u1": "uint8_t", "u4": "uint32_t", "i8": "int64_t", "f8": "double"}


def members(name: str) -> dict[str, tuple[str, str]]:
    """Members of a struct: type on the wire as its comment says, and type in C++."""
    body = HEADER.split(f"struct {name} {{")[1].split("template <class F>")[0]
    return {
        one.split("=")[0].strip(): (wire, kind)
        for kind, names, wire in re.findall(r"^ +([\w:<>]+) ([^;]+); +// (\S+)$", body, re.MULTILINE)
        for one in names.split(",")
    }


@pytest.mark.parametrize(
    ("struct", "message"),
    [("Settings", "hello"), ("Step", "step"), ("Sent", "sent"), ("Beliefs", "beliefs"), ("Warned", "warned")],
)
def test_its_structs_are_the_messages(struct: str, message: str) -> None:
    fields = dict(step_protocol().messages[message].fields)
    fields.pop("protocol", None)
    found = members(struct)
    assert {name: wire for name, (wire, _) in found.items()} == {
        name: field.type for name, field in fields.items()
    }
    for name, field in fields.items():
        own, kind = field.array(), found[name][1]
        if own is not None:
            assert kind == f"std::vector<{ELEMENTS[field.type[:2]]}>".replace("<u", "<std::u").replace(
                "<i", "<std::i"
            )
    body = HEADER.split(f"struct {struct} {{")[1].split("\n};")[0]
    letters = [own[1] for own in (field.array() for field in fields.values()) if own is not None]
    for name, field in fields.items():
        own = field.array()
        assert f'"{name}", {name}' in body
        if step_protocol().messages[message].origin == "server" and own is not None:
            # As many numbers a row as the schema says; arrays of another length are read alone.
            call, wide = "f" if own[1] == letters[0] else "f.alone", prod(own[2])
            assert f'{call}("{name}", {name}{f", {wide}" if wide > 1 else ""})' in body


def test_its_constants_are_those_of_the_protocol() -> None:
    spoken = step_protocol()
    assert f"constexpr int kProtocol = {spoken.protocol};" in HEADER
    assert f"constexpr std::uint32_t kFrameBytes = {spoken.frame_bytes};" in HEADER
    assert f"constexpr std::int64_t kForeign = {FOREIGN};" in HEADER
    kinds = ", ".join(f"{one.name.lower()} = {one.value}" for one in Kind)
    assert f"enum class Kind : std::uint8_t {{ {kinds} }};" in HEADER
    for message in spoken.messages:
        assert f'"{message}"' in HEADER


def test_its_defaults_are_those_of_python() -> None:
    for name, (wire, _) in members("Settings").items():
        default = re.search(rf'\b{name} = "?([^,;"]+)"?[,;]', HEADER)
        assert default is not None
        if name != "slots":
            own = getattr(SessionSettings(1), name)
            assert (default[1] if wire == "text" else float(default[1])) == own


def test_it_is_short() -> None:
    assert HEADER.count("\n") <= 400
