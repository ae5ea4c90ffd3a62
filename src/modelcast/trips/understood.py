"""What a reader took a file for, where the file leaves that open: its columns, units, marks and clock.

A guess that nobody sees is a wrong figure that nobody notices. Readers that guess say what they guessed here;
`modelcast trips` shows it before all else, and an evaluation keeps it with its trips.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["Understood"]


@dataclass(frozen=True, slots=True)
class Understood:
    """What was taken for what in one recording.

    Parameters
    ----------
    columns
        The file's column of each meaning, in words of a column map (`modelcast.io.column_meanings`), which
        state the unit.
    unused
        Columns that are not read, in order.
    suggested
        Those of them that a column map might take, by their names and first numbers: the column of each
        meaning.
    notes
        What else was told by the content or only assumed, by subject (``text``, ``time``, ``position``,
        ``assumed``, ...), in words.
    """

    columns: Mapping[str, str] = field(default_factory=dict[str, str])
    unused: tuple[str, ...] = ()
    suggested: Mapping[str, str] = field(default_factory=dict[str, str])
    notes: Mapping[str, str] = field(default_factory=dict[str, str])

    @property
    def unused_text(self) -> str:
        """What is not read, with the column map that would read what looks like something; empty for none.

        Examples
        --------
        >>> Understood({}, ("foo", "v"), {"speed_kmh": "v"}).unused_text
        "foo, v (perhaps: --columns 'speed_kmh=v')"
        """
        perhaps = f" (perhaps: --columns '{_map(self.suggested)}')" if self.suggested else ""
        return ", ".join(self.unused) + perhaps

    def lines(self) -> dict[str, str]:
        """Return what there is to say, by subject.

        Examples
        --------
        >>> Understood({"t": "Time", "lat": "Breite"}, ("foo",)).lines()
        {'columns': 't=Time, lat=Breite', 'not used': 'foo'}
        """
        said = {"columns": _map(self.columns, ", "), **self.notes, "not used": self.unused_text}
        return {subject: text for subject, text in said.items() if text}

    def document(self) -> dict[str, object]:
        """Return it as plain values."""
        return {
            "columns": dict(self.columns),
            "unused": list(self.unused),
            "suggested": dict(self.suggested),
            "notes": dict(self.notes),
        }


def _map(columns: Mapping[str, str], mark: str = ",") -> str:
    return mark.join(f"{meaning}={name}" for meaning, name in columns.items())
