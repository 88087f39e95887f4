"""The built documentation, page by page, on a screen and on a phone."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from playwright.sync_api import Browser

SITE = os.environ.get("MECANIQUE_SITE", "")
"""Folder of the built documentation."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not SITE, reason="MECANIQUE_SITE names no built documentation"),
]

FAULTS = r"""() => {
    const faults = [];
    const { scrollWidth, clientWidth } = document.documentElement;
    if (scrollWidth > clientWidth) faults.push(`wider than the screen: ${scrollWidth}`);
    for (const picture of document.images)
        if (picture.complete && !picture.naturalWidth) faults.push(`no picture: ${picture.src}`);
    const article = document.querySelector('article');
    for (const part of article?.querySelectorAll('*') ?? []) {
        const hidden = getComputedStyle(part).overflowX === 'hidden';
        if (hidden && part.clientWidth && part.scrollWidth > part.clientWidth + 2)
            faults.push(`cut: ${part.outerHTML.slice(0, 80)}`);
    }
    const prose = article?.cloneNode(true);
    prose?.querySelectorAll('pre, code, math, a, dl.py').forEach((e) => e.remove());
    const raw = prose?.textContent.match(/\\frac|\\dot|\$[^$\n(]+\$|\b[A-Z]_[a-z]+\b/);
    if (raw) faults.push(`a formula that is not set: ${raw[0]}`);
    return faults;
}"""
"""What is wrong with a page, in lines."""


@pytest.mark.parametrize(("width", "height"), [(1280, 900), (390, 844)])
def test_pages_fit_the_screen_and_set_their_formulas(
    browser: Browser, width: int, height: int
) -> None:
    site = Path(SITE).resolve()
    pages = [path for path in site.rglob("*.html") if "gallery" not in path.parts]
    assert len(pages) > 40
    seen = browser.new_page(viewport={"width": width, "height": height})
    faults = {}
    for path in sorted(pages):
        seen.goto(path.as_uri(), wait_until="load")
        if wrong := seen.evaluate(FAULTS):
            faults[path.relative_to(site).as_posix()] = wrong
    seen.close()
    assert faults == {}
