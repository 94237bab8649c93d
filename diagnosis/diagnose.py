"""The whole chain: gross faults, base parameters, selection of causes, what stays unexplained, extension and gain."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..datasets.instruments import corrected
from ..methods.innovations.estimator import Estimator, Parameter, Setting
from ..methods.innovations.layout import OUTER
from ..models.errors import BadInput
from . import gain as gains
from . import hypotheses, kinematics, selection, unknown, verdict
from .attempts import ATTEMPTS
from .causes import CAUSES, testable
from .evidence import log_tail, together
from .extend import extended_model
from .flags import Flag, put_right
from .result import Diagnosis, Entry, Finding
from .search import SHARE_UNKNOWN, Candidate, Search, channel_name, covariance, mimicry
from .sizes import sizes_of

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

MOST_SPIKES = 2
PREDICTED, WORSE = ("heading_rad", "yaw_rate_rad_s"), 1.2
"""Channels by which the extended model is judged, and the ratio of its errors to the base model's that is too much."""
RIVALLED_NATS, RIVALLED_LEVEL = 30.0, 0.05
"""How near an unknown effect may come to what was named before its sizes are tested at a level of their own, and that
level: right names stand so near where effects are faint, and faint ones' small faults of description do not show."""


@dataclass(frozen=True)
class Options:
    """Choices of a diagnosis.

    base_parameters : 'file' takes the model's coefficients as known, 'identify' estimates them along; None: 'file'
        where the model carries coefficients.
    coefficient_sd : relative uncertainty of known coefficients, as a Gaussian prior (0: none).
    channels : record channels to use, None for all.
    max_effects : most causes that are named together.
    alpha : family-wise level of the whole run.
    only : causes that the bank is restricted to, None for all.
    """

    base_parameters: str | None = None
    coefficient_sd: float = 0.0
    channels: tuple[str, ...] | None = None
    max_effects: int = 3
    alpha: float = 0.01
    seed: int = 0
    only: tuple[str, ...] | None = None

    def checked(self, model: Model) -> Options:
        """The options with defaults for a model; BadInput for a value that cannot be."""
        base = self.base_parameters or ("file" if model.known else "identify")
        if base not in ("file", "identify"):
            raise BadInput(f"base parameters {base!r}", hint="file or identify")
        if base == "file" and not model.known:
            raise BadInput(f"model {model.id} carries no coefficients", hint="use --base-parameters identify")
        if not 0.0 < self.alpha < 0.5 or self.max_effects < 1 or self.coefficient_sd < 0.0:
            raise BadInput("alpha must lie in 0 .. 0.5, max effects be at least 1, coefficient sd at least 0")
        for name in self.only or ():
            if name not in CAUSES:
                raise BadInput(f"unknown cause {name!r}", hint="'helmbench list causes' shows all")
        return replace(self, base_parameters=base)


def diagnose(
    model: Model, train: Sequence[Record], held_out: Sequence[Record] = (), options: Options | None = None
) -> Diagnosis:
    """Show what the model gets wrong about training records, name the cause, and measure the gain on held-out ones.

    Parameters
    ----------
    model : base model; with coefficients unless they are to be identified.
    train, held_out : records in SI units; held-out records take no part in naming or fitting.

    Raises
    ------
    BadInput : for options that cannot be, or no training record.
    CannotFit : if a record lacks rudder, or heading and yaw rate.
    """
    options = (options or Options()).checked(model)
    if not train:
        raise BadInput("no training record", hint="give at least one")
    started = time.perf_counter(), time.process_time()
    rng = np.random.default_rng(options.seed)
    records, flags = put_right(prepared([*train, *held_out], model, options), model)
    tracks = kinematics.Tracks()
    if not {"v", "x", "y"} <= set(model.states):
        tracks = kinematics.compare(records[: len(train)], options.alpha, options.only)
        records = [corrected(r, dict(tracks.instruments)) for r in records]
    fitted, others = records[: len(train)], records[len(train) :]
    if options.base_parameters == "identify":
        model = identified(model, fitted)
    est = Estimator(model, fitted)
    search, cannot = _search(est, options, rng)
    poor = verdict.undecidable(est, search)
    if poor is None:
        selection.select(search, options.max_effects)
        left = _unexplained(search, options)
    else:
        left = None
    kept, final, measured, failing = _predicting(search, others, options, rng)
    if failing and left is None:
        said = f"{' and '.join(failing)}, or what looks like it here: held-out records are predicted worse with it"
        left = Candidate(f"unknown:{said}", (), 0.0, 0.0, search.setting, search.now)
    own = [_remarked(f) if f.cause in failing else f for f in _findings(search, rng)]
    findings = [*_flag_findings(flags), *tracks.findings, *_spike_findings(est), *own]
    extended = extended_model(est, final, [a.cause for a in kept.accepted], flags, tracks)
    said, reason = verdict.decide(poor, left, bool(search.accepted) and left is search.rival, findings)
    return Diagnosis(
        model=model,
        extended=extended,
        base_parameters=str(options.base_parameters),
        records=tuple([(r.name, "train") for r in train] + [(r.name, "held_out") for r in held_out]),
        alpha=options.alpha,
        seed=options.seed,
        verdict=said,
        reason=reason,
        causes=tuple(findings) if said != "inconclusive" else (),
        bank=_bank(search, cannot, flags, findings, dict(tracks.statistics)),
        gain=measured[0],
        hypothesis=_hypothesis(search, left, others),
        noise=_noise(est, search.setting),
        traces=measured[1],
        where=tuple(verdict.where(measured[1])),
        next_manoeuvre=verdict.next_manoeuvre(poor, findings),
        wall_s=time.perf_counter() - started[0],
        cpu_s=time.process_time() - started[1],
    )


def prepared(records: Sequence[Record], model: Model, options: Options) -> list[Record]:
    """Records in the model's rudder sign, behind its instruments, with the chosen channels only."""
    from ..datasets.record import RUDDERS

    out = []
    for record in records:
        turned = corrected(record.turned(model.positive_rudder), model.instruments)
        if options.channels is not None:
            kept = {*options.channels, *RUDDERS, "propeller_rps"}
            turned = replace(turned, channels={k: v for k, v in turned.channels.items() if k in kept})
        out.append(turned)
    return out


def identified(model: Model, records: Sequence[Record]) -> Model:
    """The model with coefficients that an output-error fit to the records gives."""
    from ..methods.registry import make

    return make("output-error").fit(records, model.blanked()).model


def _search(est: Estimator, options: Options, rng: np.random.Generator) -> tuple[Search, dict[str, str]]:
    bank, cannot = testable(est)
    if options.only is not None:
        cannot |= dict.fromkeys(set(bank) - set(options.only), "left out")
        bank = {name: bank[name] for name in options.only if name in bank}
    start = est.start()
    nuisance, prior = _free_coefficients(est, options)
    speed = _reference_speed(est)
    nuisance, prior = (*nuisance, *speed), None if prior is None else np.append(prior, np.zeros(len(speed)))
    search = Search(est, start, start, est.evaluate(start), bank, rng, options.alpha, nuisance, prior)
    return search, cannot


def _reference_speed(est: Estimator) -> tuple[Parameter, ...]:
    """The speed U0 against which a response model's surge shows a loss: estimated along."""
    if "speed_loss_state" not in est.kernels.STATES or not est.channels[2]:
        return ()
    return (Parameter("U0", "m/s", ((est.index["bias_u"], 1.0), (est.index["scale_u"], -1.0)), scale=1e-3),)


def _free_coefficients(est: Estimator, options: Options) -> tuple[tuple[Parameter, ...], np.ndarray | None]:
    """Coefficients that are estimated along, with the precisions of their prior."""
    model = est.model
    if options.base_parameters == "file" and options.coefficient_sd == 0.0:
        return (), None
    found = []
    for name, value in zip(model.coordinates, model.coefficients, strict=True):
        if value != 0.0:
            found.append(Parameter(name, "", ((est.index[name], abs(value)),), scale=1e-3))
    if options.base_parameters == "identify":
        return tuple(found), None
    return tuple(found), np.full(len(found), options.coefficient_sd**-2.0)


def _unexplained(search: Search, options: Options) -> Candidate | None:
    """An effect outside the bank that the innovations still ask for, or that alone beats all that was named.

    What an unknown effect comes near to must be the same throughout the records at a level of its own.
    """
    threshold = np.log(options.alpha * SHARE_UNKNOWN)
    found = hypotheses.best_unknown(search, threshold) if search.accepted else search.rival
    if found is not None:
        return found
    lead = hypotheses.lead(search)
    if lead < 0.0:
        return search.rival
    sizes = selection.size_tests(search)
    if lead < RIVALLED_NATS and sizes:
        log_p = together([p for _, p in sizes])
        if log_p < np.log(RIVALLED_LEVEL):
            return _untold(search, _smallest(sizes)[0], log_p)
    line = unknown.line_test(search.est, search.now)
    label, log_p = _smallest(
        [
            *unknown.activity_tests(search.est, search.now),
            *unknown.whiteness_tests(search.est, search.now),
            *sizes,
            (f"a line at {line[1]:.3g} rad/s", line[0]),
        ]
    )
    return _untold(search, label, log_p) if log_p < min(threshold, -0.5 * mimicry(search).sum()) else None


def _smallest(tests: Sequence[tuple[str, float]]) -> tuple[str, float]:
    """Label of the most significant test, and its log p-value, their number taken into account."""
    label, log_p = min(tests, key=lambda t: t[1])
    return label, log_p + float(np.log(len(tests)))


def _untold(search: Search, label: str, log_p: float) -> Candidate:
    """An effect that shows in a test and has no form of its own."""
    return Candidate(f"unknown:{label}", (), log_p, -2.0 * log_p, search.setting, search.now)


# ---- findings
def _flag_findings(flags: Sequence[Flag]) -> list[Finding]:
    return [
        Finding(
            f.cause,
            (),
            "kinematics",
            f.statistic,
            float(np.exp(max(log_tail(f.statistic, 1), -700.0))),
            (),
            details=f.details,
            evidence=f.evidence,
        )
        for f in flags
    ]


def _spike_findings(est: Estimator) -> list[Finding]:
    """Outliers: more isolated samples far from their neighbours than sensors' noise gives."""
    spikes, count = sum(d.spikes for d in est.data), est.n_values
    if spikes <= MOST_SPIKES or spikes <= sum(d.near_spikes for d in est.data):
        return []
    from .result import Size

    share = spikes / max(count + spikes, 1)
    half = 1.645 * np.sqrt(share * (1.0 - share) / max(count, 1))
    size = Size("share", share, max(share - half, 0.0), share + half, "1")
    said = f"{spikes} of {count + spikes} samples stand more than 6.5 standard deviations off their neighbours"
    return [Finding("outliers", (), "kinematics", float(spikes), 1e-6, (size,), evidence=said)]


def _findings(search: Search, rng: np.random.Generator) -> list[Finding]:
    est, spread = search.est, covariance(search)
    at = len(search.nuisance)
    found = []
    for a in search.accepted:
        k = len(a.variant)
        block = spread[at : at + k, at : at + k]
        at += k
        sizes = sizes_of(est, search.setting, a.cause, a.variant, block, rng)
        adjusted = float(min(1.0, np.exp(a.log_p + np.log(search.n_effective))))
        ties = search.ties.get(a.cause, ())
        details = _details(a)
        found.append(
            Finding(
                a.cause,
                ties,
                "dynamics",
                a.statistic,
                adjusted,
                sizes,
                details=details,
                evidence=_evidence(a, search.n_effective),
                separate_by=CAUSES[a.cause].separate_by if ties else None,
            )
        )
    return sorted(found, key=lambda f: -f.statistic)


def _details(a: Candidate) -> dict[str, Any]:
    if a.cause == "coefficient_shift":
        return {"coefficient": a.variant[0].name.partition(":")[2]}
    if a.cause in ("constant_force", "crossflow_coupling"):
        return {"components": [p.name for p in a.variant]}
    if a.cause == "velocity_delay":
        return {"late": "surge, sway, yaw rate and heading" if len(a.variant[0].slots) > 2 else "surge and sway"}
    return {}


def _evidence(a: Candidate, tests: float) -> str:
    k = max(len(a.variant), 1)
    said = (
        f"twice the log likelihood, less the cost of gusts, rises by {a.statistic:.1f} for {k} "
        f"parameter{'s' if k > 1 else ''}, noise refitted (about {tests:.0f} independent tests)"
    )
    if a.cause in ATTEMPTS or a.cause == "rudder_fault" or CAUSES[a.cause].scan or CAUSES[a.cause].profile:
        said += f"; its values count as {a.tests:.1f} by bootstrap, the recorded rudder used again"
    return said


def _bank(
    search: Search,
    cannot: dict[str, str],
    flags: Sequence[Flag],
    findings: Sequence[Finding],
    tracks: Mapping[str, float],
) -> tuple[Entry, ...]:
    """One line for every cause of the taxonomy."""
    named = {f.cause: f for f in findings}
    tied = {t: f for f in findings for t in f.tied_with}
    first = {c.cause: c for c in search.first_candidates}
    out = []
    for name in [*CAUSES, *(f.cause for f in flags if f.cause not in CAUSES), "outliers"]:
        screened = search.first_screen.get(name)
        candidate = first.get(name)
        statistic = candidate.statistic if candidate else (screened.score.statistic if screened else None)
        log_p = candidate.log_p if candidate else (screened.log_p if screened else 0.0)
        adjusted = float(min(1.0, np.exp(log_p + np.log(search.n_effective)))) if statistic is not None else None
        power = verdict.power(search, name)
        if name in named:
            status, why = ("tied" if named[name].tied_with else "named"), named[name].evidence
            statistic, adjusted = named[name].statistic, named[name].p_adjusted
        elif name in tied:
            status, why = "tied", f"cannot be told from {tied[name].cause} on these records"
        elif name in tracks:
            statistic, adjusted = tracks[name], float(min(1.0, len(tracks) * np.exp(log_tail(tracks[name], 1))))
            status, why = "not_significant", "heading, log and positions agree without it"
        elif name in cannot:
            status, why = "not_testable", cannot[name]
        elif name in search.in_span:
            status, why = (
                "not_testable",
                "the free coefficients of the base model, or nothing that was measured, can show it",
            )
        elif adjusted is not None and adjusted < search.alpha and search.accepted:
            status, why = "explained_by", f"significant alone, not beside {search.accepted[0].cause}"
        else:
            status, why = "not_significant", "the innovations do not ask for it"
        out.append(Entry(name, status, statistic, adjusted, power, why))
    return tuple(out)


def _remarked(f: Finding) -> Finding:
    return replace(
        f, evidence=f"{f.evidence}; left out of the extended model, which predicts held-out records worse with it"
    )


# ---- gain
def _predicting(search: Search, others: Sequence[Record], options: Options, rng: np.random.Generator):
    """The search without the last causes as long as they make free runs of held-out records worse than the base model.

    Returns it, its setting for simulation, the gain with the traces, and the causes that were left out.
    """
    failing: list[str] = []
    while True:
        final = _simulating(search, options)
        measured = _gain(search, final, others, options, rng)
        ratios = [measured[0][c].rmse_after / measured[0][c].rmse_before for c in PREDICTED if c in measured[0]]
        bad = bool(ratios) and not any(ratio <= WORSE for ratio in ratios)
        if not bad or not search.accepted or not search.accepted[-1].variant:
            return search, final, measured, failing
        failing.append(search.accepted[-1].cause)
        search = selection.without(search, search.accepted[-1])


def _simulating(search: Search, options: Options) -> Setting:
    """The setting that the extended model is simulated at: free coefficients are fitted to free runs."""
    if options.base_parameters != "identify":
        return search.setting
    index = search.est.index
    sensors = {index[name] for name in OUTER if name.startswith(("scale_", "bias_", "delay_", "misalignment"))}
    moved = [p for p in search.parameters if not {i for i, _ in p.slots} & sensors]
    return gains.fitted_to_simulate(search.est, search.setting, moved)


def _gain(search: Search, final: Setting, records: Sequence[Record], options: Options, rng: np.random.Generator):
    """Gain on the held-out records, and the traces that the page shows."""
    est = search.est
    base = _base_setting(search, options)
    per_record = [p for a in search.accepted for p in a.variant if p.record is not None and a.cause != "rudder_fault"]
    fitted = [gains.free_runs(est, s) for s in (base, final)]
    shown = gains.traces(est, "train", fitted[0], fitted[1], gains.scored_from(est, False))
    if not records:
        return {}, shown
    held = Estimator(est.model, records, est.unit)
    held.rudder_sd, held.base = est.rudder_sd, est.base
    after = gains.transferred(held, final, [p for a in search.accepted for p in a.variant if p.record is not None])
    after = gains.adapted(held, after, tuple(per_record))
    before = gains.transferred(held, base, ())
    starts = gains.scored_from(held, bool(per_record))
    old, new = gains.free_runs(held, before), gains.free_runs(held, after)
    noise = search.setting.noise
    return gains.gains(held, old, new, starts, noise, rng), (*shown, *gains.traces(held, "held_out", old, new, starts))


def _base_setting(search: Search, options: Options) -> Setting:
    """The base model without causes: its coefficients refitted where they are free."""
    est = search.est
    if not search.nuisance:
        return replace(est.start(), noise=search.setting.noise)
    bare = replace(search, accepted=[], setting=est.start())
    s, _ = bare.refit(replace(est.start(), noise=search.setting.noise), (), 6)
    return gains.fitted_to_simulate(est, s, search.nuisance) if options.base_parameters == "identify" else s


def _hypothesis(search: Search, left: Candidate | None, records: Sequence[Record]) -> dict[str, Any] | None:
    """The sparse term that fits an unexplained effect best, and whether held-out records confirm it."""
    if left is None:
        return None
    est = search.est
    terms = []
    for p in left.variant:
        assert p.series is not None
        axis = p.series[0]
        names = ("X", "Y", "N") if est.n_forces == 3 else ("N", "N rate")
        where = names[axis] if axis < est.n_forces else f"channel {channel_name(axis - est.n_forces)}"
        terms.append({"term": p.name.rpartition(":")[0], "acts_on": where, "size": est.value(left.setting, p)})
    confirmed = hypotheses.confirmed(search, left, records) if left.variant and records else None
    return {
        "hypothesis": left.cause.removeprefix("unknown:"),
        "terms": terms,
        "log_p": left.log_p,
        "confirmed_on_held_out": confirmed,
    }


def _noise(est: Estimator, s: Setting) -> dict[str, Any]:
    names = [channel_name(c) for c in range(6)]
    nf = est.n_forces
    return {
        "sensor_sd": {names[c]: float(s.noise[c]) for c in np.flatnonzero(est.channels)},
        "force_sd": (s.noise[6 : 6 + nf] * est.unit).tolist(),
        "correlation_time_s": float(s.noise[6 + nf]),
        "rudder_sd": est.rudder_sd,
    }
