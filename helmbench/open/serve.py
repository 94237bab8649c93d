"""The server of `helmbench open`, from its start to its end."""

from __future__ import annotations

import os
import shutil
import socket
import sys
import threading
import webbrowser
from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlencode

import uvicorn

from ..models.errors import BadInput
from ..models.folders import without_working_folder
from ..models.temporary import temporary_folder
from ..reporting import open as view
from ..reporting.templating import FOLDER
from .app import application
from .guard import LOOPBACK, Guard
from .projects import LOGS, Projects
from .workers import Workers


@dataclass(frozen=True)
class Site:
    """A server that listens: its application, its socket, and what it holds."""

    app: Guard
    listener: socket.socket
    projects: Projects

    @property
    def address(self) -> str:
        """The address of the server; it alone opens nothing."""
        return f"http://{LOOPBACK}:{self.listener.getsockname()[1]}"

    def link(self, work: str = "") -> str:
        """A new link for the browser, which opens the page once.  work : id of a project; empty: a new one."""
        content = {"code": self.app.keys.code()} | ({"work": work} if work else {})
        return f"{self.address}/#{urlencode(content)}"

    def server(self) -> uvicorn.Server:
        """What answers; `run` it with the socket."""
        config = uvicorn.Config(
            self.app,
            lifespan="off",
            ws="none",
            proxy_headers=False,
            log_level="error",
            access_log=False,
            server_header=False,
        )
        return uvicorn.Server(config)


def serve(files: Sequence[Path], say: Callable[[str], object], browser: bool) -> None:
    """Serve the page until the process is interrupted; all that came to the server is deleted then.

    Parameters
    ----------
    files : logs with which the page opens.
    say : is called with a link to the page, and with another one whenever the user presses Enter.
    browser : whether to open the link in the user's browser.

    Raises
    ------
    BadInput : a file cannot be read.
    """
    with site() as made:
        work = _with_logs(made.projects, files) if files else ""
        made.projects.workers.warm()
        link = made.link(work)
        say(link)
        if browser:
            webbrowser.open(link)
        if sys.stdin.isatty():
            threading.Thread(target=_link_at_enter, args=(made, say), daemon=True).start()
        made.server().run(sockets=[made.listener])


def _link_at_enter(made: Site, say: Callable[[str], object]) -> None:
    """Say a new link for every line of the terminal.

    The terminal is read without Python's buffer, whose lock would keep the process from ending.
    """
    while os.read(sys.stdin.fileno(), 1024):
        say(made.link())


@contextmanager
def site() -> Generator[Site]:
    """A site on a free port of this machine, with a private folder that is deleted at the end."""
    with ExitStack() as stack:
        stack.enter_context(without_working_folder())
        folder = stack.enter_context(temporary_folder())
        workers = Workers()
        stack.callback(workers.close)
        projects = Projects(folder, workers)
        listener = stack.enter_context(socket.create_server((LOOPBACK, 0)))
        assets = Path(view.__file__).parent / "assets"
        app = Guard(application(projects, assets, FOLDER / "style.css"), listener.getsockname()[1])
        yield Site(app, listener, projects)


def _with_logs(projects: Projects, files: Sequence[Path]) -> str:
    """Begin a project with copies of logs and of the sidecars beside them, and read them; returns its id."""
    project = projects.new()
    sidecars = {file.with_suffix(".yaml") for file in files}
    for file in [*files, *sorted(place for place in sidecars - {*files} if place.is_file())]:
        try:
            shutil.copyfile(file, project.vacant(LOGS, file.name))
        except OSError as error:
            raise BadInput(f"cannot be read ({error.strerror or error})", file=file) from None
    projects.read(project)
    return project.id
