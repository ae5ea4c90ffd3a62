"""A transport that throws frames away as they arrive: losses to try a node with."""

from typing import final

import numpy as np

from modelcast.runtime.transport.base import AbstractTransport, Arrival

__all__ = ["LossyTransport"]


@final
class LossyTransport(AbstractTransport):
    """Another transport, less a share of what arrives.

    Parameters
    ----------
    own
        The transport; closing this one closes it.
    ratio
        Share of the frames that are lost, each by itself, 0..1.
    seed
        Of the losses.

    Raises
    ------
    ValueError
        Where the ratio is out of its range.
    """

    def __init__(self, own: AbstractTransport, ratio: float, seed: int) -> None:
        if not 0.0 <= ratio <= 1.0:
            raise ValueError(f"ratio must lie in 0..1, got {ratio}")
        self._own, self._ratio, self._rng = own, ratio, np.random.default_rng(seed)
        self.lost = 0
        """Frames thrown away."""

    def fileno(self) -> int | None:
        """As of the transport."""
        return self._own.fileno()

    def close(self) -> None:
        """Close the transport."""
        self._own.close()

    def send(self, octets: bytes, *, sent_s: float) -> None:
        """Broadcast one frame; nothing is lost here."""
        self._own.send(octets, sent_s=sent_s)

    def receive(self, until_s: float) -> list[Arrival]:
        """Return what has arrived and was not thrown away."""
        arrived = self._own.receive(until_s)
        kept = [one for one in arrived if self._rng.random() >= self._ratio]
        self.lost += len(arrived) - len(kept)
        return kept
