"""Claims about Gaussian processes on noisy windows: they stay near a least-squares line."""

import numpy as np
import pytest

from modelcast.models.base import Windows
from modelcast.models.gp import GaussianProcess

WORSE_THAN_A_LINE = 3.0
"""Root mean square error at 1 s over that of a least-squares line, at any noise (measured: 2.2 at most)."""

MODELS = {
    "anchored": GaussianProcess(form="anchored", noise_floor_m=1e-5),
    "intercept": GaussianProcess(form="intercept"),
    "adaptive": GaussianProcess(form="intercept", noise="estimated"),
}


@pytest.mark.parametrize("noise_m", [0.1, 1.0, 3.0, 10.0, 30.0])
@pytest.mark.parametrize("name", MODELS)
def test_a_process_is_at_most_three_times_as_far_off_as_a_line(name: str, noise_m: float) -> None:
    t_s = np.arange(-9, 1) * 0.1
    truth_m = np.stack([15.0 * t_s, 0.0 * t_s], axis=1)
    seen_m = truth_m + noise_m * np.random.default_rng(1).standard_normal((1000, 10, 2))
    samples = np.zeros((1000, 10, 7))
    samples[:, :, :2], samples[:, :, 2], samples[:, :, 6] = seen_m, 15.0, noise_m
    fit = np.linalg.pinv(np.stack([np.ones(10), t_s], axis=1))
    line_m = np.einsum("kj,bja->bka", fit, seen_m).sum(axis=1)  # intercept and slope times 1 s
    model = MODELS[name]
    parameters = model.fit(Windows(samples, dt_s=0.1))
    process_m = seen_m[:, -1] + model.predict(parameters, np.array([1.0]), dt_s=0.1)[:, 0]
    errors_m = [np.sqrt(((place - [15.0, 0.0]) ** 2).sum(axis=1).mean()) for place in (process_m, line_m)]
    assert errors_m[0] <= WORSE_THAN_A_LINE * errors_m[1]
