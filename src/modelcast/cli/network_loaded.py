"""The scenario ``loaded`` of ``modelcast network``: a busy channel, by roads, messages and antennas at once.

Published traffic seldom loads the channel so far that J2945/1 lowers its power. Here ten lanes carry long
messages over good antennas. Where the user's radio word sets a gain, itself or by its preset, that holds.
"""

from dataclasses import replace
from typing import Any

from modelcast.channel.radio import AbstractRadio
from modelcast.channel.radio_presets import PRESETS
from modelcast.core.named_settings import named_settings

__all__ = ["ANTENNA_GAIN_DB", "LANES", "OTHER_BYTES", "loaded_radio"]

LANES = 5
"""In each direction."""

OTHER_BYTES = 82
"""Beside what a message is counted with [byte]: a plain one with the certificate's digest has 168 bytes, so
that it has 250. What is meant are path history and path prediction, which J2945/1 has in every message;
senders of models carry them too."""

ANTENNA_GAIN_DB = 3.0
"""Of either end [dB]."""

_GAIN = "antenna_gain_db"


def loaded_radio(radio: AbstractRadio[Any], text: str) -> AbstractRadio[Any]:
    """The radio with the scenario's antennas; one that knows no antennas as it is.

    Parameters
    ----------
    radio
        As its word has it.
    text
        That word.

    Examples
    --------
    >>> from modelcast.channel.dsrc import Dsrc
    >>> loaded_radio(Dsrc(), "dsrc").parameters.antenna_gain_db
    3.0
    """
    held: Any = radio
    holder: Any = getattr(radio, "parameters", radio)
    if _GAIN not in getattr(holder, "__dataclass_fields__", ()):
        return radio
    name, given = named_settings(text)
    preset = PRESETS.get(name, {}).get(str(given.get("preset")))
    if _GAIN in given or (preset is not None and _GAIN in preset.settings):
        return radio
    fitted: Any = replace(holder, antenna_gain_db=ANTENNA_GAIN_DB)
    return fitted if holder is held else replace(held, parameters=fitted)
