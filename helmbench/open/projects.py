"""Projects: the logs, choices, parts and results of one tab; they last as long as the server."""

from __future__ import annotations

import re
import secrets
import shutil
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any
from unicodedata import category

from ..models.errors import HIDDEN, BadInput
from .recipes import Recipe
from .tasks import READING_STEPS, steps_of
from .workers import UNFINISHED, Job, Workers

MOST_PROJECTS, MOST_FILES, MOST_PARTS = 64, 64, 200
LONGEST_NAME, LONGEST_PART = 120, 200
"""Bytes of the name of a file, and of a part of it, which has a kind and a number behind; systems take 255."""
LOGS, MODELS, COMING = "logs", "models", "coming"
"""Folders of a project: logs, models, and what has not wholly come yet."""
MAPPING = ".map.yaml"
"""Ends the name of a mapping."""
READING, RESULT = "reading-", "result-"
"""Begin the names of the folders that jobs write."""
NOT_IN_NAMES = re.compile(
    r'[/\\:*?"<>|\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u2800\u3164\ufe00-\ufe0f\uffa0\U000e0100-\U000e01ef]'
)
"""Characters of paths, and letters that nobody sees though Unicode does not count them to `HIDDEN`."""
EDGES = re.compile(r"^[\s.]+|[\s.]+$")


@dataclass
class Analysis:
    """A result: what lists show of it, its folder, and the names of its files."""

    id: str
    folder: Path
    told: dict[str, Any]
    files: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """What the page shows of it."""
        return {"id": self.id, **self.told, "files": list(self.files)}


@dataclass
class Project:
    """What one tab works on.

    log : outcome of the last reading (`tasks.read_logs`);  answers : id of a question -> its answer;  asked : id of a
    question -> the question, of all that were open once;
    choices : what the user says of columns;  version : counts changes;  reading : folder of the last reading;
    parts : of the records with these `spans`, (name, from, to) in s;  question : what the user means to ask.
    """

    id: str
    folder: Path
    lock: threading.RLock = field(default_factory=threading.RLock)
    version: int = 0
    touched: float = field(default_factory=time.time)
    answers: dict[str, str] = field(default_factory=dict[str, str])
    asked: dict[str, dict[str, Any]] = field(default_factory=dict[str, dict[str, Any]])
    choices: dict[tuple[str, str], dict[str, Any]] = field(default_factory=dict[tuple[str, str], dict[str, Any]])
    positive_rudder: str | None = None
    log: dict[str, Any] | None = None
    reading: Path | None = None
    parts: list[dict[str, Any]] = field(default_factory=list[dict[str, Any]])
    spans: list[tuple[str, float, float]] = field(default_factory=list[tuple[str, float, float]])
    question: dict[str, Any] | None = None
    job: Job | None = None
    analyses: list[Analysis] = field(default_factory=list[Analysis])

    def changed(self) -> None:
        """Count a change."""
        self.version += 1
        self.touched = time.time()

    def names(self, kind: str = LOGS) -> list[str]:
        """Names of the files in the order in which they came."""
        return [path.name for path in sorted((self.folder / kind).iterdir(), key=lambda path: path.stat().st_ctime_ns)]

    def logs(self) -> list[str]:
        """Names of the files that are read: those that say something of another one are not among them."""
        names = self.names()
        return [name for name in names if not is_beside(name, names)]

    def mapping(self) -> str | None:
        """Name of the mapping that was dropped last, if there is one."""
        return next((name for name in reversed(self.names()) if name.lower().endswith(MAPPING)), None)

    def coming(self) -> Path:
        """The place of a file while it comes, of one upload alone."""
        return self.folder / COMING / secrets.token_hex(8)

    def keep(self, file: Path, kind: str, name: str) -> Path:
        """Give a file that has come its place; BadInput where there are too many."""
        with self.lock:
            return file.rename(self.vacant(kind, name))

    def vacant(self, kind: str, name: str) -> Path:
        """The place of a new file; BadInput where there are too many."""
        taken = self.names(kind)
        if len(taken) >= MOST_FILES:
            raise BadInput(f"{MOST_FILES} files are the most", hint="open another tab for other logs")
        safe = safe_name(name)
        stem, dot, suffix = safe.rpartition(".")
        stem, suffix = (stem, dot + suffix) if stem else (suffix, "")
        number = 2
        while safe in taken:
            safe, number = f"{stem}-{number}{suffix}", number + 1
        return self.folder / kind / safe

    def sweep(self) -> None:
        """Remove the folders of readings that were replaced, and of jobs that came to nothing."""
        kept = {self.reading, *(one.folder for one in self.analyses)}
        kept |= {Path(self.job.arguments["out"])} if self.job is not None and self.busy() else set()
        for folder in {*self.folder.glob(f"{READING}*"), *self.folder.glob(f"{RESULT}*")} - kept:
            shutil.rmtree(folder, ignore_errors=True)

    def file(self, kind: str, name: str) -> Path:
        """The file of that name; BadInput where there is none."""
        if name not in self.names(kind):
            raise BadInput("there is no such file", file=name)
        return self.folder / kind / name

    def analysis(self, number: str) -> Analysis:
        """The result of that id; BadInput where there is none."""
        found = [one for one in self.analyses if one.id == number]
        if not found:
            raise BadInput(f"there is no result {number!r}")
        return found[0]

    def busy(self) -> bool:
        """Whether a job is under way."""
        return self.job is not None and self.job.state in UNFINISHED

    def to_json(self) -> dict[str, Any]:
        """The state that the page shows."""
        with self.lock:
            names = self.names()
            files = [
                {"name": name, "bytes": (self.folder / LOGS / name).stat().st_size, "beside": is_beside(name, names)}
                for name in names
            ]
            return {
                "id": self.id,
                "version": self.version,
                "files": files,
                "models": self.names(MODELS),
                "positive_rudder": self.positive_rudder,
                "answers": self.answers,
                "answered": [
                    _answered(self.asked[name], key) for name, key in self.answers.items() if name in self.asked
                ],
                "choices": [[table, column, said] for (table, column), said in self.choices.items()],
                "log": self.log,
                "reading": self.reading.name if self.reading else "",
                "parts": self.parts,
                "question": self.question,
                "job": self.job.to_json() if self.job else None,
                "analyses": [one.to_json() for one in reversed(self.analyses)],
            }


def is_beside(name: str, names: Sequence[str]) -> bool:
    """Whether a file is no log: a YAML file, or a JSON file with the name of another file."""
    place = PurePosixPath(name)
    if place.suffix.lower() in (".yaml", ".yml"):
        return True
    others = [PurePosixPath(other) for other in names if other != name]
    return place.suffix.lower() == ".json" and any(place.stem in (other.stem, other.name) for other in others)


def _answered(question: dict[str, Any], key: str) -> dict[str, str]:
    """A question and its answer in words."""
    texts = {answer["key"]: answer["text"] for answer in question["answers"]}
    return {"id": question["id"], "text": question["text"], "answer": texts.get(key, key)}


def safe_name(name: str, most: int = LONGEST_NAME) -> str:
    """The last part of a file's name, without anything that a path or a terminal would take for more than text.

    Characters that steer a terminal, turn the direction of text or have no width become `_`, as those of paths do.
    most : bytes that it may have.
    """
    last = PureWindowsPath(PurePosixPath(name.strip()).name).name
    shown = "".join("_" if category(letter) in HIDDEN else letter for letter in last)
    text = EDGES.sub("", NOT_IN_NAMES.sub("_", shown))
    stem, dot, suffix = text.rpartition(".")
    text = f"{_cut(stem, most - len(suffix.encode()) - 1)}{dot}{suffix}" if stem else text
    return EDGES.sub("", _cut(text, most)) or "log"


def _cut(text: str, most: int) -> str:
    """The first letters of a text, of at most so many bytes."""
    return text.encode()[: max(most, 0)].decode(errors="ignore")


class Projects:
    """All projects, in a folder that only this user can read.

    Parameters
    ----------
    folder : private and empty; it is emptied at the end.
    """

    def __init__(self, folder: Path, workers: Workers) -> None:
        self.folder, self.workers = folder, workers
        self._all: dict[str, Project] = {}
        self._lock = threading.Lock()

    def new(self) -> Project:
        """A project without logs; the oldest one without logs makes room where there are too many.

        Raises
        ------
        BadInput : there are too many with logs.
        """
        with self._lock:
            if len(self._all) >= MOST_PROJECTS:
                self._drop_an_empty_one()
            number = secrets.token_urlsafe(9)
            project = self._all[number] = Project(number, self.folder / number)
        for kind in (LOGS, MODELS, COMING):
            (project.folder / kind).mkdir(parents=True)
        return project

    def _drop_an_empty_one(self) -> None:
        empty = [one for one in self._all.values() if not one.names() and not one.busy()]
        if not empty:
            raise BadInput(f"{MOST_PROJECTS} tabs with logs are the most", hint="end helmbench open and start it again")
        shutil.rmtree(self._all.pop(empty[0].id).folder)

    def get(self, number: str) -> Project:
        """The project of that id; BadInput where there is none."""
        with self._lock:
            if number not in self._all:
                raise BadInput("this work is gone", hint="the server was started anew: drop the logs again")
            return self._all[number]

    def listed(self) -> list[dict[str, Any]]:
        """Projects with logs, the latest first."""
        with self._lock:
            found = [(one.touched, one.id, one.names(), len(one.analyses)) for one in self._all.values()]
        return [{"id": number, "files": names, "results": results, "at": at}
                for at, number, names, results in sorted(found, reverse=True) if names]  # fmt: skip

    # ---- jobs

    def read(self, project: Project) -> None:
        """Read the logs with what the user says of them; what is under way is cancelled.

        Raises
        ------
        BadInput : there is no log.
        """
        names, mapping = project.logs(), project.mapping()
        if not names:
            raise BadInput("there is no log to read", hint="drop one")
        out = project.folder / f"{READING}{secrets.token_hex(4)}"
        out.mkdir()
        arguments = {
            "logs": str(project.folder / LOGS),
            "files": names,
            "mapping": mapping and str(project.folder / LOGS / mapping),
            "out": str(out),
            "answers": project.answers,
            "choices": [(table, column, said) for (table, column), said in project.choices.items()],
            "positive_rudder": project.positive_rudder,
        }

        def keep(found: dict[str, Any]) -> None:
            spans = [(one["name"], one["from"], one["to"]) for one in found["records"]]
            project.log, project.reading = found, out
            project.asked |= {question["id"]: question for question in found["questions"]}
            if spans and spans != project.spans:  # a choice that makes no record costs no part
                project.parts, project.spans = found["parts"], spans

        self._start(project, Job("read", arguments, READING_STEPS), keep)

    def analyse(self, project: Project, kind: str, model: str, method: str) -> None:
        """Check, identify or diagnose the parts.

        Raises
        ------
        BadInput : there is no record, or something is computed already.
        """
        if project.reading is None or not project.log or not project.log["records"]:
            raise BadInput("there is no record yet", hint="answer what is asked of the columns")
        if project.busy():
            raise BadInput("something is computed already", hint="wait for it, or cancel it")
        number = f"{len(project.analyses) + 1}-{secrets.token_hex(3)}"
        out, reading = project.folder / f"{RESULT}{number}", project.reading
        out.mkdir()
        shutil.copy(reading / "log.map.yaml", out)
        if model.startswith(MODEL_FILE):
            model = str(shutil.copy(project.file(MODELS, model.removeprefix(MODEL_FILE)), out))
        parts = tuple(part for part in project.parts if part["role"] in ("train", "held_out"))
        logs, side = tuple(project.logs()), project.positive_rudder
        recipe = Recipe(kind, Path(model).name, method, logs, "log.map.yaml", side, parts)
        records = [str(reading / f"{place}.parquet") for place in range(len(project.log["records"]))]
        arguments = {"recipe": recipe, "model": model, "records": records, "out": str(out)}

        def keep(told: dict[str, Any]) -> None:
            files = sorted(path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file())
            files = [name for name in files if name != "view.json"]
            project.analyses.append(Analysis(number, out, told, tuple(files)))

        self._start(project, Job("analyse", arguments, steps_of(kind, model)), keep)

    def _start(self, project: Project, job: Job, keep: Callable[[Any], object]) -> None:
        with project.lock:
            self.cancel(project)
            project.job = job
            project.sweep()
            project.changed()

        def finished(_: Job, found: Any) -> None:
            with project.lock:
                if project.job is job:
                    keep(found)
                    project.sweep()
                    project.changed()

        self.workers.start(job, finished)

    def cancel(self, project: Project) -> None:
        """End what is under way."""
        if project.job is not None and project.busy():
            self.workers.cancel(project.job)
            project.changed()


MODEL_FILE = "file:"
"""Begins the name of a model that the user has dropped."""
