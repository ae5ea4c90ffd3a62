"""What a browser finds wrong with a page: errors, requests, width, axe's rules, and what the keyboard misses.

`faults` is the check; `VIEWS` is what it is asked for. A page passes where the list is empty in every view.
What it does not see: whether a picture is right, contrast on a canvas, and pages behind a link.
"""

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))
from chromium import chromium

sys.path.pop(0)

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

__all__ = ["VIEWS", "View", "faults", "opened_browser", "opened_page"]

PATIENCE_MS = 120_000
"""After which a page that does not show what it should has failed."""

_MORE_TABS = 30
"""Stops of the Tab key beyond the controls of a page, as of boxes that scroll."""

_MOST_LEFT = 2
"""Times the focus may leave the page: at its end, and where nothing on it had the focus first."""

_SHOWN_FAULTS = 5
"""Places that a fault is told for."""

_MORE_RULES = (
    "hidden-content",
    "identical-links-same-purpose",
    "label-content-name-mismatch",
    "meta-refresh-no-exceptions",
    "p-as-heading",
    "table-fake-caption",
    "target-size",
    "td-has-header",
)
"""What axe does not look at by itself, being of level AAA, new or experimental."""

_AXE_OPTIONS = {
    "resultTypes": ["violations"],
    "rules": {name: {"enabled": True} for name in _MORE_RULES},
    "preload": False,
}
"""All rules that axe runs by itself, best practice among them, and all others but four kinds.

Left out are what axe has given up; a contrast of 7 (`color-contrast-enhanced`; 4.5 is asked for); that what
takes the focus is a control (`focus-order-semantics`), since another rule wants the keyboard to reach what
scrolls; and a locked orientation, for which axe would have to load style sheets: without preloading it asks
for none, and takes no addresses in them for addresses in the page.
"""


@dataclass(frozen=True, slots=True)
class View:
    """A window that a page is looked at in.

    Parameters
    ----------
    width_px, height_px
        Its size.
    scheme
        ``light`` or ``dark``, as the reader prefers.
    """

    width_px: int
    height_px: int
    scheme: str

    def __str__(self) -> str:
        """Short, for the names of tests."""
        return f"{self.width_px}-{self.scheme}"


VIEWS = tuple(View(*size, scheme) for size in ((390, 844), (1440, 900)) for scheme in ("light", "dark"))
"""A phone and a desk, by day and at night."""


@contextmanager
def opened_browser() -> Iterator["Browser"]:
    """Open a headless Chromium; skip the test where there is none."""
    try:
        start = chromium()
    except FileNotFoundError as missing:
        pytest.skip(str(missing))
    pytest.importorskip("playwright", reason="playwright is not installed")
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - where there is a browser

    with sync_playwright() as engine:
        browser = engine.chromium.launch(**start)
        yield browser
        browser.close()


@contextmanager
def opened_page(browser: "Browser", address: str, view: View, found: list[str]) -> Iterator["Page"]:
    """Open a page in a context of its own, and note what goes wrong as long as it is open.

    Parameters
    ----------
    browser
        As `opened_browser` gives it.
    address
        ``http://...`` or ``file://...``.
    view
        The window.
    found
        Gets console errors, failed requests, and requests to anywhere else.
    """
    context = browser.new_context(
        viewport={"width": view.width_px, "height": view.height_px},
        color_scheme="dark" if view.scheme == "dark" else "light",
        reduced_motion="reduce",
    )
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    place = urlsplit(address)
    allowed = (f"{place.scheme}://{place.netloc}/", f"ws://{place.netloc}/", "data:", "blob:")
    page.on("console", lambda line: found.append(f"console: {line.text}") if line.type == "error" else None)
    page.on("pageerror", lambda error: found.append(f"script: {error}"))
    page.on("requestfailed", lambda one: found.append(f"request failed: {one.url} {one.failure}"))
    page.on("response", lambda one: found.append(f"{one.status}: {one.url}") if one.status >= 400 else None)
    page.on("request", lambda one: None if one.url.startswith(allowed) else found.append(f"asks {one.url}"))
    page.goto(address)
    page.wait_for_load_state()
    yield page
    context.close()


def faults(
    browser: "Browser",
    address: str,
    view: View,
    *,
    prepare: Callable[["Page"], None] | None = None,
    keyboard: bool = True,
) -> list[str]:
    """Open a page and return what is wrong with it, a line each; nothing where nothing is.

    Parameters
    ----------
    browser
        As `opened_browser` gives it.
    address
        ``http://...`` or ``file://...``. What the page asks of any other place is a fault.
    view
        The window.
    prepare
        Brings the page to the state that is looked at, and waits for it.
    keyboard
        Whether to go through it by the Tab key: seconds where a page has hundreds of links.
    """
    found: list[str] = []
    with opened_page(browser, address, view, found) as page:
        if prepare is not None:
            prepare(page)
        found += _too_wide(page)
        found += _broken_rules(page)
        if keyboard:
            found += _keyboard(page)
    return found


def _too_wide(page: "Page") -> list[str]:
    """Return what makes the page scroll sideways."""
    wide: list[str] = page.evaluate(_WIDE)
    return [f"wider than the window: {place}" for place in wide[:_SHOWN_FAULTS]]


def _broken_rules(page: "Page") -> list[str]:
    """Return the rules of axe that are broken, with the first places."""
    from axe_playwright_python.sync_playwright import Axe  # noqa: PLC0415 - it reads its script at once

    broken: list[Mapping[str, Any]] = Axe().run(page, options=_AXE_OPTIONS).response["violations"]
    return [
        f"axe {rule['id']} ({rule['impact']}, {len(rule['nodes'])} places): {rule['help']}: {_places(rule)}"
        for rule in broken
    ]


def _places(rule: Mapping[str, Any]) -> str:
    """Return the first places that break a rule, with what axe says of each."""
    return "; ".join(
        f"{' '.join(str(part) for part in node['target'])} [{' '.join(node['failureSummary'].split())}]"
        for node in rule["nodes"][:_SHOWN_FAULTS]
    )


def _keyboard(page: "Page") -> list[str]:
    """Press Tab until it comes round; return controls it never reached, and focus that does not show."""
    names: list[str] = page.evaluate(_CONTROLS)
    reached = set[int]()
    left = 0
    found: list[str] = []
    for _ in range(len(names) + _MORE_TABS):
        page.keyboard.press("Tab")
        at, name, fault = page.evaluate(_FOCUSED)
        # Behind the last control the focus leaves the page once, and comes back to the first.
        left += not name
        if at in reached or left > _MOST_LEFT:
            break
        if at >= 0:
            reached.add(at)
        if fault:
            found.append(f"focus on {name} {fault}")
    missed = [name for at, name in enumerate(names) if at not in reached]
    found += [f"Tab never reaches {name}" for name in missed[:_SHOWN_FAULTS]]
    return found


_NAME = """
const nameOf = (one) => {
  const said = one.getAttribute("aria-label") || one.textContent.trim().replace(/\\s+/g, " ").slice(0, 40);
  return `${one.tagName.toLowerCase()}${one.id ? "#" + one.id : ""}${said ? ` "${said}"` : ""}`;
};
"""

_WIDE = f"""() => {{
  {_NAME}
  const width = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth <= width) return [];
  const held = (one) => {{
    for (let up = one.parentElement; up && up !== document.body; up = up.parentElement)
      if (getComputedStyle(up).overflowX !== "visible") return true;
    return false;
  }};
  const wide = [...document.body.querySelectorAll("*")].filter(
    (one) => one.getBoundingClientRect().right > width + 0.5 && !held(one));
  return wide.length ? wide.map(nameOf) : ["the page, by something that has no box"];
}}"""

_CONTROLS = f"""() => {{
  {_NAME}
  const look = (one) => {{
    const style = getComputedStyle(one);
    return [style.backgroundColor, style.boxShadow, style.borderColor, style.textDecorationLine].join();
  }};
  const first = (one) => one.type !== "radio" || !one.name || one === (
    document.querySelector(`input[type=radio][name="${{CSS.escape(one.name)}}"]:checked`)
    || document.querySelector(`input[type=radio][name="${{CSS.escape(one.name)}}"]`));
  const modal = document.querySelector("dialog:modal");
  const shown = (one) => {{
    if (modal && !modal.contains(one)) return false;
    const box = one.getBoundingClientRect();
    return one.tabIndex >= 0 && !one.disabled && !one.closest("[inert]") && box.width > 0 && box.height > 0
      && one.checkVisibility({{ visibilityProperty: true }}) && first(one);
  }};
  const all = document.querySelectorAll(
    "a[href], area[href], button, input, select, textarea, summary, iframe, [tabindex], [contenteditable]");
  document.activeElement?.blur();
  const controls = [...all].filter(shown);
  window.modelcastLooked = {{ controls, before: controls.map(look), look }};
  return controls.map(nameOf);
}}"""

_FOCUSED = f"""() => {{
  {_NAME}
  const one = document.activeElement;
  if (!one || one === document.body || one === document.documentElement) return [-1, "", ""];
  const {{ controls, before, look }} = window.modelcastLooked;
  const at = controls.indexOf(one);
  const style = getComputedStyle(one);
  const outlined = style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 1
    && !/^rgba.*, 0\\)$/.test(style.outlineColor);
  const box = one.getBoundingClientRect();
  const inside = box.bottom > 0 && box.right > 0 && box.top < innerHeight && box.left < innerWidth;
  const shows = outlined || (at >= 0 && look(one) !== before[at]);
  return [at, nameOf(one), !inside ? "is out of sight" : shows ? "" : "does not show"];
}}"""
