"""The leaderboard's table of how far ahead methods can be trusted."""

import numpy as np
import pandas as pd

from helmbench.reporting.leaderboard.tables import ahead_table


def test_medians_by_method_and_nothing_without_measured_records():
    keys = {"vessel": "set", "model": "nomoto-1", "noise_yaw_rate_rad_s": 0.001}
    rows = [
        {**keys, "method": method, "trusted_s": trusted, "rmse_ahead_3_yaw_rate_rad_s": np.deg2rad(trusted)}
        for method, trusted in (("ls", 10.0), ("ls", 20.0), ("ls", 60.0), ("pem", 30.0))
    ]
    found = ahead_table(pd.DataFrame(rows))
    assert [row[1].text for row in found.rows] == ["pem", "ls"] and found.rows[1][3].value == 20.0
    assert found.rows[1][found.columns.index("3 lengths")].text.startswith("20 /")
    assert not ahead_table(pd.DataFrame([{**rows[0], "trusted_s": np.nan}])).rows
    assert not ahead_table(pd.DataFrame([{"method": "ls"}])).rows
