"""Sentences and facts of a diagnosis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

from ...checks.columns import ChannelSwap, RudderSign
from ...checks.result import Size
from ...datasets.columns import CANONICAL
from ...datasets.display import IN_DEGREES, shown_name, shown_unit
from ...diagnosis.causes.base_coefficients import BaseCoefficients
from ...diagnosis.causes.registry import causes
from ...diagnosis.causes.steering_gear import RudderOffset
from ...diagnosis.causes.surroundings import Current
from ...diagnosis.gain.guard import WORSE
from ...diagnosis.report.bank import BY_CHANNELS, is_of_record
from ...diagnosis.result import BESIDE, CHANGE
from ...estimation.validation.validate import label
from ..numbers import DEG, interval_digits, number, p_value, percent, with_unit
from ..validation.page import share_explained

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...diagnosis.result import Curve, Diagnosis, Entry, Finding, RemainingForce
    from ...models.model import Model

SHARES = ("e", "s", "share", "fraction", "change")
"""Parameters without unit that are given in per cent."""
HEADLINED = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m", "position_m")
"""Channels of which the first one that changes is told in the headline."""
FACTORS = {"thrust_scale": "thrust"}
"""Parameters of extensions that are changes of a factor, and what they change."""
LABELS = {**FACTORS, "heading_rms": "rms heading", "period": "period of encounter"}
"""Numbers whose names are not those of a formula -> what they are called."""
NAMES = {BaseCoefficients.id: "the model's own numbers"}
"""Causes whose ids are no words that a reader knows."""
MOST_PERCENT = 1000.0
"""Change, %, from which both values are told in its place."""
TOO_SMALL = 0.02
"""Relative change of an error below which it is told as it was."""
SYMBOLS = ("x", "delta0", "tau", "b", "s", "e", "k", "angle", "rate", "limit", "fraction", "share")
"""Names of numbers that say no more than their cause does, where it has one number alone."""
MOVED = 5
"""Numbers of a joint fit that are told with their changes."""
SHOWN = 3
"""Sizes of a cause that are told in a sentence."""
AGREES = 0.95
"""R² of heading and yaw rate of held-out records from which a simulation agrees with records."""
NEXT_TO_NOTHING = 0.02
"""Share of the largest size of all records up to which that of another record is not told in a sentence."""
USEFUL = 0.5
"""Share of the yaw rate from which a simulation whose errors no cause explains is told to be of use."""
LONGEST = 25
"""Words that a headline may have."""
ENDINGS = {
    "late": "with delay",
    "now": "at once",
    "first": "at the start",
    "drift": "growing by",
    "growth": "growing by",
    "size": "steady part",
    "cos": "with the cosine of the heading",
    "sin": "with its sine",
}
"""Ends of the names of numbers of forces and drifts -> what the number is."""
STATUS_ORDER = ("named", "tied", "explained_by", "not_significant", "not_testable")


def channel(name: str) -> tuple[str, str, float]:
    """Name, unit and factor with which a channel is shown."""
    if name in CANONICAL:
        return shown_name(name), *shown_unit(name)
    return ("position", "m", 1.0) if name == "position_m" else (name, "", 1.0)


def size(item: Size) -> str:
    """`delta0 0.31 deg [0.28, 0.34]`, in degrees or per cent where that is usual; `+- 0.07 %` of a narrow interval."""
    return f"{label_of(item)} {_in_record(item)}"


def value_and_interval(item: Size) -> tuple[str, str]:
    """`0.31 deg` and `[0.28, 0.34]`."""
    factor, unit = scale(item)
    value, low, high = (factor * x for x in (item.value, item.low, item.high))
    digits = interval_digits(value, low, high, most=3)
    middle, ends = with_unit(value, unit, digits), (number(low, digits), number(high, digits))
    if ends[0] == ends[1] and low < high:  # three digits do not show so narrow an interval
        of_value = f"{number(50.0 * (high - low) / max(abs(value), 1e-300), 1)} %"
        return middle, f"+- {with_unit(0.5 * (high - low), unit, 1) if unit == 'deg' else of_value}"
    return middle, f"[{ends[0]}, {ends[1]}]"


def label_of(item: Size) -> str:
    """What a number is called."""
    if item.parameter.startswith(CHANGE):
        return f"change of {item.parameter.removeprefix(CHANGE).partition(' ')[0]}"
    return LABELS.get(item.parameter, item.parameter)


def scale(item: Size) -> tuple[float, str]:
    """Factor and unit in which a size is shown."""
    if item.unit in IN_DEGREES:
        return DEG, IN_DEGREES[item.unit]
    if item.unit.endswith("/rad"):
        return 1.0 / DEG, f"{item.unit.removesuffix('rad')}deg"
    if item.unit.startswith("rad/"):
        return DEG, f"deg{item.unit.removeprefix('rad')}"
    if item.unit in ("1", "fraction") and item.parameter.partition(":")[0] in (*SHARES, *FACTORS):
        return 100.0, "%"
    return 1.0, "" if item.unit == "1" else item.unit


def cause(name: str) -> str:
    """The id of a cause as words: `rudder offset`."""
    return NAMES.get(name, name.replace("_", " "))


def said(text: str) -> str:
    """A sentence of a diagnosis, with the ids of causes as words."""
    for name in causes():
        text = text.replace(name, cause(name))
    return text


def sentence(text: str) -> str:
    """The same with a capital and a full stop."""
    text = said(text)
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".") if text else ""


def tie(finding: Finding, sizes: Sequence[str] = (), between: str = "; ") -> str:
    """The cause with the columns that it is of, or the groups of the model's own numbers, the few records that have
    it, with its sizes, and with causes that the records cannot distinguish from it."""
    groups, columns = _wrong_groups([finding]), finding.details.get("columns", ())
    columns = columns or (finding.details.get("channels", ()) if finding.cause == ChannelSwap.id else ())
    rivals = [*map(cause, finding.tied_with), *_groups_as_good(finding)]
    other = "other values of " if finding.tied_with else ""
    of_own = finding.cause == BaseCoefficients.id and groups
    first = f"{other}{in_line(groups)}" if of_own else cause(finding.cause)
    titles = [title for name in columns if not first.startswith(title := channel(name)[0])]
    first += f" of {in_line(titles)}" if titles else ""
    where = f" in {in_line(records)}" if (records := finding.details.get("records")) else ""
    own = [one.removesuffix(where) for one in sizes]
    first += f"{where} ({between.join(own)})" if own else where
    mostly = "mostly " if BESIDE in finding.details else ""
    return f"{mostly}{'either ' if rivals else ''}{' or '.join([first, *rivals])}"


def _groups_as_good(finding: Finding) -> list[str]:
    """Groups of the model's own numbers that would do as well as others of these, in words."""
    titles = finding.details.get("would do as well", ()) if finding.cause == BaseCoefficients.id else ()
    return [title.partition(" (")[0] for title in titles]


def detail(value: object) -> str:
    """A detail of a finding: a number with three digits, parts of a list or of a table one after the other."""
    if isinstance(value, Mapping):
        return ", ".join(f"{said(str(key))} {detail(part)}" for key, part in value.items())
    if isinstance(value, list | tuple):
        return "; ".join(map(detail, value))
    return number(value) if isinstance(value, float) else said(str(value))


def headline(diagnosis: Diagnosis) -> str:
    """The verdict in at most LONGEST words: what is named, with its size where there is room, and what including it
    does to the heading (or the next known channel) of held-out records; the heading with each record's own neutral
    angle and start, which are not the model's, unless one neutral angle of all records is what is named."""
    alone = {
        "adequate": f"the simulation agrees with {_alike(diagnosis)}{_but_for(diagnosis)}{_held_out(diagnosis)}",
        "inconclusive": "the records do not allow a conclusion",
        "unexplained": f"{_corrected(diagnosis)}{_unexplained(diagnosis)}",
    }
    told = f"{cause(diagnosis.verdict).capitalize()}: "
    if diagnosis.verdict == "described":
        first = diagnosis.remaining[0]
        known = "" if first.of_sensor else ", of no known cause"
        few = [item for item in _not_zero(first.sizes) if len({size.parameter for size in first.sizes}) == 1][:SHOWN]
        sizes = [f"{value_and_interval(s)[0]}{_where(s)}" for s in few]
        size_said = f" ({', '.join(sizes)})" if sizes else _in_some(first.sizes)
        return f"{told}{first.text.partition(';')[0]}{size_said}{known}{_ending(diagnosis)}"
    if diagnosis.verdict in alone or not diagnosis.causes:
        return f"{told}{alone.get(diagnosis.verdict, 'a part of the error is explained')}."
    of_records, of_model = by_subject(diagnosis)
    columns = [f for f in of_records if f.details.get("columns")]
    rest = [*of_model, *(f for f in of_records if f not in columns)]
    named = [*columns, *sorted(rest, key=lambda f: bool(f.tied_with))]
    ending = _ending(diagnosis) if of_model else _otherwise(diagnosis)
    for count in range(len(named), 0, -1):
        more = [f"{len(named) - count} more"] if count < len(named) else []
        for name_of in (partial(_with_size, diagnosis.model), tie, _first_of_tie, _first_word):
            line = f"{told}{in_line([*map(name_of, named[:count]), *more])}{ending}"
            if len(line.split()) <= LONGEST:
                return line
    return f"{told}{in_line([_first_word(named[0]), *more])}{ending}"


def _otherwise(diagnosis: Diagnosis) -> str:
    """That the simulation agrees with the records where they are right; or by how much it errs along held-out ones."""
    if all(diagnosis.gain[name].r2_after >= AGREES for name in HEADLINED[:2] if name in diagnosis.gain):
        return "; otherwise the simulation agrees with the records."
    return f"; no cause is told of what remains{_held_out(diagnosis)}."


def _first_of_tie(finding: Finding) -> str:
    """A cause, or groups of the model's own numbers, and how many others would do as well."""
    count = len(finding.tied_with) + len(_groups_as_good(finding))
    first = in_line(_wrong_groups([finding])) or cause(finding.cause)
    return f"{first} or {count} other{'s' if count > 1 else ''}" if count else first


def _first_word(finding: Finding) -> str:
    """A cause, or the first group of the model's own numbers in short; and that others would do as well."""
    groups = _wrong_groups([finding])
    first = groups[0].partition(",")[0] if groups else cause(finding.cause)
    return f"{first} or others" if finding.tied_with or _groups_as_good(finding) else first


def _with_size(model: Model, finding: Finding, interval: bool = False) -> str:
    """A cause with its first sizes, with their intervals or without: `rudder offset (-2.51 deg in B)`."""
    if finding.cause == BaseCoefficients.id:
        sizes = [_changed(model, item, interval) for item in finding.sizes[:SHOWN]]
    else:
        few = telling(finding)[:SHOWN]
        values = ((item, value_and_interval(item)) for item in few)
        sizes = [f"{_name_in(finding, i)}{' '.join(v[: 1 + interval])}{_where(i)}" for i, v in values]
    return tie(finding, sizes, ", ")


def _name_in(finding: Finding, item: Size) -> str:
    """The name of a number with a blank behind it; empty where it says no more than its cause."""
    alone = len({size.parameter for size in finding.sizes}) == 1 and item.parameter in (*SYMBOLS, finding.cause)
    return "" if alone or item.parameter.startswith(CHANGE) else f"{label_of(item)} "


def telling(finding: Finding) -> Sequence[Size]:
    """The sizes that hold for all records; of a finding that each record has of its own, or whose mean may be zero,
    those of records that are not, nor next to nothing beside the largest."""
    of_all, of_records = ([x for x in finding.sizes if (x.record is None) == every] for every in (True, False))
    own = [item for item in of_records if _is_clear(item)]
    largest = {x.parameter: max(abs(y.value) for y in own if y.parameter == x.parameter) for x in own}
    own = [item for item in own if abs(item.value) > NEXT_TO_NOTHING * largest[item.parameter]]
    return of_all if any(map(_is_clear, of_all)) or (of_all and not own) else own or of_records


def _not_zero(sizes: Sequence[Size]) -> Sequence[Size]:
    """Sizes whose intervals do not hold zero, where there are some."""
    return [*filter(_is_clear, sizes)] or sizes


def _is_clear(item: Size) -> bool:
    """Whether the interval of a size does not hold zero."""
    return not item.low <= 0.0 <= item.high


def _in_some(sizes: Sequence[Size]) -> str:
    """` in A and B`, of sizes of single records that are not zero in some alone."""
    own, every = ({item.record for item in some if item.record} for some in (_not_zero(sizes), sizes))
    return f" in {in_line(sorted(own))}" if own < every else ""


def _corrected(diagnosis: Diagnosis) -> str:
    """What was corrected in the records before the simulation was judged, as the first words of a headline: what shows
    most clearly first, behind whole columns."""
    of_records = by_subject(diagnosis)[0]
    of_records.sort(key=lambda f: (not f.details.get("columns"), -(f.statistic or 0.0)))
    first, *more = [tie(f) for f in of_records] or [""]
    others = f" and {len(more)} more" if more else ""
    return f"{first}{others} corrected, but " if first else ""


def _unexplained(diagnosis: Diagnosis) -> str:
    """That no cause explains the errors, and when they arise, or else what the base model predicts nevertheless, up to
    where it is trusted."""
    if spans := _spans(diagnosis):
        return f"no known cause explains the errors; most arise in {spans}"
    ahead, name = diagnosis.ahead, diagnosis.model.id
    time_s = 0.0 if ahead is None else ahead.trusted_s.get(name, 0.0)
    if ahead is not None and 0.0 < time_s < math.inf:
        share = share_explained(ahead, "yaw_rate_rad_s", name, label(time_s))
        if share >= USEFUL:
            use = f"up to {label(time_s)} ahead the simulation is of use: it predicts {percent(share)} of the yaw rate"
            return f"no known cause explains the errors; {use}"
    return "the simulation is wrong in a way that no known cause explains"


def _spans(diagnosis: Diagnosis) -> str:
    """The times at which forces act that are those of single records alone; empty where there are none."""
    spans = [force.span for force in diagnosis.remaining if force.span]
    first = spans[0] if spans else ""
    return f"{len(spans)} spans of time, first {first}" if len(spans) > 1 else first


def _but_for(diagnosis: Diagnosis) -> str:
    """The times at which an adequate simulation errs."""
    spans = _spans(diagnosis)
    return f" but for {spans}" if spans else ""


def _ending(diagnosis: Diagnosis) -> str:
    """What the extended model does to the error of held-out records, at the end of a headline."""
    gained = next((n for n in HEADLINED if n in diagnosis.gain and _changes(diagnosis, n)), None)
    if not gained:
        return "."
    gain, trim = diagnosis.gain[gained], _errors_beside_trim(diagnosis)
    if trim and (trim[1] <= trim[0] or gain.rmse_after > gain.rmse_before):
        return f"; held-out heading error (own neutral angle) {_from_to('heading_rad', *trim)}."
    return f"; held-out {channel(gained)[0]} error {_from_to(gained, gain.rmse_before, gain.rmse_after)}."


def _held_out(diagnosis: Diagnosis) -> str:
    """The error of the heading of held-out records, at the end of a headline; empty where none was measured."""
    gain = diagnosis.gain.get("heading_rad")
    if gain is None:
        return ""
    own = math.isfinite(gain.own_after)
    of_what = "heading error (own neutral angle)" if own else "heading error"
    return f"; held-out {of_what} {with_unit(DEG * (gain.own_after if own else gain.rmse_after), 'deg')}"


def remaining(force: RemainingForce) -> str:
    """A force that no known cause explains: what it depends on, its sizes, what it may be, and what would tell."""
    numbers = {item.parameter for item in force.sizes}
    if force.curve and len(numbers) > 1 and not (force.of_sensor or force.depends_on[0].startswith("past")):
        sizes = _extremes(force.curve)
    else:
        endings = {name: ENDINGS.get(name.rpartition("_")[2], name) if len(numbers) > 1 else "" for name in numbers}
        sizes = "; ".join(f"{endings[s.parameter]} {_in_record(s)}".strip() for s in _not_zero(force.sizes))
    said = f"{sentence(force.text)[:-1]} ({sizes})." if sizes else sentence(force.text)
    known = "" if force.extended else " It is not a term of the extended model."
    known += f" As likely: {in_line(list(force.tied_with))}." if force.tied_with else ""
    return f"{said}{known} It may be {force.reading}. To tell: {force.next_manoeuvre}."


def _in_record(item: Size) -> str:
    """A size without its name: `0.03 deg/s [0.028, 0.032] in B`; that of a change in a regime with this."""
    return f"{' '.join(value_and_interval(item))}{_where(item)}"


def _where(item: Size) -> str:
    """The record that a size is of, or the regime, behind a blank; empty for all records."""
    regime = item.parameter.removeprefix(CHANGE).partition(" ")[2] if item.parameter.startswith(CHANGE) else ""
    return f" {regime}" if regime else f" in {item.record}" if item.record else ""


def _extremes(curve: Curve) -> str:
    """The largest force to either side along a curve, with its interval and where it is."""
    unit, factor = ("deg", DEG) if curve.variable_unit == "rad" else (curve.variable_unit, 1.0)
    force = curve.force
    ends = dict.fromkeys((force.index(min(force)), force.index(max(force))))
    sizes = {k: Size("", force[k], curve.low[k], curve.high[k], curve.force_unit) for k in ends}
    return ", ".join(f"{_in_record(s)} at {with_unit(factor * curve.values[k], unit)}" for k, s in sizes.items())


def _wrong_groups(findings: Sequence[Finding]) -> list[str]:
    """Groups of the base model's own numbers that are named, by their short titles."""
    return [title.partition(" (")[0] for f in findings for title in f.details.get("groups", ())]


def verdict(diagnosis: Diagnosis) -> str:
    """The first sentences: what the records show by themselves, what the simulation lacks, and what including it does
    to the free-run error."""
    return " ".join(
        part for part in (*_findings(diagnosis), gain_sentence(diagnosis), calibrated_sentence(diagnosis)) if part
    )


def _findings(diagnosis: Diagnosis) -> tuple[str, str]:
    """What the records show without a model, and the verdict on the simulation."""
    of_records, of_model = by_subject(diagnosis)
    current = [f for f in of_records if f.cause == Current.id]
    sensors = [f for f in of_records if f.stage == BY_CHANNELS and f not in current]
    beside = [f for f in of_records if f not in (*sensors, *current)]
    shown = [f"Found in the records themselves, and corrected: {listed(sensors)}."] if sensors else []
    if current:
        shown.append(f"Positions against the log show a {listed(current)}: they are not compared with the model.")
    if beside:
        shown.append(f"The records show {listed(beside)}, which is no error of the simulation.")
    lacking = _lacking(diagnosis, of_model) if of_model else _agrees(diagnosis, bool(beside))
    still = "With that corrected, the simulation is still" if sensors else "The simulation is"
    unexplained = f"{still} wrong in a way that none of the known causes explains"
    best = f"; of these, {listed(of_model)} {'fit' if len(of_model) > 1 else 'fits'} best." if of_model else "."
    described = f"{unexplained}, but what remains is described"
    if diagnosis.remaining and all(force.of_sensor for force in diagnosis.remaining):
        described = "The errors are those of a sensor, not of the simulation"
    return " ".join(shown), {
        "adequate": f"The simulation agrees with {_alike(diagnosis)}{_but_for(diagnosis)}: no cause is named.",
        "inconclusive": "The records do not allow a conclusion.",
        "unexplained": unexplained + best,
        "described": f"{described}.",
        "named": f"{lacking}{_still_lost(diagnosis) if of_model else ''}.",
        "partly_named": f"{lacking}; a part of its error remains." if of_model else "A part of its error remains.",
        "tied": f"{lacking}; the records cannot distinguish between the tied causes.",
    }[diagnosis.verdict]


def _agrees(diagnosis: Diagnosis, apart_from: bool) -> str:
    """That nothing of the simulation is named, and whether it follows whole held-out records; apart_from : motion that
    no simulation has, which the yaw rate shows most."""
    lost = _lost(diagnosis, HEADLINED[:1] if apart_from else HEADLINED[:2])
    pieces = f"pieces of {_alike(diagnosis)}, but hardly follows whole held-out records ({lost})"
    agrees = f"agrees with {pieces if lost else _alike(diagnosis)}"
    return f"Apart from that, the simulation {agrees}" if apart_from else f"The simulation {agrees}"


def _still_lost(diagnosis: Diagnosis) -> str:
    """That whole held-out records are hardly followed, although most is explained; empty where they are followed."""
    lost = _lost(diagnosis, HEADLINED[:2])
    return f"; even so, the extended model hardly follows whole held-out records ({lost})" if lost else ""


def _lost(diagnosis: Diagnosis, columns: Sequence[str]) -> str:
    """Channels that are hardly predicted along held-out records, with R²; empty where none is."""
    r2 = {n: diagnosis.gain[n].r2_after for n in columns if n in diagnosis.gain}
    return ", ".join(f"R² {x:.2f} of the {shown_name(n)}" for n, x in r2.items() if x < USEFUL)


def _alike(diagnosis: Diagnosis) -> str:
    """The records that were diagnosed, in words."""
    train = [name for name, role in diagnosis.records if role == "train"]
    left = len(train) - len(diagnosis.apart)
    not_with = f" (not with {in_line(diagnosis.apart)})" if len(diagnosis.apart) <= SHOWN else ""
    return f"{left} of {len(train)} training records{not_with}" if diagnosis.apart else "the records"


def _lacking(diagnosis: Diagnosis, findings: Sequence[Finding]) -> str:
    """What the simulation lacks; coefficients it has, and they are wrong; and what is so in some records alone."""
    some = [f for f in findings if "records" in f.details]
    wrong = [f for f in findings if f.cause == BaseCoefficients.id and not f.tied_with and f not in some]
    lacked = [f for f in findings if f not in wrong and f not in some]
    side = [f for f in lacked if f.cause == RudderSign.id]
    lacked = [f for f in lacked if f not in side]
    parts = ["turned its rudder to the wrong side, which was corrected"] if side else []
    parts += [f"has wrong {_groups(diagnosis, wrong) or _together(diagnosis, wrong)}"] if wrong else []
    parts += [f"lacks {listed(lacked)}"] if lacked else []
    alone = [_with_size(diagnosis.model, f, interval=True) for f in some]
    parts += [f"errs by {in_line(alone)}"] if alone else []
    return f"The simulation {' and '.join(parts)}"


def _groups(diagnosis: Diagnosis, findings: Sequence[Finding]) -> str:
    """Groups of coefficients with their numbers as changes: `propeller thrust (thrust_scale +33 %)`; empty where all
    are uncertain."""
    numbers = [_changed(diagnosis.model, item) for finding in findings for item in finding.sizes]
    groups = in_line(_wrong_groups(findings)) or "numbers of its own"
    alike = [n for f in findings for n in (*f.details.get("numbers that would do as well", ()), *_groups_as_good(f))]
    others = f"; {in_line(alike)} would do as well" if alike else ""
    together = "numbers, most of all " if any(BESIDE in f.details for f in findings) else ""
    return f"{together}{groups} ({', '.join(numbers)}{others})" if numbers else ""


def _together(diagnosis: Diagnosis, findings: Sequence[Finding]) -> str:
    """Numbers that are all uncertain, with the changes of those that move furthest for their priors."""
    numbers = {k: v for f in findings for k, v in f.details.get("numbers", {}).items()}
    first = [_moved(name, *numbers[name]) for name in list(numbers)[:MOVED]]
    rest = f" and {len(numbers) - MOVED} more" if len(numbers) > MOVED else ""
    fit = f" (joint fit: {', '.join(first)}{rest})" if first else ""
    return f"numbers of its own, of which none alone explains the error{fit}"


def change(model: Model, finding: Finding, item: Size) -> str:
    """By how much a number of the model's own changes, `+30 %`; empty of all others."""
    if finding.cause != BaseCoefficients.id or not _before(model, item):
        return ""
    return _changed(model, item).removeprefix(item.parameter).strip()


def _before(model: Model, item: Size) -> float:
    """What the model says of a number, or of a coefficient of its wind force; 0 where it has none of it."""
    return {**(model.windage or {}), **model.parameters}.get(item.parameter, 0.0)


def _changed(model: Model, item: Size, interval: bool = True) -> str:
    """A number of the model as its change in per cent, one that it has not or that was 0 as it is, with its interval or
    without: `N_r +12 %`."""
    if item.parameter.startswith(CHANGE):
        number_of, _, where = item.parameter.removeprefix(CHANGE).partition(" ")
        factor, unit = scale(item)
        value = f"{factor * item.value:+.2g} {unit}" if item.unit == "rad" else f"{100.0 * item.value:+.0f} %"
        return f"{number_of} {value} {where}"
    before = _before(model, item)
    if before or item.parameter in FACTORS:
        return _moved(item.parameter, before, item.value)
    return size(item) if interval else f"{label_of(item)} {value_and_interval(item)[0]}"


def _moved(name: str, before: float, after: float) -> str:
    """The change of a number in per cent; where it is too large for that, both values."""
    if name in FACTORS:
        return f"{FACTORS[name]} {100.0 * after:+.0f} %"
    if not before:
        return f"{name} {number(after)}"
    percent = 100.0 * (after / before - 1.0)
    return f"{name} {percent:+.0f} %" if abs(percent) < MOST_PERCENT else f"{name} {number(before)} to {number(after)}"


def in_line(parts: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def by_subject(diagnosis: Diagnosis) -> tuple[list[Finding], list[Finding]]:
    """Findings of the records, and those of the simulation."""
    of_records = [f for f in diagnosis.causes if is_of_record(f)]
    return of_records, [f for f in diagnosis.causes if f not in of_records]


def listed(findings: Sequence[Finding]) -> str:
    """Causes with the sizes that hold for all records, or with the first ones of single records; ties at the end."""
    named = []
    for finding in sorted(findings, key=lambda f: bool(f.tied_with)):
        sizes = [f"{_name_in(finding, item)}{_in_record(item)}" for item in telling(finding)[:SHOWN]]
        named.append(tie(finding, sizes))
    return in_line(named)


def gain_sentence(diagnosis: Diagnosis) -> str:
    """How the extension changes the error on held-out records, or how large it is; empty where none was measured."""
    shown = [name for name in ("yaw_rate_rad_s", "heading_rad", "surge_m_s", "sway_m_s") if name in diagnosis.gain]
    if not shown:
        return ""
    changed = [name for name in shown if _changes(diagnosis, name)]
    error = "the free-run error on held-out records"
    if changed:
        changes = in_line([_change(diagnosis, name) for name in changed[:2]])
        told = f"The extended model changes {error}: {changes}."
    else:
        opening = f"The extended model leaves {error} as it is:" if diagnosis.extends else f"{error.capitalize()} is"
        told = f"{opening} {in_line([_error(diagnosis, name) for name in shown[:2]])}."
    blind = [name for name in shown if diagnosis.gain[name].rmse_after > WORSE * diagnosis.gain[name].rmse_before]
    lost = [n for n in blind if not diagnosis.gain[n].own_after <= WORSE * diagnosis.gain[n].own_before]
    if lost:
        return f"{told} {worse(lost, 'extended')}"
    names = ", ".join(channel(name)[0] for name in blind)
    return f"{told} The error of {names} grows only where a record's own neutral angle is not known." if blind else told


def calibrated_sentence(diagnosis: Diagnosis) -> str:
    """What moving all numbers of the base model under their priors would reach; empty where none was uncertain."""
    shown = [n for n in ("yaw_rate_rad_s", "heading_rad") if n in diagnosis.calibrated_gain and n in diagnosis.gain]
    pairs = [(diagnosis.calibrated_gain[n].rmse_after, diagnosis.gain[n].rmse_after) for n in shown]
    if diagnosis.calibrated is None or all(new == old for new, old in pairs):
        return ""
    if any(new > WORSE * old for new, old in pairs):
        return "With all its numbers moved under their priors held-out records are predicted worse (calibrated model)."
    errors = [f"{number(channel(n)[2] * diagnosis.calibrated_gain[n].rmse_after)} {channel(n)[1]}" for n in shown]
    return f"With all its numbers moved under their priors the errors are {in_line(errors)} (calibrated model)."


def _changes(diagnosis: Diagnosis, name: str) -> bool:
    """Whether the error of a channel changes by more than what is told as no change."""
    gain = diagnosis.gain[name]
    return not abs(gain.rmse_after - gain.rmse_before) <= TOO_SMALL * gain.rmse_before


def _from_to(name: str, before: float, after: float) -> str:
    """Errors of a channel, SI: `from 3.49 to 0.143 deg`."""
    _, unit, factor = channel(name)
    return f"from {number(factor * before)} to {number(factor * after)} {unit}".strip()


def _change(diagnosis: Diagnosis, name: str) -> str:
    gain = diagnosis.gain[name]
    return f"of the {channel(name)[0]} {_from_to(name, gain.rmse_before, gain.rmse_after)}"


def _errors_beside_trim(diagnosis: Diagnosis) -> tuple[float, float] | None:
    """Errors of the heading with own neutral angles and starts, before and after; None where they are not known, or
    where a neutral angle is named that is not each record's own."""
    gain = diagnosis.gain.get("heading_rad")
    of_all = [f for f in diagnosis.causes if "records" not in f.details]
    shared = [f for f in of_all if not f.sizes or any(size.record is None for size in f.sizes)]
    named = {name for f in shared for name in (f.cause, *f.tied_with)}
    if gain is None or RudderOffset.id in named or not math.isfinite(gain.own_before + gain.own_after):
        return None
    return gain.own_before, gain.own_after


def _error(diagnosis: Diagnosis, name: str) -> str:
    word, unit, factor = channel(name)
    return f"{with_unit(factor * diagnosis.gain[name].rmse_after, unit)} of the {word}"


def worse(columns: Sequence[str], model: str) -> str:
    """Which channels of held-out records a model that was made (extended, calibrated) predicts worse."""
    names = ", ".join(channel(column)[0] for column in columns)
    return f"Held-out records are predicted worse than by the base model in {names}: use the {model} model with care."


def ordered_bank(diagnosis: Diagnosis) -> list[Entry]:
    """All causes: those named first, then by evidence."""

    def key(entry: Entry) -> tuple:
        place = STATUS_ORDER.index(entry.status) if entry.status in STATUS_ORDER else len(STATUS_ORDER)
        p = 2.0 if entry.p_adjusted is None else entry.p_adjusted
        return place, p, -(entry.statistic or 0.0), entry.cause

    return sorted(diagnosis.bank, key=key)


def hypothesis(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """The term that fits an unexplained effect best, as pairs of name and text."""
    facts = diagnosis.hypothesis or {}
    rows = [("kind", cause(str(facts.get("hypothesis", ""))))]
    rows += [(f"{term['term']} on {term['acts_on']}", number(float(term["size"]))) for term in facts.get("terms", ())]
    outcomes = {True: "confirmed", False: "rejected", None: "not tested"}
    confirmed = facts.get("confirmed_on_held_out")
    return [*rows, ("on held-out records", outcomes[None if confirmed is None else bool(confirmed)])]


def facts(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """What the diagnosis was made with, as pairs of name and text."""
    given = {True: "known, from the model file", False: "identified together with the causes"}
    files = {role: [name for name, own in diagnosis.records if own == role] for role in ("train", "held_out")}
    rows = [
        ("model", f"{diagnosis.model.id} ({diagnosis.model.family})"),
        ("base parameters", given[diagnosis.base_parameters == "file"]),
        ("training records", ", ".join(files["train"])),
        ("held-out records", ", ".join(files["held_out"]) or "none: the gain was not measured"),
        ("family-wise level", number(diagnosis.alpha)),
        ("seed", str(diagnosis.seed)),
    ]
    if diagnosis.wall_s > 0.0:
        rows.append(("time", f"{diagnosis.wall_s:.1f} s ({diagnosis.cpu_s:.1f} s of processor time)"))
    return [*rows, *noise_rows(diagnosis)]


def noise_rows(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """The estimated noise model, as pairs of name and text."""
    noise, rows = diagnosis.noise, []
    sd = [_standard_deviation(name, value) for name, value in noise.get("sensor_sd", {}).items()]
    if noise.get("rudder_sd") is not None:
        sd.append(f"rudder {number(DEG * noise['rudder_sd'])} deg")
    if sd:
        rows.append(("sensor noise (sd)", ", ".join(sd)))
    forces = noise.get("force_sd", [])
    if len(forces):
        names = (("X", "N"), ("Y", "N"), ("N", "N m")) if len(forces) == 3 else [("yaw", "")] * len(forces)
        texts = [f"{name} {with_unit(value, unit)}" for (name, unit), value in zip(names, forces, strict=True)]
        time = f", correlation time {number(noise.get('correlation_time_s'))} s"
        rows.append(("gusts (sd)", ", ".join(texts) + time if max(forces) > 0.0 else "none"))
    return rows


def _standard_deviation(name: str, value: float) -> str:
    word, unit, factor = channel(name)
    return f"{word} {with_unit(factor * float(value), unit)}"


FOUND_BY = {
    "kinematics": "Found in the records by themselves",
    "dynamics": "Found in the residuals of a filter",
    "free runs": "Found by free runs of the model along pieces of the records",
}
"""Stage -> how something was found."""


def found_by(finding: Finding) -> str:
    """How a cause was found, and the p-value of its test where there was one."""
    p = finding.p_adjusted
    tested = "there is no test of significance" if p is None else f"p-value {p_value(p)}, adjusted for all causes tried"
    return f"{FOUND_BY[finding.stage]}; {tested}."


def separations(diagnosis: Diagnosis) -> list[str]:
    """What would distinguish between tied causes, a sentence each finding that is tied."""
    tied = [f for f in diagnosis.causes if f.tied_with and f.separate_by]
    return [f"To distinguish {in_line(list(map(cause, (f.cause, *f.tied_with))))}: {f.separate_by}." for f in tied]
