"""The folder of an exam: worlds without their answers, with all that is needed to answer them."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ...datasets import randomness
from ...datasets.io import read_record, write_record
from ...datasets.record import Record
from ...models.data_file import json_of
from ...models.errors import BadInput
from ...models.files import reason_of
from ...models.folders import path_within, write_atomic
from ...models.model import Model, model_to_json, resolve
from ...models.plain import plain
from ...models.temporary import temporary_folder
from ...models.yaml_file import checked
from ..store import check_vacant
from ..suites import load_suite
from .exam_file import Manifest, WorldFiles, cause_list, group_list, read_file
from .key import SCHEMA, Key, digest, read_key, world_key
from .motion import logged, opening, without_motion
from .submission import submission_schema
from .worlds import World, draw

MANIFEST, CAUSES, SUBMISSION_SCHEMA, MODEL = "exam.json", "causes.json", "submission.schema.json", "model.json"
MOST_WORLDS = 500
MOST_MANIFEST, MOST_FILE = 2**24, 2**26


class Exam:
    """An exam's folder; records and models are read where they are asked for, digests are checked then.

    Raises
    ------
    BadInput : the folder holds no exam.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        data = read_file(folder / MANIFEST, MOST_MANIFEST)
        self.manifest = checked(Manifest, json_of(data, folder / MANIFEST), folder / MANIFEST)

    @property
    def id(self) -> str:
        """What a submission names the exam by."""
        return self.manifest.exam

    @property
    def worlds(self) -> Mapping[str, WorldFiles]:
        """Name -> what it holds."""
        return self.manifest.worlds

    @cached_property
    def causes(self) -> dict[str, dict[str, Any]]:
        """Public names of causes, with what their sizes are called."""
        return json_of(read_file(self.folder / CAUSES, MOST_MANIFEST), self.folder / CAUSES)

    def model(self, world: str) -> Model:
        """The base model of a world."""
        return resolve(self._intact(f"{world}/{MODEL}"))

    def records(self, world: str, names: Sequence[str]) -> list[Record]:
        """Records of a world."""
        for name in names:
            self._intact(f"{world}/{name}.yaml")
        return [read_record(self._intact(f"{world}/{name}.csv")) for name in names]

    def check(self) -> None:
        """BadInput where a file of a world is missing or was changed since the exam was made."""
        for name in self.manifest.files:
            self._intact(name)

    def key(self, path: Path) -> Key:
        """The key, checked against the manifest, and the manifest's digests against the key."""
        _check_apart(self.folder, path)
        key = read_key(path, self.manifest.key_sha256)
        if key.files != self.manifest.files or set(key.worlds) != set(self.worlds):
            raise BadInput("was changed since the exam was made", file=self.folder / MANIFEST)
        return key

    def _intact(self, name: str) -> Path:
        path = path_within(self.folder, name, self.folder / MANIFEST, "files")
        if digest(read_file(path, MOST_FILE)) != self.manifest.files.get(name):
            raise BadInput("was changed since the exam was made", file=path, hint="take the exam's folder anew")
        return path


def make(
    folder: Path,
    key: Path,
    pages: Callable[[Manifest, Mapping[str, Model]], Mapping[str, str]],
    suite: str = "exam",
    count: int = 12,
    seed: int | None = None,
    vessels: Sequence[str] = (),
    watch: Callable[[str], object] = lambda stage: None,
) -> Exam:
    """Draw the worlds of an exam and write its folder and its key: both or none.

    pages : texts of the folder, such as its README, from manifest and base models.

    Raises
    ------
    BadInput : the folder exists and is not empty, the key exists or would lie in the folder, the suite has too few
        cases.
    """
    _check_places(folder, key)
    if not 0 < count <= MOST_WORLDS:
        raise BadInput(f"{count} worlds", hint=f"give 1 to {MOST_WORLDS}")
    seed = randomness.drawn_seed() if seed is None else seed
    loaded = load_suite(suite)
    worlds = draw(loaded, seed, count, vessels)
    names = [f"world-{i:0{len(str(count))}d}" for i in range(1, count + 1)]
    with _new_folder(folder) as place:
        entries, shown, models = {}, {}, {}
        for name, world in zip(names, worlds, strict=True):
            watch(name)
            entries[name], shown[name] = _write_world(place / name, world)
            models[name] = world.base()
        files = {str(p.relative_to(place).as_posix()): digest(p.read_bytes()) for p in sorted(place.rglob("*.*"))}
        content = {
            "schema_version": SCHEMA, "suite": loaded.name, "seed": seed, "version": version("helmbench"),
            "files": files, "worlds": entries,
        }  # fmt: skip
        secret = _json(content)
        manifest = checked(
            Manifest,
            {
                "schema_version": SCHEMA, "exam": digest(secret)[:16], "title": f"{count} worlds",
                "version": version("helmbench"), "key_sha256": digest(secret), "files": files, "worlds": shown,
            },
            folder,
        )  # fmt: skip
        texts = {**pages(manifest, models), CAUSES: _json(cause_list()).decode()}
        texts |= {SUBMISSION_SCHEMA: _json(submission_schema()).decode()}
        for name, text in texts.items():
            (place / name).write_text(text, "utf-8")
        (place / MANIFEST).write_bytes(_json(manifest.model_dump()))
        write_atomic(key, secret, 0o600)
    return Exam(folder)


def _write_world(folder: Path, world: World) -> tuple[dict[str, Any], dict[str, Any]]:
    """Write a world; its entries in the key and in the manifest."""
    case, base = world.injected(), world.base()
    train, held_out = [logged(r) for r in case.train], [without_motion(logged(r)) for r in case.held_out]
    folder.mkdir()
    for record in (*train, *held_out):
        write_record(record, folder / f"{record.name}.csv")
    model_to_json(base, folder / MODEL)
    shown = {
        "base_numbers": world.base_numbers,
        "train": [record.name for record in train],
        "held_out": [record.name for record in held_out],
        "opening_s": {record.name: float(record.time_s[opening(record) - 1]) for record in held_out},
        "groups": group_list(base),
    }
    return plain(world_key(world, case, held_out)), shown


def _json(value: Any) -> bytes:
    return (json.dumps(plain(value), indent=1, allow_nan=False) + "\n").encode()


def _check_places(folder: Path, key: Path) -> None:
    check_vacant(folder)
    if not folder.resolve().parent.is_dir():
        raise BadInput("no such directory", file=folder.parent)
    if key.exists() or key.is_symlink():
        raise BadInput("exists already", file=key, hint="give the key another name")
    if not key.resolve().parent.is_dir():
        raise BadInput("no such directory", file=key.parent)
    _check_apart(folder, key)


def _check_apart(folder: Path, key: Path) -> None:
    if folder.resolve() in key.resolve().parents:
        raise BadInput("lies in the folder that is handed out", file=key, hint="keep the key elsewhere")


@contextmanager
def _new_folder(folder: Path) -> Generator[Path]:
    """A folder under a temporary name, which is moved to its place where all went well, else removed."""
    try:
        with temporary_folder(folder.parent, 0o777) as place:
            yield place
            os.replace(place, folder)
    except OSError as error:
        raise BadInput(f"cannot be written ({reason_of(error)})", file=folder) from None
