"""Suite files of kind `identification`: every entry is the full product of its lists."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from ....models.yaml_file import Count, Counts, FileContent, Flag, Positive, Shares, Text, TextGroups, Texts


class Head(FileContent):
    """Keys of the file beside its entries."""

    title: Text = ""
    kind: Literal["identification"] = "identification"


class Entry(FileContent):
    """One product of lists.

    vessels : ids, or one of `all`, `3dof`, `response` (every vessel of that kind).
    dataset : instead of vessels, a measured set; `train` and `held_out` then hold the names of its records.
    models : families to fit; `own` is the vessel's own.
    methods : method texts (`ls`, `ls,scheme=midpoint`, `rls,variant=as_printed`, `path.py:Class`); `all` stands for
        every method of the registry.
    open : false: only these methods, also when `--method` asks for others.
    train, held_out : manoeuvres (default: the vessel file's); a list of lists makes one row of each.
    euler : training records are made by the explicit Euler difference equation.
    noise, disturbance : texts as the command line takes them.
    thinning : every how many-th sample of the training records is kept.
    length : shares of the training records that are kept, from their start.
    seeds : number of seeds; duration_s, dt_s : of the training records.
    """

    vessels: Texts = ("all",)
    dataset: Text | None = None
    models: Texts = ("own",)
    methods: Texts = ("all",)
    open: Flag = True
    train: TextGroups = ()
    held_out: TextGroups = ()
    euler: Flag = False
    noise: Texts = ("none",)
    disturbance: Texts = ("none",)
    thinning: Counts = (1,)
    length: Shares = (1.0,)
    seeds: Count = 1
    duration_s: Positive | None = None
    dt_s: Positive | None = None

    @model_validator(mode="after")
    def _records_are_named(self) -> Entry:
        if self.dataset and not (self.train and self.held_out):
            raise ValueError("a dataset entry needs train and held_out")
        return self
