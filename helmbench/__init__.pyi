"""The public names of helmbench, and the module that each is in: type checkers read this file, and `__init__.py`."""
# ruff: noqa: I001

from .api.advice import AdviceTest as AdviceTest, check_advice as check_advice
from .api.arguments import rudder_sign_doubt as rudder_sign_doubt
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
from .api.records import Validation as Validation, check as check, validate as validate
from .api.reproduction import Reproduction as Reproduction, reproduce as reproduce
from .api.simulation import simulate as simulate, simulate_many as simulate_many
from .api.suites import SuiteResults as SuiteResults, compare_results as compare_results, leaderboard as leaderboard
from .api.suites import load_results as load_results, merge_results as merge_results, run_suite as run_suite
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
from .datasets.yaw_response import RudderSignWarning as RudderSignWarning
from .estimation.estimates.assessment import Assessment as Assessment
from .estimation.estimates.comparison import Comparison as Comparison
from .methods.registry import make as make_method, method_options as method_options
from .methods.tuned import with_tuner as with_tuner
from .models.errors import BadInput as BadInput, CannotFit as CannotFit, FitFailed as FitFailed
from .models.model import Model as Model, list_vessels as list_vessels, resolve as resolve
from .models.model import list_families as list_models
from .reporting.leaderboard.comparing import Changes as Changes
from .reporting.report import write_report as write_report

__version__: str
# Names that are another in their module, which type checkers would take for private.
__all__ = ["list_models", "make_method"]
