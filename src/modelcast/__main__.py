"""Entry point of the ``modelcast`` command."""

import sys

__all__ = ["main"]


def main() -> None:
    """Run the command line and leave with its exit code."""
    try:
        from modelcast.cli.app import run  # noqa: PLC0415 - importing this module must stay cheap

        code = run(sys.argv[1:])
    except KeyboardInterrupt:  # while importing, or a second one while cleaning up
        sys.stderr.write("modelcast: interrupted\n")
        code = 130
    sys.exit(code)


if __name__ == "__main__":
    main()
