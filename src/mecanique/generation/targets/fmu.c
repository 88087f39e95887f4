/*
 * A model of the FMI standard, version 3.0 (Modelica Association, 2022): model exchange and
 * co-simulation.
 *
 * Defined above this text: the steps (stepper.c), whose p are the parameters, then the inputs;
 * TOKEN, the token of instances; START and GIVEN, the initial values of y and p; FIXED, how each
 * of p may change; OUTPUTS and GROUPS, the numbers of outputs and of the functions
 * output[] that compute them, from first_output[] on. Value references count the time, the states,
 * their rates, p and the outputs, from 0 on. With CORNERS, corners.c stands above as well, and the
 * state and the heading of each of ELEMENTS follow p.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } Status;
typedef void (*Log)(void *environment, Status status, const char *category, const char *message);
typedef void (*Callback)(void);
typedef uint32_t Reference;

enum { TIME = 0, STATES = 1, RATES = STATES + N, GIVENS = RATES + N, RESULTS = GIVENS + P };
enum { END_OF_RESULTS = RESULTS + OUTPUTS };
enum Mode { INSTANTIATED, INITIALIZATION, EVENT, CONTINUOUS, STEP, TERMINATED };
enum Change { TUNABLE, FIXED_LENGTH, INPUT };


typedef struct {
    double t, y[N], p[P + 3 * ELEMENTS + 1];
    double dy[N], out[OUTPUTS + 1];     /* the last results */
    bool knows_rates, knows[GROUPS + 1];
    double left[2 * ELEMENTS + 1];      /* of each element, after the last step or corner */
    Motion motion;
    enum Mode mode;
} State;

typedef struct {
    State now;
    double tolerance;
    bool steps;                         /* co-simulation */
    bool logs;
    Log log;
    void *environment;
} Instance;

static Status say(const Instance *m, Status status, const char *message)
{
    if (m->log != NULL && (status != fmi3OK || m->logs)) {
        m->log(m->environment, status, status == fmi3OK ? "logAll" : "logStatusError", message);
    }
    return status;
}

static void forget(State *now)
{
    now->knows_rates = false;
    for (int k = 0; k < GROUPS; k++) now->knows[k] = false;
}

static void restart(Motion *motion)
{
    motion->h = 0.0;
    motion->before = BEFORE;
    motion->at_limit = motion->below = 0;
}

static void reset(Instance *m)
{
    State *now = &m->now;
    memset(now, 0, sizeof *now);
    memcpy(now->y, START, sizeof now->y);
    for (int k = 0; k < P; k++) now->p[k] = GIVEN[k];
    restart(&now->motion);
    now->motion.near = NEAREST;
    now->motion.max_step = INFINITY;
    m->tolerance = TOLERANCE;
    now->mode = INSTANTIATED;
}

static Instance *make(const char *token, bool logs, void *environment, Log log, bool steps)
{
    Instance *m = calloc(1, sizeof *m);
    if (m == NULL) return NULL;
    m->logs = logs;
    m->log = log;
    m->environment = environment;
    m->steps = steps;
    reset(m);
    if (token == NULL || strcmp(token, TOKEN) != 0) {
        say(m, fmi3Error, "this is the binary of another model: the instantiation token differs");
        free(m);
        return NULL;
    }
    return m;
}

static Status find_rates(Instance *m)
{
    State *now = &m->now;
    if (!now->knows_rates) {
        rates(now->t, now->y, now->p, now->dy);
        for (int i = 0; i < N; i++) {
            if (!isfinite(now->dy[i])) {
                return say(m, fmi3Discard, "no acceleration is finite in this state");
            }
        }
        now->knows_rates = true;
    }
    return fmi3OK;
}

static Status get(Instance *m, Reference at, double *value)
{
    State *now = &m->now;
    if (at == TIME) {
        *value = now->t;
    } else if (at < RATES) {
        *value = now->y[at - STATES];
    } else if (at < GIVENS) {
        const Status found = find_rates(m);
        *value = now->dy[at - RATES];
        return found;
    } else if (at < RESULTS) {
        *value = now->p[at - GIVENS];
    } else if (at < END_OF_RESULTS) {
        const int place = (int)(at - RESULTS);
        int k = 0;
        while (first_output[k + 1] <= place) k++;
        if (!now->knows[k]) output[k](now->t, now->y, now->p, now->out + first_output[k]);
        now->knows[k] = true;
        *value = now->out[place];
    } else {
        return say(m, fmi3Error, "no variable has this value reference");
    }
    return fmi3OK;
}

static Status set(Instance *m, Reference at, double value)
{
    State *now = &m->now;
    const bool before = now->mode == INSTANTIATED || now->mode == INITIALIZATION;
    if (!isfinite(value)) return say(m, fmi3Error, "expected a finite value");
    if (STATES <= at && at < RATES) {
        if (!before) return say(m, fmi3Error, "a state is set by its start value");
        now->y[at - STATES] = value;
    } else if (GIVENS <= at && at < RESULTS) {
        if (!before && FIXED[at - GIVENS] == FIXED_LENGTH) {
            return say(m, fmi3Error, "a parameter on which closed loops depend is fixed");
        }
        now->p[at - GIVENS] = value;
    } else {
        return say(m, fmi3Error, "this variable is computed, and cannot be set");
    }
    forget(now);
    return fmi3OK;
}

/* Project the state on the loops, and forget the results for the state before. */
static Status settle(Instance *m, const char *message)
{
    State *now = &m->now;
    if (!land(now->t, now->y, now->p, CLOSED)) return say(m, fmi3Error, message);
    forget(now);
    return fmi3OK;
}

/* Return the relative distance of the state from its loops, and of quaternions from unit length. */
static double stray(const State *now)
{
    double change[N], worst = 0.0;
    for (int k = 0; k < BALLS; k++) {
        const double *x = now->y + ball[k];
        worst = fmax(worst, fabs(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3] - 1.0));
    }
#if CORNERS
    worst = fmax(worst, creep(now->t, now->y, now->p));
#endif
    if (!LOOPS) return worst;
    landing(now->t, now->y, now->p, change);
    for (int i = 0; i < N; i++) worst = fmax(worst, fabs(change[i]) / (1.0 + fabs(now->y[i])));
    return worst;
}

#if CORNERS
static const double AHEAD = 1e-11;      /* tools find corners to this part of the time, or of 1 s */

/* Return the tolerance by which an importing tool finds corners: it tells no lower bounces apart. */
static double early(const Instance *m)
{
    return m->steps ? 0.0 : m->tolerance;
}

/* Note what is left of each state after a corner: a mode begins sound, but for rounding. */
static void note_margins(State *now)
{
    give_margins(now->t, now->y, now->p, now->left);
    for (int j = 0; j < 2 * ELEMENTS; j++) now->left[j] = fmax(now->left[j], 0.0);
    forget(now);
}
#endif

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT Status fmi3SetDebugLogging(void *m, bool on, size_t n, const char *const categories[])
{
    (void)n; (void)categories;
    ((Instance *)m)->logs = on;
    return fmi3OK;
}

EXPORT void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *place,
                                          bool visible, bool logs, void *environment, Log log)
{
    (void)name; (void)place; (void)visible;
    return make(token, logs, environment, log, false);
}

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *place,
                                         bool visible, bool logs, bool events, bool early,
                                         const Reference between[], size_t n, void *environment,
                                         Log log, Callback update)
{
    (void)name; (void)place; (void)visible; (void)events; (void)early; (void)between; (void)n;
    (void)update;
    return make(token, logs, environment, log, true);
}

EXPORT void *fmi3InstantiateScheduledExecution(const char *name, const char *token,
                                               const char *place, bool visible, bool logs,
                                               void *environment, Log log, Callback update,
                                               Callback lock, Callback unlock)
{
    (void)name; (void)token; (void)place; (void)visible; (void)logs; (void)update; (void)lock;
    (void)unlock;
    if (log != NULL) {
        log(environment, fmi3Error, "logStatusError", "this model has no scheduled execution");
    }
    return NULL;
}

EXPORT void fmi3FreeInstance(void *m) { free(m); }

EXPORT Status fmi3EnterInitializationMode(void *model, bool has_tolerance, double tolerance,
                                          double start, bool has_stop, double stop)
{
    Instance *m = model;
    (void)has_stop; (void)stop;
    if (has_tolerance && !(tolerance > 0.0)) return say(m, fmi3Error, "expected a tolerance above 0");
    if (has_tolerance) m->tolerance = fmax(tolerance, 1e-14);
    m->now.t = start;
    forget(&m->now);
    m->now.mode = INITIALIZATION;
    return fmi3OK;
}

EXPORT Status fmi3ExitInitializationMode(void *model)
{
    Instance *m = model;
    m->now.mode = m->steps ? STEP : EVENT;
    const Status closed =
        settle(m, "the start is not on the closed loops: give all coordinates, or change none");
#if CORNERS
    State *now = &m->now;
    char words[SENTENCE];
    if (!begin(now->t, now->y, now->p, early(m), words)) return say(m, fmi3Error, words);
    note_margins(now);
#endif
    return closed;
}

EXPORT Status fmi3EnterEventMode(void *m)
{
    ((Instance *)m)->now.mode = EVENT;
    return fmi3OK;
}

EXPORT Status fmi3Terminate(void *m)
{
    ((Instance *)m)->now.mode = TERMINATED;
    return fmi3OK;
}

EXPORT Status fmi3Reset(void *m)
{
    reset(m);
    return fmi3OK;
}

EXPORT Status fmi3GetFloat64(void *m, const Reference at[], size_t n, double values[], size_t size)
{
    Status worst = fmi3OK;
    if (n != size) return say(m, fmi3Error, "expected one value for each variable");
    for (size_t k = 0; k < n; k++) {
        const Status found = get(m, at[k], values + k);
        if (found > worst) worst = found;
    }
    return worst;
}

EXPORT Status fmi3SetFloat64(void *m, const Reference at[], size_t n, const double values[],
                             size_t size)
{
    if (n != size) return say(m, fmi3Error, "expected one value for each variable");
    for (size_t k = 0; k < n; k++) {
        const Status done = set(m, at[k], values[k]);
        if (done != fmi3OK) return done;
    }
    return fmi3OK;
}

/* Variables of other types: there are none. */
#define NONE(type)                                                                            \
    EXPORT Status fmi3Get##type(void *m, const Reference at[], size_t n, void *values,        \
                                size_t size)                                                  \
    {                                                                                         \
        (void)at; (void)values; (void)size;                                                   \
        return n ? say(m, fmi3Error, "no variable of this model is a " #type) : fmi3OK;       \
    }                                                                                         \
    EXPORT Status fmi3Set##type(void *m, const Reference at[], size_t n, const void *values,  \
                                size_t size)                                                  \
    {                                                                                         \
        (void)at; (void)values; (void)size;                                                   \
        return n ? say(m, fmi3Error, "no variable of this model is a " #type) : fmi3OK;       \
    }
NONE(Float32)
NONE(Int8)
NONE(UInt8)
NONE(Int16)
NONE(UInt16)
NONE(Int32)
NONE(UInt32)
NONE(Int64)
NONE(UInt64)
NONE(Boolean)
NONE(String)

EXPORT Status fmi3GetBinary(void *m, const Reference at[], size_t n, size_t sizes[],
                            const uint8_t *values[], size_t size)
{
    (void)at; (void)sizes; (void)values; (void)size;
    return n ? say(m, fmi3Error, "no variable of this model is a Binary") : fmi3OK;
}

EXPORT Status fmi3SetBinary(void *m, const Reference at[], size_t n, const size_t sizes[],
                            const uint8_t *const values[], size_t size)
{
    (void)at; (void)sizes; (void)values; (void)size;
    return n ? say(m, fmi3Error, "no variable of this model is a Binary") : fmi3OK;
}

/* Functions of features that this model lacks, by the number and kind of their arguments. */
#define LACKS(name, arguments)                                                                \
    EXPORT Status name arguments                                                              \
    {                                                                                         \
        return say(m, fmi3Error, #name " is not supported: this model has no such feature");  \
    }
LACKS(fmi3GetClock, (void *m))
LACKS(fmi3SetClock, (void *m))
LACKS(fmi3GetNumberOfVariableDependencies, (void *m))
LACKS(fmi3GetVariableDependencies, (void *m))
LACKS(fmi3GetDirectionalDerivative, (void *m))
LACKS(fmi3GetAdjointDerivative, (void *m))
LACKS(fmi3GetIntervalDecimal, (void *m))
LACKS(fmi3GetIntervalFraction, (void *m))
LACKS(fmi3GetShiftDecimal, (void *m))
LACKS(fmi3GetShiftFraction, (void *m))
LACKS(fmi3SetIntervalDecimal, (void *m))
LACKS(fmi3SetIntervalFraction, (void *m))
LACKS(fmi3SetShiftDecimal, (void *m))
LACKS(fmi3SetShiftFraction, (void *m))
LACKS(fmi3GetOutputDerivatives, (void *m))
LACKS(fmi3ActivateModelPartition, (void *m))
LACKS(fmi3EnterConfigurationMode, (void *m))
LACKS(fmi3ExitConfigurationMode, (void *m))

EXPORT Status fmi3GetFMUState(void *m, void **kept)
{
    if (*kept == NULL) *kept = malloc(sizeof(State));
    if (*kept == NULL) return say(m, fmi3Error, "there is no memory for a state");
    memcpy(*kept, &((Instance *)m)->now, sizeof(State));
    return fmi3OK;
}

EXPORT Status fmi3SetFMUState(void *m, void *kept)
{
    memcpy(&((Instance *)m)->now, kept, sizeof(State));
    return fmi3OK;
}

EXPORT Status fmi3FreeFMUState(void *m, void **kept)
{
    (void)m;
    free(*kept);
    *kept = NULL;
    return fmi3OK;
}

EXPORT Status fmi3SerializedFMUStateSize(void *m, void *kept, size_t *size)
{
    (void)m; (void)kept;
    *size = sizeof(State);
    return fmi3OK;
}

EXPORT Status fmi3SerializeFMUState(void *m, void *kept, uint8_t bytes[], size_t size)
{
    if (size != sizeof(State)) return say(m, fmi3Error, "expected a state of this model");
    memcpy(bytes, kept, size);
    return fmi3OK;
}

EXPORT Status fmi3DeserializeFMUState(void *m, const uint8_t bytes[], size_t size, void **kept)
{
    if (size != sizeof(State)) return say(m, fmi3Error, "expected a state of this model");
    const Status made = fmi3GetFMUState(m, kept);
    if (made == fmi3OK) memcpy(*kept, bytes, size);
    return made;
}

EXPORT Status fmi3EvaluateDiscreteStates(void *m)
{
    (void)m;
    return fmi3OK;
}

EXPORT Status fmi3UpdateDiscreteStates(void *model, bool *again, bool *terminates, bool *nominals,
                                       bool *values, bool *has_next, double *next)
{
    Instance *m = model;
    *again = *terminates = *nominals = *has_next = false;
    *next = 0.0;
#if CORNERS
    State *now = &m->now;
    double left[2 * ELEMENTS];
    char words[SENTENCE];
    int rows[ROWS];
    bool passed[2 * ELEMENTS];
    if (find_rates(m) != fmi3OK) return fmi3Discard;
    /* the tool may have found the corner just before it: look a little ahead */
    double ahead[N];
    const double h = AHEAD * (1.0 + fabs(now->t));
    for (int i = 0; i < N; i++) ahead[i] = now->y[i] + h * now->dy[i];
    give_margins(now->t + h, ahead, now->p, left);
    for (int j = 0; j < 2 * ELEMENTS; j++) passed[j] = left[j] < 0.0 && now->left[j] >= 0.0;
    /* of slip in space that ends, margins touch zero, and no tool finds them below it */
    Terms k;
    know(now->t, now->y, now->p, &k);
    for (int e = 0; e < ELEMENTS; e++)
        if (now->p[MODE + e] == SLIPS && size_along(e, k.rate) <= late_speed(&k, now->y, early(m)))
            passed[2 * e + 1] = true;
    /* first, as rates of rows that are held would be taken for rates of contacts that part */
    project(now->t, now->y, now->p, list_held(now->p + MODE, rows), rows);
    bool switched = false;
    for (int j = 0; j < 2 * ELEMENTS; j++) {
        if (!passed[j]) continue;
        /* of margins that pass zero at once, those that no switch before has lifted */
        if (switched) give_margins(now->t, now->y, now->p, left);
        if (switched && left[j] >= 0.0) continue;
        if (!switch_at(now->t, now->y, now->p, j, early(m), words)) return say(m, fmi3Error, words);
        switched = true;
    }
    note_margins(now);
    *values = true;
    return fmi3OK;
#endif
    *values = stray(&m->now) > 0.1 * m->tolerance;
    return *values ? settle(m, "the state is too far from the closed loops") : fmi3OK;
}

EXPORT Status fmi3EnterContinuousTimeMode(void *m)
{
    ((Instance *)m)->now.mode = CONTINUOUS;
    return fmi3OK;
}

/* A state that has left its loops is projected on them in an event. */
EXPORT Status fmi3CompletedIntegratorStep(void *model, bool no_going_back, bool *event,
                                          bool *terminates)
{
    Instance *m = model;
    (void)no_going_back;
    *terminates = false;
    *event = stray(&m->now) > m->tolerance;
#if CORNERS
    State *now = &m->now;
    double left[2 * ELEMENTS];
    give_margins(now->t, now->y, now->p, left);
    for (int j = 0; j < 2 * ELEMENTS; j++) {
        if (left[j] < 0.0 && now->left[j] >= 0.0) *event = true;
        else now->left[j] = left[j];
    }
#endif
    return fmi3OK;
}

EXPORT Status fmi3SetTime(void *m, double t)
{
    ((Instance *)m)->now.t = t;
    forget(&((Instance *)m)->now);
    return fmi3OK;
}

EXPORT Status fmi3SetContinuousStates(void *model, const double states[], size_t n)
{
    Instance *m = model;
    if (n != N) return say(m, fmi3Error, "expected a value for each state");
    memcpy(m->now.y, states, sizeof m->now.y);
    forget(&m->now);
    return fmi3OK;
}

EXPORT Status fmi3GetContinuousStateDerivatives(void *model, double out[], size_t n)
{
    Instance *m = model;
    if (n != N) return say(m, fmi3Error, "expected a place for each state");
    const Status found = find_rates(m);
    memcpy(out, m->now.dy, sizeof m->now.dy);
    return found;
}

EXPORT Status fmi3GetEventIndicators(void *m, double out[], size_t n)
{
    (void)out;
    if (n != 2 * ELEMENTS) return say(m, fmi3Error, "expected a place for each event indicator");
#if CORNERS
    const State *now = &((Instance *)m)->now;
    give_margins(now->t, now->y, now->p, out);
#endif
    return fmi3OK;
}

EXPORT Status fmi3GetContinuousStates(void *model, double out[], size_t n)
{
    Instance *m = model;
    if (n != N) return say(m, fmi3Error, "expected a place for each state");
    memcpy(out, m->now.y, sizeof m->now.y);
    return fmi3OK;
}

EXPORT Status fmi3GetNominalsOfContinuousStates(void *m, double out[], size_t n)
{
    if (n != N) return say(m, fmi3Error, "expected a place for each state");
    for (int i = 0; i < N; i++) out[i] = 1.0;
    return fmi3OK;
}

EXPORT Status fmi3GetNumberOfEventIndicators(void *m, size_t *n)
{
    (void)m;
    *n = 2 * ELEMENTS;
    return fmi3OK;
}

EXPORT Status fmi3GetNumberOfContinuousStates(void *m, size_t *n)
{
    (void)m;
    *n = N;
    return fmi3OK;
}

EXPORT Status fmi3EnterStepMode(void *m)
{
    ((Instance *)m)->now.mode = STEP;
    return fmi3OK;
}

EXPORT Status fmi3DoStep(void *model, double t, double step, bool no_going_back, bool *event,
                         bool *terminates, bool *early, double *last)
{
    static const char *const why[] = {
        [NEAR] = "near a position where the loops lock or branch, which this model does not pass",
        [SMALL] = "the steps become too small",
        [OFF] = "no state after this one is finite and on the loops",
    };
    Instance *m = model;
    State *now = &m->now;
    Motion *motion = &now->motion;
    (void)no_going_back;
    *event = *terminates = *early = false;
    motion->t = now->t = t;
    motion->end = t + step;
    motion->rtol = motion->atol = m->tolerance;
    motion->most = 0x7fffffff;
    motion->steps = 0;
    int reason = STIFF;
#if CORNERS
    char words[SENTENCE] = "";
    motion->at_limit = motion->below = 0;
    reason = march_on(motion, now->p, now->y, words);
    if (reason == CORNER) return say(m, fmi3Error, words);
#else
    Notes none = {0, 0, NULL, NULL, NULL};
    Samples samples = {0, 0, NULL, NULL};
    while (reason == STIFF || reason == MANY) {
        /* stiff motions are also computed correctly, though slowly */
        motion->at_limit = motion->below = 0;
        motion->steps = 0;
        reason = march(motion, now->p, now->y, &none, &samples);
    }
#endif
    *last = now->t = motion->t;
    forget(now);
    return reason == END ? fmi3OK : say(m, fmi3Error, why[reason]);
}
