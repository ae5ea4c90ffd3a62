"""Whether the packages of an extra are there, asked before anything is done that needs them."""

from importlib.util import find_spec

from modelcast.core.exceptions import MissingExtraError
from modelcast.core.extras import EXTRAS

__all__ = ["require_installed"]


def require_installed(what: str, extra: str) -> None:
    """Refuse what cannot be done; nothing is imported.

    Parameters
    ----------
    what
        What the user asked for.
    extra
        The extra that brings it.

    Raises
    ------
    MissingExtraError
        Where one of its modules is not installed.
    """
    if not all(find_spec(module) for module in EXTRAS[extra].packages.values()):
        raise MissingExtraError(what, extra)
