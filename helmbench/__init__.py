"""helmbench: benchmark and diagnosis of methods that identify ship manoeuvring models from records.

`import helmbench` offers the names below.  Each is loaded when it is first used, so that the import itself is quick:

    import helmbench

    record = helmbench.simulate("mariner", "zigzag:20/20", noise="low", seed=1)
    estimate = helmbench.identify(record, "mariner", "ls")
    print(estimate.parameters, estimate.stderr)

SI units and radians throughout, unless a name says otherwise.
"""

import os
import sys

if (  # of `python -m helmbench` the working folder leaves the path, unless this package lies there
    sys.argv[:1] == ["-m"]
    and sys.orig_argv[-len(sys.argv)].partition(".")[0].endswith("helmbench")
    and sys.path[0] == os.getcwd() != os.path.dirname(__path__[0])
):
    del sys.path[0]

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .api.admission import rudder_sign_doubt
    from .api.advice import AdviceTest, check_advice
    from .api.assessment import Assessment, Comparison, compare
    from .api.check import Check, check
    from .api.craft import CraftDiagnosis, build_model
    from .api.diagnosis import Calibration, Diagnosis, calibrate, diagnose
    from .api.doctor import Health, doctor
    from .api.exam import ExamScores, answer_exam, make_exam, score_exam
    from .api.export import ModelFromIndices, export_model, model_from_indices, read_parameters
    from .api.identification import Estimate, identify, simulate
    from .api.importing import Import, ImportDraft, draft_import, import_log
    from .api.lists import (
        list_causes,
        list_diagnosers,
        list_manoeuvres,
        list_methods,
        list_models,
        list_suites,
        list_vessels,
    )
    from .api.many import simulate_many
    from .api.reproduction import Reproduction, reproduce
    from .api.suites import SuiteResults, compare_results, leaderboard, load_results, merge_results, run_suite
    from .api.validation import Validation, validate
    from .bench.identibench.method import identibench_model
    from .bench.identibench.problems import export_problems
    from .bench.identibench.ship import identibench_suite
    from .bench.identibench.specs import identibench_specs
    from .datasets.generator import Case, generate
    from .datasets.io import read_record, write_record
    from .datasets.many import SimulatedRuns
    from .datasets.measured import fetch
    from .datasets.plausibility import PlausibilityWarning
    from .datasets.record import Record, RecordMeta
    from .datasets.rudder_sign import RudderSignWarning
    from .methods.registry import make as make_method
    from .methods.registry import method_options
    from .methods.tuned import with_tuner
    from .models.errors import BadInput, CannotFit, FitFailed
    from .models.model import Model, resolve
    from .reporting.leaderboard.comparing import Changes
    from .reporting.report import write_report

    __version__: str

__all__ = [
    "AdviceTest",
    "Assessment",
    "BadInput",
    "Calibration",
    "CannotFit",
    "Case",
    "Changes",
    "Check",
    "Comparison",
    "CraftDiagnosis",
    "Diagnosis",
    "Estimate",
    "ExamScores",
    "FitFailed",
    "Health",
    "Import",
    "ImportDraft",
    "Model",
    "ModelFromIndices",
    "PlausibilityWarning",
    "Record",
    "RecordMeta",
    "Reproduction",
    "RudderSignWarning",
    "SimulatedRuns",
    "SuiteResults",
    "Validation",
    "__version__",
    "answer_exam",
    "build_model",
    "calibrate",
    "check",
    "check_advice",
    "compare",
    "compare_results",
    "diagnose",
    "doctor",
    "draft_import",
    "export_model",
    "export_problems",
    "fetch",
    "generate",
    "identibench_model",
    "identibench_specs",
    "identibench_suite",
    "identify",
    "import_log",
    "leaderboard",
    "list_causes",
    "list_diagnosers",
    "list_manoeuvres",
    "list_methods",
    "list_models",
    "list_suites",
    "list_vessels",
    "load_results",
    "make_exam",
    "make_method",
    "merge_results",
    "method_options",
    "model_from_indices",
    "read_parameters",
    "read_record",
    "reproduce",
    "resolve",
    "rudder_sign_doubt",
    "run_suite",
    "score_exam",
    "simulate",
    "simulate_many",
    "validate",
    "with_tuner",
    "write_record",
    "write_report",
]

# Python that is started in a checkout takes this folder before an installed package: the rooms stand beside it there.
if not Path(__file__).with_name("models").is_dir():
    __path__.append(str(Path(__file__).resolve().parents[1]))

# module below helmbench -> the public names that it has, `name=public name` where they differ
_NAMES = {
    "api.admission": "rudder_sign_doubt",
    "api.advice": "AdviceTest check_advice",
    "api.assessment": "Assessment Comparison compare",
    "api.check": "Check check",
    "api.craft": "CraftDiagnosis build_model",
    "api.diagnosis": "Calibration Diagnosis calibrate diagnose",
    "api.doctor": "Health doctor",
    "api.exam": "ExamScores answer_exam make_exam score_exam",
    "api.export": "ModelFromIndices export_model model_from_indices read_parameters",
    "api.identification": "Estimate identify simulate",
    "api.importing": "Import ImportDraft draft_import import_log",
    "api.lists": "list_causes list_diagnosers list_manoeuvres list_methods list_models list_suites list_vessels",
    "api.many": "simulate_many",
    "api.reproduction": "Reproduction reproduce",
    "api.suites": "SuiteResults compare_results leaderboard load_results merge_results run_suite",
    "api.validation": "Validation validate",
    "bench.identibench.method": "identibench_model",
    "bench.identibench.problems": "export_problems",
    "bench.identibench.ship": "identibench_suite",
    "bench.identibench.specs": "identibench_specs",
    "datasets.generator": "Case generate",
    "datasets.io": "read_record write_record",
    "datasets.many": "SimulatedRuns",
    "datasets.measured": "fetch",
    "datasets.plausibility": "PlausibilityWarning",
    "datasets.record": "Record RecordMeta",
    "datasets.rudder_sign": "RudderSignWarning",
    "methods.registry": "make=make_method method_options",
    "methods.tuned": "with_tuner",
    "models.errors": "BadInput CannotFit FitFailed",
    "models.model": "Model resolve",
    "reporting.leaderboard.comparing": "Changes",
    "reporting.report": "write_report",
}
_HOME = {
    own or name: (module, name)
    for module, names in _NAMES.items()
    for name, _, own in (text.partition("=") for text in names.split())
}
"""Public name -> module, and its name there."""


def _load(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("helmbench")
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _HOME[name]
    try:
        return getattr(import_module(f"{__name__}.{module}"), attribute)
    except ModuleNotFoundError as error:
        from .models.extras import missing_here

        raise ModuleNotFoundError(missing_here(error), name=error.name) from None


def __getattr__(name: str) -> Any:
    value = globals()[name] = _load(name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
