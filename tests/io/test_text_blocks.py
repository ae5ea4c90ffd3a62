"""Text read as numbers at once gives what text read cell by cell gives."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import DataFormatError
from modelcast.io.text_blocks import number_column, read_blocks, text_column

NUMBERS = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.integers(-(10**20), 10**20).map(str),
    st.decimals(-1000, 1000, places=7).map(str),
    st.decimals(-1000, 1000, places=7).map("{:E}".format),
)
CELLS = st.one_of(
    NUMBERS,
    st.sampled_from(
        ["", "NULL", "nan", "inf", "-Infinity", '"1.5"', " 2 ", "\t3", "1e400", "+7", ".5", "6."]
    ),
    st.text("0123456789+-.eE_xnaifNUL ", max_size=8),
)


def numbers_of(path: Path, *, at_once: bool) -> list[float | str]:
    """What a column holds, or the error that it is."""
    asked = (1,) if at_once else ()
    try:
        blocks = read_blocks(str(path), counts=[3], fields=[0, 1], skip_lines=0, numbers=asked)
        return [
            value.hex() for block in blocks for value in number_column(str(path), block, 1, "speed").tolist()
        ]
    except DataFormatError as error:
        return [str(error)]


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(cells=st.lists(CELLS, min_size=1, max_size=6))
@example(cells=["1.7976931348623157e308", "5e-324", "-0.0", "0.1", "123456789012345678"])
@example(cells=["1", "two"])
def test_numbers_are_the_same_to_the_bit_and_errors_too(tmp_path: Path, cells: list[str]):
    path = tmp_path / "table.csv"
    path.write_text("".join(f"a,{cell},z\n" for cell in cells))
    assert numbers_of(path, at_once=True) == numbers_of(path, at_once=False)


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(cells=st.lists(NUMBERS, min_size=1, max_size=6))
def test_numbers_are_those_of_python(tmp_path: Path, cells: list[str]):
    path = tmp_path / "table.csv"
    path.write_text("".join(f"a,{cell},z\n" for cell in cells))
    wanted = [float(cell) for cell in cells]
    if all(abs(value) <= 1e18 for value in wanted):
        assert numbers_of(path, at_once=True) == [value.hex() for value in wanted]


@pytest.mark.parametrize(("cell", "plain"), [("x", True), ('"x"', False), (" x", False), ("x\t", False)])
def test_text_is_stripped_whichever_way_it_is_read(tmp_path: Path, cell: str, plain: bool):
    path = tmp_path / "table.csv"
    path.write_text(f"{cell},1,z\n,2,z\nNULL,3,z\n")
    (block,) = read_blocks(str(path), counts=[3], fields=[0, 1], skip_lines=0, numbers=[1])
    assert block.plain == plain
    assert text_column(block, 0).to_list() == ["x", None, None]
    assert number_column(str(path), block, 1, "speed").tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("more", [1, 256, 257, 512, 1000])
def test_lines_of_very_many_fields_are_counted(tmp_path: Path, more: int):
    path = tmp_path / "table.csv"
    path.write_text("1,2,3\n4,5,6" + "," * more + "\n7,8,9\n")
    with pytest.raises(DataFormatError, match=f"row 2: {3 + more} fields where the format has 3"):
        list(read_blocks(str(path), counts=[3], fields=[0], skip_lines=0))
    path.write_text("1," + "," * more + "\n" + "2," + "," * more + "\n")
    (block,) = read_blocks(str(path), counts=[2 + more], fields=[0], skip_lines=0, numbers=[0])
    assert np.array_equal(number_column(str(path), block, 0, "x"), [1.0, 2.0])
