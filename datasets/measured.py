"""Measured sets, read in the raw form in which they are published; none of them is part of this distribution.

`measured_sets.DATASETS` says for each set where its files come from and what their SHA-256 sums are. They lie below
`data_dir()`; `fetch` downloads the missing ones, `load` reads one run as a `Record` and refuses a file that is not the
published one.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import TYPE_CHECKING

from ..models.argument_types import typed
from ..models.errors import BadInput
from ..models.files import read_bytes, replace_together
from ..models.suggestions import suggestion
from ..models.temporary import temporary_folder
from .record import Record

if TYPE_CHECKING:
    from .measured_sets import Dataset, MeasuredRun

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
    from .measured_sets import DATASETS

    if name not in DATASETS:
        raise BadInput(f"no measured set is called {name!r}", hint=suggestion(name, DATASETS))
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
    if not _is_stored(content, run):
        hint = f"`helmbench fetch {name}` replaces it"
        raise BadInput("SHA-256 differs: this is not the published file", file=path, hint=hint)
    return source.record(content, stem)


@typed
def fetch(name: str, progress: bool = False) -> list[Path]:
    """Download what is missing of a measured set, or is not as published, and return the paths of all its files.

    A file appears in its place only complete and with the right SHA-256; where the set is stored in another form than
    it is published, the sum is that of the converted file. `progress` shows a bar on a terminal.

    Raises
    ------
    BadInput : unknown set, source out of reach, downloaded file not the published one, folder not writable.
    """
    from tqdm import tqdm

    source = dataset(name)
    bar = tqdm(source.runs.values(), desc=name, unit="file", disable=None if progress else True)
    places = []
    for run in bar:  # left alone where it is right, else downloaded, converted, checked and put in its place
        place = data_dir() / source.folder / run.file
        places.append(place)
        if place.is_file() and _is_stored(read_bytes(place), run):
            continue
        content = _published(source, run, place)
        if not _is_stored(content, run):
            message = f"the download from {source.address(run)} is not the published file (SHA-256 differs)"
            raise BadInput(message, file=place, hint="the download was deleted")
        replace_together({place: lambda path, content=content: path.write_bytes(content)})
    return places


def missing_files(name: str) -> list[Path]:
    """Files of a measured set that are not there or not as published; BadInput for an unknown set."""
    source = dataset(name)
    places = [(data_dir() / source.folder / run.file, run) for run in source.runs.values()]
    return [place for place, run in places if not (place.is_file() and _is_stored(read_bytes(place), run))]


def _is_stored(content: bytes, run: MeasuredRun) -> bool:
    return hashlib.sha256(content).hexdigest() == run.sha256


def _published(source: Dataset, run: MeasuredRun, place: Path) -> bytes:
    """Download the published file of a run and convert it; BadInput where that cannot be done."""
    import pooch

    pooch.get_logger().setLevel("WARNING")
    url = source.address(run)
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        with temporary_folder() as folder:
            store = pooch.create(folder, "", registry={run.file: None}, urls={run.file: url}, retry_if_failed=1)
            content = Path(store.fetch(run.file)).read_bytes()
    except OSError as error:
        hint = "try again, or copy the file there by hand"
        raise BadInput(f"cannot be fetched from {url} ({_cause(error)})", file=place, hint=hint) from None
    try:
        return source.convert(content) if source.convert else content
    except (KeyError, ValueError) as error:
        raise BadInput(f"the download from {url} is not the published file ({error!r})", file=place) from None


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
