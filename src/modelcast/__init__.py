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
    from modelcast.agents.host import Host as Host
    from modelcast.core.exceptions import ModelcastError as ModelcastError
    from modelcast.core.sensor import SensorModel as SensorModel
    from modelcast.core.trajectory import Trajectory as Trajectory
    from modelcast.core.trajectory import build_trajectory as build_trajectory
    from modelcast.evaluation.case import SensedTrip as SensedTrip
    from modelcast.evaluation.compare.candidate import FixedCandidate as FixedCandidate
    from modelcast.evaluation.compare.candidate import TrainedCandidate as TrainedCandidate
    from modelcast.evaluation.compare.run import compare as compare
    from modelcast.evaluation.compare.settings import CompareSettings as CompareSettings
    from modelcast.evaluation.evaluate import evaluate as evaluate
    from modelcast.evaluation.result import EvaluationResult as EvaluationResult
    from modelcast.evaluation.settings import EvaluationSettings as EvaluationSettings
    from modelcast.evaluation.training.profile import train_profile as train_profile
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
    from modelcast.policy.error_driven import ErrorDriven as ErrorDriven
    from modelcast.policy.periodic import Periodic as Periodic
    from modelcast.report.html import write_report as write_report
    from modelcast.report.tables import rates_frame as rates_frame
    from modelcast.report.tables import references_frame as references_frame
    from modelcast.report.tables import tracking_frame as tracking_frame
    from modelcast.simulation.drive import generate_drive as generate_drive

_HOMES = {
    "Bank": "models.bank",
    "BsmCore": "messages.bsm",
    "CompareSettings": "evaluation.compare.settings",
    "ConstantVelocity": "models.constant_velocity",
    "ErrorDriven": "policy.error_driven",
    "EvaluationResult": "evaluation.result",
    "EvaluationSettings": "evaluation.settings",
    "FixedCandidate": "evaluation.compare.candidate",
    "GaussianProcess": "models.gp",
    "Host": "agents.host",
    "ModelcastError": "core.exceptions",
    "Periodic": "policy.periodic",
    "Profile": "models.profile",
    "SensedTrip": "evaluation.case",
    "SensorModel": "core.sensor",
    "TrainedCandidate": "evaluation.compare.candidate",
    "Trajectory": "core.trajectory",
    "build_trajectory": "core.trajectory",
    "compare": "evaluation.compare.run",
    "decode_bsm": "messages.bsm",
    "default_profile": "models.profile",
    "encode_bsm": "messages.bsm",
    "evaluate": "evaluation.evaluate",
    "generate_drive": "simulation.drive",
    "rates_frame": "report.tables",
    "read_profile": "io.profile",
    "read_trips": "io.trips",
    "references_frame": "report.tables",
    "tracking_frame": "report.tables",
    "train_profile": "evaluation.training.profile",
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
