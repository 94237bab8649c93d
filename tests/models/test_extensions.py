"""Extensions of model families: null, derivatives, physics, and what a model needs to carry one."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from helmbench.datasets.disturbances import GRAVITY, parse_disturbance
from helmbench.models import kernels
from helmbench.models.errors import BadInput
from helmbench.models.extend import NEUTRAL, extended
from helmbench.models.families.environment import with_environment
from helmbench.models.families.extensions import carries, extensions
from helmbench.models.model import model_from_json, model_to_json, resolve
from helmbench.models.simulate import accelerations, initial_state, simulate

FAMILIES = ("abkowitz", "mmg", "sway-yaw", "nomoto-1-cubic", "nomoto-2-quadratic", "kt")
PAIRS = [(family, name) for family in FAMILIES for name in extensions() if carries(kernels.definition_of(family), name)]
NUMPY = [{"absv": np.abs, "sgn": np.sign, "atan2v": np.arctan2, "step": lambda x: float(x > 0)}, "numpy"]


def evaluate(definition, numbers):
    """State derivative of a simulated definition by plain substitution; numbers: symbol name -> value."""
    table = dict(numbers)

    def value(expression):
        arguments = sorted(sp.sympify(expression).free_symbols, key=str)
        return float(sp.lambdify(arguments, expression, NUMPY)(*[table[a.name] for a in arguments]))

    for helper, expression in definition.helpers.items():
        table[helper.name] = value(expression)
    mass = np.array([[value(entry) for entry in row] for row in definition.mass.tolist()])
    rates = np.linalg.solve(mass, [value(force) for force in definition.forces])
    return np.array([*rates, *[value(expression) for expression in definition.kinematics]])


def draw(definition, rng):
    typical = {"u": 5.0, "n": 1.5, "v": 0.4, "r": 0.02, "delta": 0.2, "m": 2.0, "L": 10.0, "U0": 5.0, "Iz": 2.0}
    names = [s.name for s in (*definition.states, *definition.inputs, *definition.parameters)]
    heavy = ("m11", "m22", "m33", "m_x", "m_y", "rigid", "J_", "nabla", "D_P", "rho")
    numbers = {name: typical.get(name, 0.3) * rng.uniform(0.7, 1.3) for name in names}
    return numbers | {name: rng.uniform(1.0, 2.0) for name in names if name.startswith(heavy)}


@pytest.mark.parametrize(("family", "name"), PAIRS)
def test_an_extension_at_its_null_changes_nothing(family, name, rng):
    base, grown = kernels.definition_of(family).simulated(), kernels.definition_of(f"{family}+{name}").simulated()
    numbers = draw(grown, rng)
    numbers |= {p: NEUTRAL.get(p, 0.0) for p in extensions()[name].units} | {"speed_loss_state": 0.0}
    rates = dict(zip([s.name for s in grown.states], evaluate(grown, numbers), strict=True))
    expected = evaluate(base, numbers)
    found = [rates[s.name] for s in base.states]
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize(("family", "name"), PAIRS)
def test_every_parameter_of_an_extension_moves_the_ship(family, name, rng):
    grown = kernels.definition_of(f"{family}+{name}").simulated()
    numbers = draw(grown, rng)
    for parameter in extensions()[name].units:
        rates = evaluate(grown, numbers)
        moved = evaluate(grown, numbers | {parameter: 1.1 * numbers[parameter]}) - rates
        dead = name == "constant_force" and parameter == "constant_X" and family == "sway-yaw"  # surge is held
        assert np.isfinite(moved).all() and (np.abs(moved).max() > 1e-15 * np.abs(rates).max()) != dead, parameter


def test_the_current_is_that_of_the_environment_variant(rng):
    base = kernels.definition_of("abkowitz")
    grown, variant = kernels.definition_of("abkowitz+current"), with_environment(base)
    numbers = draw(variant, rng) | {"current_towards_north": 0.7, "current_towards_east": -0.4}
    numbers |= {s.name: 0.0 for s in variant.inputs[1:]} | {"current_north": 0.7, "current_east": -0.4}
    np.testing.assert_allclose(evaluate(grown, numbers), evaluate(variant, numbers), rtol=1e-12)


def test_wind_and_forces_are_those_of_the_environment_variant(rng):
    variant = with_environment(kernels.definition_of("abkowitz"))
    numbers = draw(variant, rng) | {s.name: 0.0 for s in variant.inputs[1:]}
    numbers |= {"wind_towards_north": 6.0, "wind_towards_east": 3.0, "constant_X": 5.0, "constant_Y": 2.0}
    numbers["constant_N"] = 9.0
    for name, inputs in (
        ("wind", {"wind_north": 6.0, "wind_east": 3.0}),
        ("constant_force", {"force_x": 5.0, "force_y": 2.0, "moment_n": 9.0}),
    ):
        found = evaluate(kernels.definition_of(f"abkowitz+{name}"), numbers)
        np.testing.assert_allclose(found, evaluate(variant, numbers | inputs), rtol=1e-12)


def test_wave_drift_is_that_of_the_disturbances(rng):
    model, waves = resolve("mariner"), parse_disturbance("waves:3/9@50")
    particulars = model.particulars
    amount = particulars["rho"] * GRAVITY * 3.0**2 * particulars["L"]
    towards = {"wave_drift_north": amount * np.cos(np.deg2rad(50)), "wave_drift_east": amount * np.sin(np.deg2rad(50))}
    definition = kernels.definition_of("abkowitz+wave_drift")
    variant = with_environment(kernels.definition_of("abkowitz"))
    numbers = draw(variant, rng) | {s.name: 0.0 for s in variant.inputs[1:]} | model.environment_numbers()
    for psi in rng.uniform(-np.pi, np.pi, 4):
        force = waves.drift(model, np.array([psi]))[0]
        felt = numbers | {"psi": psi} | dict(zip(("force_x", "force_y", "moment_n"), force, strict=True))
        np.testing.assert_allclose(
            evaluate(definition, numbers | {"psi": psi} | towards), evaluate(variant, felt), rtol=1e-9, atol=1e-12
        )


def test_a_first_order_model_with_lead_is_the_second_order_one(rng):
    t1, t2, t3, gain = 40.0, 8.0, 15.0, 0.1
    first = resolve("nomoto-1")
    first = first.with_coefficients(first.from_parameters({"T": t1, "K": gain}))
    second = resolve("nomoto-2")
    second = second.with_coefficients(second.from_parameters({"T1": t1, "T2": t2, "T3": t3, "K": gain}))
    grown = extended(first, "second_order_lead", {"lead": 1.0 - t3 / t2, "lead_T2": t2})
    rudder = np.interp(np.arange(600), np.arange(0, 601, 40), np.concatenate([[0.0], rng.normal(size=15) * 0.2]))
    one = simulate(grown, rudder[:, None], 0.5, initial_state(grown))
    two = simulate(second, rudder[:, None], 0.5, initial_state(second))
    np.testing.assert_allclose(one[:, 0], two[:, 1], atol=1e-7 * np.abs(two[:, 1]).max())


def test_speed_loss_settles_at_its_gain():
    model = resolve("nomoto-1")
    model = model.with_coefficients(model.from_parameters({"T": 20.0, "K": 0.1}))
    grown = extended(model, "speed_loss", {"loss_gain": 400.0, "loss_time": 15.0, "loss_power": 1.0})
    end = simulate(grown, np.full((4000, 1), 0.2), 0.5, initial_state(grown))[-1]
    assert end[2] == pytest.approx(400.0 * end[0] ** 2, rel=1e-9)
    assert end[0] == pytest.approx(0.02, rel=1e-9)  # power 1: moment and damping both fall with the speed
    lossy = extended(model, "speed_loss", {"loss_gain": 400.0, "loss_time": 15.0, "loss_power": 2.0})
    end = simulate(lossy, np.full((4000, 1), 0.2), 0.5, initial_state(lossy))[-1]
    assert end[0] == pytest.approx(0.02 * (1.0 - end[2]), rel=1e-9) and end[2] > 0.05


def test_a_slower_ship_turns_the_same_path_in_more_time(rng):
    """Every term keeps its prime value, that of the rudder's rate too."""
    base, grown = (kernels.definition_of(f"nomoto-2-quadratic{e}") for e in ("", "+speed_loss"))
    numbers = draw(grown, rng) | {"loss_power": 2.0}
    ratio = 1.0 - numbers["speed_loss_state"]
    slow = numbers | {name: ratio**k * numbers[name] for name, k in {"q": 2, "r": 1, "delta_rate": 1}.items()}
    q_rate, r_rate = evaluate(base, numbers)[:2]
    np.testing.assert_allclose(evaluate(grown, slow)[:2], [ratio**3 * q_rate, ratio**2 * r_rate], rtol=1e-12)


def test_rudder_effectiveness_scales_the_rudders_rate_too(rng):
    model = resolve("response-2")
    grown = extended(model, "rudder_effectiveness", {"rudder_effectiveness": -0.2})
    rudder = np.interp(np.arange(400), np.arange(0, 401, 40), np.concatenate([[0.0], rng.normal(size=10) * 0.2]))
    less = simulate(model, 0.8 * rudder[:, None], 0.5, initial_state(model))
    found = simulate(grown, rudder[:, None], 0.5, initial_state(grown))
    np.testing.assert_allclose(found[:, 1], less[:, 1], atol=1e-12)


def test_an_extended_model_is_a_model_file_like_any_other(tmp_path, rng):
    model = extended(resolve("mariner"), "rudder_offset", {"rudder_offset": 0.01})
    model = extended(model, "yaw_damping_quadratic", {"added_Nr_absr": -0.002})
    model = replace(model, instruments={"yaw_rate_bias": 0.001, "rudder_delay": 1.0})
    model_to_json(model, tmp_path / "m.json")
    back = model_from_json(tmp_path / "m.json")
    assert back.family == "abkowitz+rudder_offset+yaw_damping_quadratic" and back.instruments == model.instruments
    states, inputs = rng.normal(size=(3, 6)) + np.array([7.0, 0, 0, 0, 0, 0]), 0.1 * rng.normal(size=(3, 1))
    np.testing.assert_array_equal(accelerations(back, states, inputs), accelerations(model, states, inputs))
    assert back.parameters["rudder_offset"] == 0.01


def test_model_files_without_instruments_are_read_and_wrong_ones_refused(tmp_path):
    path = tmp_path / "m.json"
    model_to_json(resolve("response-1"), path)
    text = path.read_text()
    path.write_text(text.replace(',\n "instruments": {}', ""))
    assert "instruments" not in path.read_text() and model_from_json(path).instruments == {}
    for wrong in ('"gyro_bias": {"value": 0.1, "unit": "rad"}', '"rudder_delay": {"value": -1.0, "unit": "s"}'):
        path.write_text(text.replace('"instruments": {}', f'"instruments": {{{wrong}}}'))
        with pytest.raises(BadInput, match="instrument"):
            model_from_json(path)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("nomoto-1+foo", "unknown extension 'foo'"),
        ("nomoto-1+current", "cannot carry the extension 'current'"),
        ("foo+current", "unknown model"),
        ("nomoto-1+environment", "unknown model"),
        ("abkowitz+bank", "unknown model"),
    ],
)
def test_unknown_extensions_end_in_one_line(name, told):
    with pytest.raises(BadInput, match=told.replace("+", r"\+")) as caught:
        resolve(name)
    assert "\n" not in str(caught.value)


def test_a_model_says_what_an_extension_lacks():
    with pytest.raises(BadInput, match="no parameter 'offset'"):
        extended(resolve("response-1"), "rudder_offset", {"offset": 1.0})
    assert extended(resolve("response-1"), "rudder_offset").parameters["rudder_offset"] == 0.0


def test_held_parameters_in_helpers_do_not_hinder_regression():
    """The MMG's rudder angle stands in helpers; regression holds the added offset at zero there too."""
    module = kernels.load("mmg+rudder_offset")
    definition = kernels.definition_of("mmg+rudder_offset")
    place = [s.name for s in definition.coefficients].index("rudder_offset")
    k, p = 3, len(definition.coefficients)
    rng = np.random.default_rng(1)
    numbers = draw(definition, rng) | {"rudder_offset": 0.0}
    x, u, theta = (
        np.array([numbers[s.name] for s in g]) for g in (definition.states, definition.inputs, definition.parameters)
    )
    left, right = np.empty(k), np.empty(k * p)
    acceleration = evaluate(definition, numbers)[:k]
    module.regress(x, acceleration, u, theta, left, right)
    phi = right.reshape(k, p)
    assert not phi[:, place].any()
    scale = np.abs(phi) @ np.abs(theta[:p]) + np.abs(left)
    assert np.all(np.abs(left - phi @ theta[:p]) <= 1e-9 * scale)
