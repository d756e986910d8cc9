"""A headless Chromium of the system, without a network; tests that need it are skipped where there is none."""

from __future__ import annotations

import io
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

NAMES = ("chromium", "chromium-browser", "google-chrome")
# The processor draws, as on a machine without a screen.
SOFTWARE = ["--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader"]
SOFTWARE.append("--enable-unsafe-swiftshader")


@pytest.fixture(scope="session")
def browser() -> Iterator:
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip("no browser: install Debian's chromium")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as driver:
        found = driver.chromium.launch(executable_path=program, args=SOFTWARE)
        yield found
        found.close()


@pytest.fixture
def opened(browser) -> Iterator[Callable]:
    """Function of (file, width, dark) that opens a page and gives it, with what it said and asked for."""
    contexts = []

    def opened(path: Path, width: int = 1280, dark: bool = False) -> SimpleNamespace:
        context = browser.new_context(
            viewport={"width": width, "height": 820},
            color_scheme="dark" if dark else "light",
            offline=True,
            has_touch=width < 600,
            reduced_motion="reduce",  # it waits to be played
        )
        contexts.append(context)
        page, said, asked = context.new_page(), [], []
        page.on("console", lambda message: said.append(message.text) if message.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri())
        page.wait_for_function("(window.report || window.explorer || {}).ready", timeout=60_000)
        settle(page)
        return SimpleNamespace(page=page, said=said, asked=asked)

    yield opened
    for context in contexts:
        context.close()


def settle(page) -> None:
    """Wait until what was asked for is drawn."""
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())))")


def picture(page, selector: str) -> np.ndarray:
    """What an element shows, shape (height, width, 3)."""
    with Image.open(io.BytesIO(page.locator(selector).first.screenshot())) as image:
        return np.asarray(image.convert("RGB")).astype(int)
