"""What a node has to go by at a tick: which fix, which values of the bus, and what that is called."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from modelcast.node.inputs.frozen import frozen_quantities, same_place_since
from modelcast.node.inputs.motion import Mode
from modelcast.node.inputs.samples import SAME_S, GnssFix
from modelcast.node.inputs.series import Series, stale_after_s

__all__ = ["State", "judged"]

_NEEDED = frozenset({"speed_mps", "yaw_rate_radps"})
"""What dead reckoning needs of the bus."""
_GAPS = 5


@dataclass(frozen=True, slots=True)
class State:
    """What there is at a tick.

    Parameters
    ----------
    mode, why
        As in `modelcast.node.inputs.motion.Health`.
    fixes
        In order of time; the last is the one to go on from.
    fresh, frozen
        Quantities of the bus that are used, and what stands still and should not.
    stale_s
        Age from which a fix is old [s].
    """

    mode: Mode
    why: str
    fixes: Sequence[GnssFix]
    fresh: frozenset[str]
    frozen: frozenset[str]
    stale_s: float


def judged(
    now_s: float, fixes: Sequence[GnssFix], bus: Mapping[str, Series], *, stale_s: float, reckon_s: float
) -> State:
    """What there is at a tick.

    Parameters
    ----------
    now_s
        The tick [s].
    fixes
        All that arrived, in order of time.
    bus
        Values that arrived, by quantity.
    stale_s
        Longest age of anything used as fresh [s].
    reckon_s
        How long a place may be reckoned without fixes [s].
    """
    fixes = _one_an_instant(fixes)
    old_s = stale_after_s([fix.measured_s for fix in fixes[-_GAPS - 1 :]], stale_s)
    frozen = frozen_quantities(fixes, bus)
    fresh = frozenset(
        name
        for name, series in bus.items()
        if name not in frozen and now_s - series.newest_s <= series.stale_after_s(stale_s) + SAME_S
    )
    if not fixes:
        return State("silent", "no fix yet", fixes, fresh, frozen, old_s)
    age_s = now_s - fixes[-1].measured_s
    lost = f"no fix for {age_s:.1f} s"
    since = same_place_since(fixes, bus["speed_mps"] if "speed_mps" in fresh else None)
    if since is not None:
        frozen |= {"place"}
        fixes = fixes[: since + 1]
        age_s = now_s - fixes[-1].measured_s
        lost = f"place frozen for {age_s:.1f} s"
    elif age_s <= old_s + SAME_S:
        whole = fresh >= _NEEDED
        why = "fixes and bus" if whole else _bus_words(frozen, bus)
        return State("gnss+can" if whole else "gnss", why, fixes, fresh, frozen, old_s)
    if not fresh >= _NEEDED:
        return State("silent", f"{lost} and {_bus_words(frozen, bus)}", fixes, fresh, frozen, old_s)
    if age_s > reckon_s + SAME_S:
        return State("silent", f"{lost}, too long to reckon", fixes, fresh, frozen, old_s)
    return State("can", lost, fixes, fresh, frozen, old_s)


def _one_an_instant(fixes: Sequence[GnssFix]) -> list[GnssFix]:
    """Fixes in order of time, of one instant the one that arrived last."""
    last = len(fixes) - 1
    return [
        fix
        for at, fix in enumerate(fixes)
        if at == last or fixes[at + 1].measured_s - fix.measured_s > SAME_S
    ]


def _bus_words(frozen: frozenset[str], bus: Mapping[str, Series]) -> str:
    """Why the bus does not help."""
    held = sorted(frozen & _NEEDED)
    if held:
        return f"{' and '.join(held)} frozen"
    return "bus lost" if any(len(bus[name]) for name in _NEEDED) else "no bus"
