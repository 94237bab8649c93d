"""`helmbench simulate VESSEL --manoeuvre ... -o record.csv`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import FILE, NUMBER, SIDES, VESSEL, WholeRange, check_file, echo, force_option, output_options, print_json


@click.command()
@click.argument("vessel", type=VESSEL)
@click.option("--manoeuvre", required=True, help="For example zigzag:20/20 or turn:35:port.")
@click.option("--duration", "duration_s", type=NUMBER, help="Seconds; default: the vessel file's.")
@click.option("--dt", "dt_s", type=NUMBER, help="Sampling step in seconds; default: the vessel file's.")
@click.option("--noise", default="none", show_default=True, help="none, low, medium, high, or yaw_rate=0.05deg_s,...")
@click.option(
    "--disturbance", default="none", show_default=True, help="wind:12@40deg, current:..., waves:..., joined by +."
)
@click.option("--seed", type=WholeRange(min=0), default=0, show_default=True)
@click.option("--positive-rudder", type=SIDES, help="Side of a positive rudder in the file; default: the vessel's.")
@click.option(
    "-o", "--output", default="record.csv", show_default=True, type=FILE, help="record.csv or .parquet to write"
)
@force_option
@output_options
def simulate(
    vessel: str,
    manoeuvre: str,
    duration_s: float | None,
    dt_s: float | None,
    noise: str,
    disturbance: str,
    seed: int,
    positive_rudder: str | None,
    output: Path,
    force: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Simulate a manoeuvre; writes a record with its sidecar."""
    import helmbench

    check_file(output, force)
    record = helmbench.simulate(
        vessel, manoeuvre, noise=noise, disturbance=disturbance, seed=seed, duration_s=duration_s, dt_s=dt_s
    )
    record = record.turned(positive_rudder) if positive_rudder else record
    helmbench.write_record(record, output)
    facts = {"record": str(output), "vessel": vessel, "samples": record.n, "dt_s": record.dt}
    if as_json:
        print_json(facts | {"channels": list(record.channels), "positive_rudder": record.meta.positive_rudder})
    elif not quiet:
        echo(f"{output}: {record.n} samples every {record.dt:g} s, {', '.join(record.channels)}")
