"""The registry: what it finds, what it refuses, and which packages it does not import."""

import subprocess
import sys
from types import SimpleNamespace

import pytest

from helmbench.methods import registry
from helmbench.methods.base import Method
from helmbench.methods.ls import Ls
from helmbench.methods.rls import FwRls
from helmbench.models import discovery
from helmbench.models.errors import BadInput

OWN = """
from helmbench.methods.ls import Ls

class Mine(Ls):
    name = "mine"
    title = "a method of one's own"

class Other:
    name = "other"
"""


def test_methods_are_found():
    found = registry.methods()
    assert {"ls", "rls", "fw-rls", "ekf", "output-error"} <= set(found)
    assert list(found) == sorted(found)
    assert all(issubclass(cls, Method) and cls.name == name and cls.title for name, cls in found.items())


def test_listing_loads_nothing_heavy():
    code = (
        "import sys; from helmbench.methods.registry import methods; methods();"
        "print([m for m in ('numba', 'sympy', 'scipy', 'pandas', 'pyarrow', 'sklearn') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == "[]"


def test_options_in_the_text():
    method = registry.make("fw-rls, mu=0.99,weight=5,variant=as_printed, prior=physical")
    assert isinstance(method, FwRls)
    assert (method.mu, method.weight, method.variant, method.prior) == (0.99, 5, "as_printed", "physical")
    assert registry.make("ls", scheme="midpoint").get_params() == {"scheme": "midpoint"}
    assert repr(registry.make("ls,scheme=midpoint")) == "Ls(scheme='midpoint')"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("lss", "unknown method 'lss'"),
        ("ls,midpoint", "not of the form name=value"),
        ("ls,colour=blue", "has no option 'colour'"),
        ("ls,scheme=backward", "unknown difference scheme"),
        ("fw-rls,variant=draft", "has no variant 'draft'"),
        ("nowhere.py:Mine", "no such file"),
    ],
)
def test_refusals(text, message):
    with pytest.raises(BadInput, match=message) as caught:
        registry.make(text)
    assert "\n" not in str(caught.value)


def test_a_method_from_a_file(tmp_path):
    file = tmp_path / "own.py"
    file.write_text(OWN)
    method = registry.make(f"{file}:Mine,scheme=midpoint")
    assert method.name == "mine" and isinstance(method, Ls) and method.get_params() == {"scheme": "midpoint"}
    for name in ("Other", "Nobody"):
        with pytest.raises(BadInput, match="not a subclass"):
            registry.make(f"{file}:{name}")
    file.write_text("import no_such_package_anywhere")
    with pytest.raises(BadInput, match="ModuleNotFoundError"):
        registry.make(f"{file}:Mine")


Plug = type("Plug", (Ls,), {"name": "plug", "title": "from another package"})
Twin = type("Twin", (Ls,), {"title": "has a name that is taken"})


def test_entry_points(monkeypatch):
    def installed(load):
        point = SimpleNamespace(value="elsewhere:Plug", load=load)
        monkeypatch.setattr(discovery, "_points", lambda group: [point] if group == registry.GROUP else [])

    def broken():
        raise ImportError("broken")

    installed(lambda: Plug)
    assert registry.methods()["plug"] is Plug
    installed(broken)
    with pytest.raises(BadInput, match=r"elsewhere:Plug: method plug-in cannot be loaded: broken"):
        registry.methods()
    installed(lambda: Twin)
    with pytest.raises(BadInput, match="'ls' is defined twice"):
        registry.methods()
