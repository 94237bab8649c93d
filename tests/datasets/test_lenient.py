"""Reading files whose rows are not in order."""

import numpy as np
import pytest

from helmbench.datasets.io import read_leniently, read_record, write_record
from helmbench.datasets.record import Record
from helmbench.models.errors import BadInput


def test_a_sound_file_is_read_as_it_is(tmp_path, rng):
    channels = {"rudder_rad": rng.normal(size=30), "surge_m_s": rng.normal(size=30)}
    path = tmp_path / "run.csv"
    write_record(Record(0.1 * np.arange(30), channels, "run"), path)
    record, repairs = read_leniently(path)
    assert record.equals(read_record(path))
    assert (repairs.rows, repairs.timeless, repairs.repeated, repairs.backwards, repairs.infinite) == (30, 0, 0, 0, ())


def test_rows_are_put_in_order_and_counted(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("time_s,rudder_rad\n0,1\n2,3\n1,2\n2,9\n,7\n3,inf\n", "utf-8")
    record, repairs = read_leniently(path)
    assert record.time_s.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert record.column("rudder_rad").tolist()[:3] == [1.0, 2.0, 3.0] and np.isnan(record.column("rudder_rad")[3])
    assert (repairs.timeless, repairs.repeated, repairs.backwards) == (1, 1, 1)
    assert repairs.infinite == (("rudder_rad", 1),)


@pytest.mark.parametrize("text", ["time_s,rudder_rad\n1,1\n1,2\n", "time_s,rudder_rad\nnan,1\n,2\n"])
def test_fewer_than_two_times_are_bad_input(tmp_path, text):
    path = tmp_path / "run.csv"
    path.write_text(text, "utf-8")
    with pytest.raises(BadInput, match="fewer than two rows"):
        read_leniently(path)
