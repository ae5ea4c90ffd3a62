"""People on foot and on bicycles: the shipped profile of people, and how it fares on tracks it has not seen.

``people.py profile`` prints the profile that ships as ``people``; with ``--write`` it puts the file into the
package, with ``--check`` it tells by its exit code whether the package has it.

``people.py count FOLDER`` counts messages, bytes and errors under loss on every other track of three
recordings; the constants of the profile were chosen on the tracks between. It trains a learned sub-model on
those too, for measurement alone. What is done is kept in the folder. ``people.py table FOLDER`` prints the
tables; with ``--write`` it puts them into ``docs/people.md``, with ``--check`` it tells whether that page has
them.
"""

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.io.trips import read_trips
from modelcast.models.bank import Bank
from modelcast.models.free import Limits
from modelcast.models.profile import Profile
from modelcast.models.shipped import PEOPLE, profile_path
from modelcast.models.stop_and_go import StopAndGo
from modelcast.station.banks import BASELINE_BANK, named_bank
from modelcast.study.compare.candidate import FixedCandidate
from modelcast.study.compare.result import messages_of
from modelcast.study.compare.run import compare
from modelcast.study.compare.settings import CompareSettings
from modelcast.study.ellipse import EllipseFilter, ellipse_messages
from modelcast.study.settings import EvaluationSettings
from modelcast.study.training.descent import Descent
from modelcast.study.training.free import FreeSettings
from modelcast.study.training.free_members import FreeMembersSettings, train_free_members
from modelcast.study.training.playback import AS_RECORDED
from modelcast.study.training.views import SenderView
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.named_sensors import named_sensor
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "people.md"
SOURCES = {
    "cyclists": "cyclists_dev",
    "crossing cyclists": "crossing_cyclists_dev",
    "pedestrians": "crossing_pedestrians_dev",
}
CYCLISTS = ("cyclists", "crossing cyclists")
THRESHOLDS_M = (0.2, 0.5)
PACKET_ERROR_RATIO = 0.4
FILTERED = "cv, same filter"
RULES = ("hindsight", "never")
PARTS = {"all of the other half": 1, "a quarter": 4, "an eighth of the tracks": 8}
_LEARNT_DT_S = 0.1


def shipped() -> Profile:
    """The profile of people: one sub-model without trained weights."""
    found = {
        "constants": "round numbers, chosen on every other track of each recording of docs/people.md",
        "trained": "nothing",
    }
    return Profile(Bank((StopAndGo(),), PEOPLE), start=RULES[0], identify=RULES[1], record=found)


def profile(*, write: bool, check: bool) -> int:
    """Print the shipped profile, write it or compare it."""
    path, text = profile_path(PEOPLE), shipped().text
    if write:
        path.write_text(text, encoding="utf-8", newline="\n")
    if check:
        return int(not path.exists() or path.read_text(encoding="utf-8") != text)
    print(text, end="")
    return 0


def _half(source: str, *, judged: bool) -> list[Trajectory]:
    """Every other track: those that are judged, or those between."""
    data = Path(os.environ.get("MODELCAST_DATA", ""))
    path = data / "roads" / f"{SOURCES[source]}.parquet"
    return sorted(read_trips(path), key=lambda trip: trip.trip_id)[int(judged) :: 2]


def _candidates() -> list[FixedCandidate]:
    """Who is compared: rivals, the same filter without the switch or without its bounds, and the profile."""
    filtered = StopAndGo(gain_per_s=0.0, label="cv-filtered")
    unbounded = StopAndGo(least_change_mps2=0.0, phase_s=60.0, pace_mps=100.0, label="ca-filtered")
    found = [FixedCandidate("cv", BASELINE_BANK)]
    for text in ("ca", "imm", "default"):
        named = named_bank(text)
        found.append(FixedCandidate(text, named.bank, named.start, named.identify, named.selector))
    for name, member in ((FILTERED, filtered), ("ca, same filter", unbounded)):
        found.append(FixedCandidate(name, Bank((member,)), *RULES))
    return [*found, FixedCandidate(PEOPLE, shipped().bank, *RULES)]


def _compared(
    trips: Sequence[Trajectory],
    candidates: Sequence[FixedCandidate],
    evaluation: EvaluationSettings,
    protocols: Sequence[Any],
) -> dict[str, list[dict[str, Any]]]:
    """What a comparison found, as plain rows."""
    alone = replace(evaluation, free=None)  # who people are held against is named
    settings = CompareSettings(alone, tuple(protocols), route_by="trip", resamples=500)
    found = compare(trips, candidates, settings)
    return {
        "ratios": [row.plain() for row in found.ratios],
        "tracking": [row.plain() for row in found.tracking if row.trip == "all"],
        "references": [row.plain() for row in found.references],
        "counts": [
            {
                "candidate": row.candidate,
                "protocol": row.protocol,
                "threshold_m": row.threshold_m,
                "messages": messages_of(row),
                "baseline_messages": row.baseline_messages,
                "duration_s": row.duration_s,
            }
            for row in found.counts
        ],
    }


def _judged(source: str) -> Any:
    evaluation = EvaluationSettings(THRESHOLDS_M, (PACKET_ERROR_RATIO,), seeds=3, references=True)
    return _compared(_half(source, judged=True), _candidates(), evaluation, ("recorded", "sensor"))


def _phone(source: str) -> Any:
    evaluation = EvaluationSettings(
        THRESHOLDS_M, (PACKET_ERROR_RATIO,), seeds=3, sensor=named_sensor("phone"), references=False
    )
    return _compared(_half(source, judged=True), _candidates(), evaluation, ("sensor",))


def _between(source: str) -> Any:
    evaluation = EvaluationSettings(THRESHOLDS_M, (0.0,), seeds=1, references=False)
    return _compared(_half(source, judged=False), _candidates()[-1:], evaluation, ("recorded", "sensor"))


def _ellipses(source: str) -> Any:
    """Messages of senders of ellipses, and how often people are inside."""
    model, found = EllipseFilter(), dict[str, Any]()
    for trip in _half(source, judged=True):
        held = model.follow(trip)
        for rule in ("error", "ellipse"):
            for threshold_m in THRESHOLDS_M:
                sent = ellipse_messages(trip, threshold_m, model=model, rule=rule, held=held)
                row = found.setdefault(
                    f"{rule} {threshold_m:g}", {"messages": 0, "inside": 0.0, "samples": 0}
                )
                row["messages"] += sent.starts.size
                row["inside"] += sent.within * len(trip)
                row["samples"] += len(trip)
    return found


def _thinned(trip: Trajectory) -> Trajectory:
    """A track at 10 Hz or the next lower rate that it has: at a higher one a learned window is too short."""
    at = np.arange(0, len(trip), max(1, ceil(_LEARNT_DT_S / trip.dt_s - 1e-6)))
    return build_trajectory(trip.trip_id, trip.t_s[at], trip.position_m[at])


def _learnt(part: int) -> Any:
    """A learned sub-model, trained on a part of the tracks of all sources, counted on the judged ones."""
    own = FreeSettings(
        limits=Limits(0.8, 0.5, acceleration_mps2=0.5, yaw_rate_radps=0.5), descent=Descent(steps=300)
    )
    settings = FreeMembersSettings(
        own, views=((SenderView("recorded"), 1.0),), playbacks=(AS_RECORDED,), rows=12_000
    )
    trips = [_thinned(trip) for source in SOURCES for trip in _half(source, judged=False)[::part]]
    trained = train_free_members(trips, settings, progress=lambda _, __, ___: None)
    candidates = [
        FixedCandidate("learned", Bank((trained.predictive,)), *RULES),
        FixedCandidate(PEOPLE, shipped().bank, *RULES),
    ]
    evaluation = EvaluationSettings(THRESHOLDS_M, (0.0,), seeds=1, references=False)
    found: dict[str, Any] = {"tracks": len(trips), "duration_s": sum(trip.duration_s for trip in trips)}
    for source in SOURCES:
        judged = [_thinned(trip) for trip in _half(source, judged=True)]
        found[source] = _compared(judged, candidates, evaluation, ("recorded",))["ratios"]
    return found


def count(folder: Path) -> None:
    """Everything, two processes at a time."""
    folder.mkdir(parents=True, exist_ok=True)
    work: dict[str, Callable[[], Any]] = {
        f"learnt {name}": partial(_learnt, part) for name, part in PARTS.items()
    }
    for what, made in (
        ("judged", _judged),
        ("phone", _phone),
        ("between", _between),
        ("ellipses", _ellipses),
    ):
        work |= {f"{what} {source}": partial(made, source) for source in SOURCES}
    with ProcessPoolExecutor(2) as pool:
        missing = {name: made for name, made in work.items() if not _file(folder, name).exists()}
        running = {name: pool.submit(made) for name, made in missing.items()}
        for name, future in running.items():
            _file(folder, name).write_text(json.dumps(future.result()), encoding="utf-8")
            print(name, flush=True)


def _file(folder: Path, name: str) -> Path:
    return folder / f"{name.replace(' ', '-')}.json"


class Found:
    """What was counted, as tables ask for it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def of(self, name: str) -> Any:
        """Everything of one piece of work."""
        return json.loads(_file(self._folder, name).read_text(encoding="utf-8"))

    def row(self, what: str, kind: str, source: str, **wanted: Any) -> dict[str, Any]:
        """The one row of a kind that has these values."""
        rows = self.of(f"{what} {source}")[kind]
        (found,) = (row for row in rows if all(row[name] == value for name, value in wanted.items()))
        return found

    def pooled(self, what: str, sources: Sequence[str], **wanted: Any) -> float:
        """Messages over the baseline's, all tracks of some sources together."""
        sent = before = 0
        for source in sources:
            for row in self.of(f"{what} {source}")["counts"]:
                if all(row[name] == value for name, value in wanted.items()):
                    sent, before = sent + row["messages"], before + row["baseline_messages"]
        return sent / before


def _pair(values: Sequence[float]) -> str:
    return " / ".join(f"{value:.2f}" for value in values)


def _rates(found: Found, what: str, protocol: str) -> Iterator[str]:
    """Messages over the baseline's at both thresholds, a row a candidate."""
    yield "| | cyclists | crossing cyclists | both, pooled | pedestrians |"
    yield "|---|---|---|---|---|"
    columns = (("cyclists",), ("crossing cyclists",), CYCLISTS, ("pedestrians",))
    for candidate in _candidates()[1:]:
        cells = [
            _pair(
                [
                    found.pooled(what, sources, candidate=candidate.name, protocol=protocol, threshold_m=one)
                    for one in THRESHOLDS_M
                ]
            )
            for sources in columns
        ]
        yield f"| `{candidate.name}` | {' | '.join(cells)} |"


def _people(found: Found) -> Iterator[str]:
    """The profile of people with intervals: messages, bytes, errors under loss, and the other half."""
    yield "| source | protocol | threshold, m | messages | bytes | p99 at 40 % loss | on the tracks between |"
    yield "|---|---|---|---|---|---|---|"
    for source in SOURCES:
        for what, protocol, name in (
            ("judged", "recorded", "recorded"),
            ("judged", "sensor", "sensor"),
            ("phone", "sensor", "phone"),
        ):
            for one in THRESHOLDS_M:
                wanted = {"candidate": PEOPLE, "protocol": protocol, "threshold_m": one}
                row = found.row(what, "ratios", source, **wanted)
                lost = found.row(what, "tracking", source, **wanted)
                other = "" if what == "phone" else found.row("between", "ratios", source, **wanted)
                between = f"{other['message_ratio']:.2f}" if other else ""
                yield (
                    f"| {source} | {name} | {one:g} | {row['message_ratio']:.2f} "
                    f"[{row['message_low']:.2f}, {row['message_high']:.2f}] | {row['bytes_ratio']:.2f} "
                    f"| {lost['p99_ratio']:.2f} [{lost['p99_low']:.2f}, {lost['p99_high']:.2f}] | {between} |"
                )


def _bounds(found: Found) -> Iterator[str]:
    """What a sender that knows the future needs, and what there is."""
    yield "| | cyclists | crossing cyclists | pedestrians |"
    yield "|---|---|---|---|"
    for degree in (1, 2, 3):
        cells = [
            _pair(
                [
                    found.row(
                        "judged",
                        "references",
                        source,
                        reference=f"clairvoyant-{degree}",
                        protocol="recorded",
                        threshold_m=one,
                    )["message_ratio"]
                    for one in THRESHOLDS_M
                ]
            )
            for source in SOURCES
        ]
        yield f"| knows the future, polynomials of degree {degree} | {' | '.join(cells)} |"
    first = [_pair([_first(found, source, one) for one in THRESHOLDS_M]) for source in SOURCES]
    yield f"| first message of each track alone | {' | '.join(first)} |"


def _first(found: Found, source: str, threshold_m: float) -> float:
    """Share of the baseline's messages that are the first of their tracks."""
    rows = [
        row
        for row in found.of(f"judged {source}")["counts"]
        if row["candidate"] == PEOPLE and row["protocol"] == "recorded" and row["threshold_m"] == threshold_m
    ]
    return len(rows) / sum(row["baseline_messages"] for row in rows)


def _rival(found: Found) -> Iterator[str]:
    """Senders of ellipses."""
    yield "| a message is due when | what | cyclists | crossing cyclists | pedestrians |"
    yield "|---|---|---|---|---|"
    rules = {
        "error": "the error passes the threshold",
        "ellipse": "the person leaves the ellipse, or it is too large",
    }
    for rule, words in rules.items():
        sent: list[str] = []
        inside: list[str] = []
        for source in SOURCES:
            rows = [found.of(f"ellipses {source}")[f"{rule} {one:g}"] for one in THRESHOLDS_M]
            base = [
                sum(
                    row["baseline_messages"]
                    for row in found.of(f"judged {source}")["counts"]
                    if row["candidate"] == PEOPLE
                    and row["protocol"] == "recorded"
                    and row["threshold_m"] == one
                )
                for one in THRESHOLDS_M
            ]
            sent.append(_pair([row["messages"] / all_of for row, all_of in zip(rows, base, strict=True)]))
            inside.append(_pair([row["inside"] / row["samples"] for row in rows]))
        yield f"| {words} | messages | {' | '.join(sent)} |"
        yield f"| | inside the ellipse of 95 % | {' | '.join(inside)} |"


def _curve(found: Found) -> Iterator[str]:
    """The learned sub-model by how much it was trained on."""
    yield "| trained on | tracks | hours | cyclists | crossing cyclists | pedestrians |"
    yield "|---|---|---|---|---|---|"

    def cells(name: str, candidate: str) -> list[str]:
        of = found.of(f"learnt {name}")
        rows = [[row for row in of[source] if row["candidate"] == candidate] for source in SOURCES]
        return [_pair([row["message_ratio"] for row in own]) for own in rows]

    for name in PARTS:
        of = found.of(f"learnt {name}")
        hours = of["duration_s"] / 3600.0
        yield f"| {name} | {of['tracks']} | {hours:.2f} | {' | '.join(cells(name, 'learned'))} |"
    yield f"| `people`, nothing trained | | | {' | '.join(cells(next(iter(PARTS)), PEOPLE))} |"


def blocks(folder: Path) -> dict[str, list[str]]:
    """All tables of the page, by name."""
    found = Found(folder)
    return {
        "people": list(_people(found)),
        "recorded": list(_rates(found, "judged", "recorded")),
        "sensor": list(_rates(found, "judged", "sensor")),
        "phone": list(_rates(found, "phone", "sensor")),
        "bounds": list(_bounds(found)),
        "ellipse": list(_rival(found)),
        "curve": list(_curve(found)),
    }


def main() -> int:
    """Make the profile, count, or print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=("profile", "count", "table"))
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    if given.what == "profile":
        return profile(write=given.write, check=given.check)
    if given.folder is None:
        parser.error("name a folder")
    if given.what == "count":
        count(given.folder)
        return 0
    tables = blocks(given.folder)
    for name, lines in tables.items():
        print(f"\n{name}\n" + "\n".join(lines))
    if given.write or given.check:
        return put({PAGE: tables}, check=given.check)
    return 0


if __name__ == "__main__":
    sys.exit(main())
