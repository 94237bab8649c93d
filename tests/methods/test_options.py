"""Options: one declaration makes the constructor, the check, the docstring, the list and the searched range."""

import inspect
import re
from typing import ClassVar

import pytest

from helmbench.estimation.methods_only.tuning.space import Real
from helmbench.methods.base import Method
from helmbench.methods.options import POSITIVE, option, whole, words
from helmbench.methods.registry import make, method_options, methods
from helmbench.models.errors import BadInput


class Tilted(Method):
    """Declares its options."""

    gain: float = option(2.0, "of the tilt", POSITIVE, Real(0.1, 10.0))
    side: str = option("port", "'port' or 'starboard'", words("side", ("port", "starboard")))
    steps: int | None = option(None, "None: as many as there are samples", whole(1, 9))
    loud: bool = option(False, "whether it tells")


class Steeper(Tilted):
    """Another default, another range, and an option of its own first."""

    offset: float = option(0.0, "added")
    gain = 4.0
    steps: int | None = option(searched=Real(1.0, 3.0))


class Plain(Method):
    """With a constructor of its own."""

    search_space: ClassVar = {"gain": Real(0.1, 10.0)}

    def __init__(self, gain: float = 2.0, loud: bool = False) -> None:
        self.gain, self.loud = gain, loud


def test_a_declaration_makes_the_constructor_the_list_and_the_docstring():
    assert Tilted(3.0, steps=2).get_params() == {"gain": 3.0, "side": "port", "steps": 2, "loud": False}
    assert list(inspect.signature(Tilted).parameters) == list(Tilted.options) == ["gain", "side", "steps", "loud"]
    assert Tilted.search_space == {"gain": Real(0.1, 10.0)} and Tilted.gain == 2.0
    assert "gain : a positive number; of the tilt" in Tilted.__doc__
    with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
        Tilted(colour="blue")


def test_a_subclass_changes_what_it_states():
    assert list(Steeper.options) == ["offset", "steps", "gain", "side", "loud"]
    assert Steeper().gain == 4.0 and Tilted().gain == 2.0
    assert Steeper.options["steps"].meaning == Tilted.options["steps"].meaning
    assert set(Steeper.search_space) == {"gain", "steps"}
    with pytest.raises(BadInput, match="gain is 0"):
        Steeper(gain=0).check_options()


class Fixed(Tilted):
    """Has one option of its base class, and states the others."""

    def __init__(self, gain: float = 3.0) -> None:
        super().__init__(gain, "starboard")


def test_a_constructor_may_state_options_of_its_base():
    fixed = Fixed(5.0)
    assert list(Fixed.options) == ["gain"] and fixed.get_params() == {"gain": 5.0}
    assert (fixed.side, fixed.loud) == ("starboard", False)
    with pytest.raises(BadInput, match="gain is -1"):
        Fixed(-1).check_options()
    assert Fixed.options["gain"].meaning == "of the tilt" and Fixed.search_space == {"gain": Real(0.1, 10.0)}


def test_a_constructor_of_its_own_works_as_well():
    (gain, loud) = Plain.options.values()
    assert (gain.default, gain.searched) == ("2.0", str(Real(0.1, 10.0)))
    assert loud.default == "false"
    with pytest.raises(BadInput, match="loud is 'no', true or false is needed"):
        Plain(loud="no").check_options()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"gain": 0.0}, "gain is 0.0, a positive number is needed"),
        ({"gain": "much"}, "gain is 'much', a positive number is needed"),
        ({"gain": True}, "gain is True, a positive number is needed"),
        ({"side": "left"}, "unknown side 'left'; known: port, starboard"),
        ({"steps": 10}, "steps is 10, a whole number from 1 to 9 is needed"),
        ({"steps": 1.5}, "steps is 1.5, a whole number from 1 to 9 is needed"),
        ({"loud": 1}, "loud is 1, true or false is needed"),
    ],
)
def test_impossible_values_are_refused_in_one_line(options, message):
    with pytest.raises(BadInput) as caught:
        Tilted(**options).check_options()
    assert str(caught.value) == message


def test_none_is_allowed_where_it_is_the_default():
    Tilted(steps=None).check_options()
    with pytest.raises(BadInput, match="gain is None"):
        Tilted(gain=None).check_options()


@pytest.mark.parametrize("name", methods())
def test_every_option_has_a_meaning_and_no_value_ends_in_a_traceback(name):
    cls = methods()[name]
    for one in method_options(name):
        assert one.meaning and "\n" not in one.meaning, one.name
        one.check(one.value)
        for value in (-1, 1.5, "words", float("nan"), None, True, [1]):
            try:
                cls(**{one.name: value}).check_options()
            except BadInput as error:
                assert "\n" not in str(error)


@pytest.mark.parametrize(("text", "own", "inner"), [("sklearn:SVR", "rows", "C"), ("tuned:ridge", "trials", "penalty")])
def test_what_wraps_lists_the_options_of_what_it_wraps(text, own, inner):
    names = [one.name for one in method_options(text)]
    assert names.index(own) < names.index(inner)


IMPOSSIBLE = {
    "ekf": "passes=0 inflation=0",
    "eso-rw-lssvr": "omega0=0 discretisation=other C=0",
    "euler-ls": "algorithm=A3",
    "fci-ls": "beta=-1 most=0 tolerance=-1",
    "fw-rls": "mu=0 mu=1.1 weight=0",
    "gp-narx": "trials=-1",
    "arx": "stride=0",
    "huber": "k=0 scheme=zoh",
    "iv": "instruments=none lag=0 iterations=0 horizon_s=-1 scheme=x",
    "ls": "scheme=backward",
    "ls-svr": "C=-1 scheme=other tuner=other variant=other",
    "lts": "coverage=0.5 starts=-1",
    "mi-rls": "length=0 length=2.5",
    "mlp": "alpha=-2",
    "moving-horizon": "horizon=1 step=0 step=1.5 step=0.4 forgetting=0 passes=0 inflation=0",
    "nmi-rls": "omega=0",
    "output-error": "max_iterations=0",
    "pem": "max_iterations=0",
    "pinn": "weight=0 spacing=0.5 iterations=0",
    "ridge": "penalty=-1",
    "rls": "p0=-1 prior=mine",
    "svf-ls": "omega=0 omega=-1 order=2",
    "tls": "scaling=none scheme=x",
    "tukey": "k=-1",
    "ukf": "alpha=0 alpha=1.5 beta=0 passes=0",
}


@pytest.mark.parametrize("text", [f"{name},{own}" for name, options in IMPOSSIBLE.items() for own in options.split()])
def test_impossible_options_of_methods_are_refused(text):
    _, key, _ = re.split("[,=]", text)
    with pytest.raises(BadInput, match=key) as caught:
        make(text)
    assert "\n" not in str(caught.value)
