"""Claims about hostile input: the fuzzer's committed corpus, without the fuzzer."""

import runpy
import subprocess
import sys
import tracemalloc
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from modelcast.core.exceptions import CodecError
from modelcast.messages.bsm import decode_bsm, encode_message
from modelcast.messages.bsm_batch import decode_cores
from modelcast.messages.frame import decode_frame
from modelcast.messages.mbc_codec import UpdateCodec
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import read_update
from modelcast.messages.mbc_wire import decode_extension, decode_identification
from modelcast.messages.psm import decode_psm, encode_psm
from modelcast.messages.psm_batch import decode_people
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.signed import decode_signed
from modelcast.messages.update_document import read_model

FUZZ = Path(__file__).parents[2] / "fuzz"
TARGET = runpy.run_path(str(FUZZ / "decoding.py"))
PROFILES: dict[int, WireProfile] = TARGET["PROFILES"]
CORPUS = sorted((FUZZ / "corpus").iterdir())
PEAK_BYTES = 2**20
BENDS = 20
"""Inputs made of each file of the corpus by changing one octet of its first 60, for the bounded run."""


@pytest.fixture(scope="module")
def check() -> Callable[[bytes], bool]:
    """What the fuzzer checks."""
    return TARGET["check"]


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: path.name)
def test_a_file_of_the_corpus_is_a_message_or_refused(path: Path, check: Callable[[bytes], bool]) -> None:
    octets = path.read_bytes()
    assert check(octets) is not path.name.startswith(("refused", "other"))
    for place in range(0, min(len(octets), 60), max(1, min(len(octets), 60) // BENDS)):
        check(octets[:place] + bytes([octets[place] ^ 0xA5]) + octets[place + 1 :])


def peak_bytes(decode: Callable[[bytes], object], inputs: Sequence[bytes]) -> int:
    """Peak of the memory that decoding takes, each input by itself; nothing refused is an error."""
    peaks: list[int] = []
    tracemalloc.start()
    try:
        for octets in inputs:
            before, _ = tracemalloc.get_traced_memory()
            tracemalloc.reset_peak()
            with suppress(CodecError):
                decode(octets)
            peaks.append(tracemalloc.get_traced_memory()[1] - before)
    finally:
        tracemalloc.stop()
    return max(peaks)


@pytest.mark.parametrize(
    "decode",
    [
        lambda octets: encode_message(decode_bsm(octets)),
        lambda octets: read_update(octets, PROFILES),
        lambda octets: read_update(octets, {}),
        lambda octets: UpdateCodec(PROFILES[1]).decode(octets),
        decode_frame,
        decode_extension,
        decode_identification,
        decode_signed,
        lambda octets: read_update(decode_signed(octets).payload, PROFILES),
        Certificate.from_octets,
        lambda octets: decode_cores(np.frombuffer(octets, np.uint8)[None], np.array([len(octets)])),
        lambda octets: read_model(octets, ()),
        lambda octets: encode_psm(decode_psm(octets)),
        lambda octets: decode_people(np.frombuffer(octets, np.uint8)[None], np.array([len(octets)])),
    ],
    ids=[
        "bsm there and back",
        "update",
        "update of an unknown profile",
        "update codec",
        "frame",
        "extension",
        "identification",
        "signed",
        "update in a signed message",
        "certificate",
        "batch",
        "document",
        "person there and back",
        "people in batch",
    ],
)
def test_memory_stays_below_one_mebibyte_on_the_corpus(decode: Callable[[bytes], object]) -> None:
    """Every decoder, after a first message: what is made ready once is not a message's."""
    inputs = [path.read_bytes() for path in CORPUS]
    for octets in inputs[-3:]:
        with suppress(CodecError):
            decode(octets)
    assert peak_bytes(decode, inputs) < PEAK_BYTES


def test_a_decoder_needs_no_compiler_and_no_array_library() -> None:
    """Hostile input is met by plain code: what the fuzzer instruments is what decodes."""
    modules = "modelcast.messages.bsm, modelcast.messages.psm, modelcast.messages.mbc_wire"
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
