"""The command line: its commands, its exit codes, and how errors are shown.

Exit codes: 0 done; 1 internal error (of doctor: something is broken; of replay: something differs); 2 usage,
bad input or no usable trip; 3 some trips failed, the rest is complete; 130 interrupted; 141 whoever read the
output stopped reading; 143 ended by SIGTERM.
"""

import os
import signal
import sys
import warnings
from collections.abc import Generator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

from cyclopts import App, CycloptsError, Group

from modelcast.cli.command_list import COMMAND_GROUPS, COMMANDS, FIRST_STEPS, list_commands
from modelcast.cli.signals import INTERRUPTED, TERMINATED, Terminated, heeded, taken
from modelcast.cli.terminal import complain, say
from modelcast.cli.usage import usage_problem
from modelcast.core.exceptions import ModelcastError, ModelcastWarning
from modelcast.core.refusals import refusal

__all__ = ["BROKEN_PIPE", "USAGE", "app", "run"]

USAGE = 2
BROKEN_PIPE = 141

_ATTENDED = frozenset(COMMANDS) - {"node", "serve", "demo-live", "view", "replay", "decode", "encode"}
"""Those whose progress is shown from beginning to end; the others run on, or are done at once."""


def _version() -> str:
    from modelcast.cli.installation import version_text

    return version_text()


app = App(
    name="modelcast",
    help="Model-based communication for V2X: message rates and tracking on real trips.",
    version=_version,
    exit_on_error=False,
    print_error=False,
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)
_OTHERS = Group("Options", sort_key=len(COMMAND_GROUPS))
for _place, (_title, _lines) in enumerate(COMMAND_GROUPS.items()):
    _group = Group(_title, sort_key=_place, help_formatter=list_commands)
    for _order, _name in enumerate(_lines):
        _module = _name.replace("-", "_")
        app.command(f"modelcast.cli.{_module}:{_module}", name=_name, group=_group, sort_key=_order)
app.register_install_completion_command(
    help="Complete commands and options in this shell by the tab key.", group=_OTHERS
)
for _flag in (*app.help_flags, *app.version_flags):
    app[_flag].group = _OTHERS


def run(arguments: Sequence[str]) -> int:
    """Run one command and return its exit code.

    Parameters
    ----------
    arguments
        The words after ``modelcast``.
    """
    _open_closed()
    try:
        code = _run(arguments)
    except KeyboardInterrupt as error:
        return _interrupted(error)
    except Exception as error:
        if taken() is None:
            raise
        return _interrupted(_made_of(error))
    return code if taken() is None else _interrupted(None)


def _run(arguments: Sequence[str]) -> int:
    """Run one command; an interrupt gets out."""
    try:
        with _warnings_told(), _attended(arguments):
            code = app(list(arguments)) if arguments else _tell_first_steps()
        sys.stdout.flush()
    except CycloptsError as error:
        complain(usage_problem(error, arguments))
        return USAGE
    except (BrokenPipeError, SystemExit) as error:
        # rich leaves with SystemExit where nobody reads what it prints.
        if isinstance(error, SystemExit) and not isinstance(error.__context__, BrokenPipeError):
            raise
        _drop_unprinted()
        return BROKEN_PIPE
    except (ModelcastError, OSError) as error:
        # Readers name their files themselves: what is left of OSError is a place that cannot be written.
        if taken() is not None:  # it is what a library has made of an interrupt
            raise
        complain(_place_and_reason(error) if isinstance(error, OSError) else error)
        _drop_unprinted()
        return USAGE
    return code if isinstance(code, int) else 0


def _tell_first_steps() -> int:
    """Say what to type first."""
    for line in FIRST_STEPS.splitlines():
        say(line)
    return 0


def _made_of(error: BaseException) -> KeyboardInterrupt:
    """The interrupt that an error was made of, whose notes say what is kept; a new one where it is lost."""
    step: BaseException | None = error
    while step is not None and not isinstance(step, KeyboardInterrupt):
        step = step.__cause__ or step.__context__
    return step or KeyboardInterrupt()


def _interrupted(error: BaseException | None) -> int:
    """Say that the command was interrupted, and what is left of its work: the notes of the exception."""
    heeded()
    terminated = isinstance(error, Terminated) or taken() == signal.SIGTERM
    complain(
        "; ".join(("ended by SIGTERM" if terminated else "interrupted", *getattr(error, "__notes__", ())))
    )
    return TERMINATED if terminated else INTERRUPTED


@contextmanager
def _warnings_told() -> Generator[None]:
    """Show modelcast's own warnings as problems are shown."""
    shown = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if issubclass(category, ModelcastWarning):
            complain(message)
        else:
            shown(message, category, *place, **more)

    warnings.showwarning = show
    try:
        yield
    finally:
        warnings.showwarning = shown


def _attended(arguments: Sequence[str]) -> AbstractContextManager[None]:
    """Show progress, where there is a command at work."""
    if not arguments or arguments[0] not in _ATTENDED or {"--help", "-h"} & set(arguments):
        return nullcontext()
    from modelcast.cli.board import attended

    return attended(quiet="--quiet" in arguments)


def _place_and_reason(error: OSError) -> str:
    return f"{error.filename}: {refusal(error)}" if error.filename else refusal(error)


def _open_closed() -> None:
    """Send nowhere what is printed where whoever started the process has closed the place (``>&-``)."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            setattr(sys, name, open(nowhere, "w", encoding="utf-8", closefd=False))  # noqa: SIM115


def _drop_unprinted() -> None:
    """Send what cannot be printed nowhere, so that the interpreter does not try again at its end."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
