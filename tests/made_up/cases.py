"""Hand-made diagnoses and stored cases: nothing is fitted."""

from helmbench.bench.kinds.diagnosis.columns import KEYS
from helmbench.diagnosis.result import Diagnosis, Finding, Gain
from helmbench.models.model import resolve


def make_diagnosis(*findings, verdict=None, sizes=(), ratio=1.0):
    """A diagnosis whose findings are texts such as `current/wind`: best member first, then those tied with it."""
    found = []
    for text in findings:
        cause, *tied = text.split("/")
        found.append(Finding(cause, tuple(tied), "dynamics", 50.0, 1e-6, tuple(sizes)))
    said = verdict or ("adequate" if not found else "tied" if any(f.tied_with for f in found) else "named")
    model = resolve("response-1")
    gains = {"heading_rad": Gain(1.0, ratio, ratio, ratio, 0.0, 0.0, 0.0)}
    return Diagnosis(
        model, model, "file", (), 0.01, 0, said, "", tuple(found), (), gains, None, {}, (), (), None, 1.0, 1.0
    )


DEFAULTS = {
    "suite": "made-up", "method": "innovations", "group": "injected", "vessel": "mariner", "injected": "rudder_offset",
    "strength": "faint", "gusts": "none", "seed": 0, "base": "exact", "records": "plain",
}  # fmt: skip


def make_case(size_of=None, **facts):
    """One stored case."""
    row = DEFAULTS | {"status": "ok", "error": None, "noncentrality": 80.0, "detectable": True, "verdict": "named"}
    row |= {"named": "rudder_offset", "outcome": "alone", "false_alarm": None, "confident_wrong": False, "tie_size": 1}
    row |= {"rmse_before_heading_rad": 0.2, "rmse_after_heading_rad": 0.11, "wall_s": 3.0, "cpu_s": 4.0}
    row |= facts
    sizes = [] if size_of is None else [size_of | {"record": "", "unit": "rad"}]
    return {"key": "-".join(str(row[key]) for key in KEYS), "row": row, "parameters": sizes}
