"""What it is worth to a radio that reserves resources that a sender knows when its next message comes.

Usage: python validation/grants.py FOLDER [--densities D ...] [--seeds N] [--kept] [--write | --check]
FOLDER keeps what is done, a file a run, so it can be called again; give each version of modelcast its own.
``--kept`` makes nothing and takes, density by density, those seeds that are whole.

The same fleets send over LTE-V2X mode 4 in four ways: a one-shot for every message; a reservation at 100 ms
for every message; one-shot, reservation and interval chosen by when the sender expects its next message; and
as deployed (SAE J3161/1). What a sender would gain that knew its next message for certain is told by the
radio alone: it carries the messages of the one-shot run again, each with the time of the next.
``--write`` puts the tables into ``docs/grants.md``, ``--check`` tells by its exit
code whether that page has them.
"""

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import stats

from modelcast.channel.radio import OUTCOMES, AbstractRadio, Receptions, Transmissions
from modelcast.channel.sidelink import Sidelink, SidelinkState
from modelcast.channel.sidelink_parameters import SidelinkParameters, j3161_sidelink_parameters
from modelcast.core.arrays import FloatArray
from modelcast.core.version import package_version
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.study.network.measure import measure
from modelcast.study.network.rows import NetworkCase
from modelcast.world.named_sensors import named_sensor
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import filter_for
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "grants.md"
STEP_S = 0.1
LENGTH_M, DURATION_S = 1000.0, 8.0
DENSITIES_PER_KM = (25.0, 100.0, 200.0, 400.0)
THRESHOLD_M = 0.2
SETTINGS = NetworkSettings(warm_up_s=3.0)
WAYS = {
    "one-shot": SidelinkParameters(one_shot=True),
    "reserved": SidelinkParameters(),
    "by next": SidelinkParameters(interval_by_next=True, grant_by_next=True),
    "deployed": j3161_sidelink_parameters(),
}
KNOWN = "known"
CHOSEN = ("one-shot", "reserved", "by next", KNOWN)
ERRORS_ALONE = "mbc, errors alone"
POLICIES = ("mbc", ERRORS_ALONE, "j2945-mbc-relaxed")
NEAR = slice(1, 3)
"""Bins of distance of the figures of frames: 50 m to 150 m, as in `modelcast.study.network.rows.RUNS`."""

DEPLOYED = ("j3161", "j3161-mbc", "j3161-mbc-relaxed", "mbc")
FIGURES = ("message_rate_hz", "pte_p90_m", "busy_ratio", "delivery_ratio", "collision_ratio")
"""Columns of `RunRow`."""


class Case(NamedTuple):
    """One drive of the fleet."""

    density_per_km: float
    policy: str
    way: str
    seed: int

    @property
    def name(self) -> str:
        """Of its file."""
        return f"{self.density_per_km:g}-{self.policy}-{self.way}-{self.seed}".replace(", ", "-").replace(
            " ", "-"
        )


def cases(density_per_km: float, seeds: int) -> list[Case]:
    """What is driven at a density, seed by seed."""
    sent = [*product(POLICIES, CHOSEN), *product(DEPLOYED, ("deployed",))]
    return [Case(density_per_km, policy, way, seed) for seed, (policy, way) in product(range(seeds), sent)]


def whole_seeds(density_per_km: float, seeds: int, folder: Path) -> int:
    """How many seeds of a density the folder has all runs of."""
    lacking = {one.seed for one in cases(density_per_km, seeds) if not (folder / f"{one.name}.json").exists()}
    return min(lacking, default=seeds)


class Overheard(AbstractRadio[SidelinkState]):
    """A radio, and all that it is asked to carry: messages, places and the end of each step."""

    def __init__(self, radio: Sidelink) -> None:
        self.radio = radio
        self.steps: list[tuple[Transmissions, FloatArray, float]] = []

    def init(self, vehicles: int, rng: np.random.Generator) -> SidelinkState:
        """As the radio."""
        return self.radio.init(vehicles, rng)

    def step(
        self, state: SidelinkState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, SidelinkState]:
        """As the radio."""
        self.steps.append((transmissions, position_m.copy(), until_t_s))
        return self.radio.step(state, transmissions, position_m, until_t_s)

    def channel_busy_ratio(self, state: SidelinkState) -> FloatArray:
        """As the radio."""
        return self.radio.channel_busy_ratio(state)


def known(steps: list[tuple[Transmissions, FloatArray, float]], seed: int) -> dict[str, float]:
    """What the radio makes of the same messages where each says for certain when the next comes."""
    radio = Sidelink(WAYS["by next"])
    sender = np.concatenate([one.sender for one, _, _ in steps])
    ready_s = np.concatenate([one.ready_s for one, _, _ in steps])
    order = np.lexsort((ready_s, sender))
    next_s = np.full(sender.size, np.inf)
    same = sender[order][1:] == sender[order][:-1]
    next_s[order[:-1][same]] = ready_s[order[1:][same]]
    state, at = radio.init(steps[0][1].shape[0], np.random.default_rng([seed, 29])), 0
    outcomes = np.zeros((radio.parameters.bins, len(OUTCOMES)), dtype=np.int64)
    for transmissions, place_m, until_s in steps:
        own = replace(transmissions, next_s=next_s[at : at + transmissions.size])
        received, state = radio.step(state, own, place_m, until_s)
        at += transmissions.size
        outcomes += received.outcomes * (until_s > SETTINGS.warm_up_s)
    near = outcomes[NEAR].sum(axis=0) / outcomes[NEAR].sum()
    return {"delivery_ratio": float(near[0]), "collision_ratio": float(near[3] + near[4])}


def announced(steps: list[tuple[Transmissions, FloatArray, float]]) -> dict[str, float]:
    """Shares of the messages that came in the step in which they were expected, before and after it."""
    sender, ready_s, said_s = (
        np.concatenate([getattr(one, name) for one, _, _ in steps])
        for name in ("sender", "ready_s", "next_s")
    )
    order = np.lexsort((ready_s, sender))
    same = sender[order][1:] == sender[order][:-1]
    late_s = (ready_s[order][1:] - said_s[order][:-1])[same]
    late, early = float((late_s > 0.5 * STEP_S).mean()), float((late_s < -0.5 * STEP_S).mean())
    return {"in_step": 1.0 - early - late, "early": early, "late": late}


def heard_of(radio: Overheard, seed: int) -> dict[str, float]:
    """What an overheard run says beside its own figures."""
    return {**known(radio.steps, seed), **announced(radio.steps)}


def drive(case: Case) -> dict[str, float]:
    """Drive the fleet once: `FIGURES`, and what it took [s]; where it is overheard, what was announced."""
    start = time.perf_counter()
    model = named_sensor("default")
    alone = {"approach_m": np.inf, "keep_alive_s": 5.0} if case.policy == ERRORS_ALONE else {}
    name = case.policy.partition(",")[0]
    sender = named_sender(name, threshold_m=THRESHOLD_M, motion=filter_for(model), **alone)
    own = Sidelink(WAYS["one-shot" if case.way == KNOWN else case.way])
    radio = Overheard(own) if case.way == KNOWN else own
    frames = run_scenario(
        Highway(LENGTH_M, case.density_per_km),
        np.random.default_rng([case.seed, 23]),
        duration_s=DURATION_S,
    )
    found = run_network(frames, sender, radio, SETTINGS, seed=case.seed, sensor=FleetSensor(model))
    named = NetworkCase(case.density_per_km, case.way, case.policy, "default", case.seed)
    row = measure(found, named, SETTINGS, outcome_bin_m=own.bin_m).run
    return {
        **{name: float(getattr(row, name)) for name in FIGURES},
        **(heard_of(radio, case.seed) if isinstance(radio, Overheard) else {}),
        "wall_s": time.perf_counter() - start,
    }


def kept(case: Case, folder: Path) -> dict[str, float]:
    """What the folder has of a case, made where it has nothing."""
    path = folder / f"{case.name}.json"
    if not path.exists():
        done = drive(case)
        path.write_text(json.dumps(done), encoding="utf-8")
        print(path.stem, {name: round(value, 4) for name, value in done.items()}, file=sys.stderr, flush=True)
    return json.loads(path.read_text(encoding="utf-8"))


Found = dict[tuple[float, str, str], list[dict[str, float]]]
"""Runs of all seeds by density, policy and way."""


def _half(values: np.ndarray) -> float:
    """Half the 95 % interval of a mean over seeds."""
    if values.size < 2:
        return np.nan
    return float(stats.t.ppf(0.975, values.size - 1) * values.std(ddof=1) / np.sqrt(values.size))


def _figure(found: Found, key: tuple[float, str, str], name: str) -> np.ndarray:
    return np.array([one[name] for one in found[key]])


def _rows(found: Found, keys: Sequence[tuple[float, str, str]]) -> list[str]:
    """A row a setting: messages, delivery, collisions, p90 and busy ratio."""
    heads = ("vehicles/km", "policy", "grant", "messages/s", "received %", "collided %", "p90 cm", "busy %")
    lines = [f"| {' | '.join(heads)} |", "|---:|---|---|" + "---:|" * 5]
    for density, policy, way in keys:
        one = {name: _figure(found, (density, policy, way), name) for name in FIGURES}
        cells = [
            f"{one['message_rate_hz'].mean():.2f}",
            *(
                f"{100 * one[name].mean():.{digits}f} ± {100 * _half(one[name]):.{digits}f}"
                for name, digits in (("delivery_ratio", 1), ("collision_ratio", 1), ("pte_p90_m", 2))
            ),
            f"{100 * one['busy_ratio'].mean():.1f}",
        ]
        lines.append(f"| {density:g} | `{policy}` | {way} | {' | '.join(cells)} |")
    return lines


def _gains(found: Found, densities: list[float]) -> list[str]:
    """What choosing by the next message changes, seed by seed."""
    heads = ("vehicles/km", "policy", "received, against one-shot", "against reserved")
    lines = [
        f"| {' | '.join((*heads, 'p90, against one-shot', 'against reserved'))} |",
        "|---:|---|" + "---:|" * 4,
    ]
    for density, policy in product(densities, POLICIES):
        cells = []
        for name, relative in (("delivery_ratio", False), ("pte_p90_m", True)):
            own = _figure(found, (density, policy, "by next"), name)
            for other in ("one-shot", "reserved"):
                theirs = _figure(found, (density, policy, other), name)
                gain = own / theirs - 1.0 if relative else own - theirs
                unit = "%" if relative else "points"
                cells.append(f"{100 * gain.mean():+.1f} ± {100 * _half(gain):.1f} {unit}")
        lines.append(f"| {density:g} | `{policy}` | {' | '.join(cells)} |")
    return lines


def _announced(found: Found, densities: list[float]) -> list[str]:
    """How often the next message came when its sender expected it, of runs that say so."""
    heads = ("vehicles/km", "policy", "runs", "in its step %", "earlier %", "later %")
    lines = [f"| {' | '.join(heads)} |", "|---:|---|" + "---:|" * 4]
    for density, policy in product(densities, POLICIES):
        runs = [one for one in found[density, policy, KNOWN] if "in_step" in one]
        if runs:
            means = (100 * np.mean([one[name] for one in runs]) for name in ("in_step", "early", "late"))
            lines.append(
                f"| {density:g} | `{policy}` | {len(runs)} | {' | '.join(f'{one:.1f}' for one in means)} |"
            )
    return lines


def tables(found: Found) -> dict[str, list[str]]:
    """Lines of Markdown by block of the page."""
    densities = sorted({density for density, _, _ in found})
    seeds = ", ".join(f"{len(found[one, POLICIES[0], CHOSEN[0]])} at {one:g}/km" for one in densities)
    note = (
        f"Highway of {LENGTH_M / 1000:g} km, {DURATION_S:g} s, {SETTINGS.warm_up_s:g} s of them not counted; "
        f"pairs 50 m to 150 m apart; mean with its 95 % interval over seeds, {seeds}. "
        f"modelcast {package_version()}."
    )
    chosen = [(density, *one) for density, one in product(densities, product(POLICIES, CHOSEN))]
    deployed = [(density, policy, "deployed") for density, policy in product(densities, DEPLOYED)]
    return {
        "grants": [*_rows(found, chosen), "", note],
        "grants-gain": _gains(found, densities),
        "grants-announced": _announced(found, densities),
        "grants-deployed": [*_rows(found, deployed), "", note],
    }


def main() -> int:
    """Run all, print the tables, and write or check the page where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--densities", type=float, nargs="+", default=DENSITIES_PER_KM, help="vehicles a km")
    parser.add_argument("--seeds", type=int, default=10, help="runs of each setting")
    parser.add_argument("--kept", action="store_true", help="make nothing: take the seeds that are whole")
    asked = parser.add_mutually_exclusive_group()
    asked.add_argument("--write", action="store_true", help="put the tables into docs/grants.md")
    asked.add_argument("--check", action="store_true", help="tell whether docs/grants.md has them")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    found: Found = {}
    for density in given.densities:
        seeds = whole_seeds(density, given.seeds, given.folder) if given.kept else given.seeds
        for case in cases(density, seeds):
            found.setdefault((density, case.policy, case.way), []).append(kept(case, given.folder))
    if not found:
        parser.error("no seed is whole")
    blocks = tables(found)
    print("\n".join(line for lines in blocks.values() for line in [*lines, ""]))
    if given.write or given.check:
        return put({PAGE: blocks}, check=given.check)
    return 0


if __name__ == "__main__":
    sys.exit(main())
