"""Claims: a figure in a page is that of its file, to a hundredth of a point, whatever names it shows."""

import io
import re
from urllib.parse import unquote
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from modelcast.report.figures.files import drawn
from modelcast.report.style import new_figure, style
from modelcast.report.svg_address import svg_address

HUNDREDTH_PT = 0.0051
NAME = """O'Brien's "car" <1> & co -- 100 % #7 -->"""


@pytest.fixture(scope="module")
def svg() -> bytes:
    """A figure with lines, markers, and a name of all that is special somewhere."""
    with style():
        figure = new_figure(3.5, 2.0)
        axes = figure.subplots()
        axes.plot(np.linspace(0.0, 3.0, 50), np.sin(np.linspace(0.0, 3.0, 50)), "o-")
        axes.set_title(NAME)
        return drawn("made", figure).svg


def _elements(text: str) -> list[ET.Element]:
    """Elements in order, without what is never seen."""
    tree = ET.parse(io.StringIO(text)).getroot()  # noqa: S314 - our own
    return [one for one in tree.iter() if "www.w3.org/2000/svg" in one.tag and "metadata" not in one.tag]


def test_it_holds_the_same_elements_at_the_same_places(svg: bytes) -> None:
    own, shown = _elements(svg.decode()), _elements(unquote(svg_address(svg).partition(",")[2]))
    assert [one.tag for one in own] == [one.tag for one in shown]
    for one, other in zip(own, shown, strict=True):
        assert set(one.attrib) == set(other.attrib)
        for name, value in one.attrib.items():
            if name not in {"d", "x", "y"}:
                assert other.attrib[name] == value.replace("\n", " ").strip()
                continue
            numbers = [
                [float(item) for item in re.findall(r"-?\d+(?:\.\d+)?", text)]
                for text in (value, other.attrib[name])
            ]
            np.testing.assert_allclose(*numbers, atol=HUNDREDTH_PT)


def test_nothing_in_it_ends_an_attribute_or_begins_markup(svg: bytes) -> None:
    assert not set('"<>&#\n') & set(svg_address(svg))
    assert len(svg_address(svg)) < 1.33 * len(svg)
