"""The options of ``modelcast compare``, and the settings and candidates they mean."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from cyclopts import Parameter

from modelcast.cli.context_options import road_files
from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.cli.options import Count, Numbers, SensorOptions, Words
from modelcast.messages.rules import CertificateRule
from modelcast.models.shipped import names_profile, profile_path
from modelcast.station.policy.rules import BelieveRule, CostUnit, IdentifyRule, StartRule
from modelcast.station.sensing.rules import VelocityRule
from modelcast.study.rules import RateBasis

if TYPE_CHECKING:
    from modelcast.models.profile import Profile
    from modelcast.station.banks import NamedBank
    from modelcast.study.compare.candidate import AbstractCandidate, TrainedCandidate
    from modelcast.study.compare.settings import CompareSettings
    from modelcast.study.settings import EvaluationSettings
    from modelcast.trips.trajectory import Trajectory

__all__ = ["CompareOptions"]

_Protocols = Annotated[
    tuple[Literal["auto", "recorded", "sensor"], ...], Parameter(consume_multiple=True, negative="")
]


@Parameter(name="*")
@dataclass(frozen=True)
class CompareOptions:
    """Everything that changes the figures of a comparison.

    Parameters
    ----------
    bank
        Banks to compare, several after one another, each as in 'modelcast evaluate --bank', or 'trained': a
        profile trained anew without the route that is judged, of which 'trained:regimes' takes the bank
        regimes, 'trained:gp-vehicle' that sub-model, and so on. Every single sub-model, 'regimes', 'paper'
        and 'default' where not given. Put the trips before this option.
    profile
        File of the profile in use, as in 'modelcast evaluate'.
    rules
        Rules of the policy, several after one another, each as START/IDENTIFY; each bank's own where not
        given. They make no difference to a bank of one sub-model, which is run once.
    threshold
        Tracking-error thresholds [m], several after one another.
    per
        Packet error ratios, 0 to 1, several after one another.
    protocol
        'recorded', 'sensor', 'auto', or several after one another, as in 'modelcast evaluate'.
    against
        Candidate that all are held against beside the baseline; the free receiver where not given, or the
        first where that is left out.
    free
        Run the free receiver beside all banks: plain messages whose receiver coasts their acceleration and
        turn as well, at the same threshold and at the rate of each.
    route_by
        How trips are told apart into routes: 'auto' by the ground they drove over and the platoon they drove
        in, or one route a 'file' or a 'trip'.
    resample_by
        What the bootstrap resamples: single trips, or whole routes.
    resamples
        Bootstrap resamples.
    seeds
        Runs drawn for every packet error ratio.
    seed
        Seed of all random numbers.
    window
        Samples a Gaussian process is fitted to.
    noise_floor
        Smallest position noise a Gaussian process may assume [m]; as in 'modelcast evaluate' where not given.
    trusted_horizon
        Ages beyond which a sub-model is damped, as in 'modelcast evaluate', several after one another [s]; 0
        for never. Every bank is run with each.
    cost
        What the rule cheapest counts: messages, bytes or airtime.
    policy
        Who calls for the messages of all banks, as in 'modelcast evaluate'.
    rate_basis
        What the baselines of the loss runs send as often as: all messages of the candidate (total), or its
        model updates alone (update, the paper's).
    velocity
        As in 'modelcast evaluate'.
    keep_alive
        Longest silence in loss runs, for every error-driven policy [s]; 0 for none.
    believe, budget, legacy_threshold
        As in 'modelcast evaluate'.
    references
        Count the references too: the fewest messages of a sender that knows the future, and the rules of
        cooperative awareness messages.
    quantised
        Predict with what a message can say, at sender and host alike.
    rates_only
        Messages alone, without tracking under loss: --per and --seeds play no part. Of a corpus, with
        --route-by trip and banks that neither learn nor read context, the trips are shared out.
    road
        What banks that read context remember of the road, as in 'modelcast evaluate'.
    leader
        Whether they know of the vehicle ahead, as in 'modelcast evaluate'.
    certificates
        Which messages carry the certificate, as in 'modelcast evaluate'.
    sensor
        What the sender measures in the sensor protocol.
    """

    bank: Words = ()
    profile: str | None = None
    rules: Words = ()
    threshold: Numbers = (0.2, 0.3, 0.4, 0.5)
    per: Numbers = (0.0, 0.2, 0.4, 0.6)
    protocol: _Protocols = ("recorded", "sensor")
    against: str | None = None
    free: bool = True
    route_by: Literal["auto", "file", "trip"] = "auto"
    resample_by: Literal["trip", "route"] = "trip"
    resamples: Count = 2000
    seeds: Count = 3
    seed: Count = 0
    window: int = 10
    noise_floor: float | None = None
    trusted_horizon: Numbers = (0.0,)
    cost: CostUnit = "bytes"
    policy: str | None = None
    rate_basis: RateBasis = "total"
    velocity: VelocityRule = "auto"
    keep_alive: float = 2.0
    believe: BelieveRule | None = None
    budget: float = 4.0 / 3.0
    legacy_threshold: float = 0.0
    references: bool = True
    quantised: bool = True
    rates_only: Annotated[bool, Parameter(negative="")] = False
    road: str = "own"
    leader: bool = True
    certificates: CertificateRule = "gap"
    sensor: SensorOptions = field(default_factory=SensorOptions)

    def as_plain(self) -> Mapping[str, Any]:
        """Every option by its name on the command line, as plain values."""
        found = asdict(self)
        sensor = found.pop("sensor")
        return {**found, **sensor}

    @property
    def files(self) -> tuple[Path, ...]:
        """The profiles' files, the one in use and those among the banks, and the road file."""
        named = [text for text in self.bank if names_profile(text)]
        return (*(profile_path(text) for text in (self.profile, *named) if text), *road_files(self.road))

    @property
    def foreign(self) -> dict[str, str]:
        """Package and version of the policy and of the sub-models that other packages bring."""
        from modelcast.cli.banks import profile_in_use
        from modelcast.cli.named_words import origins_in_use
        from modelcast.models.sub_models import SUB_MODELS
        from modelcast.station.banks import parts_of
        from modelcast.study.compare.candidate import FixedCandidate

        fixed = (one.bank for one in self.candidates() if isinstance(one, FixedCandidate))
        trained = [text for text in self.bank or () if text.partition(":")[0] == "trained"]
        banks = (*fixed, *((profile_in_use(self.profile).bank,) if "trained" in trained else ()))
        named = (part for text in trained for part in parts_of(text.partition(":")[2]))
        return {
            **origins_in_use(self.policy, banks),
            **SUB_MODELS.origins(part for part in named if part in SUB_MODELS.foreign_names()),
        }

    def settings(self) -> "CompareSettings":
        """The settings they mean.

        Raises
        ------
        ConfigError
            Where a value is out of its range.
        """
        from modelcast.core.exceptions import ConfigError
        from modelcast.study.compare.settings import CompareSettings

        shared = EvaluateOptions(
            profile=self.profile,
            threshold=self.threshold,
            per=() if self.rates_only else self.per,
            seeds=self.seeds,
            seed=self.seed,
            keep_alive=self.keep_alive,
            believe=self.believe,
            budget=self.budget,
            legacy_threshold=self.legacy_threshold,
            velocity=self.velocity,
            references=self.references,
            quantised=self.quantised,
            certificates=self.certificates,
            road=self.road,
            leader=self.leader,
            sensor=self.sensor,
            policy=self.policy,
        )
        evaluation = shared.settings()
        if not self.free:
            evaluation = replace(evaluation, free=None)
        try:
            return CompareSettings(
                evaluation,
                self.sensor.protocols(self.protocol),
                against=self.against,
                route_by=self.route_by,
                resamples=self.resamples,
                cluster=self.resample_by,
                rate_basis=self.rate_basis,
            )
        except ValueError as error:
            raise ConfigError(str(error)) from error

    def candidates(self) -> "list[AbstractCandidate]":
        """What is compared: every bank with every horizon and pair of rules, none twice.

        Raises
        ------
        ConfigError
            Where a bank or rule is unknown.
        """
        from modelcast.cli.banks import profile_in_use
        from modelcast.core.exceptions import ConfigError
        from modelcast.models.regimes import REGIME_BANK
        from modelcast.station.banks import member_names
        from modelcast.study.compare.candidate import FixedCandidate

        if not self.trusted_horizon:
            raise ConfigError("--trusted-horizon: name at least one, as 0")
        rules = [_rules(text) for text in self.rules]
        found: list[AbstractCandidate] = []
        profile = profile_in_use(self.profile)
        regimes = () if profile.regimes is None else (REGIME_BANK,)
        train = _trainer(profile, self.bank or ())
        for text in self.bank or (*member_names(profile), *regimes, "paper", "default"):
            if text.partition(":")[0] == "trained":
                found.append(_trained_candidate(text, train))
                continue
            for ending, named in self._banks(text, profile).items():
                own: tuple[StartRule, IdentifyRule] = (named.start, named.identify)
                fitting = rules if rules and len(named.bank.members) > 1 else [own]
                for start, identify in fitting:
                    label = f"{text}{ending}" + (f" {start}/{identify}" if len(fitting) > 1 else "")
                    selector, costs = named.selector, named.costs(self.cost)
                    if (start == "predicted" and selector is None) or (
                        identify == "cheapest" and costs is None
                    ):
                        raise ConfigError(
                            f"--rules {start}/{identify}: --bank {text} has nothing trained for it; take "
                            "another rule, or a profile ('default' or a file of modelcast train)"
                        )
                    found.append(
                        FixedCandidate(
                            label,
                            named.bank,
                            start,
                            identify,
                            selector=selector,
                            costs=costs,
                            trained_on=named.trained_on,
                        )
                    )
        return found

    def _banks(self, text: str, profile: "Profile") -> "dict[str, NamedBank]":
        """A bank with every trusted horizon, by what its name ends in; equal ones, as of cv alone, once."""
        from modelcast.cli.banks import bank_in_use

        made = {
            horizon_s: bank_in_use(
                text,
                noise_floor_m=self.noise_floor,
                window=self.window,
                trusted_horizon_s=horizon_s or None,
                profile=profile,
            )
            for horizon_s in self.trusted_horizon
        }
        distinct: dict[str, NamedBank] = {}
        for horizon_s, named in made.items():
            if named.bank not in [other.bank for other in distinct.values()]:
                ending = f" trusted {horizon_s:g} s" if horizon_s and len(made) > 1 else ""
                distinct[ending] = named
        return distinct


def _trainer(profile: "Profile", texts: "Sequence[str]") -> "Callable[[Sequence[Trajectory]], Profile]":
    """What trains a profile whose bank has this one's members; once for all candidates on the same trips.

    It also has what the texts name behind a colon.
    """
    from modelcast.station.banks import parts_of

    made: dict[tuple[str, ...], Profile] = {}

    def train(trips: "Sequence[Trajectory]") -> "Profile":
        from modelcast.study.training.profile import ProfileSettings, families_of, train_profile

        named = {name for text in texts if text.startswith("trained:") for name in parts_of(text[8:])}
        settings = ProfileSettings(
            names=tuple(member.name for member in profile.bank.members), also=families_of(named)
        )
        key = tuple(trip.trip_id for trip in trips)
        if key not in made:
            made[key] = train_profile(trips, settings)
        return made[key]

    return train


def _trained_candidate(text: str, train: "Callable[[Sequence[Trajectory]], Profile]") -> "TrainedCandidate":
    """A bank of a profile trained on all other routes: the profile's own, or the one named after a colon."""
    from modelcast.station.banks import named_bank
    from modelcast.study.compare.candidate import TrainedCandidate
    from modelcast.study.training.profile import LONGEST_WINDOW

    def learn(trips: "Sequence[Trajectory]", shared: "EvaluationSettings") -> "EvaluationSettings":
        named = named_bank(text.partition(":")[2] or "default", profile=train(trips))
        return replace(shared, bank=named.bank, start=named.start, identify=named.identify)

    return TrainedCandidate(text, learn, LONGEST_WINDOW)


def _rules(text: str) -> tuple[StartRule, IdentifyRule]:
    """A pair of rules from START/IDENTIFY."""
    from modelcast.core.exceptions import ConfigError

    starts: dict[str, StartRule] = {rule: rule for rule in get_args(StartRule)}
    identifies: dict[str, IdentifyRule] = {rule: rule for rule in get_args(IdentifyRule)}
    start, _, identify = text.partition("/")
    if start not in starts or identify not in identifies:
        raise ConfigError(
            f"--rules: '{text}' is not START/IDENTIFY; starts are {', '.join(starts)}, "
            f"identify rules are {', '.join(identifies)}"
        )
    return starts[start], identifies[identify]
