/*
@HEADING@
 *
 * Functional mock-up unit for co-simulation, FMI 2.0.  Names that begin with fmi2 are those of the standard.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define COUNT @COUNT@
#define STATES @STATES@
#define STATE @STATE@
#define RUDDER @RUDDER@
#define COMMAND @COMMAND@
#define GEAR @GEAR@
#define MAX_STEP @STEP@

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef void *Component;
typedef unsigned int Reference;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;

/* Inputs, states, rudder angle, coefficients and constants, limits of the steering gear. */
typedef struct {
    double v[COUNT];
} Unit;

static const double START[COUNT] = {@START@};

/* Derivative hb_d of the states hb_x under the rudder angle hb_delta and the numbers hb_v. */
static void derivative(const double *hb_x, double hb_delta, const double *hb_v, double *hb_d)
{
@EQUATIONS@
}

/* Time until the steering gear is no more limited by its rate: s. */
static double saturated(const double *v)
{
    const double change = fabs(fmin(fmax(v[COMMAND], -v[GEAR]), v[GEAR]) - v[RUDDER]);
    return fmax(0.0, change / v[GEAR + 1] - v[GEAR + 2]);
}

/* Rudder angle after t seconds of the present command: at the largest rate, then by the lag. */
static double rudder(const double *v, double t)
{
    const double target = fmin(fmax(v[COMMAND], -v[GEAR]), v[GEAR]), change = target - v[RUDDER];
    const double slow = saturated(v), sign = change < 0.0 ? -1.0 : 1.0;
    if (t <= slow) return v[RUDDER] + sign * v[GEAR + 1] * t;
    if (v[GEAR + 2] <= 0.0) return target;
    return target - (change - sign * v[GEAR + 1] * slow) * exp(-(t - slow) / v[GEAR + 2]);
}

/* One Runge-Kutta step of fourth order. */
static void step(Unit *unit, double h)
{
    static const double PART[4] = {0.0, 0.5, 0.5, 1.0}, WEIGHT[4] = {1.0, 2.0, 2.0, 1.0};
    double d[STATES] = {0.0}, x[STATES], sum[STATES] = {0.0};
    for (int stage = 0; stage < 4; ++stage) {
        for (int i = 0; i < STATES; ++i) x[i] = unit->v[STATE + i] + PART[stage] * h * d[i];
        derivative(x, rudder(unit->v, PART[stage] * h), unit->v, d);
        for (int i = 0; i < STATES; ++i) sum[i] += WEIGHT[stage] * d[i];
    }
    const double angle = rudder(unit->v, h);
    for (int i = 0; i < STATES; ++i) unit->v[STATE + i] += h / 6.0 * sum[i];
    unit->v[RUDDER] = angle;
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT Status fmi2SetDebugLogging(Component c, int on, size_t n, const char *const names[])
{
    (void)c, (void)on, (void)n, (void)names;
    return OK;
}

EXPORT Component fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                                 const void *functions, int visible, int logging)
{
    (void)name, (void)resources, (void)functions, (void)visible, (void)logging;
    if (type != 1 || guid == NULL || strcmp(guid, "@GUID@") != 0) return NULL;
    Unit *unit = malloc(sizeof(Unit));
    if (unit != NULL) memcpy(unit->v, START, sizeof START);
    return unit;
}

EXPORT void fmi2FreeInstance(Component c) { free(c); }
EXPORT Status fmi2SetupExperiment(Component c, int tolerant, double tolerance, double start, int stops, double stop)
{
    (void)c, (void)tolerant, (void)tolerance, (void)start, (void)stops, (void)stop;
    return OK;
}
EXPORT Status fmi2EnterInitializationMode(Component c) { return c == NULL ? ERROR : OK; }
EXPORT Status fmi2ExitInitializationMode(Component c) { return c == NULL ? ERROR : OK; }
EXPORT Status fmi2Terminate(Component c) { return c == NULL ? ERROR : OK; }
EXPORT Status fmi2Reset(Component c)
{
    memcpy(((Unit *)c)->v, START, sizeof START);
    return OK;
}

EXPORT Status fmi2GetReal(Component c, const Reference r[], size_t n, double value[])
{
    for (size_t i = 0; i < n; ++i) {
        if (r[i] >= COUNT) return ERROR;
        value[i] = ((Unit *)c)->v[r[i]];
    }
    return OK;
}
EXPORT Status fmi2SetReal(Component c, const Reference r[], size_t n, const double value[])
{
    for (size_t i = 0; i < n; ++i) {
        if (r[i] >= COUNT || !isfinite(value[i])) return ERROR;
        ((Unit *)c)->v[r[i]] = value[i];
    }
    return OK;
}

EXPORT Status fmi2DoStep(Component c, double now, double size, int no_set_state)
{
    Unit *unit = c;
    (void)now, (void)no_set_state;
    if (!(size >= 0.0) || !isfinite(size)) return ERROR;
    double left = size;
    while (left > 1e-12 * size) {
        const double kink = saturated(unit->v);
        double h = left / ceil(left / MAX_STEP - 1e-9);
        if (kink > 1e-12 * size && kink < h) h = kink;
        step(unit, h);
        left -= h;
    }
    for (int i = 0; i < STATES; ++i)
        if (!isfinite(unit->v[STATE + i])) return ERROR;
    return OK;
}
EXPORT Status fmi2CancelStep(Component c) { return (void)c, ERROR; }

EXPORT Status fmi2GetFMUstate(Component c, void **state)
{
    if (*state == NULL) *state = malloc(sizeof(Unit));
    if (*state == NULL) return ERROR;
    memcpy(*state, c, sizeof(Unit));
    return OK;
}
EXPORT Status fmi2SetFMUstate(Component c, void *state)
{
    memcpy(c, state, sizeof(Unit));
    return OK;
}
EXPORT Status fmi2FreeFMUstate(Component c, void **state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return OK;
}

/* What the unit does not have: variables of other types, serialised states, derivatives, steps in the background. */
#define NOT_THERE(name, ...) \
    EXPORT Status name(__VA_ARGS__) { return ERROR; }
#define NONE_OF(type, written) \
    EXPORT Status fmi2Get##type(Component c, const Reference r[], size_t n, written value[]) \
    { return (void)c, (void)r, (void)value, n ? ERROR : OK; } \
    EXPORT Status fmi2Set##type(Component c, const Reference r[], size_t n, const written value[]) \
    { return (void)c, (void)r, (void)value, n ? ERROR : OK; }
typedef const char *Text;
NONE_OF(Integer, int)
NONE_OF(Boolean, int)
NONE_OF(String, Text)
NOT_THERE(fmi2SerializedFMUstateSize, Component c, void *state, size_t *size)
NOT_THERE(fmi2SerializeFMUstate, Component c, void *state, char bytes[], size_t size)
NOT_THERE(fmi2DeSerializeFMUstate, Component c, const char bytes[], size_t size, void **state)
NOT_THERE(fmi2GetDirectionalDerivative, Component c, const Reference z[], size_t nz, const Reference v[], size_t nv,
          const double dv[], double dz[])
NOT_THERE(fmi2SetRealInputDerivatives, Component c, const Reference r[], size_t n, const int order[], const double v[])
NOT_THERE(fmi2GetRealOutputDerivatives, Component c, const Reference r[], size_t n, const int order[], double v[])
NOT_THERE(fmi2GetStatus, Component c, int kind, int *value)
NOT_THERE(fmi2GetRealStatus, Component c, int kind, double *value)
NOT_THERE(fmi2GetIntegerStatus, Component c, int kind, int *value)
NOT_THERE(fmi2GetBooleanStatus, Component c, int kind, int *value)
NOT_THERE(fmi2GetStringStatus, Component c, int kind, Text *value)
