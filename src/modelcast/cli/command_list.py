"""The commands as ``modelcast --help`` lists them: by what one wants to do, a line each."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cyclopts.help import HelpPanel
    from rich.console import Console, ConsoleOptions

__all__ = ["COMMANDS", "COMMAND_GROUPS", "FIRST_STEPS", "list_commands"]

COMMAND_GROUPS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "Your trips": {
            "demo": "The main job on a generated drive: no data needed",
            "trips": "What is in a recording, and how good it is",
            "evaluate": "Message rates, tracking under loss, figures, a report",
            "compare": "Sub-models and rules side by side, with intervals",
            "train": "A profile of your own trips, for --bank",
            "profile": "What a profile holds, or how two differ",
            "coverage": "How often errors stay within what a sub-model says of itself",
            "reproduce": "The paper's evaluation under every choice that it leaves open",
            "convert": "Any format to one table",
            "ingest": "Months of trips to one corpus, for evaluate and compare",
            "road": "What earlier trips say of a road, as a file",
        },
        "Radio and fleets": {
            "network": "Fleets on a shared channel, as a closed loop",
            "capacity": "Up to how many vehicles a kilometre tracking holds",
            "mixed": "Fleets in which not everybody speaks the new language",
            "safety": "Warnings of the vehicle ahead, against perfect knowledge",
            "cruise": "Platoons that drive by what they hear",
            "serve": "Stations for another simulator, step by step",
        },
        "On the road": {
            "demo-live": "Four nodes on this machine, and the page of one of them",
            "node": "A station on the road, or a trip driven again",
            "view": "What a host believed, as a page in the browser",
            "replay": "A recorded node again, compared bit for bit",
            "prepare": "Compile beforehand what a node runs",
        },
        "Messages": {
            "decode": "A message, field by field",
            "encode": "A message from its fields",
            "credentials": "Certificates that a node signs with",
        },
        "Installation": {
            "doctor": "What is installed, what is missing, and what is broken",
        },
    }
)
"""The commands with a line each, by group; each is what has that name in the module of that name."""

COMMANDS = tuple(name for group in COMMAND_GROUPS.values() for name in group)
"""Names of the commands."""

FIRST_STEPS = """\
modelcast measures model-based V2X communication on recorded trips. To begin:

  modelcast demo                 a generated drive and its report, in out/demo
  modelcast trips FILE...        what is in your own recording, and how good it is
  modelcast evaluate FILE...     message rates, tracking under loss, figures, a report

All commands: modelcast --help. One of them: modelcast COMMAND --help."""
"""What ``modelcast`` alone prints."""


def list_commands(console: "Console", options: "ConsoleOptions", panel: "HelpPanel") -> None:
    """Print a group of commands with their lines, as cyclopts asks a formatter of help to.

    Parameters
    ----------
    console, options
        Where to, and how wide.
    panel
        The group; its commands have no texts yet, as none of their modules has been imported.
    """
    from cyclopts.help.formatters import DefaultFormatter

    lines = {name: line for group in COMMAND_GROUPS.values() for name, line in group.items()}
    entries = [entry.copy(description=lines[entry.names[0]]) for entry in panel.entries]
    DefaultFormatter()(console, options, panel.copy(entries=entries))
