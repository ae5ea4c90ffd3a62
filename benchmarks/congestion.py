"""Whether J2945/1's rules and the neighbour tables cost more, for each vehicle, in a larger fleet.

Every host hears 300 remotes at 10 Hz. Messages come host by host, as from an engine that sorts the receptions
of a step, or sender by sender. Figures are processor time, the best of three.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from measured import record
from modelcast.station.policy import j2945_kernels, neighbours_kernels
from modelcast.station.policy.j2945 import J2945
from modelcast.station.policy.neighbours import neighbour_tables

REMOTES = 300
CAPACITY = 384


@dataclass
class Fleet:
    """Hosts that hear their remotes again and again."""

    hosts: int
    by_host: bool
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    ticks: int = 0

    def __post_init__(self) -> None:
        near = np.stack([self.rng.choice(2 * REMOTES, REMOTES, replace=False) for _ in range(self.hosts)])
        host = np.repeat(np.arange(self.hosts), REMOTES)
        remote = (np.arange(self.hosts)[:, None] + near).ravel()
        order = np.arange(host.size) if self.by_host else np.argsort(remote, kind="stable")
        self.host, self.remote = host[order], remote[order]
        self.position_m = self.rng.uniform(-150.0, 150.0, (host.size, 2))
        self.slots = np.empty(host.size, dtype=np.int64)
        self.tables = neighbour_tables(self.hosts, CAPACITY)
        self.found, self.ratio = np.empty(self.hosts, dtype=np.int64), np.empty(self.hosts)

    def hear(self) -> None:
        """Every host hears every remote once."""
        self.ticks += 1
        neighbours_kernels.hear_each(
            *self.tables,
            self.host,
            self.remote,
            np.full(self.host.size, self.ticks % 128),
            np.full(self.host.size, 0.1 * self.ticks),
            self.position_m,
            1.0,
            self.slots,
        )

    def survey(self) -> None:
        """Every host counts, with ratios."""
        now = np.full(self.hosts, 0.1 * self.ticks)
        here = np.zeros((self.hosts, 2))
        neighbours_kernels.survey_each(*self.tables[:2], now, here, 1.0, 100.0, self.found, self.ratio)

    def count(self) -> None:
        """Every host counts."""
        now = np.full(self.hosts, 0.1 * self.ticks)
        neighbours_kernels.count_each(
            *self.tables[:2], now, np.zeros((self.hosts, 2)), 1.0, 100.0, self.found
        )


def best_of_three(run: Callable[[], object]) -> float:
    """Shortest processor time of three [s], after one run to warm up."""
    run()
    times = []
    for _ in range(3):
        begun = time.process_time()
        run()
        times.append(time.process_time() - begun)
    return min(times)


def step_time(hosts: int) -> float:
    """Processor time of one step of J2945/1's rules for a fleet [s]."""
    rng = np.random.default_rng(1)
    policy = J2945()
    rows, constants = policy.init(hosts, 1).rows, policy.parameters.constants()
    columns = [np.full(hosts, value) for value in (0.3, 0.6, 40.0, 0.1)]
    out = np.empty(hosts, dtype=np.int64), np.empty(hosts), np.empty(hosts), np.empty(hosts, dtype=np.bool_)
    uniforms = rng.random((hosts, 3))
    ticks = 0

    def step() -> None:
        nonlocal ticks
        ticks += 1
        t_s = np.full(hosts, 0.1 * ticks)
        flags = np.zeros(hosts, dtype=np.bool_)
        seen = j2945_kernels.Vehicles(t_s, t_s + 0.1, *columns, flags, uniforms)
        j2945_kernels.step_each(rows, seen, constants, *out)

    return best_of_three(step)


def main() -> None:
    """Print one row for each size of the fleet and order of messages."""
    print(
        "hosts  messages  hear [ns/message]  survey [ns/remote]  count [ns/remote]  step [ns/vehicle]  [MB]"
    )
    for hosts in (100, 1000, 5000):
        for by_host in (True, False):
            fleet = Fleet(hosts, by_host)
            for _ in range(60):
                fleet.hear()
            one = 1e9 / fleet.host.size
            size = sum(column.nbytes for column in fleet.tables) / 1e6
            order = "by host" if by_host else "by sender"
            heard, surveyed, counted = (
                one * best_of_three(run) for run in (fleet.hear, fleet.survey, fleet.count)
            )
            stepped = 1e9 * step_time(hosts) / hosts
            for what, cost, unit in (
                (f"hear, {order}", heard, "ns a message"),
                (f"survey, {order}", surveyed, "ns a remote"),
                (f"step, {order}", stepped, "ns a vehicle"),
            ):
                record(what, cost, unit, sizes={"hosts": hosts})
            print(
                f"{hosts:5d}  {order:9s}{heard:17.1f}{surveyed:20.1f}{counted:19.1f}"
                f"{stepped:19.0f}{size:6.0f}"
            )


if __name__ == "__main__":
    main()
