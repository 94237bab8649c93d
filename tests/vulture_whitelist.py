"""Names that are used, but not where vulture looks for it: by users, by other packages, or through `_asdict`."""

from helmbench.bench.faults.effects.base import ScalarKind
from helmbench.bench.kinds.diagnosis.judge import OUTCOMES
from helmbench.bench.kinds.identification.suite import Entry
from helmbench.bench.pool import inline
from helmbench.bench.scores.parameter_error import parameter_error
from helmbench.estimation.likelihood.profile import Interval
from helmbench.estimation.tuning.abc import ABCSampler
from helmbench.methods import contract
from helmbench.methods.base import RecursiveMethod

USED = (
    ScalarKind.__init_subclass__,  # by Python
    OUTCOMES,  # says what the outcomes of a case mean
    Entry._records_are_named,  # by pydantic
    inline,  # for tests and for debugging
    parameter_error,  # by the registry of scores
    ABCSampler.infer_relative_search_space,  # by Optuna
    ABCSampler.sample_relative,
    Interval.low_open,  # by `_asdict`
    Interval.high_open,
    RecursiveMethod.reset,  # by users of partial_fit
    contract.check_method,  # by authors of other methods
)
