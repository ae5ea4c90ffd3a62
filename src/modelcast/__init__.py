"""Model-based communication for V2X: message rates and tracking on real trips.

>>> import modelcast
>>> drive = modelcast.generate_drive(seed=0, duration_s=120.0)
>>> settings = modelcast.EvaluationSettings(thresholds_m=(0.5,), packet_error_ratios=(0.0,), seeds=1)
>>> result = modelcast.evaluate([drive.truth], settings)
>>> modelcast.rates_frame(result)["policy"].to_list()
['mbc', 'baseline', 'free', 'mbc', 'baseline', 'free']

Everything here is imported on first use, so that importing the package costs nothing.
"""

import importlib
import sys
from typing import TYPE_CHECKING, Any

from modelcast.core.public_names import PublicPackage

if TYPE_CHECKING:
    from modelcast.apps.base import AbstractApplication as AbstractApplication
    from modelcast.apps.cruise.path import PathCacc as PathCacc
    from modelcast.apps.motions import Motions as Motions
    from modelcast.apps.registry import get_application as get_application
    from modelcast.apps.surrogates import modified_time_to_collision_s as modified_time_to_collision_s
    from modelcast.apps.surrogates import time_to_collision_s as time_to_collision_s
    from modelcast.apps.warnings import Warnings as Warnings
    from modelcast.channel.dsrc import Dsrc as Dsrc
    from modelcast.channel.erasure import GilbertElliott as GilbertElliott
    from modelcast.channel.erasure import IndependentErasure as IndependentErasure
    from modelcast.channel.erasure_radio import ErasureRadio as ErasureRadio
    from modelcast.channel.external_radio import AbstractExternalRadio as AbstractExternalRadio
    from modelcast.channel.external_radio import AbstractRadioSimulator as AbstractRadioSimulator
    from modelcast.channel.external_radio import CarriedFrames as CarriedFrames
    from modelcast.channel.nr import Nr as Nr
    from modelcast.channel.nr_parameters import NrParameters as NrParameters
    from modelcast.channel.radio import OUTCOMES as OUTCOMES
    from modelcast.channel.radio import AbstractRadio as AbstractRadio
    from modelcast.channel.radio import Receptions as Receptions
    from modelcast.channel.radio import Transmissions as Transmissions
    from modelcast.channel.sidelink import Sidelink as Sidelink
    from modelcast.core.exceptions import CodecError as CodecError
    from modelcast.core.exceptions import ConfigError as ConfigError
    from modelcast.core.exceptions import DataFormatError as DataFormatError
    from modelcast.core.exceptions import MissingExtraError as MissingExtraError
    from modelcast.core.exceptions import ModelcastError as ModelcastError
    from modelcast.core.exceptions import ModelcastWarning as ModelcastWarning
    from modelcast.core.exceptions import PolicyError as PolicyError
    from modelcast.core.exceptions import SubModelError as SubModelError
    from modelcast.core.kinds import Kind as Kind
    from modelcast.dashboard.document import snapshot_text as snapshot_text
    from modelcast.dashboard.meter import MessageMeter as MessageMeter
    from modelcast.dashboard.snapshot import Host as Host
    from modelcast.dashboard.snapshot import snapshot_of as snapshot_of
    from modelcast.interface.comparison import Comparison as Comparison
    from modelcast.interface.comparison import compare as compare
    from modelcast.interface.evaluation import Evaluation as Evaluation
    from modelcast.interface.evaluation import evaluate as evaluate
    from modelcast.interface.network import NetworkSimulation as NetworkSimulation
    from modelcast.interface.network import simulate_network as simulate_network
    from modelcast.interface.training import reproduce_paper as reproduce_paper
    from modelcast.interface.training import train_profile as train_profile
    from modelcast.interface.warnings import WarningEvaluation as WarningEvaluation
    from modelcast.interface.warnings import evaluate_warnings as evaluate_warnings
    from modelcast.io.base import AbstractTripReader as AbstractTripReader
    from modelcast.io.base import Tally as Tally
    from modelcast.io.base import ignore_skipped as ignore_skipped
    from modelcast.io.profile import read_profile as read_profile
    from modelcast.io.profile import write_profile as write_profile
    from modelcast.io.results import write_results as write_results
    from modelcast.io.sumo import run_sumo as run_sumo
    from modelcast.io.sumo import survey_sumo as survey_sumo
    from modelcast.io.sumo_config import read_sumo_config as read_sumo_config
    from modelcast.io.sumo_roads import highway_input as highway_input
    from modelcast.io.table_files import read_table_schema as read_table_schema
    from modelcast.io.table_files import write_table as write_table
    from modelcast.io.traces import read_trace as read_trace
    from modelcast.io.traces import trace_writer as trace_writer
    from modelcast.io.trips import Trips as Trips
    from modelcast.io.trips import read_trips as read_trips
    from modelcast.io.write_trips import write_csv as write_csv
    from modelcast.io.write_trips import write_parquet as write_parquet
    from modelcast.messages.bsm import BsmCore as BsmCore
    from modelcast.messages.bsm import decode_bsm as decode_bsm
    from modelcast.messages.bsm import encode_bsm as encode_bsm
    from modelcast.messages.cam import CamLowFrequency as CamLowFrequency
    from modelcast.messages.cam import CooperativeAwarenessMessage as CooperativeAwarenessMessage
    from modelcast.messages.cam import decode_cam as decode_cam
    from modelcast.messages.cam import encode_cam as encode_cam
    from modelcast.messages.mbc import ModelUpdate as ModelUpdate
    from modelcast.messages.mbc import SubModelIdentification as SubModelIdentification
    from modelcast.messages.mbc_codec import UpdateCodec as UpdateCodec
    from modelcast.messages.mbc_profile import WireProfile as WireProfile
    from modelcast.messages.mbc_update import UpdateMessage as UpdateMessage
    from modelcast.messages.mbc_update import read_update as read_update
    from modelcast.messages.psm import PersonalSafetyMessage as PersonalSafetyMessage
    from modelcast.messages.psm import decode_psm as decode_psm
    from modelcast.messages.psm import encode_psm as encode_psm
    from modelcast.messages.psm import person_codes as person_codes
    from modelcast.messages.security.authority import Authority as Authority
    from modelcast.messages.security.p256 import PrivateKey as PrivateKey
    from modelcast.messages.security.signer import Signer as Signer
    from modelcast.messages.security.signer import SignerState as SignerState
    from modelcast.messages.security.verifier import Verifier as Verifier
    from modelcast.messages.security.verifier import VerifierState as VerifierState
    from modelcast.models.bank import Bank as Bank
    from modelcast.models.base import Windows as Windows
    from modelcast.models.constant_velocity import ConstantVelocity as ConstantVelocity
    from modelcast.models.gp.expression import KernelProcess as KernelProcess
    from modelcast.models.gp.gaussian_process import GaussianProcess as GaussianProcess
    from modelcast.models.gp.kernels.linear import Linear as Linear
    from modelcast.models.gp.kernels.matern import Matern32 as Matern32
    from modelcast.models.gp.kernels.rbf import Rbf as Rbf
    from modelcast.models.kinematic import ConstantTurnRateVelocity as ConstantTurnRateVelocity
    from modelcast.models.numpy_model import AbstractNumpySubModel as AbstractNumpySubModel
    from modelcast.models.payload import PayloadField as PayloadField
    from modelcast.models.payload import PayloadLayout as PayloadLayout
    from modelcast.models.profile import Profile as Profile
    from modelcast.models.profile import default_profile as default_profile
    from modelcast.models.threshold_time import expected_time_to_threshold as expected_time_to_threshold
    from modelcast.node.inputs.motion_source import MotionSource as MotionSource
    from modelcast.node.inputs.replay import TripReplay as TripReplay
    from modelcast.node.serving.client import StepClient as StepClient
    from modelcast.report.figures.remotes import plot_remotes as plot_remotes
    from modelcast.report.html import write_report as write_report
    from modelcast.report.tables import rates_frame as rates_frame
    from modelcast.report.tables import references_frame as references_frame
    from modelcast.report.tables import tracking_frame as tracking_frame
    from modelcast.runtime.external.exchange import SessionSettings as SessionSettings
    from modelcast.runtime.external.exchange import Step as Step
    from modelcast.runtime.external.session import Session as Session
    from modelcast.runtime.fleet.engine import run_network as run_network
    from modelcast.runtime.fleet.mix import Mix as Mix
    from modelcast.runtime.fleet.settings import NetworkSettings as NetworkSettings
    from modelcast.runtime.platoon.control import CruiseControl as CruiseControl
    from modelcast.runtime.platoon.drive import PlatoonTrace as PlatoonTrace
    from modelcast.runtime.transport.virtual import VirtualMedium as VirtualMedium
    from modelcast.station.banks import PAPER_BANK as PAPER_BANK
    from modelcast.station.banks import bank_from_text as bank_from_text
    from modelcast.station.fleet import Fleet as Fleet
    from modelcast.station.policy.base import AbstractTransmitPolicy as AbstractTransmitPolicy
    from modelcast.station.policy.base import Air as Air
    from modelcast.station.policy.base import Decisions as Decisions
    from modelcast.station.policy.base import MessageKind as MessageKind
    from modelcast.station.policy.base import Motion as Motion
    from modelcast.station.policy.base import TransmitInputs as TransmitInputs
    from modelcast.station.policy.error_driven import ErrorDriven as ErrorDriven
    from modelcast.station.policy.j2945 import J2945 as J2945
    from modelcast.station.policy.j2945 import Cause as Cause
    from modelcast.station.policy.periodic import Periodic as Periodic
    from modelcast.station.receiver.heard import heard_messages as heard_messages
    from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap as LocalDynamicMap
    from modelcast.station.receiver.local_dynamic_map import Receipt as Receipt
    from modelcast.station.receiver.plausibility import Plausibility as Plausibility
    from modelcast.station.sender.sender import named_sender as named_sender
    from modelcast.station.station import Station as Station
    from modelcast.study.case import SensedTrip as SensedTrip
    from modelcast.study.case import make_case as make_case
    from modelcast.study.compare.candidate import FixedCandidate as FixedCandidate
    from modelcast.study.compare.candidate import TrainedCandidate as TrainedCandidate
    from modelcast.study.compare.settings import CompareSettings as CompareSettings
    from modelcast.study.cruise.measure import measure_drive as measure_drive
    from modelcast.study.cruise.senders import platoon_sender as platoon_sender
    from modelcast.study.network.simulate import FleetRuns as FleetRuns
    from modelcast.study.network.trace import TraceObserver as TraceObserver
    from modelcast.study.recording import AbstractRecordSink as AbstractRecordSink
    from modelcast.study.result import EvaluationResult as EvaluationResult
    from modelcast.study.safety.settings import SafetySettings as SafetySettings
    from modelcast.study.settings import EvaluationSettings as EvaluationSettings
    from modelcast.study.table import Table as Table
    from modelcast.study.training.calibration import train_calibrations as train_calibrations
    from modelcast.trips.manoeuvres.rank import count_manoeuvres as count_manoeuvres
    from modelcast.trips.trajectory import Trajectory as Trajectory
    from modelcast.trips.trajectory import build_trajectory as build_trajectory
    from modelcast.world.drive import generate_drive as generate_drive
    from modelcast.world.platoon.leaders import Sinusoid as Sinusoid
    from modelcast.world.platoon.platoons import Platoons as Platoons
    from modelcast.world.scenario.base import FleetFrame as FleetFrame
    from modelcast.world.scenario.base import run_scenario as run_scenario
    from modelcast.world.scenario.grid import Grid as Grid
    from modelcast.world.scenario.highway import Highway as Highway
    from modelcast.world.scenario.sensed import sensed as sensed
    from modelcast.world.sensors import SensorModel as SensorModel

_HOMES = {
    "AbstractApplication": "apps.base",
    "AbstractExternalRadio": "channel.external_radio",
    "AbstractNumpySubModel": "models.numpy_model",
    "AbstractRadio": "channel.radio",
    "AbstractRadioSimulator": "channel.external_radio",
    "AbstractRecordSink": "study.recording",
    "AbstractTransmitPolicy": "station.policy.base",
    "AbstractTripReader": "io.base",
    "Air": "station.policy.base",
    "Authority": "messages.security.authority",
    "Bank": "models.bank",
    "BsmCore": "messages.bsm",
    "CamLowFrequency": "messages.cam",
    "CarriedFrames": "channel.external_radio",
    "Cause": "station.policy.j2945",
    "CodecError": "core.exceptions",
    "CompareSettings": "study.compare.settings",
    "Comparison": "interface.comparison",
    "ConfigError": "core.exceptions",
    "ConstantTurnRateVelocity": "models.kinematic",
    "ConstantVelocity": "models.constant_velocity",
    "CooperativeAwarenessMessage": "messages.cam",
    "CruiseControl": "runtime.platoon.control",
    "DataFormatError": "core.exceptions",
    "Decisions": "station.policy.base",
    "Dsrc": "channel.dsrc",
    "ErasureRadio": "channel.erasure_radio",
    "ErrorDriven": "station.policy.error_driven",
    "Evaluation": "interface.evaluation",
    "EvaluationResult": "study.result",
    "EvaluationSettings": "study.settings",
    "FixedCandidate": "study.compare.candidate",
    "Fleet": "station.fleet",
    "FleetFrame": "world.scenario.base",
    "FleetRuns": "study.network.simulate",
    "GaussianProcess": "models.gp.gaussian_process",
    "GilbertElliott": "channel.erasure",
    "Grid": "world.scenario.grid",
    "Highway": "world.scenario.highway",
    "Host": "dashboard.snapshot",
    "IndependentErasure": "channel.erasure",
    "J2945": "station.policy.j2945",
    "KernelProcess": "models.gp.expression",
    "Kind": "core.kinds",
    "Linear": "models.gp.kernels.linear",
    "LocalDynamicMap": "station.receiver.local_dynamic_map",
    "Matern32": "models.gp.kernels.matern",
    "MessageKind": "station.policy.base",
    "MessageMeter": "dashboard.meter",
    "MissingExtraError": "core.exceptions",
    "Mix": "runtime.fleet.mix",
    "ModelUpdate": "messages.mbc",
    "ModelcastError": "core.exceptions",
    "ModelcastWarning": "core.exceptions",
    "Motion": "station.policy.base",
    "MotionSource": "node.inputs.motion_source",
    "Motions": "apps.motions",
    "NetworkSettings": "runtime.fleet.settings",
    "NetworkSimulation": "interface.network",
    "Nr": "channel.nr",
    "NrParameters": "channel.nr_parameters",
    "OUTCOMES": "channel.radio",
    "PAPER_BANK": "station.banks",
    "PathCacc": "apps.cruise.path",
    "PayloadField": "models.payload",
    "PayloadLayout": "models.payload",
    "Periodic": "station.policy.periodic",
    "PersonalSafetyMessage": "messages.psm",
    "PlatoonTrace": "runtime.platoon.drive",
    "Platoons": "world.platoon.platoons",
    "Plausibility": "station.receiver.plausibility",
    "PolicyError": "core.exceptions",
    "PrivateKey": "messages.security.p256",
    "Profile": "models.profile",
    "Rbf": "models.gp.kernels.rbf",
    "Receipt": "station.receiver.local_dynamic_map",
    "Receptions": "channel.radio",
    "SafetySettings": "study.safety.settings",
    "SensedTrip": "study.case",
    "SensorModel": "world.sensors",
    "Session": "runtime.external.session",
    "SessionSettings": "runtime.external.exchange",
    "Sidelink": "channel.sidelink",
    "Signer": "messages.security.signer",
    "SignerState": "messages.security.signer",
    "Sinusoid": "world.platoon.leaders",
    "Station": "station.station",
    "Step": "runtime.external.exchange",
    "StepClient": "node.serving.client",
    "SubModelError": "core.exceptions",
    "SubModelIdentification": "messages.mbc",
    "Table": "study.table",
    "Tally": "io.base",
    "TraceObserver": "study.network.trace",
    "TrainedCandidate": "study.compare.candidate",
    "Trajectory": "trips.trajectory",
    "Transmissions": "channel.radio",
    "TransmitInputs": "station.policy.base",
    "TripReplay": "node.inputs.replay",
    "Trips": "io.trips",
    "UpdateCodec": "messages.mbc_codec",
    "UpdateMessage": "messages.mbc_update",
    "Verifier": "messages.security.verifier",
    "VerifierState": "messages.security.verifier",
    "VirtualMedium": "runtime.transport.virtual",
    "WarningEvaluation": "interface.warnings",
    "Warnings": "apps.warnings",
    "Windows": "models.base",
    "WireProfile": "messages.mbc_profile",
    "bank_from_text": "station.banks",
    "build_trajectory": "trips.trajectory",
    "compare": "interface.comparison",
    "count_manoeuvres": "trips.manoeuvres.rank",
    "decode_bsm": "messages.bsm",
    "decode_cam": "messages.cam",
    "decode_psm": "messages.psm",
    "default_profile": "models.profile",
    "encode_bsm": "messages.bsm",
    "encode_cam": "messages.cam",
    "encode_psm": "messages.psm",
    "evaluate": "interface.evaluation",
    "evaluate_warnings": "interface.warnings",
    "expected_time_to_threshold": "models.threshold_time",
    "generate_drive": "world.drive",
    "get_application": "apps.registry",
    "heard_messages": "station.receiver.heard",
    "highway_input": "io.sumo_roads",
    "ignore_skipped": "io.base",
    "make_case": "study.case",
    "measure_drive": "study.cruise.measure",
    "modified_time_to_collision_s": "apps.surrogates",
    "named_sender": "station.sender.sender",
    "person_codes": "messages.psm",
    "platoon_sender": "study.cruise.senders",
    "plot_remotes": "report.figures.remotes",
    "rates_frame": "report.tables",
    "read_profile": "io.profile",
    "read_sumo_config": "io.sumo_config",
    "read_table_schema": "io.table_files",
    "read_trace": "io.traces",
    "read_trips": "io.trips",
    "read_update": "messages.mbc_update",
    "references_frame": "report.tables",
    "reproduce_paper": "interface.training",
    "run_network": "runtime.fleet.engine",
    "run_scenario": "world.scenario.base",
    "run_sumo": "io.sumo",
    "sensed": "world.scenario.sensed",
    "simulate_network": "interface.network",
    "snapshot_of": "dashboard.snapshot",
    "snapshot_text": "dashboard.document",
    "survey_sumo": "io.sumo",
    "time_to_collision_s": "apps.surrogates",
    "trace_writer": "io.traces",
    "tracking_frame": "report.tables",
    "train_calibrations": "study.training.calibration",
    "train_profile": "interface.training",
    "write_csv": "io.write_trips",
    "write_parquet": "io.write_trips",
    "write_profile": "io.profile",
    "write_report": "report.html",
    "write_results": "io.results",
    "write_table": "io.table_files",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return importlib.import_module("modelcast.core.version").package_version()
    if name not in _HOMES:
        now = importlib.import_module("modelcast.core.renamed").RENAMED.get(name)
        near = importlib.import_module("modelcast.core.near_names").near
        became = f": since 0.2.0 it is {now} (docs/upgrading.md)" if now else near(name, _HOMES)
        raise AttributeError(f"module 'modelcast' has no attribute {name!r}{became}")
    return getattr(importlib.import_module(f"modelcast.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*_HOMES, "__version__"])


sys.modules[__name__].__class__ = PublicPackage  # its docstring ends with the list of its names
