"""Coverage-guided fuzzing of the decoders; needs atheris (`make fuzz`).

Arguments are libFuzzer's: folders of inputs, ``-runs=N``, ``-max_total_time=S``, ``-max_len=N``.
"""

import sys

import atheris

# Compiled code is no Python, and Numba refuses to compile what atheris has instrumented: it comes first.
import modelcast.messages.bsm_kernels
import modelcast.messages.psm_kernels
import modelcast.models.profile  # noqa: F401

with atheris.instrument_imports(include=["modelcast.messages"]):
    from decoding import check

__all__ = ["main"]


def main() -> None:
    """Fuzz until libFuzzer's limits or the first failure."""
    atheris.Setup(sys.argv, check_one)
    atheris.Fuzz()


def check_one(data: bytes) -> None:
    """Check one input; what it returns is of no interest here."""
    check(data)


if __name__ == "__main__":
    main()
