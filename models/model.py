"""A model: a definition with numbers.  Resolved from a vessel id, a family id or a model.json."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import kernels as kernel_store
from .argument_types import typed
from .display import html_table
from .errors import BadInput
from .files import content_writer, replace_together
from .instruments import INSTRUMENTS
from .kernels import check_family_name, is_family_name
from .particulars import STEPS, Particulars, numbers_of, read_particulars
from .plain import json_text
from .stated_numbers import (
    coefficients_of,
    in_order,
    in_si,
    instruments_of,
    parameters_of,
    public_of,
    stated_coefficients,
)
from .suggestions import suggestion
from .vessel import read_vessel, vessel_files

if TYPE_CHECKING:
    from .model_file import ModelFile

CHANNELS = {
    "u": "surge_m_s",
    "v": "sway_m_s",
    "r": "yaw_rate_rad_s",
    "psi": "heading_rad",
    "x": "north_m",
    "y": "east_m",
    "delta": "rudder_rad",
    "n": "propeller_rps",
}
"""State and input names of the models -> record channels."""

RESPONSE_STEP_S = 0.1
FILE_SCHEMA = 1
TABLES = (".csv", ".parquet", ".pq", ".xlsx", ".xls", ".txt")
"""Endings of files that are no models."""
SMALLEST, LARGEST, PLACES = 1e-6, 1e9, ("x_", "y_", "z_")
"""Particulars (SI units) that a ship can have, and how the names of places begin."""


@dataclass(frozen=True)
class RudderGear:
    """Largest angle [rad], rate limit [rad/s] and time constant [s] of the steering gear."""

    max_rad: float = np.inf
    rate_rad_s: float = np.inf
    lag_s: float = 0.0


@dataclass(frozen=True)
class HeadingController:
    """Gains of delta = kp (psi_ref - psi) - kd r, in the vessel's rudder sign."""

    kp: float
    kd: float = 0.0


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """A family of equations with coefficients and constants.

    Parameters
    ----------
    id : vessel id, family id or name of the file it came from.
    family : id of the definition whose kernels it uses.
    coefficients : (p,) in the kernel's coordinates; nan where unknown.
    constants : (c,) known numbers of the definition (length, masses, ...).
    positive_rudder : side to which a positive rudder angle turns the ship.
    speed_m_s : speed of the straight course, nan where the model has none.
    max_step_s : largest RK4 step.
    windage : coefficients of the wind force by name, None where the vessel file has none.
    suite : suggested manoeuvres, duration and sampling of a vessel.
    instruments : rudder linkage and sensor errors between the true motion and the record: see `models.instruments`.
    """

    id: str
    family: str
    coefficients: NDArray[np.float64]
    constants: NDArray[np.float64]
    positive_rudder: str = "starboard"
    vessel: str | None = None
    title: str = ""
    source: str = ""
    speed_m_s: float = float("nan")
    n0_rps: float | None = None
    max_step_s: float = RESPONSE_STEP_S
    rudder: RudderGear = RudderGear()
    controller: HeadingController | None = None
    windage: Mapping[str, float] | None = None
    particulars: Mapping[str, float] = field(default_factory=dict)
    suite: Mapping = field(default_factory=dict)
    instruments: Mapping[str, float] = field(default_factory=dict)

    @property
    def kernels(self) -> kernel_store.Kernels:
        """The generated code of the family."""
        return kernel_store.load(self.family)

    @property
    def states(self) -> tuple[str, ...]:
        return self.kernels.STATES

    @property
    def inputs(self) -> tuple[str, ...]:
        return self.kernels.INPUTS

    @property
    def regression_states(self) -> tuple[str, ...]:
        return self.kernels.REGRESSION_STATES

    @property
    def regression_inputs(self) -> tuple[str, ...]:
        return self.kernels.REGRESSION_INPUTS

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the p coefficients."""
        return self.kernels.COEFFICIENTS

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the q published parameters."""
        return self.kernels.PARAMETERS

    @property
    def parameter_units(self) -> tuple[str, ...]:
        return self.kernels.UNITS

    @property
    def constant_names(self) -> tuple[str, ...]:
        return self.kernels.CONSTANTS

    @property
    def is_3dof(self) -> bool:
        return self.kernels.ENVIRONMENT

    @property
    def is_linear(self) -> bool:
        return self.kernels.LINEAR

    @property
    def known(self) -> bool:
        """Whether every coefficient has a value."""
        return bool(np.all(np.isfinite(self.coefficients)))

    @property
    def theta(self) -> NDArray[np.float64]:
        """Coefficients and constants as the kernels take them."""
        return np.concatenate([self.coefficients, self.constants])

    @property
    def starboard(self) -> int:
        """Sign of the rudder angle that turns the ship to starboard."""
        return 1 if self.positive_rudder == "starboard" else -1

    def __repr__(self) -> str:
        state = f"{len(self.parameter_names)} parameters" if self.known else "without coefficients"
        return f"<Model {self.id!r}: {self.title or self.family}; {state}>"

    def _repr_html_(self) -> str:
        values = self.to_parameters(self.coefficients)
        pairs = zip(self.parameter_names, values.tolist(), self.parameter_units, strict=True)
        rows = [(name, f"{value:.5g}" if np.isfinite(value) else "", unit) for name, value, unit in pairs]
        facts = [f"family {self.family}", self.source, f"positive rudder to {self.positive_rudder}"]
        facts += [f"{self.speed_m_s:g} m/s"] if np.isfinite(self.speed_m_s) else []
        told = "; ".join(escape(fact) for fact in facts if fact)
        title = f"<p><b>{escape(self.id)}</b>: {escape(self.title)}<br>{told}</p>"
        return title + html_table(("parameter", "value", "unit"), rows)

    def with_coefficients(self, coefficients: ArrayLike) -> Model:
        """The same model with other coefficients (p,)."""
        values = np.array(coefficients, float)
        if values.shape != (len(self.coordinates),):
            raise BadInput(f"{self.id} has {len(self.coordinates)} coefficients, not {values.shape}")
        return replace(self, coefficients=values)

    def blanked(self) -> Model:
        """The model without its coefficients: what an identification method is given."""
        return self.with_coefficients(np.full(len(self.coordinates), np.nan))

    def to_parameters(self, coefficients: ArrayLike) -> NDArray[np.float64]:
        """Published parameters (q,) of coefficients (p,); nan where a map has no real value."""
        return public_of(self.kernels, coefficients)[0]

    def parameters_jacobian(self, coefficients: ArrayLike) -> NDArray[np.float64]:
        """d parameters / d coefficients, (q, p)."""
        return public_of(self.kernels, coefficients)[1]

    def from_parameters(self, parameters: ArrayLike | Mapping[str, float]) -> NDArray[np.float64]:
        """Coefficients (p,) of published parameters, (q,) or by name."""
        return coefficients_of(self.kernels, parameters)

    @property
    def parameters(self) -> dict[str, float]:
        """Published parameter name -> value."""
        return dict(zip(self.parameter_names, self.to_parameters(self.coefficients).tolist(), strict=True))

    def environment(self, wind: bool) -> tuple[kernel_store.Kernels, NDArray[np.float64]]:
        """Kernels and parameter vector of the variant with current, wind and extra forces.

        Raises
        ------
        BadInput : if the family has no such variant, or there is wind and the vessel has no windage data.
        """
        if not self.is_3dof:
            raise BadInput(
                f"{self.id}: current, wind and drift forces need a 3-DOF model", hint="choose a 3-DOF vessel"
            )
        if wind and self.windage is None:
            raise BadInput(f"{self.id}: the vessel file has no windage data", hint="add a windage block to it")
        module = kernel_store.load(self.family + kernel_store.ENVIRONMENT)
        numbers = self.environment_numbers()
        return module, np.concatenate([self.coefficients, [numbers[name] for name in module.CONSTANTS]])

    def environment_numbers(self) -> dict[str, float]:
        """The family's constants and those that act on a hull from outside; wind has no effect without windage."""
        calm = dict.fromkeys(("A_F", "A_L", "wind_cx", "wind_cy", "wind_L"), 1.0)
        numbers = calm | dict.fromkeys(("rho_air", "wind_cn", "wind_kn", "wind_delta"), 0.0) | {"rho": 1025.0}
        numbers |= {"wind_L": self.particulars.get("L", 1.0), **(self.windage or {})}
        numbers |= {"rho": self.particulars["rho"]} if "rho" in self.particulars else {}
        return numbers | dict(zip(self.constant_names, self.constants.tolist(), strict=True))


def ship_length_m(model: Model) -> float:
    """Length of a 3-DOF model's ship, m; 1 where it states none."""
    numbers = model.environment_numbers()
    return numbers.get("L", numbers["wind_L"])


def list_families() -> dict[str, str]:
    """Family id -> title."""
    return {name: facts["title"] for name, facts in kernel_store.catalogue().items()}


def list_vessels() -> dict[str, str]:
    """Vessel id -> title."""
    return {name: read_vessel(path)["title"] for name, path in vessel_files().items()}


@typed
def resolve(name: str | os.PathLike[str]) -> Model:
    """The model of a vessel id, a family id, or the path of a model.json, a vessel file or a YAML file of particulars.

    Raises
    ------
    BadInput : if there is no such id or file, or the file cannot be used.
    """
    text = os.fspath(name)
    if text.lower().endswith(TABLES):
        hint = "a model is a vessel id, a family id or a model.json; 'helmbench import-model' makes one of a table"
        raise BadInput("is a record or another table, not a model", file=text, hint=hint)
    if text in vessel_files():
        return _from_vessel(text)
    if text.endswith((".yaml", ".yml")):
        return _from_yaml(Path(text))
    if text.endswith(".json") or os.sep in text:
        return model_from_json(text)
    if is_model_id(text):
        return _from_family(text)
    known = [*vessel_files(), *kernel_store.catalogue()]
    hint = suggestion(text, known, f"vessels: {', '.join(vessel_files())}")
    raise BadInput(f"unknown model {text!r}", hint=f"{hint} ('helmbench list models' shows all)")


def is_model_id(text: str) -> bool:
    """Whether a text is the identifier of a vessel or of a family of equations, extended or not."""
    return text in vessel_files() or (is_family_name(text) and kernel_store.is_family(text))


def _from_family(name: str) -> Model:
    kernels = kernel_store.load(name)
    if kernels.CONSTANTS:
        raise BadInput(
            f"family {name!r} needs a vessel's constants ({', '.join(kernels.CONSTANTS[:4])}, ...)",
            hint="give a vessel id or a model.json",
        )
    blank = np.full(len(kernels.COEFFICIENTS), np.nan)
    return Model(name, name, blank, np.zeros(0), title=kernels.TITLE, source=kernels.SOURCE)


def _from_yaml(path: Path) -> Model:
    """A vessel file, which names a family, or a file of particulars."""
    from .data_file import load

    content = load(path)
    if not isinstance(content, dict) or "family" not in content:
        return model_from_particulars(read_particulars(path), path.stem)
    facts = read_vessel(path)
    check_family_name(facts["family"], path)
    if not kernel_store.is_family(facts["family"]):
        raise BadInput(f"unknown family {facts['family']!r}", file=path, hint="'helmbench list models' shows them")
    return _from_facts(path.stem, facts, path)


def model_from_particulars(p: Particulars, name: str = "ship") -> Model:
    """The ship as a model of the family mmg; a positive rudder turns to starboard."""
    values, known = numbers_of(p), kernel_store.load("mmg")
    return Model(
        name, "mmg",
        np.array([values[n] for n in known.COEFFICIENTS]), np.array([values[n] for n in known.CONSTANTS]),
        positive_rudder="starboard", title=p.title, speed_m_s=p.speed_m_s, n0_rps=p.n0_rps,
        max_step_s=p.L / p.speed_m_s / STEPS,
        source="regressions of Clarke 1983, Kijima 1990, Yoshimura & Masumoto 2012",
        particulars={"L": p.L, "B": p.B, "d": p.d, "nabla": p.nabla, "x_G": p.x_G, "rho": p.rho},
    )  # fmt: skip


@lru_cache
def _from_vessel(name: str) -> Model:
    path = vessel_files()[name]
    return _from_facts(name, read_vessel(path), path)


def _sound(particulars: Mapping[str, float], file: object) -> Mapping[str, float]:
    """The particulars, SI units; BadInput where one is no size of a ship: only places (x_G) may be 0 or negative."""
    for name, value in particulars.items():
        size = abs(value) if name.startswith(PLACES) else value
        if not ((size == 0.0 and name.startswith(PLACES)) or SMALLEST <= size <= LARGEST):
            hint = f"lengths, areas, volumes, speeds and densities lie between {SMALLEST:g} and {LARGEST:g}"
            raise BadInput(f"particulars {name}: {value:g} is no size of a ship", file=file, hint=hint)
    return particulars


def _from_facts(name: str, facts: Mapping, file: Path) -> Model:
    kernels = kernel_store.load(facts["family"])
    stated = {name: (entry["value"], entry["unit"]) for name, entry in facts["parameters"].items()}
    gear, steering, speed = facts.get("rudder") or {}, facts.get("controller"), facts.get("speed_m_s")
    limits = (np.inf if gear.get(key) is None else float(np.deg2rad(gear[key])) for key in ("max_deg", "rate_deg_s"))
    return Model(
        id=name,
        family=facts["family"],
        coefficients=stated_coefficients(None, parameters_of(stated, kernels, file), kernels, file),
        constants=in_order(in_si(facts.get("constants")), kernels.CONSTANTS, file, "constant"),
        positive_rudder=facts["positive_rudder"],
        vessel=name,
        title=facts["title"],
        source=facts["source"],
        speed_m_s=float("nan") if speed is None else float(speed),
        n0_rps=facts.get("n0_rps"),
        max_step_s=float(facts["max_step_s"]),
        rudder=RudderGear(*limits, float(gear.get("lag_s") or 0.0)),
        controller=HeadingController(float(steering["kp"]), float(steering.get("kd") or 0.0)) if steering else None,
        windage=_windage(facts.get("windage")),
        particulars=_sound(in_si(facts.get("particulars")), file),
        suite=facts.get("suite") or {},
    )


WIND_COEFFICIENTS = ("wind_cx", "wind_cy", "wind_cn")
"""Coefficients of the wind force ahead and to the side, and of its moment."""


def usual_windage(length_m: float) -> dict[str, float]:
    """Constants of the wind force on a usual ship of a length: areas above water of the loaded merchant ships in
    vessels/ (A_L .058 to .070 L^2, a quarter of it ahead), and coefficients between theirs."""
    side = 0.065 * length_m**2
    form = {"wind_cx": 0.7, "wind_cy": 0.85, "wind_cn": 0.08, "wind_kn": 0.0, "wind_delta": 0.0}
    return {"rho_air": 1.225, "A_F": 0.25 * side, "A_L": side, **form}


def _windage(facts: Mapping | None) -> dict[str, float] | None:
    """Constants of the wind force from a vessel file's block, by the names that the kernels use."""
    if facts is None:
        return None
    common = {"rho_air": facts["rho_air"], "A_F": facts["A_F_m2"], "A_L": facts["A_L_m2"]}
    if facts["form"] == "sinusoidal":
        form = {"wind_cx": facts["cx"], "wind_cy": facts["cy"], "wind_cn": facts["cn"]}
        return {**common, **form, "wind_kn": 0.0, "wind_delta": 0.0}
    form = {"wind_cx": facts["CDl_AF"], "wind_cy": facts["CDt"], "wind_delta": facts["delta"]}
    return {**common, **form, "wind_cn": 0.0, "wind_kn": 0.18}


def model_to_json(model: Model, path: str | os.PathLike[str]) -> None:
    """Write a model that `resolve` reads back; replaces the file in one step.

    Raises
    ------
    BadInput : the file cannot be written; nothing of it is left then.
    """
    values = model.to_parameters(model.coefficients)
    facts = {
        "schema": FILE_SCHEMA,
        "id": model.id,
        "title": model.title,
        "family": model.family,
        "vessel": model.vessel,
        "source": model.source,
        "positive_rudder": model.positive_rudder,
        "speed_m_s": model.speed_m_s,
        "n0_rps": model.n0_rps,
        "max_step_s": model.max_step_s,
        "coefficients": dict(zip(model.coordinates, model.coefficients, strict=True)),
        "parameters": {
            name: {"value": value, "unit": unit}
            for name, value, unit in zip(model.parameter_names, values, model.parameter_units, strict=True)
        },
        "constants": dict(zip(model.constant_names, model.constants, strict=True)),
        "rudder": model.rudder,
        "controller": model.controller,
        "windage": model.windage or None,
        "particulars": model.particulars,
        "instruments": {
            name: {"value": float(value), "unit": INSTRUMENTS[name]} for name, value in model.instruments.items()
        },
    }
    replace_together({Path(path): content_writer(json_text(facts) + "\n")})


def model_from_json(path: str | os.PathLike[str]) -> Model:
    """Read a model file.

    Raises
    ------
    BadInput : if the file is missing or not JSON, lacks what a model needs, holds an unknown key or a number in a unit
        that it cannot be in, or states parameters that its coefficients do not give.
    """
    from .model_file import ModelFile
    from .yaml_file import checked, read_yaml

    file = Path(path)
    return _from_file(checked(ModelFile, read_yaml(file, "a model file"), path), file)


def _from_file(facts: ModelFile, path: Path) -> Model:
    check_family_name(facts.family, path)
    if not kernel_store.is_family(facts.family):
        raise BadInput(f"unknown model family {facts.family!r}", file=path, hint="'helmbench list models' shows them")
    kernels = kernel_store.load(facts.family)
    stated = {name: (entry.value, entry.unit) for name, entry in facts.parameters.items()}
    parameters = parameters_of(stated, kernels, path)
    return Model(
        id=path.stem,
        family=facts.family,
        coefficients=stated_coefficients(facts.coefficients, parameters, kernels, path),
        constants=in_order(facts.constants, kernels.CONSTANTS, path, "constant"),
        positive_rudder=facts.positive_rudder,
        vessel=facts.vessel,
        title=facts.title,
        source=facts.source,
        speed_m_s=np.nan if facts.speed_m_s is None else facts.speed_m_s,
        n0_rps=facts.n0_rps,
        max_step_s=facts.max_step_s,
        rudder=RudderGear(**{key: np.inf if value is None else value for key, value in facts.rudder}),
        controller=HeadingController(**dict(facts.controller)) if facts.controller else None,
        windage=dict(facts.windage) if facts.windage else None,
        particulars=_sound(facts.particulars, path),
        suite=read_vessel(vessel_files()[facts.vessel])["suite"] if facts.vessel in vessel_files() else {},
        instruments=instruments_of({n: (entry.value, entry.unit) for n, entry in facts.instruments.items()}, path),
    )
