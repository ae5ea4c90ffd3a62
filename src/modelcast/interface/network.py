"""`simulate_network`: fleets on a shared channel, with a result of frames and figures."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import polars as pl

from modelcast.channel.radio import AbstractRadio
from modelcast.channel.radio_words import get_radio
from modelcast.core.argument_types import require_several, require_type
from modelcast.core.version import package_version
from modelcast.interface.result import AbstractFrames
from modelcast.io.network import write_network
from modelcast.io.network_runs import RunKey
from modelcast.report.figures.network import (
    plot_delivery,
    plot_distance,
    plot_load,
    plot_settling,
    plot_tracking,
)
from modelcast.report.network import write_network_report
from modelcast.report.tables import frame
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.study.network.rows import CaseResult, NetworkResult
from modelcast.study.network.simulate import FleetJob, FleetRuns, simulate_fleets
from modelcast.world.scenario.base import AbstractScenario
from modelcast.world.sensors import filter_for

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["NetworkPlots", "NetworkSimulation", "simulate_network"]

_HEADLINE = ("message_rate_hz", "bytes_per_s", "busy_ratio", "held_ratio", "pte_p90_m")


@dataclass(frozen=True, slots=True)
class NetworkPlots:
    """The figures of fleets on a shared channel, each as a Matplotlib figure.

    Parameters
    ----------
    result
        Their rows.
    """

    result: NetworkResult

    def load(self) -> "Figure":
        """Messages, bytes and busy ratio against density."""
        return plot_load(self.result)

    def delivery(self) -> "Figure":
        """What became of frames, against density."""
        return plot_delivery(self.result)

    def tracking(self) -> "Figure":
        """Tracking error against density."""
        return plot_tracking(self.result)

    def distance(self) -> "Figure":
        """Tracking error against distance."""
        return plot_distance(self.result)

    def settling(self) -> "Figure":
        """How the loop settles at the highest density."""
        return plot_settling(self.result)


@dataclass(frozen=True, slots=True, repr=False)
class NetworkSimulation(AbstractFrames):
    """Fleets on a shared channel as data frames, figures and files.

    Parameters
    ----------
    result
        Their rows.
    settings
        What was asked for, as plain values.
    """

    result: NetworkResult
    settings: Mapping[str, Any]

    @property
    def runs(self) -> pl.DataFrame:
        """A row a run (`RUNS`)."""
        return frame(self.result.runs)

    @property
    def pooled(self) -> pl.DataFrame:
        """A row a figure, with its mean and 95 % interval over seeds (`POOLED`)."""
        return frame(self.result.pooled)

    @property
    def distances(self) -> pl.DataFrame:
        """A row for each run and bin of distance: what hosts hold of remotes (`DISTANCES`)."""
        return frame(self.result.distances)

    @property
    def outcomes(self) -> pl.DataFrame:
        """A row for each run and bin of distance: what became of frames (`OUTCOMES`)."""
        return frame(self.result.outcomes)

    @property
    def seconds(self) -> pl.DataFrame:
        """A row for each run and second, warm-up included (`SECONDS`)."""
        return frame(self.result.seconds)

    @property
    def senders(self) -> pl.DataFrame:
        """A row for each sender of models: its sub-models and rules (`SENDERS`)."""
        return frame(self.result.senders)

    @property
    def plot(self) -> NetworkPlots:
        """The figures."""
        return NetworkPlots(self.result)

    @property
    def scope(self) -> str:
        """What was run, in one line."""
        runs, policies = self.result.runs, dict.fromkeys(row.policy for row in self.result.runs)
        noun = "run" if len(runs) == 1 else "runs"
        return f"{len(runs)} {noun} of {self.settings['duration_s']:g} s: {', '.join(policies)}"

    @property
    def headline(self) -> pl.DataFrame:
        """Load and tracking, mean over seeds, a row for each density, radio and sender."""
        keys = ["density_per_km", "radio", "policy", "bank", "threshold_m", "seeds"]
        shown = self.pooled.filter(pl.col("figure").is_in(_HEADLINE))
        return shown.pivot(on="figure", index=keys, values="value").select(*keys, *_HEADLINE)

    def _write(self, folder: Path) -> list[Path]:
        return write_network(self.result, self.settings, folder, key=RunKey(package_version(), {}))

    def _report(self, folder: Path) -> list[Path]:
        return write_network_report(self.result, self.settings, folder)


def simulate_network(
    scenarios: AbstractScenario[Any] | Sequence[AbstractScenario[Any]],
    senders: str | Sender | Iterable[str | Sender] = ("j2945", "j2945-mbc"),
    radios: str | AbstractRadio[Any] | Iterable[str] | Mapping[str, AbstractRadio[Any]] = "dsrc",
    runs: FleetRuns | None = None,
    *,
    each: Callable[[Callable[[FleetJob], CaseResult], Iterable[FleetJob]], Iterable[CaseResult]] = map,
    progress: Callable[[int, int], None] | None = None,
) -> NetworkSimulation:
    """Run fleets on a shared channel: traffic moves, senders decide, messages contend, receivers track.

    Parameters
    ----------
    scenarios
        Traffic, one or several of different densities.
    senders
        Names as for `named_sender`, or senders, one or several.
    radios
        The channel: one or several names as for the command line (``dsrc``, ``sidelink``, ``ideal``,
        ``NAME:KEY=VALUE``), a radio, which is called after its class, or several by name.
    runs
        How often, how long, and what is counted; None for one run of 30 s.
    each
        Applies a function to jobs and returns what it gave, in order: `map`, or one that shares the jobs out
        among processes, as `concurrent.futures.ProcessPoolExecutor.map`; the result is the same.
    progress
        Called with runs done and runs to do.

    Raises
    ------
    ConfigError
        Where there is nothing to run, or rows of two runs could not be told apart.
    TypeError
        Where a scenario, a sender or a radio is none.
    ValueError
        Where a name is unknown, or vehicles do not fit on the road.

    Examples
    --------
    >>> from modelcast.runtime.fleet.settings import NetworkSettings
    >>> from modelcast.world.scenario.highway import Highway
    >>> road = Highway(500.0, 20.0, warm_up_s=0.0)
    >>> asked = FleetRuns(2.0, settings=NetworkSettings(warm_up_s=1.0))
    >>> found = simulate_network(road, "bsm-10hz", runs=asked)
    >>> found
    NetworkSimulation(1 run of 2 s: bsm-10hz)
    >>> found.headline["message_rate_hz"].round(6).to_list()
    [10.0]
    """
    asked = FleetRuns() if runs is None else runs
    require_type("runs", asked, FleetRuns, remedy="give modelcast.FleetRuns(30.0) for 30 s")
    traffic: list[AbstractScenario[Any]] = require_several(
        "scenarios", scenarios, AbstractScenario, remedy="give modelcast.Highway(1000.0, 25.0) or its like"
    )
    if isinstance(senders, str) or not isinstance(senders, Iterable):
        senders = (senders,)
    made = require_several(
        "senders",
        [
            named_sender(one, motion=filter_for(asked.sensor)) if isinstance(one, str) else one
            for one in senders
        ],
        Sender,
        remedy="give names, or what modelcast.named_sender makes",
    )
    channels = _channels(radios)
    result = simulate_fleets(traffic, made, channels, asked, each=each, progress=progress)
    settings: dict[str, Any] = {
        "scenarios": [type(one).__name__ for one in traffic],
        "radios": list(channels),
        "senders": [one.name for one in made],
        **asdict(asked),
    }
    del settings["threads"]  # the result is the same whatever their number
    return NetworkSimulation(result, settings)


def _channels(
    radios: str | AbstractRadio[Any] | Iterable[str] | Mapping[str, AbstractRadio[Any]],
) -> Mapping[str, AbstractRadio[Any]]:
    """The radios by name."""
    if isinstance(radios, Mapping):
        return cast("Mapping[str, AbstractRadio[Any]]", radios)
    if isinstance(radios, AbstractRadio):
        return {type(radios).__name__.lower(): radios}
    names = require_several(
        "radios", radios, str, remedy="give names, a radio, or a mapping of names to radios"
    )
    return {name: get_radio(name) for name in names}
