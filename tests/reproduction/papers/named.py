"""What a claims file names, against what the studies and drawings of its paper give."""

from helmbench.reporting.plots import svg
from helmbench.reproduction.claims import files
from helmbench.reproduction.papers.study import StudyResult, drawing, stream, studies_of


def run(paper: str, study: str, index: int = 0) -> StudyResult:
    return studies_of(paper)[study].function(stream(paper, study, index), index=index)


def unnamed(paper: str, results: dict[str, StudyResult]) -> list[str]:
    """Keys that claims and references of the paper name and that the results do not have."""
    whole = files.load(paper)
    named = [(c.study, key) for c in whole.claims if c.study for key in (c.corrected, c.as_printed) if key]
    named += [(check.study, check.key) for check in whole.checks()]
    return [f"{study}: {key}" for study, key in named if key not in results[study].values]


def drawn(paper: str, results: dict[str, StudyResult]) -> dict[str, int]:
    """Size of every figure of the paper whose study has a result, in bytes."""
    shown = [figure for figure in files.load(paper).figures if figure.study in results]
    return {figure.id: len(svg(drawing(paper, figure, [results[figure.study]]))) for figure in shown}
