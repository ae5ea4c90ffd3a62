"""``modelcast prepare``: compile beforehand what a node runs."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from modelcast.node.config import NodeConfig
    from modelcast.node.rehearsal import Rehearsed
    from modelcast.station.sender.sender import Sender

__all__ = ["prepare", "rehearsed"]


def prepare(config: Path | None = None) -> int:
    """Compile what a node runs and keep it, so that its first step is not late.

    For example: `modelcast prepare`

    A node is rehearsed for a few seconds on a made-up clock and without sockets. Done once, it takes a minute
    or two; done again, some seconds. Where compiled code cannot be kept, that is an error: every start would
    take as long.

    Parameters
    ----------
    config
        The node's TOML file, as for node; the defaults without one.
    """
    from modelcast.cli.kernel_cache import kernel_cache
    from modelcast.cli.node import sender_of_config
    from modelcast.cli.progress import busy
    from modelcast.cli.terminal import say
    from modelcast.core.exceptions import ConfigError
    from modelcast.core.kernel import COMPILES
    from modelcast.node.config import NodeConfig, read_config

    asked = NodeConfig() if config is None else read_config(config)
    sender = sender_of_config(asked)
    if not COMPILES:
        raise ConfigError("nothing is compiled where NUMBA_DISABLE_JIT is set: unset it")
    with busy("rehearsing a node", quiet=False):
        met = rehearsed(asked, sender)
    cache = kernel_cache()
    if met.unkept:
        raise ConfigError(
            f"{len(met.unkept)} of {met.ready} kernels cannot be kept in {cache.place}: every start compiles "
            f"them anew, as now for {met.took_s:.0f} s; set MODELCAST_CACHE_DIR to a folder of its user"
        )
    made = f"{len(met.compiled)} functions compiled" if met.compiled else "none had to be compiled"
    say(f"{met.ready} kernels are ready, {made}; {met.took_s:.1f} s")
    size = f"{cache.size_bytes / 1e6:.1f} MB"
    say(f"kept in {cache.place}, {size}" + ("" if cache.writable else ", which cannot be written to"))
    return 0


def rehearsed(
    config: "NodeConfig", sender: "Sender", *, announce: "Callable[[str], None] | None" = None
) -> "Rehearsed":
    """Rehearse a node that is configured so.

    Parameters
    ----------
    config
        The configuration.
    sender
        What it sends.
    announce
        Takes the name of each kernel that is about to be compiled.
    """
    import time

    from modelcast.node.building import applications_of
    from modelcast.node.rehearsal import rehearse

    return rehearse(
        sender,
        applications=applications_of(config),
        clock_s=time.perf_counter,
        tick_s=config.sending.tick_s,
        announce=announce,
    )
