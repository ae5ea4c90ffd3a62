"""Packed recordings: read as what they hold, and refused where they are damaged, encrypted or bombs."""

import gzip
import zipfile

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io import packed, unpacking
from modelcast.io.recordings import Recordings
from modelcast.io.registry import FORMATS, detect_format
from modelcast.io.trips import read_trips

_FOLDERS = {"comma2k19", "kitti-oxts"}
"""Recordings that are folders, which gzip does not pack."""

_SEVERAL = {"smartloc", "kitti-poses", "highd", "ind"}
"""Recordings of several files, which an archive packs together and gzip does not."""


def same(one, other):
    assert one.trip_id == other.trip_id
    assert one.reading == other.reading
    assert one.origin == other.origin
    assert one.columns().keys() == other.columns().keys()
    for name, column in one.columns().items():
        assert column.tobytes() == other.columns()[name].tobytes(), name


def zipped(path, files, method=zipfile.ZIP_DEFLATED):
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, octets in files.items():
            archive.writestr(name, octets)
    return path


def csv_text(rows=30, first=0.0):
    lines = (f"{0.1 * at},{first + at},0" for at in range(rows))
    return "t,x,y\n" + "\n".join(lines) + "\n"


@pytest.mark.parametrize("name", sorted(FORMATS.keys() - _FOLDERS - _SEVERAL))
def test_every_format_is_read_from_gzip_as_it_is_read_plain(made, name, tmp_path):
    plain = made.valid(name)
    path = tmp_path / f"{plain.name}.gz"
    path.write_bytes(gzip.compress(plain.read_bytes()))
    assert detect_format(path) == name
    for one, other in zip(read_trips(path), read_trips(plain), strict=True):
        same(one, other)


@pytest.mark.parametrize("name", sorted(FORMATS.keys() - _FOLDERS))
def test_every_format_is_read_from_an_archive_as_it_is_read_plain(made, name, tmp_path):
    plain = made.valid(name)
    files = {
        f"day 1/{file.relative_to(made.folder)}": file.read_bytes()
        for file in made.folder.rglob("*") if file.is_file()
    }  # fmt: skip
    archive = zipped(tmp_path / "all.zip", files)
    for one, other in zip(read_trips(archive), read_trips(plain), strict=True):
        same(one, other)


def test_each_member_of_an_archive_is_a_recording(tmp_path):
    files = {
        "b/one.csv": csv_text(), "a/two.csv.gz": gzip.compress(csv_text(40).encode()),
        ".hidden.csv": csv_text(), "__MACOSX/one.csv": csv_text(), "notes.txt": "nothing", "b/": "",
    }  # fmt: skip
    archive = zipped(tmp_path / "drives.zip", files)
    told = {}
    trips = list(read_trips(archive, on_skipped=told.__setitem__))
    assert [(trip.trip_id, len(trip)) for trip in trips] == [("two/vehicle", 40), ("one/vehicle", 30)]
    assert {name.removeprefix(f"{archive}/"): why for name, why in told.items()} == {
        ".hidden.csv": "hidden: unpack it to have it read",
        "__MACOSX/one.csv": "hidden: unpack it to have it read",
        "notes.txt": "no reader knows this file",
    }
    (trip,) = read_trips(f"{archive}/b/one.csv")
    assert trip.trip_id == "one/vehicle"


def test_members_of_one_name_are_told(tmp_path):
    path = zipped(tmp_path / "a.zip", {"one.csv": csv_text(40), "two.csv": csv_text(30)})
    path.write_bytes(path.read_bytes().replace(b"two.csv", b"one.csv"))
    told = {}
    assert [len(trip) for trip in read_trips(path, on_skipped=told.__setitem__)] == [30]
    assert told == {f"{path}/one.csv": "several members have this name: only the last of them is read"}


def test_why_no_member_is_a_recording_is_told(tmp_path):
    inner = zipped(tmp_path / "in.zip", {"one.csv": csv_text()})
    outer = zipped(tmp_path / "out.zip", {"in.zip": inner.read_bytes()})
    with pytest.raises(DataFormatError, match=r"knows \(out\.zip/in\.zip: is an archive in an archive"):
        list(read_trips(outer))
    other = zipped(tmp_path / "other.zip", {"one.csv": csv_text()}, zipfile.ZIP_LZMA)
    with pytest.raises(DataFormatError, match=r"knows \(other\.zip/one\.csv: is packed by method 14"):
        list(read_trips(other))


def test_an_archive_in_a_folder_is_searched_and_its_recordings_are_named_by_it(tmp_path):
    folder = tmp_path / "all"
    folder.mkdir()
    zipped(folder / "drives.zip", {"one.csv": csv_text()})
    (folder / "two.csv").write_text(csv_text())
    recordings = Recordings(folder)
    found = list(recordings)
    assert [recordings.label(one.path) for one in found] == ["all/drives.zip/one.csv", "all/two.csv"]
    assert [[trip.trip_id for trip in one.trips()] for one in found] == [["one/vehicle"], ["two/vehicle"]]


def test_what_is_wrong_in_a_packed_file_is_told_with_its_line_and_place(tmp_path):
    archive = zipped(tmp_path / "a.zip", {"one.csv": csv_text() + "soon,0,0\n", "two.csv": csv_text()})
    with pytest.raises(DataFormatError, match=r"a\.zip/one\.csv, row 32: t is 'soon'"):
        list(read_trips(archive))


def test_a_recording_that_needs_a_copy_is_told_by_its_own_path(made, tmp_path):
    octets = made.valid("parquet").read_bytes()
    damaged = octets[:200] + bytes(40) + octets[240:]
    archive = zipped(tmp_path / "a.zip", {"day/one.parquet": damaged})
    with pytest.raises(DataFormatError, match=r"a\.zip/day/one\.parquet: is not readable as Parquet"):
        list(read_trips(archive))


@pytest.mark.parametrize("cut", [12, 200, 1000])
def test_gzip_cut_short_is_an_error(tmp_path, cut):
    rng = np.random.default_rng(0)
    text = csv_text() + "".join(f"{3 + 0.1 * at},{rng.normal()},0\n" for at in range(200))
    whole = gzip.compress(text.encode())
    path = tmp_path / "a.csv.gz"
    path.write_bytes(whole[:cut])
    with pytest.raises(DataFormatError, match=r"a\.csv\.gz: cannot be unpacked: .*cut short"):
        list(read_trips(path, "csv"))


def test_gzip_with_a_changed_octet_is_an_error(tmp_path):
    octets = bytearray(gzip.compress(csv_text().encode()))
    octets[-6] ^= 1
    path = tmp_path / "a.csv.gz"
    path.write_bytes(octets)
    with pytest.raises(DataFormatError, match=r"cannot be unpacked: CRC check failed"):
        list(read_trips(path))


@pytest.mark.parametrize("kind", ["gz", "zip"])
def test_more_than_a_recording_can_unpack_to_is_refused(tmp_path, monkeypatch, kind):
    monkeypatch.setattr(packed, "FREE_BYTES", 2**18)
    text = csv_text().encode() + b"9,0,0\n" * 10**6
    path = tmp_path / f"a.csv.{kind}"
    if kind == "gz":
        path.write_bytes(gzip.compress(text))
    else:
        path = zipped(tmp_path / "a.zip", {"a.csv": text})
    with pytest.raises(DataFormatError, match=r"unpacks to over [\d,]+ octets from [\d,]+, 250 times"):
        list(read_trips(path))


def test_a_copy_larger_than_allowed_is_refused_and_removed(made, tmp_path, monkeypatch):
    monkeypatch.setattr(unpacking, "MOST_COPIED_BYTES", 1000)
    monkeypatch.setattr(unpacking.tempfile, "tempdir", str(tmp_path / "copies"))
    (tmp_path / "copies").mkdir()
    archive = zipped(tmp_path / "a.zip", {"one.parquet": made.valid("parquet").read_bytes()})
    with pytest.raises(DataFormatError, match=r"one\.parquet: takes over 0 GiB unpacked"):
        list(read_trips(archive))
    assert list((tmp_path / "copies").iterdir()) == []


def test_encrypted_members_are_told(tmp_path):
    archive = zipped(tmp_path / "a.zip", {"one.csv": csv_text()})
    octets = bytearray(archive.read_bytes())
    for mark, at in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        octets[octets.index(mark) + at] |= 1
    archive.write_bytes(octets)
    with pytest.raises(DataFormatError, match=r"a\.zip: is encrypted\. Unpack it with its password"):
        list(read_trips(archive))
    with pytest.raises(DataFormatError, match=r"a\.zip/one\.csv: is encrypted"):
        list(read_trips(f"{archive}/one.csv", "csv"))


def test_other_methods_and_missing_members_are_errors(tmp_path):
    archive = zipped(tmp_path / "a.zip", {"one.csv": csv_text()}, zipfile.ZIP_BZIP2)
    with pytest.raises(DataFormatError, match="is packed by method 12, not deflate"):
        list(read_trips(f"{archive}/one.csv", "csv"))
    with pytest.raises(DataFormatError, match="is not in the archive"):
        list(read_trips(f"{archive}/two.csv"))


@pytest.mark.parametrize("octets", [b"PK", b"PK\x03\x04" + bytes(50), b"PK\x05\x06" + b"\xff" * 18])
def test_a_damaged_archive_is_an_error(tmp_path, octets):
    path = tmp_path / "a.zip"
    path.write_bytes(octets)
    with pytest.raises(DataFormatError, match=r"a\.zip: (is no archive|holds)"):
        list(read_trips(path))


def test_an_archive_of_too_many_members_is_refused_before_its_list_is_read(tmp_path, monkeypatch):
    archive = zipped(tmp_path / "a.zip", {f"{at}.csv": "" for at in range(30)})
    monkeypatch.setattr(packed, "MOST_MEMBERS", 20)
    with pytest.raises(DataFormatError, match="holds 30 members"):
        list(read_trips(archive))


def test_a_column_map_goes_to_packed_text(tmp_path):
    path = tmp_path / "a.csv.gz"
    path.write_bytes(gzip.compress(csv_text().replace("t,x,y", "clock,px,py").encode()))
    (trip,) = read_trips(path, columns={"t": "clock", "east": "px", "north": "py"})
    assert (trip.trip_id, len(trip)) == ("a/vehicle", 30)
