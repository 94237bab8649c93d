"""What an identification says: whether to believe the model, its parameters, residuals, what the records tell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ...datasets.display import shown_name, shown_unit
from ...estimation.estimates.assessment import APPROXIMATES, EXPLAINS, FAILS, POOR
from ...estimation.likelihood.output_error import ADEQUATE
from ..diagnosis.words import in_line, size
from ..numbers import SHORT, interval, interval_digits, is_missing, number, r_squared
from ..page import BAD, FAIR, GOOD, Drawing, Items, Note, Overlays, Section, Verdict, items, overlays, result_page
from ..plots import COLOURS, SOFT, svg
from ..runs import WIDTH, of_validation
from ..tables import Column, Table, field, make_table, numeric
from ..validation.page import free_table, horizon_table, left_out_table, trusted_lines
from .comparison import comparison_note, comparison_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...estimation.estimates.assessment import Assessment, ParameterTold
    from ...estimation.estimates.correlation import ChannelResiduals, Correlation
    from ...estimation.validation.result import Validation
    from ..page import Page

BIASES = {"rudder_offset": "a neutral rudder angle of", "yaw_rate_bias": "a yaw rate bias of"}
"""Bias -> how its size is told."""
CHANGED, MOST_CHANGED = 0.01, 4
"""Least relative change of a parameter that is told beside a bias, and how many are."""
GROWS = 2.0
"""Factor between errors on held-out and on training records that is told."""


TONES = {EXPLAINS: GOOD, APPROXIMATES: FAIR, FAILS: BAD}
TITLES = ("Measured and simulated", "The model", "What remains", "What to sail next")
RUNS = (
    "The model is simulated with the recorded rudder and revolutions from the state that the record itself, smoothed, "
    "has at its first sample, and anew behind a long gap. R² = 1 − SSE/SST, about each run's mean; together: mean over "
    "heading, yaw rate, surge and sway."
)
RESIDUALS = (
    "Measured − simulated, each run from the initial state that fits it best (a black box from the first sample). "
    "Sensor noise: from third differences of the records. With the right equations the residuals are the sensors' "
    "noise: 99 % of the coefficients lie inside the dashed band. Coefficients outside with the rudder: the equations "
    "lack something that the rudder does. Outside in time only: a disturbance, or a sensor whose noise is not white."
)
PARAMETERS = (
    "Interval: from the standard error or, where the method gives it, by profile likelihood. Smallest possible: "
    "relative standard deviation that these records allow any unbiased method (Cramér-Rao). Published values are those "
    "of the vessels that ship with helmbench, in their own rudder sign; those with a unit depend on size and speed of "
    "the ship."
)
NEXT = (
    "Each manoeuvre is simulated with the model for as long as the longest record and added to the records. "
    "Information: half the growth of the log determinant (D-optimality) of all parameters together, each known within "
    "100 % before."
)


def page(assessment: Assessment) -> Page:
    """The page of an identification."""
    tested = (
        "nothing" if assessment.held_out is None else ", ".join(record.name for record in assessment.held_out.records)
    )
    judged = "training" if assessment.held_out is None else "held-out"
    runs = of_validation(assessment.held_out, "held_out") if assessment.held_out is not None else []
    first, each = overlays([*runs, *of_validation(assessment.train, "train")])
    trained = ", ".join(record.name for record in assessment.train.records)
    state = "" if assessment.estimate.converged else "; not converged"
    compared = assessment.comparison
    candidates = assessment.identifiability.candidates if assessment.identifiability else ()
    return result_page(
        f"{assessment.name} from {trained}",
        f"{tested} held out{state}",
        Verdict(TONES[assessment.verdict], headline(assessment), tuple(statement(assessment))),
        seen=[
            first,
            replace(free_table(assessment.judged), title=f"Free runs of {judged} records"),
            left_out_table(assessment.judged),
        ],
        changed=[
            assessed_table(assessment) if assessment.parameters else "A black box has no parameters.",
            comparison_table(compared, "Compared with others", comparison_note(compared)) if compared else None,
        ],
        remains=[residual_table(assessment), items([f"{line}." for line in trusted_lines(assessment.judged)])],
        following=[items(next_lines(assessment))],
        details=[
            Section(
                "Errors ahead", (horizon_table(assessment.judged), f"Times ahead: {assessment.judged.horizon_basis}.")
            ),
            *_of_training(assessment),
            Section("Correlation of the residuals", (*residual_drawings(assessment), Note(RESIDUALS))),
            Section("What the records tell of the parameters", _told(assessment)),
            Section("Every manoeuvre that was tried", (make_table(CANDIDATES, candidates), Note(NEXT))),
            *_compared(assessment, judged),
            each,
            Section("How to read it", (items([RUNS, PARAMETERS]),)),
        ],
        titles=TITLES,
    )


def _of_training(assessment: Assessment) -> list[Section]:
    """Errors of training records, where others judge the model."""
    if assessment.held_out is None:
        return []
    return [Section("Free runs of training records", (free_table(assessment.train), left_out_table(assessment.train)))]


def _told(assessment: Assessment) -> tuple[Table | Items | Note, ...]:
    told = assessment.identifiability
    if told is None:
        return ()
    noise = ", ".join(f"{shown_name(channel)} ({sd:.2g})" for channel, sd in told.noise_sd.items())
    note = (
        f"Cramér-Rao bounds of the free run at the estimate, for white noise on {noise}, with unknown initial states."
    )
    if assessment.verdict != EXPLAINS:
        note += " They count the sensors' noise alone: the model does not explain the records, true errors are larger."
    return make_table(TOLD, told.parameters), items(told.group_lines()), Note(note)


def _compared(assessment: Assessment, judged: str) -> list[Section]:
    """Runs of the candidates side by side; nothing where none were compared."""
    if assessment.compared is None:
        return []
    runs = tuple(of_validation(assessment.compared))
    title = f"Free runs along the {judged} records, each fitted to all training records"
    return [Section(title, (Overlays(runs),))]


def headline(assessment: Assessment) -> str:
    """The verdict in one sentence, which names the model where it was chosen from several."""
    chosen = _chosen(assessment)
    if assessment.verdict == FAILS:
        model = f"this model{f': it is {chosen}' if chosen else ''}"
        far = (
            f" further ahead than {assessment.trusted_s:.3g} s"
            if assessment.trusted_s > 0.0 and not assessment.diverged
            else ""
        )
        return f"Do not predict{far} with {model}."
    model = f"{chosen[0].upper()}{chosen[1:]}," if chosen else "The model"
    told = (
        "explains the records"
        if assessment.verdict == EXPLAINS
        else "approximates the records, it does not explain them"
    )
    return f"{model} {told}."


def _chosen(assessment: Assessment) -> str:
    """The name of a model that was chosen from several, and from how many; '' where it was not."""
    compared, own = assessment.comparison, (assessment.estimate.model.id, assessment.estimate.method)
    if compared is None:
        return ""
    tried = {(one.model.id, one.method) for one in compared.candidates if one.squares} | {own}
    beaten = [(one.model.id, one.method) for one in compared.candidates if one is not compared.chosen]
    return "" if own in beaten or len(tried) < 2 else f"the best of {len(tried)} models, {assessment.name}"


def statement(assessment: Assessment) -> list[str]:
    """Why, and what else the reader must know, in sentences."""
    lines = [
        _misfit(assessment),
        *_reach(assessment),
        *_held_out(assessment),
        *_correlated(assessment),
        *_biases(assessment),
    ]
    lines += _undetermined(assessment)
    lines += [f"{assessment.estimate.method}: {assessment.estimate.message}."] if assessment.estimate.message else []
    return [line for line in (*lines, *assessment.doubts) if line]


def _misfit(assessment: Assessment) -> str:
    if assessment.diverged:
        return f"Its free run diverges along {in_line(list(dict.fromkeys(assessment.diverged)))}."
    train = _together(assessment.train)
    told = f"Free runs of the training records have R² {train}."
    if assessment.held_out is not None:
        told = f"Free runs have R² {_together(assessment.held_out)} on held-out, {train} on training records."
    if assessment.exceeding:
        sizes = ", ".join(_size(one) for one in _worst(assessment.exceeding))
        return f"{told} Their residuals exceed the sensors' noise: {sizes}."
    if not assessment.train_residuals:
        return told
    largest = max((*assessment.train_residuals, *assessment.held_out_residuals), key=lambda one: one.ratio)
    name, ratio = shown_name(largest.channel), number(largest.ratio, 2)
    limit = f"; up to {ADEQUATE:g} times counts as explained" if assessment.verdict == EXPLAINS else ""
    size = f"residuals are at most {ratio} times the sensors' noise ({name}{limit})."
    return f"{told} {'Their' if assessment.r2 >= POOR else 'From the starts that fit best, their'} {size}"


def _reach(assessment: Assessment) -> list[str]:
    """How far a model predicts whose errors along whole records are large."""
    if assessment.verdict == FAILS or assessment.r2 >= POOR:
        return []
    return [
        f"Predict no further ahead than {assessment.trusted_s:.3g} s: along whole records its errors grow too large."
    ]


def _biases(assessment: Assessment) -> list[str]:
    """A neutral rudder angle or a yaw rate bias that would lower the errors, and what it changes."""
    biases = assessment.biases
    if biases is None:
        return []
    sizes = in_line([size(replace(one, parameter=BIASES[one.parameter])) for one in biases.sizes])
    errors = []
    for channel in (c for c in biases.before if c in biases.after):
        unit, factor = shown_unit(channel)
        before, after = (number(factor * side[channel]) for side in (biases.before, biases.after))
        errors.append(f"the free-run error of the {shown_name(channel)} from {before} to {after} {unit}")
    old, new = assessment.estimate.parameters, biases.parameters
    moved = {n: abs(new[n] - x) / abs(x) for n, x in old.items() if n in new and x != 0.0}
    most = sorted((n for n, share in moved.items() if share > CHANGED), key=lambda n: -moved[n])[:MOST_CHANGED]
    changes = [f"{n} from {number(old[n])} to {number(new[n])}" for n in old if n in most]
    told = f"{sizes[0].upper()}{sizes[1:]} would take {in_line([*errors, *changes])}."
    return [f"{told} The identified numbers are without it."]


def _together(validation: Validation) -> str:
    """R^2 of all channels together."""
    score = validation.score(None)
    return r_squared(np.nan if score is None else score.r2)


def _worst(found: Sequence[ChannelResiduals]) -> list[ChannelResiduals]:
    """The largest residual of every channel."""
    worst: dict[str, ChannelResiduals] = {}
    for one in found:
        if one.channel not in worst or one.ratio > worst[one.channel].ratio:
            worst[one.channel] = one
    return list(worst.values())


def _size(one: ChannelResiduals) -> str:
    unit, factor = shown_unit(one.channel)
    return f"{shown_name(one.channel)} {number(factor * one.rms)} {unit} ({number(one.ratio, 2)} times)"


def _held_out(assessment: Assessment) -> list[str]:
    if assessment.held_out is None:
        return ["No record was held out: nothing shows how the model predicts other runs."]
    grown = []
    for channel in dict.fromkeys(score.channel for score in assessment.held_out.scores if score.channel):
        here, there = assessment.held_out.score(channel), assessment.train.score(channel)
        if here is not None and there is not None and not assessment.diverged and here.rmse > GROWS * there.rmse > 0.0:
            grown.append(f"{shown_name(channel)} {number(here.rmse / there.rmse, 2)} times")
    lines = [f"Errors on held-out records are larger than on training records: {', '.join(grown)}."] if grown else []
    if (
        assessment.comparison is not None
        and assessment.comparison.basis == "held out"
        and len(assessment.comparison.candidates) > 1
    ):
        lines.append("The held-out records also compared the candidates: their errors are no independent test.")
    return lines


def _correlated(assessment: Assessment) -> list[str]:
    lines = []
    if assessment.rudder_left:
        names = in_line([shown_name(channel) for channel in assessment.rudder_left])
        lines.append(f"Residuals of {names} depend on the rudder: the equations lack something that the rudder does.")
    if assessment.correlated:
        names = in_line([shown_name(channel) for channel in assessment.correlated])
        lines.append(f"Residuals of {names} are correlated in time: standard errors and intervals are too small.")
    return lines


def _undetermined(assessment: Assessment) -> list[str]:
    if assessment.identifiability is None:
        return (
            [f"What the records tell of the parameters is not known: {assessment.not_told}."]
            if assessment.not_told
            else []
        )
    poor = assessment.identifiability.names[2]
    total = len(assessment.parameters)
    lines = [f"The records do not determine {len(poor)} of {total} parameters: {in_line(poor)}."] if poor else []
    return lines + [
        f"{in_line(group.names)} are known well only in combination: {group.known}."
        for group in assessment.identifiability.combinations
    ]


def next_lines(assessment: Assessment) -> list[str]:
    """What to sail next, where the records leave something open."""
    told = assessment.identifiability
    if told is None or not told.candidates:
        return []
    best = told.candidates[0]
    gain = f"of the parameters, in the median, {share(best.median)} instead of {share(told.median)}"
    return [f"Most useful next manoeuvre: {best.manoeuvre}. With it the smallest possible standard deviation {gain}."]


# ---- Charts of residuals: correlation coefficients by lag inside their 99 % band.

HEIGHT = 2.6
SIDES = {"training": COLOURS[0], "held out": COLOURS[1]}
"""Records -> colour of their coefficients."""


def residual_drawings(assessment: Assessment) -> list[Drawing]:
    """Of every channel the correlation of its residuals in time, and with the rudder."""
    sides = {"training": assessment.train_residuals, "held out": assessment.held_out_residuals}
    channels = dict.fromkeys(one.channel for own in sides.values() for one in own)
    out = []
    for channel in channels:
        own = {side: one for side, group in sides.items() for one in group if one.channel == channel}
        in_time = {side: one.in_time for side, one in own.items()}
        with_rudder = {side: one.with_rudder for side, one in own.items()}
        for other, coefficients in (("itself", in_time), ("the rudder", with_rudder)):
            caption = f"{shown_name(channel)}: residual with {other}, so long before"
            file = f"{channel}-{other.rpartition(' ')[2]}"
            out.append(Drawing(file, caption, partial(correlation_chart, coefficients)))
    return out


def correlation_chart(found: dict[str, Correlation]) -> str:
    """An SVG file of coefficients over the lag in s, beside each other, each in its band."""

    def draw(figure) -> None:
        axes: Axes = figure.subplots()
        for place, (side, one) in enumerate(found.items()):
            step = one.lag_s[1] - one.lag_s[0] if one.lag_s.size > 1 else 1.0
            at = one.lag_s + 0.25 * step * place
            axes.vlines(at, 0.0, one.values, color=SIDES[side], linewidth=1.2, label=side)
            axes.plot(at, one.values, "o", color=SIDES[side], markersize=2.5)
            for edge in (-one.band, one.band):
                axes.axhline(edge, color=SIDES[side], linewidth=0.8, linestyle=(0, (4, 2)))
        axes.axhline(0.0, color=SOFT, linewidth=0.7)
        axes.set(xlabel="lag, s", ylabel="correlation", ylim=_limits(found))
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.97), ncols=len(found))

    return svg(draw, (WIDTH, HEIGHT))


def _limits(found: dict[str, Correlation]) -> tuple[float, float]:
    largest = max(max(one.band, float(abs(one.values).max())) for one in found.values())
    edge = min(1.15 * largest, 1.05)
    return -edge, edge


# ---- Tables: parameters, residuals, what the records tell, what to sail next.

DIGITS = 5
SHOWN = 4
"""Published values that are listed one by one; of more the range is shown."""


def standard_error(value: float) -> str:
    """`+- 0.012`; a parameter is fixed where it is 0, not identified where it is infinite, and nan means unknown."""
    if math.isinf(value):
        return "not identified"
    return "" if math.isnan(value) else f"+- {number(value, 2)}" if value else "fixed"


def profile_interval(profile: Mapping[str, Any]) -> str:
    """A profile-likelihood interval; a round bracket marks an open-ended interval."""
    left, right = ("(" if profile["low_open"] else "["), (")" if profile["high_open"] else "]")
    return f"{left}{number(profile['low'], DIGITS)}, {number(profile['high'], DIGITS)}{right}"


def assessed_table(assessment: Assessment) -> Table:
    """Every parameter with its interval, what the records allow at best, and published values."""
    profiles = assessment.estimate.extra.get("profile", {})
    columns = [
        field("name", "parameter"),
        Column(
            "estimate, 95 % interval", lambda one: _with_interval(one, profiles.get(one.name)), lambda one: one.value
        ),
        field("unit"),
        Column("standard error", lambda one: standard_error(one.stderr)),
        numeric("smallest possible sd", "bound", share),
        Column("published for ships of the kind", _published),
    ]
    return make_table(columns, assessment.parameters)


def _with_interval(one: ParameterTold, profile: Mapping[str, Any] | None) -> str:
    if profile is not None:
        return f"{number(one.value, DIGITS)} {profile_interval(profile)}"
    if is_missing(one.low) or math.isinf(one.low) or one.low == one.high:
        return number(one.value, DIGITS)
    digits = interval_digits(one.value, one.low, one.high)
    return interval(one.value, one.low, one.high, lambda value: number(value, digits))


def share(bound: float) -> str:
    """A relative standard deviation in percent."""
    if is_missing(bound):
        return number(math.nan)
    return "not determined" if bound > 1e2 else f"{number(100.0 * bound, 2)} %"


def _published(one: ParameterTold) -> str:
    values = one.published
    if len(values) <= SHOWN:
        return ", ".join(f"{vessel} {number(value, 4)}" for vessel, value in values.items())
    low, high = (number(pick(values.values()), 4) for pick in (min, max))
    return f"{low} to {high} ({len(values)} vessels)"


def residual_table(assessment: Assessment) -> Table:
    """Residuals of free runs: a row a channel of each side."""
    rows = [("training", one) for one in assessment.train_residuals]
    rows += [("held out", one) for one in assessment.held_out_residuals]
    columns = [
        Column("records", lambda row: row[0]),
        Column("channel", lambda row: shown_name(row[1].channel)),
        Column("unit", lambda row: shown_unit(row[1].channel)[0]),
        numeric("residual, RMS", lambda row: _shown(row[1], row[1].rms)),
        Column("sensor noise", lambda row: number(_shown(row[1], row[1].noise_sd))),
        numeric("ratio", lambda row: row[1].ratio, SHORT),
        Column("lags outside 99 %, in time", lambda row: _outside(row[1].in_time)),
        Column("lags outside 99 %, with the rudder", lambda row: _outside(row[1].with_rudder)),
    ]
    return make_table(columns, rows)


def _shown(one: ChannelResiduals, value: float) -> float:
    return shown_unit(one.channel)[1] * value


def _outside(one: Correlation) -> str:
    return f"{one.outside} of {one.values.size}"


TOLD = (
    field("name", "parameter"),
    numeric("value", "value", partial(number, digits=DIGITS)),
    field("unit"),
    numeric("smallest relative standard deviation", "relative", share),
)
CANDIDATES = (
    field("manoeuvre"),
    numeric("information, nats", "information", SHORT),
    numeric("median bound after it", "median", share),
    numeric("worst bound after it", "worst", share),
)
