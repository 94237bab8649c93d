"""Finding diagnosers: own, of a file, of a plug-in."""

from types import SimpleNamespace

import pytest

from helmbench.diagnosis.baselines.naive import ResidualBic
from helmbench.diagnosis.registry import Diagnoser, diagnosers, find
from helmbench.models import discovery
from helmbench.models.errors import BadInput

OWN = """
from helmbench.diagnosis.registry import Diagnoser

class Mine(Diagnoser):
    name = "mine"
    title = "my own"

class Nameless(Diagnoser):
    pass
"""


def test_the_projects_own_are_known_by_name_and_title():
    found = diagnosers()
    assert list(found) == ["best-fit", "innovations", "nothing", "residual-bic", "sparse-regression"]
    assert all(cls.name == name and cls.title and issubclass(cls, Diagnoser) for name, cls in found.items())


def test_a_file_of_the_users_own_is_loaded(tmp_path):
    (tmp_path / "own.py").write_text(OWN)
    assert find(f"{tmp_path / 'own.py'}:Mine").name == "mine"
    with pytest.raises(BadInput, match="Diagnoser that sets 'name'"):
        find(f"{tmp_path / 'own.py'}:Nameless")


def test_an_unknown_one_is_refused_with_those_known():
    with pytest.raises(BadInput, match="residual-bic"):
        find("residual")


def point(load):
    return SimpleNamespace(value="elsewhere:Thing", load=load)


def test_plug_ins_are_added_and_clashes_refused(monkeypatch):
    class OwnDiagnoser(Diagnoser):
        name = "other"

    class Clash(Diagnoser):
        name = ResidualBic.name

    monkeypatch.setattr(discovery, "_points", lambda group: [point(lambda: OwnDiagnoser)])
    assert find("other") is OwnDiagnoser
    monkeypatch.setattr(discovery, "_points", lambda group: [point(lambda: Clash)])
    with pytest.raises(BadInput, match="defined twice"):
        diagnosers()
    monkeypatch.setattr(discovery, "_points", lambda group: [point(lambda: 1 / 0)])
    with pytest.raises(BadInput, match="cannot be loaded"):
        diagnosers()
