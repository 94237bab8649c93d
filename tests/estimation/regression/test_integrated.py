"""Integrated equations, against the reference values of paper 000 and on generated records."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record
from helmbench.estimation.regression.integrated import rudder_integrals
from helmbench.estimation.regression.schemes import regression_samples
from helmbench.methods.registry import make
from helmbench.models.model import resolve
from helmbench.models.simulate import zoh_matrices

DEGREE = np.pi / 180


def remus_zigzag(noise_rad=0.0, rng=None):
    """20/20 zigzag of paper 000 on the continuous model, rudder held: 200 samples of 0.1 s, column k held from k on."""
    a, b = zoh_matrices(resolve("remus-kt"), 0.1)
    psi, delta, x, side = np.zeros(201), np.zeros(201), np.zeros(3), 1.0
    for k in range(1, 201):
        if side * psi[k - 1] >= 20 * DEGREE:
            side = -side
        delta[k] = side * 20 * DEGREE
        x = a @ x + b[:, 0] * delta[k]
        psi[k] = x[2]
    held = np.append(delta[1:], delta[-1])
    noise = 0.0 if rng is None else rng.normal(0.0, noise_rad, psi.size)
    return Record(0.1 * np.arange(201), {"rudder_rad": held, "heading_rad": psi + noise})


def errors(estimate, model):
    return np.array([estimate.parameters[name] / model.parameters[name] - 1.0 for name in model.parameter_names])


@pytest.mark.parametrize("scheme", ["triple-integral-held", "triple-integral-rest"])
def test_triple_integral_on_paper_000_continuous_data(scheme):
    """Noise-free bias at most .9 % where regression on eq 8 is wrong by 300 %."""
    model = resolve("remus-kt")
    assert np.abs(errors(make("ls", scheme=scheme).fit([remus_zigzag()], model), model)).max() < 9e-3
    assert errors(make("ls", scheme="heading-difference").fit([remus_zigzag()], model), model).max() > 3.0


@pytest.mark.nightly
def test_triple_integral_with_heading_noise(rng):
    """3 to 4 times the Cramer-Rao bound at .1 deg (reference p000_CRB_sd_0.1deg_exact), 80 runs."""
    model, method = resolve("remus-kt"), make("ls", scheme="triple-integral-rest")
    found = [method.fit([remus_zigzag(0.1 * DEGREE, rng)], model).coefficients for _ in range(80)]
    bound = [0.008402834047297542, 0.017420553495216342, 0.018128520195117164, 0.01094416340161591]  # T1, T2, K, T3
    ratio = np.std(found, axis=0) / bound
    assert ratio.min() > 2.3 and ratio.max() < 5.5
    assert np.abs(np.median(found, axis=0) / model.coefficients - 1.0).max() < 0.03


@pytest.mark.parametrize("name", ["response-1", "response-2", "cargo", "remus-kt"])
@pytest.mark.parametrize("missing", ["heading_rad", "yaw_rate_rad_s"])
def test_triple_integral_on_generated_records(name, missing):
    """A rudder linear between samples, from heading or yaw rate alone, starting anywhere, with gaps."""
    model = resolve(name)
    record = generate(Case(name, "zigzag:20/20")).with_channels(**{missing: None})
    found = make("ls", scheme="triple-integral").fit([record.slice(record.n // 4, None)], model)
    assert np.abs(errors(found, model)).max() < 5e-3
    channel = next(c for c in ("heading_rad", "yaw_rate_rad_s") if record.has(c))
    gaps = record.column(channel).copy()
    gaps[100:120] = np.nan
    holed = make("ls", scheme="triple-integral").fit([record.with_channels(**{channel: gaps})], model)
    assert np.abs(errors(holed, model)).max() < 5e-3


def test_integrated_3dof_regression_holds_at_the_truth():
    model = resolve("kvlcc2-l7")
    record = generate(Case("kvlcc2-l7", "zigzag:20/20", duration_s=60, dt_s=0.1))
    y, phi = next(regression_samples([record], model.blanked(), "triple-integral")[0].blocks(model))
    left = y - phi @ model.coefficients
    assert np.abs(left).max() < 1e-3 * np.abs(y).max()


def test_rudder_integrals_are_exact(rng):
    """Against a fine sum, for a held and for a linear rudder on uneven steps."""
    dt = rng.uniform(0.5, 1.5, 6)
    time, rudder = np.concatenate([[0.0], np.cumsum(dt)]), rng.normal(size=7)
    fine = np.linspace(0.0, time[-1], 200001)
    for held in (True, False):
        place = np.searchsorted(time, fine, side="right") - 1
        value = rudder[np.minimum(place, 6)] if held else np.interp(fine, time, rudder)
        for found in rudder_integrals(rudder, dt, held):
            value = np.concatenate([[0.0], np.cumsum((value[1:] + value[:-1]) / 2.0 * np.diff(fine))])
            assert found == pytest.approx(np.interp(time, fine, value), abs=3e-3)
