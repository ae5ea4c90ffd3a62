"""``modelcast credentials``: make and show the keys and certificates of a node."""

from pathlib import Path
from typing import Literal

__all__ = ["credentials"]

_DAY_S = 86_400
_MOST_DAYS = 2730


def credentials(
    action: Literal["new", "show"],
    folder: Path,
    *,
    authority: Path | None = None,
    count: int = 20,
    days: int = 7,
    speaks: Literal["vehicles", "people", "both"] = "vehicles",
) -> int:
    """Make credentials of a node, or show what is in a folder of them.

    For example: `modelcast credentials new keys --count 20`

    These serve to try signatures among machines of one's own: nobody is enrolled, and nothing is revoked.

    Parameters
    ----------
    action
        new or show.
    folder
        The folder; for new one that is empty, or not there yet.
    authority
        Folder "authority" of other credentials, whose authority issues these too; without it a new one does.
    count
        How many pseudonym certificates.
    days
        How many days all of them are good for, from now on.
    speaks
        Whose messages they may sign: those of vehicles, of people (node --kind pedestrian), or both, as a
        roadside unit that relays.
    """
    import os
    import time
    from datetime import UTC, datetime

    from modelcast.cli.terminal import say
    from modelcast.core.exceptions import ConfigError
    from modelcast.messages.psids import PEOPLE_PSID, PSIDS, SAFETY_PSID
    from modelcast.messages.security.time64 import since_2004_s
    from modelcast.node.credentials import make_credentials, read_credentials

    now_utc_s = time.time()
    now_s = since_2004_s(now_utc_s)
    if action == "new":
        if not 1 <= days <= _MOST_DAYS:
            raise ConfigError(f"--days must be from 1 to {_MOST_DAYS}, got {days}")
        found = make_credentials(
            folder,
            count=count,
            start_s=int(now_s),
            duration_s=days * _DAY_S,
            random=os.urandom,
            authority=authority,
            psids={"vehicles": (SAFETY_PSID,), "people": (PEOPLE_PSID,), "both": PSIDS}[speaks],
        )
    else:
        found = read_credentials(folder)
    good = sum(one.certificate.is_good_at(now_s) for one in found.own)
    say(f"{folder}: {len(found.own)} pseudonym certificates, {good} of them good now")
    if good:
        until = datetime.fromtimestamp(now_utc_s + found.good_until_s(now_s) - now_s, UTC)
        say(f"the last is good until {until:%Y-%m-%d %H:%M} UTC")
    for one in found.trusted:
        say(f"trusts the authority {one.digest.hex()}")
    return 0
