"""The command line: parses, calls, prints.  Nothing heavy is imported before a command needs it.

Exit status: 0 done, 1 finished but some runs failed (they are listed), 2 bad input (one line, nothing written).
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

if TYPE_CHECKING:
    from .bench.runner import Selection
    from .bench.store import Store
    from .identification import Identification
    from .reproduction.claims.claim import Paper

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
KINDS = ("models", "vessels", "manoeuvres", "methods", "causes", "diagnosers", "suites")
SIDES = click.Choice(["port", "starboard"])
TUNERS = click.Choice(["abc", "tpe", "cmaes", "gp", "grid", "random"])


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and leave with its exit status."""
    sys.exit(status_of(arguments))


def status_of(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; bad input becomes one line on stderr and status 2."""
    try:
        result = cli(args=arguments, prog_name="helmbench", standalone_mode=False)
    except click.exceptions.Exit as leave:
        return leave.exit_code
    except (click.Abort, KeyboardInterrupt):
        return _complain("interrupted (a run is continued with --resume)", INTERRUPTED)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return BAD_INPUT
    except click.ClickException as error:
        return _complain(error.format_message(), BAD_INPUT)
    except (ValueError, OSError) as error:
        if not _is_bad_input(error):
            raise
        return _complain(str(error), BAD_INPUT)
    return result if isinstance(result, int) else OK


def _is_bad_input(error: Exception) -> bool:
    """Whether the user's input is at fault: said so by the code, or a file that the system refuses."""
    from .models.errors import BadInput

    return isinstance(error, BadInput) or (isinstance(error, OSError) and error.filename is not None)


def _complain(message: str, status: int) -> int:
    click.echo(f"helmbench: {' '.join(message.split())}", err=True)
    return status


class Greedy(click.Command):
    """A command whose options named in `greedy` take every value up to the next option: `--validate a.csv b.csv`."""

    greedy: tuple[str, ...] = ()

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        return super().parse_args(ctx, spread(args, self.greedy))


def spread(args: Iterable[str], greedy: Sequence[str]) -> list[str]:
    """`--x a b` as `--x a --x b` for the options in `greedy`."""
    out: list[str] = []
    current, repeat = "", False
    for arg in args:
        if arg.startswith("-") and arg != "-":
            current, repeat = arg, False
        elif current in greedy:
            out += [current] if repeat else []
            repeat = True
        out.append(arg)
    return out


class Identify(Greedy):
    """`identify RECORD... --validate RECORD...`"""

    greedy = ("--validate",)


class Diagnose(Greedy):
    """`diagnose --train RECORD... --held-out RECORD...`"""

    greedy = ("--train", "--held-out")


def _tuning_options(function: Callable) -> Callable:
    where = "Where studies are kept and shared: PATH.journal or sqlite:///PATH; default: in memory."
    function = click.option("--storage", help=where)(function)
    return click.option("--tuner", type=TUNERS, help="Tune the options that the methods declare.")(function)


def _output_options(function: Callable) -> Callable:
    function = click.option("--quiet", is_flag=True, help="Print nothing but results asked for and failures.")(function)
    return click.option("--json", "as_json", is_flag=True, help="Print JSON for machines.")(function)


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="helmbench", prog_name="helmbench")
def cli() -> None:
    """Benchmark methods that identify ship, USV and AUV manoeuvring models from records."""


@cli.command("list")
@click.argument("kind", type=click.Choice(KINDS), metavar="|".join(KINDS))
@click.option("--json", "as_json", is_flag=True, help="Print JSON for machines.")
def list_command(kind: str, as_json: bool) -> None:
    """List what is known: identifier and title."""
    found = _catalogue(kind)
    if as_json:
        _print_json([{"id": name, "title": title} for name, title in found.items()])
        return
    width = max(map(len, found), default=0)
    for name, title in found.items():
        click.echo(f"{name:<{width}}  {title}".rstrip())


@cli.command()
@click.argument("vessel")
@click.option("--manoeuvre", required=True, help="For example zigzag:20/20 or turn:35:port.")
@click.option("--duration", "duration_s", type=float, help="Seconds; default: the vessel file's.")
@click.option("--dt", "dt_s", type=float, help="Sampling step in seconds; default: the vessel file's.")
@click.option("--noise", default="none", show_default=True, help="none, low, medium, high, or yaw_rate=0.05deg_s,...")
@click.option("--disturbance", default="none", show_default=True, help="wind:12@40deg, current:..., waves:..., by +.")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True)
@click.option("--positive-rudder", type=SIDES, help="Side of a positive rudder in the file; default: the vessel's.")
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="record.csv or record.parquet")
@_output_options
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
    as_json: bool,
    quiet: bool,
) -> None:
    """Simulate a manoeuvre and write it as a record with its sidecar."""
    from .datasets.generator import Case, generate
    from .datasets.io import write_record

    _check_folder(output)
    record = generate(Case(vessel, manoeuvre, noise, disturbance, seed, duration_s, dt_s))
    record = record.turned(positive_rudder) if positive_rudder else record
    write_record(record, output)
    facts = {"record": str(output), "vessel": vessel, "samples": record.n, "dt_s": record.dt}
    if as_json:
        _print_json(facts | {"channels": list(record.channels), "positive_rudder": record.meta.positive_rudder})
    elif not quiet:
        click.echo(f"{output}: {record.n} samples every {record.dt:g} s, {', '.join(record.channels)}")


@cli.command(cls=Identify)
@click.argument("records", nargs=-1, required=True, metavar="RECORD...", type=click.Path(path_type=Path))
@click.option("--model", required=True, help="Vessel id, family id or model.json.")
@click.option("--method", required=True, help="Method id with options (ls,scheme=midpoint) or path.py:Class.")
@click.option(
    "--validate", multiple=True, metavar="RECORD...", type=click.Path(path_type=Path), help="Held-out records."
)
@click.option("--positive-rudder", type=SIDES, help="Side of a positive rudder in the files; overrides their sidecars.")
@click.option(
    "--identifiability", is_flag=True, help="Say what the records tell of each parameter, and what would help."
)
@_tuning_options
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="model.json to write")
@_output_options
def identify(
    records: tuple[Path, ...],
    model: str,
    method: str,
    validate: tuple[Path, ...],
    positive_rudder: str | None,
    identifiability: bool,
    tuner: str | None,
    storage: str | None,
    output: Path,
    as_json: bool,
    quiet: bool,
) -> int:
    """Identify a model from records, score it on others and write it as a model file (a black box has none)."""
    from .identification import identify as fit
    from .methods.tuned import with_tuner
    from .models.errors import FitFailed

    _check_folder(output)
    (method,) = with_tuner((method,), tuner, storage)
    try:
        found = fit(records, model, method, validate, positive_rudder, identifiability)
    except FitFailed as reason:
        return _complain(f"{method} failed on {model}: {reason}", FAILED)
    for doubt in found.warnings:
        click.echo(f"helmbench: warning: {doubt}", err=True)
    written = found.estimate.predictor is None
    if written:
        found.estimate.save(output)
    if as_json:
        _print_json(found.as_dict() | {"output": str(output) if written else None})
    elif not quiet:
        _print_identification(found, output)
    return OK


@cli.command(cls=Diagnose)
@click.option("--model", required=True, help="Vessel id, family id or model.json.")
@click.option(
    "--train", multiple=True, required=True, metavar="RECORD...", type=click.Path(path_type=Path), help="Records."
)
@click.option(
    "--held-out", multiple=True, metavar="RECORD...", type=click.Path(path_type=Path), help="Records for the gain."
)
@click.option(
    "--base-parameters",
    type=click.Choice(["file", "identify"]),
    help="Take the model's coefficients as known, or identify them along.  [default: file where it has any]",
)
@click.option("--coefficient-sd", default=0.0, show_default=True, help="Relative uncertainty of known coefficients.")
@click.option("--channels", help="Use these only: heading,yaw_rate,surge,sway,north,east.  [default: all there are]")
@click.option("--max-effects", type=click.IntRange(min=1), default=3, show_default=True, help="Most causes to name.")
@click.option("--alpha", default=0.01, show_default=True, help="Family-wise error level of the whole diagnosis.")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True)
@click.option("--positive-rudder", type=SIDES, help="Side of a positive rudder in the files; overrides their sidecars.")
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="directory of the results")
@_output_options
def diagnose(
    model: str,
    train: tuple[Path, ...],
    held_out: tuple[Path, ...],
    base_parameters: str | None,
    coefficient_sd: float,
    channels: str | None,
    max_effects: int,
    alpha: float,
    seed: int,
    positive_rudder: str | None,
    output: Path,
    as_json: bool,
    quiet: bool,
) -> None:
    """Show what a simulation gets wrong about records, name the cause, extend the model, measure the gain.

    Writes diagnosis.json, diagnosis.html and extended_model.json.
    """
    from .diagnosing import channel_columns, check_target, diagnose_files, write_diagnosis
    from .diagnosis.options import Options
    from .reporting.diagnosis.text import terminal

    check_target(output)
    options = Options(base_parameters, coefficient_sd, channel_columns(channels), max_effects, alpha, seed)
    found = diagnose_files(model, train, held_out, options, positive_rudder)
    paths = write_diagnosis(found, output)
    if as_json:
        _print_json(found.to_json())
    elif not quiet:
        click.echo(terminal(found))
        click.echo("\n".join(f"wrote {path}" for path in paths), err=True)


@cli.command()
@click.option("--suite", "suite", help="quick, default, measured, diagnosis, or a suite file.  [default: quick]")
@click.option("--method", "methods", multiple=True, help="Only these methods (repeatable); also path.py:Class.")
@click.option("--vessel", "vessels", multiple=True, help="Only these vessels (repeatable).")
@click.option("--seeds", type=click.IntRange(min=1), help="Number of seeds or rounds; default: the suite's.")
@click.option("--seed", type=click.IntRange(min=0), help="What diagnosis cases are drawn from; default: drawn anew.")
@click.option("--jobs", type=click.IntRange(min=1), help="Worker processes; default: one a processor.")
@click.option("--scheduler", help="Run on a dask cluster, tcp://host:port.")
@_tuning_options
@click.option("--resume", is_flag=True, help="Continue a run that was interrupted.")
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="directory of the results")
@_output_options
def run(
    suite: str | None,
    methods: tuple[str, ...],
    vessels: tuple[str, ...],
    seeds: int | None,
    seed: int | None,
    jobs: int | None,
    scheduler: str | None,
    tuner: str | None,
    storage: str | None,
    resume: bool,
    output: Path,
    as_json: bool,
    quiet: bool,
) -> int:
    """Run a suite; every finished run is kept at once."""
    from .bench.runner import Selection
    from .methods.tuned import with_tuner

    methods = with_tuner(methods, tuner, storage)
    given = Selection(suite or "quick", methods, vessels, seeds, seed)
    resume = resume and _started(output)
    if resume:
        stored = _stored_selection(output)
        asked = (suite, methods, vessels, seeds) != (None, (), (), None)
        given = replace(given if asked else stored, seed=stored.seed if seed is None else seed)
    store = _execute(output, given, resume, jobs, scheduler, quiet or as_json)
    return _summarise(store, as_json, quiet)


@cli.command()
@click.argument("directory", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--timing", type=click.Path(path_type=Path), help="Benchmark JSON to show; default: DIR/timing.json.")
@_output_options
def report(directory: Path, timing: Path | None, as_json: bool, quiet: bool) -> None:
    """Write the report of a run (Markdown, CSV and HTML) from stored results, without refitting."""
    from .reporting.report import write_report

    written = write_report(directory, timing)
    if as_json:
        _print_json(written.as_dict())
    elif not quiet:
        click.echo(written.markdown)
        click.echo("\n".join(f"wrote {path}" for path in written.paths), err=True)


@cli.command()
@click.argument("seed", required=False, metavar="[SEED]")
@click.option("--table", type=click.IntRange(min=1), help="Only the claims of this table.")
@click.option("--jobs", type=click.IntRange(min=1), help="Worker processes; default: one a processor.")
@click.option("--resume", is_flag=True, help="Continue a computation that was interrupted.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Keep runs, results and pages in this directory.")
@_output_options
def reproduce(
    seed: str | None, table: int | None, jobs: int | None, resume: bool, output: Path | None, as_json: bool, quiet: bool
) -> int:
    """Compute the tables and claims of the seed papers (SEED: 003 for one of them) and compare with what they print."""
    from tempfile import TemporaryDirectory

    from .models.errors import BadInput
    from .reproduction.session import select

    chosen = select(seed, table)
    show = not (quiet or as_json) and sys.stderr.isatty()
    if output is not None:
        return _reproduce(chosen, output, jobs, resume, show, as_json, quiet)
    if resume:
        raise BadInput("--resume needs the directory that was started", hint="give it with -o")
    with TemporaryDirectory() as folder:
        return _reproduce(chosen, Path(folder), jobs, False, show, as_json, quiet)


@cli.command()
@click.argument("dataset")
@_output_options
def fetch(dataset: str, as_json: bool, quiet: bool) -> None:
    """Download a measured set, SHA-256 checked, into HELMBENCH_DATA."""
    from .datasets import measured

    paths = measured.fetch(dataset, progress=not (quiet or as_json) and sys.stderr.isatty())
    if as_json:
        _print_json({"dataset": dataset, "files": [str(path) for path in paths]})
    elif not quiet:
        click.echo(f"{dataset}: {len(paths)} files in {paths[0].parent}")


def _catalogue(kind: str) -> dict[str, str]:
    if kind == "models":
        from .models.model import list_families

        return list_families()
    if kind == "vessels":
        from .models.model import list_vessels

        return list_vessels()
    if kind == "manoeuvres":
        from .datasets.manoeuvres import KINDS as manoeuvres

        return {entry.form: entry.description for entry in manoeuvres.values()}
    if kind == "methods":
        from .methods.registry import FAMILIES, methods

        families = {f"{prefix}:NAME": title for prefix, (_, _, title) in FAMILIES.items()}
        return {name: cls.title for name, cls in methods().items()} | families
    if kind == "causes":
        from .diagnosis.causes.registry import causes

        return {name: " ".join(entry.physics.split()) for name, entry in causes().items()}
    if kind == "diagnosers":
        from .diagnosis.registry import diagnosers

        return {name: cls.title for name, cls in diagnosers().items()}
    from .bench.suites import load_suite, suite_names

    return {name: load_suite(name).title for name in suite_names()}


def _check_folder(output: Path) -> None:
    """Refuse an output file that cannot be written, before anything is computed."""
    from .models.errors import BadInput

    if output.is_dir():
        raise BadInput("is a directory", file=output, hint="give the name of a file with -o")
    if not output.resolve().parent.is_dir():
        raise BadInput("no such directory", file=output.parent)


def _started(output: Path) -> bool:
    from .bench.store import MANIFEST

    return (output / MANIFEST).exists()


def _stored_selection(output: Path) -> Selection:
    from .bench.runner import Selection
    from .bench.store import read_manifest

    stored = read_manifest(output).get("selection", {})
    lists = {name: tuple(stored.get(name) or ()) for name in ("methods", "vessels")}
    return Selection(stored.get("suite", "quick"), **lists, seeds=stored.get("seeds"), seed=stored.get("seed"))


def _execute(
    output: Path, selection: Selection, resume: bool, jobs: int | None, scheduler: str | None, quiet: bool
) -> Store:
    """Run what is not stored yet; whatever is wrong with the input is found before anything is written."""
    from tqdm import tqdm

    from .bench import runner
    from .bench.kinds import runner_of
    from .bench.pool import cluster, processes
    from .bench.store import check_vacant
    from .bench.suites import load_suite

    if not resume:
        check_vacant(output)
    suite = load_suite(selection.suite)
    kind = runner_of(suite.kind)
    selection = kind.settled(suite, selection)
    specs = kind.plan(suite, selection)
    if selection.seed is not None and not quiet:
        click.echo(f"seed {selection.seed} (--seed {selection.seed} draws the same cases)", err=True)
    if not scheduler:
        kind.check(specs)
    with cluster(scheduler) if scheduler else processes(jobs) as pool:
        opened = runner.resume_store(output, suite, specs) if resume else None
        with opened or runner.open_store(output, suite, selection, specs, kind.facts(suite, specs)) as store:
            todo = [spec for spec in specs if spec.key not in store.finished]
            if not scheduler:
                kind.warm(todo)
            shown = not quiet and sys.stderr.isatty()
            with tqdm(total=len(specs), initial=len(specs) - len(todo), unit="run", disable=not shown) as bar:
                runner.run(todo, store, pool, lambda _: bar.update(), kind.execute)
    return store


def _reproduce(
    chosen: list[Paper], directory: Path, jobs: int | None, resume: bool, show: bool, as_json: bool, quiet: bool
) -> int:
    """Compute and tell; status 1 if some runs failed."""
    from tqdm import tqdm

    from .bench.pool import processes
    from .reproduction import runner, session
    from .reproduction.pages.markdown import counts_line

    def watch(run: runner.Run | None) -> None:
        bar.update()
        failed.extend([run] if run is not None and run.error else [])

    failed: list[runner.Run] = []
    with processes(jobs) as pool, tqdm(total=len(runner.plan(chosen)), unit="run", disable=not show) as bar:
        found = session.reproduce(chosen, directory, pool, resume, watch)
    for run in failed:
        click.echo(f"failed: paper {run.job.paper}, {run.job.study} {run.job.index}: {run.error}", err=True)
    if as_json:
        _print_json(session.rows(found))
    elif not quiet:
        for row in session.rows(found):
            click.echo(f"{row['paper']} {row['item']}, {row['quantity']}: {row['verdict']}. {row['reason']}")
        for paper, results in found:
            click.echo(f"paper {paper.paper}: {counts_line(results.judged(paper))}")
    return FAILED if failed else OK


def _summarise(store: Store, as_json: bool, quiet: bool) -> int:
    """Say how the runs ended; status 1 if some failed."""
    from .bench.kinds import runner_of
    from .bench.store import IDENTIFICATION

    kind = runner_of(store.manifest.get("kind", IDENTIFICATION))
    rows = [run["row"] for run in store.runs]
    counts = {status: sum(row["status"] == status for row in rows) for status in ("ok", "failed", "not_applicable")}
    failures = [row for row in rows if row["status"] == "failed"]
    if as_json:
        listed = [{key: row[key] for key in (*kind.LISTED, "error")} for row in failures]
        where = {"directory": str(store.directory), "suite": store.manifest["suite"]}
        drawn = {
            name: value for name, value in store.manifest["selection"].items() if name == "seed" and value is not None
        }
        _print_json({**where, **drawn, "runs": len(rows), **counts, "failures": listed})
    else:
        for told, number in Counter(map(kind.describe, failures)).items():
            click.echo(f"failed: {told}" + (f" ({number} runs)" if number > 1 else ""), err=True)
        if not quiet:
            told = f"{counts['ok']} ok, {counts['failed']} failed, {counts['not_applicable']} not applicable"
            click.echo(f"suite {store.manifest['suite']}: {len(rows)} runs, {told}; results in {store.directory}")
    return FAILED if failures else OK


def _print_identification(found: Identification, output: Path) -> None:
    import math

    estimate = found.estimate
    state = "" if estimate.converged else f", not converged: {estimate.message}"
    click.echo(f"{estimate.model.family} by {estimate.method} from {', '.join(found.train)}{state}")
    width = max(map(len, estimate.parameters), default=0)
    units = dict(zip(estimate.model.parameter_names, estimate.model.parameter_units, strict=True))
    for name, unit in ((name, units[name]) for name in estimate.parameters):
        error = estimate.stderr.get(name, math.nan)
        told = "not identified" if math.isinf(error) else "" if math.isnan(error) else f"+- {error:.2g}"
        told = told if error else "fixed"
        interval = _interval(estimate.extra.get("profile", {}).get(name))
        click.echo(f"  {name:<{width}}  {estimate.parameters[name]:>12.5g}  {told:<15} {unit}{interval}".rstrip())
    for line in found.identifiability.lines() if found.identifiability else ():
        click.echo(line)
    if found.validation:
        click.echo(f"validation on {', '.join(found.validation)}{' (diverged)' if found.scores['diverged'] else ''}")
        for channel in [name[len("rmse_free_") :] for name in found.scores if name.startswith("rmse_free_")]:
            rmse, r2 = (found.scores[f"{score}_free_{channel}"] for score in ("rmse", "r2"))
            one = found.scores[f"rmse_one_{channel}"]
            click.echo(f"  {channel:<15} free run RMSE {rmse:10.4g}  R2 {r2:8.4f}   one step RMSE {one:10.4g}")
    click.echo(f"wrote {output}" if estimate.predictor is None else f"no {output}: a black box has no coefficients")


def _interval(profile: dict[str, Any] | None) -> str:
    """A profile-likelihood interval, with a round bracket at an end up to which the records do not object."""
    if profile is None:
        return ""
    left, right = ("(" if profile["low_open"] else "["), (")" if profile["high_open"] else "]")
    return f"  {left}{profile['low']:.5g}, {profile['high']:.5g}{right}"


def _print_json(value: Any) -> None:
    from .bench.store import plain

    click.echo(json.dumps(plain(value), indent=1, allow_nan=False))
