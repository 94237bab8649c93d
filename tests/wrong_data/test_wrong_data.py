"""Wrong data never become a hull, and nothing is invented that the records do not have.

A matrix of changes whose answer is known, on three simulated ships and two measured sets: each command tells it,
refuses the records, or is not harmed.
"""

import warnings

import pytest

import helmbench
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.measured import data_dir, load
from helmbench.models.errors import BadInput, CannotFit, FitFailed
from tests.transformations import CHANGES

MANOEUVRES = ("zigzag:20/20", "turn:25", "zigzag:10/10:port")
SHIPS = {"mariner": (200.0, 1.0), "response-1": (200.0, 1.0), "kvlcc2-l7": (120.0, 0.5)}
MEASURED = {
    "kvlcc2-hsva": ("kvlcc2-l7", ("Z_20_10_S", "Z_10_05", "Z_10_10_P"), 8),
    "esso-osaka": ("nomoto-1", ("zigzag_31-Jul-2020_13_42_53", "zigzag_31-Jul-2020_13_57_45"), 4),
}
REFUSED = (BadInput, CannotFit, FitFailed)
INVENTED = {
    "dropouts": {"derived_channel", "earth_frame_velocity", "current", "speed_scale"},
    "gap": {"derived_channel", "earth_frame_velocity", "current", "speed_scale"},
    "rows lost": {"derived_channel", "earth_frame_velocity", "current", "speed_scale"},
    "constant speed": {"derived_channel", "earth_frame_velocity", "current", "speed_scale", "splice"},
    "heading + 180": {"derived_channel", "earth_frame_velocity", "current", "speed_scale", "channel_sign"},
    "radians in all degrees": {"earth_frame_velocity", "current", "speed_scale", "heading_offset"},
}
"""Change -> what must not be told of it beyond what the unchanged records have."""
STANDING = (
    *("radians in the rudder's degrees", "radians in all degrees", "rudder late", "rudder shuffled"),
    *("rudder amidships", "rows lost", "gap", "time reversed"),
)
"""Changes that nothing can correct: they are told as doubts that stand, on every ship."""
TOLD = {
    "degrees in heading": "wrong_unit",
    "degrees in yaw rate": "wrong_unit",
    "rudder turned": "rudder_sign",
    "heading turned": "channel_sign",
    "yaw rate turned": "channel_sign",
    "outliers": "outliers",
    "halves exchanged": "splice",
}
OF_TRACK = {
    "heading + 180": "heading_zero",
    "heading + 90": "heading_zero",
    "knots": "wrong_unit",
    "velocities exchanged": "channel_swap",
    "positions exchanged": "channel_swap",
    "earth frame": "earth_frame_velocity",
    "sway turned": "channel_sign",
}


@pytest.fixture(scope="module")
def fleet():
    """Records by ship or set, made once."""
    known = {}

    def of(name):
        if name not in known:
            if name in SHIPS:
                seconds, step = SHIPS[name]
                cases = [Case(name, m, "low", seed=i, duration_s=seconds, dt_s=step) for i, m in enumerate(MANOEUVRES)]
                known[name] = [generate(case) for case in cases]
            else:
                if not (data_dir() / ("kvlcc2" if "kvlcc2" in name else "esso_osaka")).exists():
                    pytest.skip(f"{name} is not here")
                _, stems, every = MEASURED[name]
                known[name] = [load(name, stem).thinned(every) for stem in stems]
        return known[name]

    return of


def changed(records, change, rng):
    return [CHANGES[change](record, rng) for record in records]


def named(found):
    return {f.cause for f in found.findings if f.material}


@pytest.mark.parametrize("name", [*SHIPS, *MEASURED])
def test_check_tells_each_change_and_invents_nothing(name, fleet, rng):
    records = fleet(name)
    unchanged = named(helmbench.check(records))
    assert name not in SHIPS or not unchanged
    for change in CHANGES:
        found = helmbench.check(changed(records, change, rng))
        print(name, change, named(found))
        assert not (named(found) - unchanged) & INVENTED.get(change, set()), change
        if change in STANDING and not (name == "esso-osaka" and change == "rudder late"):
            assert any(f.standing for f in found.findings), change
        expected = TOLD | (OF_TRACK if name != "response-1" else {})
        if change in expected:
            assert expected[change] in named(found), change


@pytest.mark.parametrize("change", CHANGES)
def test_a_diagnosis_names_no_number_of_the_hull(change, fleet, rng):
    train = changed(fleet("response-1")[:2], change, rng)
    try:
        found = helmbench.diagnose("response-1", train)
    except REFUSED as error:
        print(error)
        return
    print(found.verdict, found.reason, found.causes)
    assert found.calibration is None or found.verdict != "named"
    assert not {f.cause for f in found.causes if f.stage != "kinematics"} - HARMLESS


HARMLESS = {"rudder_delay", "wave_motion"}
"""No numbers of a hull: an early rudder is late on its way to the ship; outliers that are left look like waves."""


@pytest.mark.filterwarnings("ignore::helmbench.datasets.rudder_sign.RudderSignWarning")
@pytest.mark.parametrize("change", ["rudder shuffled", "rudder doubled", "rudder late", "gap"])
def test_calibrate_refuses_and_validate_tells_what_stands(change, fleet, rng):
    records = changed(fleet("mariner")[:2], change, rng)
    with pytest.raises(BadInput):
        helmbench.calibrate("mariner", records)
    assert helmbench.validate("mariner", records).doubts


@pytest.mark.parametrize("change", ["rudder shuffled", "rudder late", "radians in the rudder's degrees", "gap"])
def test_identify_warns(change, fleet, rng):
    records = changed(fleet("mariner")[:2], change, rng)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        helmbench.identify(records, "nomoto-1", "ls")
    print([str(w.message) for w in told])
    assert any(issubclass(w.category, helmbench.PlausibilityWarning) for w in told)
