"""Texts that are no decimal number of ASCII digits, at every place where somebody types a number."""

import json

import pytest

from helmbench.cli import status_of
from helmbench.datasets.disturbances import parse_disturbance
from helmbench.datasets.io import read_record
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import parse_noise
from helmbench.methods.registry import _value
from helmbench.models.data_file import load
from helmbench.models.errors import BadInput
from helmbench.models.number_texts import number_of, whole_of
from helmbench.models.parameter_table import model_of_table

NO_NUMBERS = {
    "digits of other scripts": ["\uff11\uff12", "\u0661\u0662", "\u0967", "1\uff10", "\u00b2", "\u2460", "\U0001d7d9"],
    "signs of other scripts": ["\u22121", "\uff0b1", "1\uff0e5", "1\uff455", "1\u066b5"],
    "underscores and groups": ["1_0", "1_0.0_1", "1,000", "1 000", "1'000", "1\u00a0000", "_1", "1_"],
    "other bases and notations": ["0x10", "0b1", "0o7", "1e", "e5", "1e5.0", "1d5", "1^5", "1/2", "1j", "--1", "."],
    "no numbers": ["nan", "NaN", "inf", "-inf", "Infinity", "1#INF", "true", "None", "one", "-", "", "(1)", "=1"],
    "units": ["1kg", "3 t", "5%%", "1m/s", "$1", "1\u00b0"],
    "too large or small": ["1e99999", "-1e99999", "1e-99999", "9" * 400, "1e309"],
    "hidden characters": ["1\u200b", "\u202e1", "1\0", "\ufeff1", "1\u00ad0", "1\n2"],
}  # fmt: skip
TEXTS = [text for texts in NO_NUMBERS.values() for text in texts]


@pytest.mark.parametrize("kind", NO_NUMBERS)
def test_what_is_no_decimal_number_is_none(kind):
    for text in NO_NUMBERS[kind]:
        for read in (number_of, whole_of):
            with pytest.raises(ValueError, match=r"is not a|too large|too small|digits, at most"):
                read(text)


def test_decimal_numbers_are_read():
    assert [number_of(text) for text in ("1", "-0.5", "+1e-3", ".5", "5.", "0", "0.0e-99999", "1E3")] == [
        *(1.0, -0.5, 1e-3, 0.5, 5.0, 0.0, 0.0, 1e3),
    ]
    assert [whole_of(text) for text in ("0", "-3", "+07", "9" * 18)] == [0, -3, 7, 10**18 - 1]
    with pytest.raises(ValueError, match="a number of 19 digits, at most 18 are read"):
        whole_of("9" * 19)


@pytest.mark.parametrize("kind", NO_NUMBERS)
def test_no_grammar_takes_them(kind):
    """Manoeuvres, disturbances and noise; a unit of the grammar behind the number is none of these texts."""
    for text in NO_NUMBERS[kind]:
        for read, around in (
            (parse_manoeuvre, "zigzag:{}/20"),
            (parse_manoeuvre, "sine:20deg/{}s"),
            (parse_manoeuvre, "turn:{}"),
            (parse_disturbance, "wind:{}@40"),
            (parse_disturbance, "waves:{}/5@40"),
            (parse_noise, "yaw_rate={}deg_s"),
            (parse_noise, "medium,dropout={}%"),
            (parse_noise, "medium,gaps=5%/{}"),
        ):
            if text == "" and around.endswith("/{}"):  # the usual number of samples
                continue
            with pytest.raises(BadInput):
                read(around.format(text))


@pytest.mark.parametrize("kind", NO_NUMBERS)
def test_no_option_of_a_command_takes_them(kind, tmp_path, capsys):
    out = tmp_path / "out.csv"
    for text in NO_NUMBERS[kind]:
        for option in ("--dt", "--duration", "--seed"):
            given = ["simulate", "cargo", "--manoeuvre", "zigzag:10/10", f"{option}={text}", "-o", str(out)]
            assert status_of(given) == 2, (option, text)
            assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert not out.exists()


def test_a_method_takes_them_as_words():
    assert [text for text in TEXTS if not isinstance(_value(text), str | bool | None)] == []
    assert (_value("3"), _value("0.99")) == (3, 0.99)


@pytest.mark.parametrize("kind", NO_NUMBERS)
def test_no_table_of_parameters_takes_them(kind, tmp_path):
    for text in NO_NUMBERS[kind]:
        for name, content in (
            ("t.json", json.dumps({"T": text, "K": 0.1})),
            ("t.csv", f"name,value\nK,0.1\nT,{json.dumps(text, ensure_ascii=False)}\n"),
        ):
            if name == "t.csv" and text == "\u22121":  # a minus sign of a printed table
                continue
            (tmp_path / name).write_text(content, "utf-8")
            with pytest.raises(BadInput):
                model_of_table(tmp_path / name, "nomoto-1", "starboard", None, None)


def test_no_record_takes_them(tmp_path):
    path = tmp_path / "run.csv"
    for text in (text for text in TEXTS if text.lower() not in ("nan", "") and "e-9" not in text):
        rows = [f"{0.5 * k},0.1,{text if k == 5 else 0.01 * k}" for k in range(40)]
        path.write_text("\n".join(["time_s,rudder_rad,yaw_rate_rad_s", *rows, ""]), "utf-8")
        with pytest.raises(BadInput):
            read_record(path)


@pytest.mark.parametrize(
    "text", ["!!int '\uff11\uff12'", "!!int 1_0", "!!float 1_0.5", "!!float '\u0661'", "!!float nan"]
)
def test_no_tag_of_yaml_makes_them_numbers(text, tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(f"a: {text}\n", "utf-8")
    with pytest.raises(BadInput):
        load(path)
