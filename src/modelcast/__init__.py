"""Model-based communication for V2X: message rates and tracking on real trips.

>>> import modelcast
>>> drive = modelcast.generate_drive(seed=0, duration_s=120.0)
>>> settings = modelcast.EvaluationSettings(thresholds_m=(0.5,), packet_error_ratios=(0.0,), seeds=1)
>>> result = modelcast.evaluate([drive.truth], settings)
>>> modelcast.rates_frame(result)["policy"].to_list()
['mbc', 'baseline', 'mbc', 'baseline']

Everything here is imported on first use, so that importing the package costs nothing.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from modelcast.core.exceptions import ModelcastError as ModelcastError
    from modelcast.io.profile import read_profile as read_profile
    from modelcast.io.results import write_results as write_results
    from modelcast.io.trips import read_trips as read_trips
    from modelcast.messages.bsm import BsmCore as BsmCore
    from modelcast.messages.bsm import decode_bsm as decode_bsm
    from modelcast.messages.bsm import encode_bsm as encode_bsm
    from modelcast.models.bank import Bank as Bank
    from modelcast.models.constant_velocity import ConstantVelocity as ConstantVelocity
    from modelcast.models.gp import GaussianProcess as GaussianProcess
    from modelcast.models.profile import Profile as Profile
    from modelcast.models.profile import default_profile as default_profile
    from modelcast.node.serving.client import StepClient as StepClient
    from modelcast.report.html import write_report as write_report
    from modelcast.report.tables import rates_frame as rates_frame
    from modelcast.report.tables import references_frame as references_frame
    from modelcast.report.tables import tracking_frame as tracking_frame
    from modelcast.runtime.external.exchange import SessionSettings as SessionSettings
    from modelcast.runtime.external.exchange import Step as Step
    from modelcast.runtime.external.session import Session as Session
    from modelcast.runtime.transport.virtual import VirtualMedium as VirtualMedium
    from modelcast.station.fleet import Fleet as Fleet
    from modelcast.station.policy.error_driven import ErrorDriven as ErrorDriven
    from modelcast.station.policy.periodic import Periodic as Periodic
    from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap as LocalDynamicMap
    from modelcast.station.station import Station as Station
    from modelcast.study.case import SensedTrip as SensedTrip
    from modelcast.study.compare.candidate import FixedCandidate as FixedCandidate
    from modelcast.study.compare.candidate import TrainedCandidate as TrainedCandidate
    from modelcast.study.compare.run import compare as compare
    from modelcast.study.compare.settings import CompareSettings as CompareSettings
    from modelcast.study.evaluate import evaluate as evaluate
    from modelcast.study.paper.run import reproduce_paper as reproduce_paper
    from modelcast.study.result import EvaluationResult as EvaluationResult
    from modelcast.study.settings import EvaluationSettings as EvaluationSettings
    from modelcast.study.training.profile import train_profile as train_profile
    from modelcast.trips.manoeuvres.rank import count_manoeuvres as count_manoeuvres
    from modelcast.trips.trajectory import Trajectory as Trajectory
    from modelcast.trips.trajectory import build_trajectory as build_trajectory
    from modelcast.world.drive import generate_drive as generate_drive
    from modelcast.world.sensors import SensorModel as SensorModel

_HOMES = {
    "Bank": "models.bank",
    "BsmCore": "messages.bsm",
    "CompareSettings": "study.compare.settings",
    "ConstantVelocity": "models.constant_velocity",
    "ErrorDriven": "station.policy.error_driven",
    "EvaluationResult": "study.result",
    "EvaluationSettings": "study.settings",
    "FixedCandidate": "study.compare.candidate",
    "Fleet": "station.fleet",
    "GaussianProcess": "models.gp",
    "LocalDynamicMap": "station.receiver.local_dynamic_map",
    "ModelcastError": "core.exceptions",
    "Periodic": "station.policy.periodic",
    "Profile": "models.profile",
    "SensedTrip": "study.case",
    "SensorModel": "world.sensors",
    "Session": "runtime.external.session",
    "SessionSettings": "runtime.external.exchange",
    "Station": "station.station",
    "Step": "runtime.external.exchange",
    "StepClient": "node.serving.client",
    "TrainedCandidate": "study.compare.candidate",
    "Trajectory": "trips.trajectory",
    "VirtualMedium": "runtime.transport.virtual",
    "build_trajectory": "trips.trajectory",
    "compare": "study.compare.run",
    "count_manoeuvres": "trips.manoeuvres.rank",
    "decode_bsm": "messages.bsm",
    "default_profile": "models.profile",
    "encode_bsm": "messages.bsm",
    "evaluate": "study.evaluate",
    "generate_drive": "world.drive",
    "rates_frame": "report.tables",
    "read_profile": "io.profile",
    "read_trips": "io.trips",
    "references_frame": "report.tables",
    "reproduce_paper": "study.paper.run",
    "tracking_frame": "report.tables",
    "train_profile": "study.training.profile",
    "write_report": "report.html",
    "write_results": "io.results",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return importlib.import_module("modelcast.core.version").package_version()
    if name not in _HOMES:
        raise AttributeError(f"module 'modelcast' has no attribute {name!r}")
    return getattr(importlib.import_module(f"modelcast.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*_HOMES, "__version__"])
