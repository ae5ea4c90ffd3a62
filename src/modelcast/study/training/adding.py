"""Sub-models trained later join a profile; all else in it stays as it is, its identity too."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

from modelcast.models.base import AbstractSubModel
from modelcast.models.profile import Profile
from modelcast.trips.fingerprint import fingerprint
from modelcast.trips.trajectory import Trajectory

__all__ = ["require_new", "with_added"]


def with_added(
    profile: Profile,
    models: Sequence[AbstractSubModel],
    record: Mapping[str, Any],
    trips: Sequence[Trajectory],
) -> Profile:
    """The profile with sub-models added; those of the same name that were added before are replaced.

    Parameters
    ----------
    profile
        Any profile.
    models
        What joins.
    record
        How they were trained, by what is told; it joins the record of what was added before.
    trips
        What they were trained on: those that the profile was not trained on join its training trips.

    Raises
    ------
    ValueError
        Where the profile was itself trained with a sub-model of the name.
    """
    new = {model.name for model in models}
    require_new(profile, new)
    known = set(profile.training_trips)
    own = tuple(fingerprint(trip) for trip in trips)
    return replace(
        profile,
        added=(*(model for model in profile.added if model.name not in new), *models),
        added_record={**profile.added_record, **record},
        training_trips=(*profile.training_trips, *(one for one in own if one not in known)),
    )


def require_new(profile: Profile, names: Collection[str]) -> None:
    """Refuse sub-models that a profile was itself trained with: its identity would change.

    Parameters
    ----------
    profile
        Any profile.
    names
        Of what is to join.

    Raises
    ------
    ValueError
        Where there is one.
    """
    twice = sorted({one.name for one in profile.sub_models if one not in profile.added} & set(names))
    if twice:
        raise ValueError(
            f"the profile was itself trained with {', '.join(twice)}: train a new one, which takes the "
            "other sub-models over ('modelcast train' with --profile and without --add)"
        )
