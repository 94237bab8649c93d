"""Tables of a diagnosis suite: `diagnosis.parquet`, a row per case and diagnoser, and `diagnosis_sizes.parquet`."""

from ..base import TIMES

CASES, SIZES = "diagnosis.parquet", "diagnosis_sizes.parquet"
CHANNELS = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m")

KEYS = {
    "suite": "string",
    "method": "string",
    "group": "string",
    "vessel": "string",
    "injected": "string",
    "strength": "string",
    "gusts": "string",
    "seed": "int",
    "base": "string",
    "records": "string",
}
"""`injected`: causes joined by +, empty for a clean record; `seed` is the case's own: with it the truth simulator makes
the same records again."""

CASE_COLUMNS = {
    **KEYS,
    "status": "string",
    "error": "string",
    "noncentrality": "float",
    "detectable": "bool",
    "verdict": "string",
    "named": "string",
    "outcome": "string",
    "false_alarm": "bool",
    "confident_wrong": "bool",
    "tie_size": "int",
    "extra_names": "int",
    "names": "int",
    "false_names": "int",
    "described": "string",
    "right_variable": "bool",
    "regime_true": "string",
    "regime_named": "string",
    "regime_f1": "float",
    "healthy_bias": "float",
    **{f"rmse_{when}_{channel}": "float" for when in ("before", "after", "truth") for channel in CHANNELS},
    **TIMES,
}
"""`named`: findings of the diagnosis in its order, joined by +, tied causes by /; `outcome`: see `judge.OUTCOMES`;
`described`: variables of what remains; `regime_`, `healthy_bias`: see `judge`; `rmse_`: on held-out records, of
free runs of the model before and after, and of the true ship without gusts."""

SIZE_COLUMNS = {
    **KEYS,
    "cause": "string",
    "parameter": "string",
    "record": "string",
    "unit": "string",
    "true": "float",
    "estimate": "float",
    "low": "float",
    "high": "float",
    "covered": "bool",
    "rel_error": "float",
}
SIZE_KEYS = ("cause", "parameter", "record")
