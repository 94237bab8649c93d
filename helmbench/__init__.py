"""helmbench: benchmark and diagnosis of methods that identify ship manoeuvring models from records.

`import helmbench` offers the names below.  Each is loaded when it is first used, so that the import itself is quick:

    import helmbench

    record = helmbench.simulate("mariner", "zigzag:20/20", noise="low", seed=1)
    estimate = helmbench.identify(record, "mariner", "ls")
    print(estimate.parameters, estimate.stderr)

SI units and radians throughout, unless a name says otherwise.
"""
# ruff: noqa: I001 (the imports for type checkers)

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

if TYPE_CHECKING:  # each as itself, which type checkers take for a public name
    from .api.advice import AdviceTest as AdviceTest, check_advice as check_advice
    from .api.arguments import rudder_sign_doubt as rudder_sign_doubt
    from .api.check import check as check
    from .api.diagnosis import Calibration as Calibration, CraftDiagnosis as CraftDiagnosis, Diagnosis as Diagnosis
    from .api.diagnosis import build_model as build_model, calibrate as calibrate, diagnose as diagnose
    from .api.doctor import Health as Health, doctor as doctor
    from .api.exam import ExamScores as ExamScores, answer_exam as answer_exam, make_exam as make_exam
    from .api.exam import score_exam as score_exam
    from .api.export import ModelFromIndices as ModelFromIndices, export_model as export_model
    from .api.export import model_from_indices as model_from_indices, read_parameters as read_parameters
    from .api.identification import Estimate as Estimate, compare as compare, identify as identify
    from .api.importing import Import as Import, ImportDraft as ImportDraft, draft_import as draft_import
    from .api.importing import import_log as import_log
    from .api.lists import list_causes as list_causes, list_diagnosers as list_diagnosers
    from .api.lists import list_manoeuvres as list_manoeuvres, list_methods as list_methods, list_suites as list_suites
    from .api.reproduction import Reproduction as Reproduction, reproduce as reproduce
    from .api.simulation import simulate as simulate, simulate_many as simulate_many
    from .api.suites import SuiteResults as SuiteResults, compare_results as compare_results, leaderboard as leaderboard
    from .api.suites import load_results as load_results, merge_results as merge_results, run_suite as run_suite
    from .api.validation import Validation as Validation, validate as validate
    from .bench.identibench.method import identibench_model as identibench_model
    from .bench.identibench.problems import export_problems as export_problems, identibench_specs as identibench_specs
    from .bench.identibench.ship import identibench_suite as identibench_suite
    from .checks.result import Check as Check
    from .datasets.generator import Case as Case, generate as generate
    from .datasets.io import read_record as read_record, write_record as write_record
    from .datasets.many import SimulatedRuns as SimulatedRuns
    from .datasets.measured import fetch as fetch
    from .datasets.plausibility import PlausibilityWarning as PlausibilityWarning
    from .datasets.record import Record as Record, RecordMeta as RecordMeta
    from .datasets.rudder_sign import RudderSignWarning as RudderSignWarning
    from .estimation.estimates.assessment import Assessment as Assessment
    from .estimation.estimates.comparison import Comparison as Comparison
    from .methods.registry import make, method_options as method_options
    from .methods.tuned import with_tuner as with_tuner
    from .models.errors import BadInput as BadInput, CannotFit as CannotFit, FitFailed as FitFailed
    from .models.model import Model as Model, list_vessels as list_vessels, resolve as resolve
    from .models.model import list_families
    from .reporting.leaderboard.comparing import Changes as Changes
    from .reporting.report import write_report as write_report

    list_models, make_method = list_families, make
    __version__: str

# Python that is started in a checkout takes this folder before an installed package: the rooms stand beside it there.
if not Path(__file__).with_name("models").is_dir():
    __path__.append(str(Path(__file__).resolve().parents[1]))

# module below helmbench -> the public names that it has, `name=public name` where they differ
_NAMES = {
    "api.advice": "AdviceTest check_advice",
    "api.arguments": "rudder_sign_doubt",
    "api.check": "check",
    "api.diagnosis": "Calibration CraftDiagnosis Diagnosis build_model calibrate diagnose",
    "api.doctor": "Health doctor",
    "api.exam": "ExamScores answer_exam make_exam score_exam",
    "api.export": "ModelFromIndices export_model model_from_indices read_parameters",
    "api.identification": "Estimate compare identify",
    "api.importing": "Import ImportDraft draft_import import_log",
    "api.lists": "list_causes list_diagnosers list_manoeuvres list_methods list_suites",
    "api.reproduction": "Reproduction reproduce",
    "api.simulation": "simulate simulate_many",
    "api.suites": "SuiteResults compare_results leaderboard load_results merge_results run_suite",
    "api.validation": "Validation validate",
    "bench.identibench.method": "identibench_model",
    "bench.identibench.problems": "export_problems identibench_specs",
    "bench.identibench.ship": "identibench_suite",
    "checks.result": "Check",
    "datasets.generator": "Case generate",
    "datasets.io": "read_record write_record",
    "datasets.many": "SimulatedRuns",
    "datasets.measured": "fetch",
    "datasets.plausibility": "PlausibilityWarning",
    "datasets.record": "Record RecordMeta",
    "datasets.rudder_sign": "RudderSignWarning",
    "estimation.estimates.assessment": "Assessment",
    "estimation.estimates.comparison": "Comparison",
    "methods.registry": "make=make_method method_options",
    "methods.tuned": "with_tuner",
    "models.errors": "BadInput CannotFit FitFailed",
    "models.model": "Model list_families=list_models list_vessels resolve",
    "reporting.leaderboard.comparing": "Changes",
    "reporting.report": "write_report",
}
_HOME = {
    own or name: (module, name)
    for module, names in _NAMES.items()
    for name, _, own in (text.partition("=") for text in names.split())
}
"""Public name -> module, and its name there."""
__all__ = sorted(["__version__", *_HOME])


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
