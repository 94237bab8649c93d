"""The generated kernels say what the symbols say, for every family and its environment variant."""

import re

import numpy as np
import pytest
import sympy as sp

from helmbench.models import kernels
from helmbench.models.definition import Definition, symbols
from helmbench.models.families.environment import with_environment
from helmbench.models.generate import lanes_source, simulate_source, sources
from helmbench.models.primitives import absv, atan2v, sgn, step

FAMILIES = sorted(kernels.definitions())
SHIPS = [name for name in FAMILIES if kernels.definitions()[name]().force_scale is not None]
VARIANTS = FAMILIES + [name + kernels.ENVIRONMENT for name in SHIPS]
NUMPY = [{"absv": np.abs, "sgn": np.sign, "atan2v": np.arctan2, "step": lambda x: float(x > 0)}, "numpy"]


def symbolic(name: str) -> Definition:
    definition = kernels.definitions()[name.removesuffix(kernels.ENVIRONMENT)]()
    return with_environment(definition) if name.endswith(kernels.ENVIRONMENT) else definition


def draw(definition: Definition, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A state, input and parameter vector at which every family is regular: ship at speed, masses dominant."""
    typical = {"u": 5.0, "n": 1.5, "delta": 0.2, "rudder": 0.2, "v": 0.4, "r": 0.02, "psi": 1.0, "x": 10.0, "y": 10.0}

    def value(name: str) -> float:
        if name.startswith(("m11", "m22", "m33", "Iz", "m_x", "m_y")) or name in ("m", "L", "U0", "Tm", "rho", "D_P"):
            return rng.uniform(1.0, 2.0)
        return typical.get(name, 0.3) * rng.uniform(0.5, 1.5)

    return tuple(
        np.array([value(s.name) for s in group])
        for group in (definition.states, definition.inputs, definition.parameters)
    )


def evaluate(definition: Definition, x, u, theta) -> np.ndarray:
    """State derivative by plain substitution, without any of the generator's code."""
    table = dict(zip([*definition.states, *definition.inputs, *definition.parameters], [*x, *u, *theta], strict=True))
    for helper, expression in definition.helpers.items():
        arguments = sorted(expression.free_symbols, key=str)
        table[helper] = float(sp.lambdify(arguments, expression, NUMPY)(*[table[a] for a in arguments]))

    def number(expression) -> float:
        arguments = sorted(sp.sympify(expression).free_symbols, key=str)
        return float(sp.lambdify(arguments, expression, NUMPY)(*[table[a] for a in arguments]))

    mass = np.array([[number(entry) for entry in row] for row in definition.mass.tolist()])
    accelerations = np.linalg.solve(mass, [number(force) for force in definition.forces])
    return np.array([*accelerations, *[number(expression) for expression in definition.kinematics]])


def rhs(module, x, u, theta) -> np.ndarray:
    rates = np.empty(len(x))
    module.rhs(x, u, theta, rates)
    return rates


def relative(a, b) -> float:
    return float(np.max(np.abs(a - b)) / (np.max(np.abs(b)) + 1e-300))


@pytest.mark.parametrize("name", VARIANTS)
def test_state_derivative_is_the_symbolic_one(name, rng):
    definition = symbolic(name).simulated()
    module = kernels.load(name)
    for _ in range(5):
        x, u, theta = draw(definition, rng)
        np.testing.assert_allclose(rhs(module, x, u, theta), evaluate(definition, x, u, theta), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", VARIANTS)
def test_lanes_are_the_scalar_kernel(name, rng):
    definition, module = symbolic(name).simulated(), kernels.load(name)
    sets = [draw(definition, rng) for _ in range(module.LANES)]
    x, u, theta = (np.ascontiguousarray(np.array(group).T).ravel() for group in zip(*sets, strict=True))
    rates, numbers = np.empty(len(definition.states) * module.LANES), np.empty(module.LANE_NUMBERS * module.LANES)
    module.prepare_lanes(theta, numbers)
    module.rhs_lanes(x, u, numbers, rates)
    lanes = rates.reshape(-1, module.LANES).T
    for lane, one in zip(lanes, sets, strict=True):
        np.testing.assert_allclose(lane, rhs(module, *one), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("name", VARIANTS)
def test_a_step_works_out_nothing_of_parameters_alone(name):
    """Of many runs, and of one: what parameters determine is worked out once a run."""
    definition = symbolic(name).simulated()
    parameters = {str(symbol) for symbol in definition.parameters}
    for source, function in ((lanes_source(definition), "rhs_lanes"), (simulate_source(definition), "_rates")):
        text = source.partition(f"def {function}(")[2].partition("\n\n")[0]
        body = dict(re.findall(r"^ +(\w+) = (.+)$", text, re.MULTILINE))
        numbers = {name for name, value in body.items() if value.startswith("_p[")}
        used = {name: set(re.findall(r"[A-Za-z_]\w*", value)) for name, value in body.items() if name not in numbers}
        assert numbers and "_th[" not in text and not parameters & used.keys()
        assert [name for name, of in used.items() if of and of <= numbers] == []


@pytest.mark.parametrize("name", [name for name in FAMILIES if name.startswith("mmg")])
def test_the_normal_force_of_a_rudder_is_that_of_its_inflow_angle(name, rng):
    """U_R^2 sin(delta + atan(v_R/u_R)) in all four quadrants, written without an arc tangent."""
    helpers = {str(symbol): expression for symbol, expression in symbolic(name).helpers.items()}
    force = helpers["F_N"]
    assert not force.has(atan2v) and "alpha_R" not in helpers
    inflow = [
        next(s for s in force.free_symbols if str(s) == name) for name in ("u_R", "v_R", "sin_delta", "cos_delta")
    ]
    scale = [s for s in force.free_symbols if s not in inflow]
    along, across, delta = rng.normal(size=(3, 200))
    found = sp.lambdify([*inflow, *scale], force)(along, across, np.sin(delta), np.cos(delta), *np.ones(len(scale)))
    expected = (along**2 + across**2) * np.sin(delta + np.arctan2(across, along))
    np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("name", VARIANTS)
def test_tangent_agrees_with_finite_differences(name, rng):
    definition, module = symbolic(name).simulated(), kernels.load(name)
    x, u, theta = draw(definition, rng)
    n, nu, p = len(x), len(u), len(definition.coefficients)
    rates, product = np.empty(n), np.empty(n * n)
    by_input, sparse = np.zeros(n * nu), np.zeros(module.JT_COLUMN.size)
    module.tangent(x, u, theta, np.eye(n).ravel(), n, rates, product, by_input, sparse)
    by_coefficient = np.zeros((n, p))
    by_coefficient[module.JT_ROW, module.JT_COLUMN] = sparse
    np.testing.assert_allclose(rates, rhs(module, x, u, theta), rtol=1e-12)
    exact = [product.reshape(n, n), by_input.reshape(n, nu), by_coefficient]
    for k, (point, jacobian) in enumerate(zip((x, u, theta), exact, strict=True)):
        for column in range(jacobian.shape[1]):
            width = 1e-5 * max(abs(point[column]), 1e-2)
            ends = []
            for side in (1, -1):
                moved = [x.copy(), u.copy(), theta.copy()]
                moved[k][column] += side * width
                ends.append(rhs(module, *moved))
            difference = (ends[0] - ends[1]) / (2 * width)
            rounding = 1e-14 * np.abs(rates).max() / width
            near = 1e-6 * np.abs(difference).max() + rounding + 1e-12
            np.testing.assert_allclose(jacobian[:, column], difference, rtol=2e-5, atol=near)


@pytest.mark.parametrize("name", FAMILIES)
def test_regression_is_exact_at_the_true_coefficients(name, rng):
    definition, module = symbolic(name), kernels.load(name)
    x, u, theta = draw(definition, rng)
    k, p = len(definition.forces), len(definition.coefficients)
    theta[[definition.parameters.index(symbol) for symbol in definition.held]] = 0.0  # regression holds them there
    accelerations = evaluate(definition, x, u, theta)[:k]
    left, right = np.empty(k), np.empty(k * p)
    module.regress(x, accelerations, u, theta, left, right)
    scale = np.abs(right.reshape(k, p)) @ np.abs(theta[:p]) + np.abs(left)
    assert np.all(np.abs(left - right.reshape(k, p) @ theta[:p]) <= 1e-9 * scale + 1e-12)


@pytest.mark.parametrize("name", [name for name in FAMILIES if symbolic(name).public is not None])
def test_published_parameters_go_there_and_back(name, rng):
    module = kernels.load(name)
    count = len(module.PARAMETERS)
    published = 20.0 / 2.0 ** np.arange(count) * rng.uniform(0.9, 1.1, count)  # T1 well above T2
    coefficients, back = np.empty(len(module.COEFFICIENTS)), np.empty(published.size)
    jacobian = np.zeros((published.size, coefficients.size))
    module.private(published, coefficients)
    module.public(coefficients, back, jacobian)
    np.testing.assert_allclose(back, published, rtol=1e-10)
    for column in range(coefficients.size):
        width = 1e-6 * coefficients[column]
        ends = []
        for side in (1, -1):
            moved, values = coefficients.copy(), np.empty(published.size)
            moved[column] += side * width
            module.public(moved, values, np.zeros_like(jacobian))
            ends.append(values)
        difference = (ends[0] - ends[1]) / (2 * width)
        np.testing.assert_allclose(jacobian[:, column], difference, rtol=1e-4, atol=1e-6 * np.abs(jacobian).max())


@pytest.mark.parametrize("name", SHIPS)
def test_a_calm_environment_changes_nothing(name, rng):
    calm, variant = symbolic(name), symbolic(name + kernels.ENVIRONMENT)
    x, u, theta = draw(variant, rng)
    u[len(calm.inputs) :] = 0.0
    shared = [variant.parameters.index(symbol) for symbol in calm.parameters]
    still = rhs(kernels.load(name), x, u[: len(calm.inputs)].copy(), theta[shared])
    np.testing.assert_allclose(
        rhs(kernels.load(name + kernels.ENVIRONMENT), x, u, theta), still, rtol=1e-11, atol=1e-13
    )


def test_every_parameter_has_a_unit():
    for name in FAMILIES:
        module = kernels.load(name)
        assert len(module.UNITS) == len(module.PARAMETERS) and all(module.UNITS)


def test_non_smooth_functions_have_fixed_derivatives():
    x, y = symbols("x y")
    assert absv(x).diff(x) == sgn(x) and sgn(x).diff(x) == 0 and step(x).diff(x) == 0
    assert atan2v(y, x).diff(y).subs({x: 2.0, y: 0.0}) == pytest.approx(0.5)


def test_a_coefficient_that_enters_in_a_non_linear_way_is_refused():
    x, u, a = symbols("x u a")
    definition = Definition(
        name="bent",
        title="",
        states=[x],
        inputs=[u],
        coefficients=[a],
        constants=[],
        mass=sp.eye(1),
        forces=[a**2 * x + u],
        kinematics=[],
        units={"a": "1"},
        source="",
    )
    with pytest.raises(ValueError, match="not linear in the coefficients"):
        sources(definition)
