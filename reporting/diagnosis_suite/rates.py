"""Rates over the cases of a diagnosis suite, with their numbers and 95 % binomial intervals (Clopper and Pearson 1934).

`build` works on the stored tables alone.  A failed case counts against every rate that it belongs to.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ...bench.kinds.diagnosis.bases import EXACT, UNSTATED
from ...bench.kinds.diagnosis.plan import ONE_BUG, ORACLE, PLANTED, REGIME

Frame: TypeAlias = Any
"""pandas frames, which are imported only where they are made."""
LEVEL = 0.95
RATE_COLUMNS = ["method", "scope", "group", "rate", "title", "n", "hits", "value", "low", "high", "target", "met"]
GAIN_CHANNELS = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s")
"""Channels whose errors make the gain; positions drift and are stored only."""
CASE = ["group", "vessel", "injected", "strength", "gusts", "seed"]
SCOPES = ("vessel", "gusts", "strength", "injected", "base", "records")
FOUND = ("alone", "tie")
LATER = ("regime_true", "regime_named", "regime_f1", "healthy_bias", "names", "false_names", "described")
LATER = (*LATER, "right_variable")
"""Columns that old stores do not have."""
WORSE = 1.05
"""Ratio of errors that an extended model may not exceed."""
CLOSE = 1.3
"""Largest ratio of errors to the oracle's, in any channel, that counts as close to it."""
CLOSE_F1 = 0.8
"""F1 score of samples from which a regime counts as located."""
FDR = 0.05
"""Largest share of names that may be false."""
HEALTHY = 0.1
"""Largest error of numbers that are right, in prior standard deviations."""
POWER_EDGES = (1.0, 3.0, 10.0, 30.0, 60.0, 120.0, 400.0, 800.0, 4e3, 1e4)
"""Non-centralities between which the power curves count."""


Test: TypeAlias = Callable[[Frame], Frame]
"""Which rows of a frame it holds for, (N,) truth values."""


@dataclass(frozen=True)
class Rate:
    """A rate that is reported: which cases, what counts, and what the design asks for."""

    id: str
    title: str
    cases: Test
    hit: Test
    target: float
    at_least: bool = True


def _is(column: str, *values: Any) -> Test:
    return lambda frame: frame[column].isin(values)


_null, _pair, _effects = _is("group", "null"), _is("group", "pair"), _is("group", "injected", "pair")
_one_bug, _regime, _planted = _is("group", ONE_BUG), _is("group", REGIME), _is("group", PLANTED)
_alone, _named, _in_some_finding = _is("outcome", "alone"), _is("outcome", *FOUND), _is("outcome", *FOUND, "among")
_both, _unexplained, _adequate = _is("outcome", "both"), _is("outcome", "unexplained"), _is("outcome", "adequate")
_unstated, _wrong = _is("base", UNSTATED), _is("confident_wrong", True)


def _all(*tests: Test) -> Test:
    return lambda frame: np.logical_and.reduce([test(frame) for test in tests])


def _not(test: Test) -> Test:
    return lambda frame: ~test(frame)


def _has(column: str) -> Test:
    return lambda frame: frame[column].notna()


def _up_to(column: str, most: float) -> Test:
    return lambda frame: frame[column] <= most


def _detectable(frame: Frame) -> Frame:
    return (frame["group"] == "injected") & frame["detectable"].eq(True)


def _exact(frame: Frame) -> Frame:
    return frame["base"].fillna(EXACT) == EXACT  # stores from before bases were drawn hold none


_nameable = _all(_detectable, _not(_exact), _is("outcome_oracle", *FOUND))
"""Effects beside an imperfect base that the oracle names."""
_beside = _all(_is("group", "injected"), _not(_exact), _has("gain_worst"))
"""Effects beside an imperfect base, with the oracle's errors."""
_null_unstated, _null_beside = _all(_null, _unstated), _all(_null, _not(_exact), _not(_unstated))
_known_variable = _all(_is("strength", "largest"), _has("right_variable"), _is("group", "anticipated"))
"""Unknown effects of the largest size whose variable is known."""


def _null_in(gusts: str) -> Test:
    return _all(_null, _is("gusts", gusts), _exact)


def _of(group: str, calm: bool) -> Test:
    return lambda frame: (frame["group"] == group) & ((frame["gusts"] == "none") == calm)


def _located(frame: Frame) -> Frame:
    """Cases of a regime that occurs in the records."""
    return _regime(frame) & (frame["regime_f1"].notna() | (frame["status"] == "failed"))


def _near(frame: Frame) -> Frame:
    return frame["regime_f1"] >= CLOSE_F1


def _healthy(frame: Frame) -> Frame:
    """Wrong numbers and regimes, where the other numbers have priors."""
    return (_regime(frame) | _one_bug(frame)) & frame["healthy_bias"].notna()


def _described(frame: Frame) -> Frame:
    return frame["described"].fillna("") != ""


def _further(frame: Frame) -> Frame:
    """Also cases of stores that do not count them: none."""
    return frame.get("extra_names", frame["tie_size"] * 0).fillna(0) > 0


def _worse(frame: Frame) -> Frame:
    return _above_the_base(frame, "after")


def _above_the_base(frame: Frame, which: str) -> Frame:
    """Cases whose held-out error is more than WORSE times the base model's in some channel."""
    ratios = [frame[f"rmse_{which}_{channel}"] / frame[f"rmse_before_{channel}"] for channel in GAIN_CHANNELS]
    return np.logical_or.reduce([ratio > WORSE for ratio in ratios])


def _halved(frame: Frame) -> Frame:
    return _squared(frame, "after") <= 0.25 * _squared(frame, "before")


def _squared(frame: Frame, which: str) -> Frame:
    """Squared held-out error, in units of the true ship's, which is the noise of the sensors; the sum over channels."""
    known = [c for c in GAIN_CHANNELS if f"rmse_truth_{c}" in frame]
    ratios = [frame[f"rmse_{which}_{c}"].astype(float) / frame[f"rmse_truth_{c}"].astype(float) for c in known]
    return np.nansum(np.square(ratios), axis=0)


def _predictable(frame: Frame) -> Frame:
    """Effects under which the true ship itself, without gusts, is not worse than the base model; none in stores that
    do not hold its errors."""
    if "rmse_truth_heading_rad" not in frame:
        return frame["seed"].isna()
    return _effects(frame) & frame["rmse_truth_heading_rad"].notna() & ~_above_the_base(frame, "truth")


NAMED = "true cause first or in its tie"
BUG_WORSE = "one wrong number: held-out error above 1.05 of the base in some channel"
CLOSE_BESIDE = f"held-out error within {CLOSE} of the oracle's in every channel, imperfect base"
HALVED = "... whose held-out error is halved (of all channels, each in units of the true ship's)"
RIGHT_VARIABLE = "unknowns of the largest size described by the right variable"
UNTOLD = "correct base, not told so: verdict other than adequate"
STAYS = "numbers that are right stay within .1 of their prior standard deviation (rms)"
VERDICT = "verdict named or tied where nothing but the wrong number is named"
_only_bug, _false = _all(_one_bug, _alone), _not(_adequate)
_no_regime, _regime_named = _all(_not(_regime), _has("regime_true")), _not(_is("regime_named", ""))
RATES = (
    Rate("named", f"{NAMED} (detectable)", _detectable, _named, 0.97),
    Rate("alone", "... by itself", _detectable, _alone, 0.0),
    Rate("false_clean", "false alarms, clean", _null_in("none"), _false, 0.02, False),
    Rate("false_fast", "false alarms, fast gusts", _null_in("fast"), _false, 0.03, False),
    Rate("false_slow", "false alarms, slow gusts", _null_in("slow"), _false, 0.03, False),
    Rate("wrong", "wrong names without a tie", _effects, _wrong, 0.02, False),
    Rate("anticipated_clean", "anticipated unknowns unexplained, clean", _of("anticipated", True), _unexplained, 0.95),
    Rate("anticipated_gusty", "anticipated unknowns unexplained, gusts", _of("anticipated", False), _unexplained, 0.70),
    Rate("unforeseen_clean", "unforeseen unknowns unexplained, clean", _of("unforeseen", True), _unexplained, 0.70),
    Rate("right_variable", RIGHT_VARIABLE, _known_variable, _is("right_variable", True), 0.80),
    Rate("halved", HALVED, _known_variable, _halved, 0.0),
    Rate("described", "something is described where nothing is, gusts or none", _null, _described, 0.02, False),
    Rate("extra", "runs with a further name that is none of the hull's", _effects, _further, 0.05, False),
    Rate("named_beside", f"{NAMED} (imperfect base; the oracle names it)", _nameable, _named, 0.92),
    Rate(
        "false_beside", "a name that is none of the hull's, clean, imperfect base", _null_beside, _further, 0.02, False
    ),
    Rate("close_beside", CLOSE_BESIDE, _beside, _up_to("gain_worst", CLOSE), 0.90),
    Rate("worse", "held-out error above 1.05 of the base in some channel", _effects, _worse, 0.0, False),
    Rate("worse_than_possible", "... where the true ship without gusts is not", _predictable, _worse, 0.0, False),
    Rate("bug_alone", "one wrong number: its group or cause is all that is named", _one_bug, _alone, 0.80),
    Rate("bug_tie", "... or tied with others", _one_bug, _named, 0.0),
    Rate("bug_among", "... or among other findings", _one_bug, _in_some_finding, 0.90),
    Rate("bug_verdict", VERDICT, _only_bug, _is("verdict", "named", "tied"), 0.95),
    Rate("bug_worse", BUG_WORSE, _one_bug, _worse, 0.0, False),
    Rate("false_unstated", UNTOLD, _null_unstated, _false, 0.02, False),
    Rate("regime_alone", "fault in a regime: its group or cause is all that is named", _regime, _alone, 0.0),
    Rate("regime_among", "... or tied, or among other findings", _regime, _in_some_finding, 0.90),
    Rate("regime_f1", "fault in a regime: samples located with F1 >= .8", _located, _near, 0.80),
    Rate("regime_false", "a regime is stated where there is none", _no_regime, _regime_named, 0.05, False),
    Rate("healthy", STAYS, _healthy, _up_to("healthy_bias", HEALTHY), 0.90),
    Rate("planted", "planted nulls of which something is named", _planted, _not(_is("names", 0)), 0.05, False),
    Rate("both", "both causes of a pair named", _pair, _both, 0.90),
)


@dataclass(frozen=True)
class Board:
    """Aggregated results, each a pandas frame.

    rates: method, scope, group, rate, title, n, hits, value, low, high, target, met; scope `all` or one of SCOPES.
    figures: method, figure, title, n, value, low, high, target, met. confusion: counts of (method, injected,
    named). power: method, gusts, low, high (of the non-centrality), middle, n, hits, value. sizes: coverage by
    method and cause. failures: what failed or did not apply.
    """

    rates: Frame
    figures: Frame
    confusion: Frame
    power: Frame
    sizes: Frame
    failures: Frame

    def table(self) -> Frame:
        """Rates and figures in one table, as `diagnosis.csv` holds them."""
        import pandas as pd

        figures = self.figures.rename(columns={"figure": "rate"}).assign(scope="all", group="all")
        return pd.concat([self.rates, figures]).reindex(columns=RATE_COLUMNS)


def build(cases: Frame, sizes: Frame) -> Board:
    """The board of one results store (frames as `store.read_tables` gives them)."""
    own = with_gain(cases)
    return Board(
        rates=rate_table(own),
        figures=figure_table(own, sizes),
        confusion=confusion(own),
        power=power_curves(own),
        sizes=coverage(sizes),
        failures=failures(own),
    )


def with_gain(cases: Frame) -> Frame:
    """Rows of the diagnosers, with what the oracle reached on the same case.

    outcome_oracle : its outcome.  gain_ratio, gain_worst : held-out error after over the oracle's, geometric mean and
    largest of the channels.
    """
    cases = cases.reindex(columns=[*cases, *(name for name in LATER if name not in cases)])
    told = cases["method"] == ORACLE
    after = [f"rmse_after_{channel}" for channel in GAIN_CHANNELS]
    oracle = cases[told & (cases["status"] == "ok")][[*CASE, "outcome", *after]]
    own = cases[~told].merge(oracle, on=CASE, how="left", suffixes=("", "_oracle"))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.log(
            np.column_stack([own[name].astype(float) / own[f"{name}_oracle"].astype(float) for name in after])
        )
    known = ~np.isnan(ratios)
    mean = np.where(known, ratios, 0.0).sum(axis=1) / np.maximum(known.sum(axis=1), 1)
    own["gain_ratio"] = np.where(known.any(axis=1), np.exp(mean), np.nan)
    own["gain_worst"] = np.where(known.any(axis=1), np.exp(np.where(known, ratios, -np.inf).max(axis=1)), np.nan)
    return own.drop(columns=[f"{name}_oracle" for name in after])


def rate_table(cases: Frame) -> Frame:
    """Every rate of every method, over all cases and by what they have in common."""
    import pandas as pd

    rows = []
    for method, own in _judged(cases).groupby("method", sort=True):
        for rate in RATES:
            chosen = own[rate.cases(own)]
            rows.append(_rate_row(method, "all", "all", rate, chosen))
            for scope in (scope for scope in SCOPES if scope in chosen):
                for group, part in chosen.groupby(scope, sort=True):
                    rows.append(_rate_row(method, scope, group, rate, part))
    return pd.DataFrame([row for row in rows if row["n"]], columns=RATE_COLUMNS)


def _judged(cases: Frame) -> Frame:
    """Cases that ran; what did not apply is left out, what failed counts as missed."""
    return cases[cases["status"] != "not_applicable"]


def _rate_row(method: Any, scope: str, group: Any, rate: Rate, cases: Frame) -> dict[str, Any]:
    n, hits = len(cases), int(rate.hit(cases).sum()) if len(cases) else 0
    low, high = binomial_interval(hits, n)
    value = hits / n if n else np.nan
    met = value >= rate.target if rate.at_least else value <= rate.target
    facts = (method, scope, group, rate.id, rate.title, n, hits, value, low, high, rate.target, met)
    return dict(zip(RATE_COLUMNS, facts, strict=True)) | ({"target": np.nan, "met": None} if not rate.target else {})


def binomial_interval(hits: int, n: int, level: float = LEVEL) -> tuple[float, float]:
    """Clopper-Pearson interval of a rate; (nan, nan) where n = 0."""
    from scipy.stats import binomtest

    if n == 0:
        return np.nan, np.nan
    found = binomtest(hits, n).proportion_ci(level, method="exact")
    return float(found.low), float(found.high)


FIGURE_COLUMNS = ["figure", "title", "n", "hits", "value", "low", "high", "target", "met"]


def figure_table(cases: Frame, sizes: Frame) -> Frame:
    """What is no rate of cases: tie size, coverage, gain, time."""
    import pandas as pd

    rows = []
    for method, own in cases[cases["status"] == "ok"].groupby("method", sort=True):
        covered = sizes[sizes["method"] == method]["covered"]
        figures = [dict(zip(FIGURE_COLUMNS, row, strict=True)) for row in _figures(own, covered)]
        rows += [{"method": method} | row for row in figures if row["n"]]
    return pd.DataFrame(rows, columns=["method", *FIGURE_COLUMNS])


def _figures(own: Frame, covered: Frame) -> list[tuple[Any, ...]]:
    """Rows of `FIGURE_COLUMNS`."""
    ties = own[_detectable(own) & _named(own)]["tie_size"].astype(float)
    ratio = own[_detectable(own)]["gain_ratio"].dropna().to_numpy(float)
    f1 = own["regime_f1"].dropna().to_numpy(float)
    wall, cpu = (own[name].dropna().to_numpy(float) for name in ("wall_s", "cpu_s"))
    return [
        _mean_row(ties),
        _share_row("coverage", "sizes inside their 90 % intervals", covered, (0.85, 0.95)),
        _spread_row("gain_median", "held-out error over the oracle's, median (5-95 % of cases)", ratio, 1.15),
        _share_row("gain_close", "... share of cases within 1.15", ratio <= 1.15),
        _false_discovery_row(own[own["names"].notna()]),
        _spread_row("regime_f1_median", "F1 of samples located in a regime, median (5-95 % of cases)", f1),
        _spread_row("wall_s", "wall time of a diagnosis, s, median (5-95 % of cases)", wall),
        _spread_row("cpu_s", "CPU time of a diagnosis, s, median (5-95 % of cases)", cpu),
    ]


def _mean_row(ties: Frame) -> tuple[Any, ...]:
    """Mean tie size with a normal interval."""
    n, mean = len(ties), float(ties.mean()) if len(ties) else np.nan
    half = 1.96 * float(ties.std()) / np.sqrt(n) if n > 1 else np.nan
    title = "mean tie size (detectable, named)"
    return "tie_size", title, n, None, mean, mean - half, mean + half, "1.3", mean <= 1.3


def _false_discovery_row(cases: Frame) -> tuple[Any, ...]:
    """False discovery rate: mean over the cases of the share of names that are false, 0 where nothing is stated.

    The interval is that of Clopper and Pearson for the same mean: no variable in 0 .. 1 has a larger variance.
    """
    from scipy.stats import beta

    n = len(cases)
    total = float((cases["false_names"] / cases["names"].clip(lower=1)).sum())
    low, high = beta.ppf([0.025, 0.975], [total, total + 1.0], [n - total + 1.0, n - total]) if n else (np.nan, np.nan)
    low, high = (0.0 if total == 0.0 else float(low)), (1.0 if total == n else float(high))
    value = total / n if n else np.nan
    title = "false discovery rate (share of names that are false, mean of cases)"
    return "false_discovery", title, n, None, value, low, high, f"{FDR:g}", value <= FDR


def _share_row(name: str, title: str, hit: Any, asked: tuple[float, float] | None = None) -> tuple[Any, ...]:
    n, hits = len(hit), int(np.sum(hit))
    value = hits / n if n else np.nan
    target = None if asked is None else f"{100 * asked[0]:.0f}-{100 * asked[1]:.0f} %"
    met = None if asked is None else asked[0] <= value <= asked[1]
    return name, title, n, hits, value, *binomial_interval(hits, n), target, met


def _spread_row(name: str, title: str, values: np.ndarray, most: float | None = None) -> tuple[Any, ...]:
    """Median and the 5 and 95 % quantiles."""
    quantiles = np.quantile(values, [0.05, 0.5, 0.95], method="median_unbiased") if values.size else [np.nan] * 3
    low, middle, high = map(float, quantiles)
    target, met = (None, None) if most is None else (f"{most:g}", middle <= most)
    return name, title, values.size, None, middle, low, high, target, met


def confusion(cases: Frame) -> Frame:
    """What was named for what was injected: method, injected, named, cases.

    Detectable single causes, wrong numbers, unknown effects (by group) and clean records; a tie that holds the truth
    counts as the truth, else the best member of the first finding; `adequate` and `unexplained` where that is all that
    was said.
    """
    chosen = cases[(cases["status"] == "ok") & (cases["group"] != "pair")]
    chosen = chosen[(chosen["group"] != "injected") | _detectable(chosen)]
    injected = chosen["injected"].where(chosen["group"] == "injected", "(" + chosen["group"] + ")")
    injected = injected.where(~_one_bug(chosen), chosen["base"]).where(~_regime(chosen), chosen["injected"])
    table = chosen.assign(injected=injected, named=[_said(row) for row in chosen.to_dict("records")])
    return table.groupby(["method", "injected", "named"], sort=True).size().rename("cases").reset_index()


def _said(row: dict[str, Any]) -> str:
    if row["outcome"] in FOUND:
        return row["injected"] or row["base"]
    if row["outcome"] == "unexplained" or not row["named"]:
        return f"({row['verdict']})"
    return row["named"].split("+")[0].split("/")[0]


def power_curves(cases: Frame) -> Frame:
    """Share of cases with one injected effect in which the truth was first or in its tie, over the non-centrality."""
    import pandas as pd

    chosen = _judged(cases)
    chosen = chosen[(chosen["group"] == "injected") & np.isfinite(chosen["noncentrality"].astype(float))]
    rows = []
    for (method, calm), own in chosen.groupby(["method", chosen["gusts"] == "none"], sort=True):
        size = own["noncentrality"].astype(float)
        for low, high in zip(POWER_EDGES, (*POWER_EDGES[1:], np.inf), strict=True):
            part = own[(size >= low) & (size < high)]
            if len(part):
                hits = int(_named(part).sum())
                bounds = binomial_interval(hits, len(part))
                middle = float(np.exp(np.log(part["noncentrality"].astype(float)).mean()))
                rows.append(
                    [method, "calm" if calm else "gusts", low, high, middle, len(part), hits, hits / len(part), *bounds]
                )
    names = ["method", "weather", "from", "to", "middle", "n", "hits", "value", "low", "high"]
    return pd.DataFrame(rows, columns=names)


def coverage(sizes: Frame) -> Frame:
    """Coverage of the stated intervals and median error by method and cause."""
    groups = sizes.groupby(["method", "cause"], sort=True)
    table = groups.agg(n=("covered", "size"), hits=("covered", "sum"), error=("rel_error", "median")).reset_index()
    table["value"] = table["hits"].astype(float) / table["n"]
    bounds = [binomial_interval(int(hits), int(n)) for hits, n in zip(table["hits"], table["n"], strict=True)]
    return table.assign(low=[low for low, _ in bounds], high=[high for _, high in bounds])


def failures(cases: Frame) -> Frame:
    """Reasons why cases failed or did not apply, with their number and one seed by which to repeat them."""
    told = cases[cases["status"] != "ok"]
    keys = ["status", "method", "group", "vessel", "injected", "error"]
    groups = told.assign(error=told["error"].fillna("")).groupby(keys, sort=True)["seed"]
    return groups.agg(runs="size", seed="first").reset_index()
