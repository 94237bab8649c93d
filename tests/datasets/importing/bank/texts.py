"""Writers of tables as text."""

from pathlib import Path

import numpy as np

from .truth import KN, START, Run

D = 180.0 / np.pi


def iso(run: Run) -> list[str]:
    return [str(np.datetime64(round(1e3 * (START + t)), "ms")) for t in run.t]


def fixed(values, digits=3) -> list[str]:
    return [f"{value:.{digits}f}" for value in values]


def series(run: Run) -> dict[str, list[str]]:
    """What loggers show of a run, as texts: degrees, knots."""
    return {
        "t": fixed(run.t, 2), "iso": iso(run), "heading": fixed(run.psi * D % 360.0, 2),
        "rot_min": fixed(60 * run.r * D, 2),
        "rot_s": fixed(run.r * D, 4), "rudder": fixed(run.delta * D, 2), "order": fixed(run.order * D, 1),
        "sog": fixed(run.sog / KN, 3), "cog": fixed(run.cog * D, 2), "lat": fixed(run.lat, 8), "lon": fixed(run.lon, 8),
        "u": fixed(run.u, 4), "v": fixed(run.v, 4), "north": fixed(run.north, 3), "east": fixed(run.east, 3),
        "roll": fixed(run.roll * D, 3), "rpm": fixed(60 * run.rps, 2), "rps": fixed(run.rps, 4),
        "psi_rad": fixed(run.psi % (2 * np.pi), 5), "r_rad": fixed(run.r, 6), "delta_rad": fixed(run.delta, 5),
    }  # fmt: skip


def table(
    path: Path, columns: dict[str, list[str]], sep=",", head=(), encoding="utf-8", comma=False, units=(), quote=False
) -> list[Path]:
    """Write a table; `comma`: decimal commas in all columns that are numbers; `quote`: names in quotes."""
    rows = [list(row) for row in zip(*columns.values(), strict=True)]
    if comma:
        rows = [
            [x.replace(".", ",") if x.lstrip("-").replace(".", "", 1).isdigit() else x for x in row] for row in rows
        ]
    names = [f'"{name.replace(chr(34), 2 * chr(34))}"' if quote else name for name in columns]
    lines = [*head, sep.join(names), *([sep.join(units)] if units else []), *(sep.join(row) for row in rows)]
    path.write_bytes(("\r\n".join(lines) + "\r\n").encode(encoding))
    return [path]


def texts(name: str, make, **options):
    """A writer of one table: `make` gives its columns from the texts of a run and the run."""

    def write(run: Run, folder: Path) -> list[Path]:
        return table(folder / name, make(series(run), run), **options)

    return write
