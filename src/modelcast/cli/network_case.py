"""One run of ``modelcast network``: which traffic, which radio, which sender; what a worker process does."""

from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from modelcast.channel.radio import AbstractRadio
from modelcast.channel.radio_words import get_radio
from modelcast.cli.banks import bank_in_use, profile_in_use
from modelcast.cli.network_loaded import loaded_radio
from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.network_senders import named_banks, sender_of
from modelcast.cli.network_traffic import BLOCK_M, traffic
from modelcast.core.exceptions import ConfigError
from modelcast.core.kinds import Kind
from modelcast.io.traffic_survey import TrafficSurvey
from modelcast.runtime.fleet.engine import NetworkRun, run_network
from modelcast.runtime.fleet.observer import AbstractObserver, Observers
from modelcast.runtime.fleet.people import People
from modelcast.station.banks import free_bank
from modelcast.station.receiver.reading import Reading
from modelcast.station.sender.names import sends_models
from modelcast.station.sender.sender import Sender
from modelcast.station.sensing.motion_filter import MotionFilter
from modelcast.study.network.measure import measure
from modelcast.study.network.mixed import measure_mixed, mixed_of
from modelcast.study.network.people import measure_people
from modelcast.study.network.roadside import measure_roadside
from modelcast.study.network.rows import CaseResult, NetworkCase
from modelcast.study.network.simulate import loop_seed
from modelcast.study.network.warned import measure_warnings
from modelcast.study.safety.fleet import SafetyObserver
from modelcast.study.safety.fleet_score import score_pairings
from modelcast.study.safety.fleet_settings import FleetSafetySettings
from modelcast.world.scenario.motion import checked
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import filter_for

if TYPE_CHECKING:
    from modelcast.channel.propagation import Propagation

__all__ = ["TraceFiles", "propagation_of", "run_case", "simulated"]

_STREET_M = 30.0

_TOO_LONG = "size_bytes must fit"
"""How radios with sub-channels refuse a message."""


@dataclass(frozen=True, slots=True)
class TraceFiles:
    """Where traces of runs go, and as what.

    Parameters
    ----------
    folder
        Holds a folder a run.
    formats
        Of `modelcast.io.traces.TRACE_FORMATS`.
    """

    folder: Path
    formats: tuple[str, ...] = ("parquet",)


def propagation_of(plan: NetworkPlan) -> "Propagation":
    """How radio waves get from vehicle to vehicle: in a town, buildings fill what lies between its streets.

    Parameters
    ----------
    plan
        It names the scenario.
    """
    from modelcast.channel.path_loss import ManhattanNlos
    from modelcast.channel.propagation import Propagation, Shadowing, StreetGrid

    if not plan.is_town:
        return Propagation()
    streets = StreetGrid(BLOCK_M, _STREET_M)
    return Propagation(shadowing=Shadowing(decorrelation_m=10.0), streets=streets, nlos=ManhattanNlos())


def _radio(plan: NetworkPlan, text: str) -> AbstractRadio[Any]:
    """The radio that a user means, where waves get about as the plan says."""
    propagation = propagation_of(plan)
    if plan.roadside is not None:
        propagation = plan.roadside.raise_antennas(propagation)
    radio = get_radio(text, propagation)
    return loaded_radio(radio, text) if plan.is_loaded else radio


def run_case(
    plan: NetworkPlan,
    case: NetworkCase,
    found: TrafficSurvey | None = None,
    trace: TraceFiles | None = None,
) -> CaseResult:
    """Run one case and return its rows.

    Parameters
    ----------
    plan
        What all runs share.
    case
        The run.
    found
        What the traffic's file holds, where it is one.
    trace
        Where its trace goes; None for none.

    Raises
    ------
    ConfigError
        Where an option is out of its range, the traffic does not fit, or vehicles do not move as their
        columns say.
    """
    mixed = mixed_of(case.policy)
    observer = _observer(plan, case, is_mixed=mixed.is_mixed)
    with ExitStack() as stack:
        looking: list[AbstractObserver] = [] if observer is None else [observer]
        if trace is not None:
            looking.append(_tracer(trace, case, stack))
        run, bin_m = simulated(plan, case, found=found, observer=Observers(tuple(looking)))
    result = measure(run, case, plan.settings, outcome_bin_m=bin_m)
    if run.roadside is not None and plan.roadside is not None:
        result = measure_roadside(result, run.roadside, len(plan.roadside.places_m), plan.settings)
    if run.people is not None and plan.people is not None:
        counted_s = plan.settings.dt_s * int(run.series.shape[0] - round(plan.warm_up_s / plan.settings.dt_s))
        result = measure_people(result, run.people, plan.people.policy or case.policy, counted_s)
    if mixed.is_mixed:
        result = measure_mixed(result, run, mixed, plan.settings, plan.receivers_ratios)
    if observer is None:
        return result
    return measure_warnings(result, score_pairings(observer, len(mixed.senders)), mixed.senders)


def simulated(
    plan: NetworkPlan,
    case: NetworkCase,
    *,
    found: TrafficSurvey | None = None,
    observer: AbstractObserver | None = None,
) -> tuple[NetworkRun, float]:
    """Run one case and return what it counted, and the width of the radio's bins of distance [m].

    Parameters
    ----------
    plan, case, found
        As for `run_case`.
    observer
        Looks on; None for nobody.

    Raises
    ------
    ConfigError
        As for `run_case`.
    """
    try:
        model = plan.sensor.model()
        mixed = mixed_of(case.policy)
        senders = [_sender(plan, case, one, filter_for(model)) for one in mixed.senders]
        free = free_bank(profile_in_use(plan.profile))
        who = mixed.mix(senders, free) if mixed.is_mixed else senders[0]
        radio = _radio(plan, case.radio)
        seed = loop_seed(plan.seed, case.run)
        with traffic(plan, case, found) as frames:
            run = run_network(
                checked(frames),
                who,
                radio,
                plan.settings,
                seed=seed,
                sensor=FleetSensor(model),
                threads=plan.threads,
                observer=observer,
                roadside=None if plan.roadside is None else plan.roadside.units(),
                people=_devices(plan, case, filter_for(model)),
            )
    except ValueError as error:
        raise ConfigError(_told(error, case.radio)) from error
    return run, radio.bin_m


def _told(error: ValueError, radio: str) -> str:
    """What is wrong with a run; where a message is too long for its radio, with what helps."""
    if not str(error).startswith(_TOO_LONG):
        return str(error)
    return f"--radio {radio}: {error}; lower --more-bytes, or take more sub-channels or a higher mcs"


def _tracer(trace: TraceFiles, case: NetworkCase, stack: ExitStack) -> AbstractObserver:
    """Who writes the trace of a run; its folder appears when the stack is left."""
    from modelcast.io.network_runs import case_name
    from modelcast.io.traces import trace_writer
    from modelcast.study.network.trace import TraceObserver

    writer = trace_writer(trace.folder / case_name(case), trace.formats)
    return TraceObserver(stack.enter_context(writer))


def _observer(plan: NetworkPlan, case: NetworkCase, *, is_mixed: bool) -> SafetyObserver | None:
    """Who looks at what hosts warn of; of a mixed fleet by every reading."""
    if not plan.applications:
        return None
    return SafetyObserver(
        FleetSafetySettings(
            applications=plan.warns(),
            readings=tuple(Reading) if is_mixed else (Reading.MODEL,),
            warm_up_s=plan.warm_up_s,
            seed=case.run,
        )
    )


def _sender(plan: NetworkPlan, case: NetworkCase, policy: str, motion: MotionFilter) -> Sender:
    """The sender of one policy of a case."""
    named = named_banks(plan).get(case.bank) if sends_models(policy) else None
    return sender_of(plan, policy, case.bank, threshold_m=case.threshold_m, named=named, motion=motion)


def _devices(plan: NetworkPlan, case: NetworkCase, motion: MotionFilter) -> People | None:
    """What the devices of people do; None where there are none."""
    people = plan.people
    if people is None:
        return None
    policy = people.policy or case.policy
    if people.keep_alive_s is not None:
        plan = replace(plan, keep_alive_s=people.keep_alive_s)
    profile = profile_in_use(plan.profile)
    named = bank_in_use(people.bank, profile=profile) if sends_models(policy) else None
    sender = sender_of(
        plan,
        policy,
        people.bank,
        threshold_m=case.threshold_m,
        named=named,
        motion=motion,
        kind=Kind.PEDESTRIAN,
    )
    return people.devices(sender)
