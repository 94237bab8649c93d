"""Sources that are generated with hostile texts in every field of a model: they are the ones of a harmless text."""

import ast
import io
import json
import keyword
import re
import shutil
import subprocess
import sys
import zipfile
from dataclasses import replace
from functools import cache
from unicodedata import category
from xml.etree import ElementTree

import pytest

from helmbench.models.errors import BadInput
from helmbench.models.export.equations import statements
from helmbench.models.export.formats import FORMATS, exported
from helmbench.models.export.texts import inert, name_of
from helmbench.models.kernels import catalogue, load
from helmbench.models.model import list_vessels, model_to_json, resolve

from ..support.hostile_texts import HOSTILE, KINDS

FIELDS = ("id", "title", "source", "positive_rudder")
VESSELS = dict.fromkeys(("simulink", "vehicle-simulator", "fmu"), "response-1") | dict.fromkeys(
    ("mmgdynamics", "gazebo"), "kvlcc2-l7"
)
"""Format -> a vessel of it whose export is quick."""
HARMLESS = dict.fromkeys(FIELDS, "harmless")
HIDDEN = ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")
C_TOKENS = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|.', re.DOTALL)
PLAIN_NAME = re.compile(r"(sources/)?([A-Za-z][A-Za-z0-9_]{0,62})(\.sdf)?\.[a-z]+|modelDescription.xml")
TAKEN = {*keyword.kwlist, *sys.stdlib_module_names, "con", "nul", "aux", "sin"}
MATLAB_LINE = re.compile(r"(?:'(?:''|[^'\n])*'|(?<=[\w\])}.'])'|[^'%\n])*(?:%[^\n]*)?")
"""Code with literals and transposes, then a comment."""


STATEMENTS = {}


@pytest.fixture(autouse=True)
def _quick(monkeypatch):
    """No test of this file waits for a library, or for equations that were simplified for an earlier text."""

    def once(own, printer):
        key = own.name, type(printer)
        STATEMENTS[key] = STATEMENTS[key] if key in STATEMENTS else statements(own, printer)
        return STATEMENTS[key]

    monkeypatch.setattr("helmbench.models.export.fmu._compiled", lambda name, source: {})
    monkeypatch.setattr("helmbench.models.export.equations.statements", once)


def files(to, texts):
    """Name -> text of everything that a format writes for a model with these texts."""
    found = exported(replace(resolve(VESSELS[to]), **texts), to)
    if to != "fmu":
        return dict(found)
    ((name, content),) = found.items()
    with zipfile.ZipFile(io.BytesIO(content)) as unit:
        return {name: ""} | {place: unit.read(place).decode() for place in unit.namelist()}


def hidden(found):
    """Characters of the files that are not seen, but for ends of lines."""
    return {letter for letter in set("".join(found.values())) - {"\n"} if category(letter) in HIDDEN}


def is_plain(name):
    """Whether the name of a file is made of a plain word that means nothing to a system or a language."""
    found = PLAIN_NAME.fullmatch(name)
    return found and (found[2] or "").lower() not in TAKEN


def code_of_c(text):
    """The C source without its comments and its identifier."""
    assert "??" not in text
    tokens = [token for token in C_TOKENS.findall(text) if not token.startswith(("/*", "//"))]
    return re.sub(r'"[0-9a-f-]{36}"', '"GUID"', "".join(tokens))


def code_of_python(text):
    """The tree of a Python source without its docstring, the name of its class and the name in it."""
    tree = ast.parse(text)
    compile(tree, "exported", "exec")
    assert isinstance(tree.body[0].value.value, str)
    (vehicle,) = (node for node in tree.body if isinstance(node, ast.ClassDef))
    vehicle.name, tree.body[0].value.value = "Vehicle", ""
    (named,) = (node for node in ast.walk(vehicle) if isinstance(node, ast.Assign) and ".name," in ast.unparse(node))
    assert isinstance(named.value.elts[0].value, str)
    named.value.elts[0].value = ""
    return ast.dump(tree)


def code_of_matlab(text, name):
    """The lines of an .m file without comments and without what its literals say; the file's name as NAME."""
    lines = []
    for line in text.split("\n"):
        assert MATLAB_LINE.fullmatch(line), line
        shown = re.sub(r"'(?:''|[^'])*'(?=[\s;,})\]])", "'TEXT'", line)
        lines.append(re.sub(rf"\b{name}(?=\b|_)", "NAME", re.sub(r"%.*", "%", shown)))
    return lines


def code_of_xml(text):
    """Names of all elements with their attributes' names, and the numbers of elements."""
    tree = ElementTree.fromstring(text.encode())
    return [(node.tag, sorted(node.attrib), (node.text or "").strip()) for node in tree.iter()]


def codes(to, texts):
    """What stays of every file of a format without the texts in it, by its place among the files.  No file holds a
    character that is not seen, and its name is a plain word."""
    found = files(to, texts)
    assert not hidden(found) and all(map(is_plain, found)), ascii(texts)
    name = re.split(r"[.]", next(iter(found)))[0]
    readers = {"c": code_of_c, "py": code_of_python, "xml": code_of_xml, "m": lambda text: code_of_matlab(text, name)}
    readers |= {"fmu": str, "json": lambda text: json.loads(text) | {"comment": len(json.loads(text)["comment"])}}
    return [readers[place.rpartition(".")[2]](text) for place, text in found.items()]


@cache
def harmless(to):
    """What stays of the files with a harmless text in every field."""
    return codes(to, HARMLESS)


def with_text(text):
    return dict.fromkeys(FIELDS, text)


@pytest.mark.parametrize("to", FORMATS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_source_with_hostile_texts_is_the_one_of_a_harmless_text(kind, to):
    """Comments and literals apart the sources are equal, so that no text of any field ended where it stands."""
    for text in HOSTILE[kind]:
        assert codes(to, with_text(text)) == harmless(to), (text, to)


@pytest.mark.parametrize("to", FORMATS)
@pytest.mark.parametrize("field", FIELDS)
def test_no_field_alone_becomes_code(field, to):
    for text in ("*\\", 'ends in "', "--->", "'\nimport os", "\u2028x", "\\"):
        assert codes(to, HARMLESS | {field: text}) == harmless(to), (field, text, to)


@pytest.mark.nightly
@pytest.mark.parametrize("to", FORMATS)
def test_no_source_holds_a_character_that_is_not_seen(to):
    for text in (text for texts in HOSTILE.values() for text in texts if len(text) < 1000):
        assert not hidden(files(to, HARMLESS | {"title": text, "source": text})), ascii(text)


def test_every_c_source_with_a_hostile_text_compiles(tmp_path):
    """One call of the compiler for sources of as many texts as there are fields, warnings of comments being errors."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    texts = [text for texts in HOSTILE.values() for text in texts]
    for place in range(0, len(texts), len(FIELDS)):
        some = dict(zip(FIELDS, texts[place : place + len(FIELDS)], strict=False))
        (source,) = (code for name, code in files("fmu", some).items() if name.endswith(".c"))
        (tmp_path / f"{place}.c").write_text(source, "utf-8")
    command = [compiler, "-fsyntax-only", "-std=c99", "-Wcomment", "-Wtrigraphs", "-Werror"]
    done = subprocess.run([*command, *sorted(tmp_path.glob("*.c"))], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.nightly
@pytest.mark.parametrize("to", FORMATS)
def test_names_of_files_are_plain_words(to):
    for text in ("", *HOSTILE["names"], *HOSTILE["line breaks"]):
        assert all(map(is_plain, files(to, HARMLESS | {"id": text}))), text


def test_a_harmless_text_stays_as_it_is():
    """So do the names and units of every family, and titles and identifiers of the vessels."""
    assert inert("Yasukawa & Yoshimura (2015), 日本丸, ünï: doi 10.1007/s1_x-y") == (
        "Yasukawa & Yoshimura (2015), 日本丸, ünï: doi 10.1007/s1_x-y"
    )
    assert inert("Fossen's toolbox") == "Fossen\u2019s toolbox"
    for family in catalogue():
        for text in (*load(family).PARAMETERS, *load(family).UNITS, *load(family).STATES, *load(family).INPUTS):
            assert inert(text) == text
    for vessel in list_vessels():
        model = resolve(vessel)
        assert inert(model.title) == model.title and name_of(model.id) == model.id.replace("-", "_")


@pytest.mark.parametrize("block", ["coefficients", "parameters", "constants", "instruments"])
def test_a_model_file_has_no_names_but_those_of_its_family(block, tmp_path):
    """So that no name of a file is written into a source."""
    path = tmp_path / "model.json"
    model_to_json(resolve("kvlcc2-l7"), path)
    content = json.loads(path.read_text())
    entry = {"value": 1.0, "unit": "1"} if block in ("parameters", "instruments") else 1.0
    for text in ("__import__('os').system('id')", "Y_v; import os", "Y_v\\", "Y_v\u200b", "", "\uff39_v"):
        path.write_text(json.dumps(content | {block: content.get(block, {}) | {text: entry}}))
        with pytest.raises(BadInput):
            exported(resolve(path), "vehicle-simulator")


def test_a_family_is_an_identifier_of_equations(tmp_path):
    path = tmp_path / "model.json"
    model_to_json(resolve("response-1"), path)
    content = json.loads(path.read_text())
    for family in (
        "nomoto-1+x'",
        "nomoto-1\n",
        "../x",
        "mmg+N_r_absv;",
        "nomoto-1~a b",
        "nomoto-1+__import__",
        "\uff4b\uff54",
    ):
        path.write_text(json.dumps(content | {"family": family}))
        with pytest.raises(BadInput):
            resolve(path)
