"""What must hold for any profile and any ``run.json``: it is refused by name, or it runs with finite results.

`check_profile` and `check_run` take a file. Refused means a `ConfigError` whose text names the file, is short
and holds no control character. Everything else that leaves them is a fault.
"""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.cli.banks import bank_in_use
from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.cli.evaluation_run import run_evaluation
from modelcast.cli.run_record import EvaluationRun, load_run, write_run
from modelcast.core.exceptions import ConfigError
from modelcast.core.rules import is_clean
from modelcast.io.profile import read_profile
from modelcast.io.write_trips import write_csv
from modelcast.messages.mbc_profile import WireProfile
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.calibration import Calibration
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess, Hyperparameters, VehicleProcess
from modelcast.models.gp.conditional import AxisKernel
from modelcast.models.kinematic import ConstantAcceleration, ConstantTurnRateAcceleration
from modelcast.models.learned import FeatureMap, LearnedTrajectory, Perceptron, Selector
from modelcast.models.predicted_path import PredictedPath
from modelcast.models.profile import Profile, default_profile
from modelcast.models.regimes import Regimes
from modelcast.models.trusted import Trusted
from modelcast.station.policy.costs import CostTable
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import DEFAULT_FROM_POSITIONS
from modelcast.study.evaluate import evaluate
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory
from modelcast.world.drive import generate_drive

__all__ = ["check_profile", "check_run", "profile_documents", "run_document"]

_HORIZONS_S = np.array([0.1, 0.5, 1.0, 3.0, 10.0, 60.0])
_LONGEST_ERROR = 1500
_LONGEST_WINDOW = 101


def check_profile(path: Path, *, runs: bool) -> bool:
    """Return whether a file is a profile; fail where it is neither that nor properly refused.

    Parameters
    ----------
    path
        The file.
    runs
        Whether a profile that is read is also run: fitted, asked, carried and evaluated.
    """
    try:
        profile = read_profile(path)
    except ConfigError as refusal:
        _require_proper(refusal, path)
        return False
    if runs:
        _run_models(profile)
        _run_tables(profile)
        _run_bank(path)
    return True


def check_run(path: Path, out: Path, *, runs: bool) -> bool:
    """Return whether a file is a ``run.json``; fail where it is neither that nor properly refused.

    Parameters
    ----------
    path
        The file.
    out
        Folder for results.
    runs
        Whether it is also run.
    """
    try:
        run = load_run(path)
    except ConfigError as refusal:
        _require_proper(refusal, path)
        return False
    options = run.options
    if runs and options.seeds * len(options.threshold) * max(1, len(options.per)) <= 32:
        try:
            code = run_evaluation(run, out, trace=None, json=False, quiet=True)
        except ConfigError as refusal:
            _require_proper(refusal, None)
        else:
            assert code in (0, 3)
            json.loads((out / "summary.json").read_text(), parse_constant=_no_constant)
    else:
        try:
            options.settings()
        except ConfigError as refusal:
            _require_proper(refusal, None)
    return True


def _no_constant(text: str) -> None:
    raise AssertionError(f"summary.json holds {text}")


def _require_proper(refusal: ConfigError, path: Path | None) -> None:
    text = str(refusal)
    assert len(text) < _LONGEST_ERROR, f"the refusal has {len(text)} characters"
    assert is_clean(text), f"the refusal holds control characters: {text!r}"
    assert path is None or path.name in text, text


def _run_models(profile: Profile) -> None:
    """Fit every sub-model to windows and ask it; every number must be finite."""
    drive = _drive()
    matrix = sample_matrix(drive, DEFAULT_FROM_POSITIONS)
    ends = np.arange(_LONGEST_WINDOW, len(drive), 37)
    samples = np.stack([matrix[end - _LONGEST_WINDOW : end] for end in ends])
    samples[0] = 0.0
    samples[1, :, 6] = 1000.0
    for dt_s in (0.1, 0.05, 1.0):
        windows = Windows(samples, dt_s=dt_s)
        for member in profile.sub_models:
            parameters = member.fit(windows)
            _require_finite(member.name, parameters)
            _require_finite(member.name, member.predict(parameters, _HORIZONS_S, dt_s=dt_s))
            _require_finite(member.name, member.covariance(parameters, _HORIZONS_S, dt_s=dt_s))
            table = profile.calibrations.get(member.name)
            if table is not None:
                _require_finite(member.name, table.covariance(member, parameters, _HORIZONS_S, dt_s=dt_s))
        if profile.selector is not None:
            scores = profile.selector.scores(windows, 0.3)
            reaches = (samples.shape[1] - 1) * dt_s >= 0.1 * profile.selector.lags
            assert np.isfinite(scores).all() or not reaches


def _run_tables(profile: Profile) -> None:
    WireProfile.of_profile(profile)
    if profile.costs:
        _require_finite("costs", CostTable.from_plain(profile.costs).packed(0.3))


def _run_bank(path: Path) -> None:
    """Evaluate a short drive with the profile's bank and rules, as the command line does."""
    named = bank_in_use(str(path), profile=default_profile())
    settings = EvaluationSettings(
        (0.3,),
        (0.3,),
        seeds=1,
        bank=named.bank,
        start=named.start,
        identify=named.identify,
        selector=named.selector if named.start == "predicted" else None,
        costs=named.costs("bytes") if named.identify == "cheapest" else None,
        references=False,
    )
    try:
        result = evaluate([_drive()], settings)
    except ConfigError as refusal:
        _require_proper(refusal, None)  # the drive may be shorter than a window
        return
    assert all(np.isfinite(row.total_rate_hz) for row in result.rates)
    assert all(np.isfinite(row.bytes_per_s) for row in result.rates)


def _require_finite(name: str, array: Any) -> None:
    assert np.isfinite(array).all(), f"{name}: a number is not finite"


_DRIVES: list[Trajectory] = []


def _drive() -> Trajectory:
    if not _DRIVES:
        _DRIVES.append(generate_drive(seed=5, duration_s=90.0).truth)
    return _DRIVES[0]


def profile_documents() -> list[Any]:
    """Profiles to make mutants of: a small one that holds every class, and the shipped one."""
    return [json.loads(profile.text) for profile in (_small(), default_profile())]


def run_document(folder: Path) -> Any:
    """A ``run.json`` to make mutants of, with its trip in the folder.

    Parameters
    ----------
    folder
        An existing folder.
    """
    trip = folder / "drive.csv"
    write_csv([_drive()], trip)
    options = EvaluateOptions(threshold=(0.3,), per=(0.3,), seeds=1, references=False, bank="paper")
    run = EvaluationRun((trip,), None, None, "*", options)
    write_run(folder, "evaluate", run.arguments(), run.inputs)
    return json.loads((folder / "run.json").read_text())


def _small() -> Profile:
    """A profile with every class that one may hold; its networks are small, its numbers made up."""
    rng = np.random.default_rng(3)
    axis = AxisKernel(4.0, 10.0)
    fixed = GaussianProcess(
        form="intercept", hyperparameters=Hyperparameters(2.0, 1e-4, linear_ratio_per_s2=1.0)
    )
    bank = Bank(
        (
            LearnedTrajectory((_network(rng, 4, 0.05), _network(rng, 4, np.inf)), coefficients=2),
            Trusted(ConstantTurnRateAcceleration(), 1.5),
            PredictedPath(replace(fixed, label="gp-sent")),
            ConstantVelocity(),
        ),
        "small",
    )
    names = tuple(member.name for member in bank.members)
    regimes = Regimes(
        (VehicleProcess("gp-regime-1"), VehicleProcess("gp-regime-2", axis, across=axis, velocities=True)),
        ((15.0, 0.2, 0.5), (3.0, 1.2, 0.1)),
        scales=(6.0, 0.5, 1.0),
        shares=(0.75, 0.25),
    )
    costs = CostTable(
        60.0,
        12.0,
        thresholds_m=np.array([0.2, 0.5]),
        update_life_s=np.array([2.0, 3.0]),
        age_edges_s=np.array([1.0]),
        share_edges=np.array([0.5]),
        residual_life_s=np.full((2, 4, 2, 2), 0.5),
    )
    table = Calibration(
        "cv",
        np.array([1.0, 2.0]),
        unmodelled=0.1,
        factors=np.ones((2, 2)),
        radii=np.array([[1.0, 2.0, 2.5]] * 2),
        instants=9,
    )
    return Profile(
        bank,
        shelf=(VehicleProcess("gp-vehicle"), fixed, ConstantAcceleration()),
        regimes=regimes,
        start="guarded",
        identify="cheapest",
        selector=Selector(names, (0.2, 0.5), (_network(rng, 8, np.inf),)),
        costs=costs.as_plain(),
        calibrations={"cv": table},
        record={"seed": 3, "trips": [{"trip": "a/b", "duration_s": 12.5}]},
        training_trips=("ab" * 32,),
    )


def _network(rng: np.random.Generator, outputs: int, up_to_noise_m: float) -> Perceptron:
    inputs, hidden = FeatureMap(20).inputs, 4
    return Perceptron(
        up_to_noise_m,
        centre=np.zeros(inputs),
        width=np.ones(inputs),
        weights_1=0.1 * rng.standard_normal((inputs, hidden)),
        bias_1=np.zeros(hidden),
        weights_2=0.1 * rng.standard_normal((hidden, hidden)),
        bias_2=np.zeros(hidden),
        weights_3=0.1 * rng.standard_normal((hidden, outputs)),
        bias_3=np.zeros(outputs),
    )
