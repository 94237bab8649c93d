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
GAIN_CHANNELS = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s")
"""Channels whose errors make the gain; positions drift and are stored only."""
CASE = ["group", "vessel", "injected", "strength", "gusts", "seed"]
SCOPES = ("vessel", "gusts", "strength", "injected", "base", "records")
FOUND = ("alone", "tie")
LATER = (
    "regime_true",
    "regime_named",
    "regime_f1",
    "healthy_bias",
    "names",
    "false_names",
    "described",
    "right_variable",
)
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


@dataclass(frozen=True)
class Rate:
    """A rate that is reported: which cases, what counts, and what the design asks for."""

    id: str
    title: str
    cases: Callable[[Frame], Frame]
    hit: Callable[[Frame], Frame]
    target: float
    at_least: bool = True


def _named(frame: Frame) -> Frame:
    return frame["outcome"].isin(FOUND)


def _unexplained(frame: Frame) -> Frame:
    return frame["outcome"] == "unexplained"


def _detectable(frame: Frame) -> Frame:
    return (frame["group"] == "injected") & frame["detectable"].eq(True)


def _exact(frame: Frame) -> Frame:
    return frame["base"].fillna(EXACT) == EXACT  # stores from before bases were drawn hold none


def _nameable(frame: Frame) -> Frame:
    """Effects beside an imperfect base that the oracle names."""
    return _detectable(frame) & ~_exact(frame) & frame["outcome_oracle"].isin(FOUND)


def _beside(frame: Frame) -> Frame:
    """Effects beside an imperfect base, with the oracle's errors."""
    return (frame["group"] == "injected") & ~_exact(frame) & frame["gain_worst"].notna()


def _null(gusts: str) -> Callable[[Frame], Frame]:
    return lambda frame: (frame["group"] == "null") & (frame["gusts"] == gusts) & _exact(frame)


def _null_beside(frame: Frame) -> Frame:
    return (frame["group"] == "null") & ~_exact(frame) & ~_unstated(frame)


def _unstated(frame: Frame) -> Frame:
    return frame["base"] == UNSTATED


def _null_unstated(frame: Frame) -> Frame:
    return (frame["group"] == "null") & _unstated(frame)


def _one_bug(frame: Frame) -> Frame:
    return frame["group"] == ONE_BUG


def _one_bug_alone(frame: Frame) -> Frame:
    return _one_bug(frame) & (frame["outcome"] == "alone")


def _regime(frame: Frame) -> Frame:
    return frame["group"] == REGIME


def _located(frame: Frame) -> Frame:
    """Cases of a regime that occurs in the records."""
    return _regime(frame) & (frame["regime_f1"].notna() | (frame["status"] == "failed"))


def _without_regime(frame: Frame) -> Frame:
    return ~_regime(frame) & frame["regime_true"].notna()


def _healthy(frame: Frame) -> Frame:
    """Wrong numbers and regimes, where the other numbers have priors."""
    return (_regime(frame) | _one_bug(frame)) & frame["healthy_bias"].notna()


def _in_some_finding(frame: Frame) -> Frame:
    return frame["outcome"].isin([*FOUND, "among"])


def _false_alarm(frame: Frame) -> Frame:
    return frame["outcome"] != "adequate"


def _wrong(frame: Frame) -> Frame:
    return frame["confident_wrong"].eq(True)


def _of(group: str, calm: bool) -> Callable[[Frame], Frame]:
    return lambda frame: (frame["group"] == group) & ((frame["gusts"] == "none") == calm)


def _effects(frame: Frame) -> Frame:
    return frame["group"].isin(["injected", "pair"])


def _of_known_variable(frame: Frame) -> Frame:
    """Unknown effects of the largest size whose variable is known."""
    return (frame["strength"] == "largest") & frame["right_variable"].notna() & (frame["group"] == "anticipated")


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


RATES = (
    Rate("named", "true cause first or in its tie (detectable)", _detectable, _named, 0.97),
    Rate("alone", "... by itself", _detectable, lambda f: f["outcome"] == "alone", 0.0),
    Rate("false_clean", "false alarms, clean", _null("none"), _false_alarm, 0.02, False),
    Rate("false_fast", "false alarms, fast gusts", _null("fast"), _false_alarm, 0.03, False),
    Rate("false_slow", "false alarms, slow gusts", _null("slow"), _false_alarm, 0.03, False),
    Rate("wrong", "wrong names without a tie", lambda f: f["group"].isin(["injected", "pair"]), _wrong, 0.02, False),
    Rate("anticipated_clean", "anticipated unknowns unexplained, clean", _of("anticipated", True), _unexplained, 0.95),
    Rate("anticipated_gusty", "anticipated unknowns unexplained, gusts", _of("anticipated", False), _unexplained, 0.70),
    Rate("unforeseen_clean", "unforeseen unknowns unexplained, clean", _of("unforeseen", True), _unexplained, 0.70),
    Rate(
        "right_variable",
        "unknowns of the largest size described by the right variable",
        _of_known_variable,
        lambda f: f["right_variable"].fillna(value=False).astype(bool),
        0.80,
    ),
    Rate(
        "halved",
        "... whose held-out error is halved (of all channels, each in units of the true ship's)",
        _of_known_variable,
        lambda f: _squared(f, "after") <= 0.25 * _squared(f, "before"),
        0.0,
    ),
    Rate(
        "described",
        "something is described where nothing is, gusts or none",
        lambda f: f["group"] == "null",
        _described,
        0.02,
        False,
    ),
    Rate("extra", "runs with a further name that is none of the hull's", _effects, _further, 0.05, False),
    Rate(
        "named_beside", "true cause first or in its tie (imperfect base; the oracle names it)", _nameable, _named, 0.92
    ),
    Rate(
        "false_beside", "a name that is none of the hull's, clean, imperfect base", _null_beside, _further, 0.02, False
    ),
    Rate(
        "close_beside",
        f"held-out error within {CLOSE} of the oracle's in every channel, imperfect base",
        _beside,
        lambda f: f["gain_worst"] <= CLOSE,
        0.90,
    ),
    Rate("worse", "held-out error above 1.05 of the base in some channel", _effects, _worse, 0.0, False),
    Rate(
        "worse_than_possible",
        "... where the true ship without gusts is not",
        _predictable,
        _worse,
        0.0,
        False,
    ),
    Rate(
        "bug_alone",
        "one wrong number: its group or cause is all that is named",
        _one_bug,
        lambda f: f["outcome"] == "alone",
        0.80,
    ),
    Rate("bug_tie", "... or tied with others", _one_bug, _named, 0.0),
    Rate("bug_among", "... or among other findings", _one_bug, _in_some_finding, 0.90),
    Rate(
        "bug_verdict",
        "verdict named or tied where nothing but the wrong number is named",
        _one_bug_alone,
        lambda f: f["verdict"].isin(["named", "tied"]),
        0.95,
    ),
    Rate(
        "bug_worse",
        "one wrong number: held-out error above 1.05 of the base in some channel",
        _one_bug,
        _worse,
        0.0,
        False,
    ),
    Rate(
        "false_unstated",
        "correct base, not told so: verdict other than adequate",
        _null_unstated,
        _false_alarm,
        0.02,
        False,
    ),
    Rate(
        "regime_alone",
        "fault in a regime: its group or cause is all that is named",
        _regime,
        lambda f: f["outcome"] == "alone",
        0.0,
    ),
    Rate("regime_among", "... or tied, or among other findings", _regime, _in_some_finding, 0.90),
    Rate(
        "regime_f1",
        "fault in a regime: samples located with F1 >= .8",
        _located,
        lambda f: f["regime_f1"] >= CLOSE_F1,
        0.80,
    ),
    Rate(
        "regime_false",
        "a regime is stated where there is none",
        _without_regime,
        lambda f: f["regime_named"] != "",
        0.05,
        False,
    ),
    Rate(
        "healthy",
        "numbers that are right stay within .1 of their prior standard deviation (rms)",
        _healthy,
        lambda f: f["healthy_bias"] <= HEALTHY,
        0.90,
    ),
    Rate(
        "planted",
        "planted nulls of which something is named",
        lambda f: f["group"] == PLANTED,
        lambda f: ~(f["names"] == 0),
        0.05,
        False,
    ),
    Rate("both", "both causes of a pair named", lambda f: f["group"] == "pair", lambda f: f["outcome"] == "both", 0.90),
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
        columns = ["method", "scope", "group", "rate", "title", "n", "hits", "value", "low", "high", "target", "met"]
        return pd.concat([self.rates, figures]).reindex(columns=columns)


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


RATE_COLUMNS = ["method", "scope", "group", "rate", "title", "n", "hits", "value", "low", "high", "target", "met"]


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


def figure_table(cases: Frame, sizes: Frame) -> Frame:
    """What is no rate of cases: tie size, coverage, gain, time."""
    import pandas as pd

    rows = []
    for method, own in cases[cases["status"] == "ok"].groupby("method", sort=True):
        covered = sizes[sizes["method"] == method]["covered"]
        rows += [{"method": method} | row for row in _figures(own, covered)]
    columns = ["method", "figure", "title", "n", "hits", "value", "low", "high", "target", "met"]
    return pd.DataFrame(rows, columns=columns)


def _figures(own: Frame, covered: Frame) -> list[dict[str, Any]]:
    ties = own[_detectable(own) & _named(own)]["tie_size"].astype(float)
    ratio = own[_detectable(own)]["gain_ratio"].dropna().to_numpy(float)
    f1 = own["regime_f1"].dropna().to_numpy(float)
    wall, cpu = (own[name].dropna().to_numpy(float) for name in ("wall_s", "cpu_s"))
    rows = [
        _mean_row(ties),
        _share_row("coverage", "sizes inside their 90 % intervals", covered, (0.85, 0.95)),
        _spread_row("gain_median", "held-out error over the oracle's, median (5-95 % of cases)", ratio, 1.15),
        _share_row("gain_close", "... share of cases within 1.15", ratio <= 1.15),
        _false_discovery_row(own[own["names"].notna()]),
        _spread_row("regime_f1_median", "F1 of samples located in a regime, median (5-95 % of cases)", f1),
        _spread_row("wall_s", "wall time of a diagnosis, s, median (5-95 % of cases)", wall),
        _spread_row("cpu_s", "CPU time of a diagnosis, s, median (5-95 % of cases)", cpu),
    ]
    return [row for row in rows if row["n"]]


def _mean_row(ties: Frame) -> dict[str, Any]:
    """Mean tie size with a normal interval."""
    mean = float(ties.mean()) if len(ties) else np.nan
    half = 1.96 * float(ties.std()) / np.sqrt(len(ties)) if len(ties) > 1 else np.nan
    facts = {"figure": "tie_size", "title": "mean tie size (detectable, named)", "n": len(ties), "hits": None}
    return facts | {"value": mean, "low": mean - half, "high": mean + half, "target": "1.3", "met": mean <= 1.3}


def _false_discovery_row(cases: Frame) -> dict[str, Any]:
    """False discovery rate: mean over the cases of the share of names that are false, 0 where nothing is stated.

    The interval is that of Clopper and Pearson for the same mean: no variable in 0 .. 1 has a larger variance.
    """
    from scipy.stats import beta

    n = len(cases)
    total = float((cases["false_names"] / cases["names"].clip(lower=1)).sum())
    low, high = beta.ppf([0.025, 0.975], [total, total + 1.0], [n - total + 1.0, n - total]) if n else (np.nan, np.nan)
    low, high = (0.0 if total == 0.0 else float(low)), (1.0 if total == n else float(high))
    value = total / n if n else np.nan
    facts = {
        "figure": "false_discovery",
        "title": "false discovery rate (share of names that are false, mean of cases)",
    }
    return facts | {
        "n": n,
        "hits": None,
        "value": value,
        "low": low,
        "high": high,
        "target": "0.05",
        "met": value <= FDR,
    }


def _share_row(name: str, title: str, hit: Any, asked: tuple[float, float] | None = None) -> dict[str, Any]:
    n, hits = len(hit), int(np.sum(hit))
    low, high = binomial_interval(hits, n)
    value = hits / n if n else np.nan
    target = None if asked is None else f"{100 * asked[0]:.0f}-{100 * asked[1]:.0f} %"
    met = None if asked is None else asked[0] <= value <= asked[1]
    facts = {"figure": name, "title": title, "n": n, "hits": hits, "value": value}
    return facts | {"low": low, "high": high, "target": target, "met": met}


def _spread_row(name: str, title: str, values: np.ndarray, most: float | None = None) -> dict[str, Any]:
    """Median and the 5 and 95 % quantiles."""
    low, middle, high = (
        np.quantile(values, [0.05, 0.5, 0.95], method="median_unbiased") if values.size else [np.nan] * 3
    )
    facts = {"figure": name, "title": title, "n": values.size, "hits": None, "value": float(middle)}
    target, met = (None, None) if most is None else (f"{most:g}", bool(middle <= most))
    return facts | {"low": float(low), "high": float(high), "target": target, "met": met}


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
