"""Simulation of a ship in C: its equations written by hand from the paper (`c/`), one run or several side by side."""

import ctypes
import re
import subprocess
from pathlib import Path

import numpy as np

TEXTS = Path(__file__).with_name("c")
FLAGS = ["-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-signed-zeros", "-freciprocal-math"]
"""What the compiled kernels may do too: fused multiply-add, reciprocals, no sign of zero, this machine's registers."""
SIDE_BY_SIDE = ["-O3", "-march=native", "-ffast-math", "-fopenmp-simd"]
"""With these gcc takes sines of several runs from the vector library (libmvec of glibc)."""
POINTER = np.ctypeslib.ndpointer(float, flags="C")


def compile_c(gcc, options, text, library):
    subprocess.run([gcc, *options, "-shared", "-fPIC", text, "-o", library, "-lm"], check=True)
    return ctypes.CDLL(str(library))


def compiled(ship, facts, gcc, folder, runs=1):
    """A function (inputs (N, nu*W), step, substeps, x0 (n*W,), states (N, n*W)) of W runs of the ship of c/SHIP.c.

    facts : value of every name among the NUMBERS of the file, the same for all runs.
    """
    names = re.findall(
        r"F\((\w+)\)", (TEXTS / f"{ship}.c").read_text().partition("NUMBERS(F)")[2].partition("DERIVED")[0]
    )
    numbers = np.repeat([facts[name] for name in names], runs)
    options = [*(FLAGS if runs == 1 else SIDE_BY_SIDE), f"-DW={runs}", f'-DSHIP="{ship}.c"']
    run = compile_c(gcc, options, TEXTS / "runs.c", folder / f"{ship}_{runs}.so").simulate
    run.argtypes = [POINTER, POINTER, POINTER, ctypes.c_double, ctypes.c_long, ctypes.c_long, POINTER]
    run.restype = None

    def simulate(inputs, dt, count, start, states):
        run(start, inputs, numbers, dt / count, count, len(inputs), states)

    return simulate
