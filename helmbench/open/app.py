"""The server's answers: the page, the state of a project, files that come and go."""

from __future__ import annotations

import asyncio
import io
import json
import zipfile
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Route

from ..api.arguments import METHOD
from ..models.errors import BadInput
from ..models.plain import plain
from .projects import LOGS, LONGEST_PART, MODEL_FILE, MODELS, MOST_PARTS, Project, Projects, safe_name
from .tasks import NO_MODEL, VIEW

MOST_BYTES, MOST_BODY = 1 << 30, 4 << 20
"""Largest file that is taken, and largest other body of a request, bytes."""
EXAMPLE_BIAS = 0.004
"""Bias of the yaw rate of the example, rad/s."""
NOT_READ = "nothing was read yet"
DISCARD_S = 1.0
"""How long the rest of a body that is too large is still taken, s."""
MEDIA = {".css": "text/css", ".js": "text/javascript"}
"""Suffix of the page's files -> media type."""
REPORT_PAGE = (
    "sandbox allow-scripts allow-modals; default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; "
    "img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Content security policy of a report: it may not speak to the server."""
Body = TypeVar("Body", bound="_Request")


class _Request(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class ColumnMeaning(_Request):
    """What the user says of a column."""

    to: Annotated[str, Field(max_length=60)]
    unit: Annotated[str, Field(max_length=60)] = ""
    sign: Literal[1, -1] = 1


class LogAnswers(_Request):
    """What the user says of the logs: id of a question -> its answer, and (table, column, what)."""

    answers: Annotated[dict[str, Annotated[str, Field(max_length=500)]], Field(max_length=5000)] = {}

    choices: Annotated[list[tuple[str, str, ColumnMeaning]], Field(max_length=5000)] = []
    positive_rudder: Literal["port", "starboard"] | None = None


class Part(_Request):
    """A part of a record, s, and what it is for."""

    record: Annotated[int, Field(ge=0)]
    name: Annotated[str, Field(min_length=1, max_length=LONGEST_PART)]
    start: Annotated[float, Field(alias="from")]
    stop: Annotated[float, Field(alias="to")]
    role: Literal["train", "held_out", "unused"]


class Parts(_Request):
    """All parts."""

    parts: Annotated[list[Part], Field(max_length=MOST_PARTS)]


class Asked(_Request):
    """An analysis."""

    kind: Literal["check", "identify", "diagnose"]
    model: Annotated[str, Field(max_length=200)] = NO_MODEL
    method: Annotated[str, Field(max_length=60)] = METHOD


def application(projects: Projects, assets: Path, style: Path) -> Starlette:
    """The application.

    assets : folder of the page's files.  style : the style that all pages share.
    """
    server = _Server(projects, assets, style)
    one = "/api/projects/{project}"
    routes = [
        Route("/", server.page),
        Route("/assets/{name}", server.asset),
        Route("/api/about", server.about),
        Route("/api/choices", server.choices),
        Route("/api/projects", server.listed),
        Route("/api/projects", server.new, methods=["POST"]),
        Route(one, server.state),
        Route(f"{one}/logs", server.take_log, methods=["POST"]),
        Route(f"{one}/example", server.example, methods=["POST"]),
        Route(f"{one}/logs/{{name}}", server.drop_log, methods=["DELETE"]),
        Route(f"{one}/read", server.read, methods=["POST"]),
        Route(f"{one}/parts", server.parts, methods=["POST"]),
        Route(f"{one}/question", server.question, methods=["POST"]),
        Route(f"{one}/analyses", server.analyse, methods=["POST"]),
        Route(f"{one}/cancel", server.cancel, methods=["POST"]),
        Route(f"{one}/columns", server.columns),
        Route(f"{one}/records/{{place:int}}", server.record),
        Route(f"{one}/analyses/{{analysis}}", server.result),
        Route(f"{one}/analyses/{{analysis}}/all.zip", server.bundle),
        Route(f"{one}/analyses/{{analysis}}/files/{{name:path}}", server.result_file),
    ]
    return Starlette(routes=routes, exception_handlers={BadInput: _refused, _TooLarge: _too_large})


class _TooLarge(Exception):
    """A body has more bytes than are taken."""


async def _refused(_: Request, error: Exception) -> Response:
    return JSONResponse({"error": str(error)}, 400)


async def _too_large(_: Request, error: Exception) -> Response:
    return JSONResponse({"error": str(error)}, 413, {"connection": "close"})


class _Server:
    """The handlers of all routes."""

    def __init__(self, projects: Projects, assets: Path, style: Path) -> None:
        self._projects, self._index = projects, assets / "index.html"
        self._assets = {place.name: place for place in (style, *assets.iterdir()) if place.suffix in MEDIA}

    async def page(self, _: Request) -> Response:
        return FileResponse(self._index, media_type="text/html")

    async def asset(self, request: Request) -> Response:
        place = self._assets.get(request.path_params["name"])
        if place is None:
            return JSONResponse({"error": "there is no such file"}, 404)
        return FileResponse(place, media_type=MEDIA[place.suffix])

    async def about(self, _: Request) -> Response:
        return JSONResponse(await asyncio.to_thread(_about))

    async def choices(self, _: Request) -> Response:
        return JSONResponse(await asyncio.to_thread(_choices))

    async def listed(self, _: Request) -> Response:
        return JSONResponse(self._projects.listed())

    async def new(self, _: Request) -> Response:
        return JSONResponse(self._projects.new().to_json())

    async def state(self, request: Request) -> Response:
        return JSONResponse(self._project(request).to_json())

    async def take_log(self, request: Request) -> Response:
        """Write a body into a file of its own as it comes; it gets its name when it is whole."""
        project, name = self._project(request), safe_name(request.query_params.get("name", ""))
        project.vacant(LOGS, name)  # too many are refused before they come
        coming = project.coming()
        try:
            await _stream(request, coming, name)
            kind = MODELS if name.lower().endswith(".json") and await asyncio.to_thread(_is_model, coming) else LOGS
            place = project.keep(coming, kind, name)
        except OSError as error:
            raise BadInput(f"cannot be kept ({error.strerror or error})", file=name) from None
        except ClientDisconnect:
            return Response(status_code=400)
        finally:
            coming.unlink(missing_ok=True)
        project.changed()
        return JSONResponse({"name": place.name, "kind": kind})

    async def example(self, request: Request) -> Response:
        """Begin with a log that is simulated."""
        project = self._project(request)
        await asyncio.to_thread(_write_example, project.vacant(LOGS, "example.csv"))
        with project.lock:
            project.choices, project.answers = {}, {}
            self._projects.read(project)
        return JSONResponse(project.to_json())

    async def drop_log(self, request: Request) -> Response:
        project = self._project(request)
        project.file(LOGS, request.path_params["name"]).unlink()
        with project.lock:
            self._projects.cancel(project)
            project.choices, project.answers = {}, {}
            if not project.logs():
                project.log, project.reading, project.job = None, None, None
                project.parts, project.spans = [], []
            project.changed()
        return JSONResponse(project.to_json())

    async def read(self, request: Request) -> Response:
        project, said = self._project(request), await _body(request, LogAnswers)
        with project.lock:
            project.choices = {(table, column): one.model_dump() for table, column, one in said.choices}
            project.answers, project.positive_rudder = said.answers, said.positive_rudder
            self._projects.read(project)
        return JSONResponse(project.to_json())

    async def parts(self, request: Request) -> Response:
        project, said = self._project(request), await _body(request, Parts)
        records = (project.log or {"records": []})["records"]
        found = [_checked(part, records) for part in said.parts]
        names = [part["name"] for part in found]
        twice = [name for name in names if names.count(name) > 1]
        if twice:
            raise BadInput(f"two parts are called {twice[0]!r}", hint="give every part a name of its own")
        with project.lock:
            project.parts = found
            project.changed()
        return JSONResponse(project.to_json())

    async def question(self, request: Request) -> Response:
        project, asked = self._project(request), await _body(request, Asked)
        with project.lock:
            project.question = asked.model_dump()
            project.changed()
        return JSONResponse(project.to_json())

    async def analyse(self, request: Request) -> Response:
        project, asked = self._project(request), await _body(request, Asked)
        known = await asyncio.to_thread(_choices)
        models = {NO_MODEL, *([] if asked.kind == "diagnose" else ["auto"]), *known["models"], *known["vessels"]}
        if not asked.model.startswith(MODEL_FILE) and asked.model not in models:
            raise BadInput(f"unknown model {asked.model!r}", hint="choose one of the list, or drop a model.json")
        if asked.method not in known["methods"]:
            raise BadInput(f"unknown method {asked.method!r}", hint="choose one of the list")
        self._projects.analyse(project, asked.kind, asked.model, asked.method)
        return JSONResponse(project.to_json())

    async def cancel(self, request: Request) -> Response:
        project = self._project(request)
        await asyncio.to_thread(self._projects.cancel, project)
        return JSONResponse(project.to_json())

    async def columns(self, request: Request) -> Response:
        return await self._read_file(request, "columns.json")

    async def record(self, request: Request) -> Response:
        return await self._read_file(request, f"{request.path_params['place']}.json")

    async def _read_file(self, request: Request, name: str) -> Response:
        reading = self._project(request).reading
        try:  # the next reading may remove it at any time
            data = b"" if reading is None else await asyncio.to_thread((reading / name).read_bytes)
        except FileNotFoundError:
            data = b""
        return Response(data, media_type="application/json") if data else JSONResponse({"error": NOT_READ}, 404)

    async def result(self, request: Request) -> Response:
        found = self._project(request).analysis(request.path_params["analysis"])
        return FileResponse(found.folder / VIEW, media_type="application/json")

    async def result_file(self, request: Request) -> Response:
        found = self._project(request).analysis(request.path_params["analysis"])
        name = request.path_params["name"]
        if name not in found.files:
            return JSONResponse({"error": "there is no such file"}, 404)
        if name.endswith(".html") and "download" not in request.query_params:
            policy = {"content-security-policy": REPORT_PAGE}
            return FileResponse(found.folder / name, media_type="text/html", headers=policy)
        return FileResponse(found.folder / name, filename=Path(name).name, media_type="application/octet-stream")

    async def bundle(self, request: Request) -> Response:
        found = self._project(request).analysis(request.path_params["analysis"])
        data = await asyncio.to_thread(_zipped, found.folder, found.files)
        name = {"content-disposition": f'attachment; filename="helmbench-{found.told["kind"]}.zip"'}
        return Response(data, media_type="application/zip", headers=name)

    def _project(self, request: Request) -> Project:
        return self._projects.get(request.path_params["project"])


async def _stream(request: Request, place: Path, name: str) -> None:
    """Write a body into the file of a name; _TooLarge before it is read where the header says so, else when it is."""
    told = request.headers.get("content-length", "0")
    size = int(told) if told.isascii() and told.isdigit() else 0
    written = 0
    with place.open("xb") as file:
        if size <= MOST_BYTES:
            async for chunk in request.stream():
                written += len(chunk)
                if written > MOST_BYTES:
                    break
                await asyncio.to_thread(file.write, chunk)
    if max(size, written) > MOST_BYTES:
        await _discarded(request)
        raise _TooLarge(_limit(MOST_BYTES))
    if size and written != size:
        raise BadInput("the file did not come whole", file=name, hint="drop it again")


async def _discarded(request: Request) -> None:
    """Take what still comes of a body for a moment: an answer is lost where a connection closes with unread bytes."""
    with suppress(TimeoutError):
        async with asyncio.timeout(DISCARD_S):
            while (await request.receive()).get("more_body"):
                pass


async def _body(request: Request, shape: type[Body]) -> Body:
    """The JSON of a body; BadInput where it is not of that shape."""
    data = bytearray()
    async for chunk in request.stream():
        data += chunk
        if len(data) > MOST_BODY:
            await _discarded(request)
            raise _TooLarge(_limit(MOST_BODY))
    try:
        return shape.model_validate_json(bytes(data))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise BadInput(f"the request is malformed: {where}: {first['msg']}") from None


def _limit(most: int) -> str:
    return f"more than {most >> 20} MiB: too large to be taken; cut the log, or use helmbench import"


def _checked(part: Part, records: list[dict[str, Any]]) -> dict[str, Any]:
    """A part as plain values within its record."""
    if part.record >= len(records):
        raise BadInput(f"part {part.name!r} is of a record that there is not")
    record = records[part.record]
    start, stop = max(part.start, record["from"]), min(part.stop, record["to"])
    if not start < stop:
        raise BadInput(
            f"part {part.name!r} has no sample", hint=f"its record runs from {record['from']:g} to {record['to']:g} s"
        )
    name = safe_name(part.name, LONGEST_PART)
    return {"record": part.record, "name": name, "from": start, "to": stop, "role": part.role}


def _is_model(file: Path) -> bool:
    """Whether a JSON file is a model rather than a log."""
    if file.stat().st_size > MOST_BODY:
        return False
    try:
        content = json.loads(file.read_bytes())
    except (ValueError, RecursionError):
        return False
    return isinstance(content, dict) and {"family", "coefficients"} <= content.keys()


def _write_example(place: Path) -> None:
    """A zigzag of the Mariner whose yaw rate has a bias, with its sidecar."""
    from .. import simulate, write_record

    record = simulate("mariner", "zigzag:20/20", noise="low", seed=1)
    write_record(record.with_channels(yaw_rate_rad_s=record.column("yaw_rate_rad_s") + EXAMPLE_BIAS), place)


def _zipped(folder: Path, files: tuple[str, ...]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in files:
            archive.write(folder / name, name)
    return buffer.getvalue()


@cache
def _about() -> dict[str, Any]:
    """What the columns may be, and how much is taken: known at once."""
    from ..api.importing import list_quantities
    from ..datasets.importing.clock import FORMS
    from ..datasets.importing.draft import TIME
    from ..datasets.importing.mapping import PARTS

    quantities = {**list_quantities(), TIME: [form for form in FORMS if form not in ("rows", "gps week", *PARTS)]}
    return plain({"quantities": quantities, "version": version("helmbench"), "most_bytes": MOST_BYTES})


@cache
def _choices() -> dict[str, Any]:
    """Models, vessels and methods to choose from: takes seconds of imports."""
    from .. import list_methods, list_models, list_vessels

    methods = {name: title for name, title in list_methods().items() if ":" not in name}
    return plain({"models": list_models(), "vessels": list_vessels(), "methods": methods})
