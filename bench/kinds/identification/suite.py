"""Suite files of kind `identification`: every entry is the full product of its lists."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from ....models.yaml_file import Count, Counts, FileContent, Flag, Positive, Real, Shares, Side, Text, TextGroups, Texts


class RunsHead(FileContent):
    """Keys of the file beside its entries."""

    title: Text = ""
    kind: Literal["identification"] = "identification"


class Records(FileContent):
    """Records of the user's own: paths, beside the suite file or from the working directory.

    train, held_out : a list of lists makes one row of each.
    ship : what the tables call the ship.
    positive_rudder : side of a positive rudder in the files; default: their sidecars'.
    """

    train: TextGroups
    held_out: TextGroups
    ship: Text = "own ship"
    positive_rudder: Side | None = None


class RunsEntry(FileContent):
    """One product of lists.

    vessels : ids, files of vessels or particulars, or one of `all`, `3dof`, `response` (every vessel of that kind).
    records : instead of vessels, records of the user's own.
    dataset : instead of vessels, a measured set; `train` and `held_out` then hold the names of its records.
    models : families, vessels or files of models to fit; `own` is the vessel's own.
    methods : method texts (`ls`, `ls,scheme=midpoint`, `rls,variant=as_printed`, `path.py:Class`), or groups of
        the registry's: `all`, `identification` (those that estimate a model's coefficients), `learners` (black boxes,
        hybrids and floors).
    constants : factor by constant of the fitted model, which is then wrong on purpose.
    terms : extension -> its parameters, a force that the ship has and the fitted model lacks.
    optional : true: left out where its records are not on this machine.
    open : false: only these methods, also when `--method` asks for others.
    train, held_out : manoeuvres (default: the vessel file's); a list of lists makes one row of each.
    euler : training records are made by the explicit Euler difference equation.
    noise, disturbance : texts as the command line takes them; of measured records, only the channels that are taken
        away (`none,only=heading`).
    thinning : every how many-th sample of the training records is kept.
    length : shares of the training records that are kept, from their start.
    held_out_noise, held_out_disturbance : of the held-out records, which have neither without them.
    held_out_speed : of a held-out record's first sample, as a share of the vessel's; the propeller stays as it is set.
    held_out_dataset : the measured set that the held-out records come from; default: `dataset`.
    seeds : number of seeds; duration_s, dt_s : of the training and held-out records.
    """

    vessels: Texts = ("all",)
    dataset: Text | None = None
    records: Records | None = None
    models: Texts = ("own",)
    methods: Texts = ("all",)
    constants: dict[str, Positive] = Field(default_factory=dict)
    terms: dict[str, dict[str, Real]] = Field(default_factory=dict)
    optional: Flag = False
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
    held_out_noise: Text = "none"
    held_out_disturbance: Text = "none"
    held_out_speed: Positive = 1.0
    held_out_dataset: Text | None = None

    @model_validator(mode="after")
    def _records_are_named(self) -> RunsEntry:
        if self.records and (self.dataset or self.train or self.held_out):
            raise ValueError("records have their own train and held_out, and no dataset")
        if self.records and "own" in self.models:
            raise ValueError("records need models: families such as nomoto-1-cubic, vessels, or files of models")
        if self.dataset and not (self.train and self.held_out):
            raise ValueError("a dataset entry needs train and held_out")
        if self.held_out_dataset and not self.dataset:
            raise ValueError("held_out_dataset needs a dataset")
        conditions = (self.held_out_noise, self.held_out_disturbance, self.held_out_speed)
        measured = self.dataset or self.records
        if measured and conditions != ("none", "none", 1.0):
            raise ValueError("held-out records of a dataset are as they were measured")
        selected = all(
            part.partition("=")[0] in ("none", "only", "without") for t in self.noise for part in t.split(",")
        )
        if measured and not selected:
            raise ValueError("the noise of measured records is none; only=... and without=... take channels away")
        if measured and self.terms:
            raise ValueError("terms are for simulated ships")
        if self.optional and not measured:
            raise ValueError("optional is for measured records")
        if measured and (self.duration_s or self.dt_s):
            raise ValueError("duration_s and dt_s are for simulated records; thinning and length for measured ones")
        return self


MODELS = (RunsHead, RunsEntry)
