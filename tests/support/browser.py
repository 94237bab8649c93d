"""The Chromium that tests of pages drive."""

import shutil


def chromium() -> str:
    """Path of the program; AssertionError where there is none."""
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    assert program, "no Chromium: `make browser` installs it"
    return program
