/*
 * Integrate one motion, or many, by the method of order 8(5,3) of Dormand and Prince (E. Hairer,
 * S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, sect. II.5 and II.10);
 * after each step the state is projected on the loops.
 *
 * Defined above this text: NQ and NV, the numbers of coordinates and velocities, and N, their sum;
 * LOOPS, whether there are any; BALLS, the number of quaternions, at ball[] in q; STAGES and the
 * coefficients A, B, C, E3, E5; the constants of steps and projection in capital letters, which
 * generation/dop853.py explains; plain[], the natural unit of each velocity; and the program:
 *   rates      the rates of q and v
 *   landing    the changes of q and v that project a nearby state on the loops
 *   firmness   measure of regularity of the loops, zero in a singular position
 * Exported names begin with mecanique_, to differ from those of other libraries.
 */
enum { END, ROOM, NEAR, SMALL, MANY, STIFF, OFF };

typedef struct {
    double t, end;          /* present and final time [s] */
    double h;               /* length of the next step; 0 at the start [s] */
    double before;          /* error of the last step */
    double rtol, atol;      /* tolerances of a step */
    double max_step;        /* the longest step [s] */
    double near;            /* distance from a singular position to stop at, in natural units */
    long most, steps, evaluations, at_limit, below;
} Motion;

typedef struct {
    long room, noted;       /* largest and present number of noted steps */
    double *t, *y, *dy;     /* their times, states and rates; NULL to note none */
} Notes;

typedef struct {
    long number, done;      /* number of samples, and of those that are done */
    const double *times;    /* their times [s] */
    double *states;
} Samples;

typedef struct {
    long count, width;      /* numbers of runs, and of the parameters of each */
    const double *starts, *parameters;
    Samples samples;        /* samples of the runs, one run after the other */
    long *steps;
    int *ended;             /* the reason why each ended */
} Runs;

/* Project a state on the loops and normalize its quaternions; return whether that succeeded. */
static int land(double t, double *y, const double *p)
{
    for (int k = 0; k < BALLS; k++) {
        double *x = y + ball[k];
        const double length = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
        for (int i = 0; i < 4; i++) x[i] /= length;
    }
    if (!LOOPS) return 1;
    double change[N], last = ASTRAY;
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double size = 0.0, most = 1.0;
        landing(t, y, p, change);
        for (int i = 0; i < NQ; i++) {
            if (!isfinite(change[i])) return 0;
            size = fmax(size, fabs(change[i]));
            most = fmax(most, fabs(y[i]));
        }
        if (size <= ROUNDING * most || size > HALVED * last) {
            /* only rounding is left; the velocities are consistent with these positions */
            for (int i = NQ; i < N; i++) y[i] += change[i];
            return size <= CLOSED * most;
        }
        for (int i = 0; i < NQ; i++) y[i] += change[i];
        last = size;
    }
    return 0;
}

/* Estimate the distance to a singular position along the motion, in natural units. */
static double distance_along(double t, const double *y, const double *p, double *speed)
{
    *speed = 0.0;
    if (!LOOPS) return INFINITY;
    double there[N], dy[N];
    const double firm = firmness(t, y, p);
    for (int i = 0; i < NV; i++) *speed = fmax(*speed, fabs(y[NQ + i]) / plain[i]);
    if (!(firm > FIRM)) return 0.0;
    if (*speed == 0.0) return INFINITY;
    rates(t, y, p, dy);
    memcpy(there, y, sizeof there);
    for (int i = 0; i < NQ; i++) there[i] += PROBE / *speed * dy[i];
    const double change = fabs(firmness(t, there, p) - firm);
    return change > 0.0 ? firm * PROBE / change : INFINITY;
}

double mecanique_distance(double t, const double *y, const double *p, double *speed)
{
    return distance_along(t, y, p, speed);
}

/* Take a step of length h from y with the rates k[0]; next is at first the last stage's state. */
static void step(double t, const double *y, const double *p, double h, double k[][N], double *last,
                 double *next)
{
    for (int s = 1; s <= STAGES; s++) {
        const double *weights = s < STAGES ? A[s] : B;
        double *out = s < STAGES ? last : next;
        for (int i = 0; i < N; i++) {
            double sum = 0.0;
            for (int j = 0; j < s; j++) sum += weights[j] * k[j][i];
            out[i] = y[i] + h * sum;
        }
        if (s < STAGES) rates(t + C[s] * h, last, p, k[s]);
    }
}

/* Return the error of a step, relative to the tolerance. */
static double error_of(const Motion *m, const double *y, const double *next, double h,
                       double k[][N])
{
    double fifth = 0.0, third = 0.0;
    for (int i = 0; i < N; i++) {
        const double scale = m->atol + m->rtol * fmax(fabs(y[i]), fabs(next[i]));
        double five = 0.0, three = 0.0;
        for (int j = 0; j < STAGES; j++) {
            five += E5[j] * k[j][i];
            three += E3[j] * k[j][i];
        }
        fifth += five / scale * (five / scale);
        third += three / scale * (three / scale);
    }
    const double whole = fifth + 0.01 * third;
    return whole > 0.0 ? fabs(h) * fifth / sqrt(whole * N) : whole;
}

/* Return whether stability rather than accuracy limits the steps (Hairer et al., DOP853). */
static int is_stiff(Motion *m, double h, const double *last, const double *next, const double *rate,
                    const double *new_rate)
{
    double apart = 0.0, gain = 0.0;
    for (int i = 0; i < N; i++) {
        apart += (next[i] - last[i]) * (next[i] - last[i]);
        gain += (new_rate[i] - rate[i]) * (new_rate[i] - rate[i]);
    }
    if (apart > 0.0 && h * sqrt(gain / apart) > UNSTABLE) {
        m->at_limit++;
        m->below = 0;
    } else if (++m->below == STIFF_FORGET) {
        m->at_limit = 0;
    }
    return m->at_limit >= STIFF_AFTER;
}

/* Return a first step from the sizes of the state and its rates (Hairer et al., sect. II.4). */
static double first_step(const Motion *m, const double *y, const double *dy)
{
    double size = 0.0, rate = 0.0;
    for (int i = 0; i < N; i++) {
        const double scale = m->atol + m->rtol * fabs(y[i]);
        size += y[i] / scale * (y[i] / scale);
        rate += dy[i] / scale * (dy[i] / scale);
    }
    return size > UNKNOWN && rate > UNKNOWN ? FIRST * sqrt(size / rate) : BRIEF;
}

/*
 * Integrate until the end, or until there is a reason to stop, and return the reason. Steps are
 * noted, and samples taken.
 */
static int march(Motion *m, const double *p, double *y, Notes *notes, Samples *samples)
{
    double k[STAGES][N], inner[STAGES][N], last[N], next[N], dy[N], speed;
    int grows = 1;
    double away = distance_along(m->t, y, p, &speed);
    if (away < m->near) return NEAR;
    rates(m->t, y, p, k[0]);
    m->evaluations++;
    if (m->h == 0.0) m->h = first_step(m, y, k[0]);
    while (m->t < m->end) {
        if (m->steps >= m->most) return MANY;
        if (notes->t != NULL && notes->noted >= notes->room) return ROOM;
        double h = fmin(m->h, m->max_step);
        if (speed > 0.0) h = fmin(h, fmax(0.5 * (away - m->near), 0.1 * m->near) / speed);
        const int ends = m->t + NEARLY * h >= m->end;
        if (ends) h = m->end - m->t;
        step(m->t, y, p, h, k, last, next);
        m->evaluations += STAGES - 1;
        double error = error_of(m, y, next, h, k);
        if (error <= 1.0 && !land(m->t + h, next, p)) error = INFINITY;
        if (!(error <= 1.0)) {
            m->h = h * (error < INFINITY ? fmax(SHRINKAGE, SAFETY / pow(error, EXPONENT))
                                  : SHRINKAGE);
            grows = 0;
            if (m->h < SHORTEST * fmax(1.0, fabs(m->t))) return isfinite(error) ? SMALL : OFF;
            continue;
        }
        const double now = ends ? m->end : m->t + h;
        for (; samples->done < samples->number; samples->done++) {
            const double time = samples->times[samples->done];
            double *out = samples->states + samples->done * N, idle[N];
            if (time > now) break;
            if (time == now) {
                memcpy(out, next, sizeof next);
                continue;
            }
            memcpy(inner[0], k[0], sizeof k[0]);
            step(m->t, y, p, time - m->t, inner, idle, out);
            m->evaluations += STAGES - 1;
            land(time, out, p);
        }
        rates(now, next, p, dy);
        m->evaluations++;
        const int stiff = is_stiff(m, h, last, next, k[STAGES - 1], dy);
        memcpy(y, next, sizeof next);
        memcpy(k[0], dy, sizeof dy);
        const double factor = error > 0.0 ? SAFETY * pow(m->before, DAMPING) / pow(error, EXPONENT)
                                          : GROWTH;
        const double longer = h * fmax(SHRINKAGE, fmin(grows ? GROWTH : 1.0, factor));
        m->h = ends ? fmax(m->h, longer) : longer;
        m->before = fmax(error, BEFORE);
        m->t = now;
        m->steps++;
        grows = 1;
        if (notes->t != NULL) {
            notes->t[notes->noted] = now;
            memcpy(notes->y + notes->noted * N, y, sizeof next);
            memcpy(notes->dy + notes->noted * N, dy, sizeof dy);
            notes->noted++;
        }
        if (stiff) return STIFF;
        away = distance_along(now, y, p, &speed);
        if (away < m->near && now < m->end) return NEAR;
    }
    return END;
}

int mecanique_advance(Motion *m, const double *p, double *y, Notes *notes, Samples *samples)
{
    return march(m, p, y, notes, samples);
}

/* Integrate many motions, each from its own start and with its own parameters. */
void mecanique_advance_many(const Motion *same, const Runs *runs)
{
    for (long run = 0; run < runs->count; run++) {
        Motion m = *same;
        Notes none = {0, 0, NULL, NULL, NULL};
        Samples samples = runs->samples;
        double y[N];
        memcpy(y, runs->starts + run * N, sizeof y);
        samples.states += run * samples.number * N;
        runs->ended[run] = march(&m, runs->parameters + run * runs->width, y, &none, &samples);
        runs->steps[run] = m.steps;
    }
}
