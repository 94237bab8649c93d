"""Wrong data never become a hull, and nothing is invented that the records do not have.

A sample of the matrix that `make wrong-data` runs whole, in part drawn anew: each command tells a change, refuses the
records, or is not harmed; no number of the hull is named, and no sensor, that the unchanged records do not have.
"""

import pytest

from ...nightly_marks import nightly_but
from ...seeds import SHIFT
from .changes import CHANGES
from .commands import UNKNOWABLE, judged
from .fleet import CRAFT, SETS, SHIPS, at_hand, records_of

STANDING = (
    *("radians in the rudder's degrees", "radians in all degrees", "rudder late", "rudder early", "rudder shuffled"),
    *("rudder amidships", "gap", "time reversed", "time doubled"),
)
"""Changes that nothing can correct."""
OF_TRACK = (
    "heading + 180",
    "heading + 90",
    "velocities exchanged",
    "positions exchanged",
    "earth frame",
    "sway turned",
    "positions in feet",
)
"""Changes that positions and velocities show, and a response model's records do not have."""
HARMLESS = ("rudder doubled", "dropouts")
"""Changes that records do not show without a model of their ship."""
BY_CHANCE, DRAWS = ("dropouts", "outliers"), 7
"""Changes that are judged by most of so many draws: 4 of 400 draws of the Esso Osaka's dropouts bring a speed log that
reads .5 % low above what is told; of outliers there was none in 204 draws of the measured sets."""

DRAWN = (*BY_CHANCE, "rows lost", "rudder shuffled")


def some(changes, count, rng):
    """So many of the changes, drawn; all of a ship whose records and model cost little."""
    chosen = [str(change) for change in rng.choice(list(changes), count, replace=False)]
    print(chosen)
    return chosen


def cell(command, name, change, rng):
    """What became of a change that holds in a draw, or in most of several, which end when that is certain."""
    draws = DRAWS if change in BY_CHANCE and command == "check" else 1
    held, wrong = [], []
    while max(len(held), len(wrong)) <= draws // 2:
        found = judged(command, name, change, [CHANGES[change](record, rng) for record in records_of(name)])
        print(command, name, change, found)
        (wrong if found.hull or found.invented else held).append(found)
    assert len(held) > draws // 2
    assert held[0].outcome != "silent" or (command, change) in UNKNOWABLE
    return held[0]


@pytest.mark.parametrize("name", nightly_but([n for n in SHIPS | SETS if at_hand(n)], "response-1", "mariner"))
def test_check_tells_each_change_and_invents_nothing(name, rng):
    for change in CHANGES:
        if name == "response-1" and change in (*OF_TRACK, "knots", "constant speed"):
            continue
        assert cell("check", name, change, rng).outcome == ("harmless" if change in HARMLESS else "told"), change


@pytest.mark.parametrize("name", nightly_but([name for name in CRAFT if at_hand(name)], "vtec"))
def test_check_invents_nothing_of_a_craft_that_moves_sideways(name, rng):
    """Changes without a draw: what a draw leaves of a short record may cross the size from which a finding matters."""
    for change in some((c for c in CHANGES if c not in DRAWN), 8 if SHIFT else 4, rng):
        found = judged("check", name, change, [CHANGES[change](record, rng) for record in records_of(name)])
        print(name, change, found)
        assert not found.invented


@pytest.mark.parametrize("name", [name for name in CRAFT if at_hand(name)])
def test_radians_in_all_degrees_are_told_of_a_craft_that_moves_sideways(name, rng):
    change = CHANGES["radians in all degrees"]
    assert judged("check", name, "radians in all degrees", [change(r, rng) for r in records_of(name)]).outcome == "told"


@pytest.mark.parametrize("command", nightly_but(["validate", "identify"], "validate"))
@pytest.mark.parametrize("name", nightly_but(SHIPS, "response-1"))
def test_validate_and_identify_tell_what_harms_them(command, name, rng):
    for change in CHANGES if name == "response-1" else some(CHANGES, 10, rng):
        found = cell(command, name, change, rng)
        assert change not in STANDING or found.outcome in ("told", "refused")


@pytest.mark.parametrize("name", nightly_but(["mariner", "kvlcc2-l7"]))
def test_calibrate_refuses_what_stands(name, rng):
    for change in some((*STANDING, "rudder doubled", "constant speed", "outliers"), 5, rng):
        found = cell("calibrate", name, change, rng)
        assert change == "outliers" or found.outcome == "refused"


@pytest.mark.nightly
def test_a_diagnosis_names_no_number_of_the_hull(rng):
    for change in some(CHANGES, 12, rng):
        found = cell("diagnose", "response-1", change, rng)
        assert change not in STANDING or found.outcome in ("told", "refused")
