"""Studies: named computations that are repeated over noise seeds; a paper's file `studies` has them as `STUDIES`."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from itertools import chain, repeat
from typing import Any

import numpy as np

from ...datasets.record import Record
from ...estimation.estimates.estimate import Estimate
from ...methods.registry import make
from ...models.errors import FitFailed
from ...models.model import Model
from ..claims.claim import Figure, SettingSearch
from ..claims.files import load


@dataclass(frozen=True)
class StudyResult:
    """One run of a study.

    values : key -> number, which claims refer to; nan where the computation diverged, True/False for statements.
    series : name -> array, what figures are drawn from.
    """

    values: Mapping[str, float]
    series: Mapping[str, np.ndarray] = field(default_factory=dict)


Results = Sequence[StudyResult]
Series = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class PaperStudy:
    """A computation `function(rng, index=i) -> StudyResult`, run for i = 0 .. seeds - 1.

    A deterministic one has one seed.  Only the runs of index below `drawn` keep their series.  `measured` is the
    measured set that it needs; without the data, the run in `stored/` is used instead.
    """

    function: Callable[..., StudyResult]
    seeds: int = 1
    drawn: int = 1
    measured: str = ""


def studies_of(paper: str) -> dict[str, PaperStudy]:
    """The studies of a paper, `"003"`, by name."""
    return import_module(f".paper_{paper}.studies", __package__).STUDIES


def drawing(paper: str, figure: Figure, results: Results) -> Callable[[Any], None]:
    """What draws a figure of a study's results on an empty matplotlib figure.

    The paper's function takes the axes, an array (n,) of several, the series of the first run that has any, and all
    results.
    """
    plot = getattr(import_module(f".paper_{paper}.figures", __package__), figure.draw)
    series = next((result.series for result in results if result.series), {})

    def draw(canvas: Any) -> None:
        if figure.size is not None:
            canvas.set_size_inches(*figure.size)
        panels = np.ravel(canvas.subplots(*figure.panels, sharex="x" in figure.share, sharey="y" in figure.share))
        plot(panels if panels.size > 1 else panels[0], series, results)
        for panel, own in zip(panels, chain(figure.axes, repeat({})), strict=False):
            facts = {**figure.every, **own}
            legend = facts.pop("legend", None)
            panel.set(**facts)
            if legend is not None:
                panel.legend(**legend)
        for axis, label in figure.labels.items():
            getattr(canvas, f"sup{axis}label")(label)
        if figure.below:
            handles = panels[0].get_legend_handles_labels()
            canvas.legend(*handles, loc="outside lower center", ncols=figure.below)

    return draw


def stream(paper: str, study: str, index: int, seed: int = 0) -> np.random.Generator:
    """The random numbers of one run: the same in every process and independent of all other runs and seeds."""
    digest = hashlib.sha256(f"{paper}/{study}".encode()).digest()
    words = [int.from_bytes(digest[:16], "big"), index] + ([seed] if seed else [])
    return np.random.default_rng(np.random.SeedSequence(words))


def fitted(method: str, records: Sequence[Record], model: Model) -> Estimate | None:
    """What a method, as the registry writes it, finds in records; None where it finds nothing finite."""
    try:
        return make(method).fit(records, model)
    except FitFailed:
        return None


def settings_at(paper: str, study: str, index: int) -> dict[str, Any]:
    """The settings of run `index` of a paper's search, see `point`."""
    return point(load(paper).search(study), index)


def point(search: SettingSearch, index: int) -> dict[str, Any]:
    """The settings of run `index` of a search: a Halton point over its ranges and choices, the same for every seed."""
    from scipy.stats import qmc

    names = [*search.ranges, *search.choices]
    unit = qmc.Halton(len(names), scramble=False).fast_forward(index + 1).random(1)[0]
    found: dict[str, Any] = {}
    for name, share in zip(names, unit.tolist(), strict=True):
        if name in search.ranges:
            r = search.ranges[name]
            low, high = (np.log(r.low), np.log(r.high)) if r.log else (r.low, r.high)
            value = float(low + share * (high - low))
            found[name] = float(np.exp(value)) if r.log else value
        else:
            found[name] = search.choices[name][int(share * len(search.choices[name]))]
    return found
