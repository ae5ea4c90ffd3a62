"""Entry point of the ``modelcast`` command."""

import sys

__all__ = ["main"]


def main() -> None:
    """Run the command line and leave with its exit code."""
    # Importing this module must stay cheap.
    try:
        from modelcast.cli import signals  # noqa: PLC0415
    except KeyboardInterrupt:
        sys.stderr.write("modelcast: interrupted\n")
        sys.exit(130)
    try:
        signals.install()
        from modelcast.cli.app import run  # noqa: PLC0415

        code = run(sys.argv[1:])
    except KeyboardInterrupt as error:  # while importing
        terminated = isinstance(error, signals.Terminated)
        sys.stderr.write(f"modelcast: {'ended by SIGTERM' if terminated else 'interrupted'}\n")
        code = signals.TERMINATED if terminated else signals.INTERRUPTED
    signals.finish()
    sys.exit(code)


if __name__ == "__main__":
    main()
