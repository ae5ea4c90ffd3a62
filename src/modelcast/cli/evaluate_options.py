"""The options of ``modelcast evaluate``, and the settings they mean."""

import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from cyclopts import Parameter

from modelcast.cli.context_options import context_settings, road_files
from modelcast.cli.options import Count, Numbers, SensorOptions
from modelcast.core.exceptions import ModelcastWarning
from modelcast.messages.rules import CertificateRule
from modelcast.models.shipped import names_profile, profile_path
from modelcast.station.policy.rules import BelieveRule, CostUnit, IdentifyRule, StartRule
from modelcast.station.sensing.rules import VelocityRule

if TYPE_CHECKING:
    from modelcast.study.settings import EvaluationSettings

__all__ = ["EvaluateOptions"]


_MANY_METRES = 10.0
"""A threshold that large is usual in centimetres."""


@Parameter(name="*")
@dataclass(frozen=True)
class EvaluateOptions:
    """Everything that changes the figures of an evaluation.

    Parameters
    ----------
    threshold
        Tracking-error thresholds [m], several after one another; put the trips before this option.
    rates_only
        Count the messages alone, on a channel that loses none; what is about losses plays no part then.
    per
        Packet error ratios, 0 to 1, several after one another.
    seeds
        Runs drawn for every packet error ratio.
    seed
        Seed of all random numbers.
    bank
        Sub-models of model-based communication, first in use first: 'default' (the bank of the profile in
        use), 'people', a profile's file, 'paper', 'free' (the best receiver of plain messages: the profile's
        free, else ctra), 'regimes' (a Gaussian process for each driving regime), or names joined by '+' among
        cv, ca, ctrv, ctra, imm, gp-anchored, gp-intercept, gp-adaptive, gp-linear, gp-trained, gp-vehicle,
        gp-derivative, learned, gp-regime-1, gp-regime-2, gp-regime-3, and what other packages register, as
        NAME or NAME:KEY=VALUE,KEY=VALUE.
    profile
        File of the profile in use, from which sub-models get what was trained, or 'people' for the profile of
        people that ships with modelcast; that of vehicles where not given.
    window
        Samples a Gaussian process is fitted to.
    noise_floor
        Smallest position noise a Gaussian process may assume [m]; 0.00001 for gp-anchored (the paper has no
        floor) and 0.001 for gp-intercept where not given.
    trusted_horizon
        Age beyond which a sub-model's speed is held and its turn ends, at sender and host alike [s]; 0 for
        never.
    start
        Sub-model in use after an update: first in order, the one kept, the longest survivor, the one whose
        predictions of the last two seconds did best (hindsight), the same with constant velocity while the
        bank has fallen behind it (guarded), the one a trained selector expects to last (predicted), or the
        one that erred least from each message to the next (recent); the profile's rule or order where not
        given.
    identify
        When another sub-model is named: on failure of the one in use, the same but failures are final, at
        every change of the best, never (all are fitted anew when the one in use fails), or where it is
        cheaper than an update by trained costs (cheapest); the profile's rule or on-failure where not given.
    cost
        What the rule cheapest counts: messages, bytes or airtime.
    policy
        Who calls for the messages of the model-based sender: the error-driven policy where not given, or a
        policy of another package, as NAME or NAME:KEY=VALUE,KEY=VALUE. Start, identify, keep-alive and
        believe are then its own affair.
    keep_alive
        Longest silence in loss runs, for every error-driven policy [s]; 0 for none.
    believe
        What model-based senders take their remotes to hold in loss runs: whatever they sent, or each of their
        last messages with its probability at the run's packet error ratio (expected), so that they send more
        where losses cost more; needs --identify never, or a bank of one. Where not given, expected for the
        rules of a profile's bank (start guarded, hindsight or predicted, identify never), sent for others.
    budget
        Messages that a sender with --believe expected aims at, over those of a channel without losses; with
        40 % lost it sends 1.2 to 1.7 times as many.
    legacy_threshold
        Error at which legacy receivers, which coast place, speed and heading of a message at constant
        velocity, get an update [m]; 0 for not minding them.
    burst
        Mean length of loss bursts [s] (Gilbert-Elliott); 0 for independent losses.
    delay
        Delivery delay [s].
    expiry
        Silence after which the host drops a remote [s]; 0 for never.
    protocol
        'recorded': the log is both input and truth. 'sensor': the truth is smoothed and the input simulated
        from it. 'auto': sensor where the log lies on a coarse grid or holds values, or --sensor names one.
    sensor
        What the sender measures in the sensor protocol.
    samples
        Tracking-error samples written to samples.parquet: of the first seed, all seeds, or none.
    velocity
        Where constant velocity and the baseline take their velocity from: the log's speed and heading
        (reported), its last two positions (slope-2), a quadratic through the last four (quadratic-4), or
        auto: reported where the log has it and it can be trusted, else quadratic-4.
    references
        Count the references too: the fewest messages of a sender that knows the future, and the rules of
        cooperative awareness messages.
    map
        Manoeuvre to draw, as TRIP@SECONDS; the sharpest where not given.
    detail
        Which of the thresholds the figures of sub-models, manoeuvre and single trips show [m]; the first one
        where not given.
    quantised
        Predict with what a message can say, at sender and host alike.
    road
        What a bank that reads context remembers of the road: its 'own' earlier drive and trips that ended
        before on the same clock, these and a road file of other trips ('modelcast road build'), or 'none'.
    leader
        Whether such a bank knows of the vehicle ahead, from the messages of the other trips on its clock.
    certificates
        Which messages carry the certificate, for the airtime: those that follow a gap of 450 ms, one every
        450 ms, all, none (all carry its digest), or no message is signed.
    """

    threshold: Numbers = (0.2, 0.3, 0.4, 0.5)
    per: Numbers = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    seeds: Count = 5
    seed: Count = 0
    bank: str = "default"
    profile: str | None = None
    window: int = 10
    noise_floor: float | None = None
    trusted_horizon: float = 0.0
    start: StartRule | None = None
    identify: IdentifyRule | None = None
    cost: CostUnit = "bytes"
    policy: str | None = None
    keep_alive: float = 2.0
    believe: BelieveRule | None = None
    budget: float = 4.0 / 3.0
    legacy_threshold: float = 0.0
    burst: float = 0.0
    delay: float = 0.0
    expiry: float = 0.0
    protocol: Literal["auto", "recorded", "sensor"] = "auto"
    sensor: SensorOptions = field(default_factory=SensorOptions)
    samples: Literal["first", "all", "none"] = "first"
    velocity: VelocityRule = "auto"
    references: bool = True
    map: str | None = None
    detail: float | None = None
    quantised: bool = True
    road: str = "own"
    leader: bool = True
    certificates: CertificateRule = "gap"
    rates_only: bool = False

    def as_plain(self) -> dict[str, Any]:
        """Every option by its name on the command line, as plain values."""
        found = asdict(self)
        sensor = found.pop("sensor")
        return {**found, **sensor}

    def _warn_of_centimetres(self) -> None:
        """Say what a threshold means that is large in metres and usual in centimetres."""
        for value in self.threshold:
            if value >= _MANY_METRES:
                warnings.warn(
                    f"--threshold {value:g} is in metres: {value:g} cm is {value / 100.0:g}",
                    ModelcastWarning,
                    stacklevel=2,
                )

    @property
    def files(self) -> tuple[Path, ...]:
        """The profiles' files, the one in use and the bank where it is one, and the road file."""
        named = [self.bank] if names_profile(self.bank) else []
        return (*(profile_path(text) for text in (self.profile, *named) if text), *road_files(self.road))

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "EvaluateOptions":
        """The options that `as_plain` wrote down.

        Parameters
        ----------
        plain
            Values by name; options that are not named take their defaults.

        Raises
        ------
        ValueError
            Where a name is none of an option.
        """
        sensor = {item.name for item in fields(SensorOptions)}
        own = {item.name for item in fields(cls)} - {"sensor"}
        unknown = set(plain) - sensor - own
        if unknown:
            raise ValueError(f"unknown options {', '.join(sorted(unknown))}")
        return cls(
            **{name: value for name, value in plain.items() if name in own},
            sensor=SensorOptions(**{name: value for name, value in plain.items() if name in sensor}),
        )

    def settings(self) -> "EvaluationSettings":
        """The settings they mean.

        Raises
        ------
        ConfigError
            Where a value is out of its range.
        """
        from modelcast.cli.banks import bank_in_use, profile_in_use
        from modelcast.cli.named_words import policy_that_decides
        from modelcast.cli.option_rules import OPTIONS
        from modelcast.core.exceptions import ConfigError
        from modelcast.core.rules import check
        from modelcast.messages.airtime import Stack
        from modelcast.station.banks import free_receiver
        from modelcast.study.settings import EvaluationSettings

        profile = profile_in_use(self.profile)
        named = bank_in_use(
            self.bank,
            noise_floor_m=self.noise_floor,
            window=self.window,
            trusted_horizon_s=self.trusted_horizon or None,
            profile=profile,
        )
        free = free_receiver(named.profile or profile)
        start, identify = self.start or named.start, self.identify or named.identify
        try:
            found = EvaluationSettings(
                tuple(self.threshold),
                () if self.rates_only else tuple(self.per),
                seeds=self.seeds,
                seed=self.seed,
                bank=named.bank,
                trained_on=named.trained_on,
                start=start,
                identify=identify,
                selector=named.selector if start == "predicted" else None,
                costs=named.costs(self.cost) if identify == "cheapest" else None,
                keep_alive_s=self.keep_alive or None,
                believe=self.believe,
                budget=self.budget,
                legacy_threshold_m=self.legacy_threshold or inf,
                mean_burst_s=self.burst or None,
                delay_s=self.delay,
                expiry_s=self.expiry or None,
                protocol=self.sensor.protocols((self.protocol,))[0],
                sensor=self.sensor.model(),
                keep_samples=self.samples,
                references=self.references,
                map_at=_map_at(self.map),
                detail_threshold_m=self.detail,
                velocity=self.velocity,
                quantised=self.quantised,
                stack=Stack(self.certificates),
                context=context_settings(self.road, leader=self.leader),
                free=free.bank,
                free_trained_on=free.trained_on,
                decides=None if self.policy is None else policy_that_decides(self.policy),
                decided_by=self.policy or "",
            )
            check(self.as_plain(), OPTIONS, "option")
            self._warn_of_centimetres()
        except ValueError as error:
            raise ConfigError(str(error)) from error
        return found


def _map_at(text: str | None) -> tuple[str, float] | None:
    from modelcast.core.exceptions import ConfigError

    if text is None:
        return None
    trip, at, seconds = text.rpartition("@")
    try:
        start_s = float(seconds)
    except ValueError:
        start_s = float("nan")
    if not at or start_s != start_s:  # noqa: PLR0124 - NaN
        raise ConfigError(f"--map: '{text}' is not TRIP@SECONDS")
    return trip, start_s
