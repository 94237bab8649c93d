"""Submissions made by hand: the one that is right throughout, and files of any content."""

import json

import numpy as np

from helmbench.bench.exam.answers import write
from helmbench.bench.exam.key import motion_of


def perfect(exam, key, place):
    """What the key says, as a submission in the folder `place`."""
    worlds, runs = {}, {}
    for name, world in key.worlds.items():
        files = {record: f"{name}-{record}.csv" for record in world.held_out}
        worlds[name] = {"named": right(exam, name, world), "motion": files}
        for record in exam.records(name, exam.worlds[name].held_out):
            best = motion_of(world.held_out[record.name].best)
            runs[files[record.name]] = record.with_channels(**best)
    write(place, {"schema_version": 1, "exam": exam.id, "entrant": "perfect", "worlds": worlds}, runs)
    return place


def right(exam, name, world):
    """The names of a world with their sizes and regimes."""
    if world.right:
        names = [text for one in world.right for text in (one, f"group:{one}")]
        known = [one for one in names if one in exam.causes or one in exam.worlds[name].groups]
        regimes = [vars(one) for one in world.regimes]
        return [{"cause": known[0], **({"regime": regimes[0]} if regimes else {})}]
    records = [*world.train, *world.held_out]
    return [{"cause": effect.cause, "sizes": sizes(effect, world.ship, records)} for effect in world.injected]


def sizes(effect, ship, records):
    """The true sizes of an effect in every record."""
    return [
        {"parameter": parameter, "value": value, "low": value, "high": value, "record": record}
        for i, record in enumerate(records)
        for parameter, value in effect.kind.truths(effect.at(i), ship, {}).items()
        if np.isfinite(value)
    ]


def submission(place, of, **changes):
    """A submission file to an exam with some keys changed; its path."""
    content = {"schema_version": 1, "exam": of.id, "entrant": "somebody", "worlds": {}} | changes
    place.mkdir(exist_ok=True)
    path = place / "submission.json"
    path.write_text(json.dumps(content), "utf-8")
    return path
