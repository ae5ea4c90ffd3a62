"""What a node is made again from: written down at its start, and read when it is replayed."""

from dataclasses import replace

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.core.version import package_version
from modelcast.node.config import NodeConfig
from modelcast.node.recording.about import About
from modelcast.node.toml_file import lines_of, tables_of
from modelcast.station.banks import profile_number_of
from modelcast.station.sender.sender import MODEL_SENDERS, Sender

__all__ = ["about_node", "config_of", "profile_of"]


def about_node(
    config: NodeConfig,
    sender: Sender,
    *,
    utc_at_zero_s: float,
    origin: Origin,
    names_seed: int,
    station_seed: int,
) -> About:
    """What is written at the begin of a recording; the page's token is not.

    Parameters
    ----------
    config, sender, origin, names_seed, station_seed
        As `modelcast.node.building.node_of` takes them.
    utc_at_zero_s
        UTC at the clock's 0, since 1970 [s].
    """
    kept = replace(config, page=replace(config.page, token=""))
    return About(
        version=package_version(),
        policy=sender.name,
        profile=profile_of(config, sender),
        utc_at_zero_s=utc_at_zero_s,
        origin=origin,
        names_seed=names_seed,
        station_seed=station_seed,
        config=tuple(lines_of(kept)),
    )


def profile_of(config: NodeConfig, sender: Sender) -> int | None:
    """Number of the bank as messages name it; None where no sub-models are sent.

    Parameters
    ----------
    config, sender
        Of the node.
    """
    return profile_number_of(sender.bank) if config.sending.policy in MODEL_SENDERS else None


def config_of(about: About, path: str) -> NodeConfig:
    """The configuration that was recorded.

    Parameters
    ----------
    about
        What was recorded.
    path
        How errors name the recording.

    Raises
    ------
    DataFormatError
        Where this version does not know it.
    """
    try:
        return tables_of("\n".join(about.config), NodeConfig, f"configuration in {path}")
    except DataFormatError as error:
        raise DataFormatError(
            path,
            f"modelcast {about.version} recorded it with a configuration that this one refuses ({error})",
            remedy=f"Replay it by modelcast {about.version}.",
        ) from error
