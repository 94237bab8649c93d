"""The page of a diagnosis as Markdown with figures, for publishing: it carries no series, measured or simulated, only
statistics of the errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import tables
from ..numbers import p_value, percent, with_unit
from ..report import listed, sentences
from ..validation.tables import horizon_table, trusted_lines
from . import words
from .figures import figures
from .panels import CHANNELS
from .tables import bank_table, error_table, gain_table, instrument_rows, where_table

if TYPE_CHECKING:
    from ...diagnosis.result import Diagnosis, Finding


def write_markdown(found: Diagnosis, folder: str | Path, name: str, title: str, note: str = "") -> tuple[Path, ...]:
    """Write `name`.md and its figures `name`-*.svg into a folder, all of them or none; the paths."""
    from ...models.files import replace_together
    from ...models.folders import make_folder

    folder = Path(folder)
    make_folder(folder)
    drawn = figures(found)
    texts = {f"{name}.md": markdown(found, title, note, {key: f"{name}-{key}.svg" for key in drawn})}
    texts |= {f"{name}-{key}.svg": svg for key, svg in drawn.items()}
    paths = {folder / file: text for file, text in texts.items()}
    replace_together({path: _writer(text) for path, text in paths.items()})
    for stale in set(folder.glob(f"{name}-*.svg")) - set(paths):
        stale.unlink()
    return tuple(paths)


def _writer(text: str) -> Callable[[Path], Any]:
    return lambda place: place.write_text(text, "utf-8")


def markdown(found: Diagnosis, title: str, note: str, files: Mapping[str, str]) -> str:
    """The Markdown text; `files` has the file name of each of `figures`."""
    where = tables.markdown(where_table(found)) if found.where else "Under no particular condition."
    errors = error_table(found)
    gain = tables.markdown(gain_table(found)) if found.gain else "No gain was measured."
    parts = [
        f"# {title}",
        note,
        f"**{words.headline(found)}** {words.verdict(found)}",
        words.sentence(found.reason),
    ]
    parts += [_finding(finding) for finding in found.causes]
    for number, force in enumerate(found.remaining, 1):
        parts += [f"- {words.remaining(force)}"]
        parts += [
            _figure(files, f"remaining-{number}", "The force with its 90 % band, where the records hold data", "")
        ]
    parts += ["## 1. What was simulated and what was measured", STATISTICS]
    parts += [tables.markdown(errors) if errors.rows else ""]
    parts += [_figure(files, "errors", "Root mean square errors of the free runs")]
    parts += ["## 2. Where the errors arise", where]
    parts += ["## 3. The causes that were tested", tables.markdown(bank_table(found))]
    parts += ["## 4. The extended model", *_equations(found)]
    parts += ["## 5. Before and after, on held-out records", gain]
    parts += [
        _figure(files, f"spectrum-{name}", f"Spectrum of the {words.channel(name)[0]} errors") for name in CHANNELS
    ]
    parts += _ahead(found)
    parts += ["## Made with", listed([row for row in words.facts(found) if row[0] != "time"])]
    return "\n\n".join(part for part in parts if part) + "\n"


def _ahead(found: Diagnosis) -> list[str]:
    """Errors some time ahead beside predictions without a model; nothing where none were computed."""
    if found.ahead is None:
        return []
    said = f"Root mean square errors ahead; {found.ahead.horizon_basis}."
    told = sentences(f"{line}." for line in trusted_lines(found.ahead))
    return ["## 6. How far ahead", said, tables.markdown(horizon_table(found.ahead)), told]


STATISTICS = (
    "Statistics of the free-run errors (measured minus simulated) of every record; the series themselves are not "
    "published here. Correlation: autocorrelation of the error at that lag (0 for sensor noise)."
)


def _finding(finding: Finding) -> str:
    lines = [f"- **{words.tie(finding)}** ({finding.stage}, adjusted p {p_value(finding.p_adjusted)})"]
    lines += [f"  - {words.size(item)} ({percent(finding.level)} interval)" for item in finding.sizes]
    lines += [f"  - {text}" for text in (words.said(finding.evidence), words.separation(finding)) if text]
    return "\n".join(lines)


def _equations(found: Diagnosis) -> list[str]:
    from ..equations import equations

    if not found.extends:
        return ["The model stays as it is."]
    extended = equations(found.extended, found.model)
    blocks = [f"$$\n{line.latex}\n$$" for line in (*extended.relations, *extended.dynamics) if line.new]
    values = [f"- ${symbol}$ ({name}): {with_unit(value, unit, 4)}" for _, symbol, name, value, unit in extended.added]
    values += [f"- {name}: {value}" for name, value in instrument_rows(found)]
    return ["Equations that are new or changed:", *blocks, "\n".join(values)]


def _figure(files: Mapping[str, str], name: str, caption: str, colours: str = "; red: before, blue: after") -> str:
    return f"![{caption}]({files[name]})\n\n*{caption}{colours}.*" if name in files else ""
