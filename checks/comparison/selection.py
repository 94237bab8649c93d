"""Sensor errors from the channels' agreement with each other, by forward selection: no hull model is needed.

Heading against yaw rate comes first; its corrected records go on to positions against velocities.  A logger's clock and
a speed log that is not linear explain a comparison in the place of scale errors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..base import UNUSABLE
from ..result import NORMAL_90, CheckFinding, Size
from ..sensors import LoggerClock, SpeedScaleError
from ..tails import student_quantile
from .blocks import BLOCKS, DIFFERENT, BlockFit, Mean, Sums, explained, fit, p_value, random_effects_mean
from .chains import Chain, Option, sums, why_not

if TYPE_CHECKING:
    from ...datasets.record import Record
    from .motion import Motion

LEVEL = 6.3e-5
"""Probability (|z| = 4) at which an effect is taken as found, before it is shared among records."""
LEAST = 16.0
"""Least sum of squares that it explains (z = 4): collinear columns may scatter too little to be judged by blocks."""
MOST = 3
"""Effects that are named in a chain at most."""
STEPS = 3
"""Gauss-Newton steps on corrected records."""
TIE = 9.2
"""Twice the log likelihood by which the better of two explanations must lead (odds of 100)."""
CERTAIN = 4.0
"""Standard errors from which the size of a single record is surely not zero."""
LARGE = 3.0
"""Floors from which a size of single records matters, and factor by which those of the others are smaller."""
LATEST = 0.1
"""Share of a record's duration that a delay may have at most."""
COLLINEAR = 0.5
"""Correlation of two sizes from which the small one is left out of the estimate of the large one."""
FAR, SURELY = 0.1, 1e-3
"""Standard deviation between records, as a share of a size, from which they are said to differ; and probability of
equal sizes below which records are corrected by their own sizes of a cause that does not drift."""


class Sizes(NamedTuple):
    """Sizes of one selected option: values and standard errors by record (R, k), means (k), and whether they matter;
    z of its selection, and the options that explain the records about as well."""

    option: Option
    z: float
    rivals: tuple[Option, ...]
    each: np.ndarray
    spread: np.ndarray
    means: tuple[Mean, ...]
    material: bool


Entered = tuple["Option", float, tuple["Option", ...]]
"""An option that entered, with its z and its rivals."""


@dataclass(frozen=True)
class Compared:
    """One chain on some records: what was selected, why others could not be compared, and the options that were tested
    with the z of each by itself.

    absurd : why nothing is said of the sensors: one would have an error that no instrument has.
    earlier : causes (ids) that comparisons before this one showed to matter; a heading as it was read shows them again.
    """

    chain: Chain
    records: tuple[Record, ...]
    sizes: tuple[Sizes, ...]
    reasons: tuple[str, ...]
    tested: tuple[tuple[Option, float], ...] = ()
    absurd: str | None = None
    earlier: frozenset[str] = frozenset()

    @property
    def new(self) -> list[Sizes]:
        """The sizes but those of causes that earlier comparisons showed."""
        return [s for s in self.sizes if s.option.cause.id not in self.earlier]

    @property
    def removed(self) -> list[Sizes]:
        """What is removed from records: what matters, and delays between heading and yaw rate that do not, as a model's
        innovations show those that are far too small to matter."""
        delays = not self.chain.of_positions
        return [s for s in self.sizes if s.material or (delays and s.option.is_delay)]

    @cached_property
    def corrected(self) -> list[Record]:
        """The compared records without what is removed."""
        return [self.without(record) for record in self.records]

    def without(self, record: Record, own: bool = True) -> Record:
        """A record of these instruments without what is removed: by the mean, or where the compared records differ and
        this is one of them (own), by its own size."""
        at = [i for i, one in enumerate(self.records) if own and one.name == record.name]
        for s in self.removed:
            level = DIFFERENT if s.option.cause.drifts else SURELY
            sizes = np.array([mean.value if at else mean.of_another for mean in s.means])
            for i in at:
                differs = np.array([mean.p_equal < level for mean in s.means]) & np.isfinite(s.each[i])
                sizes = np.where(differs, s.each[i], sizes)
            sizes = np.maximum(sizes, 0.0) if s.option.is_delay else sizes
            record = s.option.corrected_for(record, sizes)
        return record


def compare(
    chain: Chain, records: Sequence[Record], derived: Mapping[str, set[str]], later: Sequence[Chain] = ()
) -> Compared:
    """The sensor errors that the records show in a chain, told by what stands `instead` of some where that is better.

    derived : name of a record -> columns that are made from each other.  later : the comparisons after this one.
    """
    if chain.instead and chain.of_positions:
        return _as_curve(chain, records, derived)
    done = _compared(chain, records, derived)
    return _told_instead(done, derived, later) if chain.instead else done


def _compared(chain: Chain, records: Sequence[Record], derived: Mapping[str, set[str]]) -> Compared:
    """Select among the options of a chain."""
    whys = [why_not(chain, r, derived.get(r.name, set())) for r in records]
    reasons, usable = [why for why in whys if why], [r for r, why in zip(records, whys, strict=True) if not why]
    options = [o for o in chain.options if _testable(o, chain, usable)]
    kept = []
    for record in usable:
        try:
            sums(chain, record, options)
            kept.append(record)
        except UNUSABLE as error:
            reasons.append(f"{record.name} cannot be compared: {error}")
    if not kept or not options:
        return Compared(chain, (), (), tuple(reasons))
    entered, alone = _chosen(chain, kept, options)
    sizes = _without_small(chain, kept, _sized(chain, kept, entered))
    tested = tuple(zip(options, alone, strict=True))
    absurd = next((why for s in sizes if (why := _no_instruments(chain, s))), None)
    if absurd is not None:
        return Compared(chain, tuple(kept), (), (*reasons, absurd), tested, absurd)
    return Compared(chain, tuple(kept), sizes, tuple(reasons), tested)


def _no_instruments(chain: Chain, s: Sizes) -> str | None:
    """Why a size that matters, or that records surely have of their own, is none of an instrument; None where it may
    be."""
    entry, own = s.option.cause, np.abs(s.each)
    surely = own[(own > CERTAIN * s.spread) & np.isfinite(own) & (min(m.p_equal for m in s.means) < SURELY)]
    size = max([*(abs(mean.value) for mean in s.means if s.material), *surely.tolist()], default=0.0)
    if size <= entry.farthest:
        return None
    return (
        f"{entry.id} would be {size:.3g} {s.option.effects[0].unit}, which no instrument has: "
        f"something else is wrong with {' or '.join(chain.needed)}"
    )


def _testable(option: Option, chain: Chain, records: Sequence[Record]) -> bool:
    """Whether the records turn far enough to tell the option from others."""
    least = option.cause.least_turn
    return not least or any(float(np.ptp(chain.motion(r).heading)) > least for r in records)


def _columns(options: Sequence[Option]) -> list[list[int]]:
    """Places of each option's columns among those of all."""
    edges = np.cumsum([0, *(len(o.effects) for o in options)])
    return [list(range(a, b)) for a, b in pairwise(edges.tolist())]


class _Trial(NamedTuple):
    """An option beside the chosen ones: the sum of squares that all explain, p-value, z, and how far blocks scatter."""

    option: Option
    explained: float
    p: float
    z: float
    inflation: float


def _chosen(
    chain: Chain, records: Sequence[Record], options: Sequence[Option]
) -> tuple[list[Entered], tuple[float, ...]]:
    """Options by forward selection, and the z of every option by itself: of those that are significant in records which
    are corrected for the ones before, the one that explains most enters, with its rivals."""
    chosen: list[Entered] = []
    alone: tuple[float, ...] = ()
    for _ in range(MOST):
        trials = _trials(chain, records, options, [option for option, _, _ in chosen])
        alone = alone or tuple(t.z for t in trials)
        trials = [t for t in trials if t.p < LEVEL]
        if not trials:
            break
        best = max(trials, key=lambda t: t.explained)
        near = (t.option for t in trials if best.explained - t.explained < TIE * best.inflation)
        chosen.append((best.option, best.z, tuple(o for o in near if o.cause != best.option.cause)))
    return chosen, alone


def _trials(
    chain: Chain, records: Sequence[Record], options: Sequence[Option], entered: Sequence[Option]
) -> list[_Trial]:
    """All other options beside those that entered, in records that are corrected for these."""
    left = [o for o in options if o.cause not in [c.cause for c in entered]]
    every = [*entered, *left]
    current = _refined(chain, records, entered)[0] if entered else records
    at, parts = _columns(every), [sums(chain, r, every) for r in current]
    held = [c for places in at[: len(entered)] for c in places]
    trials = []
    for option, places in zip(left, at[len(entered) :], strict=True):
        p, z, inflation = _evidence(parts, held, places, option)
        gained = explained(parts, [*held, *places]) if p < LEVEL else 0.0
        trials.append(_Trial(option, gained, p, z, inflation))
    return trials


def _evidence(parts: Sequence[Sums], held: list[int], own: list[int], option: Option) -> tuple[float, float, float]:
    """p-value of an option beside what is held (of all records together, or of one among them), its z, and how far
    the blocks scatter beyond independent rows."""
    act, last = [*held, *own], list(range(len(held), len(held) + len(own)))
    whole = fit(parts, act)
    z = float(np.max(np.abs(whole.values[last]) / np.sqrt(np.maximum(np.diag(whole.covariance)[last], 1e-300))))
    inflation = float(np.max(whole.inflation[last]))
    groups = [list(parts), *([part] for part in parts if len(parts) > 1)]
    ps = [1.0]
    for group, tests in zip(groups, [1] + [len(parts)] * len(parts), strict=False):
        one = fit(group, act)
        clear = explained(group, act) - explained(group, held) > LEAST
        if clear and _possible(option, one, last):
            ps.append(tests * p_value(one, last))
    return min(ps), z, inflation


def _possible(option: Option, fit: BlockFit, places: Sequence[int]) -> bool:
    """Whether the first size is one that can be: no delay is negative."""
    value, (least, most) = fit.values[places[0]], option.effects[0].sizes
    return bool(least <= abs(value) <= most) and (not option.is_delay or bool(value > 0.0))


def _sized(chain: Chain, records: Sequence[Record], chosen: Sequence[Entered]) -> tuple[Sizes, ...]:
    """Sizes of the chosen options over all records, by Gauss-Newton steps, and by record, by one step more; where the
    records surely differ, from each of them alone."""
    if not chosen:
        return ()
    options = [option for option, _, _ in chosen]
    _, whole, each = _refined(chain, records, options)
    values, spread = _by_record(each)
    means = _means(values, spread, whole)
    if any(mean.p_equal < SURELY for mean in means):
        values, spread = _by_record([_alone(chain, record, options) for record in records])
        means = _means_of_records(values, spread)
    motions, out = [chain.motion(r) for r in records], []
    for entered, at in zip(chosen, _columns(options), strict=True):
        own = tuple(means[c] for c in at)
        material = _matters(motions, entered[0], values[:, at], spread[:, at], own)
        out.append(Sizes(*entered, values[:, at], spread[:, at], own, material))
    return tuple(out)


def _by_record(each: Sequence[BlockFit]) -> tuple[np.ndarray, np.ndarray]:
    """Values and standard errors (R, k) of the fits of records."""
    return np.stack([f.values for f in each]), np.stack([np.sqrt(np.diag(f.covariance)) for f in each])


def _alone(chain: Chain, record: Record, options: Sequence[Option]) -> BlockFit:
    """Sizes in one record, from that alone; nan, infinite spread for what it cannot tell by itself."""
    own = [o for o in options if _testable(o, chain, [record])]
    places = [c for o, at in zip(options, _columns(options), strict=True) if o in own for c in at]
    one = _refined(chain, [record], own)[1] if own else None
    return _among(sum(len(o.effects) for o in options), places, one)


def _among(count: int, places: list[int], one: BlockFit | None) -> BlockFit:
    """So many sizes of which a fit tells those at some places; nan, infinite spread for the others."""
    sizes, covariance = np.full(count, np.nan), np.diag(np.full(count, np.inf))
    if one is not None:
        sizes[places], covariance[np.ix_(places, places)] = one.values, one.covariance
    return BlockFit(sizes, covariance, BLOCKS, np.ones(count))


def _without_small(chain: Chain, records: Sequence[Record], sizes: tuple[Sizes, ...]) -> tuple[Sizes, ...]:
    """The sizes of what matters, estimated without what does not and is nearly collinear with it: that would move them
    by more than itself."""
    options, large = [s.option for s in sizes], [s for s in sizes if s.material]
    if not large or len(large) == len(sizes):
        return sizes
    spread = _refined(chain, records, options)[1].covariance
    size = np.sqrt(np.maximum(np.diag(spread), 1e-300))
    near = np.abs(spread / np.outer(size, size)) > COLLINEAR
    at = _columns(options)
    of_large = [c for s, places in zip(sizes, at, strict=True) if s.material for c in places]
    kept = [s for s, places in zip(sizes, at, strict=True) if s.material or not near[np.ix_(places, of_large)].any()]
    if len(kept) == len(sizes):
        return sizes
    by_option = {s.option: s for s in _sized(chain, records, [s[:3] for s in kept])}
    return tuple(by_option.get(s.option, s) for s in sizes)


def _matters(
    motions: Sequence[Motion], option: Option, values: np.ndarray, spread: np.ndarray, means: Sequence[Mean]
) -> bool:
    """Whether a mean size is clearly not zero and larger than its floor; or that of one record, of a cause that drifts,
    or where the others, more than half of all, have far smaller ones.

    Any other size whose sign differs between records is none of the instrument.
    """
    for k, (effect, mean) in enumerate(zip(option.effects, means, strict=True)):
        floor = np.array([effect.floor(m) for m in motions])
        if abs(mean.value) > np.median(floor) and mean.low * mean.high > 0.0:
            return True
        own = np.abs(values[:, k])
        clear = (own > floor) & (own > CERTAIN * spread[:, k])
        large = clear & (own > LARGE * floor)
        few = 0 < 2 * np.count_nonzero(large) < own.size and mean.p_equal < SURELY
        if few and LARGE * np.max(own[~large], initial=0.0) < np.min(own[large]):
            return True
        if np.any(clear) and mean.p_equal < DIFFERENT and option.cause.drifts:
            return True
    return False


def _means(values: np.ndarray, spread: np.ndarray, whole: BlockFit) -> list[Mean]:
    """Means over records of sizes (R, k): from all rows together where all are equal, else from each record's own.

    One size that differs between records bends what all rows together say of the others.
    """
    means = _means_of_records(values, spread)
    if any(mean.p_equal < DIFFERENT for mean in means):
        return means
    dof = max(whole.blocks - whole.values.size, 1)
    half = student_quantile(0.95, dof) * np.sqrt(np.diag(whole.covariance))
    return [
        Mean(float(v), float(v - h), float(v + h), mean.between, mean.p_equal)
        for v, h, mean in zip(whole.values, half, means, strict=True)
    ]


def _means_of_records(values: np.ndarray, spread: np.ndarray) -> list[Mean]:
    """Means of sizes (R, k) from each record's own."""
    known = np.isfinite(values)
    return [
        random_effects_mean(values[known[:, c], c], spread[known[:, c], c], dof=BLOCKS - 1)
        for c in range(values.shape[1])
    ]


def _refined(
    chain: Chain, records: Sequence[Record], chosen: Sequence[Option]
) -> tuple[list[Record], BlockFit, list[BlockFit]]:
    """The records corrected for common sizes of the chosen options, these sizes, and those of each record."""
    at = _columns(chosen)
    values = np.zeros(at[-1][-1] + 1)
    low, high = np.full(values.size, -np.inf), np.full(values.size, np.inf)
    for o, places in zip(chosen, at, strict=True):
        low[places] = 0.0 if o.is_delay else -0.9 if o.effects[0].unit == "1" else -np.inf
        if o.is_delay:
            high[places] = LATEST * min(float(np.ptp(r.time_s)) for r in records)
    current = list(records)
    for _ in range(STEPS):
        parts = [sums(chain, r, chosen) for r in current]
        step = fit(parts, range(values.size))
        before, values = values, np.clip(values + step.values, low, high)
        current = [corrected_for(r, chosen, values) for r in records]
    each = []
    for record, part in zip(records, parts, strict=True):
        own = [c for o, places in zip(chosen, at, strict=True) if _testable(o, chain, [record]) for c in places]
        each.append(_own(part, before, own))
    return current, step._replace(values=values), each


def _own(part: Sums, values: np.ndarray, columns: list[int]) -> BlockFit:
    """Sizes in one record from those of all by one step; nan, infinite spread for what it cannot tell by itself."""
    step = fit([part], columns) if columns else None
    return _among(values.size, columns, step and step._replace(values=values[columns] + step.values))


def corrected_for(record: Record, options: Sequence[Option], values: np.ndarray) -> Record:
    """A record with the errors of the options, of these sizes one after the other (k,), removed."""
    for option, places in zip(options, _columns(options), strict=True):
        if np.any(values[places] != 0.0):
            record = option.corrected_for(record, values[places])
    return record


def _told_instead(done: Compared, derived: Mapping[str, set[str]], later: Sequence[Chain]) -> Compared:
    """Heading against yaw rate with an error of the rate told as another one, else the same: the scale error as one of
    the clock, where this makes a scale error of the speed, which the later comparisons show, needless; the zero error
    as a heading that drifts, where positions agree clearly better with the heading without that."""
    for option in done.chain.instead:
        of_rate = [s for s in done.sizes if s.option.cause.id == option.cause.instead_of and s.material]
        if not of_rate:
            continue
        kept = tuple(o for o in done.chain.options if o.cause.id != option.cause.instead_of)
        other = _compared(done.chain._replace(options=(*kept, option)), done.records, derived)
        if not any(s.option == option and s.material for s in other.sizes):
            continue
        if option.cause.id == LoggerClock.id:
            is_better = _scales_speed(done, derived, later) and not _scales_speed(other, derived, later)
        else:
            is_better = _agree_better(other, done, derived, later)
        if is_better:
            return replace(other, chain=done.chain, tested=done.tested)
    return done


def _scales_speed(done: Compared, derived: Mapping[str, set[str]], later: Sequence[Chain]) -> bool:
    """Whether later comparisons show a scale error of the speed in the corrected records."""
    chains = ((chain, chain.taken(done.corrected)) for chain in later)
    sizes = (s for chain, records in chains for s in _compared(chain, records, derived).sizes)
    return any(s.option.cause.id == SpeedScaleError.id and s.material for s in sizes)


def _agree_better(one: Compared, other: Compared, derived: Mapping[str, set[str]], later: Sequence[Chain]) -> bool:
    """Whether later comparisons leave clearly less, beside all sensor errors, of records that the first comparison
    corrected than of those that the other one did: odds from TIE on, for as many rows as are independent."""
    lead = 0.0
    for chain in later:
        lefts, scatter, rows = [], 1.0, 0
        for done in (one, other):
            usable = [r for r in chain.taken(done.corrected) if not why_not(chain, r, derived.get(r.name, set()))]
            parts = [sums(chain, r, chain.options) for r in usable]
            if parts:
                every, rows = range(parts[0].score.shape[1]), sum(p.count for p in parts)
                scatter = max(scatter, float(np.max(fit(parts, every).inflation)))
                lefts.append(max(sum(p.square for p in parts) - explained(parts, every), 1e-300))
        lead += rows / scatter * float(np.log(lefts[1] / lefts[0])) if lefts else 0.0
    return lead > TIE


def _as_curve(chain: Chain, records: Sequence[Record], derived: Mapping[str, set[str]]) -> Compared:
    """Positions against velocities with errors whose sizes act together among the options, where the last of these
    matters and all together explain clearly more than any other error; else without them.

    Of more sizes they explain as much as a scale error in any record: only the tie without it makes them an error.
    """
    curves = chain.instead
    every = _compared(chain._replace(options=(*chain.options, *curves)), records, derived)
    if any(s.option in curves and s.material and not s.rivals for s in every.sizes):
        return every
    takes_part = any(option in curves for s in every.sizes for option in (s.option, *s.rivals))
    done = _compared(chain, records, derived) if takes_part or every.absurd else every
    return replace(done, chain=chain, tested=every.tested)


# ---- findings
def of_sizes(done: Compared) -> list[CheckFinding]:
    """Sensor errors that a comparison selected and no earlier one, those that matter first."""
    out = [_of_sizes(done, s) for s in done.new]
    return sorted(out, key=lambda f: not f.material)


def _of_sizes(done: Compared, s: Sizes) -> CheckFinding:
    names, sizes = [r.name for r in done.records], []
    for k, (effect, mean) in enumerate(zip(s.option.effects, s.means, strict=True)):
        sizes.append(Size(effect.parameter, mean.value, mean.low, mean.high, effect.unit))
        known = np.isfinite(s.each[:, k])
        sizes += [
            Size(effect.parameter, v, v - NORMAL_90 * sd, v + NORMAL_90 * sd, effect.unit, name)
            for v, sd, name in zip(
                s.each[known, k].tolist(), s.spread[known, k].tolist(), np.array(names)[known].tolist(), strict=True
            )
        ]
    entry, p_equal = s.option.cause, min(m.p_equal for m in s.means)
    differs = len(names) > 1 and any(m.p_equal < DIFFERENT and m.between > FAR * abs(m.value) for m in s.means)
    tied = [o.cause.id for o in s.rivals] + list(entry.track_rivals)
    of_records = f"of {len(names)} records" if len(names) > 1 else "of the record"
    said = f"{done.chain.title} {of_records}: {s.z:.1f} standard errors from zero"
    said += f"; late: {_channels(s)}" if s.option.is_delay else ""
    said += f"; scaled: {_channels(s)}" if entry.id == SpeedScaleError.id else ""
    said += f"; the records differ in size (p-value of equal ones {p_equal:.1g})" if differs else ""
    return CheckFinding(
        entry.id,
        "sensors",
        tuple(names),
        done.chain.needed,
        tuple(sizes),
        said,
        tuple(dict.fromkeys(tied)),
        entry.separate_by,
        s.material,
        s.z,
        p_equal if len(names) > 1 else None,
    )


def _channels(s: Sizes) -> str:
    """The channels that an error is of, in words."""
    slots = s.option.effects[0].instruments or (s.option.cause.id,)
    names = [slot.removesuffix("_delay").removesuffix("_scale").replace("_", " ") for slot in slots]
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
