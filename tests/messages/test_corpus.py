"""Claims about hostile input: the fuzzer's committed corpus, without the fuzzer."""

import runpy
import subprocess
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import pytest

from modelcast.core.exceptions import CodecError
from modelcast.messages.bsm import decode_bsm, encode_message

FUZZ = Path(__file__).parents[2] / "fuzz"
CORPUS = sorted((FUZZ / "corpus").iterdir())
PEAK_BYTES = 2**20
BENDS = 20
"""Inputs made of each file of the corpus by changing one octet of its first 60, for the bounded run."""


@pytest.fixture(scope="module")
def check() -> Callable[[bytes], bool]:
    """What the fuzzer checks."""
    return runpy.run_path(str(FUZZ / "decoding.py"))["check"]


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: path.name)
def test_a_file_of_the_corpus_is_a_message_or_refused(path: Path, check: Callable[[bytes], bool]) -> None:
    octets = path.read_bytes()
    assert check(octets) is not path.name.startswith(("refused", "other"))
    for place in range(0, min(len(octets), 60), max(1, min(len(octets), 60) // BENDS)):
        check(octets[:place] + bytes([octets[place] ^ 0xA5]) + octets[place + 1 :])


def test_memory_stays_below_one_mebibyte_on_the_corpus() -> None:
    inputs = [path.read_bytes() for path in CORPUS]
    decode_bsm(inputs[[path.name for path in CORPUS].index("random")])
    tracemalloc.start()
    try:
        before, _ = tracemalloc.get_traced_memory()
        tracemalloc.reset_peak()
        for octets in inputs:
            try:
                message = decode_bsm(octets)
            except CodecError:
                continue
            encode_message(message)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak - before < PEAK_BYTES


def test_a_decoder_needs_no_compiler_and_no_array_library() -> None:
    """Hostile input is met by plain code: what the fuzzer instruments is what decodes."""
    modules = "modelcast.messages.bsm, modelcast.messages.mbc_wire"
    script = f"import sys, {modules}; print(*{{'numba', 'numpy', 'asn1tools'}} & set(sys.modules))"
    ended = subprocess.run(  # noqa: S603 - our own script
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert ended.stdout.strip() == ""


def test_the_corpus_is_what_its_script_writes(tmp_path: Path) -> None:
    script = runpy.run_path(str(FUZZ / "make_corpus.py"))
    script["main"].__globals__["FOLDER"] = tmp_path
    script["main"]()
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {
        path.name: path.read_bytes() for path in CORPUS
    }
