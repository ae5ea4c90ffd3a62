"""Run every benchmark, each in a process of its own, one thread each."""

import os
import subprocess
import sys
from pathlib import Path

SCRIPTS = (
    "bsm_codec.py",
    "psm_codec.py",
    "mbc_codec.py",
    "gp_fit.py",
    "gp_peers.py",
    "switching.py",
    "numpy_sub_model.py",
    "numpy_policy.py",
    "gp_expressions.py",
    "rate_evaluation.py",
    "evaluate_command.py",
    "traffic.py",
    "congestion.py",
    "dsrc_channel.py",
    "network_loop.py",
    "people_loop.py",
    "safety_applications.py",
    "node_tick.py",
    "node_latency.py",
    "serve_step.py",
)
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def main() -> int:
    """Run them and return the number that failed."""
    if not os.environ.get("MODELCAST_DATA"):
        print("MODELCAST_DATA is not set: the benchmarks need the folder of real trips it names")
        return 2
    environment = {**os.environ, **dict.fromkeys(THREADS, "1")}
    here = Path(__file__).parent
    failed = 0
    for script in SCRIPTS:
        print(f"== {script}", flush=True)
        command = [sys.executable, str(here / script)]
        finished = subprocess.run(command, check=False, env=environment)  # noqa: S603 - our own scripts
        failed += finished.returncode != 0
    return failed


if __name__ == "__main__":
    sys.exit(main())
