"""Effects injected by a simulator that shares no code with ours, and what a correct diagnosis says of them.

An expectation is a random check with the rate at which correct code passes it.  The tests draw each until it has
passed; `make rates` draws many more and compares the number of passes with the binomial bound of that rate.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.stats import binom

from helmbench.bench.faults import TAXONOMY, FaultCase, inject, kind_of, names_of
from helmbench.bench.faults.ships import ship
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.options import Options
from helmbench.models.model import resolve

SHORT = {
    "mariner": (240.0, 1.0),
    "s175": (240.0, 1.0),
    "kvlcc2-l7": (60.0, 0.2),
    "response-1": (60.0, 0.2),
    "cargo": (300.0, 1.0),
}
"""Duration and sampling of the tests' records, s."""
OFTEN = (
    *("rudder_offset", "rudder_effectiveness", "rudder_delay", "rudder_backlash", "yaw_rate_bias", "yaw_rate_scale"),
    *("current", "wind", "speed_scale", "axis_misalignment", "yaw_damping_quadratic", "heading_delay"),
)
SINGLE = {
    **{c: "mariner" for c in names_of(TAXONOMY)},
    **dict.fromkeys(("speed_loss", "second_order_lead"), "response-1"),
}
"""Cause -> the ship in which it is injected alone."""
OF_RECORDS = ("rudder_sign", "earth_frame_velocity", "channel_swap", "outliers")
"""Effects that are found before there is a filter, whatever the bank holds."""
LEVEL = 1e-3
"""Probability that correct code fails one test of a rate."""
SELDOM = 1e-6
"""The same where draws end with the first pass."""


def injected(vessel, causes, rng, strength="large", gusts="none", **facts):
    """Short records of a ship with the effects in it."""
    duration, dt = SHORT[vessel]
    return inject(FaultCase(vessel, causes, strength, gusts=gusts, duration_s=duration, dt_s=dt, **facts), rng)


def fewest(draws: int, rate: float) -> int:
    """The fewest passes of `draws` that correct code shows at this rate, but for a share LEVEL of the tests.

    Raises
    ------
    ValueError : so few draws that no outcome would fail.
    """
    least = int(binom.ppf(LEVEL, draws, rate))
    if least < 1:
        raise ValueError(f"{draws} draws at a rate of {rate} cannot fail")
    return least


def most_draws(rate: float) -> int:
    """The fewest draws that hold a pass of correct code at this rate, but for a share SELDOM of the tests."""
    return math.ceil(math.log(SELDOM) / math.log1p(-rate))


def passes(check: Callable[[], bool], rate: float) -> bool:
    """Whether a random check passes in one of `most_draws`; it is not drawn again after that.

    How often it passes is a rate, which `make rates` measures: here the seeds are fixed, so one pass says as much.
    """
    return any(check() for _ in range(most_draws(rate)))


def names(found) -> list[str]:
    """The named causes in order, without those they tie with."""
    return [f.cause for f in found.causes]


def names_and_ties(found) -> set[str]:
    """All named causes and those they cannot be told from."""
    return {name for f in found.causes for name in (f.cause, *f.tied_with)}


def _diagnosed(case, held_out=(), **options):
    found = diagnose(resolve(case.case.vessel), case.train, held_out, Options(coefficient_sd=0.0, threads=1, **options))
    print(case.truth, found.verdict, found.causes, found.reason)
    return found


def alone_in_the_bank(cause: str) -> Callable[[np.random.Generator], bool]:
    """The effect is found where the bank holds nothing else."""

    def check(rng):
        case = injected(SINGLE[cause], (cause,), rng)
        only = None if cause in OF_RECORDS else (cause,)
        return cause in names(_diagnosed(case, max_effects=1, only=only))

    return check


def shallow_water_is_no_crossflow(rng):
    """Water of six to thirty draughts' depth; others of the bank can imitate most of it."""
    bank = ("shallow_water", "crossflow_coupling", "coefficient_shift", "yaw_damping_quadratic")
    case = injected("mariner", ("shallow_water",), rng, strength="small")
    return names(_diagnosed(case, max_effects=1, only=bank)) == ["shallow_water"]


def faint_cause_in_calm_is_no_gust(rng):
    """Just detectable by the best test; small gusts would explain most of it."""
    case = injected("s175", ("yaw_damping_quadratic",), rng, strength="faint")
    return "yaw_damping_quadratic" in names_and_ties(_diagnosed(case, max_effects=1))


def limit_just_below_the_largest_command(rng):
    """Only the tops of the widest command are cut off."""
    case = injected("cargo", ("rudder_saturation",), rng, strength="faint")
    return names(_diagnosed(case, max_effects=1, only=("rudder_saturation",))) == ["rudder_saturation"]


def limit_far_below_the_rate_of_the_commands(rng):
    """Orders come in steps: how fast they change says little about how fast the rudder can turn."""
    case = injected("response-1", ("rudder_rate_limit",), rng)
    return names(_diagnosed(case, max_effects=1)) == ["rudder_rate_limit"]


def drawn_cause_comes_first(rng):
    """A drawn cause on a drawn ship is the first name, or tied with it, among the whole bank."""
    vessel = str(rng.choice(list(SHORT)))
    cause = str(rng.choice([c for c in OFTEN if kind_of(c).carried_by(ship(vessel))]))
    case = injected(vessel, (cause,), rng)
    found = _diagnosed(case, case.held_out[:1])
    return bool(found.causes) and cause in (found.causes[0].cause, *found.causes[0].tied_with)


def no_effect_is_adequate(rng):
    """A sound ship in calm, fast or slow gusts."""
    vessel = str(rng.choice(["mariner", "kvlcc2-l7", "response-1", "cargo"]))
    case = injected(vessel, (), rng, gusts=str(rng.choice(["none", "fast", "slow"])))
    return _diagnosed(case).verdict == "adequate"


def waves_are_named_alone(rng):
    """A sound ship in waves."""
    vessel = str(rng.choice(["mariner", "kvlcc2-l7", "response-1", "cargo"]))
    case = injected(vessel, ("wave_motion",), rng, strength="moderate", gusts=str(rng.choice(["none", "fast"])))
    return set(names(_diagnosed(case))) == {"wave_motion"}


def two_effects_are_named(rng):
    """A rudder offset and a yaw-rate scale in the same records."""
    both = ("rudder_offset", "yaw_rate_scale")
    return names_and_ties(_diagnosed(injected("mariner", both, rng))) >= set(both)


def every_effect_counts_where_the_response_model_is_known(rng):
    """Just detectable by the best test: too small to matter beside fitted coefficients, which are never exact."""
    vessel, cause = (str(rng.choice(of)) for of in (["response-1", "cargo"], ["rudder_offset", "speed_loss"]))
    return names(_diagnosed(injected(vessel, (cause,), rng, strength="faint"), max_effects=1)) == [cause]


def effect_outside_the_bank_is_unexplained(rng):
    """A gross effect that is described as a family of effects, but has no name in the bank."""
    kind = str(rng.choice(["harmonic", "pulse", "periodic", "sensor_ramp", "memory"]))
    return _diagnosed(injected("mariner", (kind,), rng)).verdict == "unexplained"


def heading_and_rudder_suffice(rng):
    """Heading is the only measured motion."""
    case = injected("mariner", ("rudder_effectiveness",), rng, channels=("heading_rad",))
    found = _diagnosed(case, case.held_out[:1])
    entry = next(e for e in found.bank if e.cause == "sway_offset")
    assert entry.status == "not_testable" and "sway" in entry.why
    return "rudder_effectiveness" in names_and_ties(found)


def gaps_do_not_matter(rng):
    """A tenth of the samples is missing."""
    return "yaw_rate_scale" in names_and_ties(_diagnosed(injected("mariner", ("yaw_rate_scale",), rng, gaps=0.1)))


def noise_with_a_memory_is_no_bias(rng):
    """Sensors' noise that is filtered: the scale of the yaw rate is named, if there is one, and nothing beside it."""
    vessel = str(rng.choice(["mariner", "s175", "kvlcc2-l7", "response-1"]))
    causes = ((), ("yaw_rate_scale",))[int(rng.integers(2))]
    found = _diagnosed(injected(vessel, causes, rng, noise_time_s=5.0))
    return names(found) == list(causes) and any("filtered noise" in doubt for doubt in found.doubts)


def extension_predicts_held_out_records(rng):
    """The extended model has the size that is told, near the true one, and predicts what it has not seen."""
    case = injected("mariner", ("rudder_effectiveness",), rng)
    found = _diagnosed(case, case.held_out)
    if names(found) != ["rudder_effectiveness"]:
        return False
    gain, (size,) = found.gain["heading_rad"], found.causes[0].sizes
    assert found.extended.family == "abkowitz+rudder_effectiveness"
    assert found.extended.coefficients[-1] == pytest.approx(size.value)
    assert gain.ratio_low <= gain.rmse_after / gain.rmse_before <= gain.ratio_high
    close = abs(size.value - case.truth[0]["parameters"]["e"]) < 3.0 * (size.high - size.low)
    return close and gain.rmse_after < 0.7 * gain.rmse_before


@dataclass(frozen=True)
class Expectation:
    """A random check, and the rate at which correct code passes it."""

    check: Callable[[np.random.Generator], bool]
    rate: float

    @property
    def name(self) -> str:
        """What is expected."""
        return self.check.__name__


ALONE = {cause: Expectation(alone_in_the_bank(cause), 0.9) for cause in sorted(SINGLE)}
"""Cause -> it is found where the bank holds nothing else."""
SPECIAL = (
    Expectation(shallow_water_is_no_crossflow, 0.9),
    Expectation(faint_cause_in_calm_is_no_gust, 0.9),
    Expectation(limit_just_below_the_largest_command, 0.9),
    Expectation(limit_far_below_the_rate_of_the_commands, 0.9),
    Expectation(heading_and_rudder_suffice, 0.9),
    Expectation(gaps_do_not_matter, 0.9),
    Expectation(extension_predicts_held_out_records, 0.9),
)
COMMON = (
    Expectation(drawn_cause_comes_first, 0.95),
    Expectation(no_effect_is_adequate, 0.97),
    Expectation(waves_are_named_alone, 0.9),
    Expectation(two_effects_are_named, 0.97),
    Expectation(every_effect_counts_where_the_response_model_is_known, 0.9),
    Expectation(effect_outside_the_bank_is_unexplained, 0.89),
    Expectation(noise_with_a_memory_is_no_bias, 0.85),
)
