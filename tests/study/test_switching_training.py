"""Claims about the training of switching models: passes over the chain, conjugate beliefs, both searches."""

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hmmlearn.hmm import GaussianHMM
from scipy.stats import invwishart, matrix_normal, multivariate_normal

from modelcast.cli.app import run
from modelcast.core.arrays import FloatArray
from modelcast.io.profile import read_profile
from modelcast.io.write_trips import write_csv
from modelcast.models.profile import default_profile
from modelcast.study.training.switching import (
    FitSettings,
    SamplerSettings,
    Sequences,
    SwitchingSettings,
    add_switching,
    fit_modes,
    sample_modes,
    sequences_of,
    train_switching,
)
from modelcast.study.training.switching.prior import ModePrior, mode_sums, step_densities
from modelcast.study.training.switching.switching_kernels import backward, draw_path, forward
from modelcast.trips.fingerprint import fingerprint
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

ROUNDING = 1e-9
"""Products of some hundred chances round so."""

CHAIN = np.array([[0.95, 0.03, 0.02], [0.04, 0.94, 0.02], [0.03, 0.03, 0.94]])
FIRST = np.array([0.5, 0.3, 0.2])
WEIGHTS = np.array(
    [
        [[0.95, 0.0, 0.0], [0.0, 0.95, 0.0]],
        [[0.5, 0.0, -1.0], [0.0, 0.6, 0.0]],
        [[0.7, 0.0, 0.3], [0.0, 0.5, 0.15]],
    ]
)
"""Modes that hold, brake, and turn."""

NOISE = np.array([np.diag([0.05**2, 0.005**2]), np.diag([0.1**2, 0.01**2]), np.diag([0.08**2, 0.02**2])])


def made(count: int = 3000, parts: int = 3, seed: int = 0) -> tuple[Sequences, FloatArray]:
    """Return steps of the modes above, and the mode of each step."""
    rng = np.random.default_rng(seed)
    values, modes = list[FloatArray](), list[int]()
    for _ in range(parts):
        x, z = np.zeros((count // parts + 1, 2)), int(rng.choice(3, p=FIRST))
        for k in range(1, len(x)):
            z = z if k == 1 else int(rng.choice(3, p=CHAIN[z]))
            x[k] = rng.multivariate_normal(WEIGHTS[z] @ np.append(x[k - 1], 1.0), NOISE[z])
            modes.append(z)
        values.append(x)
    return Sequences.of(values, step_s=0.1), np.array(modes)


DATA, TRUE = made()


def densities(data: Sequences) -> FloatArray:
    return step_densities(data.regressors, data.after, WEIGHTS, NOISE)


def smoothed(data: Sequences) -> tuple[float, FloatArray, FloatArray, FloatArray]:
    """Return likelihood, filtered and smoothed chances, and moves."""
    filtered, out, moves = np.empty((len(data), 3)), np.empty((len(data), 3)), np.empty((3, 3))
    likelihood = forward(densities(data), data.begins, FIRST, CHAIN, filtered)
    backward(filtered, data.begins, CHAIN, out, moves)
    return likelihood, filtered, out, moves


def test_densities_are_scipys() -> None:
    found = densities(DATA)
    for k in (0, 7, 999, 2999):
        for m in range(3):
            mean = WEIGHTS[m] @ DATA.regressors[k]
            assert found[k, m] == pytest.approx(multivariate_normal(mean, NOISE[m]).logpdf(DATA.after[k]))


@pytest.mark.parametrize("end", [1, 2, 30, 400])
def test_likelihood_and_smoothed_chances_are_hmmlearns(end: int) -> None:
    """Without memory of the value before, the modes are a Gaussian hidden Markov model."""
    plain = WEIGHTS * np.array([0.0, 0.0, 1.0])
    peer: Any = GaussianHMM(3, covariance_type="full")
    peer.startprob_, peer.transmat_, peer.means_, peer.covars_ = FIRST, CHAIN, plain[:, :, 2], 9.0 * NOISE
    begins = np.arange(end) % 200 == 0
    lengths = np.diff([*np.flatnonzero(begins), end])
    density = step_densities(DATA.regressors[:end], DATA.after[:end], plain, 9.0 * NOISE)
    filtered, out, moves = np.empty((end, 3)), np.empty((end, 3)), np.empty((3, 3))
    likelihood = forward(density, begins, FIRST, CHAIN, filtered)
    backward(filtered, begins, CHAIN, out, moves)
    assert likelihood == pytest.approx(peer.score(DATA.after[:end], lengths))
    assert out == pytest.approx(peer.predict_proba(DATA.after[:end], lengths), abs=ROUNDING)
    assert moves.sum() == pytest.approx(end - len(lengths))


def test_expected_moves_agree_with_the_chances_at_both_ends() -> None:
    _, _, out, moves = smoothed(DATA)
    last = np.append(DATA.begins[1:], True)
    assert moves.sum(axis=1) == pytest.approx(out[~last].sum(axis=0))
    assert moves.sum(axis=0) == pytest.approx(out[~DATA.begins].sum(axis=0))


def test_paths_are_drawn_as_often_as_modes_are_probable() -> None:
    short, _ = made(60, parts=2, seed=3)
    _, filtered, out, moves = smoothed(short)
    rng, draws = np.random.default_rng(1), 4000
    counted, moved = np.zeros((len(short), 3)), np.zeros((3, 3))
    path = np.empty(len(short), dtype=np.int64)
    for _ in range(draws):
        draw_path(filtered, short.begins, CHAIN, rng.random(len(short)), path)
        counted[np.arange(len(short)), path] += 1.0
        within = ~short.begins[1:]
        np.add.at(moved, (path[:-1][within], path[1:][within]), 1.0)
    five_sigma = 5.0 * 0.5 / np.sqrt(draws)
    assert np.abs(counted / draws - out).max() < five_sigma
    assert np.abs(moved / draws - moves).max() < five_sigma * len(short)


def posterior() -> tuple[ModePrior, FloatArray, Any]:
    prior, member = ModePrior(precision=np.array([2.0, 0.5, 1.0])), np.eye(3)[TRUE]
    sums = mode_sums(DATA.regressors, DATA.after, member)
    return prior, sums, prior.posterior(sums)


def log_belief(mean: FloatArray, precision: FloatArray, degrees: float, scale: FloatArray) -> float:
    """Logarithm of the density of mode 1 as made, by scipy."""
    own: Any = matrix_normal(mean, NOISE[1], np.linalg.inv(precision))
    return float(own.logpdf(WEIGHTS[1]) + invwishart(degrees, scale).logpdf(NOISE[1]))


def test_evidence_is_likelihood_times_prior_over_posterior() -> None:
    prior, sums, after = posterior()
    likelihood = densities(DATA)[TRUE == 1, 1].sum()
    before = log_belief(prior.mean, np.diag(prior.precision), prior.degrees, prior.degrees * prior.scale)
    later = log_belief(after.mean[1], after.precision[1], after.degrees[1], after.scale[1])
    assert prior.log_evidence(sums)[1] == pytest.approx(likelihood + before - later)


def test_a_mode_without_data_has_no_evidence_and_keeps_the_prior() -> None:
    prior = ModePrior()
    nothing = np.zeros((1, 5, 5))
    assert prior.log_evidence(nothing)[0] == pytest.approx(0.0, abs=ROUNDING)
    after = prior.posterior(nothing)
    assert after.mean[0] == pytest.approx(prior.mean)
    assert after.scale[0] == pytest.approx(prior.degrees * prior.scale)


def test_the_most_probable_mode_is_a_peak_of_the_posterior() -> None:
    prior, sums, after = posterior()
    weights, covariance = after.mode()

    def density(w: FloatArray, q: FloatArray) -> float:
        regressors, values = DATA.regressors[TRUE == 2], DATA.after[TRUE == 2]
        likelihood = step_densities(regressors, values, w[None], q[None]).sum()
        return float(likelihood + prior.log_density(w[None], q[None]))

    best = density(weights[2], covariance[2])
    rng = np.random.default_rng(4)
    for size in (1e-3, 1e-2, 1e-1):
        for _ in range(10):
            w = weights[2] * (1.0 + size * rng.standard_normal((2, 3)))
            assert density(w, covariance[2]) < best
            scale = 1.0 + size * rng.choice([-1.0, 1.0])
            assert density(weights[2], covariance[2] * scale) < best
    assert len(sums) == 3


def test_draws_spread_as_the_posterior_says() -> None:
    _, _, after = posterior()
    rng = np.random.default_rng(5)
    drawn = [after.draw(rng) for _ in range(3000)]
    covariance = np.array([q for _, q in drawn]).mean(axis=0)
    expected = after.scale / (after.degrees - 3.0)[:, None, None]
    assert covariance == pytest.approx(expected, rel=0.02, abs=1e-6)
    weights = np.array([w for w, _ in drawn])
    assert weights.mean(axis=0) == pytest.approx(after.mean, abs=0.01)
    spread = (
        np.einsum("nmij,nmkj->mik", weights - after.mean, (weights - after.mean) @ after.precision) / 3000
    )
    assert spread == pytest.approx(3.0 * expected, rel=0.1, abs=1e-4)  # one Q for each of three columns


@pytest.mark.parametrize("seed", range(3))
def test_what_is_climbed_never_falls(seed: int) -> None:
    settings = FitSettings(3, starts=1, rounds=40, least_gain=0.0)
    score = fit_modes(DATA, settings, rng=np.random.default_rng(seed)).score
    rounding = 1e-9 * abs(score[-1])
    assert len(score) > 5
    assert all(after >= before - rounding for before, after in pairwise(score))


def matched(weights: FloatArray) -> list[int]:
    """Return which mode found is nearest to each one made."""
    off = np.abs(weights[None] - WEIGHTS[:, None]).sum(axis=(2, 3))
    return off.argmin(axis=1).tolist()


def standard_errors() -> FloatArray:
    """Return the standard error of each entry of W where every step's mode is known, (3, 2, 3)."""
    _, _, after = posterior()
    inverse = np.linalg.inv(after.precision)
    return np.sqrt(np.einsum("mii,mjj->mij", NOISE, inverse))


def test_the_fit_finds_the_modes_made() -> None:
    found = fit_modes(DATA, FitSettings(3), rng=np.random.default_rng(0))
    order = matched(found.weights)
    assert sorted(order) == [0, 1, 2]
    assert (np.abs(found.weights[order] - WEIGHTS) < 5.0 * standard_errors()).all()
    assert found.chain[np.ix_(order, order)] == pytest.approx(CHAIN, abs=0.03)
    deviations = [np.sqrt(np.diagonal(q, axis1=1, axis2=2)) for q in (found.covariance[order], NOISE)]
    assert deviations[0] == pytest.approx(deviations[1], rel=0.1)
    true_likelihood = smoothed(DATA)[0]
    assert found.log_likelihood > true_likelihood - 5.0


def test_the_sampler_finds_how_many_modes_there_are_and_which() -> None:
    found = sample_modes(DATA, SamplerSettings(8, rounds=80), rng=np.random.default_rng(0))
    assert len(found.chain) == 3
    order = matched(found.weights)
    assert sorted(order) == [0, 1, 2]
    assert (np.abs(found.weights[order] - WEIGHTS) < 5.0 * standard_errors()).all()
    assert found.chain[np.ix_(order, order)] == pytest.approx(CHAIN, abs=0.03)
    assert found.shares[order] == pytest.approx(np.bincount(TRUE) / len(TRUE), abs=0.03)
    assert (np.diff(found.shares) <= 0.0).all()
    assert len(found.score) == 80
    assert max(found.score) > found.score[0]


def test_one_mode_is_found_where_there_is_one() -> None:
    rng = np.random.default_rng(6)
    x = np.zeros((1500, 2))
    for k in range(1, len(x)):
        x[k] = rng.multivariate_normal(0.9 * x[k - 1], np.diag([0.05**2, 0.01**2]))
    data = Sequences.of([x], step_s=0.1)
    found = sample_modes(data, SamplerSettings(6, rounds=80), rng=np.random.default_rng(0))
    assert found.shares[0] > 0.97


def drives() -> list[Trajectory]:
    return [replace(generate_drive(seed, 90.0).truth, trip_id=f"d{seed}/1") for seed in (1, 2)]


def quick(modes: int = 3) -> SwitchingSettings:
    return SwitchingSettings(FitSettings(modes, starts=2, rounds=10), SamplerSettings(5, rounds=10))


def test_the_same_seed_gives_the_same_models_and_another_seed_others() -> None:
    one, same, other = (train_switching(drives(), quick(), seed=seed).models for seed in (3, 3, 4))
    assert one == same
    assert [model.name for model in one] == ["shs", "hdp-hmm"]
    assert one[1] != other[1]


def test_one_alone_is_what_it_is_beside_the_other() -> None:
    both = train_switching(drives(), quick(), seed=3).models
    alone = train_switching(drives(), quick(), names=("hdp-hmm",), seed=3).models
    assert alone == both[1:]


def test_sequences_hold_moving_cars_and_name_trips_of_another_interval() -> None:
    trips = drives()
    slow = replace(generate_drive(3, 90.0, 5.0).truth, trip_id="slow/1")
    data = sequences_of([*trips, slow])
    assert data.step_s == 0.1
    assert data.left_out == ("slow/1",)
    alone = sequences_of(trips)
    assert (data.after == alone.after).all()
    assert (alone.before[1:][~alone.begins[1:]] == alone.after[:-1][~alone.begins[1:]]).all()
    assert len(alone) < sum(len(trip) for trip in trips)


def test_parts_begin_where_rates_from_velocities_do() -> None:
    """Of a car that brakes, seen by its positions: the third sample of a part is the first to have rates."""
    t_s = 0.1 * np.arange(80)
    t_s[40:] += 1.0
    north_m = 20.0 * t_s - 0.5 * t_s**2
    trip = build_trajectory("made/1", t_s, np.column_stack([np.zeros(80), north_m]))
    data = sequences_of([trip])
    assert np.flatnonzero(data.begins).tolist() == [0, 37]
    assert len(data) == 2 * 37
    assert data.before[:, 0].max() < -0.5
    assert data.after[:, 0].max() < -0.5


def test_what_cannot_be_learned_from_is_refused() -> None:
    with pytest.raises(ValueError, match="no trip"):
        sequences_of([])
    with pytest.raises(ValueError, match="at least two samples"):
        Sequences.of([np.zeros((1, 2))], step_s=0.1)
    still = replace(drives()[0], position_m=np.zeros((len(drives()[0]), 2)), speed_mps=None, heading_rad=None)
    with pytest.raises(ValueError, match="at least two samples"):
        sequences_of([still])
    with pytest.raises(ValueError, match="shs, hdp-hmm"):
        train_switching(drives(), quick(), names=("shs", "other"), seed=0)


@pytest.mark.parametrize(
    ("settings", "wrong"),
    [
        (FitSettings, {"modes": 0}),
        (FitSettings, {"modes": 11}),
        (FitSettings, {"starts": 0}),
        (FitSettings, {"rounds": 0}),
        (FitSettings, {"kept_moves": 0.0}),
        (SamplerSettings, {"most": 0}),
        (SamplerSettings, {"most": 11}),
        (SamplerSettings, {"rounds": 0}),
        (SamplerSettings, {"concentration": 0.0}),
        (SamplerSettings, {"sticky": -1.0}),
        (SamplerSettings, {"least_share": 1.0}),
    ],
)
def test_settings_out_of_range_are_refused(settings: type[Any], wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        settings(**wrong)


def test_what_is_added_leaves_the_rest_of_a_profile_and_its_identity_alone() -> None:
    before = default_profile()
    after = add_switching(before, drives(), quick(), names=("shs",), seed=3)
    assert after.identity == before.identity
    assert after.named_bytes == before.named_bytes
    assert after.sub_model("shs") == train_switching(drives(), quick(), seed=3).models[0]
    assert after.sub_model("hdp-hmm") == before.sub_model("hdp-hmm")
    assert after.added_record["hdp-hmm"] == before.added_record["hdp-hmm"]
    new = tuple(fingerprint(trip) for trip in drives())
    assert after.training_trips == (*before.training_trips, *new)
    again = add_switching(after, drives(), quick(), names=("shs",), seed=3)
    assert again == after


@pytest.fixture(scope="module", name="folder")
def _folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("drives")
    write_csv(drives(), folder / "d.csv")
    return folder


@pytest.mark.slow
def test_the_command_adds_to_a_profile_and_banks_take_from_it(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "mine.json"
    asked = [
        "train",
        str(folder),
        "--add",
        "shs",
        "--modes",
        "2",
        "--seed",
        "5",
        "--out",
        str(out),
        "--quiet",
    ]
    assert run(asked) == 0
    found = read_profile(out)
    shs = found.sub_model("shs")
    assert found.identity == default_profile().identity
    assert shs is not None
    assert shs.payload_parameters == 1
    words = ["--bank", "shs", "--profile", str(out), "--threshold", "0.3", "--per", "0", "--seeds", "1"]
    assert run(["evaluate", str(folder), *words, "--out", str(tmp_path / "out"), "--quiet"]) == 0


def test_the_command_prints_what_was_added(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "mine.json"
    assert run(["train", str(folder), "--add", "shs", "--modes", "2", "--out", str(out), "--json"]) == 0
    printed, found = json.loads(capsys.readouterr().out), read_profile(out)
    assert printed["added"] == found.added_record
    assert printed["added"]["shs"] != default_profile().added_record["shs"]
    assert printed["added"]["shs"]["steps"] == len(sequences_of(drives()))
    assert printed["sha256"] == found.identity


ALONE = "for a full training: --add trains shs alone"


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ("--add gp-vehicle", "names must be some of shs, hdp-hmm"),
        ("--profile x.json", "x.json"),
        ("--add shs --modes 11", "modes"),
        ("--add shs --modes 0", "--modes 0 trains neither"),
        ("--add hdp-hmm --modes 0", "--modes 0 trains neither"),
        ("--add shs --bank ctra", f"--bank is {ALONE}"),
        ("--add shs --validate", f"--validate is {ALONE}"),
        ("--add shs --hidden 96 95", f"--hidden is {ALONE}"),
        ("--add shs --coefficients 2", f"--coefficients is {ALONE}"),
        ("--add shs --steps 10", f"--steps is {ALONE}"),
        ("--add shs --regimes 0", f"--regimes is {ALONE}"),
    ],
)
def test_the_command_refuses_what_it_cannot_add(
    folder: Path, tmp_path: Path, words: str, named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "mine.json"
    assert run(["train", str(folder), *words.split(), "--out", str(out), "--quiet"]) == 2
    assert named in " ".join(capsys.readouterr().err.split())
    assert not out.exists()
