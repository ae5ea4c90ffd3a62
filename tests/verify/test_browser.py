"""Claims: the check of pages finds what it is for, and nothing on a page that is sound."""

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from .browser import VIEWS, faults

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.slow

SOUND = """<!doctype html><html lang="en"><head><title>A page</title>
<meta name="viewport" content="width=device-width, initial-scale=1">{head}</head>
<body><main><h1>A page</h1><p>Text. <button>Go on</button></p>{body}</main></body></html>"""


def _page(folder: Path, *, head: str = "", body: str = "") -> str:
    path = folder / "page.html"
    path.write_text(SOUND.format(head=head, body=body), encoding="utf-8")
    return path.as_uri()


def test_a_sound_page_has_no_fault(browser: "Browser", tmp_path: Path) -> None:
    for view in VIEWS:
        assert faults(browser, _page(tmp_path), view) == []


@pytest.mark.parametrize(
    ("head", "body", "said"),
    [
        ("", "<script>console.error('no map')</script>", "console: no map"),
        ("", "<script>missing()</script>", "script: missing is not defined"),
        ("", '<img src="absent.png" alt="Gone">', "request failed"),
        ("", '<img src="http://127.0.0.1:9/a.png" alt="Far">', "asks http://127.0.0.1:9/a.png"),
        ("", '<div style="width: 2000px">Wide.</div>', 'wider than the window: div "Wide."'),
        ("", '<p style="color: #aaa; background: #fff">Faint.</p>', "axe color-contrast"),
        ("", "<button></button>", "axe button-name"),
        ("<style>button { outline: none }</style>", "", 'focus on button "Go on" does not show'),
        (
            "<script>addEventListener('keydown', (e) => e.key === 'Tab' && e.preventDefault())</script>",
            "",
            'Tab never reaches button "Go on"',
        ),
    ],
)
def test_a_fault_is_told(browser: "Browser", tmp_path: Path, head: str, body: str, said: str) -> None:
    found = faults(browser, _page(tmp_path, head=head, body=body), VIEWS[2])
    assert any(line.startswith(said) for line in found), found
