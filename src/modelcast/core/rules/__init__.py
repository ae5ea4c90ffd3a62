"""What a value from outside must be: rules that say where it is wrong, what it is and what was expected.

A frozen dataclass states the rule of a field beside its type, ``samples: Annotated[int, Whole(3, 60)]``, and
calls `check_fields` once. So the same sentence holds for a caller in Python and for a file: a reader builds
the dataclass and puts the place of it before the field that `FieldError` names. Documents without a class of
their own have a rule for the whole (`Keys`, `Table`).

A boolean is no number, a text is no number, and a number is finite unless the rule says otherwise.
"""

from modelcast.core.rules.arrays import Each, Grid, Numbers
from modelcast.core.rules.base import AbstractRule, FieldError, is_clean, shown
from modelcast.core.rules.checking import check, check_fields
from modelcast.core.rules.documents import Keys, Table
from modelcast.core.rules.scalars import Anything, Fixed, Flag, Maybe, Number, One, Text, Whole

__all__ = [
    "AbstractRule",
    "Anything",
    "Each",
    "FieldError",
    "Fixed",
    "Flag",
    "Grid",
    "Keys",
    "Maybe",
    "Number",
    "Numbers",
    "One",
    "Table",
    "Text",
    "Whole",
    "check",
    "check_fields",
    "is_clean",
    "shown",
]
