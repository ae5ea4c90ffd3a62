"""Entry point of the ``modelcast`` command."""

import sys

__all__ = ["main"]


def main() -> None:
    """Run the command line and leave with its exit code."""
    from modelcast.cli.app import run  # noqa: PLC0415 - importing this module must stay cheap

    sys.exit(run(sys.argv[1:]))


if __name__ == "__main__":
    main()
