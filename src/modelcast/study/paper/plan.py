"""What a reproduction of the paper is asked to do: thresholds, losses, seeds; the same for every reading."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, asdict, dataclass, field
from typing import Any

from modelcast.study.paper.choices import Reading
from modelcast.study.settings import EvaluationSettings
from modelcast.world.sensors import SensorModel

__all__ = ["PaperPlan"]


@dataclass(frozen=True, slots=True)
class PaperPlan:
    """What a reproduction is asked to do.

    Parameters
    ----------
    thresholds_m
        Tracking-error thresholds; the paper's are 20, 30, 40 and 50 cm [m].
    packet_error_ratios
        Of the sweep under the plain reading, 0..1.
    headline_ratio
        The packet error ratio that all readings are compared at, and the distribution is drawn at; the
        paper's is 0.4. It is one of the sweep's.
    seeds, seed
        Runs drawn for every ratio, and the seed they come from.
    resamples
        Bootstrap resamples behind every interval over the trips.
    sensor
        What the sender measures where a sensor stands between it and the truth.

    Raises
    ------
    ValueError
        Where a value is out of its range, or the headline's ratio is not of the sweep.
    """

    thresholds_m: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5)
    packet_error_ratios: tuple[float, ...] = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    _: KW_ONLY
    headline_ratio: float = 0.4
    seeds: int = 5
    seed: int = 0
    resamples: int = 1000
    sensor: SensorModel = field(default_factory=SensorModel)

    def __post_init__(self) -> None:
        self.settings(Reading())
        if self.headline_ratio not in self.packet_error_ratios:
            raise ValueError(
                f"the packet error ratios (--per) must hold {self.headline_ratio:g}, to compare readings at, "
                f"got {', '.join(f'{ratio:g}' for ratio in self.packet_error_ratios)}"
            )
        if self.resamples < 1:
            raise ValueError(f"resamples must be >= 1, got {self.resamples}")

    def settings(
        self, reading: Reading, packet_error_ratios: tuple[float, ...] | None = None
    ) -> EvaluationSettings:
        """The evaluation that a reading means.

        Parameters
        ----------
        reading
            One option of every choice.
        packet_error_ratios
            Other ratios than the plan's.
        """
        ratios = self.packet_error_ratios if packet_error_ratios is None else packet_error_ratios
        return EvaluationSettings(
            self.thresholds_m,
            ratios,
            seeds=self.seeds,
            seed=self.seed,
            bank=reading.bank,
            start=reading.start,
            identify=reading.identify,
            keep_alive_s=reading.keep_alive_s,
            protocol=reading.protocol,
            sensor=self.sensor,
            keep_samples="none",
            velocity=reading.velocity,
            quantised=reading.quantised,
            trained_on=frozenset(),
            references=False,
        )

    def as_plain(self) -> Mapping[str, Any]:
        """The plan as plain values, for summaries."""
        return asdict(self)
