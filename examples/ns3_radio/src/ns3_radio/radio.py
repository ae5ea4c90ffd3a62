"""The radio, and the channel that a process of ns-3 is: lock-step over its standard input and output."""

import subprocess
import weakref
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

import numpy as np

from modelcast import (
    AbstractExternalRadio,
    AbstractRadioSimulator,
    CarriedFrames,
    ModelcastError,
    Transmissions,
)
from ns3_radio.program import build, environment, installed_ns3

__all__ = ["ERROR_MODELS", "Ns3Radio", "Ns3Simulator"]

SOURCE = Path(__file__).with_name("ns3_radio.cc")
OVERHEAD_BYTES = 36
"""MAC header 24, frame check sequence 4, LLC and SNAP 8: ns-3 puts them before and after what it is given."""

ERROR_MODELS = {"nist": "ns3::NistErrorRateModel", "table": "ns3::TableBasedErrorRateModel"}
"""ns-3's names of its error models."""

_MESSAGE = np.dtype(
    [("ready_s", "<f8"), ("power_dbm", "<f8"), ("id", "<i8"), ("sender", "<i4"), ("bytes", "<i4")]
)
_PAIR = np.dtype(
    [("id", "<i8"), ("end_s", "<f8"), ("rssi_dbm", "<f8"), ("receiver", "<i4"), ("outcome", "<i4")]
)


class Ns3Simulator(AbstractRadioSimulator):
    """A process of ns-3; it ends when this is collected.

    Parameters
    ----------
    command
        The program and its options.
    ns3
        Folder of the wheel.
    stations
        Number of stations.
    """

    def __init__(self, command: list[str], ns3: Path, stations: int) -> None:
        self._stations = stations
        self._errors = TemporaryFile()  # noqa: SIM115 - lives as long as the process
        self._process = subprocess.Popen(  # noqa: S603 - our own program
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=environment(ns3),
        )
        weakref.finalize(self, _end, self._process, self._errors)

    def carry(self, transmissions: Transmissions, position_m: np.ndarray, until_t_s: float) -> CarriedFrames:
        """Run ns-3 on to ``until_t_s``.

        Raises
        ------
        ModelcastError
            Where the process has ended.
        ValueError
            Where a message is smaller than the headers of a frame.
        """
        if (transmissions.size_bytes < OVERHEAD_BYTES).any():
            raise ValueError(f"size_bytes must be at least {OVERHEAD_BYTES}, the headers of a frame")
        messages = np.empty(transmissions.size, dtype=_MESSAGE)
        messages["ready_s"], messages["power_dbm"] = transmissions.ready_s, transmissions.power_dbm
        messages["id"], messages["sender"] = transmissions.message_id, transmissions.sender
        messages["bytes"] = transmissions.size_bytes
        head = np.float64(until_t_s).tobytes() + np.int64(messages.size).tobytes()
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(head + position_m.astype("<f8").tobytes() + messages.tobytes())
            self._process.stdin.flush()
        except BrokenPipeError:
            raise self._lost() from None
        pairs, ended, expired = self._read("<i8", 3).tolist()
        found = self._read(_PAIR, pairs)
        return CarriedFrames(
            found["id"].astype(np.int64),
            found["receiver"].astype(np.int64),
            end_s=np.minimum(found["end_s"], until_t_s),  # ns-3 counts nanoseconds
            rssi_dbm=found["rssi_dbm"].astype(np.float64),
            outcome=found["outcome"].astype(np.int64),
            ended=self._read("<i8", ended),
            expired=self._read("<i8", expired),
            busy_ratio=self._read("<f8", self._stations),
        )

    def _read(self, dtype: np.typing.DTypeLike, count: int) -> np.ndarray:
        """So many values of the process's output."""
        size = np.dtype(dtype).itemsize * count
        assert self._process.stdout is not None
        octets = self._process.stdout.read(size)
        if len(octets) != size:
            raise self._lost()
        return np.frombuffer(octets, dtype=dtype).copy()

    def _lost(self) -> ModelcastError:
        """The process has ended by itself: say with what words."""
        self._process.wait()
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip()[-500:]
        return ModelcastError(f"ns-3 ended with {self._process.returncode}: {said or 'it said nothing'}")


def _end(process: subprocess.Popen[bytes], errors: IO[bytes]) -> None:
    """End a process that waits for its next step."""
    process.kill()
    process.communicate()
    errors.close()


@dataclass(frozen=True, slots=True)
class Ns3Radio(AbstractExternalRadio):
    """IEEE 802.11p of ns-3: ad hoc, 10 MHz, 6 Mb/s, log-distance loss and Nakagami fading.

    Parameters
    ----------
    max_power_dbm, distance_bin_m, bins
        As for `AbstractExternalRadio`.
    exponent, reference_loss_db
        Of the log-distance loss, its loss at 1 m [dB]. Fading is Nakagami's, m = 3 below 50 m, 1.5 below
        150 m and 1 beyond.
    noise_figure_db
        Of the receiver [dB].
    sensitivity_dbm, preamble_db
        The weakest frame that is noticed [dBm], and the least ratio to noise and interference at which its
        preamble is found [dB].
    energy_dbm
        Power of any kind that holds the medium busy [dBm]. Where a frame begins that is not received, ns-3
        asks for -82 dBm of all power together, whatever this is.
    error_model
        A key of `ERROR_MODELS`: ``nist``, or ns-3's default, ``table``.
    load_dbm
        The busy ratio counts time with this power or more, and that of own frames [dBm].
    aifsn, window
        Slots of the interframe space beyond SIFS, and the longest countdown. The default is DCF, which a
        station without QoS has.
    folder
        Of the wheel, ``ns3`` in the site-packages of an environment; empty for what ``NS3_FOLDER`` names, or
        this environment's.

    Notes
    -----
    A station holds one message; a newer one takes its place. A frame is lost by the sender that the receiver
    met: ``half-duplex`` where the receiver was sending; ``below-sensitivity`` where interference was below
    the noise; else ``concurrent`` where most of it began within one slot of the frame, and ``hidden``.
    """

    _: KW_ONLY
    exponent: float = 2.4
    reference_loss_db: float = 47.86
    noise_figure_db: float = 7.0
    sensitivity_dbm: float = -98.0
    preamble_db: float = 2.0
    energy_dbm: float = -62.0
    error_model: str = "nist"
    load_dbm: float = -85.0
    aifsn: int = 2
    window: int = 15
    folder: str = ""

    def start(self, stations: int, seed: int) -> AbstractRadioSimulator:
        """Compile the program where it is not yet, and start it."""
        if self.error_model not in ERROR_MODELS:
            known = ", ".join(ERROR_MODELS)
            raise ValueError(f"error_model must be one of {known}, got {self.error_model!r}")
        ns3 = Path(self.folder) if self.folder else installed_ns3()
        options = {
            "stations": stations,
            "seed": seed,
            "exponent": self.exponent,
            "reference": self.reference_loss_db,
            "noise": self.noise_figure_db,
            "sensitivity": self.sensitivity_dbm,
            "preamble": self.preamble_db,
            "energy": self.energy_dbm,
            "errors": ERROR_MODELS[self.error_model],
            "load": self.load_dbm,
            "aifsn": self.aifsn,
            "window": self.window,
            "reach": self.reach_m,
        }
        command = [str(build(SOURCE, ns3)), *(f"--{name}={value}" for name, value in options.items())]
        return Ns3Simulator(command, ns3, stations)
