"""How do GPy, GPyTorch and tinygp fare at the anchored fit of one axis? Each where it is installed.

The model is the same for all: an RBF with its variance, a slope with its variance, white noise of at least
1 mm; so are the bounds of lengthscale and noise, and the start. Of the ways to drive a peer that were tried,
the quickest and the one that finds the maximum are taken; what it compiles or loads once is not counted.
Likelihoods are computed anew by dense algebra, as in `gp_fit`. One thread throughout; needs the real trips.
"""

import argparse
import os
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec

import numpy as np
import numpy.typing as npt
from threadpoolctl import threadpool_limits

from gp_fit import DT_S, least_seconds, log_likelihood, report, times
from measured import record
from modelcast.models.gp import fit_axis
from windows import real_windows

__all__ = ["main"]

Array = npt.NDArray[np.float64]
LENGTHSCALE_S = (0.1, 10.0)
NOISE_M2 = (1e-6, 1.0)
START = (1.0, 1e-3, 100.0, 1.0)  # lengthscale, noise, slope, variance
LBFGS_STEPS = 200  # more than any window needs
ADAM_STEPS = 500
ADAM_RATE = 0.1
GRADIENT_TOLERANCE = 1e-4


@dataclass(frozen=True, slots=True)
class Run:
    """One way to fit with a peer.

    Parameters
    ----------
    label
        What it is.
    batched
        Whether it takes all windows at once, so that many are worth while.
    fit
        From (B, n) windows to rows of lengthscale, noise, slope and variance, (B, 4).
    """

    label: str
    batched: bool
    fit: Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class Peer:
    """Another program.

    Parameters
    ----------
    packages
        What must be installed, by the names that both pip and import know.
    runs
        Imports the program and returns the ways to fit with it.
    """

    packages: tuple[str, ...]
    runs: Callable[[], list[Run]]


def gpy_runs() -> list[Run]:
    """Return GPy's regression with its default optimiser."""
    import GPy  # noqa: PLC0415 - optional

    def fit(y: Array) -> Array:
        t = times(y.shape[1])[:, None]
        found: list[list[float]] = []
        for window in y:
            kernel = GPy.kern.RBF(1, lengthscale=START[0], variance=START[3])
            kernel += GPy.kern.Linear(1, variances=START[2])
            model = GPy.models.GPRegression(t, window[:, None], kernel, noise_var=START[1])
            rbf, linear, noise = kernel.rbf, kernel.linear, model.likelihood.variance
            rbf.lengthscale.constrain_bounded(*LENGTHSCALE_S, warning=False)
            noise.constrain_bounded(*NOISE_M2, warning=False)
            # Quicker than the softplus that is GPy's default, and as good.
            for positive in (rbf.variance, linear.variances):
                positive.constrain(GPy.constraints.Exponent(), warning=False)
            model.optimize()
            found.append([float(p[0]) for p in (rbf.lengthscale, noise, linear.variances, rbf.variance)])
        return np.array(found)

    return [Run("L-BFGS-B, a window at a time", batched=False, fit=fit)]


def gpytorch_runs() -> list[Run]:
    """Return GPyTorch's exact regression by L-BFGS and, for many windows at once, by Adam."""
    import gpytorch  # noqa: PLC0415 - optional
    import torch  # noqa: PLC0415 - optional
    from linear_operator import to_linear_operator  # noqa: PLC0415 - optional

    torch.set_num_threads(1)
    torch.set_default_dtype(torch.float64)
    Interval, Positive = gpytorch.constraints.Interval, gpytorch.constraints.Positive

    class Model(gpytorch.models.ExactGP):
        def __init__(self, y: torch.Tensor, positive: Callable[[], Interval]) -> None:
            batch = y.shape[:-1]
            noise = gpytorch.likelihoods.GaussianLikelihood(
                noise_constraint=Interval(*NOISE_M2), batch_shape=batch
            )
            noise.noise = START[1]
            t = torch.from_numpy(times(y.shape[-1])).expand(y.shape)
            super().__init__(t[..., None], y, noise)
            self.mean = gpytorch.means.ZeroMean(batch_shape=batch)
            rbf = gpytorch.kernels.RBFKernel(
                batch_shape=batch, lengthscale_constraint=Interval(*LENGTHSCALE_S)
            )
            self.rbf = gpytorch.kernels.ScaleKernel(rbf, batch_shape=batch, outputscale_constraint=positive())
            self.linear = gpytorch.kernels.LinearKernel(batch_shape=batch, variance_constraint=positive())
            rbf.lengthscale, self.linear.variance, self.rbf.outputscale = START[0], START[2], START[3]
            self.train()

        def forward(self, t: torch.Tensor) -> gpytorch.distributions.MultivariateNormal:
            # Dense: the sum of GPyTorch's own lazy matrices factorises the RBF without noise, which fails.
            covariance = to_linear_operator(self.rbf(t).to_dense() + self.linear(t).to_dense())
            return gpytorch.distributions.MultivariateNormal(self.mean(t), covariance)

        def found(self) -> Array:
            kernel = self.rbf.base_kernel
            each = (kernel.lengthscale, self.likelihood.noise, self.linear.variance, self.rbf.outputscale)
            return np.stack([p.detach().numpy().reshape(-1) for p in each], axis=1)

    def loss_of(model: Model) -> Callable[[], torch.Tensor]:
        objective = gpytorch.mlls.ExactMarginalLogLikelihood(model.likelihood, model)

        def loss() -> torch.Tensor:
            model.zero_grad()
            total = -objective(model(*model.train_inputs), model.train_targets).sum()
            total.backward()
            return total

        return loss

    def lbfgs(y: Array) -> Array:
        rows: list[Array] = []
        for window in torch.from_numpy(y):
            model = Model(window, Positive)
            search = torch.optim.LBFGS(
                model.parameters(), max_iter=LBFGS_STEPS, line_search_fn="strong_wolfe"
            )
            search.step(loss_of(model))
            rows.append(model.found())
        return np.concatenate(rows)

    def adam(y: Array) -> Array:
        # In logarithms, which L-BFGS does not survive, Adam comes closer.
        model = Model(torch.from_numpy(y), lambda: Positive(torch.exp, torch.log))
        search = torch.optim.Adam(model.parameters(), lr=ADAM_RATE)
        loss = loss_of(model)
        for _ in range(ADAM_STEPS):
            search.step(loss)
        return model.found()

    return [
        Run("L-BFGS, a window at a time", batched=False, fit=lbfgs),
        Run(f"Adam, {ADAM_STEPS} steps, windows in one batch", batched=True, fit=adam),
    ]


def tinygp_runs() -> list[Run]:
    """Return tinygp's likelihood under optax's L-BFGS, compiled as a whole."""
    # Before the backend starts.
    os.environ["XLA_FLAGS"] = os.environ.get("XLA_FLAGS", "") + " --xla_cpu_multi_thread_eigen=false"
    import jax  # noqa: PLC0415 - optional
    import optax  # noqa: PLC0415 - optional
    import tinygp  # noqa: PLC0415 - optional
    from jax import numpy as jnp  # noqa: PLC0415 - optional

    jax.config.update("jax_platforms", "cpu")
    jax.config.update("jax_enable_x64", val=True)
    low, high = jnp.log(jnp.array([LENGTHSCALE_S, NOISE_M2])).T
    first = jnp.log(jnp.array(START))
    share = (first[:2] - low) / (high - low)
    start = first.at[:2].set(jnp.log(share / (1 - share)))
    search = optax.lbfgs()

    def hyper(free: jax.Array) -> jax.Array:
        bounded = low + (high - low) * jax.nn.sigmoid(free[:2])
        return jnp.exp(free.at[:2].set(bounded))

    def fit_window(window: jax.Array) -> jax.Array:
        t = jnp.asarray(times(window.size))

        def loss(free: jax.Array) -> jax.Array:
            lengthscale, noise, slope, variance = hyper(free)
            kernel = variance * tinygp.kernels.ExpSquared(lengthscale) + slope * tinygp.kernels.DotProduct()
            return -tinygp.GaussianProcess(kernel, t, diag=noise).log_probability(window)

        value_and_grad = optax.value_and_grad_from_state(loss)

        def step(carry: tuple[jax.Array, optax.OptState]) -> tuple[jax.Array, optax.OptState]:
            free, state = carry
            value, grad = value_and_grad(free, state=state)
            change, state = search.update(grad, state, free, value=value, grad=grad, value_fn=loss)
            return optax.apply_updates(free, change), state

        def goes_on(carry: tuple[jax.Array, optax.OptState]) -> jax.Array:
            count, grad = (optax.tree.get(carry[1], name) for name in ("count", "grad"))
            steep = jnp.linalg.norm(grad) > GRADIENT_TOLERANCE
            return (count == 0) | (steep & (count < LBFGS_STEPS))

        return hyper(jax.lax.while_loop(goes_on, step, (start, search.init(start)))[0])

    # Under vmap every window waits for the slowest one's line search: many times slower.
    compiled = jax.jit(lambda y: jax.lax.map(fit_window, y))
    return [
        Run(
            "L-BFGS of optax, windows in one compiled loop",
            batched=True,
            fit=lambda y: np.asarray(compiled(y)),
        )
    ]


PEERS = {
    "GPy": Peer(("GPy",), gpy_runs),
    "GPyTorch": Peer(("gpytorch", "torch"), gpytorch_runs),
    "tinygp": Peer(("tinygp", "jax", "optax"), tinygp_runs),
}


def installed(name: str) -> bool:
    """Return whether a peer can be used, and print what is missing where it cannot."""
    missing = [package for package in PEERS[name].packages if find_spec(package) is None]
    if missing:
        print(f"{name}: left out, {' and '.join(missing)} missing: pip install {' '.join(missing)}")
    return not missing


def compare(name: str, run: Run, y: Array, ours: Array, our_seconds: float) -> None:
    """Print a peer's time and where its likelihoods are."""
    # The first fit also loads libraries, which the limit must know.
    hyper = run.fit(y)
    with threadpool_limits(1):
        seconds = least_seconds(lambda: run.fit(y), repeats=5) / len(y)
    record("anchored fit, one axis", 1e6 * our_seconds, "µs", peer=(f"{name}, {run.label}", 1e6 * seconds))
    print(f"  {run.label}: {seconds * 1e3:.2f} ms a fit, ratio to ours {seconds / our_seconds:.0f}")
    report("  our likelihood", ours, log_likelihood(y[:, :, None], "anchored", hyper))


def main() -> None:
    """Compare with every peer that is installed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--windows", type=int, default=5000, help="for the time of our fit")
    parser.add_argument("--batched", type=int, default=500, help="for a peer that takes many at once")
    parser.add_argument("--single", type=int, default=20, help="for a peer that takes one at a time")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    names = [name for name in PEERS if installed(name)]
    if not names:
        return
    if hasattr(os, "sched_setaffinity"):
        # On one core tinygp takes half the time: XLA's threads need not wake each other.
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    windows = real_windows(given.windows, given.seed)
    y = np.ascontiguousarray(windows[:, :, 0] - windows[:, -1:, 0])
    our_seconds = least_seconds(lambda: fit_axis(y, dt_s=DT_S)) / len(y)
    fits = fit_axis(y, dt_s=DT_S)
    s = fits.variance_m2
    hyper = np.stack([fits.lengthscale_s, fits.noise_ratio * s, fits.linear_ratio_per_s2 * s, s], axis=1)
    ours = log_likelihood(y[:, :, None], "anchored", hyper)
    print(
        f"anchored, one axis, noise floor 1 mm, {y.shape[1]} samples: ours {our_seconds * 1e6:.2f} µs a fit"
    )
    for name in names:
        print(", ".join(f"{package} {version(package)}" for package in PEERS[name].packages))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for run in PEERS[name].runs():
                count = given.batched if run.batched else given.single
                compare(name, run, y[:count], ours[:count], our_seconds)


if __name__ == "__main__":
    main()
