"""Every argument of every public function is told by its name where its type is wrong."""

import inspect
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import helmbench
from helmbench.models.argument_types import typed
from helmbench.models.errors import BadInput

PUBLIC = [n for n in helmbench.__all__ if inspect.isfunction(getattr(helmbench, n))]
PAIRS = [(f, p) for f in PUBLIC for p in inspect.signature(getattr(helmbench, f)).parameters]


@pytest.mark.parametrize(("function", "name"), PAIRS)
def test_a_wrong_type_is_told_with_the_name_of_the_argument(function, name):
    parameters = inspect.signature(getattr(helmbench, function)).parameters
    if parameters[name].annotation in ("Any", "ArrayLike | None", "Trust", "str | Sequence[str] | Array"):
        return  # what these allow is told by the function itself
    wrong = object()
    needed = {n: wrong for n, p in parameters.items() if p.default is p.empty and p.kind != p.VAR_KEYWORD}
    with pytest.raises(BadInput, match=rf"^({'|'.join((*needed, name))}) is <object.*; give "):
        getattr(helmbench, function)(**needed, **({} if name in needed else {name: wrong}))


def test_what_an_annotation_allows():
    @typed
    def function(texts: "Sequence[str]", number: "float | None" = None, flag: "bool" = False, *, path: "Path" = "x"):
        return texts, number, flag, path

    assert function(["a"], np.float32(2.0), True) and function(("a",), 3, np.bool_(True)) and function("a", None)
    for arguments, said in (
        ((["a", 3],), r"texts is \['a', 3\]; give several of these \(a text\)"),
        ((b"x",), "texts is b'x'"),
        ((["a"], True), "number is True; give a number"),
        ((["a"], 1.0, 1), "flag is 1; give True or False"),
        ((["a"], 1.0, "no"), "flag is 'no'"),
        ((["a"], 10**400), "number is a int; give a number"),
    ):
        with pytest.raises(BadInput, match=said):
            function(*arguments)
    with pytest.raises(BadInput, match="path is 3; give a path"):
        function(["a"], path=3)
    with pytest.raises(TypeError):
        function()
