"""The options of ``modelcast reproduce``, and the plan they mean."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cyclopts import Parameter

from modelcast.cli.options import Count, Numbers, SensorOptions

if TYPE_CHECKING:
    from modelcast.study.network.densities import TrafficPlan
    from modelcast.study.paper.plan import PaperPlan

__all__ = ["ReproduceOptions"]


@Parameter(name="*")
@dataclass(frozen=True)
class ReproduceOptions:
    """Everything that changes the figures of a reproduction.

    Parameters
    ----------
    threshold
        Tracking-error thresholds [m], several after one another; put the trips before this option.
    per
        Packet error ratios of the sweep, 0 to 1, several after one another; 0.4 must be among them, since
        readings are compared at it.
    seeds
        Runs drawn for every packet error ratio.
    seed
        Seed of all random numbers on trips; traffic has 0.
    resamples
        Bootstrap resamples behind every interval over the trips.
    sensor
        What the sender measures in the reading that puts a sensor before it; no other reading changes.
    pick
        Take one trip alone: the one with the most manoeuvres, as modelcast trips --rank ranks them.
    traffic
        Run the hybrid and the baseline in dense simulated traffic too, over 802.11p and mode 4: hours, said
        before it begins. Runs that are done are kept, so it may be interrupted and called again.
    traffic_out
        Folder of these runs; the output folder's name with -traffic behind it where not given.
    traffic_seeds
        Runs of each combination.
    traffic_density
        Vehicles a kilometre of road, several after one another.
    """

    threshold: Numbers = (0.2, 0.3, 0.4, 0.5)
    per: Numbers = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    seeds: Count = 5
    seed: Count = 0
    resamples: Count = 1000
    sensor: SensorOptions = field(default_factory=SensorOptions)
    pick: bool = False
    traffic: bool = False
    traffic_out: Path | None = None
    traffic_seeds: Count = 10
    traffic_density: Numbers = (25.0, 50.0, 100.0, 200.0, 400.0, 800.0, 1200.0)

    def as_plain(self) -> Mapping[str, Any]:
        """Every option by its name on the command line, as plain values."""
        found = asdict(self)
        sensor = found.pop("sensor")
        return {**found, **sensor, "traffic_out": None if self.traffic_out is None else self.traffic_out.name}

    def traffic_plan(self) -> "TrafficPlan":
        """What is run in traffic.

        Raises
        ------
        ConfigError
            Where there is no density or no seed.
        """
        from modelcast.core.exceptions import ConfigError
        from modelcast.study.network.densities import TrafficPlan

        if not self.traffic_density or not min(self.traffic_density) > 0:
            raise ConfigError(f"--traffic-density: name one or more above 0, got {self.traffic_density}")
        if self.traffic_seeds < 1:
            raise ConfigError(f"--traffic-seeds must be at least 1, got {self.traffic_seeds}")
        return TrafficPlan(
            thresholds_m=tuple(sorted(self.threshold)),
            densities_per_km=tuple(self.traffic_density),
            seeds=self.traffic_seeds,
        )

    def plan(self) -> "PaperPlan":
        """The plan they mean.

        Raises
        ------
        ConfigError
            Where a value is out of its range.
        """
        from modelcast.core.exceptions import ConfigError
        from modelcast.study.paper.plan import PaperPlan

        try:
            return PaperPlan(
                tuple(sorted(self.threshold)),
                tuple(sorted(self.per)),
                seeds=self.seeds,
                seed=self.seed,
                resamples=self.resamples,
                sensor=self.sensor.model(),
            )
        except ValueError as error:
            raise ConfigError(str(error)) from error
