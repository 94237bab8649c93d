"""Operators that are typed once have numba's own signatures, and numba is left as it was."""

import operator
import re
import tomllib
from pathlib import Path

import numba
import pytest
from numba import types
from numba.core.caching import CompileResultCacheImpl, NullCache
from numba.core.ccallback import CFunc
from numba.core.dispatcher import Dispatcher
from numba.core.errors import TypingError
from numba.core.registry import cpu_target
from numba.core.types.functions import BaseFunction

from helmbench.models.compilation import A1, A2, b1, f8, i8, njit
from helmbench.models.numba_internals import operators_typed_once

ROOT = Path(__file__).resolve().parents[2]
OWNED = {
    BaseFunction: ("get_call_type",),
    CFunc: ("compile",),
    CompileResultCacheImpl: ("check_cachable", "rebuild", "reduce"),
    Dispatcher: ("compile", "disable_compile", "enable_caching", "get_compile_result"),
    NullCache: ("cache_path", "load_overload", "save_overload"),
}
"""Class of numba -> what is called, replaced or answered of it."""
OPERATORS = (operator.add, operator.sub, operator.mul, operator.truediv, operator.pow, operator.lt, operator.eq)
ARGUMENTS = ((f8, f8), (i8, f8), (f8, i8), (i8, i8), (b1, f8), (types.literal(2), f8), (f8, types.literal(2)))


def signature(op, arguments):
    context = cpu_target.typing_context
    context.refresh()
    return context.resolve_value_type(op).get_call_type(context, arguments, {})


@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_signatures_are_numbas(arguments):
    theirs = [signature(op, arguments) for op in OPERATORS]
    with operators_typed_once():
        first, again = ([signature(op, arguments) for op in OPERATORS] for _ in range(2))
    assert first == theirs and again == theirs
    assert all(one is other for one, other in zip(first, again, strict=True))


@pytest.mark.parametrize("arguments", [(A1, i8), (A2, types.UniTuple(i8, 2)), (A1, types.slice2_type)], ids=str)
def test_places_of_arrays_have_numbas_signatures(arguments):
    theirs = signature(operator.getitem, arguments)
    with operators_typed_once():
        assert [signature(operator.getitem, arguments) for _ in range(2)] == [theirs, theirs]


def test_what_has_no_signature_is_refused_each_time():
    with operators_typed_once():
        for _ in range(2):
            with pytest.raises(TypingError):
                signature(operator.mul, (f8, types.none))


def test_numba_is_left_as_it_was():
    before = BaseFunction.get_call_type
    with pytest.raises(TypingError), operators_typed_once():
        assert BaseFunction.get_call_type is not before
        njit(f8(f8), cache=True)(lambda x: x + "metres")
    assert BaseFunction.get_call_type is before


def test_numba_has_what_is_used_of_it():
    lacking = [f"{one.__name__}.{name}" for one, names in OWNED.items() for name in names if not hasattr(one, name)]
    assert not lacking, f"numba {numba.__version__} lacks {', '.join(lacking)}: see models/numba_internals.py"
    compiled = numba.njit(f8(f8))(lambda x: x + 1.0)
    ((_, result),) = compiled.overloads.items()
    assert hasattr(result.library, "get_pointer_to_function") and hasattr(compiled, "_cache")


def test_no_other_file_knows_numbas_internals():
    others = {".venv", "build", "tests", "out", "dist"}
    own = [p for p in ROOT.rglob("*.py") if not others & set(p.relative_to(ROOT).parts)]
    users = [p.relative_to(ROOT) for p in own if re.search(r"numba\.core|llvmlite\.", p.read_text("utf-8"))]
    assert [p.as_posix() for p in users] == ["models/numba_internals.py"]


def test_the_versions_are_bounded_alike():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    (asked,) = [d for d in project["dependencies"] if d.startswith("numba")]
    bounds = re.search(r">=([\d.]+),<([\d.]+)", asked)
    assert bounds is not None
    said = f"numba >= {bounds[1]}, < {bounds[2]}"
    assert said in (ROOT / "models/numba_internals.py").read_text("utf-8")
    assert said.replace("= ", "=").replace(", < ", ",<") in (ROOT / "conda/recipe.yaml").read_text("utf-8")
