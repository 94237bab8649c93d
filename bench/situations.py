"""Fresh situations: ships, manoeuvres, noise, channels and disturbances drawn at random, as a suite file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..datasets.generator import suggested
from ..models.model import Model, list_vessels, resolve

NOISES = ("low", "medium", "high")
CHANNELS = ("only=heading", "only=heading+yaw_rate", "without=surge+sway", "only=north+east+heading")
SIMPLER = ("nomoto-1", "nomoto-1-cubic", "nomoto-2-cubic")
SHARES = {"simpler": 0.4, "disturbed": 0.25, "fewer channels": 0.25}
"""Share of the situations of 3-DOF ships with simpler equations and disturbances, of all with fewer channels."""
SEEDS = 3
"""Draws of the noise of a situation, of which the medians count: in a single one some method is best by chance."""
SUITE = "situations.yaml"


@dataclass(frozen=True)
class Situation:
    """What somebody has, in texts: a ship, the model to fit, records to learn from and to predict, conditions.

    `check` is one more record under the conditions of the training records, to choose among methods by.
    """

    vessel: str
    model: str
    train: tuple[str, ...]
    held_out: tuple[str, ...]
    noise: str
    disturbance: str
    check: str

    @property
    def kind(self) -> str:
        """The situation in a few words."""
        equations = "own equations" if self.model == "own" else "other equations"
        less = ", fewer channels" if "," in self.noise else ""
        return equations + less + ("" if self.disturbance == "none" else ", disturbed")


def draw(count: int, seed: int) -> list[Situation]:
    """So many situations; the first ones of a seed do not depend on their number."""
    return [_situation(np.random.default_rng([seed, number])) for number in range(count)]


def suite_text(situations: Sequence[Situation], methods: Sequence[str]) -> str:
    """The suite file that runs all methods in every situation, with `SEEDS` draws of the noise."""
    return _suite("fresh situations", [_entry(one, methods, one.held_out) for one in dict.fromkeys(situations)])


def checks_text(listed: Mapping[Situation, Sequence[str]]) -> str:
    """The suite file that runs the methods listed for each situation on its `check` record."""
    entries = [
        _entry(one, methods, (one.check,)) | {"held_out_noise": one.noise, "held_out_disturbance": one.disturbance}
        for one, methods in listed.items()
    ]
    return _suite("fresh situations, records to choose by", entries)


def _suite(title: str, entries: Sequence[Mapping[str, Any]]) -> str:
    import yaml

    return yaml.safe_dump({"title": title, "entries": list(entries)}, sort_keys=False)


def _entry(one: Situation, methods: Sequence[str], held_out: Sequence[str]) -> dict[str, Any]:
    return {
        "vessels": one.vessel,
        "models": one.model,
        "methods": list(methods),
        "train": [list(one.train)],
        "held_out": [list(held_out)],
        "noise": [one.noise],
        "disturbance": [one.disturbance],
        "seeds": SEEDS,
    }


def _situation(rng: np.random.Generator) -> Situation:
    vessel = str(rng.choice(sorted(list_vessels())))
    ship = resolve(vessel)
    simpler = ship.is_3dof and rng.random() < SHARES["simpler"]
    fewer = rng.random() < SHARES["fewer channels"]
    noise = str(rng.choice(NOISES)) + (f",{rng.choice(CHANNELS)}" if fewer else "")
    disturbed = ship.is_3dof and rng.random() < SHARES["disturbed"]
    train = tuple(dict.fromkeys(_manoeuvre(ship, rng) for _ in range(rng.integers(1, 4))))
    held_out, check = _others(ship, train, rng)
    return Situation(
        vessel,
        str(rng.choice(SIMPLER)) if simpler else "own",
        train,
        (held_out,),
        noise,
        _disturbance(ship, rng) if disturbed else "none",
        check,
    )


def _others(ship: Model, train: Sequence[str], rng: np.random.Generator) -> tuple[str, str]:
    """Two manoeuvres that are neither equal nor among the training records."""
    found = list(train)
    while len(found) < len(train) + 2:
        if (text := _manoeuvre(ship, rng)) not in found:
            found.append(text)
    return found[-2], found[-1]


def _manoeuvre(ship: Model, rng: np.random.Generator) -> str:
    """A manoeuvre that the ship's usual duration has room for."""
    angle, side = int(rng.integers(2, 7)) * 5, str(rng.choice(["", ":port"]))
    duration = suggested(ship)["duration_s"]
    kinds = (
        f"zigzag:{angle}/{int(rng.integers(1, angle // 5 + 1)) * 5}{side}",
        f"turn:{angle}{side}",
        f"sine:{angle}deg/{duration / int(rng.integers(4, 9)):.3g}s",
        f"prbs:{angle}deg/{duration / int(rng.integers(15, 31)):.3g}s",
    )
    return str(rng.choice(kinds, p=(0.5, 0.2, 0.15, 0.15)))


def _disturbance(ship: Model, rng: np.random.Generator) -> str:
    towards, speed = int(rng.integers(0, 36)) * 10, ship.speed_m_s
    current = f"current:{speed * rng.uniform(0.02, 0.08):.2g}@{towards}deg"
    wind = f"wind:{speed * rng.uniform(0.8, 1.8):.2g}@{towards}deg"
    return str(rng.choice([current, wind])) if ship.windage else current
