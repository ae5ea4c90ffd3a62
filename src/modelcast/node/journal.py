"""What happens to a node, a line of JSON each: for people who read it and programs that follow it."""

import json
import math
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from typing import TextIO, final

from modelcast.core.printable import printable

__all__ = ["Journal"]

_LONGEST = 500


@final
class Journal:
    """Writes events; who writes too many of a kind within a second is counted instead.

    Parameters
    ----------
    file
        Where lines go.
    utc_s
        Gives UTC, since 1970 [s].
    most_a_second
        Lines of one kind of event in one second.

    Examples
    --------
    >>> import io
    >>> file = io.StringIO()
    >>> Journal(file, lambda: 0.5).note("motion", {"mode": "gnss", "place": float("nan")})
    >>> print(file.getvalue(), end="")
    {"event": "motion", "mode": "gnss", "place": null, "utc": "1970-01-01T00:00:00.500Z"}
    """

    def __init__(self, file: TextIO, utc_s: Callable[[], float], *, most_a_second: int = 20) -> None:
        self._file, self._utc_s, self._most = file, utc_s, most_a_second
        self._second: dict[str, tuple[int, int]] = {}
        self.unwritten = 0
        """Events that could not be written, as on a full disk."""

    def note(self, event: str, what: Mapping[str, object]) -> None:
        """Write one event.

        Parameters
        ----------
        event
            Its name.
        what
            What belongs to it: numbers, texts and truth values. What is no number is null.
        """
        now_s = self._utc_s()
        second, noted = self._second.get(event, (math.floor(now_s), 0))
        left_out = 0
        if second != math.floor(now_s):
            left_out, noted = max(noted - self._most, 0), 0
        self._second[event] = (math.floor(now_s), noted + 1)
        if noted >= self._most:
            return
        when = datetime.fromtimestamp(now_s, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        line: dict[str, object] = {name: _plain(value) for name, value in what.items()}
        line |= {"utc": when, "event": event}
        if left_out:
            line["left_out_before"] = left_out
        try:
            self._file.write(json.dumps(line, sort_keys=True, ensure_ascii=False) + "\n")
            self._file.flush()
        except (OSError, ValueError):
            self.unwritten += 1


def _plain(value: object) -> object:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int):
        return value
    return printable(str(value))[:_LONGEST]
