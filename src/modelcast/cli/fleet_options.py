"""Options of the commands that put fleets on the air."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from cyclopts import Parameter

from modelcast.cli.options import Count, Paths, SensorOptions, Words
from modelcast.messages.rules import CertificateRule
from modelcast.station.policy.rules import BelieveRule, CostUnit, IdentifyRule, StartRule

if TYPE_CHECKING:
    from modelcast.cli.network_plan import NetworkPlan

__all__ = ["FleetOptions"]


@Parameter(name="*")
@dataclass(frozen=True)
class FleetOptions:
    """Traffic, senders and hosts, whatever is varied.

    Parameters
    ----------
    scenario
        highway; braking: streams whose leaders brake hard now and then; cut-in: streams in which vehicles
        cut in; loaded: a highway of ten lanes unless --lanes, messages of 250 bytes and antennas of 3 dB;
        grid: streets with signals and buildings; crossing: the same with priority instead of signals, and
        drivers who misjudge gaps; sumo-highway, sumo-grid, sumo-junction (extra sumo); platoon: the cars of
        an OpenACC file on their one clock, as long as it lasts; trips: recorded trips laid on a straight
        road; or a file: floating-car data (CSV, Parquet or SUMO XML), or any .sumocfg, which SUMO drives
        (extra sumo).
        Platoon, junction and files have their own density.
    trips
        Recorded trips of platoon and trips: files or folders, several after one another. Of several platoons
        seeds take one each in turn.
    duration
        Time simulated [s].
    warm_up
        How much of it is left out of all counts but the time series [s].
    seeds
        Runs of each combination.
    seed
        Seed of all random numbers.
    length
        Length of the highway, of the road of streams or of trips [m].
    lanes
        Lanes in each direction of it; 0 for as many as the density needs.
    blocks
        Junctions on each side of grid and crossing.
    pedestrians, cyclists
        People in grid and crossing, beside the vehicles of the density: on pavements and crossings,
        and beside the lanes.
    pedestrian_tracks, cyclist_tracks
        Recorded tracks of people, files or folders, laid over the crossings of grid and crossing, each once
        at a random time. They do not see the vehicles, nor the vehicles them.
    persons
        Take the persons of a file of floating-car data or of a .sumocfg, as pedestrians; else they are
        skipped.
    lead_in
        What SUMO drives of a .sumocfg before the run begins, so that its roads are not empty [s].
    certificates
        Which messages carry the certificate: gap, timer, always, digest, unsigned.
    more_bytes
        Bytes of every message beside what it is known to hold, 0 to 1400: Part II, or what another stack
        adds. Frames of cam-road have sizes of their own.
    profile
        File of the profile in use, as for evaluate.
    start
        Sub-model that their messages start with, as for evaluate; where not given, mbc takes the bank's rule
        and the others what erred least of late (recent). Timers know no guard and no survivor.
    identify
        When mbc names another sub-model, as for evaluate; the bank's rule where not given. The others never
        do.
    cost
        What the rule cheapest counts: messages, bytes or airtime.
    keep_alive
        Longest silence of baseline, free and mbc [s].
    believe
        What mbc takes its remotes to hold: whatever it sent, or each of its last messages with its
        probability at the packet error ratio it observes (expected); that where not given, for the
        rules of a profile's bank.
    budget
        Messages that mbc with --believe expected aims at, over those of a channel without losses.
    approach
        Way that two vehicles may come closer between two messages of baseline, free and mbc [m]; 0 for none.
    legacy_threshold
        Error at which legacy receivers, which coast place, speed and heading of a message at constant
        velocity, get an update of baseline, free and mbc [m]; 0 for not minding them.
    relaxed_error
        Tracking error that calls for a message of the relaxed policies in thin traffic [m]; where not given,
        1 cm, or the sensor's white position noise where that is more.
    application
        What hosts warn of by what they hear, several after one another: fcw (forward collision), eebl
        (emergency electronic brake light), ima (intersection movement assist), vru (vehicles of people, and
        people of vehicles). Missed and false warnings are
        those against the same application with perfect knowledge. None where not given.
    algorithm
        Warning range of fcw, as for safety; camp-linear where not given.
    against
        Policy whose missed and false warnings the others' are set against; where not given the first, or in
        mixed fleets what legacy receivers warn of at the lowest share of new senders.
    threads
        Threads of each run; the result is the same whatever their number.
    """

    scenario: str = "highway"
    trips: Paths = ()
    duration: float = 30.0
    warm_up: float = 10.0
    seeds: Count = 3
    seed: Count = 0
    length: float = 2000.0
    lanes: int = 0
    blocks: int = 5
    pedestrians: int = 0
    cyclists: int = 0
    pedestrian_tracks: Paths = ()
    cyclist_tracks: Paths = ()
    persons: bool = False
    lead_in: float = 0.0
    certificates: CertificateRule = "gap"
    more_bytes: int = 0
    profile: str | None = None
    start: StartRule | None = None
    identify: IdentifyRule | None = None
    cost: CostUnit = "bytes"
    keep_alive: float = 1.0
    believe: BelieveRule | None = None
    budget: float = 4.0 / 3.0
    approach: float = 20.0
    legacy_threshold: float = 0.0
    relaxed_error: float | None = None
    application: Words = ()
    algorithm: str | None = None
    against: str | None = None
    threads: int = 1

    def plan(
        self,
        sensor: SensorOptions,
        *,
        banks: tuple[str, ...],
        thresholds_m: tuple[float, ...],
        receivers_ratios: tuple[float, ...] = (),
        margin_m: float = 0.0,
    ) -> "NetworkPlan":
        """What all runs share.

        Parameters
        ----------
        sensor
            What vehicles see of themselves.
        banks, thresholds_m, receivers_ratios, margin_m
            As in `NetworkPlan`.
        """
        from modelcast.cli.network_plan import NetworkPlan

        return NetworkPlan(
            self.scenario,
            trips=tuple(str(path) for path in self.trips),
            duration_s=self.duration,
            warm_up_s=self.warm_up,
            length_m=self.length,
            lanes=self.lanes,
            blocks=self.blocks,
            pedestrians=self.pedestrians,
            cyclists=self.cyclists,
            pedestrian_tracks=tuple(str(path) for path in self.pedestrian_tracks),
            cyclist_tracks=tuple(str(path) for path in self.cyclist_tracks),
            persons=self.persons,
            lead_in_s=self.lead_in,
            seed=self.seed,
            certificates=self.certificates,
            more_bytes=self.more_bytes,
            banks=banks,
            profile=self.profile,
            start=self.start,
            identify=self.identify,
            cost=self.cost,
            threads=self.threads,
            thresholds_m=thresholds_m,
            keep_alive_s=self.keep_alive,
            believe=self.believe,
            budget=self.budget,
            approach_m=self.approach,
            legacy_threshold_m=self.legacy_threshold,
            relaxed_error_m=self.relaxed_error,
            sensor=sensor,
            receivers_ratios=receivers_ratios,
            margin_m=margin_m,
            applications=tuple(dict.fromkeys(self.application)),
            algorithm=self.algorithm,
        )
