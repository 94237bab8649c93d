"""Sentences and facts of a diagnosis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from ...datasets.columns import CANONICAL
from ...datasets.display import IN_DEGREES, shown_name, shown_unit
from ...diagnosis.causes.base_coefficients import BaseCoefficients
from ...diagnosis.causes.registry import causes
from ...diagnosis.causes.steering_gear import RudderOffset
from ...diagnosis.causes.surroundings import Current
from ...diagnosis.gain.guard import WORSE
from ...estimation.validation.validate import label
from ..numbers import DEG, interval_digits, number, percent, with_unit
from ..validation.page import share_explained

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...checks.result import Size
    from ...diagnosis.result import Diagnosis, Entry, Finding, RemainingForce
    from ...models.model import Model

SHARES = ("e", "s", "share", "fraction", "change")
"""Parameters without unit that are given in per cent."""
HEADLINED = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m", "position_m")
"""Channels of which the first one that changes is told in the headline."""
FACTORS = {"thrust_scale": "thrust"}
"""Parameters of extensions that are changes of a factor, and what they change."""
MOST_PERCENT = 1000.0
"""Change, %, from which both values are told in its place."""
MOVED = 5
"""Numbers of a joint fit that are told with their changes."""
USEFUL = 0.5
"""Share of the yaw rate from which a simulation whose errors no cause explains is told to be of use."""
LONGEST = 25
"""Words that a headline may have."""
STATUS_ORDER = ("named", "tied", "explained_by", "not_significant", "not_testable")


def channel(name: str) -> tuple[str, str, float]:
    """Name, unit and factor with which a channel is shown."""
    if name in CANONICAL:
        return shown_name(name), *shown_unit(name)
    return ("position", "m", 1.0) if name == "position_m" else (name, "", 1.0)


def size(item: Size) -> str:
    """`delta0 0.31 deg [0.28, 0.34]`, in degrees or per cent where that is usual; `+- 0.07 %` of a narrow interval."""
    factor, unit = scale(item)
    value, low, high = (factor * x for x in (item.value, item.low, item.high))
    digits = interval_digits(value, low, high, most=3)
    where, name = f" in {item.record}" if item.record else "", FACTORS.get(item.parameter, item.parameter)
    middle, ends = with_unit(value, unit, digits), (number(low, digits), number(high, digits))
    if ends[0] == ends[1] and low < high:  # three digits do not show so narrow an interval
        of_value = f"{number(50.0 * (high - low) / max(abs(value), 1e-300), 1)} %"
        width = f"+- {with_unit(0.5 * (high - low), unit, 1) if unit == 'deg' else of_value}"
        return f"{name} {middle} {width}{where}"
    return f"{name} {middle} [{ends[0]}, {ends[1]}]{where}"


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
    return name.replace("_", " ")


def said(text: str) -> str:
    """A sentence of a diagnosis, with the ids of causes as words."""
    for name in causes():
        text = text.replace(name, cause(name))
    return text


def sentence(text: str) -> str:
    """The same with a capital and a full stop."""
    text = said(text)
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".") if text else ""


def tie(finding: Finding) -> str:
    """The cause with the columns that it is of, or other values of groups of numbers, with causes that the records
    cannot distinguish from it."""
    own, columns = finding.cause == BaseCoefficients.id and finding.tied_with, finding.details.get("columns", ())
    first = f"other values of {in_line(_wrong_groups([finding]))}" if own else cause(finding.cause)
    first += f" of {in_line([channel(name)[0] for name in columns])}" if columns else ""
    return f"{'either ' if finding.tied_with else ''}{' or '.join([first, *map(cause, finding.tied_with)])}"


def detail(value: object) -> str:
    """A detail of a finding: a number with three digits, parts of a list or of a table one after the other."""
    if isinstance(value, Mapping):
        return ", ".join(f"{said(str(key))} {detail(part)}" for key, part in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(map(detail, value))
    return number(value) if isinstance(value, float) else said(str(value))


def headline(diagnosis: Diagnosis) -> str:
    """The verdict in at most LONGEST words: what is named, and what including it does to the heading (or the next known
    channel) of held-out records; the heading with each record's own neutral angle and start, which are not the model's,
    unless one neutral angle of all records is what is named."""
    alone = {
        "adequate": f"the simulation agrees with {_alike(diagnosis)}{_but_for(diagnosis)}",
        "inconclusive": "the records do not allow a conclusion",
        "unexplained": f"{_corrected(diagnosis)}{_unexplained(diagnosis)}",
    }
    told = f"{cause(diagnosis.verdict).capitalize()}: "
    if diagnosis.verdict == "described":
        return f"{told}{diagnosis.remaining[0].text.partition(';')[0]}, of no known cause{_ending(diagnosis)}"
    if diagnosis.verdict in alone or not diagnosis.causes:
        return f"{told}{alone.get(diagnosis.verdict, 'a part of the error is explained')}."
    of_records, of_model = _by_stage(diagnosis)
    wrong = [f for f in of_model if f.cause == BaseCoefficients.id and not f.tied_with]
    columns = [f for f in of_records if f.details.get("columns")]
    rest = [f for f in (*of_model, *of_records) if f not in (*wrong, *columns)]
    names = [*map(tie, columns), *_wrong_groups(wrong), *map(tie, rest)]
    ending = _ending(diagnosis)
    for count in range(len(names), 0, -1):
        more = [f"{len(names) - count} more"] if count < len(names) else []
        line = f"{told}{in_line([*names[:count], *more])}{ending}"
        if len(line.split()) <= LONGEST:
            return line
    return f"{told}{len(names)} {'cause' if len(names) == 1 else 'causes'}{ending}"


def _corrected(diagnosis: Diagnosis) -> str:
    """What was corrected in the records before the simulation was judged, as the first words of a headline."""
    first, *more = [tie(f) for f in _by_stage(diagnosis)[0]] or [""]
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
    gained = next((n for n in HEADLINED if n in diagnosis.gain and len(set(_before_and_after(diagnosis, n))) > 1), None)
    return f"; held-out error {_beside_trim(diagnosis) or _change(diagnosis, gained)}." if gained else "."


def remaining(force: RemainingForce) -> str:
    """A force that no known cause explains: what it depends on, its sizes, what it may be, and what would tell."""
    sizes = "; ".join(map(size, force.sizes))
    said = f"{sentence(force.text)[:-1]} ({sizes})." if sizes else sentence(force.text)
    known = "" if force.extended else " It is not a term of the extended model."
    known += f" As likely: {in_line(list(force.tied_with))}." if force.tied_with else ""
    return f"{said}{known} It may be {force.reading}. To tell: {force.next_manoeuvre}."


def _wrong_groups(findings: Sequence[Finding]) -> list[str]:
    """Groups of the base model's own numbers that are named, by their short titles."""
    titles = [title.partition(" (")[0] for f in findings for title in f.details.get("groups", ())]
    return titles or (["parameters of the model"] if findings else [])


def verdict(diagnosis: Diagnosis) -> str:
    """The first sentences: what the records show by themselves, what the simulation lacks, and what including it does
    to the free-run error."""
    return " ".join(
        part for part in (*_findings(diagnosis), gain_sentence(diagnosis), calibrated_sentence(diagnosis)) if part
    )


def _findings(diagnosis: Diagnosis) -> tuple[str, str]:
    """What the records show without a model, and the verdict on the simulation."""
    of_records, of_model = _by_stage(diagnosis)
    current = [f for f in of_records if f.cause == Current.id]
    sensors = [f for f in of_records if f not in current]
    shown = [f"Found in the records themselves, and corrected: {listed(sensors)}."] if sensors else []
    if current:
        shown.append(f"Positions against the log show a {listed(current)}: they are not compared with the model.")
    lacking = _lacking(diagnosis, of_model) if of_model else _agrees(diagnosis)
    still = "With that corrected, the simulation is still" if sensors else "The simulation is"
    unexplained = f"{still} wrong in a way that none of the known causes explains"
    best = f"; of these, {listed(of_model)} {'fit' if len(of_model) > 1 else 'fits'} best." if of_model else "."
    return " ".join(shown), {
        "adequate": f"The simulation agrees with {_alike(diagnosis)}{_but_for(diagnosis)}: no further cause is needed.",
        "inconclusive": "The records do not allow a conclusion.",
        "unexplained": unexplained + best,
        "described": f"{unexplained}, but what remains is described.",
        "named": f"{lacking}.",
        "partly_named": f"{lacking}; a part of its error remains." if of_model else "A part of its error remains.",
        "tied": f"{lacking}; the records cannot distinguish between the tied causes.",
    }[diagnosis.verdict]


def _agrees(diagnosis: Diagnosis) -> str:
    """That nothing of the simulation is named, and whether it follows whole held-out records."""
    r2 = {n: diagnosis.gain[n].r2_after for n in HEADLINED[:2] if n in diagnosis.gain}
    lost = [f"R² {x:.2f} of the {shown_name(n)}" for n, x in r2.items() if x < USEFUL]
    pieces = f"pieces of {_alike(diagnosis)}, but hardly follows whole held-out records ({', '.join(lost)})"
    return f"The simulation agrees with {pieces if lost else _alike(diagnosis)}"


def _alike(diagnosis: Diagnosis) -> str:
    """The records that were diagnosed, in words."""
    train = [name for name, role in diagnosis.records if role == "train"]
    left = len(train) - len(diagnosis.apart)
    return f"{left} of {len(train)} training records" if diagnosis.apart else "the records"


def _lacking(diagnosis: Diagnosis, findings: Sequence[Finding]) -> str:
    """What the simulation lacks; coefficients it has, and they are wrong."""
    wrong = [f for f in findings if f.cause == BaseCoefficients.id and not f.tied_with]
    lacked = [f for f in findings if f not in wrong]
    parts = [f"has wrong {_groups(diagnosis, wrong) or _together(diagnosis, wrong)}"] if wrong else []
    parts += [f"lacks {listed(lacked)}"] if lacked else []
    return f"The simulation {' and '.join(parts)}"


def _groups(diagnosis: Diagnosis, findings: Sequence[Finding]) -> str:
    """Groups of coefficients with their numbers as changes: `propeller thrust (thrust_scale +33 %)`; empty where all
    are uncertain."""
    numbers = [_changed(diagnosis.model, item) for finding in findings for item in finding.sizes]
    groups = in_line(_wrong_groups(findings))
    alike = [name for f in findings for name in f.details.get("numbers that would do as well", ())]
    others = f"; {in_line(alike)} would do as well" if alike else ""
    return f"{groups} ({', '.join(numbers)}{others})" if numbers else ""


def _together(diagnosis: Diagnosis, findings: Sequence[Finding]) -> str:
    """Numbers that are all uncertain, with the changes of those that move furthest for their priors."""
    numbers = {k: v for f in findings for k, v in f.details.get("numbers", {}).items()}
    first = [_moved(name, *numbers[name]) for name in list(numbers)[:MOVED]]
    rest = f" and {len(numbers) - MOVED} more" if len(numbers) > MOVED else ""
    fit = f" (their joint fit, which measures none of them alone: {', '.join(first)}{rest})" if first else ""
    return f"numbers of its own, of which none alone explains the error{fit}"


def size_and_change(model: Model, finding: Finding, item: Size) -> str:
    """A size; of a number of the model's own with its change behind it: `R_0 0.029 [0.028, 0.03], +30 %`."""
    if finding.cause != BaseCoefficients.id or not _before(model, item):
        return size(item)
    return f"{size(item)}, {_changed(model, item).removeprefix(item.parameter).strip()}"


def _before(model: Model, item: Size) -> float:
    """What the model says of a number, or of a coefficient of its wind force; 0 where it has none of it."""
    return {**(model.windage or {}), **model.parameters}.get(item.parameter, 0.0)


def _changed(model: Model, item: Size) -> str:
    """A number of the model as its change in per cent, one that it has not or that was 0 as it is: `N_r +12 %`."""
    change, _, name = item.parameter.partition(": ")
    if change == "change":
        number_of, _, where = name.partition(" ")
        factor, unit = scale(item)
        value = f"{factor * item.value:+.2g} {unit}" if item.unit == "rad" else f"{100.0 * item.value:+.0f} %"
        return f"{number_of} {value} {where}"
    before = _before(model, item)
    return size(item) if not before and item.parameter not in FACTORS else _moved(item.parameter, before, item.value)


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


def _by_stage(diagnosis: Diagnosis) -> tuple[list[Finding], list[Finding]]:
    """Findings that the records show by themselves, for which they were corrected, and those of the simulation."""
    of_records = [f for f in diagnosis.causes if f.stage == "kinematics"]
    return of_records, [f for f in diagnosis.causes if f.stage != "kinematics"]


def listed(findings: Sequence[Finding]) -> str:
    """Causes with the sizes that hold for all records, or with the first ones of single records."""
    named = []
    for finding in findings:
        sizes = [item for item in finding.sizes if item.record is None] or finding.sizes
        named.append(f"{tie(finding)} ({'; '.join(map(size, sizes[:3]))})" if sizes else tie(finding))
    return in_line(named)


def gain_sentence(diagnosis: Diagnosis) -> str:
    """How the extension changes the error on held-out records; empty where no gain was measured."""
    shown = [name for name in ("yaw_rate_rad_s", "heading_rad", "surge_m_s", "sway_m_s") if name in diagnosis.gain]
    forces = [force for force in diagnosis.remaining if force.extended]
    if not shown or not (diagnosis.causes or forces):
        return ""
    changed = [name for name in shown if len(set(_before_and_after(diagnosis, name))) > 1]
    of_model = [*_by_stage(diagnosis)[1], *forces]
    error, what = "the free-run error on held-out records", "it" if len(of_model) == 1 else "them"
    if changed:
        told = f"Including {what} changes {error}: {', '.join(_change(diagnosis, name) for name in changed[:2])}."
    else:
        opening = f"Including {what} leaves {error} as it is:" if of_model else f"{error.capitalize()} is"
        told = f"{opening} {', '.join(_error(diagnosis, name) for name in shown[:2])}."
    blind = [name for name in shown if diagnosis.gain[name].rmse_after > WORSE * diagnosis.gain[name].rmse_before]
    lost = [n for n in blind if not diagnosis.gain[n].own_after <= WORSE * diagnosis.gain[n].own_before]
    if lost:
        return f"{told} {worse(lost, 'extended')}"
    names = ", ".join(channel(name)[0] for name in blind)
    return f"{told} The error of {names} grows only where a record's own neutral angle is not known." if blind else told


def calibrated_sentence(diagnosis: Diagnosis) -> str:
    """What moving all numbers of the base model under their priors would reach; empty where none was uncertain."""
    shown = [n for n in ("yaw_rate_rad_s", "heading_rad") if n in diagnosis.calibrated_gain and n in diagnosis.gain]
    same = all(diagnosis.calibrated_gain[n].rmse_after == diagnosis.gain[n].rmse_after for n in shown)
    if diagnosis.calibrated is None or same:
        return ""
    errors = [f"{number(channel(n)[2] * diagnosis.calibrated_gain[n].rmse_after)} {channel(n)[1]}" for n in shown]
    return f"With all its numbers moved under their priors the errors are {in_line(errors)} (calibrated model)."


def _before_and_after(diagnosis: Diagnosis, name: str) -> tuple[str, str]:
    """Errors of a channel as they are shown."""
    gain, factor = diagnosis.gain[name], channel(name)[2]
    return number(factor * gain.rmse_before), number(factor * gain.rmse_after)


def _change(diagnosis: Diagnosis, name: str) -> str:
    (before, after), (word, unit, _) = _before_and_after(diagnosis, name), channel(name)
    return f"of the {word} from {before} to {after} {unit}"


def _beside_trim(diagnosis: Diagnosis) -> str:
    """The change of the heading's error with own neutral angles and starts; empty where it is not known, or where a
    neutral angle is named that is not each record's own."""
    gain = diagnosis.gain.get("heading_rad")
    shared = [f for f in diagnosis.causes if not f.sizes or any(size.record is None for size in f.sizes)]
    named = {name for f in shared for name in (f.cause, *f.tied_with)}
    if gain is None or RudderOffset.id in named or not math.isfinite(gain.own_before + gain.own_after):
        return ""
    word, unit, factor = channel("heading_rad")
    before, after = (number(factor * value) for value in (gain.own_before, gain.own_after))
    return f"of the {word} (own neutral angle) from {before} to {after} {unit}"


def _error(diagnosis: Diagnosis, name: str) -> str:
    word, unit, _ = channel(name)
    return f"{_before_and_after(diagnosis, name)[0]} {unit} of the {word}"


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


def separation(finding: Finding) -> str:
    """What would distinguish between tied causes; empty where nothing is tied."""
    return f"to distinguish between them: {finding.separate_by}" if finding.tied_with and finding.separate_by else ""
