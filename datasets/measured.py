"""Measured sets, read in the raw form in which they are published; none of them is part of this distribution.

`DATASETS` says for each set where its files come from and what their SHA-256 sums are. They lie below `data_dir()`;
`fetch` downloads the missing ones, `load` reads one run as a `Record` and refuses a file that is not the published one.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..models.errors import BadInput
from .files import read_bytes
from .record import Record, RecordMeta

ENVIRONMENT = "HELMBENCH_DATA"


@dataclass(frozen=True)
class Run:
    """One file of a measured set: its name, its SHA-256 and the manoeuvre that it holds."""

    file: str
    sha256: str
    manoeuvre: str


@dataclass(frozen=True)
class Dataset:
    """A measured set: public address, folder below `data_dir()`, runs by stem, reader of the raw bytes.

    `read(content, name, manoeuvre)` turns the content of one file into a `Record`.
    """

    url: str
    folder: str
    citation: str
    runs: Mapping[str, Run]
    read: Callable[[bytes, str, str], Record]


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


# ------------------------------------------------------------------------------------------------ kvlcc2-hsva

HSVA_HEADER_LINES = 4


def _read_hsva(content: bytes, name: str, manoeuvre: str) -> Record:
    """One free-running zigzag of the 7 m KVLCC2 model.

    Columns (N, 12): time s; x0, y0 m; psi deg; dx0/dt, dy0/dt m/s (earth-fixed); yaw rate deg/s; roll deg; rudder deg
    (positive to port); propeller 1/s; thrust; torque. Velocities are turned into body axes:
    u = x0' cos psi + y0' sin psi, v = -x0' sin psi + y0' cos psi.
    """
    lines = content.decode("cp1252").splitlines()[HSVA_HEADER_LINES:]
    time, north, east, psi, north_rate, east_rate, yaw_rate, roll, rudder, propeller = np.loadtxt(lines).T[:10]
    psi, yaw_rate, roll, rudder = np.deg2rad([psi, yaw_rate, roll, rudder])
    channels = {
        "rudder_rad": rudder,
        "propeller_rps": propeller,
        "heading_rad": psi,
        "yaw_rate_rad_s": yaw_rate,
        "surge_m_s": north_rate * np.cos(psi) + east_rate * np.sin(psi),
        "sway_m_s": -north_rate * np.sin(psi) + east_rate * np.cos(psi),
        "north_m": north,
        "east_m": east,
        "roll_rad": roll,
    }
    meta = RecordMeta(
        vessel="kvlcc2-l7",
        reference_point="midship",
        source=HSVA_CITATION,
        licence="not stated; not redistributed here",
        positive_rudder="port",
        manoeuvre=manoeuvre,
        notes="model scale, 7 m; measured rudder; the execute lags the nominal heading by up to 2.5 deg",
    )
    return Record(time, channels, name=name, meta=meta)


def _hsva_run(stem: str, sha256: str) -> tuple[str, Run]:
    rudder, heading = (int(part) for part in stem.split("_")[1:3])
    side = ":port" if stem.endswith("_P") else ""
    return stem, Run(f"HSVA_CPMC_KVLCC2_{stem}.dat", sha256, f"zigzag:{rudder}/{heading}{side}")


HSVA_CITATION = "HSVA 2006, free-running model tests of KVLCC2; SIMMAN 2008 workshop"
HSVA_SHA256 = {
    "Z_05_01": "169305b6aa1a2dee0c1a498708228fde1db04f0e0a913ad31c3186e99fb61766",
    "Z_10_05": "db2b9921264d4a2b998d259d001adb016c7368dd7ac1772dbeb96037875469b3",
    "Z_10_10_P": "fd3a1508e2c6f5fda46145a104c227789fbfa6a1847dd33723510872307467c4",
    "Z_10_10_S": "8b83dc0d1eea93f96a60d1a5d8d60f8b23c2f55b356d8b45d3f9a1cbdf94fb90",
    "Z_15_01": "3e5de380bf7a6b10fe2c650edeae01fdc8df5361e27a40ff0aa1b184cb629b6f",
    "Z_15_05": "d9e4c4669fabe7c05c6c701909f904564fd2a5a6454bbec6bf4ae5921000b140",
    "Z_20_05": "671b46a1f98e35b1b15d1aede74f909b8d3e2a4f1cb81cb69b476eb382bb4e76",
    "Z_20_10_S": "5fdf062d6077f3ed7da1ef89354d335d3a4fb89f5be4b2c448d77490ee0f01f4",
    "Z_25_05": "f9ea9d7e22e89e02fbd82be2d6e61c9b36424a9a2b54b43143775397e047e518",
    "Z_35_05": "6c2be03f2d6cdaf512c191b232352d040e8d7e64c286a2d4cac2de293dcc4796",
}

DATASETS: dict[str, Dataset] = {
    "kvlcc2-hsva": Dataset(
        url=(
            "https://raw.githubusercontent.com/martinlarsalbert/System-identification-of-Vessel-Manoeuvring-Models/"
            "4b7ce53f0cc8ac159126fdda7d45e30c540be2d8/data/01_raw/kvlcc2_hsva/raw_data"
        ),
        folder="kvlcc2/hsva",
        citation=HSVA_CITATION,
        runs=dict(_hsva_run(stem, sha256) for stem, sha256 in HSVA_SHA256.items()),
        read=_read_hsva,
    )
}
