"""Operators that are typed once have numba's own signatures, and numba is left as it was."""

import operator

import pytest
from numba import types
from numba.core.errors import TypingError
from numba.core.registry import cpu_target
from numba.core.types.functions import BaseFunction

from helmbench.models.compilation import A1, A2, b1, f8, i8, njit
from helmbench.models.typing_memo import operators_typed_once

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
