"""The schema of diagnosis.json refuses what no diagnosis writes."""

import pytest

from helmbench.diagnosis.causes.registry import all_causes
from helmbench.diagnosis.report.bank import BY_CHANNELS, BY_FREE_RUNS, BY_RESIDUALS
from helmbench.diagnosis.result import SCHEMA, VERDICTS

from .documents import faults, validator


def document(**changes) -> dict:
    """The smallest document, with changes."""
    noise = {"sensor_sd": {"heading_rad": 1e-3}, "force_sd": [0.0], "correlation_time_s": 15.0, "rudder_sd": None}
    made = {
        "schema": SCHEMA, "model": "mariner", "base_parameters": "file", "records": [], "alpha": 0.01, "seed": 0,
        "threads": 2, "verdict": "adequate", "reason": "nothing shows", "causes": [], "gain": {}, "calibrated_gain": {},
        "of_held_out": {},
        "bank": [],
        "hypothesis": None, "remaining": [], "noise": noise, "where": [],
        "next_manoeuvre": None, "doubts": [], "apart": [], "checks": [], "wall_s": 1.0, "cpu_s": 1.0,
    }  # fmt: skip
    return made | changes


def test_the_smallest_document_is_accepted():
    assert faults(document()) == []


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"schema": 1}, "$.schema"),
        ({"verdict": "proven"}, "$.verdict"),
        ({"records": [{"file": "a.csv", "role": "test"}]}, "$.records[0].role"),
        ({"alpha": "0.01"}, "$.alpha"),
        ({"gain": {"heading_rad": {"rmse_before": 1.0}}}, "$.gain.heading_rad"),
        ({"colour": "red"}, "$"),
    ],
)
def test_a_wrong_document_is_refused(change, where):
    assert any(fault.startswith(f"{where}: ") for fault in faults(document(**change)))


def test_verdicts_stages_and_causes_are_those_of_the_code():
    schema = validator().schema
    assert set(schema["properties"]["verdict"]["enum"]) == set(VERDICTS)
    stages = schema["$defs"]["finding"]["properties"]["stage"]["enum"]
    assert set(stages) == {BY_CHANNELS, BY_RESIDUALS, BY_FREE_RUNS}
    causes = [{"cause": name, "status": "not_significant", "statistic": None, "p_adjusted": None, "power": None,
               "why": ""} for name in all_causes()]  # fmt: skip
    assert faults(document(bank=causes)) == []
