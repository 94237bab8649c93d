"""Paper 004: reference numbers, cancellation, the sea, the unknown ship, and that the claims name what is computed."""

import numpy as np
import pytest

from helmbench.models.model import resolve
from helmbench.reproduction.claims import files
from helmbench.reproduction.claims.claim import Claim, Tolerance
from helmbench.reproduction.papers.paper_004 import records, studies
from helmbench.reproduction.papers.study import studies_of
from helmbench.reproduction.verdicts import judge, spread, within

from .named import drawn, run, unnamed

FEW = (30, 210)


@pytest.fixture(scope="module")
def results():
    """Every study once; of the seas that are compared two directions instead of twelve."""
    found = {name: run("004", name) for name in studies_of("004") if name not in ("comparison", "omega")}
    patch = pytest.MonkeyPatch()
    patch.setattr(studies, "DIRECTIONS", FEW)
    found |= {name: run("004", name) for name in ("comparison", "omega")}
    patch.undo()
    return found


@pytest.mark.nightly
def test_claims_name_what_is_computed(results):
    assert unnamed("004", results) == []


@pytest.mark.nightly
def test_reachable_numbers_are_reached(results):
    """What does not depend on the draw of the sea, and the sea's twelve directions."""
    studied = ("particulars", "condition", "sea")
    checks = [check for check in files.load("004").checks() if check.study in studied]
    missed = [c.id for c in checks if not within(c, spread([results[c.study].values[c.key]]))]
    assert missed == [] and len(checks) > 10


def test_table_2_is_complete():
    names = set(resolve("s175").parameter_names) - {"CP", "CRu", "CRv", "CRr"}
    assert set(studies.printed_coefficients()) == names and len(names) == 32


@pytest.mark.nightly
def test_nonlinear_innovations_change_nothing_under_mean_forces(results):
    values = results["comparison"].values
    assert values["forces_nmi_mi_gap"] < 1e-4
    assert values["forces_ratio"] == pytest.approx(1.0, abs=1e-3)


def test_the_stand_in_has_the_ship_s_inertia():
    """Accelerations per force: (m + m_x) in SI is the same in both prime systems."""
    ship, structure = resolve("kvlcc2-l7"), records.stand_in()
    c = dict(zip(ship.constant_names, ship.constants, strict=True))
    s = dict(zip(structure.constant_names, structure.constants, strict=True))
    own = c["rho"] * c["nabla"] + c["m_x"] * 0.5 * c["rho"] * c["L"] ** 2 * c["d"]
    assert (s["m"] + s["m_x"]) * 0.5 * c["rho"] * c["L"] ** 3 == pytest.approx(own, rel=1e-12)
    own = c["I_zz"] + c["J_z"] * 0.5 * c["rho"] * c["L"] ** 4 * c["d"]
    assert (s["I_z"] + s["J_z"]) * 0.5 * c["rho"] * c["L"] ** 5 == pytest.approx(own, rel=1e-12)
    assert not structure.known


def test_a_rough_run_differs_by_its_sea_and_repeats(seed):
    ship = resolve("s175")
    runs = [records.rough(ship, "zigzag:20/20", 40.0, np.random.default_rng(seed + i // 2)) for i in range(3)]
    heading = [run.column("heading_rad") for run in runs]
    assert np.array_equal(heading[0], heading[1]) and np.abs(heading[0] - heading[2]).max() > 1e-4
    swell = records.rough(ship, "zigzag:20/20", 40.0, np.random.default_rng(seed), swell=True)
    assert np.std(np.diff(swell.column("yaw_rate_rad_s"))) > 3.0 * np.std(np.diff(runs[0].column("yaw_rate_rad_s")))


@pytest.mark.parametrize(
    ("nonzero", "found", "verdict"),
    [
        (True, [-3.0, 1.0, 5.0, 2.0], "consistent, not determined"),
        (False, [-3.0, 1.0, 5.0, 2.0], "reproduced"),
        (True, [2.0, 2.1, 1.9, 2.0], "reproduced"),
        (True, [-2.0, -2.1, -1.9, -2.0], "contradicted"),
    ],
)
def test_a_coefficient_counts_only_where_its_sign_is_settled(nonzero, found, verdict):
    claim = Claim(
        id="c",
        kind="result",
        stated=True,
        widest=100.0,
        item="Table 2",
        quantity="c",
        published=2.0,
        tolerance=Tolerance(relative=0.05),
        study="s",
        corrected="k",
        nonzero=nonzero,
    )
    assert judge(claim, {"k": spread(found)}).verdict == verdict


@pytest.mark.nightly
def test_figures(results):
    sizes = drawn("004", results)
    assert len(sizes) == 4 and max(sizes.values()) < 150_000
