"""Do the verdicts depend on the random numbers?  Two reproductions with different seeds, compared.

`python -m helmbench.reproduction.stability DIR DIR` takes the folders of two calls of `helmbench reproduce -o`.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from . import results
from .claims import files
from .pages import across

MOST = 0.02
"""Share of the verdicts that may change."""


def verdicts(directory: Path) -> dict[str, str]:
    """Paper and claim -> verdict, from the results stored in the folder `pages`."""
    return {
        f"{name} {judged.claim.id}": judged.verdict
        for name in files.papers()
        for judged in results.read(name, directory / "pages").judged(files.load(name))
    }


def headlines(directory: Path) -> dict[str, str]:
    """Paper -> the words of the first page: on its own example, and on all vessels."""
    others = results.read(files.ACROSS, directory / "pages")
    found = {}
    for name in files.papers():
        paper = files.load(name)
        if paper.headline is not None:
            own = across.joined(across.own(paper, results.read(name, directory / "pages")))
            found[f"{name} headline"] = f"{own}; {across.on_vessels(paper.headline, others)}"
    return found


def changes(first: dict[str, str], second: dict[str, str]) -> list[tuple[str, str, str]]:
    """Name of a claim, or of an answer of the first page, and both entries, where they differ."""
    return [(what, first[what], second[what]) for what in first if first[what] != second[what]]


def main(arguments: Sequence[str]) -> int:
    """Print what differs; status 1 where more than `MOST` of the verdicts do, or a headline does."""
    one, two = (Path(argument) for argument in arguments)
    first = verdicts(one)
    changed, turned = changes(first, verdicts(two)), changes(headlines(one), headlines(two))
    for what, before, after in [*changed, *turned]:
        print(f"{what}: {before} -> {after}")
    share = len(changed) / len(first)
    print(f"{len(changed)} of {len(first)} verdicts ({share:.1%}) and {len(turned)} headlines changed")
    return int(share > MOST or bool(turned))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
