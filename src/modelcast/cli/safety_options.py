"""The options of ``modelcast safety``, and the settings and candidates they mean."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from modelcast.cli.compare_options import CompareOptions
from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.cli.options import Count, Numbers, Paths, SensorOptions, Words
from modelcast.messages.rules import CertificateRule
from modelcast.models.shipped import names_profile, profile_path
from modelcast.station.policy.rules import BelieveRule
from modelcast.study.safety.rules import BASES, Basis, Truth

if TYPE_CHECKING:
    from modelcast.apps.base import AbstractApplication
    from modelcast.channel.recorded import RecordedLosses
    from modelcast.study.compare.candidate import FixedCandidate
    from modelcast.study.safety.settings import SafetySettings

__all__ = ["RATIOS", "SafetyOptions"]

RATIOS = (0.0, 0.2, 0.4, 0.6, 0.8, 0.9)
"""Packet error ratios where none are asked for."""

_Bases = Annotated[tuple[Basis, ...], Parameter(consume_multiple=True, negative="")]


@Parameter(name="*")
@dataclass(frozen=True)
class SafetyOptions:
    """Everything that changes the figures of a safety evaluation.

    Parameters
    ----------
    application
        What warns: fcw (forward collision warning), eebl (emergency electronic brake light), or one that
        another package adds for two vehicles; as NAME or NAME:KEY=VALUE,KEY=VALUE with settings of its own.
    algorithm
        Of fcw: camp-linear (where not given), camp-linear-miles, knipling, nhtsa, nhtsa-intermediate,
        nhtsa-early.
    bank
        Senders to compare, several after one another, each as in 'modelcast evaluate --bank'; cv is the
        baseline. Put the trips before this option.
    profile
        File of the profile in use, as in 'modelcast evaluate'.
    policy
        Who calls for the messages of all senders but cv: the error-driven policy where not given, or a policy
        of another package, as in 'modelcast evaluate'. One without a threshold goes with --basis threshold,
        or with a single bank beside cv.
    threshold
        Tracking-error threshold [m] of the sender whose budget counts, and of all at equal threshold.
    per
        Packet error ratios, 0 to 1, several after one another. Where neither they nor --losses are given, six
        from 0 to 0.9.
    burst
        Mean lengths of loss bursts [s], several after one another; 0 for losses one by one.
    losses
        Logs whose losses are replayed, several after one another: BsmP1 of Safety Pilot, events of New York,
        captures (pcap, pcapng). Without --per they are the only losses.
    sensors
        What vehicles see of themselves, by name, several after one another: default (1 cm), ins, gnss and
        the others of 'modelcast evaluate --sensor'.
    basis
        At equal what the senders are held against each other: threshold, messages or airtime.
    budget
        Bank whose messages and airtime the others may spend, on every trip; the last where not given.
    against
        Bank whose missed and false warnings are the measure; the first where not given.
    truth
        What is held to be right: what a host would do that knew how both vehicles truly move (knowledge), or
        that heard every sample of the sender at once, as its sensors show it (communication).
    near
        Warnings count where the true margin is smaller than this [m].
    later
        Hosts warn where their margin is below zero by this much [m]: fewer false warnings, more missed ones.
    seeds
        Runs drawn for every packet error ratio.
    seed
        Seed of all random numbers.
    keep_alive
        Longest silence [s]; 0 for none.
    believe
        As in 'modelcast evaluate'.
    delay
        Delivery delay [s].
    expiry
        Silence after which the host drops a remote [s]; 0 for never.
    certificates
        Which messages carry the certificate, as in 'modelcast evaluate'.
    resamples
        Bootstrap resamples behind every interval.
    """

    application: str = "fcw"
    algorithm: str | None = None
    bank: Words = ("cv", "free", "default")
    profile: str | None = None
    policy: str | None = None
    threshold: float = 0.5
    per: Numbers | None = None
    burst: Numbers = (0.0, 0.5)
    losses: Paths = ()
    sensors: Words = ("default", "ins", "gnss")
    basis: _Bases = BASES
    budget: str | None = None
    against: str | None = None
    truth: Truth = "knowledge"
    near: float = 20.0
    later: float = 0.0
    seeds: Count = 3
    seed: Count = 0
    keep_alive: float = 2.0
    believe: BelieveRule | None = None
    delay: float = 0.0
    expiry: float = 0.0
    certificates: CertificateRule = "gap"
    resamples: Count = 2000

    def as_plain(self) -> Mapping[str, Any]:
        """Every option by its name on the command line, as plain values; packet error ratios filled in."""
        return {**asdict(self), "per": self.ratios, "losses": [str(path) for path in self.losses]}

    @property
    def ratios(self) -> tuple[float, ...]:
        """Packet error ratios at which losses are drawn; none where logs alone are replayed."""
        if self.per is None:
            return () if self.losses else RATIOS
        return self.per

    @property
    def files(self) -> tuple[Path, ...]:
        """The profiles' files, the one in use and those among the banks: what all cases depend on."""
        named = [text for text in self.bank if names_profile(text)]
        return tuple(profile_path(text) for text in (self.profile, *named) if text)

    @property
    def foreign(self) -> dict[str, str]:
        """Package and version of application, policy and sub-models that other packages bring."""
        from modelcast.apps.registry import APPLICATIONS
        from modelcast.cli.named_words import origins_in_use

        banks = (candidate.bank for candidate in self.candidates())
        return {**APPLICATIONS.origins([self.application]), **origins_in_use(self.policy, banks)}

    def candidates(self) -> "list[FixedCandidate]":
        """Who sends.

        Raises
        ------
        ConfigError
            Where a bank is unknown, or one is to be trained.
        """
        from modelcast.core.exceptions import ConfigError
        from modelcast.study.compare.candidate import FixedCandidate

        if not self.bank:
            raise ConfigError("--bank: name at least one, as default")
        found: list[FixedCandidate] = []
        for candidate in CompareOptions(bank=self.bank, profile=self.profile).candidates():
            if not isinstance(candidate, FixedCandidate):
                raise ConfigError(
                    f"--bank {candidate.name}: train a profile with 'modelcast train' and name its file"
                )
            found.append(candidate)
        names = [one.name for one in found]
        for option, name in (("budget", self.budget), ("against", self.against)):
            if name is not None and name not in names:
                raise ConfigError(f"--{option} {name}: no bank has that name; there are {', '.join(names)}")
        return found

    def warns(self) -> "AbstractApplication":
        """What warns; who follows whom is known, so the leader is in path whatever the path looks like.

        Raises
        ------
        ConfigError
            Where the application or its algorithm is unknown, or does not go with a vehicle ahead.
        """
        from modelcast.apps.brake_light import BrakeLight
        from modelcast.apps.forward_collision import ForwardCollisionWarning
        from modelcast.apps.intersection import IntersectionAssist
        from modelcast.apps.registry import get_application
        from modelcast.apps.warning_ranges import get_warning_range
        from modelcast.core.exceptions import ConfigError

        found = get_application(self.application)
        if self.algorithm is not None and not isinstance(found, ForwardCollisionWarning):
            raise ConfigError(f"--algorithm goes with --application fcw, got {self.application}")
        if isinstance(found, ForwardCollisionWarning):
            given = found.algorithm if self.algorithm is None else get_warning_range(self.algorithm)
            return replace(found, algorithm=given, lane_half_width_m=inf)
        if isinstance(found, BrakeLight):
            return replace(found, lane_half_width_m=inf)
        if found.of_people or isinstance(found, IntersectionAssist):
            raise ConfigError(
                f"--application {self.application}: recorded pairs drive behind each other: take fcw or eebl"
            )
        return found

    def settings(
        self, sensor: str, burst_s: float, recorded: "RecordedLosses | None" = None
    ) -> "SafetySettings":
        """The settings for one sensor and one kind of loss.

        Parameters
        ----------
        sensor
            Name of the sensor.
        burst_s
            Mean length of bursts [s]; 0 for losses one by one.
        recorded
            Losses to replay instead of drawing them.

        Raises
        ------
        ConfigError
            Where a value is out of its range.
        """
        from modelcast.core.exceptions import ConfigError
        from modelcast.study.safety.settings import SafetySettings

        shared = EvaluateOptions(
            threshold=(self.threshold,),
            per=self.ratios,
            seeds=self.seeds,
            seed=self.seed,
            keep_alive=self.keep_alive,
            believe=self.believe,
            burst=burst_s,
            delay=self.delay,
            expiry=self.expiry,
            protocol="sensor",
            certificates=self.certificates,
            references=False,
            sensor=SensorOptions(sensor=sensor),
            policy=self.policy,
        )
        try:
            evaluation = shared.settings()
            if recorded is not None:
                ratios = (recorded.packet_error_ratio,)
                evaluation = replace(
                    evaluation, recorded=recorded, packet_error_ratios=ratios, mean_burst_s=None
                )
            return SafetySettings(
                evaluation,
                self.warns(),
                bases=self.basis,
                budget=self.budget,
                against=self.against,
                truth=self.truth,
                near_m=self.near,
                later_m=self.later,
                resamples=self.resamples,
            )
        except ValueError as error:
            raise ConfigError(str(error)) from error
