"""The wheel and the sdist in clean environments: `make packages`, and what the extras cost: `make sizes`.

python .ci/packages.py try DIST               install and use them with every Python of 3.11 to 3.14 that is found
python .ci/packages.py this DIST              the same with the Python that runs this
python .ci/packages.py sizes DIST PAGE        MB and seconds of the base and of each extra, as a table of Markdown
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
EXTRAS = (
    *("pandas", "parquet", "bench", "bayes", "pdf", "identibench", "open", "readers"),
    *("deep", "distributed", "docs"),
)
COMMANDS = (
    "simulate kvlcc2-l7 --manoeuvre zigzag:20/20 --noise low --seed 1 -o one.csv",
    "simulate kvlcc2-l7 --manoeuvre zigzag:10/10 --noise low --seed 2 -o two.csv",
    "check one.csv two.csv",
    "import raw.csv --yes --positive-rudder starboard -o record.csv",
    "identify one.csv --model nomoto-1-cubic --method output-error --validate two.csv -o model.json",
    "diagnose --help",
    "doctor",
)
"""What the base installation must do."""
MIB = 2**20
MOST_MIB = 660
"""Size that the base installation may have, pip's own 21 MiB included."""


def pythons() -> Iterator[tuple[str, str]]:
    """(version, interpreter) of each Python that can make environments: on the path, or among pyenv's versions."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for version in PYTHONS:
        found = [shutil.which(f"python{version}"), *map(str, sorted(pyenv.glob(f"{version}.*/bin/python{version}")))]
        usable = (path for path in found if path and _is_whole(path, version))
        if path := next(usable, None):
            yield version, path
        else:
            print(f"Python {version}: not on this machine")


def _is_whole(path: str, version: str) -> bool:
    code = f"import sys, venv, ensurepip; sys.exit('{version}' != '%d.%d' % sys.version_info[:2])"
    return subprocess.run([path, "-c", code], capture_output=True, check=False).returncode == 0


def environment(python: str, folder: Path) -> Path:
    """The interpreter of a new environment."""
    subprocess.run([python, "-m", "venv", folder], check=True)
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def install(python: Path, package: str) -> float:
    """Seconds that an installation takes, with the pinned versions."""
    pins = ROOT / "requirements" / "constraints.txt"
    began = time.monotonic()
    command = [python, "-m", "pip", "install", "--quiet", "--no-warn-conflicts", "--constraint", pins, package]
    subprocess.run(command, check=True, cwd=python.parent)
    return time.monotonic() - began


def use(python: Path, folder: Path) -> None:
    """Run the commands of the base installation in a folder, with an empty cache."""
    rows = [f"2024-05-01 10:{s // 60:02}:{s % 60:02};{10 if s % 40 < 20 else -10};{50 + s % 20}" for s in range(200)]
    (folder / "raw.csv").write_text("\n".join(["Time;Rudder angle [deg];Heading [deg]", *rows]) + "\n")
    own = {"HELMBENCH_CACHE": str(folder / "cache")}
    for command in COMMANDS:
        words = [python, "-m", "helmbench", *command.split()]
        done = subprocess.run(words, cwd=folder, env=os.environ | own, capture_output=True, text=True, check=False)
        if done.returncode:
            sys.exit(f"{command}: status {done.returncode}\n{done.stdout}\n{done.stderr}")


def megabytes(python: Path) -> float:
    """Size of the environment's packages, compiled modules included."""
    return sum(path.lstat().st_size for path in python.parents[1].rglob("*") if path.is_file()) / MIB


def seconds_to_start(python: Path) -> list[float]:
    """Wall time of `helmbench --help` and of `import helmbench` with a model simulated; the best of three each."""
    codes = (
        "import sys; from helmbench.cli import status_of; sys.exit(status_of(['--help']))",
        "import helmbench; helmbench.simulate('kvlcc2-l7', 'zigzag:20/20', duration_s=20.0)",
    )
    return [min(_seconds([python, "-c", code]) for _ in range(4)) for code in codes]


def _seconds(command: list) -> float:
    began = time.monotonic()
    subprocess.run(command, check=True, capture_output=True, cwd=command[0].parent)  # the checkout is not installed
    return time.monotonic() - began


def try_all(dist: Path) -> None:
    """Install the wheel with each Python, and the sdist with the first; use each."""
    packages = [*dist.glob("*.whl"), *dist.glob("*.tar.gz")]
    for version, path in pythons():
        for package in packages:
            try_one(version, path, package)
        packages = packages[:1]


def try_this(dist: Path) -> None:
    """Install and use the wheel with the Python that runs this."""
    (wheel,) = dist.glob("*.whl")
    try_one(".".join(map(str, sys.version_info[:2])), sys.executable, wheel)


def try_one(version: str, path: str, package: Path) -> None:
    """Install and use a package in a new environment outside the checkout."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        python = environment(path, Path(folder) / "environment")
        took = install(python, str(package.resolve()))
        use(python, Path(folder))
        size = megabytes(python)
    if size > MOST_MIB:
        sys.exit(f"Python {version}: {package.name} takes {size:.0f} MiB, more than {MOST_MIB}")
    print(f"Python {version}: {package.name} installed in {took:.0f} s, {size:.0f} MiB, used", flush=True)


def sizes(dist: Path, page: Path) -> None:
    """Write the table of sizes, with this Python: the base, then each extra alone on top of it."""
    (wheel,) = (path.resolve() for path in dist.glob("*.whl"))
    with tempfile.TemporaryDirectory() as folder:
        python = environment(sys.executable, Path(folder) / "environment")
        empty = megabytes(python)
        took = install(python, str(wheel))
        base, started = megabytes(python), seconds_to_start(python)
        rows = [f"| `helmbench` | {base - empty:.0f} | {took:.0f} |"]
        for extra in EXTRAS:
            before = installed(python)
            took = install(python, f"{wheel}[{extra}]")
            rows.append(f"| `helmbench[{extra}]` | + {megabytes(python) - base:.0f} | + {took:.0f} |")
            added = sorted(installed(python) - before)
            subprocess.run([python, "-m", "pip", "uninstall", "--quiet", "--yes", *added], check=True)
    version = ".".join(map(str, sys.version_info[:3]))
    told = (
        f"Python {version}, pinned versions, each extra alone on top of the base; pip's own {empty:.0f} MiB left out;"
        f" seconds on two busy processors with packages from a near mirror. `helmbench --help` takes"
        f" {started[0]:.2f} s; `import helmbench` and a simulation with kept compiled code {started[1]:.1f} s."
    )
    head = ["| installation | MiB | seconds |", "| --- | ---: | ---: |"]
    page.write_text("\n".join([*head, *rows, "", told, ""]), encoding="utf-8")
    print("\n".join(rows))


def installed(python: Path) -> set[str]:
    """Names of the packages of an environment."""
    command = [python, "-m", "pip", "list", "--format", "freeze", "--disable-pip-version-check"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return {line.partition("==")[0] for line in done.stdout.splitlines()}


if __name__ == "__main__":
    task, *places = sys.argv[1:]
    {"try": try_all, "this": try_this, "sizes": sizes}[task](*map(Path, places))
