"""What the page and the figures say of a node, from its state after a step."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING

from modelcast.core.kinds import PEOPLE, Kind
from modelcast.dashboard.snapshot import AHEAD_S, Host, Snapshot, WarningShown, remotes_of
from modelcast.node.metrics import Metric
from modelcast.node.node import Node, NodeState
from modelcast.node.run import Lateness

if TYPE_CHECKING:
    from modelcast.node.recording.recorder import Recorder

__all__ = ["Showing", "Truth", "figures_of", "figures_of_recorder"]

Truth = Callable[[float], Mapping[int, tuple[float, float]]]
"""Gives true places on the node's plane at a time [s], by temporary id [m]."""

_SHARES = (0.5, 0.99)


class Showing:
    """Makes snapshots of one node; remembers since when each warning has been said.

    Parameters
    ----------
    node
        Which.
    truth_m
        Gives where vehicles are at a time, by temporary id, where that is known; None where nobody knows.
    """

    def __init__(self, node: Node, truth_m: Truth | None = None) -> None:
        self._node, self._truth_m = node, truth_m
        self._begun_s: dict[tuple[str, int], float] = {}

    def snapshot(self, state: NodeState) -> Snapshot:
        """What the page shows after a step.

        Parameters
        ----------
        state
            As the step returned it.
        """
        node, own = self._node, state.motion
        said = {(one.application, one.vehicle): int(one.level) for one in state.warnings}
        self._begun_s = {key: self._begun_s.get(key, state.t_s) for key in said}
        host = own and Host(
            state.temporary_id,
            own.position_m,
            heading_rad=own.heading_rad,
            speed_mps=own.speed_mps,
            inputs=own.mode,
        )
        vehicles: list[int] = state.around.vehicle.tolist()
        heard = node.station.deliveries(state.around.vehicle, state.t_s)
        return Snapshot(
            state.t_s,
            host,
            remotes=remotes_of(
                state.around,
                node.station.paths(state.t_s, AHEAD_S),
                state.t_s,
                model_names=node.station.model_names,
                messages=dict(zip(vehicles, heard.received.tolist(), strict=True)),
                loss_ratio=dict(zip(vehicles, heard.loss_ratio.tolist(), strict=True)),
                truth_m=None if self._truth_m is None else self._truth_m(state.t_s),
            ),
            warnings=tuple(
                WarningShown(level, kind, vehicle, self._begun_s[kind, vehicle])
                for (kind, vehicle), level in said.items()
            ),
            counters=node.meter.counters(state.t_s, loss_ratio=heard.total_loss_ratio),
        )


def figures_of(node: Node | None, state: NodeState | None, late: Lateness) -> Iterator[Metric]:
    """The figures of a node for Prometheus.

    Parameters
    ----------
    node
        Which; None before its plane begins.
    state
        After its last step; None before the first.
    late
        How late its steps began.
    """
    counts = Counter[str]() if node is None else node.counts
    for name, text in (
        ("sent", "Frames handed to the transport."),
        ("heard", "Frames that arrived."),
    ):
        yield Metric(f"modelcast_{name}_total", "counter", text, {"": float(counts[name])})
        octets = {"": float(counts[f"{name}_octets"])}
        yield Metric(f"modelcast_{name}_octets_total", "counter", f"{text} Their octets.", octets)
    for kind, label, text in (
        ("refused", "why", "Frames refused by their envelope."),
        ("opened", "how", "Frames whose message was taken out of its envelope."),
        ("receipt", "receipt", "What became of messages."),
    ):
        start = f"{kind}: "
        own = {
            name.removeprefix(start): float(count) for name, count in counts.items() if name.startswith(start)
        }
        yield Metric(f"modelcast_{kind}_total", "counter", text, own, label)
    around = 0.0 if state is None else float(state.around.vehicle.size)
    yield Metric("modelcast_remotes", "gauge", "Remotes with a live track.", {"": around})
    kinds = [] if state is None else [Kind(one).name.lower() for one in state.around.kind.tolist()]
    by_kind = {kind.name.lower(): float(kinds.count(kind.name.lower())) for kind in (Kind.VEHICLE, *PEOPLE)}
    text = "Remotes with a live track, by the kind of road user that they say they are."
    yield Metric("modelcast_remotes_by_kind", "gauge", text, by_kind, "kind")
    silent = 1.0 if state is None or state.motion is None else 0.0
    yield Metric("modelcast_silent", "gauge", "1 where the node does not know where it is.", {"": silent})
    yield Metric("modelcast_steps_total", "counter", "Steps taken.", {"": float(late.count)})
    yield Metric("modelcast_skipped_steps_total", "counter", "Steps left out.", {"": float(late.skipped)})
    lateness = {f"{share:g}": late.quantile_s(share) for share in _SHARES}
    text = "How late steps begin, over the last 4096."
    yield Metric("modelcast_lateness_seconds", "gauge", text, lateness, "quantile")


def figures_of_recorder(recorder: "Recorder") -> Iterator[Metric]:
    """The figures of a recording for Prometheus.

    Parameters
    ----------
    recorder
        Which.
    """
    octets = {"": float(recorder.octets)}
    yield Metric("modelcast_recorded_octets_total", "counter", "Octets written of the recording.", octets)
    text = "1 while the node is recorded, 0 after that ended."
    yield Metric("modelcast_recording", "gauge", text, {"": 0.0 if recorder.ended else 1.0})
