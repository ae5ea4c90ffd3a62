"""What to say of a file that could not be read."""

from modelcast.core.exceptions import DataFormatError, ModelcastError

__all__ = ["failure_reason"]


def failure_reason(error: BaseException, *, memory_bytes: int | None = None) -> str:
    """Return why a file gave no trips, in words, without its name.

    Parameters
    ----------
    error
        What its reader raised.
    memory_bytes
        What the process might take; None where only the machine bounds it.

    Examples
    --------
    >>> failure_reason(DataFormatError("a.csv", "speed is 'x', not a number", row=3, remedy="Correct it."))
    "row 3: speed is 'x', not a number. Correct it."
    """
    if isinstance(error, DataFormatError):
        place = "" if error.row is None else f"row {error.row}: "
        return f"{place}{error.problem}. {error.remedy}".strip()
    if isinstance(error, ModelcastError):
        return str(error)
    if isinstance(error, MemoryError) and memory_bytes is not None:
        return (
            f"takes more than the {memory_bytes / 2**20:,.0f} MiB that --memory gives a process "
            "(MemoryError). Give more, take fewer --jobs, or split it."
        )
    if isinstance(error, MemoryError):
        return "is too large for this machine's memory (MemoryError). Split it, or take a larger machine."
    return f"its reader failed with {type(error).__name__}: {error}. Please report this with the file."
