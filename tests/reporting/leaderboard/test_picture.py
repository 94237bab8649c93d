"""The picture of the standings: equal bytes every time; that of the README is of the quick suite."""

import re
from pathlib import Path

from helmbench.bench.store import Store
from helmbench.bench.suites import load_suite
from helmbench.reporting.leaderboard.board import write_picture

from ...made_up.runs import make_run

COMMITTED = Path(__file__).resolve().parents[3] / "reports" / "leaderboard" / "quick.svg"


def names(text):
    return re.findall(r"<text [^>]*>([a-z0-9:-]+)</text>", text)


def test_the_picture_names_the_methods_best_first_and_is_the_same_every_time(tmp_path, manifest):
    runs = [make_run(error, r2, method=method, seed=seed)
            for seed in range(3) for method, error, r2 in (("ls", 0.2, 0.9), ("pem", 0.01, 0.999))]  # fmt: skip
    with Store.create(tmp_path / "out", manifest(len(runs))) as store:
        for run in runs:
            store.append(run)
    texts = []
    for place in (tmp_path / "a" / "board.svg", tmp_path / "b.svg"):
        write_picture(tmp_path / "out", place)
        texts.append(place.read_text(encoding="utf-8"))
    assert texts[0] == texts[1] and names(texts[0]) == ["pem", "ls"]


def test_a_method_without_a_finite_median_is_said_to_have_none(tmp_path, manifest):
    runs = [make_run(0.1, 0.9, method=method, diverged=method == "lost", vessel=ship)
            for method in ("ls", "lost") for ship in ("cargo", "patrol")]  # fmt: skip
    with Store.create(tmp_path / "out", manifest(len(runs))) as store:
        for run in runs:
            store.append(run)
    write_picture(tmp_path / "out", tmp_path / "board.svg")
    text = (tmp_path / "board.svg").read_text(encoding="utf-8")
    assert names(text) == ["ls", "lost"] and text.count("median: infinite") == 1


def test_the_picture_of_the_readme_holds_the_methods_of_the_quick_suite():
    entries = load_suite("quick").entries
    wanted = {method for entry in entries for method in entry.methods}
    assert set(names(COMMITTED.read_text(encoding="utf-8"))) == wanted
