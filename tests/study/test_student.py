"""Claims about Student's t: it is that of SciPy, and what is no probability is refused."""

import pytest
from scipy import special

from modelcast.study.student import student_reach

TOLERANCE = 1e-12  # relative; a sum of as many rounded terms as half the degrees of freedom


@pytest.mark.parametrize("within", [0.5, 0.95, 0.999])
@pytest.mark.parametrize("degrees", [1, 2, 3, 4, 7, 30, 101, 1000, 9999])
def test_it_is_the_quantile_of_student(degrees: int, within: float) -> None:
    expected = float(special.stdtrit(degrees, 0.5 + 0.5 * within))
    assert student_reach(degrees, within) == pytest.approx(expected, rel=TOLERANCE)


@pytest.mark.parametrize(("degrees", "within"), [(0, 0.95), (3, 0.0), (3, 1.0)])
def test_what_has_no_quantile_is_refused(degrees: int, within: float) -> None:
    with pytest.raises(ValueError, match="degrees must be at least 1"):
        student_reach(degrees, within)
