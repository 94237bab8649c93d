"""Ugly inputs drawn from ships, runs and defects, and what `identify`, `diagnose` and `calibrate` make of each.

`outcomes(kind, seed)` repeats one input.  `python -m tests.nightly.robustness.sweep SEED DRAWS` prints a table.
"""

import json
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

import helmbench
from helmbench.datasets import measured
from helmbench.datasets.generator import Case, generate
from helmbench.models.errors import BadInput, CannotFit, FitFailed
from helmbench.models.model import Model, resolve

from .defects import DEFECTS

METHODS = ("ls", "ridge", "rls", "output-error", "pem", "tls", "huber", "rts-ls", "iv", "ekf", "svf-ls", "fw-rls")
MADE_UP = {
    "response-1": (200.0, 0.5),
    "response-2": (200.0, 0.5),
    "cargo": (240.0, 1.0),
    "mariner": (240.0, 1.0),
    "s175": (240.0, 1.0),
    "kvlcc2-l7": (120.0, 0.4),
}
"""Ship -> duration and step of its records, s."""
MEASURED_RUNS = {
    "kvlcc2-hsva": (("Z_20_05", "Z_10_05"), 6, ("kvlcc2-l7", "response-1")),
    "kvlcc2-marin": (("zz_10", "zz_20"), 2, ("kvlcc2-l7", "response-2")),
    "esso-osaka": (("zigzag_31-Jul-2020_14_03_39", "zigzag_31-Jul-2020_13_42_53"), 5, ("response-1", "kvlcc2-l7")),
    "blueboat": (("train-0", "train-1"), 4, ("response-1",)),
}
"""Set -> runs, thinning, models."""
WRONG_SHIP = {"mariner": "kvlcc2-l7", "kvlcc2-l7": "s175", "s175": "response-1", "response-1": "cargo"}
"""Ship of the records -> model of another ship."""
PLAIN = (BadInput, CannotFit, FitFailed)
SLOW_S = 180.0
"""Processor time of one call that is held to hang."""


@dataclass(frozen=True)
class Ugly:
    """A model with records; measured: the model is not exact, and causes may be named in good records."""

    model: Model
    train: Sequence
    held_out: Sequence
    measured: bool


@lru_cache(maxsize=64)
def _made_up(ship: str, manoeuvre: str, seed: int):
    duration, dt = MADE_UP[ship]
    return generate(Case(ship, manoeuvre, "low", seed=seed, duration_s=duration, dt_s=dt))


@lru_cache(maxsize=16)
def _loaded(name: str, run: str, every: int):
    return measured.load(name, run).thinned(every).slice(0, 600)


def base(rng: np.random.Generator) -> Ugly:
    """Good records with their model: made-up ones three times in four."""
    if rng.random() < 0.75:
        ship = str(rng.choice(list(MADE_UP)))
        seed = int(rng.integers(4))
        runs = [_made_up(ship, text, seed + i) for i, text in enumerate(("zigzag:20/20", "zigzag:10/10", "turn:20"))]
        return Ugly(resolve(ship), runs[:2], runs[2:], False)
    name = str(rng.choice(list(MEASURED_RUNS)))
    runs, every, models = MEASURED_RUNS[name]
    first, second = (_loaded(name, run, every) for run in runs)
    return Ugly(resolve(str(rng.choice(models))), [first], [second], True)


def spoiled(good: Ugly, kind: str, rng: np.random.Generator) -> tuple[Ugly, frozenset | None]:
    """An ugly input of a kind, and the causes that may be named (None: any)."""
    if kind == "the same record twice":
        return replace(good, train=[good.train[0], replace(good.train[0], name="other")]), frozenset()
    if kind == "wrong ship":
        ship = str(rng.choice(list(WRONG_SHIP)))
        # The numbers of a response model, which has no length, are truly another ship's.
        allowed = frozenset({"base_coefficients"})
        return Ugly(resolve(WRONG_SHIP[ship]), [_made_up(ship, "zigzag:20/20", 1)], [], False), allowed
    if kind == "near-cancelling second order":
        return Ugly(_near_cancelling(rng), good.train, good.held_out, True), None
    if kind == "singular model":
        return Ugly(_singular(rng), good.train, good.held_out, True), frozenset()
    defect = DEFECTS[kind]
    first, *others = good.train
    train = [defect.spoil(first, rng), *(defect.spoil(r, rng) if rng.random() < 0.5 else r for r in others)]
    held_out = [defect.spoil(r, rng) if rng.random() < 0.5 else r for r in good.held_out]
    free = good.measured and not defect.nonsense
    return replace(good, train=train, held_out=held_out), None if free else frozenset(defect.allowed)


def _near_cancelling(rng: np.random.Generator) -> Model:
    """A second-order response model with T3 within a share of 1e-9 to 1e-2 of T1 or T2."""
    model = resolve("cargo")
    values = model.parameters
    values["T3"] = values[str(rng.choice(["T1", "T2"]))] * (1.0 + 10.0 ** rng.uniform(-9.0, -2.0))
    return model.with_coefficients(model.from_parameters(values))


def _singular(rng: np.random.Generator) -> Model:
    """A 3-DOF or response model with coefficients that are all zero, all huge, or one of them huge."""
    model = resolve(str(rng.choice(["mariner", "kvlcc2-l7", "response-1", "response-2"])))
    values = model.coefficients.copy()
    how, one = rng.integers(3), np.arange(values.size) == rng.integers(values.size)
    return replace(model, coefficients=[0.0 * values, 1e12 * values, np.where(one, 1e30, values)][how])


KINDS = (*DEFECTS, "the same record twice", "wrong ship", "near-cancelling second order", "singular model")


@dataclass(frozen=True)
class SweepOutcome:
    """What one call came to: result, refused, or a failure with its reason."""

    state: str
    said: str
    cpu_s: float
    call: str = ""
    model: str = ""

    @property
    def failed(self) -> bool:
        return self.state not in ("result", "refused")

    def __str__(self) -> str:
        return f"{self.call} | {self.state} | {self.cpu_s:.1f} s | {self.model} | {self.said[:300]}"


def outcomes(kind: str, seed: int) -> list[SweepOutcome]:
    """What identify, diagnose and calibrate make of one ugly input; the same for the same kind and seed."""
    rng = np.random.default_rng([seed, *kind.encode()])
    good = base(rng)
    try:
        ugly, allowed = spoiled(good, kind, rng)
    except BadInput as refused:
        return [SweepOutcome("refused", str(refused), 0.0, "record", good.model.id)]
    method = str(rng.choice(METHODS))
    calls = {f"identify {method}": lambda: _identified(ugly, method), "diagnose": lambda: _diagnosed(ugly, allowed)}
    if ugly.model.is_3dof and rng.random() < 0.2:
        calls["calibrate"] = lambda: _calibrated(ugly)
    return [replace(_called(call), call=name, model=ugly.model.id) for name, call in calls.items()]


def _called(call: Callable[[], tuple[str, str]]) -> SweepOutcome:
    started = time.process_time()
    try:
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            state, said = call()
        numeric = [w for w in warned if issubclass(w.category, RuntimeWarning)]
        if numeric and state == "result":
            state, said = "warning", f"{Path(numeric[0].filename).name}:{numeric[0].lineno} {numeric[0].message}"
    except PLAIN as reason:
        state, said = ("refused", f"{type(reason).__name__}: {reason}") if str(reason).strip() else ("no reason", "")
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        own = [Path(f.filename) for f in frames if "site-packages" not in f.filename]
        places = " > ".join(f"{path.parent.name}/{path.name}" for path in own[-4:])
        state, said = "traceback", f"{type(error).__name__}: {error} at {places}"
    took = time.process_time() - started
    return SweepOutcome("hang" if took > SLOW_S else state, said, took)


def _identified(ugly: Ugly, method: str) -> tuple[str, str]:
    estimate = helmbench.identify(list(ugly.train), ugly.model, method)
    if not all(np.isfinite(value) for value in estimate.parameters.values()):
        return "not finite", f"parameters {estimate.parameters}"
    with tempfile.TemporaryDirectory() as folder:
        estimate.save(Path(folder) / "model.json")
        return _files(Path(folder)) or ("result", "")


def _diagnosed(ugly: Ugly, allowed: frozenset | None) -> tuple[str, str]:
    found = helmbench.diagnose(ugly.model, list(ugly.train), list(ugly.held_out))
    named = {f.cause for f in found.causes}
    if found.verdict == "named" and allowed is not None and not named <= allowed:
        return "named", f"{sorted(named)}: {found.reason}"
    return _written(found) or ("result", f"{found.verdict} {sorted(named)}")


def _calibrated(ugly: Ugly) -> tuple[str, str]:
    found = helmbench.calibrate(ugly.model, list(ugly.train), list(ugly.held_out))
    return _written(found) or ("result", found.verdict)


def _written(found) -> tuple[str, str] | None:
    found.summary()
    with tempfile.TemporaryDirectory() as folder:
        found.write(Path(folder))
        return _files(Path(folder))


def _files(folder: Path) -> tuple[str, str] | None:
    """A complaint about the first number in the JSON files that is not finite."""
    bad: list[str] = []

    def number(text: str) -> float:
        if np.isinf(float(text)):
            bad.append(text)
        return float(text)

    for path in folder.glob("*.json"):
        json.loads(path.read_text("utf-8"), parse_constant=bad.append, parse_float=number)
        if bad:
            return "not finite", f"{path.name}: {bad[0]}"
    return None


def main(seed: int, draws: int, kinds: Sequence[str] = KINDS) -> None:
    for kind in kinds:
        count: Counter[str] = Counter()
        for draw in range(draws):
            for one in outcomes(kind, seed + draw):
                count[f"{one.call.split()[0]} {one.state}"] += 1
                print(f"  {kind} | {seed + draw} | {one}", flush=True)
        print(kind, dict(count), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:] or KINDS)
