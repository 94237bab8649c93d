"""The records that are changed: three simulated ships and two measured sets, and the model that is asked; and measured
craft of which there is no model, for `check` alone."""

from dataclasses import dataclass
from functools import lru_cache

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.io import read_record
from helmbench.datasets.measured import data_dir, load
from helmbench.datasets.record import Record
from helmbench.models.model import resolve

MANOEUVRES = ("zigzag:20/20", "turn:25", "zigzag:10/10:port")


@dataclass(frozen=True)
class SimulatedShip:
    """A simulated ship: seconds and step of its records."""

    seconds: float
    step_s: float
    known: frozenset[str] = frozenset()
    family: str = "nomoto-1"

    def records(self, name: str) -> list[Record]:
        """A record of each manoeuvre with low noise."""
        length = {"duration_s": self.seconds, "dt_s": self.step_s}
        return [generate(Case(name, m, "low", seed=i, **length)) for i, m in enumerate(MANOEUVRES)]


@dataclass(frozen=True)
class MeasuredShip:
    """A measured set: the model that is asked, the runs, every which of their samples is kept, and what the set is
    known to have where every sample is."""

    model: str
    stems: tuple[str, ...]
    every: int
    folder: str
    known: frozenset[str] = frozenset()
    family: str = "nomoto-1"

    def records(self, name: str) -> list[Record]:
        """The runs, thinned."""
        return [load(name, stem).thinned(self.every) for stem in self.stems]


SHIPS = {
    "mariner": SimulatedShip(200.0, 1.0),
    "response-1": SimulatedShip(200.0, 1.0),
    "kvlcc2-l7": SimulatedShip(120.0, 0.5),
}
SETS = {
    "kvlcc2-hsva": MeasuredShip("kvlcc2-l7", ("Z_20_10_S", "Z_10_05", "Z_10_10_P"), 8, "kvlcc2"),
    "esso-osaka": MeasuredShip(
        "esso-osaka-l3",
        ("zigzag_31-Jul-2020_13_42_53", "zigzag_31-Jul-2020_13_57_45"),
        4,
        "esso_osaka",
        frozenset({"outliers"}),
    ),
}


@dataclass(frozen=True)
class MeasuredCraft:
    """A measured craft without a model: samples that are kept of a run, and what `check` finds in some of its runs."""

    samples: int = 600
    known: frozenset[str] = frozenset()

    def records(self, name: str) -> list[Record]:
        """All its runs, thinned."""
        records = [read_record(path) for path in sorted((data_dir() / name).glob("*.csv"))]
        return [record.thinned(max(round(record.n / self.samples), 1)) for record in records]


CRAFT = {
    "blueboat": MeasuredCraft(),
    "otter": MeasuredCraft(),
    "vtec": MeasuredCraft(),
    "expedition_horta": MeasuredCraft(known=frozenset({"velocity_delay"})),  # of two runs, where the third is torn
}
FLEET = SHIPS | SETS | CRAFT


def at_hand(name: str) -> bool:
    """Whether the records can be had on this machine."""
    return name in SHIPS or (data_dir() / (SETS[name].folder if name in SETS else name)).exists()


@lru_cache(maxsize=len(FLEET))
def records_of(name: str) -> tuple[Record, ...]:
    """The records of a ship or set, made or read once."""
    return tuple(FLEET[name].records(name))


@lru_cache(maxsize=len(FLEET))
def model_of(name: str):
    """The model that is asked about the records."""
    return resolve(name if name in SHIPS else SETS[name].model)
