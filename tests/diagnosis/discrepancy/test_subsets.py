"""The best small sets of numbers by a quadratic likelihood."""

from itertools import combinations

import numpy as np
import pytest

from helmbench.diagnosis.discrepancy import subsets
from helmbench.diagnosis.discrepancy.projection import Profile
from helmbench.models.coefficient_groups import GROSS, groups_of, parts_of
from helmbench.models.model import resolve


@pytest.fixture
def profile(rng):
    """A likelihood of 12 correlated numbers of which the places 3 and 8 are wrong."""
    columns = rng.normal(size=(400, 12)) + rng.normal(size=(400, 1))
    truth = np.zeros(12)
    truth[[3, 8]] = 2.0, -1.5
    error = columns @ truth + 0.1 * rng.normal(size=400)
    names = tuple(f"n{i}" for i in range(12))
    return Profile(names, columns.T @ columns, columns.T @ error, 1.0, 400)


def test_the_best_set_of_a_size_is_the_best_of_all(profile):
    best = profile.best(2)
    gains = [profile.gain(pair) for pair in combinations(range(12), 2)]
    assert set(best) == {3, 8}
    assert profile.gain(best) == pytest.approx(max(gains))


def test_exchanges_lead_from_wrong_numbers_to_the_right_ones(profile):
    assert set(subsets._exchanged(profile, [0, 1])) == {3, 8}


class Rounded(Profile):
    """Gains that hang on the order of the numbers, as those of nearly dependent columns do by rounding."""

    def gain(self, chosen):
        return super().gain(chosen) + 1e-6 * (len(chosen) > 1 and chosen[0] > chosen[-1])


@pytest.mark.parametrize("slope", [np.zeros(4), np.full(4, np.nan), np.array([1.0, 1.0, 0.0, 0.0])], ids=str)
def test_exchanges_end_where_gains_are_rounded_or_unknown(slope):
    rounded = Rounded(tuple("abcd"), np.eye(4), slope, 1.0, 400)
    assert len(set(subsets._exchanged(rounded, [0, 1]))) == 2
    assert len(subsets.best_subsets(rounded)) == 4


def test_what_would_do_as_well_is_what_is_nearly_the_same(profile):
    twin = Profile(
        (*profile.names, "twin"),
        np.block([[profile.matrix, profile.matrix[:, [3]]], [profile.matrix[[3]], profile.matrix[3, 3] * (1 + 1e-9)]]),
        np.append(profile.slope, profile.slope[3]),
        1.0,
        400,
    )
    assert subsets._rivals(twin, [3, 8], 0) == ("twin",)
    assert subsets._rivals(profile, [3, 8], 1) == ()


@pytest.mark.parametrize("vessel", ["kvlcc2-l7", "mariner", "s175"])
def test_numbers_of_drawings_stand_alone(vessel):
    groups = groups_of(resolve(vessel))
    for group in groups:
        parts = {part.id.rpartition(".")[2]: part for part in parts_of(group)}
        assert set(parts) == set(group.every) - (set(group.sd) if len(group.sd) == 1 else set())
        assert all(part.of == group.id and part.sd[name] == GROSS * group.every[name] for name, part in parts.items())
    assert [g.id for g in groups if g.slips] == {"mariner": ["inertia"]}.get(vessel, ["propeller_thrust", "inertia"])
