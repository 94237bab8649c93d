"""The discrepancy of a base model: parity, groups, what it must not imitate."""

import numpy as np
import pytest

from helmbench.diagnosis.causes.registry import terms_for
from helmbench.diagnosis.discrepancy.fit import Base
from helmbench.diagnosis.discrepancy.terms import EVEN, FORCES, NUMBERS, ODD, SIDE, terms_of, word
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.models.model import resolve

from ...expectations.injections import injected


@pytest.fixture(scope="module", params=["mariner", "s175", "kvlcc2-l7", "response-1"])
def base(request):
    """A ship without effects under the filter."""
    case = injected(request.param, (), np.random.default_rng(1))
    model = resolve(request.param)
    est = estimator(model, case.train[:2], terms=terms_for(model))
    return Base(est, terms_of(est, est.evaluate(est.start())), est.start())


def test_words_of_surge_are_even_and_those_of_sway_and_yaw_odd(rng):
    x = {letter: rng.standard_normal(5) for letter in "uvrd"}
    turned = {letter: values if letter == "u" else -values for letter, values in x.items()}
    assert all(word(w, turned) == pytest.approx(word(w, x)) for w in EVEN)
    assert all(word(w, turned) == pytest.approx(-word(w, x)) for w in ODD)


def test_every_number_of_the_model_stands_in_one_term(base):
    names = [p.name for p in base.terms.parameters]
    assert len(set(names)) == len(names) == base.terms.group.size
    entries = [p.slots[0][0] for p in base.terms.parameters if p.slots]
    assert len(set(entries)) == len(entries)
    nonzero = {n for n, v in zip(base.est.model.coordinates, base.est.model.coefficients, strict=True) if v}
    side = {"Y0", "N0", "Yu", "Yuu", "Nu", "Nuu"}
    assert nonzero - side <= {n.partition(" ")[2] for n in names if n.startswith("number")}
    groups = set(base.terms.group.tolist())
    assert NUMBERS in groups and max(groups) >= FORCES
    assert (SIDE in groups) == base.est.model.is_3dof
    assert base.terms.simulating.any()


def test_a_setting_holds_what_its_parameters_say(base, rng):
    x = 0.01 * rng.standard_normal(base.terms.group.size)
    s = base.at(x, (), base.origin)
    for p, value in zip(base.terms.parameters, x.tolist(), strict=True):
        if p.slots:
            ((entry, weight),) = p.slots
            assert s.vectors[0, entry] - base.est.base[entry] == pytest.approx(value * weight)
    forces = [(p.series[0], p.series[1][0] * v) for p, v in zip(base.terms.parameters, x, strict=True) if p.series]
    expected = np.zeros((base.est.segments[0].time.size, base.est.n_forces + 6))
    for axis, series in forces:
        expected[:, axis] += series
    if forces:
        assert s.added[0] == pytest.approx(expected)
    assert base.at(np.zeros(x.size), (), base.origin).added is None


def test_blocks_cover_every_sample_once(base):
    seen = np.concatenate([np.arange(a, b) for _, a, b in base.blocks])
    assert np.array_equal(seen, np.arange(base.est.edges[-1]))
