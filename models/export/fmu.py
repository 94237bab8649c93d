"""A functional mock-up unit for co-simulation (FMI 2.0): the equations as C, compiled where there is a C compiler."""

from __future__ import annotations

import hashlib
import io
import math
import platform
import shutil
import subprocess
import uuid
import warnings
import zipfile
from dataclasses import dataclass

from ..model import Model
from ..simulate import initial_state, inputs_of
from ..temporary import temporary_folder
from .equations import C, gear, numbers, values_of
from .texts import template

FREE_RATE_RAD_S = 1e9
"""Rudder rate of a model whose rudder follows at once: the file holds numbers only."""
BINARIES = {("Linux", "x86_64"): ("linux64", ".so"), ("Darwin", "x86_64"): ("darwin64", ".dylib")}
"""System and processor -> folder of the binary in the file, and the ending of its name (FMI 2.0, section 2.3)."""
STATES = {
    "u": ("surge speed", "m/s"), "v": ("sway speed to starboard", "m/s"), "r": ("yaw rate to starboard", "rad/s"),
    "x": ("position along north", "m"), "y": ("position along east", "m"), "psi": ("heading from north", "rad"),
}  # fmt: skip
INPUTS = {
    "delta": ("rudder command", "rad"),
    "n": ("propeller revolutions", "1/s"),
    "speed": ("speed, negative astern", "m/s"),
}
GEAR = {"max_rad": ("largest rudder angle", "rad"), "rate_rad_s": ("rudder rate", "rad/s"), "lag_s": ("lag", "s")}


@dataclass(frozen=True)
class Variable:
    """One number of the unit; its place in the list is its value reference."""

    name: str
    description: str
    unit: str
    causality: str
    start: float


def fmu(model: Model) -> dict[str, bytes]:
    """File name -> the unit: model description, C source and, where `cc` is found, a library of this machine.

    Inputs are the rudder command and what else drives the model; outputs are its states and the rudder angle behind
    the limits of the steering gear; coefficients, constants and limits are parameters.  A communication step is
    integrated by Runge-Kutta steps of at most the model's largest step; inputs are held in it.
    """
    values = values_of(model, C())
    name, variables = values["name"], _variables(model)
    state = len(model.inputs)
    values |= {"variables": variables, "state": state, "first": state + len(model.states) + 1}
    digest = hashlib.sha256(template("fmu.c").render(values, guid="@GUID@").encode())
    values["guid"] = str(uuid.UUID(digest.hexdigest()[:32]))
    source = template("fmu.c").render(values)
    files = {
        "modelDescription.xml": template("fmu.xml").render(values).rstrip("\n").encode(),
        f"sources/{name}.c": source.encode(),
    }
    return {f"{name}.fmu": _zipped(files | _compiled(name, source))}


def _variables(model: Model) -> list[Variable]:
    limits = {key: min(value, FREE_RATE_RAD_S) for key, value in gear(model).items()}
    given = zip(model.inputs, inputs_of(model, [0.0])[0].tolist(), strict=True)
    states = zip(model.states, initial_state(model).tolist(), strict=True)
    found = [_variable("rudder_command" if name == "delta" else name, INPUTS.get(name), "input", value)
             for name, value in given]  # fmt: skip
    found += [_variable(name, STATES.get(name), "output", value) for name, value in states]
    found += [Variable("rudder", "rudder angle", "rad", "output", 0.0)]
    found += [_variable(name, None, "parameter", value) for name, value in numbers(model).items()]
    return found + [_variable(f"steering_gear_{key}", GEAR[key], "parameter", value) for key, value in limits.items()]


def _variable(name: str, meaning: tuple[str, str] | None, causality: str, value: float) -> Variable:
    description, unit = meaning or ("", "")
    return Variable(name, description, unit, causality, value if math.isfinite(value) else 0.0)


def _compiled(name: str, source: str) -> dict[str, bytes]:
    """Path in the unit -> library of this machine; nothing, with a warning, where it cannot be made."""
    compiler, place = shutil.which("cc"), BINARIES.get((platform.system(), platform.machine()))
    if compiler is None or place is None:
        return _source_only(name, "there is no C compiler cc" if place else "this system has no name in FMI 2.0")
    folder, ending = place
    with temporary_folder() as where:
        code, library = where / f"{name}.c", where / f"{name}{ending}"
        code.write_text(source, "utf-8")
        command = [compiler, "-std=c99", "-O2", "-fPIC", "-shared", "-o", str(library), str(code), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            reason = done.stderr.strip().splitlines()[0] if done.stderr.strip() else f"status {done.returncode}"
            return _source_only(name, f"{compiler} failed ({reason})")
        return {f"binaries/{folder}/{library.name}": library.read_bytes()}


def _source_only(name: str, reason: str) -> dict[str, bytes]:
    warnings.warn(f"{name}.fmu holds C source only, since {reason}: compile it with FMPy", RuntimeWarning, stacklevel=3)
    return {}


def _zipped(files: dict[str, bytes]) -> bytes:
    """The same bytes for the same files, whenever it is made."""
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name, (2000, 1, 1, 0, 0, 0)), content, zipfile.ZIP_DEFLATED)
    return held.getvalue()
