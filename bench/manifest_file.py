"""What `environment.json` of a run directory holds, as far as anything is read from it."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import ConfigDict, Field

from ..models.yaml_file import Count, FileContent, Text, needs

WholeNumber = Annotated[int, Field(strict=True, ge=0), needs("a whole number of at least 0")]


class _Selection(FileContent):
    """What of the suite was asked for; see `kinds.base.Selection`."""

    model_config = ConfigDict(extra="allow", frozen=True)

    suite: Text = "quick"
    methods: tuple[Text, ...] | None = None
    vessels: tuple[Text, ...] | None = None
    seeds: Count | None = None
    seed: WholeNumber | None = None


class MergedFile(FileContent):
    """Results that were merged: digest of their journal, how many runs were added, how many of them were computed again
    with which seed of the sample, and which runs of the sample could not be."""

    journal: Text
    added: WholeNumber
    recomputed: WholeNumber
    seed: WholeNumber
    not_computable: tuple[Text, ...] = ()


class ManifestFile(FileContent):
    """Keys that reports and `--resume` read; the others say with what the run was made."""

    model_config = ConfigDict(extra="allow", frozen=True)

    suite: Text
    version: Text
    planned: WholeNumber
    kind: Text = "identification"
    title: Text = ""
    selection: _Selection = _Selection()
    seeds: Text = ""
    packages: dict[str, Any] | None = None
    merged: tuple[MergedFile, ...] = ()
