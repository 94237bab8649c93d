"""Reference pages made from the package itself: methods, causes, vessels, equations, formats, suites, commands.

`write(folder)` is called when the site is built; the pages are not kept in the repository.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click
import numpy as np

import helmbench
from helmbench.checks.base import SensorError
from helmbench.cli import cli
from helmbench.datasets import disturbances, sensors
from helmbench.datasets.columns import CANONICAL, QUANTITIES
from helmbench.datasets.sensors import CHANNELS, NOISE
from helmbench.datasets.sidecar import META_KEYS
from helmbench.diagnosis.causes.base import Cause
from helmbench.diagnosis.causes.registry import all_causes
from helmbench.estimation.estimates.assessment import NORMAL_95
from helmbench.estimation.indices import given
from helmbench.estimation.indices.fit import PRIORS, parameters_of
from helmbench.methods.base import KINDS
from helmbench.methods.registry import methods
from helmbench.models.model import Model, resolve
from helmbench.models.vessel import read_vessel, vessel_files
from helmbench.reporting.equations import equations

HEADINGS = {
    "rudder": "Rudder and steering gear",
    "hull": "Hull and propeller",
    "environment": "Wind, current, waves",
    "sensor": "Sensors",
    "sampling": "Sampling",
    "record": "Records and files",
}
"""Where a cause acts -> heading of its section."""


def write(folder: Path) -> None:
    """Write every page into a folder; an unchanged page is left alone, so that Sphinx does not read it again."""
    folder.mkdir(exist_ok=True)
    for name, page in PAGES.items():
        text = "\n".join(page()) + "\n"
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


# ---- Markdown


def table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """A Markdown table."""
    yield from ("", f"| {' | '.join(titles)} |", f"|{'---|' * len(titles)}")
    for row in rows:
        yield "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in row) + " |"
    yield ""


def code(text: str) -> str:
    return f"`{text}`" if text else ""


def number(value: float) -> str:
    return f"{value:.6g}"


def docstring(thing: object) -> Iterator[str]:
    """A docstring as it stands: its layout is that of the source."""
    yield from ("", "```text", inspect.cleandoc(thing.__doc__ or ""), "```", "")


# ---- the pages


def method_page() -> Iterator[str]:
    yield from (
        "# Methods",
        "",
        "The mathematics is on the page [Mathematics of the methods](../mathematics/methods.md). A picture shows what",
        "a method makes of zigzags with noise of the sensors (heading .1 deg, yaw rate .05 deg/s): right the free run",
        "of its model along a zigzag that took no part; left, of a method that estimates T and K, its estimates",
        "from records that differ in their noise, with the ellipse in which an efficient method has 95 % of them",
        "(Cramer-Rao bound). Points beside the cross are a bias, points beyond the ellipse lack efficiency.",
    )
    yield from table(("method", "what it is"), ((code(n), title) for n, title in helmbench.list_methods().items()))
    for name, cls in methods().items():
        yield from (f"## {name}", "", f"{cls.title[0].upper()}{cls.title[1:]}. Kind: {cls.kind} ({KINDS[cls.kind]}).")
        yield f"[Its equations](../mathematics/methods.md#{name})."
        yield from ("", f"![estimates and a free run by {name}](pictures/method-{name}.svg)")
        yield from docstring(cls)
        rows = [(code(o.name), code(repr(o.value)), o.range, o.searched) for o in cls.options.values()]
        if rows:
            yield from table(("option", "default", "allowed", "range for `tuned:`"), rows)


def cause_page() -> Iterator[str]:
    yield from (
        "# Causes",
        "",
        "What `diagnose` tests, and what `check` looks for without a model. The pictures show",
        "a run with given steps of the rudder, without the cause and with it, so large that it is seen.",
    )
    for where, heading in HEADINGS.items():
        yield from (f"## {heading}", "")
        for name, cause in all_causes().items():
            if cause.where != where:
                continue
            used = (
                "`check`"
                if not isinstance(cause, Cause)
                else "`diagnose`, and `check` where it shows"
                if isinstance(cause, SensorError) and (cause.turn or cause.track)
                else "`diagnose`"
            )
            yield from (f"### {name}", "", cause.physics, "", f"Unit: {cause.unit or 'none'}. Looked for by {used}.")
            yield from ("", f"![a run without and with {name}](pictures/cause-{name}.svg)", "")
            if cause.separate_by:
                yield f"Told from its rivals by {cause.separate_by}."
            yield ""


def vessel_page() -> Iterator[str]:
    yield from ("# Vessels", "", "Every coefficient has a unit and a source.", "")
    yield from ("![turning circles of the vessels](pictures/turning-circles.svg)", "")
    vessels = {name: read_vessel(path) for name, path in vessel_files().items()}
    rows = ((code(n), v["title"], code(v["family"]), v["source"]) for n, v in vessels.items())
    yield from table(("vessel", "ship", "family", "source"), rows)
    for name, vessel in vessels.items():
        yield from (f"## {name}", "", f"{vessel['title'][0].upper()}{vessel['title'][1:]}.")
        for part in ("particulars", "parameters", "constants"):
            yield from _quantities(part, vessel[part])


def _quantities(title: str, quantities: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    if quantities:
        rows = (
            (code(n), number(q["value"]), str(q.get("unit", "")), str(q.get("source", "")))
            for n, q in quantities.items()
        )
        yield from table((title, "value", "unit", "source"), rows)


def family_page() -> Iterator[str]:
    yield from ("# Families of equations", "", "Made from the symbolic definitions that the kernels are made of.")
    vessels = {read_vessel(path)["family"]: name for name, path in reversed(vessel_files().items())}
    for name, title in helmbench.list_models().items():
        yield from (f"## {name}", "", f"{title[0].upper()}{title[1:]}.", "")
        model = _any_model(name, vessels.get(name))
        if model is None:
            continue
        shown = equations(model, model)
        for line in (*shown.dynamics, *shown.helpers):
            # Terms are separate pieces, so that a long equation is broken into lines.
            yield from ("```{raw} html", f'<p class="equation">{line.html}</p>', "```", "")


def _any_model(family: str, vessel: str | None) -> Model | None:
    """The family without coefficients; a family that needs a vessel's constants, with those of a vessel."""
    try:
        return resolve(family)
    except helmbench.BadInput:
        return resolve(vessel).blanked() if vessel else None


def format_page() -> Iterator[str]:
    yield from ("# Formats", "", "## Columns of a record", "", "The unit is part of a column's name.")
    rows = []
    for quantity, spellings in QUANTITIES.items():
        canonical = next(iter(spellings.values()))[0]
        others = ", ".join(code(s) for s in spellings if s != canonical)
        rows.append((code(canonical), quantity.replace("_", " "), CANONICAL[canonical], others))
    yield from table(("column", "quantity", "unit", "also accepted"), rows)
    yield from ("## Sidecar", "", "A YAML file of the same stem beside the record. All keys are optional.")
    yield from table(("key", "meaning"), ((code(key), SIDECAR.get(key, "")) for key in (*META_KEYS, "constant")))
    yield from ("## Noise levels", "", "Standard deviation by channel; angles in degrees.")
    levels = list(NOISE)
    rows = [(code(c), _unit(c), *(_sd(c, level) for level in levels)) for c in CHANNELS if c != "rudder_command"]
    yield from table(("channel", "unit", *levels), rows)
    yield from ("## Manoeuvres",)
    yield from table(("form", "what it is"), ((code(k), v) for k, v in helmbench.list_manoeuvres().items()))
    for title, module in (("Sensors and their noise", sensors), ("Disturbances", disturbances)):
        yield from (f"## {title}", "", "As the source has it:", *docstring(module))


SIDECAR = {
    "vessel": "id of the vessel",
    "reference_point": "the point whose velocities and position are recorded, such as `midship`",
    "source": "where the record comes from",
    "licence": "terms of use",
    "positive_rudder": "`port` or `starboard`: the side to which the ship turns under a positive rudder angle",
    "manoeuvre": "text of the manoeuvre",
    "notes": "anything else",
    "constant": "channels that do not change on purpose",
}


def _unit(channel: str) -> str:
    return CANONICAL[CHANNELS[channel][0]].replace("rad", "deg")


def _sd(channel: str, level: str) -> str:
    sd = NOISE[level].get(channel, 0.0)
    return number(math.degrees(sd) if "rad" in CANONICAL[CHANNELS[channel][0]] else sd)


def suite_page() -> Iterator[str]:
    yield from (
        "# Suites",
        "",
        "`helmbench run --suite NAME -o DIR`; a suite of your own is a YAML file of the same form.",
    )
    yield from table(("suite", "what it runs"), ((code(n), title) for n, title in helmbench.list_suites().items()))


def command_page() -> Iterator[str]:
    yield from (
        "# Command line",
        "",
        "Exit status: 0 done (a diverged simulation, or a method that does not apply, is a result), 1 finished but",
        "some runs failed (they are listed and stay in the tables) or `check` names what matters, 2 bad input.",
        "A model is a vessel or a family by its identifier, a model.json, or a YAML file of particulars; a method may",
        "carry options: `ls,scheme=zoh`.",
    )
    yield from _help(cli, "helmbench")
    for name in cli.list_commands(click.Context(cli)):
        command = cli.commands[name]
        yield from (f"## helmbench {name}",)
        yield from _help(command, f"helmbench {name}")
        for part, own in command.commands.items() if isinstance(command, click.Group) else ():
            yield from (f"### helmbench {name} {part}",)
            yield from _help(own, f"helmbench {name} {part}")


def _help(command: click.Command, name: str) -> Iterator[str]:
    with click.Context(command, info_name=name, max_content_width=100, terminal_width=100) as context:
        yield from ("", "```text", command.get_help(context), "```", "")


def indices_report_page() -> Iterator[str]:
    """What `make indices-report` has measured."""
    yield (Path(__file__).parents[1] / "reports" / "indices" / "README.md").read_text(encoding="utf-8").rstrip("\n")


def indices_example() -> Iterator[str]:
    """What `from-indices` prints of the file on its page."""
    text = (Path(__file__).parent / "how-to" / "from-indices.md").read_text(encoding="utf-8")
    content = text.split("```yaml\n")[1].split("```")[0]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "tanker.yaml"
        path.write_text(content, encoding="utf-8")
        yield from ("```text", helmbench.model_from_indices(path).summary(), "```")


def indices_accuracies() -> Iterator[str]:
    """Accuracies that are assumed of indices."""
    share = number(given.OVERSHOOT_SHARE)
    rows = [
        ("distances", f"{number(given.DISTANCE_LENGTHS)} ship lengths"),
        ("steady speed", f"{number(given.SPEED_SHARE)} of the approach speed"),
        ("steady yaw rate", f"{number(given.RATE_SHARE)} of itself"),
        *(
            (name.replace("_", " "), f"{number(math.degrees(sd))} deg, or {share} of itself if that is more")
            for name, sd in given.OVERSHOOT.items()
        ),
    ]
    yield from table(("index", "standard deviation"), rows)


def indices_priors() -> Iterator[str]:
    """Usual values of the parameters of models from indices, and the ranges of 95 %."""
    ends = [parameters_of(np.full(len(PRIORS), side)) for side in (0.0, -NORMAL_95, NORMAL_95)]
    rows = [
        (code(name), f"{usual:.3g}", f"{low:.3g} to {high:.3g}")
        for name, usual, low, high in zip(PRIORS, *(end.tolist() for end in ends), strict=True)
    ]
    yield from table(("parameter", "usual value", "95 % of ships"), rows)


PAGES = {
    "methods": method_page,
    "causes": cause_page,
    "vessels": vessel_page,
    "families": family_page,
    "formats": format_page,
    "suites": suite_page,
    "commands": command_page,
    "indices-report": indices_report_page,
    "indices-example": indices_example,
    "indices-accuracies": indices_accuracies,
    "indices-priors": indices_priors,
}
