"""Comparison of models and methods: what each is fitted to and tested on, and which is chosen."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.estimates.comparison import compare, families_for
from helmbench.estimation.validation.validate import validate
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput, CannotFit, FitFailed
from helmbench.models.model import resolve


class Spy:
    """Least squares that notes what it is fitted to."""

    def __init__(self, spoil=1.0):
        self.seen, self.spoil = [], spoil

    def fit(self, records, model):
        self.seen.append([(record.name, record.n) for record in records])
        found = make("ls").fit(records, model)
        worse = found.model.with_coefficients(self.spoil * found.coefficients)
        return replace(found, model=worse)


def out_of_luck(records, model):
    raise FitFailed("out of luck")


@pytest.fixture(scope="module")
def records():
    texts = ("zigzag:20/20", "zigzag:10/10:port", "turn:15")
    return [generate(Case("response-1", text, "low", seed=k)) for k, text in enumerate(texts)]


def entrant(fitter, model="response-1", name="spy"):
    return resolve(model), name, fitter


def test_held_out_records_take_no_part(records):
    spy = Spy()
    found = compare([entrant(spy)], records[:2], records[2:])
    assert spy.seen == [[(record.name, record.n) for record in records[:2]]]
    assert (found.basis, found.tested) == ("held out", (records[2].name,))
    assert found.channels == ("heading_rad", "yaw_rate_rad_s")


def test_each_record_is_left_out_in_turn(records):
    spy = Spy()
    found = compare([entrant(spy)], records)
    names = [record.name for record in records]
    assert found.basis == "records left out" and list(found.tested) == names
    assert [[name for name, _ in seen] for seen in spy.seen] == [names, names[1:], [names[0], names[2]], names[:2]]


def test_blocks_of_a_single_record_are_left_out(records):
    spy = Spy()
    found = compare([entrant(spy)], records[:1])
    n = records[0].n
    assert found.basis == "blocks left out" and len(found.tested) == 4
    assert sum(k for _, k in spy.seen[0]) == n
    assert all(n - sum(k for _, k in seen) in (n // 4, n // 4 + 1) for seen in spy.seen[1:])
    with pytest.raises(BadInput, match="cannot be cut"):
        compare([entrant(spy)], [records[0].slice(0, 40)])


def test_errors_are_those_of_a_validation(records):
    found = compare([entrant(make("ls"), name="ls")], records[:2], records[2:]).chosen
    expected = validate({"m": found.estimate.model}, {"r": records[2]})
    r2 = [expected.score(channel).r2 for channel in ("heading_rad", "yaw_rate_rad_s")]
    assert found.error == pytest.approx(np.mean(np.sqrt(1.0 - np.array(r2))), rel=1e-9)
    assert found.pooled("heading_rad").scores()[0] == pytest.approx(expected.score("heading_rad").rmse, rel=1e-12)


def test_the_better_one_is_chosen_and_failures_are_kept(records):
    given = [
        entrant(Spy(0.8), name="spoiled"),
        entrant(SimpleNamespace(fit=out_of_luck), name="failing"),
        entrant(Spy(), name="good"),
    ]
    found = compare(given, records[:2], records[2:])
    assert found.chosen.method == "good" and found.candidates[1].reason == "out of luck"
    assert np.isnan(found.candidates[1].error) and found.candidates[0].error > 2.0 * found.chosen.error
    with pytest.raises(CannotFit, match="out of luck"):
        compare(given[1:2], records)


def test_a_run_that_diverges_is_never_chosen(records):
    found = compare([entrant(Spy(-1.0), name="wild"), entrant(Spy(0.5), name="poor")], records[:2], records[2:])
    assert found.candidates[0].error == np.inf and found.candidates[0].reason == "diverges"
    assert found.chosen.method == "poor"


def test_of_equal_models_the_one_with_fewer_coefficients_is_chosen(seed):
    truth = resolve("nomoto-1").with_coefficients([-0.07, 0.015])
    from helmbench.datasets.generator import record_run
    from helmbench.datasets.manoeuvres import parse_manoeuvre
    from helmbench.datasets.sensors import parse_noise

    texts = ("zigzag:20/20", "prbs:15deg/15s", "zigzag:20/10:port")
    records = [
        record_run(truth, parse_manoeuvre(text), parse_noise("low"), seed=seed % 2**31 + k, duration_s=150.0, dt_s=0.5)
        for k, text in enumerate(texts)
    ]
    models = ["nomoto-1-cubic", "nomoto-1", "integrator"]
    found = compare([(resolve(name), "output-error", make("output-error")) for name in models], records)
    errors = {one.model.id: one.error for one in found.candidates}
    assert found.chosen.model.id in ("nomoto-1", "nomoto-1-cubic")  # a tie may go to the larger one by chance
    assert errors["integrator"] > 10.0 * errors["nomoto-1"] and errors["nomoto-1-cubic"] < 1.2 * errors["nomoto-1"]


def test_families_for_records_need_no_constants(records):
    names = [model.id for model in families_for(records)]
    assert {"nomoto-1", "nomoto-2-quadratic", "kt", "integrator"} <= set(names)
    assert "mmg" not in names and "nomoto-2-steered" not in names
    ship = generate(Case("kvlcc2-l7", "zigzag:20/20"))
    (own,) = [model for model in families_for([ship]) if model.id not in names]
    assert own.id == "kvlcc2-l7" and not own.known
