"""The fenced blocks of a page in Markdown, run as a reader runs them."""

import re
import shlex
from pathlib import Path

from helmbench.cli import status_of

BLOCK = re.compile(r"^```(bash|python|yaml|\{code-cell\})\n(.*?)^```", re.DOTALL | re.MULTILINE)
SHELL = "%%bash\n"
FILE = re.compile(r"# ([\w.-]+\.(?:py|yaml))\b")
"""First line of a block that the reader saves as a file."""


def blocks(page: Path) -> list[tuple[str, str]]:
    """(language, text) of the blocks of a page."""
    return BLOCK.findall(page.read_text(encoding="utf-8"))


def file_of(text: str) -> str | None:
    """Name of the file that a block is saved as, if it is."""
    match = FILE.match(text)
    return match and match[1]


def run_block(language: str, text: str, names: dict) -> None:
    """Run a block in this process, in the working folder; `names` are those of the page's Python."""
    if language == "{code-cell}":
        run_block("bash" if text.startswith(SHELL) else "python", text.removeprefix(SHELL), names)
    elif name := file_of(text):
        Path(name).write_text(text, encoding="utf-8")
    elif language == "python":
        exec(compile(text, "example", "exec"), names)
    elif language == "bash":
        for line in text.strip().splitlines():
            call, _, after_findings = line.partition(" || ")
            command, *arguments = shlex.split(call)
            assert command == "helmbench" and status_of(arguments) == (1 if after_findings else 0), line
