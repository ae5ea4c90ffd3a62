"""``modelcast node``: remote and host in one, on the road."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from modelcast.node.config import NodeConfig
    from modelcast.node.journal import Journal
    from modelcast.node.live import LiveNode
    from modelcast.station.sender.sender import Sender


__all__ = ["node", "sender_of_config"]

_SOON_S = 86_400.0


def node(
    config: Path | None = None,
    *,
    gnss: str | None = None,
    kind: Literal["vehicle", "pedestrian", "cyclist", "roadworker", "roadside"] = "vehicle",
    dashboard: bool = False,
    port: int = 8700,
    duration: float = 0.0,
    check: bool = False,
    quiet: bool = False,
) -> int:
    """Run a station on the road: measure, send, hear, keep the map, warn.

    For example: `modelcast node --gnss trip:drive.csv --dashboard`

    Frames go out as UDP multicast on this machine alone, unless the configuration says otherwise. What
    happens is written to the standard error, a line of JSON each. Ends by SIGTERM or Ctrl-C.

    Parameters
    ----------
    config
        A TOML file with the tables station, vehicle, sending, gnss, can, air, pseudonyms, applications, page,
        metrics, roadside, subscribe and record. What is left out has its default.
    gnss
        Where places come from, instead of the file's: gpsd://HOST:PORT, nmea:DEVICE, nmea+tcp://HOST:PORT,
        nmea+file:FILE, or trip:FILE with a recorded trip.
    kind
        pedestrian, cyclist, roadworker: a person's device, that speaks personal safety messages and warns of
        vehicles; roadside: a fixed unit at the place of the file's table roadside, that hears, keeps the map,
        and may relay; vehicle: what the file says, a vehicle where it says nothing.
    dashboard
        Serve the live page on this machine.
    port
        Its port; 0 for any that is free.
    duration
        End after so long [s]; 0 for never.
    check
        Check the configuration and what it names, and end.
    quiet
        Write no line of what happens.
    """
    import asyncio
    import gc
    import io
    import sys
    import time
    from dataclasses import replace

    from modelcast.cli.terminal import say
    from modelcast.core.exceptions import ConfigError
    from modelcast.node.config import NodeConfig, Station, read_config
    from modelcast.node.inputs.opening import check_gnss_source
    from modelcast.node.journal import Journal
    from modelcast.node.live import LiveNode

    if not duration >= 0.0:
        raise ConfigError(f"--duration must not be negative, got {duration}")
    asked = NodeConfig() if config is None else read_config(config)
    if gnss is not None:
        asked = replace(asked, gnss=replace(asked.gnss, source=gnss))
    if kind == "roadside":
        asked = replace(asked, roadside=replace(asked.roadside, on=True), station=Station())
    elif kind != "vehicle":
        asked = replace(asked, station=Station(kind=kind), roadside=replace(asked.roadside, on=False))
    if dashboard:
        asked = replace(asked, page=replace(asked.page, port=port, on=True))
    sender = sender_of_config(asked)
    _check_credentials(asked)
    if not asked.roadside.on:
        check_gnss_source(asked.gnss.source)
    if check:
        say(f"{'the defaults' if config is None else config}: all is as it should be")
        return 0
    journal = Journal(io.StringIO() if quiet else sys.stderr, time.time)
    _get_ready(asked, sender, journal)
    live = LiveNode(asked, sender, journal, show=say)
    # What is loaded by now stays: looked through for garbage it would make steps late, and the end.
    gc.freeze()
    asyncio.run(_run(live, duration))
    return 0


def _get_ready(config: "NodeConfig", sender: "Sender", journal: "Journal") -> None:
    """Load what the node runs before it opens anything; on a cold cache that takes a while, and is told."""
    from modelcast.cli.kernel_cache import kernel_cache
    from modelcast.cli.prepare import rehearsed

    told: list[str] = []

    def announce(label: str) -> None:
        if not told:
            why = "compiled code is not in the cache: this start takes a minute or two"
            place, remedy = str(kernel_cache().place), "run modelcast prepare beforehand, as the node's user"
            journal.note("compiling", {"why": why, "place": place, "remedy": remedy})
        told.append(label)

    met = rehearsed(config, sender, announce=announce)
    what: dict[str, object] = {"kernels": met.ready, "compiled": len(met.compiled), "took_s": met.took_s}
    if met.unkept:
        what |= {"not_kept": len(met.unkept), "remedy": "set MODELCAST_CACHE_DIR to a folder of its user"}
    journal.note("ready", what)


def _check_credentials(config: "NodeConfig") -> None:
    """Read what the node signs with; where nothing of it is good now, nothing could be sent."""
    import time

    from modelcast.cli.terminal import complain
    from modelcast.core.exceptions import ConfigError
    from modelcast.core.kinds import PEOPLE
    from modelcast.messages.belonging import psid_of_kind
    from modelcast.messages.psids import PEOPLE_PSID
    from modelcast.messages.security.time64 import since_2004_s

    if config.security.mode == "none":
        return
    from modelcast.node.credentials import read_credentials

    now_s = since_2004_s(time.time())
    psid, credentials = psid_of_kind(config.station.speaks), read_credentials(config.security.folder)
    left_s = credentials.good_until_s(now_s, psid) - now_s
    if left_s <= 0.0:
        whose = "people" if config.station.speaks in PEOPLE else "vehicles"
        raise ConfigError(
            f"[security] {config.security.folder} holds no certificate of {whose} that is good now: make "
            f"credentials with modelcast credentials new --speaks {whose}"
        )
    site = config.roadside
    if site.on and site.relay and credentials.good_until_s(now_s, PEOPLE_PSID) <= now_s:
        complain(
            f"[security] {config.security.folder} holds no certificate of people that is good now, so "
            "nothing of theirs is repeated: make credentials with modelcast credentials new --speaks both"
        )
    if left_s < _SOON_S:
        complain(f"[security] the last certificate ends in {left_s / 3600.0:.1f} hours")


async def _run(live: "LiveNode", duration_s: float) -> None:
    """Run until a signal, or the end of the time."""
    from modelcast.cli.stopping import stopped_by_signals

    with stopped_by_signals(duration_s) as stop:
        await live.run(stop)


def sender_of_config(config: "NodeConfig") -> "Sender":
    """What the node sends, and when.

    Parameters
    ----------
    config
        The node's configuration.

    Raises
    ------
    ConfigError, DataFormatError
        Where bank, profile or rules cannot be had.
    """
    from modelcast.cli.banks import bank_in_use, profile_in_use
    from modelcast.core.exceptions import ConfigError
    from modelcast.core.kinds import PEOPLE
    from modelcast.node.config import DEFAULT_BANK, PEOPLE_BANK
    from modelcast.station.sender.in_use import in_use
    from modelcast.station.sender.names import sends_models
    from modelcast.station.sender.sender import named_sender

    own, kind = config.sending, config.station.speaks
    profile = profile_in_use(own.profile or None)
    unsaid = own.bank == DEFAULT_BANK and not own.profile
    bank = PEOPLE_BANK if unsaid and kind in PEOPLE else own.bank
    named = bank_in_use(bank, profile=profile) if sends_models(own.policy) else None
    try:
        return named_sender(
            own.policy,
            **in_use(own.policy, named, profile=profile, kind=kind),
            threshold_m=own.threshold_m,
            keep_alive_s=own.keep_alive_s,
        ).of_kind(kind)
    except ValueError as error:
        raise ConfigError(f"[sending]: {error}") from error
