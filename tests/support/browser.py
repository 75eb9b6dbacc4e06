"""Chromium without a screen, for tests of the page."""

import os
import shutil
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any, Final

CHROMIUM: Final = os.environ.get("KINOPIX_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
"""The program; None where there is none."""

HOW_TO_GET_ONE: Final = "no Chromium: apt-get install chromium, or set KINOPIX_CHROMIUM to the program"
"""Why tests are skipped."""


@contextmanager
def browser() -> Generator[Any]:
    """Give a browser of Playwright's, driven by the program that is installed."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as library:
        chromium = library.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        try:
            yield chromium
        finally:
            chromium.close()
