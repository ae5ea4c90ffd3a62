"""``modelcast doctor``: what is installed, what it runs on, and what is broken."""

from collections.abc import Mapping
from typing import Any

__all__ = ["doctor"]


def doctor(*, json: bool = False) -> int:
    """Show versions, processor, compiled code, extras, what other packages bring, and what is broken.

    For example: `modelcast doctor`

    Ends with code 0 where all is well, with 1 where something is broken; its remedy is shown.

    Parameters
    ----------
    json
        Print one JSON document instead of lines.
    """
    from modelcast.cli.diagnosis import diagnose
    from modelcast.cli.progress import busy
    from modelcast.cli.terminal import say, say_json

    with busy("looking", quiet=json):
        document, problems = diagnose()
    if json:
        say_json(document)
        return 1 if problems else 0
    for name, words in _lines(document):
        say(f"{name:<12} {words}")
    for one in problems:
        say(f"{'broken':<12} {one.what}: {one.remedy}")
    if not problems:
        say("all is well")
    return 1 if problems else 0


def _lines(document: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What was found, a line each."""
    base, processor, cache = document["modelcast"], document["processor"], document["cache"]
    terminal, packages = document["terminal"], document["packages"]
    lines = [
        ("modelcast", f"{base['version']} in {base['place']}"),
        ("Python", f"{base['python']}, {base['interpreter']}, {base['system']}"),
        ("packages", ", ".join(f"{name} {found or 'missing'}" for name, found in packages.items())),
        ("processor", f"{processor['name'] or processor['machine']}, {processor['cores']} cores"),
        ("", " ".join(processor["features"]) or "features unknown"),
    ]
    if cache is not None:
        state = "writable" if cache["writable"] else "cannot be written to"
        lines.append(("cache", f"{cache['place']}, {cache['size_bytes'] / 1e6:.1f} MB, {state}"))
    for name, extra in document["extras"].items():
        state = "present" if extra["present"] else f"missing: {extra['install']}"
        lines.append((f"extra {name}", f"{state}; needed by {extra['needed_by']}"))
    lines += [
        (
            "brought" if not number else "",
            f"{one['group'].removeprefix('modelcast.')} {one['name']}, by {one['package']} {one['version']}",
        )
        for number, one in enumerate(document["brought"])
    ]
    lines += [(name, value) for name, value in document["variables"].items() if value is not None]
    kind = "a terminal" if terminal["terminal"] else "no terminal"
    lines.append(("output", f"{kind}, {terminal['encoding']}"))
    return lines
