"""The judged table: free sub-models trained on one half of the data, judged on the other, and the reverse.

``judged.py train FOLDER`` trains two profiles, ``a.json`` and ``b.json``, as ``modelcast train`` does, each
on one half: other drives where a source has several, other sources where it has one (`SOURCES`). It takes
about ten minutes on two cores. ``judged.py count FOLDER`` compares constant velocity, the best free receiver,
interacting models, the paper's bank, the profile's bank, and the same with context on what each half left
out, recorded and as default sensors see it, at four thresholds, with and without losses of 40 %. ``judged.py
shipped FOLDER`` does the same with the shipped profile, on trips it was not trained on. ``judged.py table
FOLDER`` prints the tables; with ``--write`` it puts them into ``docs/results.md``, and what they come to into
that page and ``README.md``; with ``--check`` it tells by its exit code whether these pages have them.
"""

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.io.profile import read_profile
from modelcast.io.trips import read_trips
from modelcast.models.profile import Profile, default_profile
from modelcast.station.banks import named_bank
from modelcast.study.compare.candidate import FixedCandidate
from modelcast.study.compare.result import message_bound, rival_bound
from modelcast.study.compare.run import compare
from modelcast.study.compare.settings import CompareSettings
from modelcast.study.settings import EvaluationSettings
from modelcast.study.training.profile import ProfileSettings, train_profile
from modelcast.trips.fingerprint import fingerprint
from modelcast.trips.trajectory import Trajectory
from page_blocks import put

README = Path(__file__).parents[1] / "README.md"
PAGE = Path(__file__).parents[1] / "docs" / "results.md"
BANKS = ("cv", "free", "imm", "paper", "default", "default+context")
THRESHOLDS_M = (0.2, 0.3, 0.4, 0.5)
PROTOCOLS = ("recorded", "sensor")
PACKET_ERROR_RATIO = 0.4
SHIPPED = "shipped"
_TRACKS = ("handling", "dynamic")


@dataclass(frozen=True)
class Source:
    """Where trips lie, which of them train profile ``a`` (the others train ``b``), and seeds of losses."""

    place: str
    trains_a: Callable[[str], bool]
    seeds: int
    _: KW_ONLY
    files: str = ""
    kept: Callable[[str], bool] = lambda _: True
    kind: str = "car"

    def read(self, data: Path) -> list[Trajectory]:
        """Its trips."""
        path = data / self.place
        trips = read_trips(sorted(path.glob(self.files)) if self.files else [path])
        return [trip for trip in trips if self.kept(trip.trip_id)]


def _all(_: str) -> bool:
    return True


def _none(_: str) -> bool:
    return False


SOURCES = {
    "handling": Source("openacc_zalazone", _all, 1, files="*handling*.csv"),
    "dynamic": Source("openacc_zalazone", _none, 1, files="*dynamic*.csv"),
    "tampa": Source("roads/tampa_dev.parquet", lambda trip: "1118" in trip, 1),
    "kitti": Source("roads/kitti_00-04.parquet", lambda trip: trip[-2:] in ("00", "01"), 8),
    "boreas": Source("roads/boreas_2021-08-05.parquet", _none, 10),
    "beijing": Source("roads/beijing_gps_and_rtk.parquet", _all, 10, kept=lambda trip: trip.endswith("rtk")),
    "spmd": Source("spmd/bsm_p1_dev.csv", _none, 24),
    "smartloc": Source("smartloc", _none, 40),
    "comma2k19": Source("comma2k19", _none, 60),
}
"""What is judged. Of a single drive, one profile knows all of it and the other nothing."""


def halved(which: str, data: Path, *, training: bool) -> Iterator[tuple[str, Trajectory]]:
    """Trips that train a profile, or those that it is judged on, with their source's name."""
    for name, source in SOURCES.items():
        for trip in source.read(data):
            if (source.trains_a(trip.trip_id) == (which == "a")) == training:
                yield name, trip


def unseen(profile: Profile, data: Path, sources: Iterable[str]) -> Iterator[tuple[str, Trajectory]]:
    """Trips of sources that a profile was not trained on, with their source's name."""
    known = set(profile.training_trips)
    for name in sources:
        for trip in SOURCES[name].read(data):
            if fingerprint(trip) not in known:
                yield name, trip


def _train(which: str, folder: Path, data: Path) -> None:
    trips = [trip for _, trip in halved(which, data, training=True)]
    profile = train_profile(trips, ProfileSettings())
    (folder / f"{which}.json").write_text(profile.text, encoding="utf-8")
    print(f"{which}: {len(trips)} trips, {profile.identity}", flush=True)


def train(folder: Path, data: Path) -> None:
    """Train both profiles, one a core."""
    folder.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(2) as pool:
        for running in [pool.submit(_train, which, folder, data) for which in "ab"]:
            running.result()


def _candidates(profile: Profile) -> list[FixedCandidate]:
    found: list[FixedCandidate] = []
    for text in BANKS:
        named = named_bank(text, profile=profile)
        found.append(FixedCandidate(text, named.bank, named.start, named.identify))
    return found


def _compared(name: str, trips: Sequence[Trajectory], profile: Profile) -> list[dict[str, Any]]:
    """What a comparison of one source found, as plain rows."""
    evaluation = EvaluationSettings(
        THRESHOLDS_M,
        (0.0, PACKET_ERROR_RATIO),
        seeds=SOURCES[name].seeds,
        references=True,
        free=None,  # the profile's own is among the candidates
    )
    settings = CompareSettings(evaluation, PROTOCOLS, against="free", resamples=200)
    result = compare(trips, _candidates(profile), settings)
    rows = [{"kind": "count", "source": name, **row.plain()} for row in result.counts]
    rows += [
        {"kind": "tracking", "source": name, **row.plain()} for row in result.tracking if row.trip == "all"
    ]
    rows += [{"kind": "reference", "source": name, **row.plain()} for row in result.references]
    return rows


def _count(which: str, folder: Path, data: Path, sources: Sequence[str]) -> None:
    """Judge one profile."""
    if which == SHIPPED:
        profile = default_profile()
        own = list(unseen(profile, data, sources))
    else:
        profile = read_profile(folder / f"{which}.json")
        own = list(halved(which, data, training=False))
    rows: list[dict[str, Any]] = []
    for name in SOURCES:
        trips = [trip for source, trip in own if source == name]
        if trips and name in sources:
            rows += _compared(name, trips, profile)
            print(f"{which}: {name}, {len(trips)} trips", flush=True)
    (folder / f"{which}.counts.json").write_text(json.dumps(rows), encoding="utf-8")


def count(folder: Path, data: Path, which: Sequence[str], sources: Sequence[str]) -> None:
    """Judge profiles, one a core."""
    with ProcessPoolExecutor(2) as pool:
        for running in [pool.submit(_count, one, folder, data, sources) for one in which]:
            running.result()


@dataclass(frozen=True)
class Cell:
    """Sums over the trips of a source: messages, bytes and time on the air of a bank, of cv and of free."""

    own: np.ndarray
    cv: np.ndarray
    free: np.ndarray

    def over(self, rival: str, what: int = 0) -> float:
        """Ratio to a rival's messages (0), bytes (1) or time on the air (2)."""
        return float(self.own[what] / getattr(self, rival)[what])


class Judged:
    """All rows that were counted, those of both halves or those of the shipped profile."""

    def __init__(self, files: Iterable[Path]) -> None:
        self.rows: list[dict[str, Any]] = [
            row for path in files for row in json.loads(path.read_text(encoding="utf-8"))
        ]
        self.sources = [name for name in SOURCES if any(row["source"] == name for row in self.rows)]
        self._sums: dict[tuple[str, str, str, float], np.ndarray] = {}
        self._each: dict[tuple[str, str, str, float], dict[str, int]] = {}
        for row in self._of("count"):
            key = row["source"], row["protocol"], row["candidate"], row["threshold_m"]
            sent = np.array(
                [row["updates"] + row["identifications"], row["message_bytes"], row["airtime_s"]], dtype=float
            )
            self._sums[key] = self._sums.get(key, np.zeros(3)) + sent
            self._each.setdefault(key, {})[row["trip"]] = int(sent[0])

    def _of(self, kind: str) -> Iterator[dict[str, Any]]:
        return (row for row in self.rows if row["kind"] == kind)

    def cells(self, source: str, protocol: str, bank: str) -> list[Cell]:
        """Of every threshold."""
        return [
            Cell(*(self._sums[source, protocol, one, threshold_m] for one in (bank, "cv", "free")))
            for threshold_m in THRESHOLDS_M
        ]

    def has(self, source: str, protocol: str) -> bool:
        """Whether a source was judged so; a coarse log is no truth of its own."""
        return (source, protocol, "cv", THRESHOLDS_M[0]) in self._sums

    def bound(self, source: str, protocol: str) -> list[float]:
        """Messages of the parabolas that know the future, over those of cv."""
        found = {
            row["threshold_m"]: row["message_ratio"]
            for row in self._of("reference")
            if (row["source"], row["protocol"], row["reference"]) == (source, protocol, "clairvoyant-2")
        }
        return [found[threshold_m] for threshold_m in THRESHOLDS_M]

    def beyond(self, source: str, protocol: str, bank: str) -> list[tuple[float, float]]:
        """Messages beyond what is allowed over cv and over free, every trip and threshold."""
        found: list[tuple[float, float]] = []
        for threshold_m in THRESHOLDS_M:
            own, cv, free = (self._each[source, protocol, one, threshold_m] for one in (bank, "cv", "free"))
            found += [
                (sent - message_bound(cv[trip]), sent - rival_bound(free[trip])) for trip, sent in own.items()
            ]
        return found

    def tails(self, source: str, protocol: str, bank: str) -> np.ndarray:
        """p90 and p99 over those of cv at equal rate, the harder of both, by threshold and rate basis."""
        return np.array(
            [
                (row["p90_ratio"], row["p99_ratio"])
                for row in self._of("tracking")
                if (row["source"], row["protocol"], row["candidate"]) == (source, protocol, bank)
                and row["packet_error_ratio"] == PACKET_ERROR_RATIO
            ]
        )


def _pairs(judged: Judged) -> Iterator[tuple[str, str]]:
    for source in judged.sources:
        for protocol in PROTOCOLS:
            if judged.has(source, protocol):
                yield source, protocol


def _ends(values: Sequence[float]) -> str:
    """At the least and the greatest threshold."""
    return f"{values[0]:.2f} / {values[-1]:.2f}"


def messages_table(judged: Judged) -> list[str]:
    """Messages over cv's at 20 and 50 cm, and of the default bank over free's."""
    banks = BANKS[1:]
    head = " | ".join(banks)
    lines = [f"| source | as seen | {head} | parabolas that know the future | default over free |"]
    lines.append("|---|---|" + "---|" * (len(banks) + 2))
    each: dict[str, list[list[float]]] = {name: [] for name in (*banks, "bound", "over")}
    for source, protocol in _pairs(judged):
        row: dict[str, list[float]] = {}
        for bank in banks:
            row[bank] = [cell.over("cv") for cell in judged.cells(source, protocol, bank)]
        row["bound"] = judged.bound(source, protocol)
        row["over"] = [cell.over("free") for cell in judged.cells(source, protocol, "default")]
        for name, values in row.items():
            each[name].append(values)
        lines.append(f"| {source} | {protocol} | " + " | ".join(map(_ends, row.values())) + " |")
    means = (np.mean(values, axis=0).tolist() for values in each.values())
    lines.append("| mean | | " + " | ".join(map(_ends, means)) + " |")
    return lines


def harm_table(judged: Judged) -> list[str]:
    """What messages cost beyond their number, and the worst trips."""
    lines = [
        (
            "| source | as seen | bytes / free | airtime / messages | counts "
            "| over cv | worst | over free | worst |"
        ),
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for source, protocol in _pairs(judged):
        cells = judged.cells(source, protocol, "default")
        octets = [cell.over("free", 1) for cell in cells]
        air = max(cell.over("cv", 2) / cell.over("cv") for cell in cells)
        beyond = np.array(judged.beyond(source, protocol, "default"))
        over, worst = (beyond > 0.0).sum(axis=0), beyond.max(axis=0)
        lines.append(
            f"| {source} | {protocol} | {_ends(octets)} | {air:.3f} | {len(beyond)} | "
            f"{over[0]} | {worst[0]:+.1f} | {over[1]} | {worst[1]:+.1f} |"
        )
    return lines


def loss_table(judged: Judged) -> list[str]:
    """Tracking errors at 40 % losses over cv's at equal rate: mean over thresholds, and the worst."""
    banks = ("free", "default", "default+context")
    lines = ["| source | as seen | " + " | ".join(f"{one}: p90 / p99 (worst)" for one in banks) + " |"]
    lines.append("|---|---|" + "---|" * len(banks))
    logs: dict[str, list[np.ndarray]] = {bank: [] for bank in banks}
    for source, protocol in _pairs(judged):
        shown: list[str] = []
        for bank in banks:
            tails = judged.tails(source, protocol, bank)
            mean, worst = np.exp(np.log(tails).mean(axis=0)), tails.max(axis=0)
            logs[bank].append(np.log(mean))
            shown.append(f"{mean[0]:.2f} / {mean[1]:.2f} ({worst[0]:.2f} / {worst[1]:.2f})")
        lines.append(f"| {source} | {protocol} | " + " | ".join(shown) + " |")
    means = (np.exp(np.mean(rows, axis=0)) for rows in logs.values())
    lines.append("| mean | | " + " | ".join(f"{one[0]:.2f} / {one[1]:.2f}" for one in means) + " |")
    return lines


def _means(judged: Judged, bank: str, rival: str) -> str:
    """Mean of all rows at the least and the greatest threshold."""
    rows = [[one.over(rival) for one in judged.cells(*pair, bank)] for pair in _pairs(judged)]
    return _ends(np.mean(rows, axis=0).tolist())


def _range(judged: Judged, sources: Sequence[str]) -> str:
    """Least and greatest messages of the default bank over constant velocity's."""
    found = [
        cell.over("cv")
        for source, protocol in _pairs(judged)
        for cell in judged.cells(source, protocol, "default")
        if source in sources
    ]
    return f"{min(found):.2f} to {max(found):.2f}"


def _tail(judged: Judged, bank: str) -> str:
    """Mean of all rows of p90 and p99 at 40 % losses."""
    each = [np.log(judged.tails(*pair, bank)).mean(axis=0) for pair in _pairs(judged)]
    p90, p99 = np.exp(np.mean(each, axis=0))
    return f"{p90:.2f} and {p99:.2f}"


_FINDINGS = """\
{sources} sources of trips, {trips} trips, recorded and with sensor noise, each judged by a profile that
was trained on other drives or other sources. Messages over those of constant velocity at thresholds of 20
/ 50 cm, means over the sources:

1. A receiver that coasts a plain message well (`free`: speed, heading, acceleration and yaw rate, well
   estimated) needs {free}, at the same 40 bytes. That is most of the gain, and the rival to beat. An
   interacting multiple model at the receiver (`imm`): {imm}.
2. A network at the sender that only chooses these four values, within the accuracy that the standard asks
   for, needs {default}, or {over_free} of what `free` needs, at no byte. That is the shipped bank.
3. It needs {tracks} on test tracks, and {roads} on roads and in towns.
4. How bad it gets: a trip at a threshold, with noise or without, is a count. In {beyond_cv} of {counts}
   counts the shipped bank sends more than constant velocity by over 2 % and over 3 messages. In
   {beyond_free} it sends more than `free` by over 5 % and over 5 messages; the worst is {worst:.1f}
   messages beyond that.
5. The vehicle ahead and the road as driven before (`default+context`) bring it to {default_context}:
   little so far.
6. When 40 % of the messages are lost, p90 and p99 of the tracking error are {tails} of constant
   velocity's at an equal rate; `free`'s are {free_tails}. Part of that is a rule, not a model: the
   senders of the bank and of `free` know the share lost and repeat, that of constant velocity does not
   ([loss](loss.md#at-equal-airtime)).
7. Paths of six coefficients, Gaussian processes and switching models stay on the shelf: 13 to 20 bytes
   more a message, and next to no message saved on roads that they have not seen.
8. The paper's own bank, a Gaussian process beside constant velocity, needs {paper}; what it gains under
   loss depends on the rate it is compared at ([the paper](paper.md)).
9. In dense simulated traffic under J2945/1's timers models earn nothing beside `free`: the same messages,
   bytes and errors.
10. A sender that knew the future would need {bound} with parabolas: what is left is what drivers decide
    later.
"""

_HEADLINES = """\
On {trips} recorded trips of {sources} sources, each judged by a profile that was trained on others:

1. **Messages.** A receiver that coasts a plain message well (`free`: speed, heading, acceleration and yaw
   rate) needs {free} of the messages of constant velocity, at thresholds of 20 / 50 cm. What ships needs
   {default}: the sender chooses these four values, at no byte. The paper's bank, a Gaussian process
   beside constant velocity, needs {paper}.
2. **Under loss.** When 40 % of the messages are lost, 90th and 99th percentile of the tracking error are
   {tails} of constant velocity's, with as many messages; `free`'s are {free_tails}. Part of that is a
   rule, not a model. The senders of what ships and of `free` also repeat: they know the share lost and
   send up to 1.7 times as much. That of constant velocity does not repeat. With `--believe sent` nobody
   does: the bank that shipped before was at 0.68 and 0.95 so, and at 0.57 and 0.66 with repetitions
   ([loss](docs/loss.md#at-equal-airtime)).
3. **In dense simulated traffic** under SAE J2945/1's timers models earn nothing beside `free`: the same
   messages, bytes and errors.
"""


def sentences(judged: Judged) -> dict[str, list[str]]:
    """What a newcomer reads first, and all of it in ten sentences."""
    trips = {(row["source"], row["trip"]) for row in judged.rows if row["kind"] == "count"}
    beyond = [
        one for source, protocol in _pairs(judged) for one in judged.beyond(source, protocol, "default")
    ]
    over = (np.array(beyond) > 0.0).sum(axis=0)
    worst = np.array(beyond).max(axis=0)
    roads = [name for name in judged.sources if name not in (*_TRACKS, "spmd")]
    bound = _ends(np.mean([judged.bound(*pair) for pair in _pairs(judged)], axis=0).tolist())
    found = {
        **{name.replace("+", "_"): _means(judged, name, "cv") for name in BANKS},
        "sources": len(judged.sources),
        "trips": len(trips),
        "over_free": _means(judged, "default", "free"),
        "tracks": _range(judged, _TRACKS),
        "roads": _range(judged, roads),
        "counts": len(beyond),
        "beyond_cv": over[0],
        "beyond_free": over[1],
        "worst": max(worst[1], 0.0),
        "tails": _tail(judged, "default"),
        "free_tails": _tail(judged, "free"),
        "bound": bound,
    }
    return {
        "headlines": _HEADLINES.format(**found).splitlines(),
        "findings": _FINDINGS.format(**found).splitlines(),
    }


def blocks(folder: Path) -> dict[str, list[str]]:
    """Every table by the name of its block on the page."""
    found: dict[str, list[str]] = {}
    for name, files in (("halves", ("a", "b")), (SHIPPED, (SHIPPED,))):
        paths = [folder / f"{one}.counts.json" for one in files]
        if all(path.exists() for path in paths):
            judged = Judged(paths)
            found[f"{name} messages"] = messages_table(judged)
            found[f"{name} harm"] = harm_table(judged)
            found[f"{name} loss"] = loss_table(judged)
    return found


def main() -> int:
    """Train, count or print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=("train", "count", SHIPPED, "table"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--sources", nargs="+", choices=tuple(SOURCES), default=tuple(SOURCES))
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    data = Path(os.environ.get("MODELCAST_DATA", ""))
    if given.what == "train":
        train(given.folder, data)
    elif given.what == "table":
        found = blocks(given.folder)
        if given.write or given.check:
            pages = {PAGE: found}
            if "halves messages" in found:
                halves = [given.folder / f"{which}.counts.json" for which in "ab"]
                said = sentences(Judged(halves))
                pages[README] = {"headlines": said["headlines"]}
                pages[PAGE] = {**found, "findings": said["findings"]}
            if put(pages, check=given.check):
                return 1
        for name, lines in found.items():
            print(f"\n{name}\n")
            print("\n".join(lines))
    else:
        which = ("a", "b") if given.what == "count" else (SHIPPED,)
        count(given.folder, data, which, given.sources)
    return 0


if __name__ == "__main__":
    sys.exit(main())
