"""Results that several folders test.  Each is made once in a run: the first worker that asks makes it, and the others
read it from a file."""

import pickle
import shutil
from typing import Any

import numpy as np
import pytest
from filelock import FileLock

import helmbench
from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import apply, parse_noise
from helmbench.diagnosis.calibration.calibrate import calibrate
from helmbench.diagnosis.diagnose import diagnose
from helmbench.models.model import resolve

from .expectations.calibrations import MANOEUVRES, SHIP, altered, runs
from .seeds import seed_of
from .simulators.craft import draw, sailed
from .support.inline_pool import without_workers

BOARD = "title: mine\nentries: [{vessels: response-1, methods: [ls, rls], noise: [none, low], seeds: 2}]\n"


@pytest.fixture(scope="session")
def run_folder(tmp_path_factory, worker_id):
    """The folder of this run of the tests, the same for all workers."""
    base = tmp_path_factory.getbasetemp()
    return base if worker_id == "master" else base.parent


@pytest.fixture(scope="session")
def once(run_folder):
    """once(name, make): what make() gives, from the file of that name where another worker has made it."""

    def shared(name: str, make) -> Any:
        path = run_folder / f"{name}.pickle"
        with FileLock(f"{path}.lock"):
            if not path.exists():
                path.write_bytes(pickle.dumps(make()))
        return pickle.loads(path.read_bytes())

    return shared


@pytest.fixture(scope="session")
def calibrated(once):
    """(training records, held-out record, calibration) of a KVLCC2 with 25 % more resistance and a common neutral
    rudder angle of 1 deg."""

    def make():
        rng, ship = np.random.default_rng(20261122), resolve(SHIP)
        trims = np.deg2rad(1.0 + 0.2 * rng.normal(size=len(MANOEUVRES)))
        *train, last = runs(altered(ship, 0.25, 0.0), rng, trims)
        return train, last, calibrate(ship, train, [last])

    return once("calibrated", make)


@pytest.fixture(scope="session")
def uncertain(once):
    """The diagnosis of the published KVLCC2 model on runs of a ship with other resistance, hull and neutral rudder
    angle."""

    def make():
        base, rng, records = resolve("kvlcc2-l7"), np.random.default_rng(1), []
        values = base.coefficients.copy()
        for name, factor in (("R_0", 1.3), ("N_v", 1.1), ("N_r", 0.9), ("Y_v", 1.15), ("X_vr", 3.0)):
            values[base.coordinates.index(name)] *= factor
        for text in (*MANOEUVRES[:4], "zigzag:15/5"):
            run = record_run(base.with_coefficients(values), parse_manoeuvre(text), duration_s=70.0, dt_s=0.2)
            trim = np.deg2rad(0.8 + 0.2 * rng.normal())
            records.append(apply(run.with_channels(rudder_rad=run.rudder() - trim), parse_noise("low"), rng))
        return diagnose(base, records[:-1], records[-1:])

    return once("uncertain", make)


@pytest.fixture(scope="session")
def craft(once):
    """(training records, held-out record, what `helmbench.build_model` built of them) of a craft with a rudder in the
    flow whose neutral angle is not zero."""

    def make():
        rng = np.random.default_rng(seed_of("craft"))
        hull = draw(rng, "flow", "offset")
        *train, last = (sailed(rng, hull, f"run {i}", length=35.0) for i in range(3))
        return train, last, helmbench.build_model(train, last)

    return once("craft", make)


@pytest.fixture(scope="session")
def board(run_folder):
    """A folder with the stored results of a small suite, for reading; its suite file is `mine.yaml` beside it."""
    with FileLock(run_folder / "board.lock"):
        out = run_folder / "board" / "out"
        if not out.exists():
            shutil.rmtree(out.parent, ignore_errors=True)
            out.parent.mkdir()
            (out.parent / "mine.yaml").write_text(BOARD)
            with without_workers():
                helmbench.run_suite(str(out.parent / "mine.yaml"), directory=out, jobs=1)
    return out
