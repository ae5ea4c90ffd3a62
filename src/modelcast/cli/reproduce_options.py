"""The options of ``modelcast reproduce``, and the plan they mean."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from cyclopts import Parameter

from modelcast.cli.options import Numbers, SensorOptions

if TYPE_CHECKING:
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
        Packet error ratios of the sweep, 0 to 1, several after one another; 0.4 must be among them.
    seeds
        Runs drawn for every packet error ratio.
    seed
        Seed of all random numbers.
    resamples
        Bootstrap resamples behind every interval over the trips.
    sensor
        What the sender measures in the reading that puts a sensor before it.
    """

    threshold: Numbers = (0.2, 0.3, 0.4, 0.5)
    per: Numbers = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    seeds: int = 5
    seed: int = 0
    resamples: int = 1000
    sensor: SensorOptions = field(default_factory=SensorOptions)

    def as_plain(self) -> Mapping[str, Any]:
        """Every option by its name on the command line, as plain values."""
        found = asdict(self)
        sensor = found.pop("sensor")
        return {**found, **sensor}

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
                tuple(self.threshold),
                tuple(self.per),
                seeds=self.seeds,
                seed=self.seed,
                resamples=self.resamples,
                sensor=self.sensor.model(),
            )
        except ValueError as error:
            raise ConfigError(str(error)) from error
