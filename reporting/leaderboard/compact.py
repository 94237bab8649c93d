"""The tables of a run directory with the columns that a report needs, in little memory: a million runs in a gigabyte.

Texts are pandas categories in alphabetical order, the same ones in both tables, so that groups sort as texts do and
merge.  A missing truth value is false.  What is only shown, or of which only counts whether it is there, has single
precision (`SINGLE`).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from ...bench.kinds.identification.columns import KEYS, PARAMETER_COLUMNS, PARAMETERS, RESULTS, result_columns
from ...bench.scores.errors_ahead import errors_ahead
from ...bench.scores.prediction_error import record_errors
from ...bench.store import read_tables
from ...models.errors import BadInput
from ...models.folders import check_regular
from .standings import CELL, MEDIANS, PREDICTED, Frame, Series

JUDGED = ("rel_error_median", *(f"r2_free_{name}" for name in (*PREDICTED, "north_m", "east_m")))
WIDE = tuple(
    dict.fromkeys(
        (
            *KEYS,
            "status",
            "error",
            "diverged",
            "measured",
            *JUDGED,
            *MEDIANS.values(),
            *errors_ahead.columns,
            *record_errors.columns,
        )
    )
)
"""Columns of the runs, as far as they are stored."""
LONG = ("method", "variant", *CELL, "seed", "parameter", "unit", "true", "true_kind", "estimate", "stderr", "rel_error")
LONG = (*LONG, "crb_sd", "identifiable")

SINGLE = ("stderr", "rel_error")


def read_compact(directory: str | Path) -> tuple[Frame, Frame]:
    """Runs and parameters of a directory, as `store.read_tables` gives them, but compact.

    Raises
    ------
    BadInput : a file cannot be read.
    """
    directory = Path(directory)
    if all([check_regular(directory / name) for name in (RESULTS, PARAMETERS)]):
        parts = [_columns(directory / RESULTS, WIDE), _columns(directory / PARAMETERS, LONG)]
    else:
        parts = [frame.items() for frame in read_tables(directory)]
    runs, parameters = (
        _compact(part, wanted, kinds)
        for part, wanted, kinds in zip(parts, (WIDE, LONG), (result_columns(), PARAMETER_COLUMNS), strict=True)
    )
    return _same_categories(runs, parameters)


def _columns(path: Path, wanted: Sequence[str]) -> Iterator[tuple[Hashable, Series]]:
    """Name and values of the wanted columns of a Parquet file, one in memory at a time."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        schema = pq.read_schema(path)
        texts = [name for name in schema.names if pa.types.is_string(schema.field(name).type)]
        file = pq.ParquetFile(path, read_dictionary=texts)
        for name in schema.names:
            if name in wanted:
                yield name, file.read([name]).column(0).unify_dictionaries().to_pandas()
                pa.default_memory_pool().release_unused()
    except (OSError, ValueError) as error:
        raise BadInput(f"cannot be read ({error})", file=path) from None


def _compact(columns: Iterable[tuple[Hashable, Series]], wanted: Sequence[str], kinds: Mapping[str, str]) -> Frame:
    import pandas as pd

    kinds = {**kinds, **dict.fromkeys(SINGLE, "single")}
    found = {str(name): _smaller(values, kinds.get(str(name), "float")) for name, values in columns if name in wanted}
    return pd.DataFrame(found, copy=False)


def _smaller(values: Series, kind: str) -> Series:
    """The values of a column in less memory."""
    import pandas as pd

    if kind == "string":
        own = values.astype("category")
        return own.cat.reorder_categories(sorted(own.cat.categories))
    if kind == "bool":
        return values.eq(True)
    if kind == "single":
        return values.astype(np.float32)
    return pd.to_numeric(values, downcast="integer") if kind == "int" else values


def _same_categories(one: Frame, two: Frame) -> tuple[Frame, Frame]:
    """Both frames with the same categories in the columns that they share."""
    import pandas as pd

    texts = [name for name in one if isinstance(one[name].dtype, pd.CategoricalDtype)]
    for name in filter(two.columns.__contains__, texts):
        every = sorted({*one[name].cat.categories, *two[name].cat.categories})
        one[name], two[name] = one[name].cat.set_categories(every), two[name].cat.set_categories(every)
    return one, two
