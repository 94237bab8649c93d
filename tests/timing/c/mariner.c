/* Abkowitz polynomial of the Mariner with the published terms alone, Chislett & Stroem-Tejsen 1965. */

#define STATES 6
#define INPUTS 1
#define NUMBERS(F) \
    F(L) F(U0) F(m11) F(m22) F(m23) F(m32) F(m33) \
    F(Xu) F(Xuu) F(Xuuu) F(Xvv) F(Xrr) F(Xvr) F(Xdd) F(Xddu) F(Xvd) F(Xvdu) \
    F(Yv) F(Yr) F(Yvvv) F(Yvvr) F(Yvu) F(Yru) F(Yd) F(Yddd) F(Ydu) F(Yduu) F(Yvdd) F(Yvvd) F(Y0) F(Yu) F(Yuu) \
    F(Nv) F(Nr) F(Nvvv) F(Nvvr) F(Nvu) F(Nru) F(Nd) F(Nddd) F(Ndu) F(Nduu) F(Nvdd) F(Nvvd) F(N0) F(Nu) F(Nuu)
#define DERIVED(F) F(det)

enum { NUMBERS(PLACE) DERIVED(PLACE) KEPT };

static void prepare(const double *numbers, double *kept) {
    EACH_RUN {
        NUMBERS(LOAD)
        double det = m22 * m33 - m32 * m23;
        NUMBERS(STORE) DERIVED(STORE)
    }
}

static void rates(const double *restrict numbers, const double *restrict x, const double *restrict in,
                  double *restrict dx) {
    EACH_RUN {
        NUMBERS(LOAD) DERIVED(LOAD)
        double psi = STATE(5), d = INPUT(0), U = sqrt(STATE(0) * STATE(0) + STATE(1) * STATE(1)), q = U * U / L;
        double u = (STATE(0) - U0) / U, v = STATE(1) / U, r = STATE(2) * L / U;
        double X = Xu * u + Xuu * u * u + Xuuu * u * u * u + Xvv * v * v + Xrr * r * r + Xvr * v * r
                   + Xdd * d * d + Xddu * u * d * d + Xvd * v * d + Xvdu * u * v * d;
        double Y = Yv * v + Yr * r + Yvvv * v * v * v + Yvvr * v * v * r + Yvu * v * u + Yru * r * u
                   + Yd * d + Yddd * d * d * d + Ydu * u * d + Yduu * u * u * d + Yvdd * v * d * d
                   + Yvvd * v * v * d + Y0 + Yu * u + Yuu * u * u;
        double N = Nv * v + Nr * r + Nvvv * v * v * v + Nvvr * v * v * r + Nvu * v * u + Nru * r * u
                   + Nd * d + Nddd * d * d * d + Ndu * u * d + Nduu * u * u * d + Nvdd * v * d * d
                   + Nvvd * v * v * d + N0 + Nu * u + Nuu * u * u;
        RATE(0) = q * X / m11;
        RATE(1) = q * (m33 * Y - m23 * N) / det;
        RATE(2) = q / L * (m22 * N - m32 * Y) / det;
        RATE(3) = STATE(0) * COS(psi) - STATE(1) * sin(psi);
        RATE(4) = STATE(0) * sin(psi) + STATE(1) * COS(psi);
        RATE(5) = STATE(2);
    }
}
