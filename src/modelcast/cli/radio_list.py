"""Settings and presets of radios, as ``modelcast network --radio-settings`` lists them."""

from collections.abc import Sequence

from modelcast.channel.radio_presets import PRESETS
from modelcast.channel.radio_settings import shown
from modelcast.channel.radio_words import get_radio, radio_keys
from modelcast.cli.named_words import check_word
from modelcast.cli.terminal import say, say_json
from modelcast.core.named_settings import named_settings

__all__ = ["list_settings"]


def list_settings(words: Sequence[str], *, json: bool) -> None:
    """Print the settings and presets of radios.

    Parameters
    ----------
    words
        As ``--radio`` has them; what they set is checked and not listed.
    json
        As a document instead of lines.

    Raises
    ------
    ConfigError
        Where a word names no radio, another package's, or has settings that do not go.
    """
    for word in words:
        check_word("--radio", get_radio, word)
    names = dict.fromkeys(named_settings(word)[0] for word in words)
    if json:
        say_json({name: _document(name) for name in names}, sort=False)
        return
    for name in names:
        say(f"--radio {name}:KEY=VALUE,KEY=VALUE")
        for key, goes_with, values, default in radio_keys(name):
            behind = f", with {goes_with}" if goes_with else ""
            say(f"  {key:<24}{default:<14}{values}{behind}")
        for preset, (about, settings) in PRESETS.get(name, {}).items():
            say(f"  preset={preset}: {about}")
            say(f"    {','.join(f'{key}={shown(value)}' for key, value in settings.items())}")


def _document(name: str) -> dict[str, object]:
    """The settings and presets of a radio as plain values."""
    presets = {one: made._asdict() for one, made in PRESETS.get(name, {}).items()}
    return {"settings": [one._asdict() for one in radio_keys(name)], "presets": presets}
