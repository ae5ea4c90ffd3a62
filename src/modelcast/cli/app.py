"""The command line: its commands, its exit codes, and how errors are shown.

Exit codes: 0 done; 1 internal error; 2 usage, bad input or no usable trip; 3 some trips failed, the rest is
complete; 130 interrupted.
"""

from collections.abc import Sequence

from cyclopts import App, CycloptsError

from modelcast.cli.compare import compare
from modelcast.cli.convert import convert
from modelcast.cli.coverage import coverage
from modelcast.cli.decode import decode
from modelcast.cli.demo import demo
from modelcast.cli.encode import encode
from modelcast.cli.evaluate import evaluate
from modelcast.cli.network import network
from modelcast.cli.terminal import complain, refused
from modelcast.cli.train import train
from modelcast.cli.trips import trips
from modelcast.core.exceptions import ModelcastError

__all__ = ["INTERRUPTED", "USAGE", "run"]

USAGE = 2
INTERRUPTED = 130


def _version() -> str:
    from modelcast.core.version import package_version

    return package_version()


app = App(
    name="modelcast",
    help="Model-based communication for V2X: message rates and tracking on real trips.",
    version=_version,
    exit_on_error=False,
    print_error=True,
    error_formatter=refused,
    result_action="return_value",
)
app.command(demo)
app.command(evaluate)
app.command(compare)
app.command(trips)
app.command(convert)
app.command(coverage)
app.command(network)
app.command(train)
app.command(decode)
app.command(encode)


def run(arguments: Sequence[str]) -> int:
    """Run one command and return its exit code.

    Parameters
    ----------
    arguments
        The words after ``modelcast``.
    """
    try:
        code = app(list(arguments))
    except CycloptsError:
        return USAGE  # already shown, with the usage
    except ModelcastError as error:
        complain(error)
        return USAGE
    except OSError as error:
        # Readers name their files themselves: what is left is a place that cannot be written.
        complain(f"{error.filename or 'a file'}: {error.strerror or error}")
        return USAGE
    except KeyboardInterrupt:
        complain("interrupted; nothing was written")
        return INTERRUPTED
    return code if isinstance(code, int) else 0
