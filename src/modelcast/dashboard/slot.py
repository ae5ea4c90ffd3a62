"""A place for one value a client: what is newer replaces what was not yet taken."""

import asyncio

__all__ = ["LatestSlot"]


class LatestSlot:
    """Holds the latest text of each kind until it is taken: a slow reader skips, and costs one of each.

    Parameters
    ----------
    kinds
        The kinds there are, the one to be taken first in front.

    Examples
    --------
    >>> slot = LatestSlot(("road", "snapshot"))
    >>> for text in ("old", "new"):
    ...     slot.put("snapshot", text)
    >>> slot.replaced, asyncio.run(slot.take())
    (1, 'new')
    """

    def __init__(self, kinds: tuple[str, ...]) -> None:
        self._held: dict[str, str | None] = dict.fromkeys(kinds)
        self._filled = asyncio.Event()
        self.replaced = 0
        """Texts that were never taken."""

    def put(self, kind: str, text: str) -> None:
        """Hold a text in place of the last of its kind.

        Parameters
        ----------
        kind
            One of the kinds.
        text
            What is to be taken.

        Raises
        ------
        KeyError
            Where there is no such kind.
        """
        self.replaced += self._held[kind] is not None
        self._held[kind] = text
        self._filled.set()

    async def take(self) -> str:
        """Wait for a text, and take it out."""
        while True:
            await self._filled.wait()
            for kind, text in self._held.items():
                if text is not None:
                    self._held[kind] = None
                    return text
            self._filled.clear()
