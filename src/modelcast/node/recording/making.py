"""What a node is made again from: written down at its start, and read when it is replayed."""

from dataclasses import replace
from typing import TYPE_CHECKING

from modelcast.core.exceptions import CodecError, DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.core.version import package_version
from modelcast.messages.belonging import psid_of_kind
from modelcast.messages.security.certificate import Certificate
from modelcast.node.config import NodeConfig
from modelcast.node.envelope import AbstractEnvelope, Unsecured
from modelcast.node.recording.about import About
from modelcast.node.toml_file import lines_of, tables_of
from modelcast.station.banks import profile_number_of
from modelcast.station.sender.names import sends_models
from modelcast.station.sender.sender import Sender

if TYPE_CHECKING:
    from modelcast.node.credentials import Credentials

__all__ = ["about_node", "config_of", "envelope_again", "profile_of"]


def about_node(
    config: NodeConfig,
    sender: Sender,
    *,
    utc_at_zero_s: float,
    origin: Origin,
    names_seed: int,
    station_seed: int,
    credentials: "Credentials | None" = None,
) -> About:
    """What is written at the begin of a recording; the page's token and private keys are not.

    Parameters
    ----------
    config, sender, origin, names_seed, station_seed
        As `modelcast.node.building.node_of` takes them.
    utc_at_zero_s
        UTC at the clock's 0, since 1970 [s].
    credentials
        What it signs with, and whom it trusts; None where nothing is signed.
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
        trusted=() if credentials is None else tuple(one.octets for one in credentials.trusted),
        own=() if credentials is None else tuple(one.certificate.octets for one in credentials.own),
    )


def envelope_again(about: About, config: NodeConfig, path: str) -> AbstractEnvelope:
    """What went round messages, without the keys: it verifies as it did, and signs nothing.

    Parameters
    ----------
    about
        What was recorded.
    config
        Its configuration.
    path
        How errors name the recording.

    Raises
    ------
    DataFormatError
        Where its certificates are none.
    """
    security, psid = config.security, psid_of_kind(config.station.speaks)
    if security.mode == "none":
        return Unsecured(psid)
    from modelcast.node.signed import Signed  # noqa: PLC0415 - the extra is needed here

    try:
        trusted, own = ([Certificate.from_octets(one) for one in all_] for all_ in (about.trusted, about.own))
        return Signed(
            trusted,
            own,
            utc_at_zero_s=about.utc_at_zero_s,
            first=about.names_seed,
            psid=psid,
            required=security.required,
        )
    except (CodecError, ValueError) as error:
        raise DataFormatError(
            path, f"its certificates are none ({error})", remedy="It must be as modelcast node recorded it."
        ) from error


def profile_of(config: NodeConfig, sender: Sender) -> int | None:
    """Number of the bank as messages name it; None where no sub-models are sent.

    Parameters
    ----------
    config, sender
        Of the node.
    """
    return profile_number_of(sender.bank) if sends_models(config.sending.policy) else None


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
