"""Pictures of the reference pages: what each method makes of records, and what each cause does to one.

`write(folder)` is called when the site is built; the pictures are not kept in the repository.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from time import perf_counter

import numpy as np

import helmbench
from helmbench.bench.faults.effects.base import Effect, Setting, kinds
from helmbench.bench.faults.frames import FaultCase
from helmbench.bench.faults.injected import inject
from helmbench.bench.faults.ships import ship
from helmbench.datasets.display import shown_name, shown_unit
from helmbench.datasets.grammar import DEGREE
from helmbench.datasets.instruments import behind_play
from helmbench.datasets.signals import lagged
from helmbench.diagnosis.causes.registry import all_causes
from helmbench.estimation.information.bounds import cramer_rao
from helmbench.methods.registry import methods
from helmbench.reporting.plots import COLOURS, INK, SOFT, legend_beside, svg

NOISE_SD = {"heading_rad": 0.1 * DEGREE, "yaw_rate_rad_s": 0.05 * DEGREE}
NOISE = "heading=0.1deg,yaw_rate=0.05deg_s"
BRIEFLY = {"mcmc": "mcmc,steps=300"}
"""Method -> what is drawn of it, where a fit takes long."""
DRAWS, SECONDS = 40, 6.0
"""Records to which a method is fitted, and the time after which no further one is begun."""
TRIVIAL = 0.02
"""Share of a channel's largest value below which its variation does not count."""
SHOWS = 0.15
"""Share of a channel's variation that an effect changes in its picture."""
SHOWN = ("rudder_rad", "heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m")
"""Channels of which the one that a cause changes most is drawn."""


def write(folder: Path) -> None:
    """Write `method-NAME.svg` and `cause-NAME.svg` of every method and cause."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in methods():
        (folder / f"method-{name}.svg").write_text(_of_method(name), encoding="utf-8")
    (folder / "turning-circles.svg").write_text(turning_circles(), encoding="utf-8")
    for name in all_causes():
        (folder / f"cause-{name}.svg").write_text(_of_cause(name), encoding="utf-8")


# ---- methods


def _of_method(name: str) -> str:
    """Estimates from records that differ in their noise, and a free run along a record that took no part."""
    planar = name == "euler-ls"  # the one method for 3-DOF models only
    vessel, family = ("mariner", "abkowitz") if planar else ("response-1", "nomoto-1-cubic")
    noise = "low" if planar else NOISE
    truth = helmbench.resolve(vessel)
    *train, check = _zigzags(vessel, noise)
    started, found = perf_counter(), []
    for record in train:
        if found and perf_counter() - started > SECONDS:
            break
        found.append(helmbench.identify(record, vessel if planar else family, BRIEFLY.get(name, name)))
    drawn = [{**one.parameters} for one in found if {"K", "T"} <= set(one.parameters or {})]
    run = found[0].simulate(check)

    def draw(figure) -> None:
        places = figure.subplots(1, 2 if drawn else 1, width_ratios=[2, 3] if drawn else None, squeeze=False)[0]
        axes = places[-1]
        axes.plot(check.time_s, check.column("yaw_rate_rad_s") / DEGREE, color=SOFT, label="measured")
        axes.plot(run.time_s, run.column("yaw_rate_rad_s") / DEGREE, color=COLOURS[1], label=name)
        axes.set(xlabel="time [s]", ylabel="yaw rate [deg/s]", title="free run along a 10/10 zigzag")
        legend_beside(axes)
        if drawn:
            _estimates(places[0], truth, train[0], drawn)

    return svg(draw, (8.5, 2.6))


@cache
def _zigzags(vessel: str, noise: str) -> list:
    """The records to fit, and last the one that takes no part."""
    texts = ["zigzag:20/20"] * DRAWS + ["zigzag:10/10"]
    return [helmbench.simulate(vessel, text, noise=noise, seed=s, dt_s=0.5) for s, text in enumerate(texts)]


def _estimates(axes, truth, record, drawn) -> None:
    """The estimates in the plane of T and K, with the ellipse of 95 % by the Cramer-Rao bound."""
    _, covariance = cramer_rao(truth, [record], NOISE_SD)
    jacobian = truth.parameters_jacobian(truth.coefficients)
    names = list(truth.parameter_names)
    chosen = [names.index("T"), names.index("K")]
    plane = (jacobian @ covariance @ jacobian.T)[np.ix_(chosen, chosen)]
    angle = np.linspace(0.0, 2.0 * np.pi, 100)
    ring = np.linalg.cholesky(plane) @ np.array([np.cos(angle), np.sin(angle)]) * np.sqrt(-2.0 * np.log(0.05))
    centre = [truth.parameters["T"], truth.parameters["K"]]
    axes.plot([one["T"] for one in drawn], [one["K"] for one in drawn], ".", color=COLOURS[1], label="estimates")
    axes.plot(*(ring + np.array(centre)[:, None]), color=INK, label="95 % by the bound")
    axes.plot(*centre, "+", color=INK, markersize=10, label="true")
    axes.set(xlabel="T [s]", ylabel="K [1/s]", title=f"{len(drawn)} records of a 20/20 zigzag")
    axes.legend(fontsize=7)


# ---- vessels


def turning_circles() -> str:
    """Turning circles of all vessels with positions whose motion is bounded, in their lengths."""
    ships = {name: helmbench.resolve(name) for name in helmbench.list_vessels()}
    planar = {name: one for name, one in ships.items() if "y" in one.states and one.particulars.get("L")}

    def draw(figure) -> None:
        axes = figure.subplots()
        for name, model in planar.items():
            length = model.particulars["L"]
            try:
                run = helmbench.simulate(name, "turn:20", duration_s=25.0 * length / model.speed_m_s)
            except helmbench.BadInput:  # its published numbers make it unstable
                continue
            axes.plot(run.column("east_m") / length, run.column("north_m") / length, label=name)
        axes.set(xlabel="to starboard [lengths]", ylabel="ahead [lengths]", title="turning circles, 20 deg of rudder")
        axes.set_aspect("equal")
        legend_beside(axes)

    return svg(draw, (7.5, 4.5))


# ---- causes

Columns = dict[str, np.ndarray]


def _turned(c: Columns, t: np.ndarray) -> None:
    c["yaw_rate_rad_s"] *= -1.0


def _coarse(c: Columns, t: np.ndarray) -> None:
    c["heading_rad"] = np.round(c["heading_rad"] / (5.0 * DEGREE)) * 5.0 * DEGREE


def _deviating(c: Columns, t: np.ndarray) -> None:
    c["heading_rad"] += 8.0 * DEGREE * np.sin(c["heading_rad"] + 1.0)


def _constant(c: Columns, t: np.ndarray) -> None:
    c["surge_m_s"][:] = c["surge_m_s"][0]


def _derived(c: Columns, t: np.ndarray) -> None:
    heading = c["heading_rad"] + 0.1 * DEGREE * np.random.default_rng(1).standard_normal(len(t))
    c["yaw_rate_rad_s"] = np.gradient(heading, t)


def _frozen(c: Columns, t: np.ndarray) -> None:
    held = (t > 60.0) & (t < 110.0)
    c["heading_rad"][held] = c["heading_rad"][held][0]


def _from_zero(c: Columns, t: np.ndarray) -> None:
    c["heading_rad"] += 20.0 * DEGREE


def _impossible(c: Columns, t: np.ndarray) -> None:
    c["yaw_rate_rad_s"][[150, 320]] = 40.0 * DEGREE


def _one_sided(c: Columns, t: np.ndarray) -> None:
    c["yaw_rate_rad_s"] *= np.where(c["yaw_rate_rad_s"] > 0.0, 0.1, 1.0)


def _gross(c: Columns, t: np.ndarray) -> None:
    rng = np.random.default_rng(1)
    hit = rng.random(len(t)) < 0.05
    c["yaw_rate_rad_s"][hit] += rng.normal(0.0, 0.3 * DEGREE, hit.sum())


def _late(name: str, lag_s: float) -> Callable[[Columns, np.ndarray], None]:
    def change(c: Columns, t: np.ndarray) -> None:
        c[name] = np.interp(t - lag_s, t, c[name])

    return change


def _ahead(c: Columns, t: np.ndarray) -> None:
    c["sway_m_s"] += 60.0 * c["yaw_rate_rad_s"]


def _rudder_from_yaw(c: Columns, t: np.ndarray) -> None:
    c["rudder_rad"] = 20.0 * np.gradient(c["yaw_rate_rad_s"], t)


def _halves(c: Columns, t: np.ndarray) -> None:
    half = len(t) // 2
    for name in c:
        c[name] = np.concatenate([c[name][half:], c[name][:half]])[: len(t)]


def _stamps(c: Columns, t: np.ndarray) -> None:
    c["heading_rad"] = np.interp(np.where((t > 60.0) & (t < 120.0), t + 15.0, t), t, c["heading_rad"])


def _fast_clock(c: Columns, t: np.ndarray) -> None:
    for name, values in c.items():
        c[name] = np.interp(t / 1.05, t, values)


def _drifting(c: Columns, t: np.ndarray) -> None:
    c["heading_rad"] += 0.05 * DEGREE * t


def _larger_ship(c: Columns, t: np.ndarray) -> None:
    """1.3 times as long: slower turns at the same rudder angles."""
    c["yaw_rate_rad_s"] = np.interp(t / np.sqrt(1.3), t, c["yaw_rate_rad_s"]) / np.sqrt(1.3)


def _log_curve(c: Columns, t: np.ndarray) -> None:
    c["surge_m_s"] *= 1.3 - 0.05 * c["surge_m_s"]


def _sensor_play(c: Columns, t: np.ndarray) -> None:
    c["rudder_rad"] = behind_play(c["rudder_rad"], 4.0 * DEGREE)


def _behind_lag(c: Columns, t: np.ndarray) -> None:
    c["heading_rad"] = lagged(c["heading_rad"], 8.0, float(np.median(np.diff(t))))


def _other_unit(c: Columns, t: np.ndarray) -> None:
    c["surge_m_s"] *= 3600.0 / 1852.0


CHANGES: Mapping[str, tuple[str, Callable[[Columns, np.ndarray], None]]] = {
    "channel_sign": ("yaw_rate_rad_s", _turned),
    "coarse_channel": ("heading_rad", _coarse),
    "compass_deviation": ("heading_rad", _deviating),
    "constant_channel": ("surge_m_s", _constant),
    "derived_channel": ("yaw_rate_rad_s", _derived),
    "frozen_samples": ("heading_rad", _frozen),
    "heading_drift": ("heading_rad", _drifting),
    "heading_lag": ("heading_rad", _behind_lag),
    "heading_zero": ("heading_rad", _from_zero),
    "impossible_samples": ("yaw_rate_rad_s", _impossible),
    "logger_clock": ("heading_rad", _fast_clock),
    "one_sided_channel": ("yaw_rate_rad_s", _one_sided),
    "outliers": ("yaw_rate_rad_s", _gross),
    "position_delay": ("east_m", _late("east_m", 40.0)),
    "reference_point": ("sway_m_s", _ahead),
    "rudder_from_sensor": ("rudder_rad", _rudder_from_yaw),
    "rudder_response": ("rudder_rad", _late("rudder_rad", 6.0)),
    "rudder_sensor_delay": ("rudder_rad", _late("rudder_rad", 4.0)),
    "rudder_sensor_play": ("rudder_rad", _sensor_play),
    "ship_scale": ("yaw_rate_rad_s", _larger_ship),
    "speed_curve": ("surge_m_s", _log_curve),
    "splice": ("heading_rad", _halves),
    "time_stamps": ("heading_rad", _stamps),
    "track_delay": ("sway_m_s", _late("sway_m_s", 8.0)),
    "velocity_point": ("sway_m_s", _ahead),
    "wrong_unit": ("surge_m_s", _other_unit),
    "yaw_rate_delay": ("yaw_rate_rad_s", _late("yaw_rate_rad_s", 8.0)),
}
"""Faults of files and sensors, drawn without an effect of the bench: the channel that shows it, and what it does."""
EFFECT_OF = {"base_coefficients": "coefficient_shift"}


def _of_cause(name: str) -> str:
    """A channel of a run with the same steps of the rudder, without and with the cause."""
    if name in CHANGES:
        channel, change = CHANGES[name]
        time, plain = _run("mariner")
        changed = {key: value.copy() for key, value in plain.items()}
        change(changed, time)
        return _compared(time, channel, plain[channel], changed[channel], name)
    kind = kinds()[EFFECT_OF.get(name, name)]
    vessel = next(name for name in ("mariner", "response-1", "cargo") if kind.carried_by(ship(name)))
    time, plain, changed = _grown(vessel, kind)
    shares = {key: _share(plain[key], changed[key]) for key in plain}
    motion = {key: share for key, share in shares.items() if key != "rudder_rad" and share > 0.0}
    channel = max(motion or shares, key=shares.__getitem__)
    return _compared(time, channel, plain[channel], changed[channel], name)


def _run(vessel: str, *effects: Effect) -> tuple[np.ndarray, Columns]:
    """Time and columns of a run with given steps of the rudder."""
    case = FaultCase(
        vessel,
        effects=effects,
        train=("steps:20deg/60s",),
        held_out=("zigzag:10/10",),
        duration_s=300.0,
        noise=0.0,
        wrap=False,
    )
    record = inject(case, np.random.default_rng(0)).train[0]
    return np.asarray(record.time_s), {name: np.array(record.column(name)) for name in SHOWN if record.has(name)}


def _grown(vessel: str, kind) -> tuple[np.ndarray, Columns, Columns]:
    """Time and columns without the effect and with it, so large that it shows."""
    setting = Setting(ship(vessel), 300.0, 1, 1, lambda: (5.0, 0.5))
    effect = Effect(kind.id, kind.draw(setting, np.random.default_rng(3)))
    time, plain = _run(vessel)
    for factor in (1.0, 3.0, 10.0, 30.0, 100.0):
        _, after = _run(vessel, effect.scaled(factor))
        before = {name: values for name, values in plain.items() if name in after}
        if not kind.sized or max(_share(before[key], after[key]) for key in before) > SHOWS:
            break
    return time, before, after


def _share(before: np.ndarray, after: np.ndarray) -> float:
    """Root mean square change over the standard deviation of what was there."""
    return float(
        np.sqrt(np.nanmean((after - before) ** 2))
        / max(float(np.nanstd(before)), TRIVIAL * float(np.abs(before).max()))
    )


def _compared(time: np.ndarray, channel: str, before: np.ndarray, after: np.ndarray, name: str) -> str:
    unit, factor = shown_unit(channel)

    def draw(figure) -> None:
        axes = figure.subplots()
        axes.plot(time, before * factor, color=SOFT, label="without")
        axes.plot(time, after * factor, color=COLOURS[1], label=name.replace("_", " "))
        axes.set(xlabel="time [s]", ylabel=f"{shown_name(channel)} [{unit}]")
        legend_beside(axes)

    return svg(draw, (7.5, 1.9))
