"""How far are batched jobs from what the machine can do? Octets moved, and multiplications, as lower bounds.

For every job two times are measured in the same run: that of reading as many octets as it is given and
writing as many as it returns, in arrays of that size, and that of the least arithmetic it cannot do without.
The larger of them is the limit; a job that reached it would do nothing else. The least arithmetic counts
multiplications and additions of doubles: of a fit by maximum likelihood that of one likelihood by Cholesky
factors, though any search takes several; of a codec none, since it shifts bits. Windows to fit are those of
a generated drive. Processor times of one
thread, the least of the rounds.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bsm_codec import random_codes
from limit_kernels import FLOPS_EACH, move, multiply_add
from measured import record
from modelcast.core.arrays import FloatArray
from modelcast.messages.bsm_batch import decode_cores, encode_cores
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess, fit_axis
from modelcast.models.row_independence import made_up_windows
from modelcast.world.drive import generate_drive

ROUNDS = 9
BATCH, FITS = 100_000, 5_000
LARGE = 2**24
"""Numbers in an array that no cache holds."""

DT_S, AHEAD_S = 0.1, 1.3
FEW, TURNS = 256, 2_000
"""Numbers that stay in the nearest cache, and rounds over them."""


@dataclass(frozen=True, slots=True)
class Job:
    """A job in a batch.

    Parameters
    ----------
    name
        What is done.
    rows
        How many times, in one call.
    run
        The call; compiled already after the first.
    read_octets, written_octets
        Of all rows.
    flops
        Least multiplications and additions of a row.
    """

    name: str
    rows: int
    run: Callable[[], object]
    read_octets: int
    written_octets: int
    flops: float


def least_s(run: Callable[[], object]) -> float:
    """Return the least processor time over rounds, after one that compiles [s]."""
    run()
    times: list[float] = []
    for _ in range(ROUNDS):
        begin = time.process_time()
        run()
        times.append(time.process_time() - begin)
    return min(times)


def moving_s(read_octets: int, written_octets: int) -> float:
    """Return the time of moving so many octets [s]."""
    source, out = np.ones(max(read_octets // 8, 1)), np.ones(max(written_octets // 8, 1))
    return least_s(lambda: move(source, out))


def flops_per_s() -> float:
    """Return multiplications and additions a second of numbers at hand."""
    numbers = np.ones(FEW)
    return TURNS * FEW * FLOPS_EACH / least_s(lambda: multiply_add(TURNS, numbers, 0.5, 0.25))


def predictions(model: ConstantVelocity | GaussianProcess, flops: float) -> Job:
    """Places of many vehicles, each at its own age."""
    windows = made_up_windows(model.window, dt_s=DT_S, rows=FITS)
    parameters: FloatArray = np.resize(model.fit(windows), (BATCH, len(model.parameter_names)))
    ages_s = np.full(BATCH, AHEAD_S)
    return Job(
        f"predict, {model.name}",
        BATCH,
        lambda: model.predict_at(parameters, ages_s, dt_s=DT_S),
        parameters.nbytes + ages_s.nbytes,
        16 * BATCH,
        flops,
    )


def jobs() -> list[Job]:
    """All jobs, with what they read and write."""
    codes = random_codes(np.random.default_rng(0), BATCH)
    frames, lengths = encode_cores(codes)
    process = GaussianProcess(form="intercept")
    n = process.window
    driven_m = generate_drive(seed=0, duration_s=DT_S * (FITS + n)).input.position_m[:, 0]
    windows = np.lib.stride_tricks.sliding_window_view(driven_m, n)[:FITS]
    axis = windows - windows[:, -1:]
    fitted_octets = FITS * 8 * (n + 8)
    return [
        Job("encode basic safety messages", BATCH, lambda: encode_cores(codes), codes.nbytes,
            frames.nbytes + lengths.nbytes, 0.0),
        Job("decode basic safety messages", BATCH, lambda: decode_cores(frames, lengths),
            frames.nbytes + lengths.nbytes, codes.nbytes, 0.0),
        predictions(ConstantVelocity(), 2.0),
        predictions(process, 2.0 * 2.0 * n),
        Job("fit a Gaussian process, one axis", FITS, lambda: fit_axis(axis, dt_s=DT_S), axis.nbytes,
            fitted_octets, n**3 / 3.0 + 2.0 * n**2),
    ]  # fmt: skip


def main() -> None:
    """Print every job beside both limits."""
    moved_s, rate = moving_s(8 * LARGE, 8 * LARGE), flops_per_s()
    read_and_written = 16 * LARGE / moved_s
    record("memory, read and written in turn", read_and_written / 1e9, "GB/s")
    record("multiplications and additions", rate / 1e9, "10⁹/s")
    print(f"memory {read_and_written / 1e9:.1f} GB/s, {rate / 1e9:.1f} 10⁹ multiplications and additions/s")
    for job in jobs():
        took_ns = 1e9 * least_s(job.run) / job.rows
        octets = (job.read_octets + job.written_octets) / job.rows
        memory_ns = 1e9 * moving_s(job.read_octets, job.written_octets) / job.rows
        units_ns = 1e9 * job.flops / rate
        name, limit_ns = max(
            (f"moving {octets:.0f} octets", memory_ns),
            (f"{job.flops:.0f} multiplications and additions", units_ns),
            key=lambda one: one[1],
        )
        record(job.name, took_ns, "ns", peer=(name, limit_ns), sizes={"rows": job.rows})
        print(
            f"{job.name:34s} {took_ns:9.1f} ns; memory {memory_ns:7.2f} ns, arithmetic {units_ns:7.2f} ns: "
            f"{took_ns / limit_ns:.1f} times the limit",
            flush=True,
        )


if __name__ == "__main__":
    main()
