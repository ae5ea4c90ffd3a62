"""Finished runs of a network evaluation on disk, so that a later call takes them up again.

``<case>-<key>.json`` holds one run: ``schema``, ``modelcast`` (version), ``inputs`` (a hash of every file
that it read), ``options``, and its rows. The key is a hash of version and inputs: a run of another version,
or of a changed file, has another name and is never taken up. What is read back is checked field by field
before it is used, for the folder may come from anywhere.
"""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast
from urllib.parse import quote

from modelcast.core.exceptions import ConfigError
from modelcast.io.documents import plain_value
from modelcast.io.run_store import AbstractRunFiles, write_run_file, written_inputs
from modelcast.study.network.mixed import mixed_of
from modelcast.study.network.rows import CASE_KEYS, CASE_TABLES, RUNS, CaseResult, NetworkCase
from modelcast.study.table import Column, Row, TableSchema

__all__ = ["RUN_SCHEMA", "NetworkRunFiles", "RunKey", "case_name", "read_case", "run_path", "write_case"]

RUN_SCHEMA = 9
"""Version of the layout of a run's file; since 2 it holds version and inputs, since 3 the bank, since 4 the
threshold, since 5 the rows of mixed fleets, since 6 those of warnings, since 7 relative errors, since 8
those of roadside units, since 9 those of people."""

_LARGEST_BYTES = 64 * 2**20
_MOST_ROWS = 1_000_000
_LARGEST = 1e15
_ANY_SIGN = frozenset({"dBm"})
"""Units of numbers that may be negative."""


@dataclass(frozen=True, slots=True)
class RunKey:
    """What a run's rows depend on beside its options.

    Parameters
    ----------
    version
        Of modelcast.
    inputs
        A hash or version of all that the run reads, by name.
    banks
        A hash of the file of each bank that is one, by the bank's name: runs of other banks do not read it.
    foreign
        Package and version of radios and policies that other packages bring, by what they are and their word,
        as ``radio two-ray``: they count in runs of theirs alone.
    sub_models
        The same of the sub-models of each bank, by the bank's name: runs of other banks do not use them.
    """

    version: str
    inputs: Mapping[str, str]
    banks: Mapping[str, str] = field(default_factory=dict[str, str])
    foreign: Mapping[str, str] = field(default_factory=dict[str, str])
    sub_models: Mapping[str, Mapping[str, str]] = field(default_factory=dict[str, Mapping[str, str]])

    @property
    def all_inputs(self) -> dict[str, str]:
        """The inputs, the files of the banks and what other packages bring, by name."""
        return {
            **self.inputs,
            **{f"bank {name}": found for name, found in self.banks.items()},
            **self.foreign,
            **{name: found for one in self.sub_models.values() for name, found in one.items()},
        }

    def of(self, case: NetworkCase) -> "RunKey":
        """The key of one run.

        Parameters
        ----------
        case
            The run.
        """
        banks = {name: found for name, found in self.banks.items() if name == case.bank}
        taking = {f"radio {case.radio}", *(f"policy {one}" for one in mixed_of(case.policy).senders)}
        foreign = {name: found for name, found in self.foreign.items() if name in taking}
        sub_models = {name: found for name, found in self.sub_models.items() if name == case.bank}
        return replace(self, banks=banks, foreign=foreign, sub_models=sub_models)

    @property
    def short(self) -> str:
        """The key as file names hold it."""
        text = json.dumps([RUN_SCHEMA, self.version, sorted(self.all_inputs.items())])
        return hashlib.sha256(text.encode()).hexdigest()[:12]


def case_name(case: NetworkCase) -> str:
    """Name of a run, which is one part of a path whatever the user's words hold.

    Parameters
    ----------
    case
        The run.

    Examples
    --------
    >>> case_name(NetworkCase(100.0, "dsrc", "mbc", "paper", 3))
    'dsrc_mbc_paper_100_3'
    >>> case_name(NetworkCase(100.0, "dsrc", "mbc", "paper", 3, threshold_m=0.2))
    'dsrc_mbc_paper_0.2m_100_3'
    >>> case_name(NetworkCase(100.0, "disc:range_m=300", "cam", "none", 3))
    'disc%3Arange_m=300_cam_none_100_3'
    >>> case_name(NetworkCase(100.0, "dsrc", "mbc", "near:table=a/b+cv", 3))
    'dsrc_mbc_near%3Atable=a%2Fb+cv_100_3'
    """
    density = f"{case.density_per_km:g}" if math.isfinite(case.density_per_km) else "own"
    threshold = f"_{case.threshold_m:g}m" if math.isfinite(case.threshold_m) else ""
    radio, policy, bank = (quote(word, safe="+@,=") for word in (case.radio, case.policy, case.bank))
    return f"{radio}_{policy}_{bank}{threshold}_{density}_{case.run}"


def run_path(case: NetworkCase, key: RunKey, folder: Path) -> Path:
    """Return where a run's rows are.

    Parameters
    ----------
    case, key, folder
        As for `write_case`.
    """
    return folder / f"{case_name(case)}-{key.of(case).short}.json"


def write_case(
    result: CaseResult, case: NetworkCase, options: Mapping[str, Any], key: RunKey, folder: Path
) -> Path:
    """Write one run's rows; the file appears whole or not at all.

    Parameters
    ----------
    result
        The rows.
    case
        The run.
    options
        What it was run with, as plain values: only a call with the same takes it up again.
    key
        What else its rows depend on.
    folder
        An existing folder.
    """
    document = {
        "schema": RUN_SCHEMA,
        "modelcast": key.version,
        "inputs": key.of(case).all_inputs,
        "options": dict(options),
        "run": [result.run.plain()],
        **{name: [row.plain() for row in getattr(result, name)] for name in CASE_TABLES},
    }
    path = run_path(case, key, folder)
    write_run_file(document, path)
    return path


def read_case(case: NetworkCase, options: Mapping[str, Any], key: RunKey, folder: Path) -> CaseResult | None:
    """Rows of a run that is done already, None where it is not.

    Parameters
    ----------
    case, options, key, folder
        As for `write_case`.

    Raises
    ------
    ConfigError
        Where the file is of a run with other options, or not such a file; it names file and field.
    """
    path = run_path(case, key, folder)
    if not path.is_file():
        return None
    document = _document(path)
    known, asked = document["options"], plain_value(dict(options))
    if not isinstance(known, dict):
        raise _refused(path, "options", "a mapping")
    if known != asked:
        given = cast("dict[str, Any]", known)
        changed = sorted(name for name in {*given, *asked} if given.get(name) != asked.get(name))
        raise ConfigError(
            f"{path} was run with other options ({', '.join(changed)}): name another output folder"
        )
    if document["modelcast"] != key.version or document["inputs"] != key.of(case).all_inputs:
        raise _refused(path, "inputs", "those of its name")
    runs = _rows(path, "run", RUNS, document["run"], case)
    if len(runs) != 1:
        raise _refused(path, "run", "one row")
    tables = {name: _rows(path, name, schema, document[name], case) for name, schema in CASE_TABLES.items()}
    return CaseResult(runs[0], **tables)


@dataclass(frozen=True, slots=True)
class NetworkRunFiles(AbstractRunFiles[NetworkCase, CaseResult]):
    """Runs of ``modelcast network``.

    Parameters
    ----------
    options, key
        As for `write_case`.
    """

    options: Mapping[str, Any]
    key: RunKey

    def path(self, case: NetworkCase, folder: Path) -> Path:
        """As `run_path`."""
        return run_path(case, self.key, folder)

    def read(self, case: NetworkCase, folder: Path) -> CaseResult | None:
        """As `read_case`."""
        return read_case(case, self.options, self.key, folder)

    def inputs(self, case: NetworkCase) -> Mapping[str, str]:
        """The version of modelcast, and `RunKey.all_inputs` of the run."""
        return {"modelcast": self.key.version, **self.key.of(case).all_inputs}

    def inputs_in(self, path: Path) -> Mapping[str, str]:
        """As `inputs`."""
        document = _document(path)
        return written_inputs(path, document["modelcast"], document["inputs"])

    def write(self, case: NetworkCase, result: CaseResult, folder: Path) -> None:
        """As `write_case`."""
        _ = write_case(result, case, self.options, self.key, folder)


def _refused(path: Path, field: str, expected: str) -> ConfigError:
    return ConfigError(f"{path} is not a run of modelcast network: {field} must be {expected}: remove it")


def _document(path: Path) -> dict[str, Any]:
    """Return the content of a run's file, a mapping of all its fields."""
    try:
        if path.stat().st_size > _LARGEST_BYTES:
            raise _refused(path, "the file", f"at most {_LARGEST_BYTES} bytes")
        document: object = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path} cannot be read: {error.strerror or error}") from error
    except (ValueError, RecursionError, MemoryError) as error:
        raise _refused(path, "the file", f"JSON ({type(error).__name__})") from error
    needed = {"schema", "modelcast", "inputs", "options", "run", *CASE_TABLES}
    if not isinstance(document, dict) or set(cast("dict[str, Any]", document)) != needed:
        raise _refused(path, "the file", f"a mapping of {', '.join(sorted(needed))}")
    found = cast("dict[str, Any]", document)
    if type(found["schema"]) is not int or found["schema"] != RUN_SCHEMA:
        raise _refused(path, "schema", str(RUN_SCHEMA))
    return found


def _rows(path: Path, name: str, schema: TableSchema, rows: object, case: NetworkCase) -> tuple[Row, ...]:
    """Return checked rows; null is a number that does not exist."""
    if not isinstance(rows, list) or len(cast("list[Any]", rows)) > _MOST_ROWS:
        raise _refused(path, name, f"a list of at most {_MOST_ROWS} rows")
    own = plain_value(case.values())
    found: list[Row] = []
    for number, row in enumerate(cast("Sequence[object]", rows)):
        place = f"{name}[{number}]"
        if not isinstance(row, dict) or set(cast("dict[str, Any]", row)) != set(schema.names):
            raise _refused(path, place, f"a mapping of {', '.join(schema.names)}")
        given = cast("dict[str, Any]", row)
        values = {
            column.name: _value(path, f"{place}.{column.name}", given[column.name], column)
            for column in schema.columns
        }
        for key in CASE_KEYS:
            if given[key] != own[key]:
                raise _refused(path, f"{place}.{key}", repr(own[key]))
        found.append(schema.row(**values))
    return tuple(found)


def _value(path: Path, place: str, value: object, column: Column) -> Any:
    """Return one checked value of a row."""
    if column.kind == "text":
        if not isinstance(value, str):
            raise _refused(path, place, "a text")
        return value
    if column.kind == "count":
        if type(value) is not int or not 0 <= value < 2**63:
            raise _refused(path, place, "a whole number, not negative")
        return value
    if value is None:
        return math.nan
    low = -_LARGEST if column.unit in _ANY_SIGN else 0.0
    high = 1.0 if column.kind == "ratio" else _LARGEST
    if type(value) not in {int, float} or not low <= cast("float", value) <= high + 1e-9:
        raise _refused(path, place, f"a number from {low:g} to {high:g}")
    return float(cast("float", value))
