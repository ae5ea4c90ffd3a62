"""Claims about octets in text: digits, wrapped digits, dumps, arrays, labels."""

import base64

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.io.message_file import pieces_of
from modelcast.io.message_text import pieces_of_text
from modelcast.messages.bsm import BsmCore, encode_bsm
from modelcast.messages.ieee1609 import encode_unsecured


def frame(count: int, more: int = 0) -> bytes:
    core = BsmCore.from_values({"message_count": count, "temporary_id": 1, "yaw_rate_radps": 0.0})
    return encode_bsm(core, regional=((200, bytes(i % 256 for i in range(more))),) if more else ())


PLAIN, LONG = frame(1), frame(2, 100)


def wrapped(octets: bytes, width: int) -> str:
    digits = octets.hex()
    return "".join(f"{digits[i : i + width]}\n" for i in range(0, len(digits), width))


def rows(octets: bytes, step: int) -> list[tuple[int, bytes]]:
    return [(i, octets[i : i + step]) for i in range(0, len(octets), step)]


def letters(octets: bytes) -> str:
    return "".join(chr(octet) if 0x20 <= octet < 0x7F else "." for octet in octets)


def words(row: bytes, form: str) -> str:
    padded = row + bytes(len(row) % 2)
    return " ".join(
        format(int.from_bytes(padded[i : i + 2], "little"), form) for i in range(0, len(padded), 2)
    )


DUMPS = {
    "xxd": lambda o: "".join(f"{i:08x}: {r.hex(' ', -2):<39}  {letters(r)}\n" for i, r in rows(o, 16)),
    "xxd -g 1": lambda o: "".join(f"{i:08x}: {r.hex(' '):<47}  {letters(r)}\n" for i, r in rows(o, 16)),
    "xxd -b": lambda o: "".join(
        f"{i:08x}: {' '.join(f'{octet:08b}' for octet in r)}  {letters(r)}\n" for i, r in rows(o, 6)
    ),
    "hexdump -C": lambda o: (
        "".join(f"{i:08x}  {r[:8].hex(' ')}  {r[8:].hex(' ')}  |{letters(r)}|\n" for i, r in rows(o, 16))
        + f"{len(o):08x}\n"
    ),
    "hexdump": lambda o: "".join(f"{i:07x} {words(r, '04x')}\n" for i, r in rows(o, 16)) + f"{len(o):07x}\n",
    "od": lambda o: "".join(f"{i:07o} {words(r, '06o')}\n" for i, r in rows(o, 16)) + f"{len(o):07o}\n",
    "od -t x1": lambda o: "".join(f"{i:07o} {r.hex(' ')}\n" for i, r in rows(o, 16)) + f"{len(o):07o}\n",
    "od -A d -t x1": lambda o: "".join(f"{i:07d} {r.hex(' ')}\n" for i, r in rows(o, 16)) + f"{len(o):07d}\n",
    "od -b": lambda o: "".join(f"{i:07o} {' '.join(f'{x:03o}' for x in r)}\n" for i, r in rows(o, 16)),
    "wireshark": lambda o: "".join(f"{i:04x}  {r.hex(' '):<47}   {letters(r)}\n" for i, r in rows(o, 16)),
}


@pytest.mark.parametrize("printed", DUMPS.values(), ids=DUMPS)
@given(data=st.binary(min_size=1, max_size=90))
def test_a_dump_is_read_back(printed: object, data: bytes) -> None:
    assert callable(printed)
    (piece,) = pieces_of_text(printed(data))
    assert (piece.octets, piece.fault) == (data, "")


def test_a_row_of_a_dump_that_stands_for_copies_is_unfolded() -> None:
    text = "00000000: 0014 2500\n00000004: 0000 0000\n*\n00000010: 0001\n"
    (piece,) = pieces_of_text(text)
    assert piece.octets == bytes.fromhex("00142500" + "00" * 12 + "0001")


def test_two_dumps_in_one_file_are_two_runs() -> None:
    text = DUMPS["xxd"](PLAIN) + DUMPS["xxd"](LONG)
    assert [piece.octets for piece in pieces_of_text(text)] == [PLAIN, LONG]


@given(width=st.integers(1, 600), joined=st.booleans(), secured=st.booleans())
def test_wrapped_digits_are_one_run(width: int, joined: bool, secured: bool) -> None:
    """At any width, odd ones too; in an SPDU or not; alone, and behind a blank line."""
    octets = encode_unsecured(LONG) if secured else LONG
    text = wrapped(octets, width)
    (piece,) = pieces_of_text(text.replace("\n", "\n\n") if joined else text)
    assert piece.octets == octets


@given(width=st.integers(8, 100))
def test_wrapped_digits_of_several_messages_are_all_read(width: int) -> None:
    found = [piece.octets for piece in pieces_of_text(wrapped(PLAIN + LONG + PLAIN, width))]
    assert b"".join(found) == PLAIN + LONG + PLAIN


def test_wrapped_padding_belongs_to_the_message() -> None:
    (piece,) = pieces_of_text(wrapped(PLAIN + bytes(200), 60))
    assert piece.octets == PLAIN + bytes(200)
    assert piece.place == "lines 1 to 8"


def test_a_line_cut_short_does_not_take_the_next_message() -> None:
    cut, whole = pieces_of_text(f"{LONG.hex()[:60]}\n{PLAIN.hex()}\n")
    assert (cut.place, cut.octets, cut.announced) == ("line 1", LONG[:30], len(LONG))
    assert (whole.place, whole.octets) == ("line 2", PLAIN)


SPELLINGS = {
    "blanks": PLAIN.hex(" "),
    "colons, capitals": PLAIN.hex(":").upper(),
    "dashes": PLAIN.hex("-"),
    "words": PLAIN.hex(" ", 4),
    "0x": f"0x{PLAIN.hex()}",
    "0x each": ", ".join(f"0x{octet:02x}" for octet in PLAIN),
    "0x each, short": " ".join(f"{octet:#x}" for octet in PLAIN),
    "escapes": "".join(f"\\x{octet:02x}" for octet in PLAIN),
    "quoted": f'"{PLAIN.hex()}"',
    "label": f'BSM_1 = "{PLAIN.hex()}"',
    "label, blanks": f"received: {PLAIN.hex(' ')}",
    "JSON": f'{{"t": 1.5, "payload": "{PLAIN.hex()}", "certificate": "0123456789abcdef0123"}}',
    "CSV": f"1700000000,12,{PLAIN.hex()}",
    "CSV of digits": f"10,0123456789abcdef,{PLAIN.hex()}",
    "tabs": f"12\t{PLAIN.hex()}",
    "XML": f"<payload>{PLAIN.hex()}</payload>",
    "Python octets": repr(PLAIN),
    "Python list": str(list(PLAIN)),
    "C array": "const uint8_t frame[40] = {\n "
    + ",\n ".join(", ".join(f"0x{x:02X}" for x in row) for _, row in rows(PLAIN, 12))
    + "\n};\nunsigned int frame_len = 40;",
}


@pytest.mark.parametrize("text", SPELLINGS.values(), ids=SPELLINGS)
def test_octets_are_read_however_they_are_spelled(text: str) -> None:
    (piece,) = pieces_of_text(text)
    assert (piece.octets, piece.fault) == (PLAIN, "")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_text_is_read_in_any_of_its_encodings(encoding: str, end: str) -> None:
    text = f"{PLAIN.hex()}{end}# Straße{end}{LONG.hex()}{end}"
    assert [piece.octets for piece in pieces_of(text.encode(encoding))] == [PLAIN, LONG]


def test_text_in_latin_letters_is_text() -> None:
    (piece,) = pieces_of(f"Straße: {PLAIN.hex()}".encode("latin-1"))
    assert piece.octets == PLAIN


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("Basic Safety Messages", "column 3: 's' is not a hexadecimal digit"),
        (f"O{PLAIN.hex()[1:]}", "column 1: 'O' is not a hexadecimal digit"),
        (f"{PLAIN.hex()[:10]}g{PLAIN.hex()[11:]}", "column 11: 'g' is not a hexadecimal digit"),
        (PLAIN.hex()[1:], "an odd number of hexadecimal digits: 79"),
        (f"x: {PLAIN.hex()[:-1]}", "an odd number of hexadecimal digits: 79"),
        ("x: 0123456789abcdef, fedcba9876543210", "columns 4, 22"),
    ],
)
def test_what_holds_no_octets_tells_why(text: str, told: str) -> None:
    (piece,) = pieces_of_text(text)
    assert piece.octets == b""
    assert told in piece.fault


def wrapped_base64(octets: bytes, letters: int) -> str:
    text = base64.b64encode(octets).decode()
    return "\n".join(text[at : at + letters] for at in range(0, len(text), letters))


@pytest.mark.parametrize(
    ("text", "places"),
    [
        (base64.b64encode(PLAIN).decode(), ["line 1"]),
        (base64.b64encode(PLAIN).decode().rstrip("="), ["line 1"]),
        (base64.urlsafe_b64encode(PLAIN).decode(), ["line 1"]),
        (f'"p": "{base64.b64encode(PLAIN).decode()}"', ["line 1, column 7"]),
        (wrapped_base64(PLAIN, 20), ["lines 1 to 3"]),
        (wrapped_base64(PLAIN, 16) + "\n\n" + base64.b64encode(PLAIN).decode(), ["lines 1 to 4", "line 6"]),
        ("\n".join([base64.b64encode(PLAIN).decode()] * 3), ["line 1", "line 2", "line 3"]),
        (base64.b64encode(PLAIN).decode() + "\n" + PLAIN.hex(), ["line 1", "line 2"]),
    ],
)
def test_base64_is_read_beside_digits(text: str, places: list[str]) -> None:
    found = list(pieces_of_text(text))
    assert [piece.place for piece in found] == places
    assert {piece.octets for piece in found} == {PLAIN}


def test_base64_of_other_octets_is_read_where_it_stands_alone() -> None:
    """Of a short message with its WAVE head; inside a text such letters may be anything."""
    octets = b"\x03\x0f\x01\xac\x01\x00" + PLAIN
    (piece,) = pieces_of_text(base64.b64encode(octets).decode())
    assert piece.octets == octets
    (piece,) = pieces_of_text(f"it is {base64.b64encode(octets).decode()}")
    assert piece.fault


@given(st.binary(min_size=4, max_size=60))
def test_no_base64_of_a_message_is_digits_alone(rest: bytes) -> None:
    """So a line is one of the two, and nobody has to say which."""
    for head in (b"\x00\x14", b"\x00\xf0", b"\x03\x80\x20\x00\x14", b"\x03\x81\x00\x40\x03\x80"):
        text = base64.b64encode(head + rest).decode().rstrip("=")
        assert not set("0123456789abcdefABCDEF").issuperset(text)


@given(st.text(max_size=200) | st.text("0123456789abcdef \n:,x*{}[]|", max_size=200))
def test_any_text_is_pieces_with_octets_or_a_fault(text: str) -> None:
    assert all(bool(piece.octets) != bool(piece.fault) for piece in pieces_of_text(text))


@given(st.binary(max_size=200))
def test_any_file_is_pieces_with_octets_or_a_fault(content: bytes) -> None:
    assert all(bool(piece.octets) != bool(piece.fault) for piece in pieces_of(content))
