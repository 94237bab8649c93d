"""Names that are used, but not where vulture looks for it: by users, by other packages, or through `_asdict`."""

from helmbench.estimation.likelihood.profile import Interval
from helmbench.estimation.tuning.abc import ABCSampler
from helmbench.methods import contract
from helmbench.methods.base import RecursiveMethod

USED = (
    ABCSampler.infer_relative_search_space,  # by Optuna
    ABCSampler.sample_relative,
    Interval.low_open,  # by `_asdict`
    Interval.high_open,
    RecursiveMethod.reset,  # by users of partial_fit
    contract.check_method,  # by authors of other methods
)
