"""Linear algebra that ends, and inverses of information matrices in units of their diagonal."""

import re
from pathlib import Path

import numpy as np
import pytest

from helmbench.models import linear_algebra
from helmbench.models.linear_algebra import information_inverse

ROOT = Path(__file__).resolve().parents[2]
ENDLESS = ("lstsq", "svd", "pinv", "matrix_rank", "cond")
"""Functions of numpy.linalg that may never return from an infinity."""


def test_the_inverse_does_not_depend_on_the_units_of_the_parameters(rng):
    rows = rng.standard_normal((20, 4))
    units = 10.0 ** rng.uniform(-40.0, 40.0, 4)
    matrix = (rows * units).T @ (rows * units)
    wanted = np.linalg.inv(rows.T @ rows)
    assert information_inverse(matrix, 1e-12) * np.outer(units, units) == pytest.approx(wanted, rel=1e-8)


def test_a_parameter_that_changes_nothing_has_no_covariance(rng):
    rows = rng.standard_normal((20, 3))
    rows[:, 1] = 0.0
    found = information_inverse(rows.T @ rows, 1e-12)
    kept = [0, 2]
    assert not found[1].any() and not found[:, 1].any()
    assert found[np.ix_(kept, kept)] == pytest.approx(np.linalg.inv(rows[:, kept].T @ rows[:, kept]))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused(bad):
    matrix = np.eye(3)
    matrix[1, 0] = bad
    with pytest.raises(np.linalg.LinAlgError, match="not finite"):
        linear_algebra.lstsq(matrix, np.ones(3))
    for name in ("finite", "svd", "pinv", "matrix_rank", "condition_number"):
        with pytest.raises(np.linalg.LinAlgError, match="not finite"):
            getattr(linear_algebra, name)(matrix)


def test_no_other_file_calls_what_may_never_return():
    rooms = [path for path in ROOT.iterdir() if (path / "__init__.py").exists() and path.name != "tests"]
    files = [path for room in rooms for path in room.rglob("*.py") if path != ROOT / "models" / "linear_algebra.py"]
    calls = re.compile(rf"linalg\.({'|'.join(ENDLESS)})\b|linalg import .*\b({'|'.join(ENDLESS)})\b")
    wrong = [str(path) for path in files if calls.search(path.read_text().replace("scipy.linalg", ""))]
    assert len(files) > 500 and wrong == []
