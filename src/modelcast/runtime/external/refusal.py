"""What a session says to a request that it cannot serve."""

__all__ = ["FieldError"]

_SHOWN = 80


class FieldError(ValueError):
    """A field of a request is not what it must be; nothing of the request has been done.

    Parameters
    ----------
    field
        Its name.
    value
        What came, as text; a long one is cut.
    expected
        What was expected instead.

    Examples
    --------
    >>> print(FieldError("t_s", 0.1, "more than 0.2"))
    t_s must be more than 0.2, got 0.1
    """

    def __init__(self, field: str, value: object, expected: str) -> None:
        text = str(value)
        self.field, self.expected = field, expected
        self.value = text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
        super().__init__(f"{field} must be {expected}, got {self.value}")
