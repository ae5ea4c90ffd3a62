"""The radios by name; `modelcast.channel.radio_words` sets them.

Other packages add theirs through the entry-point group ``modelcast.radios``: each entry point loads a class
derived from `modelcast.channel.radio.AbstractRadio` whose arguments all have defaults.
"""

from typing import Any

from modelcast.channel.radio import AbstractRadio
from modelcast.core.open_group import OpenGroup

__all__ = ["RADIOS"]

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
