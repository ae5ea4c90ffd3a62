"""Lines out of chunks."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from modelcast.node.inputs.lines import LineSplitter

MEGABYTES = 10


@given(st.binary(max_size=200), st.lists(st.integers(0, 200), max_size=8), st.integers(1, 30))
def test_lines_do_not_depend_on_how_the_octets_were_cut(octets: bytes, cuts: list[int], most: int):
    whole, cut = LineSplitter(most), LineSplitter(most)
    bounds = [0, *sorted(min(at, len(octets)) for at in cuts), len(octets)]
    pieces = [octets[low:high] for low, high in pairwise(bounds)]
    assert [line for piece in pieces for line in cut.feed(piece)] == whole.feed(octets)
    assert cut.overlong == whole.overlong
    assert cut.held == whole.held


@given(st.binary(max_size=200), st.integers(1, 30))
def test_lines_are_those_of_the_octets_that_are_not_too_long(octets: bytes, most: int):
    pieces = octets.replace(b"\r", b"\n").split(b"\n")
    splitter = LineSplitter(most)
    assert splitter.feed(octets) == [piece for piece in pieces[:-1] if 0 < len(piece) <= most]
    assert splitter.overlong == sum(len(piece) > most for piece in pieces)


def test_ten_megabytes_without_a_line_end_hold_no_memory_and_count_once():
    splitter = LineSplitter(16_384)
    for _ in range(MEGABYTES * 16):
        assert splitter.feed(bytes(65_536).replace(b"\0", b"x")) == []
        assert splitter.held <= 16_384
    assert splitter.feed(b"\nnext\n") == [b"next"]
    assert splitter.overlong == 1
