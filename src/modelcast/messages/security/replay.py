"""What a receiver remembers of one sender, so that no message is taken twice."""

from dataclasses import dataclass

__all__ = ["ReplayWindow"]


@dataclass(frozen=True, slots=True)
class ReplayWindow:
    """The newest messages of a sender, and a time up to which everything counts as seen.

    A message is told from another by time and content, not by its signature: who knows one valid ECDSA
    signature can make a second one of the same message.

    Parameters
    ----------
    seen
        Generation time [µs] and fingerprint of each message remembered, by rising time.
    floor_us
        Messages of this time or before are taken for seen: some of that time were forgotten.
    """

    seen: tuple[tuple[int, bytes], ...] = ()
    floor_us: int = -1

    def holds(self, generation_us: int, fingerprint: bytes) -> bool:
        """Whether this message was seen, or is too old to tell.

        Parameters
        ----------
        generation_us
            When it was signed.
        fingerprint
            A hash of its content.
        """
        return generation_us <= self.floor_us or (generation_us, fingerprint) in self.seen

    def admit(self, generation_us: int, fingerprint: bytes, limit: int) -> "ReplayWindow":
        """The window with one more message; beyond the limit the oldest go, and the floor rises to them.

        Parameters
        ----------
        generation_us, fingerprint
            As in `holds`.
        limit
            Messages remembered at most.
        """
        seen = tuple(sorted((*self.seen, (generation_us, fingerprint))))
        forgotten, seen = seen[:-limit], seen[-limit:]
        return ReplayWindow(seen, max(self.floor_us, forgotten[-1][0]) if forgotten else self.floor_us)

    @property
    def newest_us(self) -> int:
        """Generation time up to which it knows anything."""
        return self.seen[-1][0] if self.seen else self.floor_us
