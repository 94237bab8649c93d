"""The picture of the page in the browser: `python docs/page_picture.py docs/_static/page.png` (make page-picture).

A record of a ship whose gyro reads 0.05 deg/s too much is given to the page and diagnosed, in Chromium.
"""

import shutil
import sys
import threading

import numpy as np
from playwright.sync_api import sync_playwright

import helmbench
from helmbench.open import serve

WAIT_MS = 120_000


def log() -> str:
    """The log of a bridge: degrees, knots and a clock."""
    record = helmbench.simulate(
        "mariner", "zigzag:20/20", noise="low,yaw_rate.bias=0.05deg_s", seed=1, duration_s=400.0
    )
    table = record.to_dataframe()
    degrees = {"rudder [deg]": "rudder_rad", "heading [deg]": "heading_rad", "rate of turn [deg/s]": "yaw_rate_rad_s"}
    columns = {"time [s]": table["time_s"]}
    columns |= {name: np.degrees(table[column]) for name, column in degrees.items()}
    columns |= {"speed through water [kn]": table["surge_m_s"] * 3600.0 / 1852.0}
    return type(table)(columns).to_csv(index=False)


def draw(place: str) -> None:
    """Give it the log, ask for a diagnosis, and save what the page shows."""
    with serve.site() as site, sync_playwright() as playwright:
        server = site.server()
        thread = threading.Thread(target=server.run, kwargs={"sockets": [site.listener]})
        thread.start()
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": 1100, "height": 1000})
        tab.goto(site.link())
        tab.wait_for_selector("#choose")
        tab.set_input_files("#chooser", {"name": "bridge.csv", "mimeType": "text/csv", "buffer": log().encode()})
        tab.wait_for_selector("#start", timeout=WAIT_MS)
        tab.check("#kind-diagnose")
        with tab.expect_response("**/question"):
            tab.select_option("#model", "mariner")
        tab.click("#start")
        tab.wait_for_selector("#verdict", timeout=WAIT_MS)
        tab.evaluate("document.querySelector('#result-title').scrollIntoView()")
        tab.wait_for_timeout(500)
        tab.screenshot(path=place)
        browser.close()
        server.should_exit = True
        thread.join()


if __name__ == "__main__":
    draw(sys.argv[1])
