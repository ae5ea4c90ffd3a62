"""What the stations of a session send: the senders of ``modelcast network``, of vehicles and of people."""

from collections.abc import Callable

from modelcast.core.exceptions import ConfigError
from modelcast.core.kinds import PEOPLE, Kind
from modelcast.models.profile import Profile, default_profile, people_profile
from modelcast.runtime.external.exchange import SessionSettings
from modelcast.runtime.external.refusal import FieldError
from modelcast.station.banks import named_bank
from modelcast.station.sender.in_use import in_use
from modelcast.station.sender.names import sends_models
from modelcast.station.sender.sender import Sender, named_sender

__all__ = ["MakeSender", "sender_of"]

MakeSender = Callable[[SessionSettings, Kind], Sender]
"""Gives what stations of a kind send, and when, from the settings that a client asks for."""


def sender_of(settings: SessionSettings, kind: Kind, profile: Profile | None = None) -> Sender:
    """The sender that a session's settings name, for one kind of road user.

    Parameters
    ----------
    settings
        Of the session.
    kind
        A vehicle, or one of `modelcast.core.kinds.PEOPLE`; people who send models send those of the shipped
        profile of people.
    profile
        The profile in use; the one that ships with modelcast where None.

    Raises
    ------
    FieldError
        Where there is no sender of that name.

    Examples
    --------
    >>> asked = SessionSettings(1, sender="mbc", people_slots=1)
    >>> [len(sender_of(asked, kind).bank.members) for kind in (Kind.VEHICLE, Kind.CYCLIST)]
    [4, 1]
    """
    name = settings.sender
    own = default_profile() if profile is None else profile
    try:
        named = None
        if sends_models(name):
            named = named_bank("default", profile=people_profile() if kind in PEOPLE else own)
        return named_sender(
            name,
            **in_use(name, named, profile=own, kind=kind),
            threshold_m=settings.threshold_m,
            keep_alive_s=settings.keep_alive_s,
        ).of_kind(kind)
    except (ConfigError, ValueError) as error:
        raise FieldError("sender", name, f"a sender ({error})") from error
