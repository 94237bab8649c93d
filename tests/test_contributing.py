"""The examples in CONTRIBUTING.md work as they stand."""

import importlib.util
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import helmbench

TEXT = (Path(__file__).resolve().parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")


def example(language: str) -> str:
    (block,) = re.findall(rf"^```{language}\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)
    return block


@pytest.fixture
def vessel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The example vessel, as if its file lay beside the others."""
    from helmbench.models import vessel as vessels

    path = tmp_path / "training-ship.yaml"
    path.write_text(example("yaml"), encoding="utf-8")
    files = {**vessels.vessel_files(), path.stem: path}
    monkeypatch.setattr("helmbench.models.model.vessel_files", lambda: files)
    return helmbench.resolve("training-ship")


@pytest.fixture
def method(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The example method, loaded as a module of the methods room."""
    path = tmp_path / "ridge.py"
    path.write_text(example("python"), encoding="utf-8")
    spec = importlib.util.spec_from_file_location("helmbench.methods.ridge", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)
    return module.Ridge


def test_example_vessel_is_read(vessel):
    assert vessel.parameters == pytest.approx({"T": 21.0, "K": 0.11, "alpha": 140.0})
    assert vessel.suite["train"] == ["zigzag:20/20"]


def test_example_method_recovers_the_example_vessel(vessel, method):
    record = helmbench.generate(helmbench.Case("training-ship", "zigzag:20/20@euler"))
    exact = method(penalty=0.0).fit([record], vessel.blanked())
    np.testing.assert_allclose(exact.coefficients, vessel.coefficients, rtol=1e-9)
    shrunk = method(penalty=1e-4).fit([record], vessel.blanked())
    assert 1e-6 < np.max(np.abs(shrunk.coefficients / vessel.coefficients - 1.0)) < 0.5


def test_example_method_keeps_the_contract(method):
    from helmbench.methods.contract import check_method

    check_method(method)
