"""A generated simulation kernel in C: assignments of the rates carried over, the same RK4 around them."""

import ctypes
import re
import subprocess

import numpy as np

from helmbench.models import kernels

FRAME = """
#include <math.h>
static inline double sgn(double x) {{ return x > 0.0 ? 1.0 : (x < 0.0 ? -1.0 : 0.0); }}
static inline double step(double x) {{ return x > 0.0 ? 1.0 : 0.0; }}
static void rates(const double *s, const double *in, const double *_th, double *out) {{
{body}
}}
void simulate(const double *x0, const double *u, const double *th, double h, long count, long samples, double *x) {{
    double z[{n}], a[{n}], p[{n}], q[{n}], r[{n}], w[{n}], in[{m}];
    for (int i = 0; i < {n}; i++) x[i] = z[i] = x0[i];
    for (long k = 0; k < samples - 1; k++, u += {m}) {{
        for (long s = 0; s < count; s++) {{
            for (int i = 0; i < {m}; i++) in[i] = u[i] + (double)s / count * (u[i + {m}] - u[i]);
            rates(z, in, th, p);
            for (int i = 0; i < {m}; i++) in[i] = u[i] + (s + 0.5) / count * (u[i + {m}] - u[i]);
            for (int i = 0; i < {n}; i++) a[i] = z[i] + 0.5 * h * p[i];
            rates(a, in, th, q);
            for (int i = 0; i < {n}; i++) a[i] = z[i] + 0.5 * h * q[i];
            rates(a, in, th, r);
            for (int i = 0; i < {m}; i++) in[i] = u[i] + (s + 1.0) / count * (u[i + {m}] - u[i]);
            for (int i = 0; i < {n}; i++) a[i] = z[i] + h * r[i];
            rates(a, in, th, w);
            for (int i = 0; i < {n}; i++) z[i] += h / 6.0 * (p[i] + 2.0 * (q[i] + r[i]) + w[i]);
        }}
        for (int i = 0; i < {n}; i++) x[(k + 1) * {n} + i] = z[i];
    }}
}}
"""
MEANINGS = {r"\bnp\.": "", r"\babs\(": "fabs("}
FLAGS = ["-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-signed-zeros", "-freciprocal-math"]
"""What the compiled kernels may do too: fused multiply-add, reciprocals, no sign of zero, this machine's registers."""


def text_of(model):
    """The C text of a model's scalar kernel."""
    module = kernels._text(model.kernels._found["simulate"])
    source = module[module.index("def _rates(") :].partition("\n\n")[0]
    for pattern, meaning in MEANINGS.items():
        source = re.sub(pattern, meaning, source)
    *lines, last = [line.strip() for line in source.split("\n") if line.startswith("    ")]
    names = [*model.states, *model.inputs]
    body = [f"double {name} = s[{i}];" for i, name in enumerate(names[: len(model.states)])]
    body += [f"double {name} = in[{i}];" for i, name in enumerate(names[len(model.states) :])]
    body += [f"double {line};" for line in lines]
    body += [f"out[{i}] = {value};" for i, value in enumerate(last.removeprefix("return ").rstrip(",").split(", "))]
    return FRAME.format(body="\n".join(body), n=len(model.states), m=len(model.inputs))


def compiled(model, gcc, folder):
    """A function (inputs (N, nu), step, substeps, x0, states (N, n)) that runs the kernel compiled by gcc."""
    text, library = folder / f"{model.id}.c", folder / f"{model.id}.so"
    text.write_text(text_of(model))
    subprocess.run([gcc, *FLAGS, "-shared", "-fPIC", text, "-o", library, "-lm"], check=True)
    pointer = np.ctypeslib.ndpointer(float, flags="C")
    simulate = ctypes.CDLL(str(library)).simulate
    simulate.argtypes = [pointer, pointer, pointer, ctypes.c_double, ctypes.c_long, ctypes.c_long, pointer]
    simulate.restype = None

    def run(inputs, dt, count, start, states):
        simulate(start, inputs, model.theta, dt / count, count, len(inputs), states)

    return run
