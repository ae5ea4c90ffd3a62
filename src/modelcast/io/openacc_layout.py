"""What the header of an OpenACC file says: the cars, and which columns each has.

The campaigns of the data set (Casale, Cherasco, Vicolungo, AstaZero, ZalaZONE, JRC) differ in their columns.
A column is a word and the number of a car; `WORDS` says what the words mean. A column with another word is an
error, so that a new quantity is looked at before it is left out.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from modelcast.core.exceptions import DataFormatError
from modelcast.io.text_head import file_head, first_lines, split_fields

__all__ = ["GEODETIC", "LOCAL", "WORDS", "Layout", "openacc_layout"]

WORDS: Mapping[str, str | None] = {
    "Speed": "speed_mps",
    "E": "east_m",
    "N": "north_m",
    "U": "local_up_m",
    "Lat": "lat",
    "Lon": "lon",
    "Alt": "altitude_m",
    "Acc": "acceleration_mps2",
    "Accel": "acceleration_mps2",
    "Acceleration": "acceleration_mps2",
    "A": "acceleration_mps2",
    "VE": None,
    "VN": None,
    "VU": None,
    "IVS": None,
    "Driver": None,
}
"""The words of columns and what they fill; None where a column is known and not used."""

LOCAL, GEODETIC = ("east_m", "north_m"), ("lat", "lon")
_COLUMN = re.compile(r"([A-Za-z]+)(\d+)")
_METADATA_LINES = 20


@dataclass(frozen=True, slots=True)
class Layout:
    """The columns of one file.

    Parameters
    ----------
    names
        The cars, in the order of ``Vehicle_order``; car k is the k-th.
    header
        All fields of the header row.
    line
        Its one-based line.
    cars
        For each car that has a position: the number of the field for each quantity.
    unplaced
        Numbers of cars with columns but without those of a position.
    """

    names: tuple[str, ...]
    header: tuple[str, ...]
    line: int
    cars: Mapping[int, Mapping[str, int]]
    unplaced: frozenset[int]

    @property
    def geodetic(self) -> bool:
        """Whether positions come from latitudes and longitudes, as a car has no east and north."""
        return any(not set(LOCAL) <= fields.keys() for fields in self.cars.values())

    @property
    def height(self) -> str | None:
        """The height that every car has: the altitude, else U, else none."""
        for name in ("altitude_m", "local_up_m"):
            if all(name in fields for fields in self.cars.values()):
                return name
        return None


def openacc_layout(path: str) -> Layout:
    """Return the layout of a file.

    Raises
    ------
    DataFormatError
        Where lines are missing, a column is not known or occurs twice, or the cars have no common frame.
    """
    lines = first_lines(file_head(path))[:_METADATA_LINES]
    order = next((line for line in lines if split_fields(line)[0] == "Vehicle_order"), None)
    at = next((at for at, line in enumerate(lines) if split_fields(line)[0] == "Time"), None)
    if order is None or at is None:
        raise DataFormatError(
            path,
            "no Vehicle_order line with a header row that begins with Time after it",
            remedy="OpenACC files begin with five metadata lines and a header row.",
        )
    names = [name for name in split_fields(order)[1:] if name]
    if len(set(names)) != len(names):
        names = [f"{name}-{number}" for number, name in enumerate(names, start=1)]
    header = split_fields(lines[at])
    cars = _cars(path, header, at + 1, len(names))
    placed = {
        number: fields
        for number, fields in cars.items()
        if set(LOCAL) <= fields.keys() or set(GEODETIC) <= fields.keys()
    }
    layout = Layout(tuple(names), tuple(header), at + 1, placed, frozenset(cars) - frozenset(placed))
    if not placed:
        raise DataFormatError(
            path, "no car has the columns E and N, or Lat and Lon", row=at + 1, remedy="See docs/formats.md."
        )
    local_only = [number for number, fields in placed.items() if not set(GEODETIC) <= fields.keys()]
    if layout.geodetic and local_only:
        raise DataFormatError(
            path, f"car {local_only[0]} has no Lat and Lon, and another has no E and N", row=at + 1,
            remedy="All cars need one kind of position.",
        )  # fmt: skip
    return layout


def _cars(path: str, header: list[str], row: int, count: int) -> dict[int, dict[str, int]]:
    """Return the used fields of every car by number, in order."""
    cars: dict[int, dict[str, int]] = {}
    for place, name in enumerate(header):
        if not name or place == 0:
            continue
        column = _COLUMN.fullmatch(name)
        if column is None or column[1] not in WORDS:
            raise DataFormatError(
                path, f"column {name!r} is not known", row=row,
                remedy=f"Known are {', '.join(WORDS)}, each with the number of a car; leave the column out.",
            )  # fmt: skip
        number, fills = int(column[2]), WORDS[column[1]]
        if header.count(name) > 1:
            raise DataFormatError(path, f"column {name!r} occurs more than once", row=row)
        if column[1] != "IVS" and not 1 <= number <= count:
            raise DataFormatError(
                path, f"{name} has no name; Vehicle_order names {count} cars", row=row,
                remedy="Car k is the k-th name of Vehicle_order.",
            )  # fmt: skip
        if fills is None:
            continue
        if fills in cars.setdefault(number, {}):
            raise DataFormatError(path, f"column {name!r} gives car {number} a second {fills}", row=row)
        cars[number][fills] = place
    return dict(sorted(cars.items()))
