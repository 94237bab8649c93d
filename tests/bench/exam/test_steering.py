"""No answer has a high score without a diagnosis."""

import pytest

from helmbench.bench.exam.answers import write
from helmbench.bench.exam.scores import ALL, _holds, _interval_score, score
from helmbench.models.errors import BadInput

from .entrants import submission
from .handmade import WORLDS, handmade, predicted

HULL = ("yaw_damping_quadratic", "sway_damping_quadratic", "yaw_damping_cubic", "crossflow_coupling", "loading_change",
        "shallow_water", "coefficient_shift", "speed_loss", "constant_force")  # fmt: skip
GROUPS = ("group:hull_yaw_linear", "group:hull_sway_linear", "group:rudder_effectiveness", "group:resistance")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return handmade(tmp_path_factory.mktemp("handmade"))


def scored(made, place, answers, entrant="somebody"):
    """(score over all worlds, answers by world) of a submission; answers : world -> answer, or one for all."""
    exam, _, file = made
    worlds = answers if set(answers) <= set(WORLDS) else dict.fromkeys(WORLDS, answers)
    scores, rows = score(exam.folder, file, [submission(place, exam, worlds=worlds, entrant=entrant)])
    return next(one for one in scores if one.kind == ALL), {row.world: row for row in rows}


def names(*texts):
    """One finding a text, ties joined by /."""
    parts = [text.split("/") for text in texts]
    return {"named": [{"cause": one[0], "tied_with": one[1:]} for one in parts]}


RIGHT = {
    "world-1": names("rudder_offset"),
    "world-2": names("yaw_rate_bias"),
    "world-3": names("rudder_effectiveness", "yaw_damping_quadratic"),
    "world-4": names("current"),
    "world-5": names("group:hull_yaw_linear"),
    "world-6": {"named": [{"cause": "group:rudder_large_angle"}]},
}


def test_the_right_names_have_all_points_and_no_name_those_of_the_controls(made, tmp_path):
    right, _ = scored(made, tmp_path / "right", RIGHT)
    nothing, _ = scored(made, tmp_path / "nothing", {})
    assert (right.points, right.alone, right.right_share) == (1.0, 1.0, 1.0)
    assert (nothing.points, nothing.alone, nothing.right_share) == (0.25, 0.25, 0.0)


def everything(exam, joined):
    texts = [*exam.causes, *GROUPS]
    parts = [texts[i::20] for i in range(20)]
    return names(*("/".join(part) for part in parts)) if joined else names(*texts[:20])


STEERED = {
    "one name in every world": lambda exam: names("rudder_offset"),
    "a name of the hull, which is no false alarm beside wrong numbers": lambda exam: names("constant_force"),
    "always unexplained": lambda exam: {"unexplained": True},
    "twenty names": lambda exam: everything(exam, joined=False),
    "every name, tied": lambda exam: everything(exam, joined=True),
    "two names tied with each other": lambda exam: names("rudder_offset/yaw_rate_bias", "yaw_rate_bias/rudder_offset"),
    "every name of the hull": lambda exam: names(*HULL),
    "a likely pair and every name of the hull": lambda exam: names("rudder_effectiveness", *HULL),
    "every group": lambda exam: names(*GROUPS),
    "every group, tied": lambda exam: names("/".join(GROUPS)),
    "every number that might be shifted": lambda exam: {
        "named": [{"cause": "coefficient_shift", "coefficient": name} for name in ("Nr", "Nv", "Yv", "Yr", "Xuu")]
    },
}


@pytest.mark.parametrize("strategy", STEERED)
def test_saying_more_than_is_known_does_not_pay(made, tmp_path, strategy):
    found, _ = scored(made, tmp_path / "own", STEERED[strategy](made[0]))
    assert found.points < 0.25 and found.right_share <= 0.25


def test_names_beside_the_right_one_count(made, tmp_path):
    """A right pair with further names of the hull is not right alone, and neither is one cause in two findings."""
    _, rows = scored(made, tmp_path / "hull", names("rudder_effectiveness", *HULL))
    assert (rows["world-3"].outcome, rows["world-3"].alone, rows["world-3"].points) == ("both", False, 0)
    _, rows = scored(made, tmp_path / "twice", names("rudder_offset", "wind/rudder_offset"))
    assert (rows["world-1"].alone, rows["world-1"].right_share) == (False, 0.5)


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (names("wind", "wind"), "world-1 named 1: 'wind' is named twice"),
        (
            {"named": [{"cause": "wind", "sizes": [{"parameter": "speed", "value": 1.0}] * 2}]},
            "world-1 named 0: size speed of all records is stated twice",
        ),
    ],
)
def test_what_is_stated_twice_is_refused(made, tmp_path, answer, told):
    with pytest.raises(BadInput, match=told):
        scored(made, tmp_path / "twice", {"world-1": answer})


@pytest.mark.parametrize("other", ["somebody", "Some-body ", "ＳＯＭＥＢＯＤＹ"])  # noqa: RUF001, full-width letters
def test_an_entrant_hands_in_once(made, tmp_path, other):
    exam, _, file = made
    paths = [submission(tmp_path / name, exam, entrant=who) for name, who in (("a", "somebody"), ("b", other))]
    with pytest.raises(BadInput, match=r"b/submission\.json: entrant .* is that of .*a/submission\.json too"):
        score(exam.folder, file, paths)
    assert len(score(exam.folder, file, [paths[0], submission(tmp_path / "c", exam, entrant="other")])[1]) == 16


@pytest.mark.parametrize("name", ["a\u202eb", "a\u200bb", "a\nb", " "])
def test_a_name_without_hidden_characters_is_asked_for(made, tmp_path, name):
    with pytest.raises(BadInput, match="entrant: needs 1 to 120 printable characters"):
        scored(made, tmp_path / "own", {}, entrant=name)


def sized(*sizes, cause="current"):
    return {"world-4": {"named": [{"cause": cause, "sizes": list(sizes)}]}}


def size(value, low=None, high=None, parameter="speed", record="train-1"):
    """The true speed of the current is .5 in train-1 and .4 in held_out-1."""
    return {"parameter": parameter, "value": value, "low": low, "high": high, "record": record}


def test_an_effect_counts_once_whatever_number_of_sizes_it_has(made, tmp_path):
    both = sized(size(0.5, 0.45, 0.55), size(0.4, 0.35, 0.45, record="held_out-1"))
    worlds = both | {"world-1": {"named": [{"cause": "rudder_offset", "sizes": [size(0.04, parameter="delta0")]}]}}
    found, _ = scored(made, tmp_path / "sizes", worlds)
    assert (found.sizes, found.wrong_size, found.coverage) == (2, pytest.approx(0.5), 1.0)


def test_a_size_that_is_not_stated_counts_as_none(made, tmp_path):
    found, _ = scored(made, tmp_path / "sizes", sized())
    assert (found.sizes, found.wrong_size, found.coverage) == (1, 1.0, None)


@pytest.mark.parametrize("half", [5.0, 1e9, 1.7e308])
def test_an_interval_that_holds_everything_holds_nothing(made, tmp_path, half):
    wide, _ = scored(made, tmp_path / "wide", sized(size(0.5, -half, half)))
    close, _ = scored(made, tmp_path / "close", sized(size(0.6, 0.55, 0.65)))
    assert (wide.coverage, close.coverage) == (0.0, 0.0) and wide.interval > close.interval


def test_an_interval_of_a_direction_is_less_than_half_a_turn(made, tmp_path):
    wide, _ = scored(made, tmp_path / "wide", sized(size(1.0, -2.1, 4.2, parameter="towards")))
    fair, _ = scored(made, tmp_path / "fair", sized(size(1.0, 0.5, 1.5, parameter="towards")))
    assert (wide.coverage, fair.coverage) == (0.0, 1.0)


def test_the_interval_score_is_least_for_the_true_quantiles():
    """Of a standard normal error about the truth 1: wider and narrower intervals have a worse mean score."""
    errors = [x / 100.0 for x in range(-400, 401)]
    weights = [2.718281828 ** (-0.5 * x * x) for x in errors]

    def mean(half):
        rows = [{"low": 1.0 + x - half, "high": 1.0 + x + half, "true": 1.0} for x in errors]
        return sum(w * _interval_score(row) for w, row in zip(weights, rows, strict=True)) / sum(weights)

    assert mean(1.645) < min(mean(1.2), mean(2.2))
    assert _holds({"low": -1.0, "high": 1.0, "true": 0.0, "covered": True, "rel_error": None})


def regime(side, threshold, variable="rudder"):
    where = {"variable": variable, "side": side, "threshold": threshold}
    return {"world-6": {"named": [{"cause": "group:rudder_large_angle", "regime": where}]}}


@pytest.mark.parametrize("where", [("above", -1.0), ("above", 0.0), ("below", 9.0), ("below", 1e300), ("above", 9.0)])
def test_a_regime_everywhere_or_nowhere_counts_nothing(made, tmp_path, where):
    found, _ = scored(made, tmp_path / "where", regime(*where))
    right, _ = scored(made, tmp_path / "right", regime("above", 0.25))
    near, _ = scored(made, tmp_path / "near", regime("above", 0.2))
    assert found.regime < 0.05 and 0.5 < near.regime < right.regime == 1.0


def test_motion_that_is_not_handed_in_counts_as_that_of_the_base_model(made, tmp_path):
    """Motion of the easiest world alone is no more than it is worth; `predicted` says how much there is."""
    exam, key, file = made
    place, path = tmp_path / "motion", submission(tmp_path / "base", exam, entrant="none")
    runs = {"a.csv": predicted(exam, key, "world-1", 1.01)}
    worlds = {"world-1": {"motion": {"held_out-1": "a.csv"}}}
    write(place, {"schema_version": 1, "exam": exam.id, "entrant": "one world", "worlds": worlds}, runs)
    scores, rows = score(exam.folder, file, [place, path])
    one, none = (score for score in scores if score.kind == ALL)
    assert (one.predicted, none.predicted, none.to_base) == (1 / 8, 0.0, pytest.approx(1.0))
    assert one.to_base == pytest.approx(0.1 ** (1 / 8)) and rows[0].to_base == pytest.approx(0.1)
