"""What a node measures by: its sources, what aligns them, and the figures of both."""

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import final, get_args

from modelcast.node.inputs.base import AbstractSource
from modelcast.node.inputs.motion import Mode, Motion
from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.journal import Journal
from modelcast.node.metrics import Metric

__all__ = ["Measuring"]

_MODES: tuple[Mode, ...] = get_args(Mode)
_WITH_FIXES = frozenset({"gnss+can", "gnss"})
_WITH_BUS = frozenset({"gnss+can", "can"})


@final
class Measuring:
    """Sources, and what aligns them.

    Parameters
    ----------
    sources
        By what they are, ``gnss`` and ``can``; they are started and stopped elsewhere.
    motion
        Aligns what they give.
    journal
        Takes what changes.
    """

    def __init__(self, sources: Mapping[str, AbstractSource], motion: MotionSource, journal: Journal) -> None:
        self.motion = motion
        self._sources, self._journal = dict(sources), journal
        self._changes: Counter[str] = Counter(dict.fromkeys(("frozen", *_MODES), 0))
        self._lost: Counter[str] = Counter(dict.fromkeys(sources, 0))

    def at(self, now_s: float) -> Motion | None:
        """The own motion at a step's instant; what changed is counted and written down.

        Parameters
        ----------
        now_s
            As for `MotionSource.at` [s].
        """
        for source in self._sources.values():
            self.motion.feed(source.take(now_s))
        found = self.motion.at(now_s)
        for change in self.motion.events():
            if change.what == "mode":
                self._changes[change.after] += 1
                self._lose("gnss", change.before, change.after, _WITH_FIXES)
                self._lose("can", change.before, change.after, _WITH_BUS)
            elif change.after != "nothing":
                self._changes["frozen"] += 1
            what = {"what": change.what, "before": change.before, "after": change.after, "why": change.why}
            self._journal.note("inputs", what)
        return found

    def _lose(self, source: str, before: str, after: str, modes: frozenset[str]) -> None:
        """Count an outage: its source was in use, and something else still is, or nothing."""
        if source in self._lost and before in modes and after not in modes:
            self._lost[source] += 1

    def figures(self) -> Iterator[Metric]:
        """The figures of the inputs for Prometheus."""
        for name, source in self._sources.items():
            counts = source.counts()
            text = f"What the {name} source met: samples, connections, and what was passed over."
            values = {what: float(many) for what, many in counts.items()}
            yield Metric(f"modelcast_{name}_total", "counter", text, values, "what")
        again = {
            name: float(max(source.counts().get("connections", 0) - 1, 0))
            for name, source in self._sources.items()
        }
        yield Metric("modelcast_reconnects_total", "counter", "Connections after the first.", again, "source")
        lost = {name: float(many) for name, many in self._lost.items()}
        text = "Times that a source was in use and then was lost, stale or frozen."
        yield Metric("modelcast_outages_total", "counter", text, lost, "source")
        health = self.motion.health
        text = "Samples that were aligned, and those left out, by reason."
        aligned = {what: float(many) for what, many in health.counts.items()}
        yield Metric("modelcast_aligned_total", "counter", text, aligned, "what")
        text = "1 for what the own motion is made of."
        modes = {mode: float(mode == health.mode) for mode in _MODES}
        yield Metric("modelcast_mode", "gauge", text, modes, "mode")
        text = "Changes of what the own motion is made of, by what it became."
        became = {mode: float(self._changes[mode]) for mode in _MODES}
        yield Metric("modelcast_mode_changes_total", "counter", text, became, "mode")
        yield Metric(
            "modelcast_frozen_total",
            "counter",
            "Times that a source was found to stand still and should not.",
            {"": float(self._changes["frozen"])},
        )
        text = "1 for what stands still now and should not."
        frozen = dict.fromkeys(sorted(health.frozen), 1.0)
        yield Metric("modelcast_frozen", "gauge", text, frozen, "quantity")
        text = "Age of the newest fix, +Inf where there was none."
        yield Metric("modelcast_fix_age_seconds", "gauge", text, {"": health.fix_age_s})
        text = "Age from which a fix is stale."
        yield Metric("modelcast_fix_stale_seconds", "gauge", text, {"": health.fix_stale_s})
        text = "Age of the newest value of each quantity of the bus."
        yield Metric("modelcast_bus_age_seconds", "gauge", text, dict(health.bus_ages_s), "quantity")
