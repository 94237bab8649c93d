"""`helmbench.check`: records and files, result, page, files written together."""

import json
import re

import numpy as np
import pytest

import helmbench

HEADER = "time_s,rudder_rad,heading_deg,yaw_rate_deg_s,surge_m_s\n"


def made(seed=3):
    return helmbench.simulate("mariner", "zigzag:20/20", noise="medium", seed=seed, duration_s=300.0)


def rows(n=80):
    t = 0.5 * np.arange(n)
    psi = 20.0 * np.sin(0.1 * t)
    return [
        f"{a},{0.1 * np.sin(0.2 * a):.6f},{b:.6f},{2.0 * np.cos(0.1 * a):.6f},5.0{i % 7}"
        for i, (a, b) in enumerate(zip(t, psi, strict=True))
    ]


def test_sound_records_have_no_finding():
    found = helmbench.check([made(1), made(2)])
    assert isinstance(found, helmbench.Check) and [f for f in found.findings if f.material] == []
    assert repr(found) == "<Check of 2 records: no findings>"
    assert "nothing that matters" in found.summary() and "<p>" in found._repr_html_()


def test_a_biased_gyro_is_found_and_shown(tmp_path):
    record = made()
    spoilt = record.with_channels(yaw_rate_rad_s=record.column("yaw_rate_rad_s") + np.deg2rad(0.05))
    found = helmbench.check(spoilt)
    finding = found.findings[0]
    assert finding.cause == "yaw_rate_bias" and repr(found) == "<Check of 1 record: yaw_rate_bias>"
    assert np.rad2deg(finding.sizes[0].value) == pytest.approx(0.05, abs=0.005)
    assert "yaw rate bias" in found.summary() and "0.05" in found.summary() and "deg/s" in found._repr_html_()
    paths = found.write(tmp_path / "out")
    document = json.loads(paths[0].read_text("utf-8"))
    assert document["schema"] == 1 and document["findings"][0]["cause"] == "yaw_rate_bias"
    page = paths[1].read_text("utf-8")
    assert page.startswith("<!DOCTYPE html>") and "yaw rate bias" in page
    assert not re.search(r"""(?:src|href)\s*=\s*"(?!#)|url\((?!#)|@import""", page)


def test_stamps_that_repeat_or_go_back_are_findings_not_errors(tmp_path):
    lines = rows()
    path = tmp_path / "run.csv"
    path.write_text(HEADER + "\n".join([*lines[:20], lines[19], *lines[25:30], lines[22], *lines[30:]]) + "\n", "utf-8")
    with pytest.raises(helmbench.BadInput):
        helmbench.read_record(path)
    said = " ".join(f.evidence for f in helmbench.check(path).findings if f.cause == "time_stamps")
    assert "1 of 77 rows repeat" in said and "1 of 77 rows stand before" in said and "rows are missing" in said


def test_a_file_without_rows_and_no_record_are_bad_input(tmp_path):
    path = tmp_path / "empty.csv"
    path.write_text(HEADER, "utf-8")
    with pytest.raises(helmbench.BadInput, match="time"):
        helmbench.check(path)
    with pytest.raises(helmbench.BadInput, match="no record"):
        helmbench.check([])


def test_a_side_that_contradicts_the_records_is_named():
    record = made()
    other = {"port": "starboard", "starboard": "port"}[record.meta.positive_rudder]
    from dataclasses import replace

    spoilt = replace(record, meta=replace(record.meta, positive_rudder=other))
    assert "rudder_sign" in [f.cause for f in helmbench.check(spoilt).findings]
