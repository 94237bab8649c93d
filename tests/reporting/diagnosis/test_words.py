"""Sentences and sizes of a diagnosis."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from helmbench.checks.result import Size
from helmbench.diagnosis.causes.registry import causes as known_causes
from helmbench.diagnosis.result import Curve, Finding, Gain, RemainingForce
from helmbench.reporting.diagnosis import words
from helmbench.reporting.diagnosis.page import page
from helmbench.reporting.diagnosis.tables import size_table
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
        (["propeller thrust", "resistance"], "propeller thrust; resistance"),
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
    assert " ".join(words.value_and_interval(found.causes[0].sizes[0])) in text
    before, after = (words.number(factor * value) for value in (gain.rmse_before, gain.rmse_after))
    assert f"of the yaw rate from {before} to {after} {unit}" in text


def test_coefficients_are_wrong_and_not_lacking():
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    own = replace(found.causes[0], cause="base_coefficients", sizes=(Size("K", 0.1, 0.09, 0.11, "1/s"),))
    told = words.verdict(replace(found, causes=(own, *found.causes)))
    percent = 100.0 * (0.1 / found.model.parameters["K"] - 1.0)
    expected = f"The simulation has wrong numbers of its own (K {percent:+.0f} %) and lacks rudder offset ("
    assert told.startswith(expected)
    tied = replace(own, tied_with=("rudder_effectiveness",))
    assert words.verdict(replace(found, causes=(tied,))).startswith(
        "The simulation lacks either the model's own numbers ("
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
    rows = [[cell.text for cell in row] for row in size_table(replace(found, causes=(own,))).rows]
    assert [[row[1], row[4]] for row in rows] == [[name, "-25 %"], ["thrust", ""]]
    value, interval = words.value_and_interval(sizes[1])
    assert rows[1][2:4] == [value, "32 to 34"] and interval == "[32, 34]"


def of_records(found, *causes):
    """The diagnosis with causes that the records show by themselves."""
    sizes = (Size("b", 0.02, 0.01, 0.03, "rad/s"), Size("b", 0.03, 0.02, 0.04, "rad/s", "run_1"))
    own = tuple(replace(found.causes[0], cause=cause, stage="kinematics", sizes=sizes) for cause in causes)
    return replace(found, causes=(*found.causes, *own))


def test_what_the_records_show_by_themselves_is_told_apart():
    found = of_records(made_up("response-1", "rudder_offset", {"rudder_offset": 0.02}), "yaw_rate_bias", "channel_swap")
    first, second = words.verdict(found).split("]). ")[:2]
    bias = " ".join(words.value_and_interval(Size("b", 0.02, 0.01, 0.03, "rad/s")))
    shown = f"Found in the records themselves, and corrected: yaw rate bias ({bias}) and channel swap ({bias}"
    assert f"{first}]" == shown
    assert second.startswith("The simulation lacks rudder offset (")


@pytest.fixture
def in_waves():
    """A diagnosis that names motion in waves alone, of all records and of each."""
    sizes = [
        Size(name, k * value, 0.9 * k * value, 1.1 * k * value, unit, record)
        for record, k in ((None, 1.0), ("run_0", 1.2), ("run_1", 0.8))
        for name, value, unit in (("period", 8.0, "s"), ("heading_rms", 0.01, "rad"))
    ]
    waves = Finding("wave_motion", (), "free runs", None, None, tuple(sizes), evidence="they swing")
    found = made_up(verdict="adequate")
    return replace(found, verdict="named", causes=(waves,), reason="apart from the motion in waves, all is well")


def test_motion_in_waves_is_told_apart_from_the_simulation(in_waves):
    waves = "wave motion (period of encounter 8 s, rms heading 0.573 deg)"
    assert words.headline(in_waves) == f"Named: {waves}; otherwise the simulation agrees with the records."
    told = words.verdict(in_waves)
    assert told.startswith("The records show wave motion (period of encounter 8 s [7.2, 8.8]; rms heading 0.573 deg [")
    assert "no error of the simulation. Apart from that, the simulation agrees with the records. The free-run" in told


def test_sizes_of_records_stand_in_a_table_and_what_was_not_tested_has_no_p_value(in_waves):
    told = terminal(page(in_waves))
    assert "The model stays as it is: what is found is of the records" in told and "RMSE after" not in told
    assert "there is no test of significance." in told and "p-value" not in told
    rows = [[cell.text for cell in row] for row in size_table(in_waves).rows]
    assert [row[2] for row in rows] == ["all", "all", "run_0", "run_0", "run_1", "run_1"]
    assert rows[2][1:] == ["period of encounter", "run_0", "9.6 s", "8.64 to 10.6"]
    assert "p-value 3e-9, adjusted for all causes tried" in terminal(page(made_up()))


def test_a_sensor_that_drifts_is_no_error_of_the_simulation():
    sizes = tuple(Size("psi_drift", x, x - 1e-4, x + 1e-4, "rad/s", r) for r, x in (("run_0", 0.0), ("run_1", 5e-4)))
    said = "a recorded heading that drifts through the record; it takes 100 % off"
    drift = RemainingForce("psi", ("time",), said, 1.0, {}, sizes, False, "a sensor that warms up", "repeat it")
    found = replace(made_up(verdict="described"), causes=(), remaining=(drift,), gain={})
    text = "Described: a recorded heading that drifts through the record (0.0286 deg/s in run_1)."
    assert words.headline(found) == text
    assert words.verdict(found) == "The errors are those of a sensor, not of the simulation."
    assert "(0.0286 deg/s [0.0229, 0.0344] in run_1)" in words.remaining(drift)


def unchanged(found):
    """The diagnosis with an extension that changes no free run."""
    return replace(found, gain={name: replace(g, rmse_after=g.rmse_before) for name, g in found.gain.items()})


@pytest.mark.parametrize(
    ("verdict", "own", "texts"),
    [
        ("unexplained", True, ("explains; of these, rudder offset (", "best. The extended model leaves the free-run ")),
        ("unexplained", False, ("known causes explains. The extended model leaves the free-run error",)),
        ("named", False, ("The simulation agrees with the records. The extended model leaves the free-run error",)),
        ("partly_named", False, ("A part of its error remains. The extended model leaves the free-run error",)),
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
    assert "yaw rate" not in told.partition("The extended model")[2]


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
    size = words.value_and_interval(found.causes[0].sizes[0])[0]
    said = f"Named: rudder offset ({size}); held-out heading error from {before} to {after} deg."
    assert words.headline(found) == said


def test_the_headline_leaves_the_trials_own_trim_apart():
    """Half a degree of neutral angle hides what a model gains; where it is what is named, it counts."""
    offset = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    gain = replace(offset.gain["heading_rad"], own_before=np.deg2rad(5.0), own_after=np.deg2rad(1.0))
    found = replace(offset, gain=offset.gain | {"heading_rad": gain})
    delay = replace(found.causes[0], cause="rudder_delay", sizes=(Size("tau", 1.5, 1.4, 1.6, "s"),))
    inertia = replace(found, causes=(delay,))
    said = "Named: rudder delay (1.5 s); held-out heading error (own neutral angle) from 5 to 1 deg."
    assert words.headline(inertia) == said and words.headline(found) == words.headline(offset)
    (own,) = found.causes[0].sizes
    of_each = replace(found, causes=(replace(found.causes[0], sizes=(replace(own, record="zigzag"),)),))
    assert words.headline(of_each) == said.replace("delay (1.5 s)", "offset (1.15 deg in zigzag)")


@pytest.mark.parametrize("count", [1, 2, 5, 12, 40])
def test_the_headline_is_short(count):
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    names = [name for name, entry in known_causes().items() if not entry.of_record][:count]
    own = tuple(replace(found.causes[0], cause=name) for name in names)
    told = words.headline(replace(found, causes=own))
    assert len(own) == count and told.startswith("Named: axis misalignment") and len(told.split()) <= words.LONGEST
    assert (" more; held-out" in told) == (count > 5)


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
    error = words.with_unit(words.DEG * found.gain["heading_rad"].rmse_after, "deg")
    said = f"Adequate: the simulation agrees with the records but for {spans[1]}; held-out heading error {error}."
    assert words.headline(found) == said


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
        "Described: a yaw moment that depends on the heading, three times a turn (2000000 N m), of no known cause; "
        "held-out heading error (own neutral angle) from 11.5 to 1.72 deg."
    )


def test_what_remains_is_said_with_size_reading_and_what_would_tell(described):
    first, second = map(words.remaining, described.remaining)
    assert "(2000000 N m [1900000, 2100000])" in first and "To tell: turn through all headings." in first
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


def of_thrust(**details):
    """A diagnosis that names the propeller's thrust by free runs."""
    found = made_up()
    sizes = (Size("thrust_scale", 0.25, 0.2, 0.3, "1"),)
    own = replace(found.causes[0], cause="base_coefficients", stage="free runs", sizes=sizes,
                  details={"groups": ["propeller thrust (scale of K_T)"], **details})  # fmt: skip
    return replace(found, causes=(own,))


def test_few_numbers_beside_all_others_are_told_as_such():
    found = of_thrust(beside="all of the model's own numbers")
    assert words.headline(found).startswith("Named: mostly propeller thrust (thrust +25 %).")
    assert "has wrong numbers, most of all propeller thrust (thrust +25 %)" in words.verdict(found)


def test_what_single_records_have_is_told_with_these():
    found = of_thrust(records=["run_1"])
    assert words.headline(found).startswith("Named: propeller thrust in run_1 (thrust +25 %).")
    assert "The simulation errs by propeller thrust in run_1 (thrust +25 %)" in words.verdict(found)


def test_a_tie_of_many_is_told_by_its_first_and_their_number():
    rivals = [f"a group of numbers with a long title {i}" for i in range(4)]
    found = replace(of_thrust(**{"would do as well": rivals}), verdict="tied")
    assert words.headline(found).startswith("Tied: propeller thrust or 4 others.")


def test_records_that_are_followed_badly_are_not_said_to_agree(in_waves):
    gain = {name: replace(one, r2_after=0.8) for name, one in in_waves.gain.items()}
    told = words.headline(replace(in_waves, gain=gain))
    assert "no cause is told of what remains; held-out heading error" in told and "agrees" not in told
