"""The radios by name, as a command line asks for them.

Other packages add theirs through the entry-point group ``modelcast.radios``: each entry point loads a class
derived from `modelcast.channel.radio.AbstractRadio` whose arguments all have defaults.
"""

from typing import Any

from modelcast.channel.propagation import Propagation
from modelcast.channel.radio import AbstractRadio
from modelcast.core.open_group import OpenGroup

__all__ = ["RADIOS", "get_radio"]

RADIOS: OpenGroup[AbstractRadio[Any]] = OpenGroup(
    "modelcast.radios",
    AbstractRadio,
    called="radio",
    own={
        "dsrc": "modelcast.channel.dsrc:Dsrc",
        "sidelink": "modelcast.channel.sidelink:Sidelink",
        "nr": "modelcast.channel.nr:Nr",
        "abstract": "modelcast.channel.tabulated:TabulatedRadio",
        "ideal": "modelcast.channel.erasure_radio:ErasureRadio",
    },
)
"""IEEE 802.11p, LTE-V2X and NR-V2X sidelink, a table of losses, no loss within a range; and those of other
packages."""


def get_radio(text: str, propagation: Propagation | None = None) -> AbstractRadio[Any]:
    """Return a radio by its name.

    Parameters
    ----------
    text
        ``NAME``, or ``NAME:KEY=VALUE,KEY=VALUE`` with settings of its own.
    propagation
        How waves get from vehicle to vehicle; None for the radio's own.

    Raises
    ------
    ConfigError
        Where there is none of that name, or it refuses its settings.

    Examples
    --------
    >>> get_radio("ideal:range_m=300").range_m
    300
    """
    found = RADIOS.made_from(text)
    return found if propagation is None else found.within(propagation)
