"""Free runs of left-out pieces: columns against differences of simulations, names and sizes where they are known."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.datasets.generator import Case as Manoeuvre
from helmbench.datasets.generator import generate
from helmbench.datasets.instruments import behind_play, felt_rudder, quietened, rudder_noise
from helmbench.datasets.record import Record
from helmbench.diagnosis.causes.missing_terms import MissingTerm
from helmbench.diagnosis.causes.registry import causes
from helmbench.diagnosis.diagnose import diagnose, to_side
from helmbench.diagnosis.free_runs.linearisation import FEW, STEP
from helmbench.diagnosis.free_runs.units import Lane, length_s, units_of
from helmbench.diagnosis.one_bank.catalogue import Facts, bank_of
from helmbench.diagnosis.one_bank.diagnose import runs_of
from helmbench.diagnosis.one_bank.forces import forces_along
from helmbench.diagnosis.one_bank.regimes import place_in
from helmbench.diagnosis.options import Options
from helmbench.estimation.run.run import run_along
from helmbench.estimation.selection.number import Number
from helmbench.models.coefficient_groups import local_numbers, values_of, with_values
from helmbench.models.errors import CannotFit
from helmbench.models.extend import extended
from helmbench.models.families.extensions import extension_of
from helmbench.models.instruments import INSTRUMENTS
from helmbench.models.model import RudderGear, resolve
from helmbench.models.regimes import regime
from helmbench.models.simulate import simulate
from helmbench.reporting.diagnosis import words

from ...nightly_marks import nightly_but

RATE = np.deg2rad(2.0)


@pytest.fixture(scope="module")
def ship():
    """A response model, and records of it whose column is the command of a gear that turns at RATE."""
    nomoto = resolve("nomoto-1")
    model = nomoto.with_coefficients(nomoto.from_parameters({"T": 8.0, "K": 0.12}))
    return model, [commanded(model, amplitude, seed) for seed, amplitude in enumerate((20.0, 10.0))]


def commanded(model, amplitude, seed):
    """A record under commands that reverse every 20 to 35 s."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 240.0, 0.5)
    turns = np.searchsorted(np.cumsum(rng.uniform(20.0, 35.0, 20)), time)
    command = np.deg2rad(amplitude) * (-1.0) ** turns
    felt = felt_rudder(time, command, {"rudder_rate_limit": RATE})
    states = simulate(model, felt[:, None], 0.5, np.zeros(len(model.states)))
    r, psi = (states[:, model.states.index(s)] for s in ("r", "psi"))
    noise = rng.standard_normal((2, time.size))
    r, psi = r + 5e-4 * noise[0], psi + 1e-3 * noise[1]
    return Record(time, {"rudder_command_rad": command, "yaw_rate_rad_s": r, "heading_rad": psi}, f"commands-{seed}")


def test_a_slow_gear_behind_commands_is_named_with_its_rate(ship):
    model, records = ship
    found = diagnose(model, records[:1], records[1:], Options())
    assert [f.cause for f in found.causes] == ["rudder_rate_limit"] and found.verdict == "named"
    (size,) = found.causes[0].sizes
    assert size.low < RATE < size.high and size.value == pytest.approx(RATE, rel=0.1)
    assert found.gain["heading_rad"].rmse_after < 0.2 * found.gain["heading_rad"].rmse_before
    assert found.extended.instruments["rudder_rate_limit"] == pytest.approx(size.value)
    assert np.array_equal(found.extended.coefficients, model.coefficients)


@pytest.mark.parametrize(
    "known", [{"instruments": {"rudder_rate_limit": RATE}}, {"rudder": RudderGear(rate_rad_s=RATE)}]
)
def test_nothing_is_named_where_the_gear_is_known(ship, known):
    model, records = ship
    exact = replace(model, **known)
    found = diagnose(exact, records[:1], records[1:], Options())
    assert not found.causes and found.verdict == "adequate"
    assert all(g.rmse_after == pytest.approx(g.rmse_before) for g in found.gain.values())


def test_a_gear_that_is_faster_than_the_vessels_own_is_named_with_its_rate(ship):
    """What a gear does of orders that stand in the record can be undone."""
    model, records = ship
    slow = replace(model, rudder=RudderGear(rate_rad_s=0.3 * RATE))
    found = diagnose(slow, records[:1], records[1:], Options())
    assert [f.cause for f in found.causes] == ["rudder_rate_limit"]
    assert found.causes[0].sizes[0].value == pytest.approx(RATE, rel=0.1)
    assert found.gain["heading_rad"].rmse_after < 0.2 * found.gain["heading_rad"].rmse_before


def test_a_base_model_that_states_the_wrong_side_is_turned_and_told(ship):
    model, records = ship
    known = replace(model, rudder=RudderGear(rate_rad_s=RATE), positive_rudder="port")
    found = diagnose(known, records[:1], records[1:], Options())
    assert [f.cause for f in found.causes] == ["rudder_sign"] and found.verdict == "named"
    assert found.extended.positive_rudder == "starboard" and "states the other side" in found.causes[0].evidence
    assert words.verdict(found).startswith("The simulation turned its rudder to the wrong side, which was corrected.")


def test_a_model_and_records_that_both_state_the_wrong_side_are_run_as_they_are(ship):
    model, records = ship
    known = replace(model, rudder=RudderGear(rate_rad_s=RATE), positive_rudder="port")
    wrong = [to_side(r, "port") for r in records]
    found = diagnose(known, wrong[:1], wrong[1:], Options())
    assert not found.causes and found.verdict == "adequate"
    assert any("they were read with positive_rudder: starboard" in doubt for doubt in found.doubts)


@pytest.mark.nightly
def test_a_wind_in_one_record_is_told_there_beside_a_base_that_is_off(rng):
    """Of three records; the others are calm, and a further one is expected to be."""
    wind = Effect("wind", {"speed": 9.0, "from": 1.0})
    calm, windy = inject(FaultCase("s175"), rng), inject(FaultCase("s175", effects=(wind,)), rng)
    ship = resolve("s175")
    off = ship.with_coefficients(ship.coefficients * (1.0 + 0.04 * rng.standard_normal(ship.coefficients.size)))
    train = [calm.train[0], replace(windy.train[1], name="windy"), calm.train[2]]
    found = diagnose(off, train, calm.held_out, Options())
    print(found.verdict, found.reason, found.causes)
    blows = next(f for f in found.causes if f.cause == "wind")
    assert {size.record for size in blows.sizes} == {"windy"}
    assert blows.sizes[0].low < 9.0 < blows.sizes[0].high
    assert found.gain["heading_rad"].own_after < 0.5 * found.gain["heading_rad"].own_before


def similar_to(record, scale):
    """The record as a ship `scale` times as long would give it, after Froude."""
    root = np.sqrt(scale)
    factors = {"surge_m_s": root, "sway_m_s": root, "yaw_rate_rad_s": 1.0 / root, "north_m": scale, "east_m": scale}
    channels = {name: factor * record.column(name) for name, factor in factors.items() if record.has(name)}
    return replace(record.with_channels(**channels), time_s=root * record.time_s)


@pytest.mark.parametrize("scale", [1.25, pytest.param(0.8, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("vessel", nightly_but(["mariner", "s175", "kvlcc2-l7"], "mariner"))
def test_records_of_a_ship_of_another_size_are_told_with_its_scale(vessel, scale, rng):
    """By the hull's numbers it would be a ship of another inertia and resistance."""
    case = inject(FaultCase(vessel), rng)
    train, held_out = ([similar_to(r, scale) for r in records] for records in (case.train, case.held_out))
    found = diagnose(resolve(vessel), train, held_out, Options())
    assert [f.cause for f in found.causes] == ["ship_scale"] and found.apart == ()
    assert found.causes[0].sizes[0].value == pytest.approx(scale - 1.0, abs=0.01)
    for channel in ("heading_rad", "surge_m_s"):
        assert found.gain[channel].rmse_after < 0.3 * found.gain[channel].rmse_before
    assert found.extended.instruments == {"ship_scale": pytest.approx(scale - 1.0, abs=0.01)}


def behind_sensor_play(record, play, rng):
    """The record of a rudder's sensor with play of +- play, rad, and the same noise as before."""
    rudder = record.column("rudder_rad").copy()
    noise = rudder_noise(rudder)
    shown = behind_play(quietened(rudder, noise), play)
    return record.with_channels(rudder_rad=shown + noise * rng.standard_normal(rudder.size))


@pytest.mark.parametrize("vessel", ["mariner", pytest.param("s175", marks=pytest.mark.nightly)])
@pytest.mark.parametrize("play_deg", [0.75, pytest.param(1.5, marks=pytest.mark.nightly)])
def test_play_of_the_rudders_sensor_is_no_stronger_rudder(vessel, play_deg, rng):
    """Without orders that turn back by less than the play, which no record shows."""
    manoeuvres = ("zigzag:20/20", "turn:25:port", "zigzag:10/10:port")
    case, play = inject(FaultCase(vessel, train=manoeuvres), rng), np.deg2rad(play_deg)
    train, held_out = ([behind_sensor_play(r, play, rng) for r in side] for side in (case.train, case.held_out))
    found = diagnose(resolve(vessel), train, held_out, Options())
    assert [f.cause for f in found.causes] == ["rudder_sensor_play"]
    assert found.causes[0].sizes[0].value == pytest.approx(play, rel=0.2)
    gain = found.gain["heading_rad"]  # on which side of the play a record starts is a neutral angle of its own
    assert gain.own_after < 0.5 * gain.own_before


@pytest.mark.parametrize(
    ("vessel", "late_s"), [("mariner", 3.0), pytest.param("kvlcc2-l7", 0.8, marks=pytest.mark.nightly)]
)
def test_a_rudder_column_that_is_late_is_no_wrong_hull(vessel, late_s, rng):
    """The hull feels the rudder before the record shows it, which no delay of the steering gear explains."""
    case = inject(FaultCase(vessel), rng)

    def late(record):
        rudder = np.interp(record.time_s - late_s, record.time_s, record.column("rudder_rad"))
        return record.with_channels(rudder_rad=rudder)

    train, held_out = ([late(r) for r in side] for side in (case.train, case.held_out))
    found = diagnose(resolve(vessel), train, held_out, Options())
    print(found.verdict, found.reason, found.causes)
    assert [f.cause for f in found.causes] == ["rudder_sensor_delay"]
    (size,) = found.causes[0].sizes
    assert size.value == pytest.approx(late_s, rel=0.1)
    assert found.extended.instruments["rudder_sensor_delay"] == pytest.approx(size.value)
    assert all(found.gain[channel].ratio_high < 1.0 for channel in ("heading_rad", "yaw_rate_rad_s"))


@pytest.mark.parametrize("bend", [0.2, pytest.param(-0.1, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("vessel", ["mariner", pytest.param("kvlcc2-l7", marks=pytest.mark.nightly)])
def test_a_log_that_is_not_linear_is_told_without_positions(vessel, bend, rng):
    case, model = (
        inject(FaultCase(vessel, channels=("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s")), rng),
        resolve(vessel),
    )

    def shown(record):
        surge = record.column("surge_m_s")
        return record.with_channels(surge_m_s=surge * (1.0 + bend * (surge / model.speed_m_s - 1.0)))

    found = diagnose(model, *([shown(r) for r in side] for side in (case.train, case.held_out)), Options())
    assert [f.cause for f in found.causes] == ["speed_curve"]
    s, c = (size.value for size in found.causes[0].sizes)
    assert s == pytest.approx(-bend, abs=0.02) and c * model.speed_m_s == pytest.approx(bend, abs=0.02)
    assert found.extended.instruments == {"surge_scale": pytest.approx(s), "surge_curve": pytest.approx(c)}


@pytest.mark.parametrize("vessel", ["mariner", pytest.param("kvlcc2-l7", marks=pytest.mark.nightly)])
def test_velocities_of_another_point_are_told(vessel, rng):
    """Of an antenna a third of the length ahead, whose positions agree with them."""
    case, model = inject(FaultCase(vessel), rng), resolve(vessel)
    ahead_m = model.particulars["L"] / 3.0

    def shown(record):
        psi, sway = record.heading_unwrapped(), record.column("sway_m_s") + ahead_m * record.column("yaw_rate_rad_s")
        north, east = record.column("north_m"), record.column("east_m")
        places = {"north_m": north + ahead_m * np.cos(psi), "east_m": east + ahead_m * np.sin(psi)}
        return record.with_channels(sway_m_s=sway, **places)

    told = diagnose(model, *([shown(r) for r in side] for side in (case.train, case.held_out)), Options())
    assert [f.cause for f in told.causes] == ["velocity_point"]
    assert told.causes[0].sizes[0].value == pytest.approx(ahead_m, rel=0.05)
    assert told.gain["sway_m_s"].ratio_high < 0.5


def test_every_number_of_the_bank_is_known_elsewhere():
    bank = bank_of(resolve("mariner"), Facts(set("ruv") | {"psi"}, True, 2, 300.0, exact=True), 8.0, None)
    moved = [place for place in bank.places.values() if place.kind in ("steering", "sensor")]
    assert len(moved) > 14 and all(entry in INSTRUMENTS for place in moved for entry in place.entries)
    terms = [cause for cause in causes().values() if isinstance(cause, MissingTerm)]
    assert len(terms) == 5
    for cause in terms:
        assert {one.entry for one in cause.terms} == {*extension_of(cause.id).units}


def test_limits_are_candidates_behind_commands_only(ship):
    model, _ = ship
    for commands in (True, False):
        bank = bank_of(model, Facts({"r", "psi"}, commands, 1, 300.0), 8.0, None)
        assert ("rudder_rate_limit" in {c.id for c in bank.candidates}) == commands
    bank = bank_of(model, Facts({"psi"}, True, 1, 300.0), 8.0, None)
    assert "yaw_rate_bias" not in {c.id for c in bank.candidates}
    only = bank_of(model, Facts({"r"}, True, 1, 300.0), 8.0, ("rudder_delay",))
    assert {c.id for c in only.candidates} == {"rudder_delay"}


def test_pieces_cover_the_records_and_are_eight_where_samples_allow(ship):
    model, records = ship
    units = units_of(model, records, length_s(model, records))
    assert {u.number for u in units} == {0, 1} and len(units) >= 8
    spans = sum(u.grid_s[-1] - u.grid_s[0] for u in units)
    assert spans == pytest.approx(sum(r.time_s[-1] - r.time_s[0] for r in records), rel=0.05)
    assert len(units_of(model, records[:1], 1e3)) == 8
    assert len(units_of(model, [records[0].slice(0, 80)], 1e3)) == 5
    with pytest.raises(CannotFit, match="fewer than 3 pieces"):
        units_of(model, [records[0].slice(0, 40)], 1e3)


@pytest.fixture(scope="module")
def mariner():
    model = resolve("mariner")
    return model, [generate(Manoeuvre("mariner", "zigzag:20/20", "low", seed=3, duration_s=200.0))]


def lane(runs, **values):
    """Errors (N, C) of the first unit at values of numbers."""
    (errors,) = runs.errors([Lane(0, values, runs.no_own[0])])
    return errors[:, 0].T


def predicted(runs, **values):
    return runs.measured[0] - lane(runs, **values)


def run_of_hull(model, unit, states):
    """States (N, C) of a run along a unit by the free run of every command."""
    run = run_along(replace(model, max_step_s=0.5), unit.stretch.record)
    names = {"u": "surge_m_s", "v": "sway_m_s", "r": "yaw_rate_rad_s", "psi": "heading_rad"}
    return np.column_stack([run.predicted[names[s]] for s in states])


@pytest.mark.parametrize(
    ("cause", "values"),
    [
        ("current", {"current_towards_north": 0.3, "current_towards_east": -0.2}),
        ("constant_force", {"constant_X": 2e4, "constant_Y": -3e4, "constant_N": 1e6}),
        ("yaw_damping_cubic", {"added_Nrrr": -0.002}),
        ("sway_damping_quadratic", {"added_Yv_absv": -0.01}),
    ],
)
def test_what_acts_from_outside_is_the_extension_of_its_cause(mariner, cause, values):
    """Terms act along the measured motion, which differs from the run's own by the term's effect."""
    model, records = mariner
    runs = runs_of(model, records, Options().checked(model))
    unit = runs.units[0]
    base, direct = (
        run_of_hull(model, unit, runs.symbols),
        run_of_hull(extended(model, cause, values), unit, runs.symbols),
    )
    own = predicted(runs, **values)
    scale = np.abs(direct - base).max(axis=0)
    assert np.all(np.abs(predicted(runs) - base).max(axis=0) <= 1e-3 * np.abs(base).max(axis=0))
    assert np.all(np.abs(own - direct).max(axis=0) <= 0.25 * scale + 1e-3 * np.abs(base).max(axis=0))


def test_sensors_show_the_run_and_are_taken_off_its_start(mariner):
    model, records = mariner
    runs = runs_of(model, records, Options().checked(model))
    true, r, u = predicted(runs), runs.symbols.index("r"), runs.symbols.index("u")
    shown = predicted(runs, yaw_rate_bias=1e-3)
    assert shown[0, r] == pytest.approx(true[0, r], abs=1e-6)  # the start is what the sensor shows less its bias
    assert predicted(runs, speed_scale=0.1)[0, u] == pytest.approx(true[0, u], abs=1e-6)
    late, stretch = predicted(runs, velocity_delay=3.0)[:, u], runs.units[0].stretch
    steps, known = round(3.0 / stretch.series.dt), stretch.known[model.states.index("u")]
    assert steps * stretch.series.dt == 3.0 and np.ptp(late[: steps + 1]) == 0.0
    assert late[0] == pytest.approx(known[steps])  # the run starts from what the channel shows 3 s later
    assert np.allclose(np.diff(late[steps:]), np.diff(true[:-steps, u]), atol=1e-3)


def test_a_column_is_the_difference_of_two_runs(mariner):
    model, records = mariner
    runs = runs_of(model, records, Options().checked(model))
    (number,) = next(c.numbers for c in runs.bank.candidates if c.id == "hull_yaw_linear.Nr")
    step = STEP * number.sd
    by_algebra = runs.quadratic({}, runs.no_own, [number]).squares(
        np.full((len(runs.units), 1), step), runs.no_own, [0]
    )
    assert np.allclose(by_algebra, runs.squares([{number.name: step}] * len(runs.units), runs.no_own), rtol=1e-6)


def test_columns_of_many_forces_are_those_of_runs_with_each(mariner):
    model, records = mariner
    bare = runs_of(model, records, Options().checked(model))
    forces = forces_along(bare)
    runs = bare.with_numbers(forces.places, forces.series)
    numbers = [n for c in forces.candidates for n in c.numbers if forces.places[n.name].kind == "term"][::9]
    point = {numbers[3].name: STEP * numbers[3].sd}
    quadratic = runs.quadratic(point, runs.no_own, numbers)
    assert len(numbers) > FEW and {runs.places[n.name].column for n in numbers} == {4, 5, 6}
    at_rest = runs.squares([point] * len(runs.units), runs.no_own)
    for place, number in enumerate(numbers):
        step = 1e-4 * number.sd
        values = point | {number.name: point.get(number.name, 0.0) + step}
        change = runs.squares([values] * len(runs.units), runs.no_own) - at_rest
        by_algebra = quadratic.squares(np.full((len(runs.units), 1), step), runs.no_own, [place]) - at_rest
        assert np.allclose(by_algebra, change, rtol=0.01, atol=0.01 * np.abs(change).max(axis=0))


def test_columns_of_numbers_in_regimes_are_differences_of_runs(rng):
    """Beside a number of the model that is not at rest."""
    ship, case = resolve("kvlcc2-l7"), inject(FaultCase("kvlcc2-l7", train=("zigzag:20/20",)), rng)
    bare = runs_of(ship, case.train, Options())
    regimes = [regime("rudder", "above", 0.2), regime("drift", "above", 0.05), regime("time", "above", 60.0)]
    model = bare.bank.model
    local = [(number, where) for number in local_numbers(model)[:8] for where in regimes]
    numbers = [Number(f"{own.name} {where.variable}", own.sd) for own, where in local]
    places = {n.name: place_in(model, *pair) for n, pair in zip(numbers, local, strict=True)}
    runs, point = bare.with_numbers(places, {}), {"N_r": 0.005}
    quadratic = runs.quadratic(point, runs.no_own, numbers)
    assert len(numbers) > FEW
    at_rest = runs.squares([point] * len(runs.units), runs.no_own)
    for place, number in enumerate(numbers):
        step = 1e-4 * number.sd
        change = runs.squares([point | {number.name: step}] * len(runs.units), runs.no_own) - at_rest
        by_algebra = quadratic.squares(np.full((len(runs.units), 1), step), runs.no_own, [place]) - at_rest
        assert np.allclose(by_algebra, change, rtol=0.02, atol=0.02 * np.abs(change).max(axis=0))


def test_a_group_of_which_two_numbers_are_wrong_is_named_by_these(rng):
    """The other numbers of the group would take up noise, and bias them."""
    ship, case = resolve("kvlcc2-l7"), inject(FaultCase("kvlcc2-l7"), rng)
    right = {name: values_of(ship)[name] for name in ("gamma_R_plus", "gamma_R_minus")}
    said = diagnose(with_values(ship, dict.fromkeys(right, 1.0)), case.train, case.held_out)
    (finding,) = said.causes
    assert {s.parameter: s.value for s in finding.sizes} == pytest.approx(right, rel=0.03)
    assert all(s.low < right[s.parameter] < s.high for s in finding.sizes)


@pytest.mark.nightly
def test_a_wrong_number_of_the_hull_is_named_with_its_value(rng):
    ship = resolve("mariner")
    wrong = ship.parameters["Nr"]
    model = ship.with_coefficients(ship.from_parameters(ship.parameters | {"Nr": 0.7 * wrong}))
    case = inject(FaultCase("mariner", train=("zigzag:20/20", "turn:25:port"), held_out=("zigzag:10/10:port",)), rng)
    found = diagnose(model, case.train, case.held_out)
    (finding,) = found.causes
    assert finding.cause == "base_coefficients" and finding.details["groups"] == ["linear yaw moment of the hull"]
    assert [s.parameter for s in finding.sizes] == ["Nr"]
    assert finding.sizes[0].value == pytest.approx(wrong, rel=0.03)
    assert found.gain["heading_rad"].own_after < 0.1 * found.gain["heading_rad"].own_before
