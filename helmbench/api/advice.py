"""The advice of a leaderboard, tested in fresh situations."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from html import escape
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..models.argument_types import typed
from ..models.errors import BadInput
from ..models.plain import json_text, plain

if TYPE_CHECKING:
    from os import PathLike

    from ..bench.situations import Situation
    from ..reporting.leaderboard.advice import Tested
    from ..reporting.leaderboard.contest import Contest

PAGE, ROWS, RUNS, CHOICES = "advice.md", "advice.json", "runs", "choices"
PARTICULARS = "particulars.json"


@dataclass(frozen=True, repr=False)
class AdviceTest:
    """What the advice of a leaderboard is worth: in words, a row a situation, and the page and rows that were written.

    `rows` hold the situation, the advised and the best method with their errors, and the regret: the ratio of both.
    """

    text: str
    rows: tuple[dict[str, Any], ...]
    paths: tuple[Path, ...]

    def summary(self) -> str:
        """How often the advice is good, in sentences."""
        return self.text

    def to_json(self) -> dict[str, Any]:
        """Plain values for `--json`."""
        return {"situations": list(self.rows), "files": [str(path) for path in self.paths]}

    def __repr__(self) -> str:
        return f"<AdviceTest of {len(self.rows)} situations>"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self.text)}</pre>"


@typed
def check_advice(
    board: str | PathLike[str],
    *,
    directory: str | PathLike[str],
    situations: int = 60,
    seed: int = 0,
    methods: Sequence[str] = (),
    jobs: int | None = None,
    timeout_s: float | None = None,
    progress: bool = False,
) -> AdviceTest:
    """Draw fresh situations, ask a leaderboard which method to take, run all methods, and compare.

    A situation is a ship, its own or simpler equations, manoeuvres to learn from and to predict, sensor noise, channels
    and a disturbance.  Where the equations are not the ship's own but her file states her particulars, the simulation
    that they give, corrected by the training records, is advised.  Beside the method that the board names, its list of
    methods is tested: the one is taken that errs least on one more record.  An interrupted test goes on where it
    stopped when it is called again, also with another board.

    Parameters
    ----------
    board : directory of the results of a suite, or a published leaderboard.
    directory : of the runs and of the page, `advice.md`.
    situations : how many are drawn.
    seed : seed from which they are drawn.
    methods : only these methods; none: all, with the robust output error.
    jobs : worker processes, at most one for each processor; None: one for each processor.
    timeout_s : seconds after which a run is ended and kept as a failed one.
    progress : show a progress bar on standard error.

    Raises
    ------
    BadInput : the board holds no results, or the directory those of other situations.
    """
    from ..bench.situations import SUITE, checks_text, draw, suite_text
    from ..models.folders import make_folder
    from ..reporting.leaderboard import advice

    if situations < 1:
        raise BadInput(f"situations is {situations}, at least 1 is needed")
    rule, folder, drawn = _contest(Path(board)), Path(directory), list(dict.fromkeys(draw(situations, seed)))
    make_folder(folder)
    options = {"jobs": jobs, "timeout_s": timeout_s, "progress": progress}
    text = suite_text(drawn, methods or ("all", "output-error,loss=student"))
    suite = folder / SUITE
    if suite.is_file() and suite.read_text() != text:
        raise BadInput("holds other situations", file=suite, hint="give a new directory with -o")
    fresh = _run(suite, text, folder / RUNS, options)
    advised = advice.advices(rule, fresh, drawn)
    if not advised:
        return _written(folder, [], len(drawn), seed)
    text = checks_text({one: own.listed for one, own in advised.items()})
    name = f"{CHOICES}-{sha256(text.encode()).hexdigest()[:8]}"
    checks = _run(folder / f"{name}.yaml", text, folder / name, options)
    found = advice.tested(advised, fresh, checks, _by_particulars(folder, [*filter(advice.unknown, advised)]))
    return _written(folder, found, len(drawn), seed)


def _run(suite: Path, text: str, folder: Path, options: Mapping[str, Any]) -> Contest:
    """The contest of the runs of a suite file, which is written; goes on where it stopped."""
    from ..models.folders import write_atomic
    from .suites import run_suite

    write_atomic(suite, text.encode())
    run_suite(str(suite), directory=folder, resume=True, trust=True, **options)
    return _contest(folder)


def _by_particulars(folder: Path, situations: Sequence[Situation]) -> dict[Situation, list[float]]:
    """Errors by the corrected simulation of each ship whose particulars are known; goes on where it stopped."""
    from ..bench.corrected_particulars import errors_of
    from ..models.folders import write_atomic

    path = folder / PARTICULARS
    stored: dict[str, list[float | None] | None] = json.loads(path.read_text()) if path.is_file() else {}
    for one in situations:
        if str(one) not in stored:
            errors = errors_of(one)
            stored[str(one)] = plain(errors)
            write_atomic(path, f"{json_text(stored)}\n".encode())
    found = {one: stored[str(one)] for one in situations}
    return {one: [inf if e is None else e for e in errors] for one, errors in found.items() if errors is not None}


def _contest(folder: Path) -> Contest:
    from ..bench.store import read_tables
    from ..reporting.leaderboard.board import build
    from ..reporting.leaderboard.publish import ranked_and_tuning

    results, parameters = read_tables(folder)
    if results.empty:
        raise BadInput("no run is finished yet", file=folder)
    return build(ranked_and_tuning(results)[0], parameters).contest


def _written(folder: Path, tested: Sequence[Tested], drawn: int, seed: int) -> AdviceTest:
    from ..reporting.leaderboard import advice
    from ..reporting.report import write_files

    rows = tuple(advice.as_rows(tested))
    texts = {PAGE: advice.report(tested, drawn, seed), ROWS: f"{json_text(rows)}\n"}
    return AdviceTest(advice.summary(tested), rows, write_files(folder, texts))
