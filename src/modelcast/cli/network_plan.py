"""What ``modelcast network`` is asked for: the traffic by name or file, and what all runs share."""

import hashlib
import importlib.resources
from collections.abc import Iterable
from dataclasses import KW_ONLY, asdict, dataclass, replace
from importlib import metadata
from math import ceil, inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from modelcast.cli.network_loaded import LANES, OTHER_BYTES
from modelcast.cli.options import SensorOptions
from modelcast.cli.people_plan import PeoplePlan
from modelcast.cli.roadside_plan import RoadsidePlan
from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.core.near_names import near
from modelcast.io.network_runs import RunKey
from modelcast.io.sumo_config import SUMO_CONFIG
from modelcast.messages.airtime import Stack
from modelcast.messages.rules import CertificateRule
from modelcast.models.shipped import bank_name, names_profile, profile_path
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.policy.rules import BelieveRule, CostUnit, IdentifyRule, StartRule
from modelcast.station.sender.names import POLICIES, has_threshold, sends_models
from modelcast.station.sender.sender import THRESHOLD_STARTS
from modelcast.study.network.rows import NO_THRESHOLD

if TYPE_CHECKING:
    from modelcast.apps.base import AbstractApplication

__all__ = ["BUILT_IN", "RECORDED", "SUMO", "NetworkPlan"]

_FULL_LANE_PER_KM = 100.0
"""More vehicles a kilometre of lane stand rather than drive [1/km]."""

_MOST_LANES = 32
"""In each direction: a road that is wider is none."""

BUILT_IN = ("highway", "braking", "cut-in", "loaded", "grid", "crossing")
SUMO = ("sumo-highway", "sumo-grid", "sumo-junction")
PEOPLED = ("grid", "crossing")
"""Scenarios in which people walk and ride."""

RECORDED = ("platoon", "trips")


@dataclass(frozen=True, slots=True)
class NetworkPlan:
    """What all runs of one call share.

    Parameters
    ----------
    scenario
        A name of `BUILT_IN`, `SUMO` or `RECORDED`, a configuration of SUMO, or a file of floating-car data.
    duration_s, warm_up_s
        Time simulated, and how much of it is left out of the counts [s].
    length_m
        Length of a highway or of streams [m].
    lanes
        Lanes in each direction of it; 0 for as many as the density needs.
    blocks
        Junctions on each side of a grid.
    seed
        Of all random numbers.
    pedestrians, cyclists
        People in a grid of ours, 0 for none.
    pedestrian_tracks, cyclist_tracks
        Files or folders of recorded tracks that are laid over the crossings of a grid of ours.
    persons
        Whether the persons of a file of floating-car data or of a configuration of SUMO are taken.
    lead_in_s
        Driven by a configuration of SUMO before the run begins [s].
    certificates
        Rule of the certificates.
    more_bytes
        Of every message of a vehicle, beside what it is known to hold.
    banks, profile, start, identify, cost
        Of senders of models, as users name them.
    threads
        Threads of each run.
    thresholds_m, keep_alive_s
        Of error-driven senders; each run has one of the thresholds [m], [s].
    believe, budget
        Of error-driven senders of models.
    approach_m, legacy_threshold_m
        Of error-driven senders; 0 for none [m].
    relaxed_error_m
        Of relaxed senders [m]; None for what fits the sensors.
    sensor
        What vehicles see of themselves.
    trips
        Files or folders of recorded trips, for a scenario of `RECORDED`.
    receivers_ratios
        Of mixed fleets, shares of model receivers that are asked for; empty where all fleets are of one kind.
    margin_m
        Vehicles so near to an end of a straight road are not counted as hosts [m].
    applications, algorithm
        What hosts warn of, by name, none where it is empty; and the warning range of fcw, None for its own.
    roadside
        Units beside the vehicles; None for none.
    people
        What the devices of people do; None where there are no people.
    """

    scenario: str
    _: KW_ONLY
    duration_s: float
    warm_up_s: float
    length_m: float
    lanes: int
    blocks: int
    seed: int
    certificates: CertificateRule
    banks: tuple[str, ...]
    profile: str | None
    start: StartRule | None
    identify: IdentifyRule | None
    cost: CostUnit
    threads: int
    thresholds_m: tuple[float, ...]
    keep_alive_s: float
    believe: BelieveRule | None
    budget: float
    approach_m: float
    legacy_threshold_m: float
    relaxed_error_m: float | None
    sensor: SensorOptions
    trips: tuple[str, ...] = ()
    pedestrians: int = 0
    cyclists: int = 0
    pedestrian_tracks: tuple[str, ...] = ()
    cyclist_tracks: tuple[str, ...] = ()
    persons: bool = False
    lead_in_s: float = 0.0
    receivers_ratios: tuple[float, ...] = ()
    margin_m: float = 0.0
    applications: tuple[str, ...] = ()
    algorithm: str | None = None
    roadside: RoadsidePlan | None = None
    people: PeoplePlan | None = None
    more_bytes: int = 0

    def as_plain(self) -> dict[str, Any]:
        """What every run depends on, as plain values; files by their names, the sensor with its figures.

        Each run has one of the banks and thresholds.
        """
        found: dict[str, Any] = {**asdict(self), "trips": [Path(path).name for path in self.trips]}
        for name in ("pedestrian_tracks", "cyclist_tracks"):
            found[name] = [Path(path).name for path in found[name]]
        found["sensor"]["model"] = asdict(self.sensor.model())
        del found["banks"], found["thresholds_m"]
        for name in (
            "pedestrians",
            "pedestrian_tracks",
            "cyclist_tracks",
            "persons",
            "lead_in_s",
            "cyclists",
            "receivers_ratios",
            "margin_m",
            "applications",
            "algorithm",
            "roadside",
            "people",
            "more_bytes",
        ):
            if not found[name]:
                del found[name]
        del found["threads"]  # the result is the same whatever the number of threads
        for name in ("scenario", "profile"):
            found[name] = None if found[name] is None else Path(found[name]).name
        if self.people is not None:
            found["people"]["bank"] = bank_name(self.people.bank)
        return found

    @property
    def bank_texts(self) -> dict[str, str]:
        """The banks as users name them, by their names in rows: of a file its last part.

        Raises
        ------
        ConfigError
            Where there is none, or two files have one name.
        """
        found: dict[str, str] = {}
        for text in self.banks:
            name = bank_name(text)
            if found.setdefault(name, text) != text:
                raise ConfigError(f"--bank: {found[name]} and {text} have the same name: rename one")
        if not found:
            raise ConfigError("--bank: name at least one, as default")
        return found

    def thresholds_of(self, policy: str) -> tuple[float, ...]:
        """Thresholds that a policy is run with; `NO_THRESHOLD` alone where none changes it.

        Timers know a threshold where their messages start by a rule of `THRESHOLD_STARTS`.

        Parameters
        ----------
        policy
            Its name.
        """
        asks = has_threshold(policy) or (sends_models(policy) and self.start in THRESHOLD_STARTS)
        return tuple(dict.fromkeys(self.thresholds_m)) if asks else (NO_THRESHOLD,)

    def key(self, *, radios: Iterable[str] = (), policies: Iterable[str] = ()) -> RunKey:
        """Version and hashes of all that a run reads: its traffic, its bank, the shipped profile, SUMO.

        Beside them stand the versions of what other packages bring.

        Parameters
        ----------
        radios, policies
            Of all runs, as users name them.

        Raises
        ------
        ConfigError
            Where a file cannot be read, or a bank is unknown.
        DataFormatError
            Where a bank's file or the profile is none.
        """
        from modelcast.apps.registry import APPLICATIONS
        from modelcast.channel.registry import RADIOS
        from modelcast.cli.banks import bank_in_use, profile_in_use
        from modelcast.cli.run_inputs import recorded_inputs
        from modelcast.core.version import package_version
        from modelcast.io.regular import sha256_of
        from modelcast.models.sub_models import sub_model_origins
        from modelcast.station.banks import free_bank
        from modelcast.study.network.mixed import mixed_of

        files = [self.scenario] if self.from_file else []
        if self.from_sumo_config:
            from modelcast.io.sumo_config import read_sumo_config

            files += [str(path) for path in read_sumo_config(self.scenario).inputs]
        files += [] if self.profile is None else [str(profile_path(self.profile))]
        paths = [Path(path) for path in (*self.trips, *self.tracks, *files)]
        hashes = recorded_inputs(paths).items()
        inputs: dict[str, str] = {
            f"{number} {Path(name).name}": found["sha256"] for number, (name, found) in enumerate(hashes)
        }
        profile = importlib.resources.files("modelcast") / "profiles" / "default.json"
        inputs["profile"] = hashlib.sha256(profile.read_bytes()).hexdigest()
        if self.needs_sumo:
            inputs["eclipse-sumo"] = metadata.version("eclipse-sumo")
        in_use = profile_in_use(self.profile)
        inputs |= APPLICATIONS.origins(self.applications) | sub_model_origins(free_bank(in_use).members)
        if self.people is not None:
            theirs = self.people.bank
            inputs |= {"people's bank": sha256_of(profile_path(theirs))} if names_profile(theirs) else {}
            inputs |= sub_model_origins(bank_in_use(theirs, profile=in_use).bank.members)
            inputs |= {} if self.people.policy is None else POLICIES.origins([self.people.policy])
        texts = self.bank_texts
        files_of_banks = {
            name: sha256_of(profile_path(one)) for name, one in texts.items() if names_profile(one)
        }
        senders = {one for policy in policies for one in mixed_of(policy).senders}
        return RunKey(
            package_version(),
            inputs,
            banks=files_of_banks,
            foreign={**RADIOS.origins(radios), **POLICIES.origins(sorted(senders))},
            sub_models={
                name: sub_model_origins(bank_in_use(text, profile=in_use).bank.members)
                for name, text in texts.items()
            },
        )

    @property
    def from_file(self) -> bool:
        """Whether the traffic is a file: of floating-car data, or a configuration of SUMO."""
        return self.scenario not in (*BUILT_IN, *SUMO, *RECORDED)

    @property
    def from_sumo_config(self) -> bool:
        """Whether the traffic is a configuration of SUMO."""
        return self.from_file and self.scenario.endswith(SUMO_CONFIG)

    @property
    def needs_sumo(self) -> bool:
        """Whether the traffic is driven by SUMO."""
        return self.scenario in SUMO or self.from_sumo_config

    @property
    def has_own_density(self) -> bool:
        """Whether the traffic comes with a density of its own."""
        return self.scenario in {"sumo-junction", "platoon"} or self.from_file

    @property
    def has_people(self) -> bool:
        """Whether people are asked for beside the vehicles."""
        return self.pedestrians + self.cyclists > 0

    @property
    def tracks(self) -> tuple[str, ...]:
        """Files or folders of recorded tracks of people."""
        return (*self.pedestrian_tracks, *self.cyclist_tracks)

    @property
    def is_town(self) -> bool:
        """Whether buildings stand along the streets."""
        return self.scenario in {"grid", "crossing", "sumo-grid"}

    @property
    def is_loaded(self) -> bool:
        """Whether messages and antennas are those of the loaded highway."""
        return self.scenario == "loaded"

    @property
    def stack(self) -> Stack:
        """What goes round every payload."""
        other_bytes = self.more_bytes + (OTHER_BYTES if self.is_loaded else 0)
        return Stack(self.certificates, other_bytes=other_bytes)

    def check_traffic(self) -> None:
        """Refuse traffic that cannot be had, before anything runs.

        Raises
        ------
        ConfigError
            Where the scenario is not known, or does not go with `trips`.
        DataFormatError
            Where a file is missing.
        MissingExtraError
            Where SUMO is.
        """
        if self.from_file and not Path(self.scenario).is_file():
            named = ", ".join((*BUILT_IN, *SUMO, *RECORDED))
            meant = near(self.scenario, (*BUILT_IN, *SUMO, *RECORDED))
            raise ConfigError(
                f"--scenario must be {named} or a file that exists, got {self.scenario!r}{meant}"
            )
        if self.scenario in RECORDED and not self.trips:
            raise ConfigError(f"--scenario {self.scenario} needs recorded trips: --trips FILE...")
        if self.trips and self.scenario not in RECORDED:
            raise ConfigError(
                f"--trips goes with --scenario {' or '.join(RECORDED)}, got --scenario {self.scenario}"
            )
        if not 0.0 <= self.lead_in_s < inf:
            raise ConfigError(f"--lead-in must be at least 0, got {self.lead_in_s}")
        if self.lead_in_s and not self.from_sumo_config:
            raise ConfigError(f"--lead-in goes with a .sumocfg, got --scenario {self.scenario}")
        self._check_people()
        for path in (*self.trips, *self.tracks):
            if not Path(path).exists():
                raise DataFormatError(path, "does not exist", remedy="Check the path.")
        if self.needs_sumo:
            from modelcast.io.sumo import require_sumo

            require_sumo()

    def _check_people(self) -> None:
        """Refuse people that the traffic cannot have."""
        if self.persons and not self.from_file:
            raise ConfigError(
                "--persons goes with a file of floating-car data or a .sumocfg, got --scenario "
                f"{self.scenario}"
            )
        if min(self.pedestrians, self.cyclists) < 0:
            raise ConfigError(
                f"--pedestrians and --cyclists must be at least 0, got {self.pedestrians} and {self.cyclists}"
            )
        if (self.has_people or self.tracks) and self.scenario not in PEOPLED:
            raise ConfigError(
                f"--pedestrians, --cyclists and their tracks go with --scenario {' or '.join(PEOPLED)}, "
                f"got --scenario {self.scenario}"
            )

    def warns(self) -> "dict[str, AbstractApplication]":
        """What hosts warn of, by name.

        Raises
        ------
        ConfigError
            Where an application or its algorithm is unknown, or the algorithm goes with none of them.
        """
        from modelcast.apps.forward_collision import ForwardCollisionWarning
        from modelcast.apps.registry import get_application
        from modelcast.apps.warning_ranges import get_warning_range

        found: dict[str, AbstractApplication] = {name: get_application(name) for name in self.applications}
        if self.algorithm is not None:
            of_fcw = {k: v for k, v in found.items() if isinstance(v, ForwardCollisionWarning)}
            if not of_fcw:
                raise ConfigError(f"--algorithm {self.algorithm} goes with --application fcw")
            warning_range = get_warning_range(self.algorithm)
            found |= {name: replace(one, algorithm=warning_range) for name, one in of_fcw.items()}
        return found

    @property
    def settings(self) -> NetworkSettings:
        """What is tracked and counted."""
        margin_m = self.margin_m
        counted_m = (margin_m, self.length_m - margin_m) if margin_m > 0.0 else None
        return NetworkSettings(warm_up_s=self.warm_up_s, counted_m=counted_m)

    def lanes_for(self, density_per_km: float) -> int:
        """Lanes in each direction: as given, or one more for each density that fills the last.

        The loaded highway has `modelcast.cli.network_loaded.LANES` at least.
        """
        if self.lanes:
            return self.lanes
        usual = 3 + sum(density_per_km > full for full in (200.0, 400.0, 800.0))
        if self.is_loaded:
            usual = LANES
        return min(max(usual, ceil(density_per_km / (2.0 * _FULL_LANE_PER_KM))), _MOST_LANES)
