"""The runs of the published network table: which there are, in which order, and the files that keep them."""

import hashlib
import json
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from modelcast.channel.radio_words import get_radio
from modelcast.core.exceptions import ConfigError
from modelcast.core.version import package_version
from modelcast.station.sender.names import SENDERS

__all__ = [
    "CALLS",
    "FIGURES",
    "RECEIVERS",
    "Call",
    "Cell",
    "Kept",
    "cells_of",
    "keep",
    "kept",
    "row_order",
    "sources",
]

RECEIVERS = {
    "default": "1 cm",
    "ins": "`ins`",
    "ins-timed": "`ins`, timed",
    "gnss": "`gnss`",
    "gnss-timed": "`gnss`, timed",
}
"""Named sensors, and how the page calls them; timed ones know how old their samples are (``--latency 0``)."""

FIGURES = (
    "vehicles",
    "message_rate_hz",
    "bytes_per_s",
    "model_ratio",
    "certificate_ratio",
    "power_dbm",
    "busy_ratio",
    "delivery_ratio",
    "collision_ratio",
    "held_ratio",
    "pte_p50_m",
    "pte_p90_m",
    "pte_p99_m",
    "relative_p90_m",
)
"""Columns of `modelcast.study.network.rows.RUNS` that are kept of a run."""

FREE_FLOW = (25.0, 100.0, 200.0, 400.0)
CORE = ("j2945", "j2945-filtered", "j2945-free", "j2945-mbc", "mbc")
RELAXED = ("j2945-mbc-relaxed", "j2945-free-relaxed", "j2945-mbc-relaxed-5", "j2945-free-relaxed-5")
OTHERS = ("bsm-10hz", "baseline", "free", *RELAXED)
MANY = ("bsm-10hz", *CORE, "baseline", "free", *RELAXED[:2])
LOADING = ("bsm-10hz", "j2945", "j2945-mbc", "mbc", RELAXED[0], "cam")
CAMS = tuple(name for name in SENDERS if name.startswith("cam"))
J3161 = ("j3161", "j3161-mbc", "j3161-mbc-relaxed")
RADIO_WORDS = ("sidelink", "nr", "abstract")
WANDERING = tuple(RECEIVERS)[1:]
MOST_QUICK_PER_KM = 400.0


def _is_known(radio: str) -> bool:
    """Whether this version has a radio of that word."""
    try:
        _ = get_radio(radio)
    except ConfigError:
        return False
    return True


class Cell(NamedTuple):
    """One run."""

    scenario: str
    density_per_km: float
    radio: str
    policy: str
    receiver: str
    seed: int

    @property
    def stem(self) -> str:
        """Name of its file without the ending; no two cells have one name."""
        density = f"{self.density_per_km:g}"
        words = (self.scenario, density, self.radio, self.policy, self.receiver, str(self.seed))
        return "~".join(quote(word, safe="") for word in words)


class Call(NamedTuple):
    """Runs that are asked for together: all combinations, seed by seed.

    ``kind`` is what ``--only`` names; calls of one kind may stand apart, since what matters most runs first.
    """

    kind: str
    scenario: str
    densities_per_km: Sequence[float]
    radios: Sequence[str]
    policies: Sequence[str]
    receivers: Sequence[str]
    seeds: int
    first_seed: int = 0

    def cells(self, *, most_seeds: int | None = None, quick: bool = False) -> Iterator[Cell]:
        """All its runs; of at most so many seeds, or of its first density and two seeds where that is quick.

        Radios and senders that this version does not have are left out.
        """
        count = self.seeds if most_seeds is None else min(self.seeds, most_seeds)
        first = [value for value in self.densities_per_km[:1] if value <= MOST_QUICK_PER_KM]
        densities = first if quick else self.densities_per_km
        seeds = range(self.first_seed, self.first_seed + (min(count, 2) if quick else count))
        radios = [word for word in self.radios if _is_known(word)]
        policies = [word for word in self.policies if word in SENDERS]
        for seed, density, radio, policy, receiver in product(
            seeds, densities, radios, policies, self.receivers
        ):
            yield Cell(self.scenario, density, radio, policy, receiver, seed)


CALLS = (
    Call("headline", "highway", [25.0, 100.0, 200.0], ["dsrc"], CORE, ["default"], 10),
    Call("headline", "highway", [400.0], ["dsrc"], CORE, ["default"], 3),
    Call("receivers", "highway", [25.0, 100.0], ["dsrc"], [*CORE, RELAXED[0]], WANDERING, 3),
    Call("loaded", "loaded", [700.0], ["dsrc"], LOADING, ["default"], 2),
    Call("receivers", "highway", [400.0], ["dsrc"], [*CORE, RELAXED[0]], WANDERING, 3),
    Call("headline", "highway", [25.0, 100.0], ["dsrc"], OTHERS, ["default"], 10),
    Call("coverage", "highway", [25.0, 100.0], ["dsrc"], ["j2945", "j2945-mbc", "mbc"], ["default"], 60),
    Call("headline", "highway", [400.0], ["dsrc"], CORE, ["default"], 10),
    Call(
        "radios", "highway", [25.0, 100.0], RADIO_WORDS, [*CORE, "free", *RELAXED[:2], *J3161], ["default"], 3
    ),
    Call("cams", "highway", [25.0, 100.0, 400.0], ["dsrc"], CAMS, ["default"], 10),
    Call("headline", "highway", [200.0, 400.0], ["dsrc"], OTHERS, ["default"], 10),
    Call("receivers", "highway", FREE_FLOW, ["dsrc"], [*CORE, RELAXED[0]], WANDERING, 10),
    Call("radios", "highway", [400.0], RADIO_WORDS, [*CORE, "free", *RELAXED[:2], *J3161], ["default"], 3),
    Call("headline", "highway", [50.0], ["dsrc"], [*CORE, *OTHERS], ["default"], 10),
    Call("headline", "highway", [800.0, 1200.0], ["dsrc"], MANY, ["default"], 3),
    Call("loaded", "loaded", [400.0, 700.0, 1000.0], ["dsrc"], LOADING, ["default"], 3),
    Call("loaded", "loaded", [700.0, 1000.0], ["dsrc:path_loss=dual-slope"], LOADING, ["default"], 3),
    Call("headline", "highway", [800.0, 1200.0], ["dsrc"], MANY, ["default"], 10),
)
"""What the page is made of, what matters most first."""


def cells_of(
    calls: Iterable[Call], kinds: Sequence[str], *, most_seeds: int | None = None, quick: bool = False
) -> list[Cell]:
    """All runs of the calls of these kinds (of all where none is named), each once, in order."""
    return list(
        dict.fromkeys(
            cell
            for call in calls
            if not kinds or call.kind in kinds
            for cell in call.cells(most_seeds=most_seeds, quick=quick)
        )
    )


def row_order(cell: Cell) -> tuple[int, float, int, int, int]:
    """Sorts what tables hold: by radio, density, receiver and sender, as they are listed above."""
    radios = list(dict.fromkeys(word for call in CALLS for word in call.radios))
    return (
        radios.index(cell.radio),
        cell.density_per_km,
        list(RECEIVERS).index(cell.receiver),
        SENDERS.index(cell.policy),
        cell.seed,
    )


class Kept(NamedTuple):
    """What is kept of one run: `FIGURES`, processor time [s], and the state of the sources that made it."""

    figures: dict[str, float]
    processor_s: float
    version: str
    sources: str


def sources(package: Path) -> str:
    """A hash of all Python files of the package and its profile: runs of one hash are of one state."""
    found = hashlib.sha256()
    for path in sorted([*package.rglob("*.py"), *package.rglob("*.json")]):
        found.update(str(path.relative_to(package)).encode())
        found.update(path.read_bytes())
    return found.hexdigest()[:12]


def keep(folder: Path, cell: Cell, done: Kept) -> None:
    """Write a run's file, whole or not at all."""
    partial = folder / f"{cell.stem}.part"
    held: dict[str, Any] = {"cell": list(cell), **done._asdict()}
    partial.write_text(json.dumps(held, allow_nan=True), encoding="utf-8")
    partial.replace(folder / f"{cell.stem}.json")


def kept(folder: Path, cell: Cell) -> Kept | None:
    """What the folder has of a run; None where it has nothing.

    Raises
    ------
    SystemExit
        Where the file is of another run, of other figures, or of another version of modelcast.
    """
    path = folder / f"{cell.stem}.json"
    if not path.exists():
        return None
    held = json.loads(path.read_text(encoding="utf-8"))
    named = held.pop("cell")
    if Cell(*named) != cell or tuple(held["figures"]) != FIGURES or held["version"] != package_version():
        raise SystemExit(
            f"{path} is of another run or version: give each version of modelcast a folder of its own"
        )
    return Kept(**held)
