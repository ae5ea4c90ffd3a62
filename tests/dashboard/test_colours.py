"""Claims: text and marks of the page stand out by day and at night (WCAG 2.2, 1.4.3 and 1.4.11)."""

from itertools import combinations

import pytest

TEXT, MARK = 4.5, 3.0
"""Least contrast of text, and of marks that carry meaning."""

FOR_PROTANS = (
    (0.152286, 1.052583, -0.204868),
    (0.114503, 0.786281, 0.099216),
    (-0.003882, -0.048116, 1.051998),
)
FOR_DEUTANS = (
    (0.367322, 0.860646, -0.227968),
    (0.280085, 0.672501, 0.047413),
    (-0.011820, 0.042940, 0.968881),
)
"""What is seen of linear red, green and blue (Machado et al. 2009, DOI 10.1109/TVCG.2009.113, severity 1)."""

Linear = tuple[float, ...]


def linear(colour: str) -> Linear:
    """Linear red, green and blue of an sRGB colour (IEC 61966-2-1)."""
    parts = [int(colour[at : at + 2], 16) / 255.0 for at in (1, 3, 5)]
    return tuple(one / 12.92 if one <= 0.04045 else ((one + 0.055) / 1.055) ** 2.4 for one in parts)


def contrast(one: str, other: str) -> float:
    """Contrast ratio of two colours."""
    light = [
        sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear(of), strict=True)) for of in (one, other)
    ]
    return (max(light) + 0.05) / (min(light) + 0.05)


def lab(rgb: Linear) -> Linear:
    """CIE L*a*b* of linear red, green and blue under D65."""
    rows = ((0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505))
    white = (0.9505, 1.0, 1.089)
    xyz = [sum(a * min(max(b, 0.0), 1.0) for a, b in zip(row, rgb, strict=True)) for row in rows]
    f = [
        t ** (1 / 3) if (t := v / w) > 0.008856 else 7.787 * t + 16 / 116
        for v, w in zip(xyz, white, strict=True)
    ]
    return 116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])


@pytest.mark.parametrize("theme", ["day", "night"])
def test_text_and_marks_stand_out(theme: str, themes: dict[str, dict[str, str]]) -> None:
    of = themes[theme]
    texts = [("ink", "paper"), ("soft", "paper"), ("ink", "field"), ("ink", "button"), ("paper", "accent")]
    texts += [("alarm", "alarm-paper"), ("caution", "caution-paper"), ("alarm", "paper")]
    for one, other in texts:
        assert contrast(of[one], of[other]) >= TEXT, (one, other)
    for mark in ("host", "alarm", "accent", *(f"m{at}" for at in range(8))):
        assert contrast(of[mark], of["field"]) >= MARK, mark


@pytest.mark.parametrize("theme", ["day", "night"])
@pytest.mark.parametrize("seen", [None, FOR_PROTANS, FOR_DEUTANS])
def test_the_first_five_sub_models_are_told_apart_with_impaired_colour_vision(
    theme: str, seen: tuple[Linear, ...] | None, themes: dict[str, dict[str, str]]
) -> None:
    """As a difference of L*a*b* (CIE 1976) of 10 at least, several times the least that is noticed."""
    of = themes[theme]
    for one, other in combinations(range(5), 2):
        parts: list[Linear] = []
        for at in (one, other):
            rgb = linear(of[f"m{at}"])
            if seen is not None:
                rgb = tuple(sum(a * b for a, b in zip(row, rgb, strict=True)) for row in seen)
            parts.append(lab(rgb))
        far = sum((a - b) ** 2 for a, b in zip(*parts, strict=True)) ** 0.5
        assert far >= 10.0, (one, other, far)
