"""Numbers of every size in manoeuvre and disturbance strings end in a record or in one line."""

import pytest

import helmbench
from helmbench.cli import status_of

MANOEUVRES = ["spiral:20/1e-320", "zigzag:1e-320/20", "turn:" + "9" * 400, "sine:20deg/1e-320s", "straight:1e308"]
DISTURBANCES = ["waves:1/1e308@0", "waves:1e308/8@0", "waves:1/1e-320@0", "wind:1e308@0", "current:1e308@0"]


@pytest.mark.parametrize("text", [*MANOEUVRES, *DISTURBANCES])
def test_extreme_numbers_are_told(text):
    manoeuvre, disturbance = (text, "none") if text in MANOEUVRES else ("turn:10", text)
    with pytest.raises(helmbench.BadInput, match=r"no size|above|nothing may follow|manoeuvre .turn:9999"):
        helmbench.simulate("mariner", manoeuvre, duration_s=30.0, dt_s=0.5, disturbance=disturbance)


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("manoeuvre", None),
        ("noise", 3),
        ("disturbance", 3),
        ("duration_s", "60"),
        ("duration_s", 10**400),
        ("seed", 1.5),
        ("dt_s", [1]),
    ],
)
def test_an_argument_of_the_wrong_type_is_told_by_its_name(argument, value):
    with pytest.raises(helmbench.BadInput, match=rf"^{argument} is .*; give a"):
        helmbench.simulate("response-1", **{"manoeuvre": "turn:10", argument: value})


def test_an_empty_paper_is_none_of_the_five():
    with pytest.raises(helmbench.BadInput, match="paper"):
        helmbench.reproduce("")


def test_settings_of_numba_in_the_working_folder_are_refused(tmp_path, monkeypatch, capsys):
    (tmp_path / ".numba_config.yaml").write_text("cache_dir: /tmp/elsewhere")
    monkeypatch.chdir(tmp_path)
    assert status_of(["list", "models"]) == 2 and ".numba_config.yaml" in capsys.readouterr().err
