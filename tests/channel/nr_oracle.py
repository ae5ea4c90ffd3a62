"""NR-V2X mode 2 again, slow and in plain Python: slot by slot, pair by pair, sub-channel by sub-channel.

Nothing is kept but lists of what happened: what a vehicle knows is sought in them anew for every choice.
Chance is drawn from the same generators in the same order, so both give the same frames.
"""

import itertools
import math
from dataclasses import dataclass, field

import numpy as np

from modelcast.channel.dsrc_parameters import thermal_noise_dbm
from modelcast.channel.error_models import HAZARD_MIN_DB, HAZARD_PER_DB, HAZARD_SIZE
from modelcast.channel.in_band_emission import in_band_emission
from modelcast.channel.nr import Nr
from modelcast.channel.radio import OUTCOMES, Grant, Transmissions
from modelcast.channel.random_kernels import LUCK, next_word, uniform, uniform_of
from modelcast.core.arrays import FloatArray

__all__ = ["Oracle"]

_GRID_DB = HAZARD_MIN_DB + np.arange(HAZARD_SIZE) / HAZARD_PER_DB


@dataclass
class Plan:
    """Resources of a vehicle: (slot, first sub-channel) of each copy, and what becomes of them."""

    copies: list[tuple[int, int] | None]
    length: int
    interval: int
    counter: int
    wish: int
    unused: int = 0
    comes_back: bool = False


@dataclass
class Waiting:
    """A message that waits or of which copies are to come."""

    number: int
    size_bytes: int
    power_dbm: float
    sent: int = 0
    fate: dict[int, str] = field(default_factory=dict[int, str])


@dataclass(frozen=True)
class Frame:
    """One frame on the air."""

    sender: int
    band: int
    length: int
    message: Waiting
    copy: int
    seed: int


class Oracle:
    """A fleet that stands still, without shadowing and fading; all parts of `Nr` are given by it.

    Parameters
    ----------
    radio
        Whose parameters and path loss are taken.
    place_m
        Of all vehicles, (V, 2) [m].
    rng
        Seeds as `Nr.init` seeds.
    """

    def __init__(self, radio: Nr, place_m: np.ndarray, rng: np.random.Generator) -> None:
        self.p, self.place_m = radio.parameters, place_m
        self.random = rng.integers(0, 2**64, size=2, dtype=np.uint64)
        self.vehicles = range(len(place_m))
        self.apart_m = np.hypot(*(place_m[:, None] - place_m[None]).transpose(2, 0, 1))
        los_ln = radio.propagation.tables(radio.range_m).los_ln
        self.gain_db: FloatArray = (
            np.interp(self.apart_m, 0.5 * np.arange(los_ln.size), los_ln) * 10.0 / np.log(10.0)
        )
        self.range_m, self.sensed_m = radio.range_m, radio.constants.pool.sensing_range_m
        self.hazard = radio.errors.hazard
        p = self.p
        self.leak = in_band_emission(p.sub_channels, p.blocks, mask=p.emission, total_blocks=p.channel_blocks)
        self.noise_mw = 10.0 ** (0.1 * (thermal_noise_dbm(p.sub_channel_hz) + p.noise_figure_db))
        self.plans: dict[int, Plan] = {}
        self.waiting: dict[int, Waiting] = {}
        self.reserved: dict[tuple[int, int], list[tuple[range, float]]] = {}
        """By who knows and of which slot: which sub-channels, how loud."""
        self.deaf: set[tuple[int, int]] = set()
        self.received: list[tuple[int, int, float, float]] = []
        self.expired: list[int] = []
        self.outcomes = np.zeros((p.bins, len(OUTCOMES)), dtype=np.int64)

    def run(self, transmissions: Transmissions, slots: int) -> None:
        """Carry so many slots from 0."""
        ready = np.floor(transmissions.ready_s * 1e3 * self.p.slots_a_ms + 1e-6)
        for slot in range(slots):
            frames = self._frames(slot)
            for frame in frames:
                for j in self.vehicles:
                    if j != frame.sender and self.apart_m[frame.sender, j] <= self.range_m:
                        self._deliver(slot, frame, j, frames)
            for frame in frames:
                self._finish(slot, frame)
            for n in np.flatnonzero(ready == slot):
                self._take_in(slot, transmissions, int(n))

    def _frames(self, slot: int) -> list[Frame]:
        """Who sends now."""
        frames: list[Frame] = []
        for v in self.vehicles:
            if v not in self.plans:
                continue
            plan = self.plans[v]
            for copy, resource in enumerate(plan.copies):
                if resource is None or resource[0] != slot:
                    continue
                message = self.waiting.get(v)
                if message is not None and copy == 0:
                    plan.unused, plan.comes_back = 0, self._comes_back(v, plan)
                plan.copies[copy] = (slot + plan.interval, resource[1]) if plan.interval else None
                if message is None:
                    plan.unused += copy == 0
                    if 0 < self.p.reselect_after <= plan.unused:
                        del self.plans[v]
                        break
                    continue
                seed = int(next_word(self.random)) >> 1
                frames.append(Frame(v, resource[1], plan.length, message, copy, seed))
        return frames

    def _comes_back(self, v: int, plan: Plan) -> bool:
        held, plan.interval = plan.interval, plan.wish
        if not plan.interval:
            return False
        if plan.counter > 1:
            plan.counter -= 1
        elif uniform(self.random) < self.p.keep_ratio:
            plan.counter = self._counter(plan.interval)
        else:
            return False
        if plan.interval == held:
            return True
        back = [(one[0] + plan.interval, one[1]) for one in plan.copies if one is not None]
        known = [self._known_mw(v, at, range(band, band + plan.length)) for at, band in back]
        return max(known) <= 10.0 ** (0.1 * self.p.reserved_dbm)

    def _counter(self, interval: int) -> int:
        times = math.ceil(100.0 / min(max(interval / self.p.slots_a_ms, 20.0), 100.0))
        return 5 * times + int(uniform(self.random) * (10 * times + 1))

    def _power_mw(self, frame: Frame, j: int) -> float:
        """What arrives of a frame; nothing where it is far below the noise of its sub-channels."""
        if j == frame.sender:
            return 0.0
        gains_db = 2.0 * self.p.antenna_gain_db + self.gain_db[frame.sender, j]
        power_mw = 10.0 ** (0.1 * (frame.message.power_dbm + gains_db))
        least_mw = self.noise_mw * frame.length * 10.0 ** (-0.1 * self.p.margin_db)
        return float(power_mw) if power_mw >= least_mw else 0.0

    def _inside_mw(self, other: Frame, frame: Frame, j: int) -> float:
        """What arrives of another frame in the sub-channels of one."""
        each = [
            self._power_mw(other, j) / other.length * self.leak[other.length - 1, other.band, s]
            for s in range(frame.band, frame.band + frame.length)
        ]
        return float(sum(each))

    def _deliver(self, slot: int, frame: Frame, j: int, frames: list[Frame]) -> None:
        power_mw, others = self._power_mw(frame, j), [one for one in frames if one is not frame]
        disturbing = [(self._inside_mw(one, frame, j), one.sender) for one in others]
        noise_mw = self.noise_mw * frame.length
        sinr = power_mw / (noise_mw + sum(other_mw for other_mw, _ in disturbing))
        if any(one.sender == j for one in others):
            fate = "half-duplex"
        else:
            fate = self._fate(frame, j, power_mw, sinr)
            if fate == "interference":
                worst = max(disturbing)[1]
                fate = "concurrent" if self.apart_m[frame.sender, worst] <= self.sensed_m else "hidden"
            if power_mw > 0.0 and sinr >= 10.0 ** (0.1 * self.p.control_db):
                self._overhear(frame, j, power_mw)
        known = frame.message.fate
        if known.get(j) != "received":
            if fate == "received":
                end_s = (slot + 1) * 1e-3 / self.p.slots_a_ms
                self.received.append((frame.message.number, j, end_s, 10.0 * math.log10(power_mw)))
            known[j] = fate

    def _fate(self, frame: Frame, j: int, power_mw: float, sinr: float) -> str:
        needed_db = float(self.p.threshold_db(np.array([frame.message.size_bytes]))[0])
        luck = -math.log(1.0 - uniform_of(frame.seed, j + LUCK))

        def lost(ratio: float) -> bool:
            at_db = 10.0 * math.log10(ratio) - needed_db if ratio > 0.0 else -math.inf
            return bool(np.interp(at_db, _GRID_DB, self.hazard) > luck)

        if power_mw < 10.0 ** (0.1 * self.p.sensitivity_dbm):
            return "below-sensitivity"
        if not lost(sinr):
            return "received"
        return "below-sensitivity" if lost(power_mw / (self.noise_mw * frame.length)) else "interference"

    def _overhear(self, frame: Frame, j: int, power_mw: float) -> None:
        """What the control information of a frame says: its later copies, and itself again."""
        plan = self.plans[frame.sender]
        rsrp_mw = power_mw / (frame.length * self.p.sub_channel_hz / 15e3)
        for copy, resource in enumerate(plan.copies):
            if resource is None or copy < frame.copy or (copy == frame.copy and not plan.comes_back):
                continue
            slot, band = resource
            used = range(band, band + frame.length)
            uses = math.ceil(self.p.last_ms * self.p.slots_a_ms / plan.interval) if copy == frame.copy else 1
            for use in range(uses):
                self.reserved.setdefault((j, slot + use * plan.interval), []).append((used, rsrp_mw))

    def _finish(self, slot: int, frame: Frame) -> None:
        v = frame.sender
        self.deaf.add((v, slot))
        frame.message.sent += 1
        plan = self.plans[v]
        if frame.message.sent == len(plan.copies):
            self._count(v)
            if not plan.comes_back:
                del self.plans[v]

    def _count(self, v: int) -> None:
        message = self.waiting.pop(v)
        for j, fate in message.fate.items():
            group = int(self.apart_m[v, j] / self.p.bin_m)
            if group < self.p.bins:
                self.outcomes[group, OUTCOMES.index(fate)] += 1

    def _take_in(self, slot: int, sent: Transmissions, n: int) -> None:
        v = int(sent.sender[n])
        if v in self.waiting:
            if self.waiting[v].sent:
                self._count(v)
            else:
                self.expired.append(self.waiting.pop(v).number)
        size_bytes = int(sent.size_bytes[n])
        self.waiting[v] = Waiting(int(sent.message_id[n]), size_bytes, float(sent.power_dbm[n]))
        length, interval = int(self.p.length(np.array([size_bytes]))[0]), self._interval(sent, n)
        if v in self.plans and self._fits(slot, self.plans[v], length, interval):
            self.plans[v].wish = interval
            return
        copies = self._choose(v, slot, length, interval)
        self.plans[v] = Plan(copies, length, interval, 1, interval)
        if interval:
            self.plans[v].counter = self._counter(interval)

    def _interval(self, sent: Transmissions, n: int) -> int:
        wish, gap_ms = int(sent.grant[n]), 1e3 * float(sent.next_s[n] - sent.ready_s[n])
        if wish == Grant.ONE_SHOT or (wish == Grant.ANY and self.p.dynamic):
            return 0
        interval_ms = self.p.interval_ms
        if wish == Grant.PERIODIC and math.isfinite(gap_ms):
            allowed = [*range(1, 100), *range(100, self.p.longest_ms + 1, 100)]
            allowed = [one for one in allowed if one <= self.p.longest_ms]
            interval_ms = next((one for one in allowed if one >= gap_ms - 1e-6), self.p.longest_ms)
        return interval_ms * self.p.slots_a_ms

    def _fits(self, slot: int, plan: Plan, length: int, interval: int) -> bool:
        if plan.length < length or (plan.interval > 0) != (interval > 0):
            return False
        times = [resource[0] for resource in plan.copies if resource is not None]
        if len(times) < len(plan.copies):  # some of it is spent
            return False
        first = slot + self.p.first_ms * self.p.slots_a_ms
        last = slot + self.p.last_ms * self.p.slots_a_ms
        rises = all(a < b for a, b in itertools.pairwise(times))
        if interval and times[-1] - times[0] >= interval:
            return False
        return rises and times[0] >= first and times[-1] <= last

    def _known_mw(self, v: int, slot: int, used: range) -> float:
        """How loud the strongest reservation of a resource is; infinite where the vehicle could not know."""
        if (v, slot - self.p.interval_ms * self.p.slots_a_ms) in self.deaf:
            return math.inf
        heard = self.reserved.get((v, slot), [])
        return max((rsrp_mw for there, rsrp_mw in heard if set(there) & set(used)), default=0.0)

    def _choose(self, v: int, slot: int, length: int, interval: int) -> list[tuple[int, int] | None]:
        p = self.p
        first, last = (round(ms * p.slots_a_ms) for ms in (p.first_ms, p.last_ms))
        bands = range(0, p.sub_channels - length + 1, 1 if p.overlapping else length)
        known = {
            (at, band): self._known_mw(v, at, range(band, band + length))
            for at in range(slot + first, slot + last + 1)
            for band in bands
        }
        wanted = math.ceil(p.free_ratio * sum(math.isfinite(power_mw) for power_mw in known.values()))
        limit_dbm = p.reserved_dbm
        while True:
            limit_mw = 10.0 ** (0.1 * limit_dbm)
            free = [one for one, power_mw in known.items() if power_mw <= limit_mw]
            if len(free) >= wanted or limit_dbm >= 60.0:
                break
            limit_dbm += 3.0
        free = free or list(known)
        chosen: list[tuple[int, int]] = []
        span = min(32, interval or 32)
        for _ in range(p.transmissions):
            left = [
                one
                for one in free
                if all(one[0] != other[0] and abs(one[0] - other[0]) < span for other in chosen)
            ]
            if not left:
                break
            chosen.append(left[int(uniform(self.random) * len(left))])
        return list[tuple[int, int] | None](sorted(chosen))
