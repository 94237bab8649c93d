"""Each paper's method against its baseline on every vessel: paired runs at three levels of sensor noise.

Both methods of a pair get the same 20 noisy records; the error is that of free runs on clean held-out manoeuvres.
There is one study a vessel, so that pairs share their fits, and one of paper 003's proposal with its bee colony.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from ....datasets.generator import Case, generate
from ....datasets.record import Record
from ....estimation.estimates.estimate import Estimate
from ....estimation.run.prediction import prediction_scores
from ....methods.registry import make
from ....models.errors import CannotFit, FitFailed
from ....models.model import Model, resolve
from ....reporting.leaderboard.equivalence import holm as stepped_down
from ..study import PaperStudy, StudyResult

LEVEL = 0.05
"""Level of the tests, after Holm's correction."""
MATERIAL = 0.01
"""A median ratio nearer to 1 than this is no difference, however regular it is."""
USELESS = 1.0
"""Error of a constant prediction, in standard deviations: a method with more has failed."""
BETTER, WORSE, EQUAL, BOTH_FAIL = OUTCOMES = ("better", "worse", "no difference", "both fail")


def paired(own: np.ndarray, other: np.ndarray, lost: float) -> dict[str, float]:
    """Errors (n,) of a method and of its baseline on the same n records; `lost` is the error of a run that failed.

    error, baseline : medians;  ratio : median of own/other;  won : share of records with the smaller error, ties as
    half;  effect : matched-pairs rank-biserial correlation, 1 where the method always has the smaller error;
    p : two-sided Wilcoxon signed-rank test on the logarithms (Pratt's ranks);  failed, baseline_failed : shares.
    """
    difference = np.log(own / other)
    return {
        "error": float(np.median(own)),
        "baseline": float(np.median(other)),
        "ratio": float(np.exp(np.median(difference))),
        "won": float(np.mean(difference < 0.0) + 0.5 * np.mean(difference == 0.0)),
        "effect": _rank_biserial(difference),
        "p": _wilcoxon(difference),
        "failed": float(np.mean(own >= lost)),
        "baseline_failed": float(np.mean(other >= lost)),
    }


def _wilcoxon(difference: np.ndarray) -> float:
    from scipy.stats import wilcoxon

    if not difference.any():
        return 1.0
    found: Any = wilcoxon(difference, zero_method="pratt", method="asymptotic")
    return float(found.pvalue)


def _rank_biserial(difference: np.ndarray) -> float:
    from scipy.stats import rankdata

    ranks = np.asarray(rankdata(np.abs(difference)))
    ranks[difference == 0.0] = 0.0
    total = float(ranks.sum())
    return float((ranks[difference < 0.0].sum() - ranks[difference > 0.0].sum()) / total) if total else 0.0


def holm(p: Mapping[str, float]) -> dict[str, float]:
    """Adjusted p values (Holm 1979, Scand. J. Statist. 6, 65): each may be compared with the level by itself."""
    return dict(zip(p, stepped_down([*p.values()]).tolist(), strict=True))


def outcome(adjusted: float, ratio: float, error: float, baseline: float) -> str:
    """What a comparison shows, at `LEVEL` and beyond `MATERIAL`; error, baseline : medians of both."""
    if min(error, baseline) > USELESS:
        return BOTH_FAIL
    if adjusted >= LEVEL or abs(np.log(ratio)) <= np.log1p(MATERIAL):
        return EQUAL
    return BETTER if ratio < 1.0 else WORSE


NOISE = ("low", "medium", "high")
SEEDS = 20
LOST = 10.0
"""Error of a fit that fails or whose free run diverges, in standard deviations; larger errors count as this."""
VESSELS = (
    "remus-kt", "response-1", "response-2", "cargo", "patrol", "remus", "mariner-model", "mariner", "s175",
    "s175-polynomial", "kvlcc2-l7", "esso-osaka-l3",
)  # fmt: skip
RATES = ("surge_m_s", "sway_m_s", "yaw_rate_rad_s")
RESPONSE = "nomoto-2"
ESO, SVF = "eso-rw-lssvr", "svf-ls"
FORWARD = ",scheme=forward"
"""The papers' differences."""
CORNERS: dict[tuple[str, str, int], float] = {}
"""Corner frequency of `svf-ls` by vessel, noise and seed, rad/s."""


@dataclass(frozen=True)
class MethodPair:
    """A method and its baseline, as the registry writes them.

    heading : texts of the methods that get the rudder and the heading alone.  response : both fit a linear
    second-order response model, whatever the vessel is.
    """

    method: str
    baseline: str
    heading: tuple[str, ...] = ()
    response: bool = False


PAIRS = {
    "fw-rls": MethodPair(f"fw-rls{FORWARD}", f"rls{FORWARD}"),
    "fci-ls": MethodPair(f"fci-ls{FORWARD}", "ls-forward"),
    "mi-rls": MethodPair(f"mi-rls{FORWARD}", f"rls{FORWARD}"),
    "nmi-rls": MethodPair(f"nmi-rls{FORWARD}", f"rls{FORWARD}"),
    "nmi-mi": MethodPair(f"nmi-rls{FORWARD}", f"mi-rls{FORWARD}"),
    "eso-svf": MethodPair(ESO, SVF, (ESO, SVF), response=True),
    "eso-ls": MethodPair(ESO, "ls-forward", (ESO,), response=True),
    "a1-ls": MethodPair("euler-ls", "ls,scheme=midpoint"),
    "a1-a2": MethodPair("euler-ls", "euler-ls,algorithm=A2"),
}


PROPOSED = MethodPair(
    f"{ESO},variant=proposed",
    f"{ESO},variant=proposed,weighted=false",
    (f"{ESO},variant=proposed", f"{ESO},variant=proposed,weighted=false"),
    response=True,
)
"""Paper 003's proposal as a whole, with C by its bee colony, against the same with LS-SVR.  A fit takes some 2000
evaluations: one record at each of `PLACES`."""
PLACES = tuple((vessel, noise) for vessel in VESSELS for noise in NOISE)


def structure(vessel: str, response: bool) -> Model:
    """The blank model that is fitted: the vessel's own equations, or the response model."""
    own = resolve(vessel)
    if response and own.is_3dof:
        return replace(resolve(RESPONSE), rudder=own.rudder)
    return own.blanked()


@lru_cache(maxsize=8)
def held_out(vessel: str) -> tuple[Record, ...]:
    """Clean runs of the manoeuvres that are not trained on."""
    return tuple(generate(Case(vessel, text)) for text in resolve(vessel).suite["held_out"])


@lru_cache(maxsize=256)
def training(vessel: str, noise: str, seed: int) -> tuple[Record, ...]:
    """Noisy training runs."""
    return tuple(generate(Case(vessel, text, noise, seed=seed)) for text in resolve(vessel).suite["train"])


def _with_corner(text: str, vessel: str, noise: str, seed: int) -> str:
    """The observer's poles are the corner that `svf-ls` found in the same headings, by the same search, if it did."""
    corner = CORNERS.get((vessel, noise, seed)) if text == ESO else None
    return text if corner is None else f"{text},omega0={corner!r}"


@lru_cache(maxsize=4096)
def error(text: str, vessel: str, response: bool, heading: bool, noise: str, seed: int) -> float:
    """Free-run error over the standard deviation, rms over surge, sway and yaw rate of the model.

    Raises `CannotFit` where the method does not apply to the model.
    """
    records: Sequence[Record] = training(vessel, noise, seed)
    if heading:
        records = [record.with_channels(yaw_rate_rad_s=None) for record in records]
    try:
        found = make(_with_corner(text, vessel, noise, seed)).fit(records, structure(vessel, response))
    except FitFailed:
        return LOST
    if text == SVF:
        CORNERS[vessel, noise, seed] = float(found.extra["omega_rad_s"])
    return _free_run_error(found, vessel)


def _free_run_error(found: Estimate, vessel: str) -> float:
    """Error of an estimate's free runs of the held-out manoeuvres, at most `LOST`."""
    scores = prediction_scores(found.model, held_out(vessel))
    unexplained = [1.0 - scores[f"r2_free_{channel}"] for channel in RATES if f"r2_free_{channel}" in scores]
    value = float(np.sqrt(np.mean(unexplained)))
    return LOST if scores["diverged"] or not value < LOST else value


def pairs_on(vessel: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """Every pair on one vessel, at every level of noise: keys PAIR.NOISE.QUANTITY, none where a method does not apply.

    Quantities are those of `paired`.
    """
    seeds = rng.integers(2**31, size=SEEDS).tolist()
    values: dict[str, Any] = {}
    for name, pair in PAIRS.items():
        for noise in NOISE:
            try:
                other, own = (_errors(pair, text, vessel, noise, seeds) for text in (pair.baseline, pair.method))
            except CannotFit:
                continue
            values |= {f"{name}.{noise}.{key}": value for key, value in paired(own, other, LOST).items()}
    return StudyResult(values)


def _errors(pair: MethodPair, text: str, vessel: str, noise: str, seeds: Sequence[int]) -> np.ndarray:
    heading = text in pair.heading
    return np.array([error(text, vessel, pair.response, heading, noise, seed) for seed in seeds])


def proposed_at(rng: np.random.Generator, *, index: int) -> StudyResult:
    """`PROPOSED` on one record of `PLACES[index]`: keys VESSEL.NOISE.QUANTITY.

    error, baseline : of free runs, as in `error`;  evaluations, cpu_s : of both fits, `baseline_` before those of the
    baseline.
    """
    vessel, noise = PLACES[index]
    records = [r.with_channels(yaw_rate_rad_s=None) for r in training(vessel, noise, int(rng.integers(2**31)))]
    model, values = structure(vessel, PROPOSED.response), {}
    for text, names in (
        (PROPOSED.method, ("error", "evaluations", "cpu_s")),
        (PROPOSED.baseline, ("baseline", "baseline_evaluations", "baseline_cpu_s")),
    ):
        values |= {f"{vessel}.{noise}.{k}": v for k, v in zip(names, _tuned(text, vessel, records, model), strict=True)}
    return StudyResult(values)


def _tuned(text: str, vessel: str, records: Sequence[Record], model: Model) -> tuple[float, float, float]:
    """Error of a method that chooses an option by evaluations, the number of these, and the fit's CPU time [s]."""
    begin = time.process_time()
    try:
        found = make(text).fit(records, model)
    except FitFailed:
        return LOST, np.nan, time.process_time() - begin
    seconds = time.process_time() - begin
    return _free_run_error(found, vessel), float(found.extra["evaluations"]), seconds


STUDIES = {vessel: PaperStudy(partial(pairs_on, vessel)) for vessel in VESSELS} | {
    "proposed": PaperStudy(proposed_at, seeds=len(PLACES))
}
