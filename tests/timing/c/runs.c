/* Runge-Kutta simulation of W runs of the ship of the file SHIP, element `index * W + run`; numbers of each run. */

#include <math.h>

#define EACH_RUN _Pragma("omp simd") for (int run = 0; run < W; run++)
#define PLACE(name) AT_##name,
#define LOAD(name) double name = numbers[AT_##name * W + run];
#define STORE(name) kept[AT_##name * W + run] = name;
#define STATE(i) x[(i) * W + run]
#define INPUT(i) in[(i) * W + run]
#define RATE(i) dx[(i) * W + run]
#if W > 1 /* gcc joins sin and cos of one angle to a function that has no vector form */
#define COS(angle) sin((angle) + M_PI_2)
#else
#define COS(angle) cos(angle)
#endif
#include SHIP

enum { N = STATES * W, M = INPUTS * W };

static void between(const double *u, double part, double *in) {
    for (int i = 0; i < M; i++) in[i] = u[i] + part * (u[i + M] - u[i]);
}

static void ahead(const double *z, double h, const double *rate, double *probe) {
    for (int i = 0; i < N; i++) probe[i] = z[i] + h * rate[i];
}

void simulate(const double *x0, const double *u, const double *numbers, double h, long count, long samples, double *x) {
    double kept[KEPT * W], z[N], a[N], p[N], q[N], r[N], w[N], in[M];
    prepare(numbers, kept);
    for (int i = 0; i < N; i++) x[i] = z[i] = x0[i];
    for (long k = 1; k < samples; k++, u += M) {
        for (long s = 0; s < count; s++) {
            between(u, (double)s / count, in);
            rates(kept, z, in, p);
            between(u, (s + 0.5) / count, in);
            ahead(z, 0.5 * h, p, a);
            rates(kept, a, in, q);
            ahead(z, 0.5 * h, q, a);
            rates(kept, a, in, r);
            between(u, (s + 1.0) / count, in);
            ahead(z, h, r, a);
            rates(kept, a, in, w);
            for (int i = 0; i < N; i++) z[i] += h / 6.0 * (p[i] + 2.0 * (q[i] + r[i]) + w[i]);
        }
        for (int i = 0; i < N; i++) x[k * N + i] = z[i];
    }
}
