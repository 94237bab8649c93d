"""Synthetic runs for the tests of store, leaderboard and report: no model is simulated and nothing is fitted."""

from helmbench.bench.kinds.identification.columns import KEYS
from helmbench.estimation.run.run import CHANNELS

DEFAULTS = {
    "suite": "made-up",
    "method": "ls",
    "variant": "corrected",
    "vessel": "mariner",
    "model": "abkowitz",
    "train": "zigzag:20/20",
    "held_out": "turn:35",
    "noise": "low",
    "disturbance": "none",
    "thinning": 1,
    "length": 1.0,
    "seed": 0,
}


def make_run(error=None, r2=None, reason=None, parameters=(), **facts):
    """One stored run; `error` is the relative parameter error, `r2` that of yaw rate and heading in free run."""
    row = DEFAULTS | {"status": "ok", "error": reason, "diverged": False, "n_samples": 100}
    row |= {"rel_error_median": error, "rel_error_max": error, "wall_s": 0.5, "cpu_s": 0.4, "peak_memory_mib": 120.0}
    for channel in CHANNELS[:2] if r2 is not None else ():
        row |= {f"r2_free_{channel}": r2, f"rmse_free_{channel}": 0.01}
    row |= facts
    if row["status"] != "ok":
        row |= {"rel_error_median": None, "rel_error_max": None, "diverged": None}
    elif not parameters and error is not None:
        parameters = [make_parameter("K", 1.0, 1.0 + error, 0.1)]
    return {"key": "-".join(str(row[key]) for key in KEYS), "row": row, "parameters": list(parameters)}


def make_parameter(name, true, estimate, crb_sd, kind="given", identifiable=True):
    """One row of the parameter table, without its keys."""
    return {
        "parameter": name,
        "unit": "1/s",
        "true": true,
        "true_kind": kind,
        "estimate": estimate,
        "stderr": 0.1,
        "rel_error": abs(estimate - true) / abs(true),
        "crb_sd": crb_sd,
        "identifiable": identifiable,
    }
