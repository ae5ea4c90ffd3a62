"""What every result that a Python user gets can do: show itself, write its tables, write its report."""

from abc import ABC, abstractmethod
from pathlib import Path

import polars as pl

from modelcast.io.frames import frame_html
from modelcast.io.output import written_into

__all__ = ["AbstractFrames"]


class AbstractFrames(ABC):
    """A result as data frames, figures and files."""

    @property
    @abstractmethod
    def scope(self) -> str:
        """What was run, in one line."""

    @property
    @abstractmethod
    def headline(self) -> pl.DataFrame:
        """The frame that a notebook shows."""

    @abstractmethod
    def _write(self, folder: Path) -> list[Path]:
        """Write the tables into an existing folder."""

    @abstractmethod
    def _report(self, folder: Path) -> list[Path]:
        """Write the report into an existing folder."""

    def write(self, folder: str | Path) -> list[Path]:
        """Write the tables as files and return their paths.

        Parameters
        ----------
        folder
            Made where it is missing; other files in it stay.

        Raises
        ------
        ConfigError
            Where the folder cannot be made or written into.
        """
        return written_into(folder, self._write)

    def report(self, folder: str | Path) -> list[Path]:
        """Write the report and its figures and return their paths.

        Parameters
        ----------
        folder
            Made where it is missing; other files in it stay.

        Raises
        ------
        ConfigError
            Where the folder cannot be made or written into.
        """
        return written_into(folder, self._report)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.scope})"

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        return frame_html(repr(self), self.headline)
