"""
Reading a raw log
=================

A log of a bridge has its own names, units and separators. `draft_import` says what it takes every column for, and
why, before anything is imported. Here the log is written first; of your own you give the path.
"""

import tempfile
from pathlib import Path

import numpy as np

import helmbench

run = helmbench.simulate("mariner", "zigzag:20/20", duration_s=300.0, dt_s=1.0)
start = np.datetime64("2026-03-14T23:58:30")
lines = ["UTC;Heading [deg];ROT [deg/min];Rudder [deg]"]
for second, heading, rate, rudder in zip(
    run.time_s, run.column("heading_rad"), run.column("yaw_rate_rad_s"), run.rudder(), strict=True
):
    stamp = start + np.timedelta64(int(second), "s")
    lines.append(f"{stamp};{np.degrees(heading) % 360:.2f};{60 * np.degrees(rate):.2f};{np.degrees(rudder):.2f}")
print("\n".join(lines[:4]))

# %%
# What the columns are taken for:

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "bridge.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    draft = helmbench.draft_import(path)
for column in draft.columns:
    print(f"{column.column}: {column.quantity}, {column.unit}, {column.why}")
print("open questions:", len(draft.questions))

# %%
# No question is open, so that the log is a record.

draft.import_log().record.plot()
