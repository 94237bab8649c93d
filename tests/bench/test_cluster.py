"""A dask cluster: one version of the code, and nothing lost or stored wrongly when workers or the scheduler die."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress

import pytest

import helmbench
from helmbench.bench import cluster as clusters
from helmbench.models.errors import BadInput

SUITE = "entries: [{vessels: response-1, methods: ls, noise: low, seeds: 3}]\n"
OTHER_CODE = (
    "import helmbench.bench.environment as here; here._source_digest = lambda: 'other'; "
    "from distributed.cli.dask_worker import main; main()"
)
METHODS = """
import os, pathlib, time
from helmbench.methods.base import Method

class Deadly(Method):
    name = "deadly"
    def estimate(self, records, model):
        os._exit(1)

class Slow(Method):
    name = "slow"
    def estimate(self, records, model):
        pathlib.Path(__file__).with_suffix(".began").touch()
        time.sleep(600)
"""


class Cluster:
    """A scheduler and its workers, each a process."""

    def __init__(self, folder):
        self.file, self.running = folder / "scheduler.json", []
        self.scheduler = self.start("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0")
        wait_for(lambda: self.file.exists() and "workers" in self.file.read_text())
        self.address = json.loads(self.file.read_text())["address"]

    def start(self, module, *words, code=None):
        program = ["-m", module] if code is None else ["-c", code]
        command = [sys.executable, *program, "--scheduler-file", str(self.file), "--no-dashboard", *words]
        silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        settings = os.environ | {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}
        self.running.append(subprocess.Popen(command, env=settings, start_new_session=True, **silent))
        return self.running[-1]

    def worker(self, *words, code=None):
        """A worker with one thread that has joined."""
        from distributed import Client

        process = self.start("distributed.cli.dask_worker", "--nthreads", "1", *words, code=code)
        with Client(self.address, timeout=60) as client:
            client.wait_for_workers(1, timeout=60)
        return process

    def end(self):
        for process in self.running:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)  # a nanny with its worker
            process.wait(60)


def wait_for(condition, seconds=90):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.fixture
def cluster(tmp_path):
    made = Cluster(tmp_path)
    yield made
    made.end()


@pytest.fixture
def suite(tmp_path):
    (tmp_path / "mine.yaml").write_text(SUITE)
    (tmp_path / "bad.py").write_text(METHODS)
    return str(tmp_path / "mine.yaml")


@pytest.mark.nightly
def test_a_method_that_kills_workers_ends_as_failed_rows_and_the_others_finish(cluster, suite, tmp_path):
    cluster.worker()
    methods = ["ls", f"{tmp_path / 'bad.py'}:Deadly"]
    found = helmbench.run_suite(suite, directory=tmp_path / "out", methods=methods, seeds=1, scheduler=cluster.address)
    rows = {row["method"]: row for row in found.rows}
    assert (rows["ls"]["status"], rows["deadly"]["status"]) == ("ok", "failed")
    assert "worker process died" in rows["deadly"]["error"] and "KilledWorker" not in rows["deadly"]["error"]


@pytest.mark.nightly
def test_a_worker_with_other_code_is_refused_before_anything_is_written(cluster, suite, tmp_path):
    cluster.worker("--no-nanny", code=OTHER_CODE)
    with pytest.raises(BadInput, match=r"dask worker tcp://\S+ has other code than this process .*install the same"):
        helmbench.run_suite(suite, directory=tmp_path / "out", scheduler=cluster.address)
    assert not (tmp_path / "out").exists()


@pytest.mark.nightly
def test_a_lost_scheduler_is_one_line_and_the_run_goes_on_elsewhere(cluster, suite, tmp_path):
    worker = cluster.worker("--no-nanny")
    out, words = tmp_path / "out", ["--suite", suite, "--method", "ls", "--method", f"{tmp_path / 'bad.py'}:Slow"]
    command = [sys.executable, "-m", "helmbench", "run", *words, "--seeds", "1", "-o", str(out)]
    process = subprocess.Popen([*command, "--scheduler", cluster.address], stderr=subprocess.PIPE, text=True)
    wait_for((tmp_path / "bad.began").exists)
    rows = out / "runs.jsonl"
    wait_for(lambda: rows.exists() and rows.stat().st_size > 0)  # the row before may still be on its way
    cluster.scheduler.kill()
    worker.send_signal(signal.SIGKILL)
    said = process.communicate(timeout=90)[1]
    assert process.returncode == 2 and said.count("\n") == 1, said
    assert f"the dask cluster at {cluster.address} is lost" in said and "--resume" in said
    stored = helmbench.load_results(out)
    assert [row["method"] for row in stored.rows] == ["ls"] and not stored.complete
    found = helmbench.run_suite(resume=True, directory=out, jobs=1, timeout_s=1.0, trust=True)
    assert {row["method"]: row["status"] for row in found.rows} == {"ls": "ok", "slow": "failed"}


def test_a_worker_that_joins_later_with_other_code_does_not_compute():
    with pytest.raises(helmbench.BadInput, match="a dask worker has other code"):
        clusters.on_worker("9.9+other", float, "1")


def test_a_missing_dask_is_told_in_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BadInput, match=r"helmbench\[distributed\]"), clusters.cluster("tcp://127.0.0.1:8786"):
        pass


def test_a_scheduler_out_of_reach_is_told_in_one_line(monkeypatch):
    monkeypatch.setattr(clusters, "CONNECT_S", 1)
    with pytest.raises(BadInput, match="no dask scheduler at tcp://"), clusters.cluster("tcp://127.0.0.1:1"):
        pass
