"""The table of wrong uses: what somebody types, and what modelcast has to say to it.

Files are made by `made_files` in the folder that the commands run in. `tests/cli/test_wrong_uses.py` runs
every row; ``python -m tests.cli.wrong_uses_page --write`` makes docs/wrong-uses.md of them.
"""

import gzip
import json
import math
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

__all__ = ["GROUPS", "WrongUse", "made_files"]


@dataclass(frozen=True)
class WrongUse:
    """A wrong use.

    Parameters
    ----------
    what
        What is wrong, for a reader.
    words
        What follows ``modelcast``.
    cause
        Texts that name the cause: the file, the row, the value.
    remedy
        Text that says what to do.
    code
        The exit code.
    absent
        Module that is not installed.
    room_bytes
        The largest file that the system takes then; None for any.
    """

    what: str
    words: tuple[str, ...]
    cause: tuple[str, ...]
    remedy: str
    code: int = 2
    absent: str = ""
    room_bytes: int | None = None


def _use(
    what: str,
    line: str,
    *cause: str,
    remedy: str,
    code: int = 2,
    absent: str = "",
    room_bytes: int | None = None,
) -> WrongUse:
    return WrongUse(what, tuple(line.split()), cause, remedy, code, absent, room_bytes)


def _table(head: str, row: Callable[[int], str], rows: int = 60) -> str:
    return head + "\n" + "".join(row(k) + "\n" for k in range(rows))


def _plain(k: int) -> str:
    return f"{k / 10:g},{2 * k},{math.sin(k / 10):.6f}"


def _geodetic(latitude: float, longitude: float, step: float = 1e-5) -> str:
    return _table("t_s,lat,lon", lambda k: f"{k / 10:g},{latitude + k * step:.8f},{longitude:.8f}")


_HEAD = "t_s,east_m,north_m"
_GOOD = _table(_HEAD, _plain)

_TEXTS: Mapping[str, str] = {
    "good.csv": _GOOD,
    "empty.csv": "",
    "header.csv": _HEAD + "\n",
    "headless.csv": _table("0,0,0", _plain),
    "strange.csv": _table("stamp,px,py", _plain),
    "twice.csv": _table("t_s,east_m,east_m", _plain),
    "word.csv": _GOOD.replace("\n0.3,", "\noops,"),
    "inf.csv": _GOOD.replace("\n0.3,", "\ninf,"),
    "marks.csv": _table("t_s;east_m;north_m", lambda k: f"{k / 10:.1f};{k},5;0"),
    "backwards.csv": _table(_HEAD, lambda k: _plain(60 - k)),
    "two_cars.csv": _table(_HEAD, lambda k: _plain(k // 2)),
    "milliseconds.csv": _table("t,east_m,north_m", lambda k: f"{100 * k},{2 * k},0"),
    "microseconds.csv": _table("t,east_m,north_m", lambda k: f"{100000 * k},{2 * k},0"),
    "unix_ms.csv": _table(_HEAD, lambda k: f"{1700000000000 + 100 * k},{2 * k},0"),
    "swapped.csv": _geodetic(-83.7, 42.3),
    "swapped_japan.csv": _geodetic(139.7, 35.7),
    "radians.csv": _geodetic(math.radians(42.3), math.radians(-83.7), math.radians(1e-5)),
    "degrees.csv": _table(_HEAD + ",heading_rad", lambda k: f"{_plain(k)},270"),
    "one.csv": _table(_HEAD, _plain, rows=1),
    "notes.txt": "nothing\n",
    "broken.json": '{"schema": 1,',
    "newer.json": '{"schema": 99}',
    "old_run.json": json.dumps({"schema": 1, "command": "evaluate"}),
    "other_run.json": json.dumps({"schema": 2, "command": "compare"}),
    "typo.toml": "[statoin]\nkind = 'vehicle'\n",
}


def made_files(folder: Path) -> None:
    """Make the files that the rows name.

    Parameters
    ----------
    folder
        An empty folder.
    """
    for name, text in _TEXTS.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "utf16.csv").write_text(_GOOD, encoding="utf-16")
    (folder / "picture.csv").write_bytes(bytes(range(256)) * 8)
    (folder / "cut.csv.gz").write_bytes(gzip.compress(_GOOD.encode())[:60])
    (folder / "cut.parquet").write_bytes(b"PAR1" + bytes(200))
    with zipfile.ZipFile(folder / "sheet.xlsx", "w") as sheet:
        sheet.writestr("xl/workbook.xml", "<workbook/>")
    for name in ("nothing", "mine"):
        (folder / name).mkdir()
    (folder / "mine" / "thesis.txt").write_text("mine\n", encoding="utf-8")


GROUPS: Mapping[str, tuple[WrongUse, ...]] = {
    "Files": (
        _use(
            "A file that is not there",
            "evaluate god.csv",
            "god.csv",
            "does not exist",
            remedy="is good.csv meant?",
        ),
        _use(
            "An empty file", "evaluate empty.csv", "empty.csv", "is empty", remedy="Check that it is complete"
        ),
        _use(
            "A header without rows",
            "evaluate header.csv",
            "header.csv",
            "no rows",
            remedy="that it is complete",
        ),
        _use(
            "A folder without trips",
            "evaluate nothing",
            "nothing",
            "no file in this",
            remedy="Name the files",
        ),
        _use("A picture, or other octets", "trips picture.csv", "picture.csv", "no text", remedy="--format"),
        _use(
            "A workbook of Excel",
            "trips sheet.xlsx",
            "sheet.xlsx",
            "workbook",
            remedy="Save the sheet as CSV",
        ),
        _use(
            "UTF-16, as some Windows programs write it",
            "trips utf16.csv",
            "UTF-16",
            remedy="Save it as UTF-8",
        ),
        _use(
            "A packed file cut short", "trips cut.csv.gz", "cut.csv.gz", "ended before", remedy="get it again"
        ),
        _use(
            "A Parquet file cut short", "trips cut.parquet", "cut.parquet", "Parquet", remedy="it is complete"
        ),
        _use(
            "A text that is no table",
            "trips notes.txt",
            "notes.txt",
            "no reader",
            remedy="name that by --format",
        ),
        _use("A result as a trip", "evaluate broken.json", "broken.json", "no reader", remedy="--format"),
    ),
    "Columns, units and times": (
        _use("No line with names", "trips headless.csv", "row 1", "numbers", remedy="names the columns"),
        _use(
            "Unknown names of columns",
            "trips strange.csv",
            "stamp, px, py",
            remedy="--columns 't=stamp,east=?",
        ),
        _use(
            "Two columns of one name",
            "trips twice.csv",
            "'east_m' occurs more",
            remedy="Rename all but the one",
        ),
        _use(
            "A map of a column that is not there",
            "trips good.csv --columns t=zeit,east=east_m,north=north_m",
            "no column 'zeit'",
            remedy="Its columns: t_s, east_m, north_m",
        ),
        _use(
            "A map without meanings", "trips good.csv --columns t_s,east_m", "'t_s'", remedy="t=time,east=x"
        ),
        _use(
            "A word among the numbers",
            "trips word.csv",
            "word.csv, row 5",
            "'oops'",
            remedy="Correct the value",
        ),
        _use(
            "A time that is infinite",
            "trips inf.csv",
            "inf.csv, row 5",
            "'inf'",
            remedy="leave the cell blank",
        ),
        _use("Decimal commas and points", "trips marks.csv", "'0.0'", "'0,5'", remedy="one mark of decimals"),
        _use("Times backwards", "trips backwards.csv", "row 3", "5.9 after 6", remedy="Sort the file"),
        _use(
            "Two vehicles without a column that tells them apart",
            "trips two_cars.csv",
            "row 3",
            "does not increase",
            remedy="one row per time",
        ),
        _use("Milliseconds as seconds", "trips milliseconds.csv", "grows by 100", remedy="t_ms=t"),
        _use("Microseconds as seconds", "trips microseconds.csv", "grows by 100000", remedy="t_ms=t"),
        _use("Unix times in milliseconds", "trips unix_ms.csv", "row 2", "1700000000000", remedy="t_ms=t_s"),
        _use(
            "Latitude and longitude swapped",
            "trips swapped.csv",
            "-83.7",
            "south of all",
            remedy="lat=lon,lon=lat",
        ),
        _use(
            "The same, beyond 90 degrees",
            "trips swapped_japan.csv",
            "139.7",
            "beyond 90",
            remedy="lat=lon,lon=lat",
        ),
        _use(
            "Positions in radians", "trips radians.csv", "0.738", "at sea", remedy="lat_rad=lat,lon_rad=lon"
        ),
        _use(
            "Headings in degrees called radians", "trips degrees.csv", "270", "radians", remedy="heading_deg="
        ),
        _use("A trip of one row", "evaluate one.csv", "1 samples", remedy="a window needs"),
    ),
    "Options": (
        _use("A misspelt command", "evalute good.csv", '"evalute"', remedy='"evaluate"'),
        _use("A file without a command", "good.csv", '"good.csv"', remedy="modelcast evaluate good.csv"),
        _use("The word help", "help", '"help"', remedy="type --help"),
        _use("No trip at all", "evaluate", "at least one trip", remedy="modelcast evaluate --help"),
        _use("A misspelt option", "evaluate good.csv --treshold 0.2", "--treshold", remedy="--threshold"),
        _use(
            "An option of another command",
            "evaluate good.csv --density 5",
            "--density",
            remedy="evaluate --help",
        ),
        _use(
            "A unit behind the number",
            "evaluate good.csv --threshold 20cm",
            '"20cm"',
            remedy="the number alone",
        ),
        _use(
            "Commas between numbers",
            "evaluate good.csv --threshold 0.2,0.5",
            '"0.2,0.5"',
            remedy="--threshold 0.2 0.5",
        ),
        _use(
            "Files behind numbers", "evaluate --threshold 0.2 good.csv", '"good.csv"', remedy="files before"
        ),
        _use(
            "A threshold below zero", "evaluate good.csv --threshold -0.2", "-0.2", remedy="must be positive"
        ),
        _use(
            "A threshold in centimetres",
            "evaluate empty.csv --threshold 20",
            "20",
            remedy="in metres: 20 cm is 0.2",
        ),
        _use("Losses in per cent", "evaluate good.csv --per 40", "40", remedy="40 % is 0.4"),
        _use("Half a run", "evaluate good.csv --seeds 2.5", "--seeds", '"2.5"', remedy="whole number"),
        _use(
            "A misspelt bank",
            "evaluate good.csv --bank gp-intersept",
            "gp-intersept",
            remedy="is gp-intercept",
        ),
        _use(
            "A bank joined by commas", "evaluate good.csv --bank cv,gp-linear", "cv,gp-linear", remedy="by +"
        ),
        _use("A misspelt format", "trips good.csv --format cvs", "'cvs'", remedy="is csv"),
        _use("A misspelt rule", "evaluate good.csv --protocol sensors", '"sensors"', remedy='"sensor"'),
        _use("A sensor that is none", "evaluate good.csv --sensor gps", "'gps'", remedy="gnss"),
        _use(
            "Options that contradict each other",
            "evaluate good.csv --sensor gnss --protocol recorded",
            "--protocol recorded",
            remedy="leave one of the two out",
        ),
        _use(
            "A trip that is not in the file",
            "trips good.csv --trip car*",
            "car*",
            remedy="there are good/vehicle",
        ),
        _use("A higher rate than recorded", "trips good.csv --rate 100", "10", remedy="100"),
        _use(
            "Processes for a single file", "evaluate good.csv --jobs 4", "--jobs 4", remedy="modelcast ingest"
        ),
        _use("An option of another one", "trips good.csv --top 3", "--top", remedy="--rank"),
        _use("The standard input as a trip", "evaluate -", "-", remedy="write it into a file"),
        _use("A misspelt policy", "network --policy j2495", "j2495", remedy="is j2945 meant?"),
        _use("A misspelt radio", "network --radio dscr", "dscr", remedy="is dsrc meant?"),
        _use(
            "A setting that a radio has not",
            "network --radio dsrc:preset=deployed",
            "deployed",
            remedy="deployed-obu",
        ),
        _use("A misspelt scenario", "network --scenario highwy", "highwy", remedy="is highway meant?"),
        _use("A density below zero", "network --density -5", "-5", remedy="must be positive"),
        _use(
            "Recorded traffic without a recording", "network --scenario trips", "trips", remedy="--trips FILE"
        ),
        _use("A misspelt application", "network --application fcww", "fcww", remedy="is fcw meant?"),
        _use(
            "A candidate to compare with that is none",
            "compare good.csv --bank cv paper --against fre",
            "'fre'",
            remedy="is free meant?",
        ),
    ),
    "Profiles and runs": (
        _use(
            "A profile that is not there",
            "evaluate good.csv --profile brokn.json",
            "brokn.json",
            remedy="is broken.json meant?",
        ),
        _use(
            "A damaged profile",
            "evaluate good.csv --profile broken.json",
            "no JSON",
            remedy="modelcast train",
        ),
        _use(
            "A profile of a newer modelcast",
            "evaluate good.csv --profile newer.json",
            "schema 99",
            remedy="reads up to",
        ),
        _use(
            "A run of an older modelcast", "evaluate --rerun old_run.json", "schema 1", remedy="options anew"
        ),
        _use("A run of another command", "evaluate --rerun other_run.json", "'compare'", remedy="'evaluate'"),
        _use("A run and trips", "evaluate good.csv --rerun old_run.json", "--rerun", remedy="only --out"),
    ),
    "Places to write to": (
        _use(
            "A file as the output folder",
            "evaluate good.csv --out notes.txt",
            "notes.txt",
            remedy="another output",
        ),
        _use("A folder of your own", "evaluate good.csv --out mine", "thesis.txt", remedy="move them away"),
        _use(
            "The input as the output",
            "convert good.csv --out good.csv",
            "is the input",
            remedy="name another",
        ),
        _use(
            "An unknown kind of table",
            "convert good.csv --out good.xlsx",
            "good.xlsx",
            remedy=".csv or .parquet",
        ),
        _use("A folder that is not there", "convert good.csv --out gone/good.csv", "gone", remedy="make it"),
        _use("No output at all", "convert good.csv", "--out", remedy="modelcast convert --help"),
        _use(
            "A disk that is full, here by a limit on the size of files",
            "convert good.csv --out large.csv",
            "--out large.csv cannot be written",
            remedy="Make room there",
            room_bytes=1024,
        ),
    ),
    "Messages and nodes": (
        _use("Digits that are none", "decode 00zz", "column 3: 'z'", remedy="hexadecimal"),
        _use("A message cut short", "decode 0014", "8 bits needed", remedy="ends early"),
        _use(
            "A message without what it must have",
            "encode {}",
            "message_count, temporary_id and yaw_rate_radps",
            remedy="may be left out",
        ),
        _use("A field that no message has", 'encode {"speed":3}', "speed", remedy="the fields are"),
        _use("A receiver that is none", "node --gnss usb", "'usb'", remedy="write gpsd://HOST:PORT"),
        _use(
            "A trip to drive that is not there",
            "node --gnss trip:god.csv",
            "god.csv",
            remedy="is good.csv meant?",
        ),
        _use("A misspelt table of a node", "node typo.toml", "[statoin]", remedy="There are [station]"),
        _use("A port that is none", "serve --port 99999", "99999", remedy="from 0 to 65535"),
        _use("Nothing to view", "view", "log", remedy="--demo"),
    ),
    "Parts that are not installed": (
        _use(
            "Traffic by SUMO",
            "network --scenario sumo-highway",
            "Traffic by SUMO",
            remedy="install eclipse-sumo libsumo",
            absent="libsumo",
        ),
        _use(
            "Training",
            "train good.csv --out mine.json",
            "modelcast train",
            remedy="install jax optax scipy",
            absent="jax",
        ),
        _use("The page of a node", "view --demo", "the page", remedy="install cantools", absent="starlette"),
    ),
}
"""All rows, by subject."""
