"""The server of `helmbench open`, from its start to its end."""

from __future__ import annotations

import secrets
import shutil
import socket
import tempfile
import webbrowser
from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import uvicorn

from ..models.errors import BadInput
from ..models.working_folder import without_working_folder
from ..reporting import open as view
from ..reporting.templating import FOLDER
from .app import application
from .guard import LOOPBACK, Guard
from .projects import LOGS, Projects
from .workers import Workers


@dataclass(frozen=True)
class Site:
    """A server that listens: its application, its socket, the address for the browser, and what it holds."""

    app: Guard
    listener: socket.socket
    address: str
    projects: Projects

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
    say : is called with the address of the page.
    browser : whether to open the address in the user's browser.

    Raises
    ------
    BadInput : a file cannot be read.
    """
    with site(files) as made:
        made.projects.workers.warm()
        say(made.address)
        if browser:
            webbrowser.open(made.address)
        made.server().run(sockets=[made.listener])


@contextmanager
def site(files: Sequence[Path] = ()) -> Generator[Site]:
    """A site on a free port of this machine, with a private folder that is deleted at the end; raises as `serve`."""
    with ExitStack() as stack:
        stack.enter_context(without_working_folder())
        folder = Path(tempfile.mkdtemp(prefix="helmbench-open-"))
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        workers = Workers()
        stack.callback(workers.close)
        projects = Projects(folder, workers)
        fragment = _with_logs(projects, files) if files else ""
        listener = stack.enter_context(socket.create_server((LOOPBACK, 0)))
        port, token = listener.getsockname()[1], secrets.token_urlsafe(24)
        assets = Path(view.__file__).parent / "assets"
        app = Guard(application(projects, assets, FOLDER / "style.css"), token, port)
        yield Site(app, listener, f"http://{LOOPBACK}:{port}/?token={token}{fragment}", projects)


def _with_logs(projects: Projects, files: Sequence[Path]) -> str:
    """Begin a project with copies of logs, and read them; returns the fragment of its address."""
    project = projects.new()
    for file in files:
        try:
            shutil.copyfile(file, project.vacant(LOGS, file.name))
        except OSError as error:
            raise BadInput(f"cannot be read ({error.strerror or error})", file=file) from None
    projects.read(project)
    return f"#{project.id}"
