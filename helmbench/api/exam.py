"""The open exam: worlds with hidden changes, answers of any method, scores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from ..models.argument_types import typed
from ..models.extras import extras_told
from ..models.files import content_writer, write_together
from ..models.plain import json_text, plain
from .diagnosis import shown_stages

if TYPE_CHECKING:
    import pandas as pd

    from ..bench.exam.scores import EntrantScore, WorldScore


@dataclass(frozen=True, repr=False)
class ExamScores:
    """Scores of submissions to an exam: `scores` by entrant and kind of world (`all`: over all), `answers` by world."""

    files: ClassVar = ("scores.json", "scores.csv", "scores.md")
    scores: tuple[EntrantScore, ...]
    answers: tuple[WorldScore, ...]

    def summary(self) -> str:
        """The tables as plain text."""
        from ..reporting.exam import summary

        return summary(self.scores, self.answers)

    @extras_told()
    def to_dataframe(self) -> pd.DataFrame:
        """A row an entrant and kind of world."""
        import pandas as pd

        return pd.DataFrame([vars(one) for one in self.scores])

    def to_json(self) -> dict[str, Any]:
        """Plain values: scores and answers."""
        return {"scores": plain(self.scores), "answers": plain(self.answers)}

    def write(self, folder: str | PathLike[str]) -> tuple[Path, ...]:
        """Write scores.json, scores.csv and scores.md into a folder: all of them or none.

        Raises
        ------
        BadInput : the folder cannot be written to.
        """
        from ..reporting.exam import page, scores_csv

        texts = (json_text(self.to_json()) + "\n", scores_csv(self.scores), page(self.scores, self.answers))
        writers = {name: content_writer(text) for name, text in zip(self.files, texts, strict=True)}
        return write_together(Path(folder), writers)

    def __repr__(self) -> str:
        entrants = len({one.entrant for one in self.scores})
        return f"<ExamScores of {entrants} entrants: {len(self.answers)} answers>"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self.summary())}</pre>"


@typed
def make_exam(
    folder: str | PathLike[str],
    key: str | PathLike[str],
    *,
    suite: str = "exam",
    worlds: int = 12,
    seed: int | None = None,
    vessels: Sequence[str] = (),
    progress: bool = False,
) -> str:
    """Draw an exam: a folder to hand out, and the key that is kept back.

    Parameters
    ----------
    folder : a new or empty directory.
    key : file of the answers; keep it outside the exam.
    suite : a suite of diagnoses, or its file, whose cases become worlds.
    worlds : how many are drawn; every kind comes once before any comes again.
    seed : whoever knows it has the answers; None: a new one, which only the key holds.
    vessels : only these ships of the suite.
    progress : show on standard error which world is being made.

    Returns
    -------
    The identifier of the exam, which submissions name.

    Raises
    ------
    BadInput : the folder is not empty, the key exists or lies in the folder, or the suite has too few cases.
    """
    from ..bench.exam.folder import make
    from ..reporting.exam import folder_texts

    with shown_stages(progress, "making") as watch:
        return make(Path(folder), Path(key), folder_texts, suite, worlds, seed, vessels, watch).id


@typed
def answer_exam(
    folder: str | PathLike[str], diagnoser: str, directory: str | PathLike[str], *, progress: bool = False
) -> dict[str, str]:
    """Answer an exam with a diagnoser of helmbench; writes submission.json and the predicted motion.

    Parameters
    ----------
    folder : the exam.
    diagnoser : one of `list_diagnosers`, or path.py:Class.
    directory : a new or empty directory.
    progress : show on standard error which world is being answered.

    Returns
    -------
    World -> why the diagnoser failed there; such a world is left out, which says that nothing is wrong.

    Raises
    ------
    BadInput : the folder holds no exam or was changed, there is no such diagnoser, or the directory is in use.
    """
    from ..bench.exam.answers import answer

    with shown_stages(progress, f"{diagnoser} answers") as watch:
        return answer(Path(folder), diagnoser, Path(directory), watch)


@typed
def score_exam(
    folder: str | PathLike[str],
    submissions: str | PathLike[str] | Sequence[str | PathLike[str]],
    key: str | PathLike[str],
) -> ExamScores:
    """Score submissions to an exam with its key.

    Parameters
    ----------
    folder : the exam.
    submissions : one or several: their JSON files, or the directories that hold submission.json.
    key : file of the answers.

    Raises
    ------
    BadInput : the exam was changed, the key is of another exam, or a submission cannot be used; in one line with world
        and key.
    """
    from ..bench.exam.scores import score

    given = [submissions] if isinstance(submissions, str | PathLike) else submissions
    scores, answers = score(Path(folder), Path(key), [Path(one) for one in given])
    return ExamScores(tuple(scores), tuple(answers))
