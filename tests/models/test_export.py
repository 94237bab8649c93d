"""Exported files are read back by code that shares nothing with the models, and run beside them."""

import json
import math
import re
import zipfile
from dataclasses import replace
from functools import cache
from math import atan2, copysign, cos, exp, sin, sqrt
from xml.etree import ElementTree

import fmpy
import fmpy.fmi1
import fmpy.fmi2
import fmpy.validation
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from helmbench.cli import status_of
from helmbench.cli._shared import FORMATS as OFFERED
from helmbench.models.errors import BadInput
from helmbench.models.export.formats import FORMATS, exported
from helmbench.models.model import list_vessels, resolve
from helmbench.models.simulate import accelerations, initial_state, inputs_of, simulate

from .test_reference_kvlcc2 import numbers, published_accelerations

DT = 0.1
RUDDER = np.where(np.arange(0.0, 30.0, DT) % 20.0 < 10.0, 0.3, -0.3)
MATLAB = {"sqrt": sqrt, "exp": exp, "sin": sin, "cos": cos, "atan2": atan2, "abs": abs, "double": float}
MATLAB |= {"sign": lambda x: copysign(1.0, x) if x else 0.0, "pi": math.pi, "Inf": math.inf}
OPERATORS = ((".^", "**"), (".*", "*"), ("./", "/"), ("^", "**"))


def evaluate(text, known):
    """The assignments of an .m file in their order, by Python's own arithmetic: name -> value, fields by their last
    name."""
    exec(as_python(text), MATLAB, known)
    return known


@cache
def as_python(text):
    """The assignments of numbers of an .m file as Python."""
    lines = []
    for left, right in re.findall(r"^([\w.]+) = ([^'{\[].*);$", text, re.MULTILINE):
        right = re.sub(r"\b(state|input)\((\d+)\)", r"\1[\2-1]", right)
        right = re.sub(r"\bp\.\w+\.(\w+)", r"p['\1']", right)
        for theirs, ours in OPERATORS:
            right = right.replace(theirs, ours)
        lines.append(f"{left.split('.')[-1]} = {right}")
    return compile("\n".join(lines), "matlab", "exec")


def integrated(rates, start, steps=4):
    """States (N, n) of x' = rates(x, delta) by Runge-Kutta steps, the rudder held from sample to sample."""
    states, h = [np.asarray(start, float)], DT / steps
    for delta in RUDDER[:-1]:
        x = states[-1]
        for _ in range(steps):
            k1 = np.array(rates(x, delta))
            k2 = np.array(rates(x + 0.5 * h * k1, delta))
            k3 = np.array(rates(x + 0.5 * h * k2, delta))
            x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + np.array(rates(x + h * k3, delta)))
        states.append(x)
    return np.array(states)


def assert_same_run(found, model, bound=1e-4):
    """Largest difference from the model's own simulation, relative to the largest value of each state."""
    own = simulate(model, inputs_of(model, RUDDER), DT, initial_state(model), hold="zero")
    assert np.max(np.abs(found - own) / (np.abs(own).max(axis=0) + 1e-9)) < bound


@pytest.mark.parametrize("vessel", ["kvlcc2-l7", "mariner", "response-2"])
def test_matlab_functions_run_as_the_model_does(vessel):
    model = resolve(vessel)
    files = exported(model, "simulink")
    name = next(iter(files)).removesuffix(".m")
    assert {f"{name}.m", f"{name}_ode.m", f"{name}_idnl.m", f"{name}_idnlgrey.m"} <= set(files)
    struct = evaluate(files[f"{name}.m"], {})
    assert struct["max_step_s"] == model.max_step_s and struct["max_rad"] == pytest.approx(model.rudder.max_rad)
    rates = matlab_rates(model, files)
    assert_same_run(integrated(lambda x, delta: rates(x, [delta, model.n0_rps]), initial_state(model)), model)


def matlab_rates(model, files):
    """The derivative (n,) of states and inputs by the .m files."""
    (ode,) = (text for name, text in files.items() if name.endswith("_ode.m"))
    struct = evaluate(next(iter(files.values())), {})

    def rates(state, given):
        found = evaluate(ode, {"state": state, "input": given, "p": struct})
        return [found[f"d_{name}"] for name in model.states]

    return rates


@pytest.mark.parametrize("vessel", list_vessels())
def test_derivatives_of_every_vessel_are_those_of_its_model(vessel, rng):
    model = resolve(vessel)
    matlab = matlab_rates(model, exported(model, "simulink"))
    module = {}
    ((_, text),) = exported(model, "vehicle-simulator").items()
    exec(text, module)
    for _ in range(20):
        state = initial_state(model) + rng.uniform(-0.05, 0.05, len(model.states))
        given = inputs_of(model, [rng.uniform(-0.5, 0.5)])
        own = accelerations(model, [state], given)[0]
        np.testing.assert_allclose(matlab(state, given[0]), own, rtol=1e-8, atol=1e-11)
        named = dict(zip(model.states, state, strict=True)), dict(zip(model.inputs, given[0], strict=True))
        found = module["derivative"](*named)
        np.testing.assert_allclose([found[name] for name in model.states], own, rtol=1e-8, atol=1e-11)


def test_matrices_of_a_linear_model_are_its_derivatives():
    model = resolve("cargo")
    files = exported(model, "simulink")
    struct = evaluate(files["cargo.m"], {})
    found = {}
    for letter, rows in re.findall(r"^([AB]) = \[(.*)\];$", files["cargo_matrices.m"], re.MULTILINE):
        cells = [[eval(cell.replace(".*", "*").replace("./", "/"), struct) for cell in row.split(",")]
                 for row in rows.split(";")]  # fmt: skip
        found[letter] = np.array(cells, float)
    states, inputs = np.eye(len(model.states)), np.eye(1)
    zero = np.zeros((len(model.states), 1))
    np.testing.assert_allclose(found["A"], accelerations(model, states, zero).T, rtol=1e-12)
    np.testing.assert_allclose(found["B"], accelerations(model, 0.0 * states[:1], inputs).T, rtol=1e-12)
    assert "idgrey('cargo_matrices'" in files["cargo_idgrey.m"]


@pytest.mark.parametrize("vessel", ["kvlcc2-l7", "mariner", "response-2", "s175"])
def test_a_vehicle_of_the_simulator_runs_as_the_model_does(vessel):
    model = resolve(vessel)
    ((name, text),) = exported(model, "vehicle-simulator").items()
    module = {}
    exec(compile(text, name, "exec"), module)
    vehicle = module[name.removesuffix(".py")]()

    def rates(x, delta):
        given = {"delta": delta, "n": vehicle.n, "speed": model.speed_m_s}
        found = module["derivative"](dict(zip(model.states, x, strict=True)), given)
        return [found[state] for state in model.states]

    assert_same_run(integrated(rates, initial_state(model)), model)


def test_the_main_loop_of_the_simulator_can_drive_a_vehicle():
    """Ten seconds of its step input, position and heading integrated as its main loop does."""
    model = resolve("kvlcc2-l7")
    ((_, text),) = exported(model, "vehicle-simulator").items()
    module = {}
    exec(text, module)
    vehicle, eta, dt = module["kvlcc2_l7"](), np.zeros(6), 0.02
    nu, actual, used = vehicle.nu, vehicle.u_actual, [0.0]
    for place in range(500):
        nu, actual = vehicle.dynamics(eta, nu, actual, vehicle.stepInput(place * dt), dt)
        eta[5] += dt * nu[5]
        used.append(actual[0])
    assert used[-1] == pytest.approx(math.radians(10.0))
    assert np.diff(used).max() == pytest.approx(model.rudder.rate_rad_s * dt)
    own = simulate(model, inputs_of(model, used[1:]), dt, initial_state(model), hold="zero")
    assert nu[[0, 1, 5]] == pytest.approx(own[-1, :3], rel=2e-2)


def test_the_table_of_mmgdynamics_gives_the_published_accelerations(rng):
    """Its names and conventions, undone by hand, in the equations of the paper."""
    model = resolve("kvlcc2-l7")
    ((_, text),) = exported(model, "mmgdynamics").items()
    p = json.loads(text)
    c = {name.removesuffix("_dash"): value for name, value in p.items()}
    c |= {"L": p["Lpp"], "D_P": p["D_p"], "H_R": p["D_p"] / p["eta"], "x_P": p["x_P"] / p["Lpp"]}
    c |= {"nabla": p["m"] / p["rho"], "I_zz": p["I_zG"] + p["m"] * p["x_G"] ** 2, "x_R": -0.5}
    rudder = {"t_R": p["t_R"], "a_H": p["a_H"], "x_H": p["x_H_dash"]}
    assert rudder == pytest.approx({"t_R": 0.387, "a_H": 0.312, "x_H": -0.464})
    assert p["C_b"] == pytest.approx(0.8098, abs=1e-4)
    for _ in range(50):
        state = rng.uniform([0.2, -0.5, -0.15], [1.4, 0.5, 0.15])
        delta, n = rng.uniform(-0.7, 0.7), rng.uniform(5.0, 20.0)
        own = published_accelerations(numbers(model), state, delta, n)
        np.testing.assert_allclose(published_accelerations(c, state, delta, n), own, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("vessel", ["kvlcc2-l7", "mariner"])
def test_a_gazebo_link_turns_as_the_model_does(vessel):
    """Released with drift and yaw rate, rudder amidships, three lengths: Fossen's equations with the file's numbers.

    Measured: 9 and 10 % of the largest sway speed and yaw rate; the plugin's damping does not fall with the speed.
    """
    model = resolve(vessel)
    ((_, text),) = exported(model, "gazebo").items()
    tree = ElementTree.fromstring(text)
    values = {one.tag: float(one.text) for one in tree.iter() if re.fullmatch(r"[-+.\de]+", one.text or "")}
    thrust = float(re.search(r"a thrust of (\S+) N", text)[1])
    held = [float(share) for share in re.findall(r"[XYN] ([\d.]+)%", text)]
    assert len(held) == 3 and min(held) > 95.0
    xx, yy = values["mass"] + values["xx"], values["mass"] + values["yy"]
    yr, rr = values["yr"], values["izz"] + values["rr"]

    def rates(t, x):
        u, v, r = x
        products = {"V": v, "R": r, "VabsV": v * abs(v), "RabsR": r * abs(r), "VabsR": v * abs(r), "RabsV": r * abs(v)}
        sway, yaw = (sum(values[axis + name] * own for name, own in products.items()) for axis in "yn")
        momentum = yy * v + yr * r
        surge = (momentum * r + values["xUabsU"] * u * abs(u) + thrust) / xx
        right = [sway - xx * u * r, yaw - momentum * u + xx * u * v]
        return [surge, *np.linalg.solve([[yy, yr], [yr, rr]], right)]

    length, speed = model.particulars["L"], model.speed_m_s
    start, times = [speed, -0.15 * speed, 0.4 * speed / length], np.linspace(0.0, 3.0 * length / speed, 60)
    found = solve_ivp(rates, (0.0, times[-1]), start, t_eval=times, rtol=1e-8).y
    own = simulate(model, inputs_of(model, 0.0 * times), times[1], [*start, *[0.0] * (len(model.states) - 3)]).T[:3]
    assert np.max(np.abs(found[1:] - own[1:]).max(axis=1) / np.abs(own[1:]).max(axis=1)) < 0.15
    assert np.abs(found[0] - own[0]).max() < 0.05 * speed


def run_of_unit(model, folder, command, dt, limited=False, start=None):
    """Columns of a run of the exported unit by FMPy: name -> (N,), the command held from sample to sample."""
    ((name, content),) = exported(model, "fmu").items()
    (folder / name).write_bytes(content)
    times = dt * np.arange(len(command))
    fed = np.array(list(zip(times, command, strict=True)), dtype=[("time", float), ("rudder_command", float)])
    values = {} if start is None else dict(zip(model.states, start, strict=True))
    if not limited:
        values |= {"steering_gear_max_rad": 10.0, "steering_gear_rate_rad_s": 1e9, "steering_gear_lag_s": 0.0}
    found = fmpy.simulate_fmu(
        folder / name,
        stop_time=times[-1],
        input=fed,
        output_interval=dt,
        start_values=values,
        fmi_type="CoSimulation",
        output=[*model.states, "rudder"],
    )
    assert found["time"] == pytest.approx(times)
    return found


def difference(found, own, names):
    """Largest difference of a unit's run from states (N, n), relative to the largest value of each state."""
    ran = np.column_stack([found[name] for name in names])
    return np.max(np.abs(ran - own) / (np.abs(own).max(axis=0) + 1e-9))


@pytest.mark.parametrize("vessel", list_vessels())
def test_a_functional_mock_up_unit_runs_as_the_model_does(vessel, tmp_path, rng):
    model = resolve(vessel)
    start = initial_state(model) + rng.uniform(-0.02, 0.02, len(model.states))
    found = run_of_unit(model, tmp_path, RUDDER, DT, start=start)
    own = simulate(model, inputs_of(model, RUDDER), DT, start, hold="zero")
    turned = np.abs(own[:, model.states.index("psi")]) < 20.0 * np.pi  # remus diverges: its heading is lost by rounding
    assert turned[:50].all() and difference(found[turned], own[turned], model.states) < 1e-5
    assert found["rudder"][1:] == pytest.approx(RUDDER[:-1])


@pytest.mark.parametrize(("vessel", "lag_s"), [("kvlcc2-l7", 0.0), ("kvlcc2-l7", 1.5), ("mariner", 4.0)])
def test_the_rudder_of_a_unit_keeps_the_limits_of_the_steering_gear(vessel, lag_s, tmp_path):
    """Its rudder angle is that of d' = (command - d) / lag within the rate, and the ship follows this angle."""
    gear = replace(resolve(vessel).rudder, lag_s=lag_s, rate_rad_s=math.radians(5.0), max_rad=0.25)
    model, dt, parts = replace(resolve(vessel), rudder=gear), 0.5, 2000
    command = np.where(np.arange(0.0, 40.0, dt) % 20.0 < 10.0, 0.3, -0.2)
    found = run_of_unit(model, tmp_path, command, dt, limited=True)
    angle, h = [0.0], dt / parts
    for target in np.repeat(np.clip(command, -0.25, 0.25)[:-1], parts):
        step = (target - angle[-1]) * (h / lag_s if lag_s else 1.0)
        angle.append(angle[-1] + min(max(step, -gear.rate_rad_s * h), gear.rate_rad_s * h))
    assert found["rudder"] == pytest.approx(angle[::parts], abs=2e-4)
    fine = np.array(angle[:: parts // 50])
    own = simulate(model, inputs_of(model, fine), dt / 50, initial_state(model))[::50]
    assert difference(found, own, model.states) < 1e-3


def test_a_unit_keeps_to_the_standard(tmp_path):
    """FMPy finds no problem in its description, its state can be kept and put back, and it is the same every time."""
    model = resolve("kvlcc2-l7")
    ((name, content),) = exported(model, "fmu").items()
    assert exported(model, "fmu")[name] == content
    place = tmp_path / name
    place.write_bytes(content)
    assert fmpy.validation.validate_fmu(place) == []
    description = fmpy.read_model_description(place)
    references = {one.name: one.valueReference for one in description.modelVariables}
    unit = fmpy.fmi2.FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(place, tmp_path / "open"),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="ship",
    )
    unit.instantiate()
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    unit.setReal([references["rudder_command"]], [0.3])
    unit.doStep(0.0, 5.0)
    kept, runs = unit.getFMUState(), []
    for _ in range(2):
        unit.setFMUState(kept)
        unit.doStep(5.0, 5.0)
        runs.append(unit.getReal([references["psi"]])[0])
    assert runs[0] == runs[1] > 0.01
    unit.freeFMUState(kept)
    with pytest.raises(fmpy.fmi1.FMICallException):
        unit.setReal([references["rudder_command"]], [math.nan])
    unit.terminate()
    unit.freeInstance()


def test_without_a_compiler_a_unit_holds_its_source_and_says_so(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.warns(RuntimeWarning, match="cargo.fmu holds C source only, since there is no C compiler cc"):
        assert status_of(["export", "cargo", "--to", "fmu", "-o", str(tmp_path / "out")]) == 0
    with zipfile.ZipFile(tmp_path / "out" / "cargo.fmu") as unit:
        assert unit.namelist() == ["modelDescription.xml", "sources/cargo.c"]


def test_every_vessel_is_exported_or_refused_in_one_line():
    assert list(OFFERED.choices) == list(FORMATS)
    for name in list_vessels():
        for to in FORMATS:
            try:
                files = exported(resolve(name), to)
            except BadInput as refusal:
                assert "\n" not in str(refusal) and refusal.hint
            else:
                texts = [text for text in files.values() if isinstance(text, str)]
                assert all("nan" not in text.lower().split() for text in texts)
    with pytest.raises(BadInput, match="has no coefficients"):
        exported(resolve("nomoto-1"), "simulink")
    with pytest.raises(BadInput, match="did you mean simulink"):
        exported(resolve("cargo"), "simulik")


def test_the_command_writes_all_files_or_none(tmp_path, capsys):
    out = tmp_path / "cargo"
    assert status_of(["export", "cargo", "--to", "simulink", "-o", str(out)]) == 0
    names = sorted(path.name for path in out.iterdir())
    assert len(names) == 6 and "cargo_idgrey.m" in names
    assert status_of(["export", "cargo", "--to", "simulink", "-o", str(out)]) == 2
    assert "exists already" in capsys.readouterr().err
    assert status_of(["export", "cargo", "--to", "gazebo", "-o", str(tmp_path / "none")]) == 2
    assert not (tmp_path / "none").exists()
