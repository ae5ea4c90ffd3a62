"""What a log says of who heard whom, whatever its format."""

from collections.abc import Sequence
from dataclasses import dataclass

from modelcast.channel.link_record import LinkRecord

__all__ = ["HeardLinks"]


@dataclass(frozen=True, slots=True)
class HeardLinks:
    """The links of a log.

    Parameters
    ----------
    links
        A record each.
    own
        Vehicles, or files of one, that logged their own messages: of them nothing is lost, on no radio.
    uncounted
        Messages heard without a time or a count.
    skipped
        What else of the log was not taken as it is, in words with numbers.
    """

    links: Sequence[LinkRecord]
    own: int
    uncounted: int
    skipped: tuple[str, ...] = ()
