"""Paper 001: the table as printed, what explains it, and the keys that the claims refer to."""

import numpy as np
import pytest

from helmbench.models.model import resolve
from helmbench.reproduction.claims import files
from helmbench.reproduction.papers.paper_001 import studies
from helmbench.reproduction.verdicts import spread, within

from .named import drawn


@pytest.fixture(scope="module")
def paper():
    return files.load("001")


@pytest.fixture(scope="module")
def found():
    """One run of every study."""
    return {name: study.function(np.random.default_rng(0), index=0) for name, study in studies.STUDIES.items()}


def test_all_sixty_parameters_have_a_claim_in_every_column(paper):
    ids = {claim.id for claim in paper.claims}
    for column in ("original", "A1", "A2"):
        assert {f"table2-{column}-{name}" for name in resolve("mariner-model").coordinates} <= ids


@pytest.mark.nightly
def test_every_key_is_computed(paper, found):
    entries = [(c.study, key) for c in paper.claims for key in (c.corrected, c.as_printed) if key]
    entries += [(check.study, check.key) for check in paper.checks()]
    assert [entry for entry in entries if entry[1] not in found[entry[0]].values] == []


@pytest.mark.nightly
def test_independent_values_are_reached(paper, found):
    missed = [c.id for c in paper.checks() if not within(c, spread([found[c.study].values[c.key]]))]
    assert missed == []


def test_playing_backwards_is_a_backward_difference():
    """On a record of explicit Euler run backwards in time, backward differences are exact and forward ones are not."""
    setting = studies.SETTING._replace(duration=80.0)
    model = studies.vessel(setting)
    record = studies.sailed(setting)
    forward, backward = studies.found_by("euler-ls", record, model), studies.backward(record, model)
    true = model.coefficients
    lean = (forward - true) @ (backward - true)
    assert lean < -0.5 * np.linalg.norm(forward - true) * np.linalg.norm(backward - true)


def test_another_inertia_matrix_is_found(rng):
    """Sway and yaw rows mixed by a known matrix: it is found, surge stays as it is."""
    model = resolve("mariner-model")
    c = model.coefficients + 1e-4 * rng.normal(size=60)
    matrix = np.eye(2) + 0.2 * rng.normal(size=(2, 2))
    sway, yaw = slice(16, 38), slice(38, 60)
    target = np.concatenate([c[:16], *(matrix @ [c[sway], c[yaw]])])
    assert studies.mix(c, target, model) == pytest.approx(target, rel=1e-6)


@pytest.mark.nightly
def test_a_diverged_prediction_is_worse_than_any(found):
    values = found["predictions"].values
    assert np.isnan(values["Figure 5.A2p.heading"]) and values["A1p beats A2p"]
    assert 0.0 < values["Figure 5.midpoint.heading"] < values["Figure 5.A1p.heading"]


@pytest.mark.nightly
def test_figures_are_drawn(found):
    sizes = drawn("001", found)
    assert set(sizes) == {"data", "headings", "tracks", "table2", "accuracy", "explanation"}
    assert min(sizes.values()) > 1000 and max(sizes.values()) < 200_000


def test_settings_are_points_of_a_sequence_and_not_of_a_seed():
    one, two = (studies.settings(np.random.default_rng(seed), index=3).values for seed in (0, 1))
    assert one == two and np.isfinite(one["A1.median"])


def test_a_constant_speed_in_the_primes_makes_a2_singular():
    """u(t) is then the sum of two other columns: scaled to unit length they have no full rank."""
    record, model = studies.sailed(studies.SETTING), studies.vessel(studies.SETTING)
    surge = studies._terms(record, model)[:, np.array([name[0] == "X" for name in model.coordinates])]
    columns = np.column_stack([record.column("surge_m_s"), surge])
    columns /= np.linalg.norm(columns, axis=0)
    assert np.linalg.matrix_rank(columns[:, 1:]) == np.linalg.matrix_rank(columns) == surge.shape[1]
