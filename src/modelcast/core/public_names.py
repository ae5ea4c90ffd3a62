"""What the package says of itself: its public names by subject, a line each, from where they are defined.

Nothing is imported for it: the source is read.
"""

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType

__all__ = ["PublicPackage", "names_by_subject", "summary_of"]

_PACKAGE = Path(__file__).parents[1]
_SUBJECTS = {
    "interface": "Trips in, results out",
    "study": "Studies",
    "trips": "Trips",
    "io": "Files",
    "report": "Tables and figures",
    "models": "Sub-models",
    "station": "Stations, policies and receivers",
    "channel": "Channels",
    "messages": "Messages",
    "apps": "Applications",
    "world": "Traffic and sensors",
    "runtime": "Fleets",
    "node": "Nodes",
    "dashboard": "Live page",
    "core": "Errors and kinds",
}
"""Headings by the layer that defines a name, in the order in which a user meets them."""


class PublicPackage(ModuleType):
    """A package that imports its names on first use, as ``_HOMES`` says, and lists them in its docstring."""

    @property
    def __doc__(self) -> str:  # pyright: ignore[reportIncompatibleVariableOverride]
        """The text of the package, then its public names."""
        homes: Mapping[str, str] = self.__dict__["_HOMES"]
        return "\n".join([self.__dict__["__doc__"] or "", *_listing(homes)])


def names_by_subject(homes: Mapping[str, str]) -> Iterator[tuple[str, list[str]]]:
    """Yield each subject and its names by the alphabet, subjects in the order in which a user meets them.

    Parameters
    ----------
    homes
        The module that defines each name, without ``modelcast.``.

    Raises
    ------
    LookupError
        Where a name's layer has no subject.

    Examples
    --------
    >>> list(names_by_subject({"Nr": "channel.nr", "Dsrc": "channel.dsrc", "Trips": "io.trips"}))
    [('Files', ['Trips']), ('Channels', ['Dsrc', 'Nr'])]
    """
    layers = {name: home.partition(".")[0] for name, home in homes.items()}
    for name, layer in layers.items():
        if layer not in _SUBJECTS:
            raise LookupError(f"{name} is of {layer}, which has no subject; known are {', '.join(_SUBJECTS)}")
    for layer, subject in _SUBJECTS.items():
        names = sorted(name for name, own in layers.items() if own == layer)
        if names:
            yield subject, names


def summary_of(name: str, home: str) -> str:
    """Return the first line of a name's docstring.

    Parameters
    ----------
    name
        A class, a function, or a constant with a docstring below it.
    home
        The module that defines it, without ``modelcast.``.

    Raises
    ------
    LookupError
        Where the module does not define it, or it has no docstring.

    Examples
    --------
    >>> summary_of("ConfigError", "core.exceptions")
    'Options that do not fit together, or that no trip can satisfy.'
    """
    source = _PACKAGE.joinpath(*home.split(".")).with_suffix(".py")
    body = ast.parse(source.read_text(encoding="utf-8")).body
    for node, follows in zip(body, [*body[1:], None], strict=True):
        text = _text(node, follows, name)
        if text:
            return text.strip().partition("\n")[0]
    raise LookupError(f"modelcast.{home} defines no {name} with a docstring")


def _text(node: ast.stmt, follows: ast.stmt | None, name: str) -> str | None:
    """The docstring that a statement gives a name; None where it gives none."""
    if isinstance(node, ast.ClassDef | ast.FunctionDef) and node.name == name:
        return ast.get_docstring(node)
    targets = node.targets if isinstance(node, ast.Assign) else []
    targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
    if not any(isinstance(target, ast.Name) and target.id == name for target in targets):
        return None
    if isinstance(follows, ast.Expr) and isinstance(follows.value, ast.Constant):
        return str(follows.value.value)
    return None


def _listing(homes: Mapping[str, str]) -> Iterator[str]:
    """The lines of the list."""
    width = max(map(len, homes))
    for subject, names in names_by_subject(homes):
        yield from (subject, "-" * len(subject))
        yield from (f"{name:{width}}  {summary_of(name, homes[name])}" for name in names)
        yield ""
