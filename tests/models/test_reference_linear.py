"""Straight-course linearisation: Nomoto constants of the Mariner, K-T constants of REMUS, its heading controller."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve
from helmbench.models.simulate import state_matrices


def kt_constants(model):
    """T1, T2, K, T3 of r_ddot + T1 r_dot + T2 r = K delta + T3 delta_dot, by elimination of v."""
    a, b = state_matrices(model)
    a, b = a[1:3, 1:3], b[1:3, 0]
    return -np.trace(a), np.linalg.det(a), a[1, 0] * b[0] - a[0, 0] * b[1], b[1]


def test_mariner_nomoto_constants():
    model = resolve("mariner")
    t1, t2, gain, t3 = kt_constants(model)
    poles = np.roots([1.0, t1, t2])
    published = [-0.1849915502894653, 117.97831293602371, 7.763007547625888, 18.53016087951768]
    slow, fast = sorted(-1.0 / poles, reverse=True)
    np.testing.assert_allclose([gain / t2, slow, fast, t3 / gain], published, rtol=1e-6)
    time = model.particulars["L"] / model.speed_m_s
    np.testing.assert_allclose(sorted(poles * time), [-2.6861506422375943, -0.1767494990461369], rtol=1e-6)
    primes = [-3.857556227804814, 5.657724663417405, 0.37227994002860115, 0.8886255924170614]
    np.testing.assert_allclose([gain / t2 * time, slow / time, fast / time, t3 / gain / time], primes, rtol=1e-6)


def test_remus_table_1_gives_a_course_unstable_vehicle():
    found = kt_constants(resolve("remus"))
    expected = [1.2835717339260495, -2.225310415481101, 2.5403395501140267, 1.5952305218802232]
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    poles = sorted(np.roots([1.0, *found[:2]]))
    np.testing.assert_allclose(poles, [-2.266, 0.982], atol=5e-4)


def test_remus_table_1_is_not_equation_23():
    assert np.max(np.abs(np.array(kt_constants(resolve("remus"))) / list(resolve("remus-kt").theta) - 1.0)) > 0.1


def test_remus_heading_controller_stabilises_with_the_fin_lag():
    model = resolve("remus")
    assert model.controller is not None and model.rudder.lag_s > 0.0
    a, b = state_matrices(model)
    picked = [model.states.index(name) for name in ("v", "r", "psi")]
    loop = np.zeros((4, 4))
    loop[:3, :3], loop[:3, 3] = a[np.ix_(picked, picked)], b[picked, 0]
    loop[3] = [0.0, -model.controller.kd, -model.controller.kp, -1.0]
    loop[3] /= model.rudder.lag_s
    poles = np.linalg.eigvals(loop)
    assert np.max(poles.real) < -0.75
    assert np.min(-poles.real / np.abs(poles)) > 0.7
    open_loop = np.linalg.eigvals(a[np.ix_(picked, picked)])
    assert np.max(open_loop.real) == pytest.approx(0.982, abs=5e-4)


def test_remus_follows_a_heading_but_cannot_run_free_for_long():
    steered = generate(Case("remus", "heading:8deg/20s", duration_s=60.0))
    assert np.max(np.abs(steered.column("heading_rad"))) < np.deg2rad(12.0)
    with pytest.raises(BadInput, match="diverges"):
        generate(Case("remus", "sine:10deg/1.5s", duration_s=60.0))
