"""``modelcast profile``: what a profile holds, and what has changed between two."""

from pathlib import Path

from cyclopts import App

__all__ = ["profile"]

profile = App(
    name="profile",
    help="Show what a profile holds, or what has changed between two.\n\n"
    "For example: `modelcast profile show mine.json`",
)


@profile.command
def show(name: Path = Path("default"), /, *, json: bool = False) -> int:
    """Show a profile: its sub-models with their horizons and sizes on the wire, and its training record.

    For example: `modelcast profile show mine.json`

    Parameters
    ----------
    name
        A file that `modelcast train` wrote, or a profile that ships with modelcast: default or people.
    json
        Print one JSON document instead of tables.
    """
    from modelcast.cli.banks import profile_in_use
    from modelcast.cli.terminal import say_json
    from modelcast.cli.terminal import show as show_tables
    from modelcast.report.profile import profile_document, profile_report

    found = profile_in_use(name)
    if json:
        say_json(profile_document(found))
    else:
        show_tables(*profile_report(found, str(name)))
    return 0


@profile.command
def diff(first: Path, second: Path, /, *, json: bool = False) -> int:
    """Show where two profiles differ: members, their numbers, rules, calibrations, training.

    For example: `modelcast profile diff mine.json default`

    The exit code is 0 whether or not they do.

    Parameters
    ----------
    first, second
        Files that `modelcast train` wrote, or default or people, the profiles that ship with modelcast.
    json
        Print one JSON document instead of a table.
    """
    from dataclasses import asdict

    from modelcast.cli.banks import profile_in_use
    from modelcast.cli.terminal import say_json
    from modelcast.cli.terminal import show as show_tables
    from modelcast.report.profile import difference_table, profile_differences

    found = profile_differences(profile_in_use(first), profile_in_use(second))
    if json:
        say_json([asdict(one) for one in found], sort=False)
    else:
        show_tables(difference_table(found, (str(first), str(second))))
    return 0
