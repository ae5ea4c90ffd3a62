"""Gathering rows by trip: whatever the order, the blocks and the limit, the same rows of every trip."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import DataFormatError
from modelcast.io import gathering
from modelcast.io.gathering import AbstractKeyedRows, KeyedBlock, gathered
from modelcast.io.rows import Rows

ROW_BYTES = 16
"""The line and one column."""


class Listed(AbstractKeyedRows[str]):
    """Rows whose trips are the letters of a text, cut into blocks."""

    def __init__(
        self, letters: str, cuts: list[int], *, expected: bool = True, partial: bool = False
    ) -> None:
        self.path = "listed"
        self.letters, self.partial, self._expected = letters, partial, expected
        self.bounds = sorted({0, len(letters), *(cut for cut in cuts if cut <= len(letters))})
        self.passes: list[bool] = []
        self.read = 0

    @property
    def columns(self) -> int:
        """One."""
        return 1

    @property
    def rows_expected(self) -> int | None:
        """All, or none where it is not to be known."""
        return len(self.letters) if self._expected else None

    def called(self, key: str) -> str:
        """By its letter."""
        return f"listed/{key}"

    def blocks(self, *, rows: bool) -> Iterator[KeyedBlock[str]]:
        """The pieces."""
        self.passes.append(rows)
        for index, (begin, end) in enumerate(pairwise(self.bounds)):
            self.read = index
            letters = self.letters[begin:end]
            keys = list(dict.fromkeys(letters))
            number = np.array([keys.index(letter) for letter in letters], dtype=np.int64)
            line = np.arange(begin + 1, end + 1)
            held = Rows(line, {"value": line * 0.5}) if rows else None
            last = end == len(self.letters)
            yield KeyedBlock(index, keys, number, held, partial=self.partial and last)


letters = st.text("abcd", min_size=1, max_size=60)


@given(letters=letters, cuts=st.lists(st.integers(1, 60)), held=st.integers(0, 2000), known=st.booleans())
def test_every_trip_has_its_rows_in_order_or_is_refused_for_its_length(letters, cuts, held, known):
    longest = max(map(letters.count, letters))
    file = Listed(letters, cuts, expected=known, partial=True)
    held_bytes = held + len(letters) * ROW_BYTES * (held % 2)
    if longest * ROW_BYTES > held_bytes:
        with pytest.raises(DataFormatError, match=r"the trip listed/[a-d] has over \d+ rows"):
            list(gathered(file, held_bytes))
        return
    found = list(gathered(file, held_bytes))
    assert sorted(one.key for one in found) == sorted(set(letters))
    for one in found:
        expected = [at + 1 for at, letter in enumerate(letters) if letter == one.key]
        assert one.rows.line.tolist() == expected
        assert one.rows.columns["value"].tolist() == [0.5 * at for at in expected]
        assert one.partial == (one.key == letters[-1])


@given(letters=letters, cuts=st.lists(st.integers(1, 60)))
def test_what_is_open_at_once_stays_within_the_limit(letters, cuts):
    held_bytes = max(map(letters.count, letters)) * (ROW_BYTES + 500)
    file = Listed(letters, cuts, expected=False)
    extents = gathering._extents(file, held_bytes)
    place = extents.place
    for chosen in gathering._shared_out(extents, file, held_bytes):
        for block in range(len(file.bounds)):
            opened = [at for at in chosen if extents.first[at] <= block <= extents.last[at]]
            assert sum(extents.rows[at] for at in opened) * ROW_BYTES <= held_bytes or len(opened) == 1
    assert sum(extents.rows) == len(letters)
    assert set(place) == set(letters)


def test_what_fits_is_read_once_and_comes_in_order_of_first_rows():
    file = Listed("babcab", [2, 4])
    assert [one.key for one in gathered(file, 10**6)] == ["b", "a", "c"]
    assert file.passes == [True]


def test_what_does_not_fit_comes_as_soon_as_its_last_block_is_read():
    file = Listed("aaaabbbbcccc", [4, 8])
    trips = gathered(file, 190)
    assert (next(trips).key, file.read) == ("a", 0)
    assert (next(trips).key, file.read) == ("b", 1)
    assert file.passes == [False, True]


def test_a_file_of_too_many_trips_is_refused(monkeypatch):
    monkeypatch.setattr(gathering, "MOST_TRIPS", 3)
    with pytest.raises(DataFormatError, match="over 3 trips"):
        list(gathered(Listed("abcd", [1, 2]), 60))


class OfOneTrip(Listed):
    """Rows that are known to be of one trip before they are read."""

    only = "a"


def test_one_trip_that_is_known_to_be_too_long_is_refused_before_it_is_read():
    file = OfOneTrip("a" * 10, [5])
    with pytest.raises(DataFormatError, match="the trip listed/a has over 9 rows"):
        list(gathered(file, 9 * ROW_BYTES))
    assert not file.passes
    (trip,) = gathered(OfOneTrip("a" * 10, [5]), 10_000)
    assert len(trip.rows) == 10


@pytest.mark.parametrize("held", [1_000_000, 60])
def test_a_name_that_is_too_long_is_refused(monkeypatch, held):
    monkeypatch.setattr(gathering, "MOST_NAME_BYTES", len("listed/a"))
    with pytest.raises(DataFormatError, match=r"a trip has over 8 octets: listed/ä\.\.\."):
        list(gathered(Listed("abaä", [1, 2]), held))


def test_a_file_without_rows_is_refused():
    with pytest.raises(DataFormatError, match="no rows"):
        list(gathered(Listed("", [])))
