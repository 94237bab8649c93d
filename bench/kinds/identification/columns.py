"""Tables of an identification suite: `results.parquet`, a row per run, and `parameters.parquet`."""

from ...scores import score_columns
from ..base import TIMES

RESULTS, PARAMETERS = "results.parquet", "parameters.parquet"

KEYS = {
    "suite": "string",
    "method": "string",
    "variant": "string",
    "vessel": "string",
    "model": "string",
    "train": "string",
    "held_out": "string",
    "noise": "string",
    "disturbance": "string",
    "thinning": "int",
    "length": "float",
    "seed": "int",
}
PARAMETER_COLUMNS = {
    **KEYS,
    "parameter": "string",
    "unit": "string",
    "true": "float",
    "true_kind": "string",
    "estimate": "float",
    "stderr": "float",
    "rel_error": "float",
    "crb_sd": "float",
    "identifiable": "bool",
}


def result_columns() -> dict[str, str]:
    """Columns of `results.parquet`: keys, how the run ended, whether its records were measured, scores, cost."""
    ending = {"status": "string", "error": "string", "diverged": "bool", "measured": "bool", "n_samples": "int"}
    return {**KEYS, **ending, **score_columns(), **TIMES}
