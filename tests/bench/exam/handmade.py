"""A small exam that is written by hand: eight worlds of three kinds of truth, nothing is simulated."""

import json
from dataclasses import asdict

import numpy as np

from helmbench.bench.exam import folder as exams
from helmbench.bench.exam.exam_file import cause_list, group_list
from helmbench.bench.exam.key import digest, motion_of
from helmbench.bench.exam.motion import errors, opening, without_motion
from helmbench.bench.exam.worlds import kind_of_case
from helmbench.bench.kinds.diagnosis.execute import right_names
from helmbench.bench.kinds.diagnosis.plan import CaseSpec
from helmbench.datasets.io import write_record
from helmbench.datasets.record import Record, RecordMeta
from helmbench.models.model import model_to_json, resolve
from helmbench.models.plain import plain

VESSEL, N, BEGIN = "mariner", 60, 0.25
"""The ship, samples of a record, and the rudder angle (rad) beyond which the rudder of world-6 loses force."""
WORLDS = {
    "world-1": ("injected", {"rudder_offset": {"delta0": 0.02}}, "exact"),
    "world-2": ("injected", {"yaw_rate_bias": {"b": 0.001}}, "exact"),
    "world-3": ("pair", {"rudder_effectiveness": {"e": 0.1}, "yaw_damping_quadratic": {"Nrr": 1e-4}}, "exact"),
    "world-4": ("injected", {"current": {"speed": [0.5, 0.4], "towards": [1.0, 2.0]}}, "off-5"),
    "world-5": ("one-bug", {}, "N_r"),
    "world-6": ("regime", {"rudder_force_loss": {"loss": 0.2, "angle": BEGIN}}, "unstated"),
    "world-7": ("null", {}, "exact"),
    "world-8": ("null", {}, "off-5"),
}
"""World -> group, effects with their parameters, base model."""


def record(name):
    """A run under a sine of the rudder."""
    time = np.arange(N, dtype=float)
    rudder = 0.35 * np.sin(0.3 * time)
    motion = {"yaw_rate_rad_s": 0.01 * np.sin(0.3 * time - 0.5), "heading_rad": 0.03 * np.cos(0.3 * time - 0.5)}
    motion |= {"surge_m_s": 7.0 + 0.1 * np.cos(0.2 * time), "sway_m_s": 0.3 * np.sin(0.3 * time - 0.7)}
    return Record(time, {"rudder_rad": rudder, **motion}, name, RecordMeta(positive_rudder="port"))


def handmade(place):
    """(exam, its key, the key's file) in the folder `place`."""
    folder, file = place / "exam", place / "key.json"
    shown, entries = {}, {}
    for name, facts in WORLDS.items():
        (folder / name).mkdir(parents=True)
        entries[name], shown[name] = _world(folder / name, *facts)
    files = {path.relative_to(folder).as_posix(): digest(path.read_bytes()) for path in sorted(folder.rglob("*.*"))}
    key = {"schema_version": 1, "suite": "exam", "seed": 1, "version": "0", "files": files, "worlds": entries}
    secret = json.dumps(plain(key)).encode()
    head = {"exam": "handmade", "title": "by hand", "version": "0", "key_sha256": digest(secret)}
    manifest = {"schema_version": 1, **head, "files": files, "worlds": shown}
    (folder / exams.MANIFEST).write_text(json.dumps(manifest), "utf-8")
    (folder / exams.CAUSES).write_text(json.dumps(cause_list()), "utf-8")
    file.write_bytes(secret)
    exam = exams.Exam(folder)
    return exam, exam.key(file), file


def _world(folder, group, effects, base):
    """Write a world; its entries in the key and in the manifest."""
    train, held_out, model = record("train-1"), record("held_out-1"), resolve(VESSEL)
    for one in (train, without_motion(held_out)):
        write_record(one, folder / f"{one.name}.csv")
    model_to_json(model, folder / exams.MODEL)
    spec = CaseSpec("exam", "", "", group, VESSEL, tuple(effects), "moderate", "none", 1, base)
    start, measured = opening(held_out), {c: x for c, x in held_out.channels.items() if c != "rudder_rad"}
    runs = {factor: {"held_out-1": {c: x * factor for c, x in measured.items()}} for factor in (1.1, 1.01)}
    wrong, best = (errors({"held_out-1": measured}, run, {"held_out-1": start}) for run in runs.values())
    texts = {c: " ".join(map(repr, x.tolist())) for c, x in measured.items()}
    true = {c: " ".join(map(repr, (1.01 * x).tolist())) for c, x in measured.items()}
    columns = {"time_s": train.time_s, **train.channels}
    motion = {"train-1": {c: " ".join(map(repr, x.tolist())) for c, x in columns.items()}}
    regime = group == "regime"
    entry = {
        "kind": kind_of_case(spec), "case": asdict(spec), "factors": {}, "detectable": True, "right":
        sorted(right_names(spec)[0]), "effects": [{"cause": c, "parameters": p} for c, p in effects.items()],
        "regimes": [{"variable": "rudder", "side": "above", "threshold": BEGIN}] if regime else [],
        "train": ["train-1"], "motion": motion if regime else {}, "rmse_base": wrong, "rmse_best": best,
        "held_out": {"held_out-1": {"start": start, "measured": texts, "best": true}},
    }  # fmt: skip
    shown = {
        "base_numbers": "exact" if base == "exact" else "uncertain", "train": ["train-1"], "held_out": ["held_out-1"],
        "opening_s": {"held_out-1": float(start - 1)}, "groups": group_list(model),
    }  # fmt: skip
    return entry, shown


def predicted(exam, key, world, factor=1.0):
    """The held-out record of a world with a motion `factor` times the measured one."""
    (empty,) = exam.records(world, exam.worlds[world].held_out)
    motion = motion_of(key.worlds[world].held_out["held_out-1"].measured)
    return empty.with_channels(**{c: factor * x for c, x in motion.items()})
