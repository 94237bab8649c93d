"""Nothing is imported from the working folder: files of others may lie there, a `threading.py` among them.

Python puts the working folder first on the path of modules of every process that begins with `-c` or `-m`.  So begin
the workers of multiprocessing, joblib and submitit, before code of ours runs in them.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Generator
from contextlib import contextmanager

VARIABLE = "PYTHONSAFEPATH"
"""Variable of the environment with which Python leaves the working folder off the path of modules."""


@contextmanager
def without_working_folder() -> Generator[None]:
    """Neither this process nor one that it starts imports from the working folder in the enclosed code.

    The empty entry of `sys.path`, which stands for the working folder in an interactive session, is taken out:
    multiprocessing and joblib hand their workers this path.  Folders that the path names stay.
    """
    variable, empty = os.environ.get(VARIABLE), [place for place, entry in enumerate(sys.path) if not entry]
    os.environ[VARIABLE] = "1"
    sys.path[:] = filter(None, sys.path)
    try:
        yield
    finally:
        for place in empty:
            sys.path.insert(place, "")
        if variable is None:
            os.environ.pop(VARIABLE, None)
        else:
            os.environ[VARIABLE] = variable
