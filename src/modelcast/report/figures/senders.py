"""How the senders of a network evaluation are told apart: in words, and as curves.

A colour and a marker tell policies apart, the line banks, thresholds and settings: solid with small filled
markers for the first, broken, darker and with larger hollow markers for the others, wide for what knows no
bank and no threshold. So each can be seen where several lie on each other.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any

from matplotlib.colors import to_hex, to_rgb

from modelcast.report.figures.panels import drawable
from modelcast.report.style import POLICY_COLOURS
from modelcast.study.network.mixed import mixed_of
from modelcast.study.network.rows import (
    NO_BANK,
    NO_THRESHOLD,
    NetworkResult,
)
from modelcast.study.table import Row
from modelcast.study.wording import centimetres

__all__ = [
    "NO_THRESHOLD_TEXT",
    "Curve",
    "Marker",
    "also_told",
    "density_text",
    "sender_curves",
    "sender_look",
    "threshold_text",
]

Marker = str | tuple[int, int, int]
"""As Matplotlib takes one."""

_COLOURS = {
    "bsm-10hz": "#777777",
    "baseline": POLICY_COLOURS["baseline"],
    "free": POLICY_COLOURS["free"],
    "mbc": POLICY_COLOURS["mbc"],
    "j2945": "#d55e00",
    "j2945-filtered": "#882255",
    "j2945-free": "#7a4b00",
    "j2945-free-relaxed": "#ddaa33",
    "j2945-free-relaxed-5": "#bbbb00",
    "j2945-mbc": "#009e73",
    "j2945-mbc-relaxed": "#56b4e9",
    "j2945-mbc-relaxed-5": "#332288",
    "j3161": "#aa3377",
    "j3161-mbc": "#44bb99",
    "j3161-mbc-relaxed": "#6699cc",
    "cam": "#999933",
    "cam-reactive": "#661100",
    "cam-uncontrolled": "#117733",
    "cam-road": "#4b0092",
}
_SHAPES: tuple[Marker, ...] = (
    *("X", "D", "p", "o", "s", "*", "h", "H", "d", "v", "^", "P", ">", "8"),
    *((5, 0, 36), "<", (4, 1, 0), (6, 1, 0), (3, 1, 0)),
)
"""Filled ones alone, for small ones are seen. Where no letter is: corners, 1 for a star, the angle."""

_MARKERS = dict(zip(_COLOURS, _SHAPES, strict=True))
_OTHER: tuple[str, Marker] = ("#aaaaaa", ".")
"""Look of what has no name here."""
_LINES = ("-", (0, (4, 1.5)), (0, (1, 1.2)), (0, (5, 1.2, 1, 1.2)), (0, (5, 1.2, 1, 1.2, 1, 1.2)))
_DARKER = 0.6
"""Share of its policy's colour that the next lines keep, and of that those after as many more."""

NO_THRESHOLD_TEXT = "-"
"""What tables say of a policy that knows no threshold."""


def density_text(density_per_km: float) -> str:
    """Return a density as tables say it.

    Examples
    --------
    >>> density_text(25.0), density_text(float("nan"))
    ('25', '-')
    """
    return f"{density_per_km:g}" if isfinite(density_per_km) else "-"


def threshold_text(threshold_m: float) -> str:
    """Return a threshold as tables say it.

    Examples
    --------
    >>> threshold_text(0.2), threshold_text(NO_THRESHOLD)
    ('20 cm', '-')
    """
    return centimetres(threshold_m) if isfinite(threshold_m) else NO_THRESHOLD_TEXT


def sender_look(name: str) -> tuple[str, Marker]:
    """Return the colour and the marker of a sender, whatever its word sets.

    Those of no name here, such as by the clock, share one, and so do the words of one name. A mixed fleet
    has that of its new sender.

    Examples
    --------
    >>> sender_look("mbc"), sender_look("bsm-2hz")
    (('#0072b2', 'o'), ('#aaaaaa', '.'))
    >>> sender_look("mbc:grant=periodic"), sender_look("baseline+mbc@25")
    (('#0072b2', 'o'), ('#0072b2', 'o'))
    """
    known = _known(name)
    return _COLOURS.get(known, _OTHER[0]), _MARKERS.get(known, _OTHER[1])


def _known(policy: str) -> str:
    """Name by which a policy is looked up."""
    return mixed_of(policy).senders[-1].partition(":")[0]


def also_told(result: NetworkResult) -> tuple[str, ...]:
    """Return what tells senders of one policy apart: of ``bank`` and ``threshold`` those with several."""
    several = (("bank", len(result.banks) > 1), ("threshold", len(result.thresholds_m) > 1))
    return tuple(name for name, there in several if there)


@dataclass(frozen=True, slots=True)
class Curve:
    """How the rows of one sender are drawn.

    Parameters
    ----------
    policy, bank, threshold_m
        As in `modelcast.study.network.rows.NetworkCase`.
    label
        Its name in the legend.
    place
        Which of the lines of its colour it is, from 0.
    """

    policy: str
    bank: str
    threshold_m: float
    label: str
    place: int

    @property
    def colour(self) -> str:
        """Of lines, markers and intervals."""
        red, green, blue = to_rgb(sender_look(self.policy)[0])
        share = _DARKER ** -(-self.place // len(_LINES))
        return to_hex((share * red, share * green, share * blue))

    @property
    def plain(self) -> Mapping[str, Any]:
        """Look of the line alone."""
        wide = self.bank == NO_BANK and not isfinite(self.threshold_m)
        line, width = _LINES[self.place % len(_LINES)], 2.0 if wide else 1.1
        return {"color": self.colour, "linestyle": line, "linewidth": width, "label": self.label}

    @property
    def marked(self) -> Mapping[str, Any]:
        """Look of a line with markers."""
        face, size = ("none", 4.6) if self.place else (self.colour, 3.0)
        marker = {"marker": sender_look(self.policy)[1], "markerfacecolor": face, "markersize": size}
        return {**self.plain, **marker, "markeredgewidth": 0.8}

    def drew(self, row: Row) -> bool:
        """Whether a row is of this sender."""
        return (row.policy, row.bank, repr(row.threshold_m)) == (
            self.policy,
            self.bank,
            repr(self.threshold_m),
        )


def sender_curves(result: NetworkResult) -> list[Curve]:
    """Return a curve for each sender, in the order of the legend: names of ours first, then the others.

    Parameters
    ----------
    result
        All runs.
    """
    told = also_told(result)
    found: list[Curve] = []
    lines: Counter[str] = Counter()
    names = dict.fromkeys(row.policy for row in result.runs)
    for policy in (*filter(names.__contains__, _COLOURS), *(one for one in names if one not in _COLOURS)):
        like = sender_look(policy)[0]
        own = dict.fromkeys((row.bank, repr(row.threshold_m)) for row in result.runs if row.policy == policy)
        ordered = [
            (bank, threshold_m)
            for bank in (NO_BANK, *result.banks)
            for threshold_m in (NO_THRESHOLD, *result.thresholds_m)
            if (bank, repr(threshold_m)) in own
        ]
        for bank, threshold_m in ordered:
            parts = [drawable(policy)]
            if "bank" in told and bank != NO_BANK:
                parts.append(drawable(bank, 30))
            if "threshold" in told and isfinite(threshold_m):
                parts.append(threshold_text(threshold_m))
            found.append(Curve(policy, bank, threshold_m, ", ".join(parts), lines[like]))
            lines[like] += 1
    return found
