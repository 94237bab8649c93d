"""Rates over the cases of a diagnosis suite, with their numbers and 95 % binomial intervals (Clopper and Pearson 1934).

`build` works on the stored tables alone.  A failed case counts against every rate that it belongs to.
"""

from __future__ import annotations

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
    """A rate that is reported: of which cases and what counts, in the names of `facts_of`, and what the design asks."""

    id: str
    title: str
    cases: str
    hit: str
    target: float
    at_least: bool = True


def facts_of(cases: Frame) -> Frame:
    """What each case is, and what was said of it: truth values (N,) by name."""
    import pandas as pd

    def within(column: str, *values: Any) -> Frame:
        return cases[column].isin(values)

    groups = {"one_bug": ONE_BUG, "regime": REGIME, "planted": PLANTED}
    groups |= {name: name for name in ("injected", "null", "pair", "anticipated", "unforeseen")}
    exact = cases["base"].fillna(EXACT) == EXACT
    facts = {name: within("group", group) for name, group in groups.items()}
    facts |= {name: within("outcome", name) for name in ("alone", "both", "unexplained", "adequate")}
    facts |= {"calm": within("gusts", "none"), "fast": within("gusts", "fast"), "slow": within("gusts", "slow")}
    facts |= {
        "exact": exact,
        "unstated": within("base", UNSTATED),
        "detectable": facts["injected"] & within("detectable", True),
        "largest": within("strength", "largest"),
        "named": within("outcome", *FOUND),
        "in_some_finding": within("outcome", *FOUND, "among"),
        "wrong": within("confident_wrong", True),
        "told": within("verdict", "named", "tied"),
        "stated": ~within("names", 0),
        "further": cases["extra_names"].fillna(0) > 0,
        "described": cases["described"].fillna("") != "",
        "oracle_names": within("outcome_oracle", *FOUND),
        "oracle_known": cases["gain_worst"].notna(),
        "close": cases["gain_worst"] <= CLOSE,
        "worse": _above_the_base(cases, "after"),
        "predictable": cases["rmse_truth_heading_rad"].notna() & ~_above_the_base(cases, "truth"),
        "halved": _squared(cases, "after") <= 0.25 * _squared(cases, "before"),
        "variable_known": cases["right_variable"].notna(),
        "right_variable": within("right_variable", True),
        "regime_known": cases["regime_true"].notna(),
        "regime_named": ~within("regime_named", ""),
        "regime_occurs": cases["regime_f1"].notna() | within("status", "failed"),
        "located": cases["regime_f1"] >= CLOSE_F1,
        "others_known": cases["healthy_bias"].notna(),
        "others_right": cases["healthy_bias"] <= HEALTHY,
    }
    return pd.DataFrame(facts)


def _above_the_base(cases: Frame, which: str) -> Frame:
    """Cases whose held-out error is more than WORSE times the base model's in some channel."""
    ratios = [cases[f"rmse_{which}_{channel}"] / cases[f"rmse_before_{channel}"] for channel in GAIN_CHANNELS]
    return np.logical_or.reduce([ratio > WORSE for ratio in ratios])


@np.errstate(over="ignore")
def _squared(cases: Frame, which: str) -> Frame:
    """Squared held-out error, in units of the true ship's, which is the noise of the sensors; the sum over channels."""
    ratios = [cases[f"rmse_{which}_{c}"].astype(float) / cases[f"rmse_truth_{c}"].astype(float) for c in GAIN_CHANNELS]
    return np.nansum(np.square(ratios), axis=0)


NAMED = "true cause first or in its tie"
BUG_WORSE = "one wrong number: held-out error above 1.05 of the base in some channel"
NAMED_BESIDE = f"{NAMED} (imperfect base; the oracle names it)"
FALSE_BESIDE = "a name that is none of the hull's, clean, imperfect base"
POSSIBLE = "... where the true ship without gusts is not"
NO_REGIME = "a regime is stated where there is none"
CLOSE_BESIDE = f"held-out error within {CLOSE} of the oracle's in every channel, imperfect base"
HALVED = "... whose held-out error is halved (of all channels, each in units of the true ship's)"
RIGHT_VARIABLE = "unknowns of the largest size described by the right variable"
UNTOLD = "correct base, not told so: verdict other than adequate"
STAYS = "numbers that are right stay within .1 of their prior standard deviation (rms)"
VERDICT = "verdict named or tied where nothing but the wrong number is named"
EFFECTS, VARIABLE = "injected | pair", "anticipated & largest & variable_known"
RATES = (
    Rate("named", f"{NAMED} (detectable)", "detectable", "named", 0.97),
    Rate("alone", "... by itself", "detectable", "alone", 0.0),
    Rate("false_clean", "false alarms, clean", "null & exact & calm", "~adequate", 0.02, False),
    Rate("false_fast", "false alarms, fast gusts", "null & exact & fast", "~adequate", 0.03, False),
    Rate("false_slow", "false alarms, slow gusts", "null & exact & slow", "~adequate", 0.03, False),
    Rate("wrong", "wrong names without a tie", EFFECTS, "wrong", 0.02, False),
    Rate("anticipated_clean", "anticipated unknowns unexplained, clean", "anticipated & calm", "unexplained", 0.95),
    Rate("anticipated_gusty", "anticipated unknowns unexplained, gusts", "anticipated & ~calm", "unexplained", 0.70),
    Rate("unforeseen_clean", "unforeseen unknowns unexplained, clean", "unforeseen & calm", "unexplained", 0.70),
    Rate("right_variable", RIGHT_VARIABLE, VARIABLE, "right_variable", 0.80),
    Rate("halved", HALVED, VARIABLE, "halved", 0.0),
    Rate("described", "something is described where nothing is, gusts or none", "null", "described", 0.02, False),
    Rate("extra", "runs with a further name that is none of the hull's", EFFECTS, "further", 0.05, False),
    Rate("named_beside", NAMED_BESIDE, "detectable & ~exact & oracle_names", "named", 0.92),
    Rate("false_beside", FALSE_BESIDE, "null & ~exact & ~unstated", "further", 0.02, False),
    Rate("close_beside", CLOSE_BESIDE, "injected & ~exact & oracle_known", "close", 0.90),
    Rate("worse", "held-out error above 1.05 of the base in some channel", EFFECTS, "worse", 0.0, False),
    Rate("worse_than_possible", POSSIBLE, "(injected | pair) & predictable", "worse", 0.0, False),
    Rate("bug_alone", "one wrong number: its group or cause is all that is named", "one_bug", "alone", 0.80),
    Rate("bug_tie", "... or tied with others", "one_bug", "named", 0.0),
    Rate("bug_among", "... or among other findings", "one_bug", "in_some_finding", 0.90),
    Rate("bug_verdict", VERDICT, "one_bug & alone", "told", 0.95),
    Rate("bug_worse", BUG_WORSE, "one_bug", "worse", 0.0, False),
    Rate("false_unstated", UNTOLD, "null & unstated", "~adequate", 0.02, False),
    Rate("regime_alone", "fault in a regime: its group or cause is all that is named", "regime", "alone", 0.0),
    Rate("regime_among", "... or tied, or among other findings", "regime", "in_some_finding", 0.90),
    Rate("regime_f1", "fault in a regime: samples located with F1 >= .8", "regime & regime_occurs", "located", 0.80),
    Rate("regime_false", NO_REGIME, "~regime & regime_known", "regime_named", 0.05, False),
    Rate("healthy", STAYS, "(regime | one_bug) & others_known", "others_right", 0.90),
    Rate("planted", "planted nulls of which something is named", "planted", "stated", 0.05, False),
    Rate("both", "both causes of a pair named", "pair", "both", 0.90),
)


@dataclass(frozen=True)
class Board:
    """Aggregated results, each a pandas frame.

    rates: method, scope, group, rate, title, n, hits, value, low, high, target, met; scope `all` or one of SCOPES.
    figures: what is no rate of cases, likewise, over all. confusion: counts of (method, injected, named). power:
    method, gusts, low, high (of the non-centrality), middle, n, hits, value. sizes: coverage by method and cause.
    failures: what failed or did not apply.
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

        return pd.concat([self.rates, self.figures])


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
        facts = facts_of(own)
        for rate in RATES:
            chosen = _holds(facts, rate.cases)
            hits = _holds(facts, rate.hit)[chosen]
            rows.append(_rate_row(method, "all", "all", rate, hits))
            for scope in SCOPES:
                parts = hits.groupby(own.loc[chosen, scope], sort=True)
                rows += [_rate_row(method, scope, group, rate, part) for group, part in parts]
    return pd.DataFrame([row for row in rows if row["n"]], columns=RATE_COLUMNS)


def _holds(facts: Frame, condition: str) -> Frame:
    return facts[condition] if condition in facts else facts.eval(condition, engine="python")


def _judged(cases: Frame) -> Frame:
    """Cases that ran; what did not apply is left out, what failed counts as missed."""
    return cases[cases["status"] != "not_applicable"]


def _rate_row(method: Any, scope: str, group: Any, rate: Rate, found: Frame) -> dict[str, Any]:
    n, hits = len(found), int(found.sum())
    low, high = binomial_interval(hits, n)
    value = hits / n if n else np.nan
    met = value >= rate.target if rate.at_least else value <= rate.target
    facts = (method, scope, group, rate.id, rate.title, n, hits, value, low, high, rate.target, met)
    return dict(zip(RATE_COLUMNS, facts, strict=True)) | ({"target": np.nan, "met": None} if not rate.target else {})


def binomial_interval(hits: int, n: int) -> tuple[float, float]:
    """Clopper-Pearson interval of a rate; (nan, nan) where n = 0."""
    from scipy.stats import binomtest

    if n == 0:
        return np.nan, np.nan
    found = binomtest(hits, n).proportion_ci(LEVEL, method="exact")
    return float(found.low), float(found.high)


def figure_table(cases: Frame, sizes: Frame) -> Frame:
    """What is no rate of cases: tie size, coverage, gain, time."""
    import pandas as pd

    rows = []
    for method, own in cases[cases["status"] == "ok"].groupby("method", sort=True):
        covered = sizes[sizes["method"] == method]["covered"]
        rows += [(method, "all", "all", *row) for row in _figures(own, covered) if row[2]]
    return pd.DataFrame(rows, columns=RATE_COLUMNS)


def _figures(own: Frame, covered: Frame) -> list[tuple[Any, ...]]:
    """Rows of `RATE_COLUMNS` from `rate` on."""
    facts = facts_of(own)
    ties = own[facts["detectable"] & facts["named"]]["tie_size"].astype(float)
    ratio = own[facts["detectable"]]["gain_ratio"].dropna().to_numpy(float)
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
    facts = facts_of(cases)
    kept = (cases["status"] == "ok") & ~facts["pair"] & (~facts["injected"] | facts["detectable"])
    chosen, facts = cases[kept], facts[kept]
    injected = chosen["injected"].where(facts["injected"] | facts["regime"], "(" + chosen["group"] + ")")
    injected = injected.where(~facts["one_bug"], chosen["base"])
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
                hits = int(part["outcome"].isin(FOUND).sum())
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
