"""Small identification suites and runs for the tests of bench."""

import dataclasses

from helmbench.bench.kinds.identification.plan import RunSpec
from helmbench.bench.kinds.identification.problems import Task
from helmbench.bench.suites import load_suite

TASK = Task(
    vessel="response-1",
    source="response-1",
    model="nomoto-1-cubic",
    train=("zigzag:20/20",),
    held_out=("zigzag:15/15:port",),
    noise="low",
)
OWN_METHOD = """
from helmbench.methods.base import CannotFit, Fit, FitFailed, Method

class Mine(Method):
    name = "mine"
    title = "for tests"

    def __init__(self, outcome="good"):
        self.outcome = outcome

    def estimate(self, records, model):
        if self.outcome == "not-applicable":
            raise CannotFit("no sway in\\n the record")
        if self.outcome == "failed":
            raise FitFailed("singular")
        if self.outcome == "bug":
            return {}["missing"]
        import numpy as np
        return Fit(np.full(len(model.coordinates), -0.1))
"""


def spec_of(maker="ls", **changes):
    name = maker.split(",")[0]
    return RunSpec("test", name, "corrected", maker, dataclasses.replace(TASK, **changes))


def suite_file(folder, text):
    path = folder / "mine.yaml"
    path.write_text("title: mine\nentries:\n" + text)
    return load_suite(str(path))


def own_method_file(folder):
    path = folder / "own.py"
    path.write_text(OWN_METHOD)
    return f"{path}:Mine"
