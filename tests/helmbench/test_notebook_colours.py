"""Pictures of results in notebooks follow the notebook's theme."""

import io

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import sync_playwright

from helmbench import Record

from ..support.browser import chromium

THEMES = {
    "JupyterLab": ("<body data-jp-theme-light=false>", "<body data-jp-theme-light=true>"),
    "Visual Studio Code": ('<body class="vscode-dark">', '<body class="vscode-light">'),
    "Colab": ("<html theme=dark><body>", "<html><body>"),
}


@pytest.fixture(scope="module")
def tab():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=["--no-sandbox", "--disable-gpu"])
        yield browser.new_page()
        browser.close()


@pytest.mark.parametrize("shown", ["record", "figure"])
@pytest.mark.parametrize("theme", THEMES)
def test_pictures_are_dark_where_the_notebook_is(tab, theme, shown):
    record = Record([0.0, 1.0, 2.0], {"yaw_rate_rad_s": np.deg2rad([1.0, 2.0, 3.0])}, "run")
    html = (record if shown == "record" else record.plot())._repr_html_()
    dark, light = (_brightness(tab, f"<!doctype html>{body}{html}") for body in THEMES[theme])
    assert light > 200
    assert dark < 80


def _brightness(tab, page):
    """Mean of the light, 0 to 255, of the picture as it is drawn."""
    tab.set_content(page)
    drawn = tab.locator("img.helmbench").screenshot()
    return float(np.asarray(Image.open(io.BytesIO(drawn)).convert("L")).mean())
