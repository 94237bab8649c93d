"""Measured sets, read in the raw form in which they are published; none of them is part of this distribution.

`measured_sets.DATASETS` says for each set where its files come from and what their SHA-256 sums are. They lie below
`data_dir()`; `fetch` downloads the missing ones, `load` reads one run as a `Record` and refuses a file that is not the
published one.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Any

from ..models.errors import BadInput
from .files import read_bytes
from .measured_sets import DATASETS
from .measured_sets.base import Dataset
from .record import Record

ENVIRONMENT = "HELMBENCH_DATA"


def data_dir() -> Path:
    """Where measured sets lie: the environment variable HELMBENCH_DATA, or else the user's cache folder."""
    given = os.environ.get(ENVIRONMENT)
    if given:
        return Path(given).expanduser()
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("helmbench", appauthor=False))


def dataset(name: str) -> Dataset:
    """The set of that name; BadInput lists the names there are."""
    if name not in DATASETS:
        raise BadInput(f"no measured set is called {name!r}", hint=f"there are {', '.join(DATASETS)}")
    return DATASETS[name]


def stems(name: str) -> tuple[str, ...]:
    """The runs of a measured set, as `load` takes them."""
    return tuple(dataset(name).runs)


def load(name: str, stem: str) -> Record:
    """Read one run of a measured set, in SI units and radians.

    Raises
    ------
    BadInput : unknown set or run, file missing (the hint says how to get it) or not the published one.
    """
    source = dataset(name)
    if stem not in source.runs:
        raise BadInput(f"no run of {name} is called {stem!r}", hint=f"there are {', '.join(source.runs)}")
    run = source.runs[stem]
    path = data_dir() / source.folder / run.file
    if not path.exists():
        hint = f"run `helmbench fetch {name}`, or let {ENVIRONMENT} name the folder that holds {source.folder}/"
        raise BadInput("no such file", file=path, hint=hint)
    content = read_bytes(path)
    if hashlib.sha256(content).hexdigest() != run.sha256:
        hint = f"`helmbench fetch {name}` replaces it"
        raise BadInput("SHA-256 differs: this is not the published file", file=path, hint=hint)
    return source.read(content, stem, run.manoeuvre)


def fetch(name: str, progress: bool = False) -> list[Path]:
    """Download what is missing of a measured set, or is not as published, and return the paths of all its files.

    A file appears in its place only complete and with the right SHA-256. `progress` shows a bar on a terminal.

    Raises
    ------
    BadInput : unknown set, source out of reach, downloaded file not the published one, folder not writable.
    """
    from tqdm import tqdm

    source = dataset(name)
    files = [run.file for run in source.runs.values()]
    bar = tqdm(files, desc=name, unit="file", disable=None if progress else True)
    store = _pooch(source)
    return [_fetch_file(store, file) for file in bar]


def _pooch(source: Dataset) -> Any:
    import pooch

    pooch.get_logger().setLevel("WARNING")
    return pooch.create(
        path=data_dir() / source.folder,
        base_url=source.url + "/",
        registry={run.file: f"sha256:{run.sha256}" for run in source.runs.values()},
        urls={run.file: f"{source.url}/{run.below}/{run.file}" for run in source.runs.values() if run.below},
        retry_if_failed=1,
    )


def _fetch_file(store: Any, file: str) -> Path:
    place, url = Path(store.path) / file, store.get_url(file)
    try:
        return Path(store.fetch(file))
    except OSError as error:
        hint = "try again, or copy the file there by hand"
        raise BadInput(f"cannot be fetched from {url} ({_cause(error)})", file=place, hint=hint) from None
    except ValueError:
        message = f"the download from {url} is not the published file (SHA-256 differs)"
        raise BadInput(message, file=place, hint="the download was deleted") from None


def _cause(error: OSError) -> str:
    """Why a download failed, in a few words."""
    import requests

    if isinstance(error, requests.Timeout):
        return "no answer in time"
    if isinstance(error, requests.HTTPError) and error.response is not None:
        return f"HTTP status {error.response.status_code}"
    if isinstance(error, requests.ConnectionError):
        return f"no connection, {type(error).__name__}"
    return error.strerror or str(error) or type(error).__name__
