"""Names that are used, but not where vulture looks for it: by users, by other packages, or through `_asdict`."""

from inspect import signature

from joblib.externals.loky import process_executor

from helmbench.bench.exam.key import Key
from helmbench.bench.exam.submission import Submission
from helmbench.bench.identibench.problems import ProblemsFile
from helmbench.bench.store import MergedFile
from helmbench.cli._shared import CommandGroup
from helmbench.datasets import indices, manoeuvres
from helmbench.datasets.many import SimulatedRuns
from helmbench.datasets.record import Record, RecordMeta
from helmbench.diagnosis.calibration.result import Share
from helmbench.diagnosis.contract import check_cause
from helmbench.estimation.estimates.estimate import Estimate
from helmbench.estimation.methods_only.tuning.abc import ABCSampler
from helmbench.methods import contract
from helmbench.methods.base import Method
from helmbench.methods.output_error import Interval
from helmbench.models.lanes import open_loops

deep = signature(Method.get_params).parameters["deep"]

USED = (
    ABCSampler.infer_relative_search_space,  # by Optuna
    ABCSampler.sample_relative,
    ABCSampler.sample_independent,
    CommandGroup.format_commands,  # by click
    CommandGroup.list_commands,
    Interval.low_open,  # by `_asdict`
    Interval.high_open,
    Key.schema_version,  # keys of files
    Submission.schema_version,
    ProblemsFile.schema_version,
    MergedFile.journal,
    RecordMeta.reference_point,  # by the sidecar of a record
    deep,  # given by scikit-learn
    Estimate.to_dataframe,  # by users
    Record.from_dataframe,
    Record.to_dataframe,
    SimulatedRuns.record,
    SimulatedRuns.to_dataframe,
    SimulatedRuns.indices_to_dataframe,
    indices.overshoots,
    indices.overshoot_times,
    manoeuvres.from_series,
    Share.trim,  # by a table, by name
    open_loops,  # timed against the scalar kernel
    contract.check_method,  # by authors of other methods
    check_cause,  # by authors of other causes
    process_executor._MAX_MEMORY_LEAK_SIZE,  # read by loky
)
