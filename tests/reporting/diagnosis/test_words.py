"""Sentences and sizes of a diagnosis."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from helmbench.checks.result import Size
from helmbench.diagnosis.result import Curve, Gain, RemainingForce
from helmbench.reporting.diagnosis import words
from helmbench.reporting.diagnosis.page import page
from helmbench.reporting.media import html, terminal, write_markdown

from ...made_up.diagnosis import made_up


@pytest.mark.parametrize(
    ("item", "text"),
    [
        (Size("delta0", 0.01, 0.009, 0.011, "rad"), "delta0 0.573 deg [0.516, 0.63]"),
        (Size("e", -0.2, -0.25, -0.15, "1"), "e -20 % [-25, -15]"),
        (Size("b", 0.0039915, 0.003977, 0.0040062, "rad/s"), "b 0.229 deg/s [0.228, 0.23]"),
        (Size("Nrr", -0.003, -0.0030021, -0.0029979, "1"), "Nrr -0.003 +- 0.07 %"),
        (Size("towards", 2.4435, 2.4431, 2.4439, "rad"), "towards 140 deg +- 0.02 deg"),
        (Size("speed", 0.2, 0.1, 0.3, "m/s", "run_1"), "speed 0.2 m/s [0.1, 0.3] in run_1"),
        (Size("t0", 100.0, float("nan"), float("nan"), "s"), "t0 100 s [–, –]"),
    ],
)
def test_sizes_have_their_usual_units(item, text):
    assert words.size(item) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.42632853, "0.426"),
        (["propeller thrust", "resistance"], "propeller thrust, resistance"),
        ("Nrr", "Nrr"),
        (3, "3"),
        ({"rudder_delay": 0.5, "above": "10 deg"}, "rudder delay 0.5, above 10 deg"),
    ],
)
def test_details_are_short(value, text):
    assert words.detail(value) == text


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("rudder_offset cannot be told from constant_force", "Rudder offset cannot be told from constant force."),
        ("all is well.", "All is well."),
        ("", ""),
    ],
)
def test_reasons_are_sentences(text, told):
    assert words.sentence(text) == told


def test_the_verdict_names_cause_size_and_gain():
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    text, gain = words.verdict(found), found.gain["yaw_rate_rad_s"]
    _, unit, factor = words.channel("yaw_rate_rad_s")
    assert text.startswith("The simulation lacks rudder offset (")
    assert words.size(found.causes[0].sizes[0]) in text
    before, after = (words.number(factor * value) for value in (gain.rmse_before, gain.rmse_after))
    assert f"of the yaw rate from {before} to {after} {unit}" in text


def test_coefficients_are_wrong_and_not_lacking():
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    own = replace(found.causes[0], cause="base_coefficients", sizes=(Size("K", 0.1, 0.09, 0.11, "1/s"),))
    told = words.verdict(replace(found, causes=(own, *found.causes)))
    percent = 100.0 * (0.1 / found.model.parameters["K"] - 1.0)
    expected = f"The simulation has wrong parameters of the model (K {percent:+.0f} %) and lacks rudder offset ("
    assert told.startswith(expected)
    tied = replace(own, tied_with=("rudder_effectiveness",))
    assert words.verdict(replace(found, causes=(tied,))).startswith(
        "The simulation lacks either other values of parameters of the model or rudder e"
    )


def test_wrong_coefficients_are_told_by_group_as_changes_in_per_cent():
    found = made_up()
    (name, value), *_ = found.model.parameters.items()
    sizes = (Size(name, 0.75 * value, 0.7 * value, 0.8 * value, "1"), Size("thrust_scale", 0.33, 0.32, 0.34, "1"))
    details = {"groups": ["resistance", "propeller thrust (scale of K_T)"]}
    own = replace(found.causes[0], cause="base_coefficients", stage="free runs", sizes=sizes, details=details)
    told = words.verdict(replace(found, causes=(own,)))
    numbers = f"({name} -25 %, thrust +33 %)"
    assert told.startswith(f"The simulation has wrong resistance and propeller thrust {numbers}.")
    beside = [words.size_and_change(found.model, own, item) for item in sizes]
    assert beside == [f"{words.size(sizes[0])}, -25 %", words.size(sizes[1])]
    assert f"{beside[0]}; {beside[1]} (90 % interval)" in terminal(page(replace(found, causes=(own,))))


def of_records(found, *causes):
    """The diagnosis with causes that the records show by themselves."""
    sizes = (Size("b", 0.02, 0.01, 0.03, "rad/s"), Size("b", 0.03, 0.02, 0.04, "rad/s", "run_1"))
    own = tuple(replace(found.causes[0], cause=cause, stage="kinematics", sizes=sizes) for cause in causes)
    return replace(found, causes=(*found.causes, *own))


def test_what_the_records_show_by_themselves_is_told_apart():
    found = of_records(made_up("response-1", "rudder_offset", {"rudder_offset": 0.02}), "yaw_rate_bias", "channel_swap")
    first, second = words.verdict(found).split("]). ")[:2]
    bias = words.size(Size("b", 0.02, 0.01, 0.03, "rad/s"))
    shown = f"Found in the records themselves, and corrected: yaw rate bias ({bias}) and channel swap ({bias}"
    assert f"{first}]" == shown
    assert second.startswith("The simulation lacks rudder offset (")


def unchanged(found):
    """The diagnosis with an extension that changes no free run."""
    return replace(found, gain={name: replace(g, rmse_after=g.rmse_before) for name, g in found.gain.items()})


@pytest.mark.parametrize(
    ("verdict", "own", "texts"),
    [
        ("unexplained", True, ("explains; of these, rudder offset (", "fits best. Including it leaves the free-run ")),
        ("unexplained", False, ("known causes explains. The free-run error on held-out records is ",)),
        ("named", False, ("The simulation agrees with the records. The free-run error",)),
        ("partly_named", False, ("A part of its error remains. The free-run error",)),
    ],
)
def test_the_verdict_where_no_free_run_changes(verdict, own, texts):
    found = of_records(made_up("response-1", "rudder_offset", {"rudder_offset": 0.02}), "yaw_rate_bias")
    causes = found.causes if own else found.causes[1:]
    told = words.verdict(replace(unchanged(found), verdict=verdict, causes=causes))
    assert all(text in told for text in texts)
    assert " from " not in told


def test_channels_that_change_are_told_first():
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    rate = found.gain["yaw_rate_rad_s"]
    gain = found.gain | {"yaw_rate_rad_s": replace(rate, rmse_after=rate.rmse_before)}
    told = words.verdict(replace(found, gain=gain))
    assert "records: of the heading from " in told
    assert "yaw rate" not in told.partition("Including")[2]


def test_the_terminal_shows_the_gain_as_a_table():
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    lines = terminal(page(found)).splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("  channel"))
    rows = lines[head + 1 : head + 1 + len(found.gain)]
    assert [row.split("  ")[1] for row in rows] == [words.channel(name)[0] for name in found.gain]


def test_channels_that_are_predicted_worse_are_told():
    found = made_up()
    gain = found.gain["heading_rad"]
    blind = replace(gain, rmse_after=1.2 * gain.rmse_before, own_before=1.0, own_after=0.5)
    worse, only_blind = (
        replace(found, gain=found.gain | {"heading_rad": one}) for one in (replace(blind, own_after=1.2), blind)
    )
    said = "Held-out records are predicted worse than by the base model in heading: use the extended model with care."
    assert words.verdict(worse).endswith(said)
    said = "The error of heading grows only where a record's own neutral angle is not known."
    assert words.verdict(only_blind).endswith(said)
    assert "with care" not in words.verdict(found)


def test_the_headline_names_the_cause_and_its_gain():
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    gain = found.gain["heading_rad"]
    before, after = (words.number(words.DEG * value) for value in (gain.rmse_before, gain.rmse_after))
    assert words.headline(found) == f"Named: rudder offset; held-out error of the heading from {before} to {after} deg."


def test_the_headline_leaves_the_trials_own_trim_apart():
    """Half a degree of neutral angle hides what a model gains; where it is what is named, it counts."""
    offset = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    gain = replace(offset.gain["heading_rad"], own_before=np.deg2rad(5.0), own_after=np.deg2rad(1.0))
    found = replace(offset, gain=offset.gain | {"heading_rad": gain})
    inertia = replace(found, causes=(replace(found.causes[0], cause="rudder_delay"),))
    said = "Named: rudder delay; held-out error of the heading (own neutral angle) from 5 to 1 deg."
    assert words.headline(inertia) == said and words.headline(found) == words.headline(offset)
    (own,) = found.causes[0].sizes
    of_each = replace(found, causes=(replace(found.causes[0], sizes=(replace(own, record="zigzag"),)),))
    assert words.headline(of_each) == said.replace("delay", "offset")


@pytest.mark.parametrize("count", [1, 2, 5, 12, 40])
def test_the_headline_is_short(count):
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    causes = [replace(found.causes[0], cause=f"cause_{k}_of_many_words") for k in range(count)]
    told = words.headline(replace(found, causes=tuple(causes)))
    assert told.startswith("Named: cause 0 of many words") and len(told.split()) <= 25
    assert (f"and {count - 2} more" in told) == (count > 3) or count == 2


@pytest.mark.parametrize("verdict", ["adequate", "inconclusive", "unexplained"])
def test_the_headline_without_a_name_is_the_verdict(verdict):
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    told = words.headline(replace(found, verdict=verdict))
    assert told.startswith(verdict.capitalize()) and "rudder offset" not in told


@pytest.mark.parametrize(("trusted_s", "r2", "useful"), [(73.8, 0.94, True), (0.0, 0.94, False), (73.8, 0.3, False)])
def test_a_simulation_whose_errors_no_cause_explains_may_be_of_use(trusted_s, r2, useful):
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02}, verdict="unexplained")
    ahead = SimpleNamespace(
        trusted_s={found.model.id: trusted_s}, simple=(), score=lambda channel, name, horizon: SimpleNamespace(r2=r2)
    )
    told = words.headline(replace(found, ahead=ahead))
    assert ("up to 73.8 s ahead the simulation is of use: it predicts 94 % of the yaw rate" in told) == useful


def test_a_headline_says_when_forces_act_that_single_records_alone_have():
    spans = ["run-1, 10 to 14 s, while she goes astern", "run-2, 40 to 50 s"]
    events = tuple(
        RemainingForce("N", ("time",), f"a yaw moment that acts for a time: {span}", 0.5, {},
                       (Size("N_event", 2.0, 1.0, 3.0, "N m", "run"),), False, "a tug", "repeat it")
        for span in spans
    )  # fmt: skip
    found = replace(made_up(verdict="unexplained"), causes=(), remaining=events)
    most = f"most arise in 2 spans of time, first {spans[0]}"
    assert words.headline(found) == f"Unexplained: no known cause explains the errors; {most}."
    found = replace(found, verdict="adequate", remaining=events[1:])
    assert words.headline(found) == f"Adequate: the simulation agrees with the records but for {spans[1]}."


@pytest.fixture
def described():
    """A diagnosis that a moment by the heading describes, beside a force in time."""
    size = Size("N_heading_3_cos", 2e6, 1.9e6, 2.1e6, "N m")
    curve = Curve(
        "heading", "rad", "N m", (0.0, 1.0, 2.0), (2e6, -2e6, 2e6), (1.9e6, -2.1e6, 1.9e6), (2.1e6, -1.9e6, 2.1e6)
    )
    by_heading = RemainingForce(
        "N", ("heading",), "a yaw moment that depends on the heading, three times a turn; it takes 97 % off", 0.97,
        {"heading_rad": (0.3, 0.05)}, (size,), True, "a current", "turn through all headings",
        ("a yaw moment that grows through the record",), curve,
    )  # fmt: skip
    event = RemainingForce("Y", ("time",), "a sway force that acts once", 0.9, {}, (), False, "a tug", "repeat it")
    gain = {"heading_rad": Gain(0.3, 0.05, 0.1, 0.2, 0.5, 0.9, 1.0, 0.2, 0.03)}
    return replace(made_up(verdict="described"), causes=(), remaining=(by_heading, event), gain=gain)


def test_the_headline_of_what_is_described_names_what_it_depends_on_and_its_gain(described):
    assert words.headline(described) == (
        "Described: a yaw moment that depends on the heading, three times a turn, of no known cause; held-out error of "
        "the heading (own neutral angle) from 11.5 to 1.72 deg."
    )


def test_what_remains_is_said_with_size_reading_and_what_would_tell(described):
    first, second = map(words.remaining, described.remaining)
    assert (
        f"({words.size(described.remaining[0].sizes[0])})" in first and "To tell: turn through all headings." in first
    )
    assert "As likely: a yaw moment that grows through the record." in first and "It may be a current." in first
    assert "It is not a term of the extended model." in second and "not a term" not in first
    told = terminal(page(described))
    assert first in told and second in told


def test_the_page_and_the_published_text_show_the_force_as_a_curve(described, tmp_path):
    shown = html(page(described))
    assert words.remaining(described.remaining[0]) in shown
    assert shown.count("with its 90 % band, where the records hold data</figcaption>") == 1
    paths = write_markdown(page(described), tmp_path, "moment", "A moment")
    assert tmp_path / "moment-remaining-1.svg" in paths and tmp_path / "moment-remaining-2.svg" not in paths
    assert "moment-remaining-1.svg" in (tmp_path / "moment.md").read_text("utf-8")
