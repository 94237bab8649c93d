"""Identifiability: the published counts and groups for Mariner, every vessel, and recommended manoeuvres."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.information.bounds import cramer_rao
from helmbench.estimation.information.identifiability import identifiability, noise_of
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import list_vessels, resolve
from helmbench.models.simulate import initial_state, inputs_of, simulate

NOISE = {"surge_m_s": 0.01, "sway_m_s": 0.01, "yaw_rate_rad_s": np.deg2rad(0.05)}
# Records at model scale, 160 s at 10 Hz, each set added to the ones before; counts of relative bounds < 10 %, 10-50 %
# and > 50 % among the 40 coefficients that are not zero, as computed independently for such sets.
SETS = [
    (["zigzag:15/15:port"], (1, 3, 36)),
    (["zigzag:30/30:port"], (5, 7, 28)),
    (["turn:15:port", "turn:30"], (8, 9, 23)),
    (["sine:15deg/40s", "sine:30deg/40s"], (9, 8, 23)),
    (["steps:35deg/4s", "steps:35deg/4s"], (12, 12, 16)),
]
SPEEDS = (0.5, 0.75, 1.25, 1.5)
PUBLISHED = [
    {"vvv", "vvr", "vrr", "rrr", "rrd", "rvd"},
    {"vu", "ru", "du", "vuu", "ruu"},
    {"v", "r"},
    {"vr", "uvr", "rr", "urr", "vv", "uvv"},
    {"u", "uu", "uuu"},
]


def simulated_record(text, seed):
    return generate(Case("mariner-model", text, duration_s=160.0, dt_s=0.1, seed=seed))


def at_speed(record, share):
    """The record's rudder series from another initial speed."""
    model = resolve("mariner-model")
    start = initial_state(model)
    start[0] *= share
    run = simulate(model, inputs_of(model, record.rudder()), record.dt, start)
    return record.with_channels(surge_m_s=run[:, 0], sway_m_s=run[:, 1], yaw_rate_rad_s=run[:, 2])


def test_mariners_counts():
    model, records = resolve("mariner-model"), []
    for texts, expected in SETS:
        records += [simulated_record(text, seed) for seed, text in enumerate(texts, 1)]
        found = identifiability(model, records, NOISE, [])
        assert found.counts == expected, (texts, found.counts)
    records += [at_speed(simulated_record("steps:35deg/4s", 3 + i), share) for i, share in enumerate(SPEEDS)]
    counts = identifiability(model, records, NOISE, []).counts
    assert np.abs(np.subtract(counts, (18, 11, 11))).max() <= 3, counts  # the published series are not known


def test_mariners_groups():
    """Each published group lies mostly within one of those found; sway and yaw have the same ones."""
    model = resolve("mariner-model")
    found = identifiability(model, [simulated_record("zigzag:15/15:port", 1)], NOISE, [])
    groups = [set(group.names) for group in found.groups]
    for prefix, sets in (("Y", PUBLISHED[:3]), ("N", PUBLISHED[:3]), ("X", PUBLISHED[3:])):
        for published in sets:
            names = {prefix + name for name in published}
            assert max(len(names & group) for group in groups) == len(names), (names, groups)
    alone = dict(zip((parameter.name for parameter in found.parameters), found.parameters, strict=True))
    best = {group.names: group.relative for group in found.groups}
    for names, relative in best.items():
        known = [alone[name].relative for name in names if not np.isnan(alone[name].relative)]
        assert relative < min(known), (names, relative, known)


def test_the_bound_of_a_combination():
    """Its error by the Cramer-Rao covariance, and no other combination of the group has a smaller one."""
    model, records = resolve("patrol"), [generate(Case("patrol", "sine:20deg/23s", "medium", seed=1))]
    found = identifiability(model, records, manoeuvres=[])
    _, covariance = cramer_rao(model, records, found.noise_sd)
    jacobian = model.parameters_jacobian(model.coefficients)
    public = jacobian @ covariance @ jacobian.T
    values = model.to_parameters(model.coefficients)
    assert found.groups
    for group in found.groups:
        weights = np.array([dict(group.combination).get(name, 0.0) for name in model.parameter_names])
        members = weights != 0.0

        def relative(w):
            return np.sqrt(w @ public @ w) / abs(w @ values)

        assert group.relative == pytest.approx(relative(weights), rel=1e-5)
        for k in np.flatnonzero(members):
            for nudge in (0.9, 1.1):
                assert relative(weights * np.where(np.arange(weights.size) == k, nudge, 1.0)) > group.relative


def test_the_bounds_are_those_of_cramer_rao():
    model, records = resolve("kvlcc2-l7"), [generate(Case("kvlcc2-l7", "zigzag:20/20", duration_s=100.0))]
    noise = {**NOISE, "heading_rad": 2e-3}
    sd, _ = cramer_rao(model, records, noise)
    assert [parameter.sd for parameter in identifiability(model, records, noise, []).parameters] == pytest.approx(
        sd, rel=1e-6
    )


@pytest.mark.parametrize("vessel", list_vessels())
def test_every_vessel(vessel):
    """Finite bounds from its own training records, and a candidate that lowers the median."""
    model = resolve(vessel)
    records = [generate(Case(vessel, text, "medium", seed=1)) for text in model.suite["train"][:2]]
    found = identifiability(model, records)
    assert sum(found.counts) == np.count_nonzero(model.to_parameters(model.coefficients))
    assert np.isfinite(found.median) and found.advice is not None
    assert found.advice[0].median < found.median and found.advice[1].worst < found.worst
    text = "\n".join(found.lines())
    assert all(name in text for names in found.names for name in names) and found.advice[0].manoeuvre in text


def test_the_recommended_record_gives_the_predicted_bounds():
    """Bounds with the recommended record added, with new noise, are those predicted."""
    model = resolve("patrol")
    records = [generate(Case("patrol", "sine:20deg/23s", "medium", seed=1))]
    found = identifiability(model, records)
    assert found.advice is not None
    best = found.advice[0]
    more = generate(Case("patrol", best.manoeuvre, duration_s=records[0].time_s[-1], dt_s=records[0].dt))
    sd, _ = cramer_rao(model, [*records, more], found.noise_sd)
    after = np.median(sd / np.abs(model.to_parameters(model.coefficients)))
    assert best.median == pytest.approx(after, rel=0.3)
    assert after < found.median


@pytest.mark.parametrize("vessel", ["cargo", "remus-kt", "response-1"])
def test_heading_alone(vessel):
    model = resolve(vessel)
    record = generate(Case(vessel, "zigzag:20/20", "medium", seed=1))
    both = identifiability(model, [record], manoeuvres=[])
    heading = identifiability(model, [record.with_channels(yaw_rate_rad_s=None)], manoeuvres=[])
    assert list(heading.noise_sd) == ["heading_rad"]
    assert np.all(heading.relative > both.relative)


def test_the_noise_is_estimated_from_the_records():
    quiet = generate(Case("response-1", "zigzag:20/20"))
    assert noise_of([quiet])["yaw_rate_rad_s"] == np.deg2rad(0.01)  # none is visible: the table's low level
    loud = generate(Case("response-1", "zigzag:20/20", "medium", seed=1))
    assert noise_of([loud])["yaw_rate_rad_s"] == pytest.approx(np.deg2rad(0.05), rel=0.15)


def test_refusals():
    model = resolve("response-1")
    record = generate(Case("response-1", "zigzag:20/20"))
    with pytest.raises(BadInput, match="unknown manoeuvre"):
        identifiability(model, [record], manoeuvres=["looping:20"])
    with pytest.raises(BadInput, match="noise of 'roll_rad'"):
        identifiability(model, [record], {"roll_rad": 0.1})
    with pytest.raises(CannotFit, match="none of the columns"):
        identifiability(model, [replace(record, channels={"rudder_rad": record.rudder()})], {"yaw_rate_rad_s": 1e-3})
