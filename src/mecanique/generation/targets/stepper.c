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
enum { END, ROOM, NEAR, SMALL, MANY, STIFF, OFF, PAST };

typedef struct {
    double t, end;          /* present and final time [s] */
    double h;               /* length of the next step; 0 at the start [s] */
    double before;          /* error of the last step */
    double rtol, atol;      /* tolerances of a step */
    double max_step;        /* the longest step [s] */
    double near;            /* distance from a singular position to stop at, in natural units */
    double leap;            /* distance from which to leap across it if branches cross, or 0 */
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

/*
 * Project a state on the loops and normalize its quaternions; return whether the last change of
 * position was at most `closed`, relative to its size or one.
 */
static int land(double t, double *y, const double *p, double closed)
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
            return size <= closed * most;
        }
        for (int i = 0; i < NQ; i++) y[i] += change[i];
        last = size;
    }
    return 0;
}

/* Estimate the distance to a singular position along the motion, in natural units; behind, < 0. */
static double signed_distance(double t, const double *y, const double *p, double least,
                              double *speed)
{
    *speed = 0.0;
    if (!LOOPS) return INFINITY;
    double there[N], dy[N];
    const double firm = firmness(t, y, p);
    for (int i = 0; i < NV; i++) *speed = fmax(*speed, fabs(y[NQ + i]) / plain[i]);
    if (!(firm > least)) return 0.0;
    if (*speed == 0.0) return INFINITY;
    rates(t, y, p, dy);
    memcpy(there, y, sizeof there);
    for (int i = 0; i < NQ; i++) there[i] += PROBE / *speed * dy[i];
    const double change = firm - firmness(t, there, p);
    return change != 0.0 ? firm * PROBE / change : INFINITY;
}

static double distance_along(double t, const double *y, const double *p, double *speed)
{
    return fabs(signed_distance(t, y, p, FIRM, speed));
}

double mecanique_distance(double t, const double *y, const double *p, double *speed)
{
    return distance_along(t, y, p, speed);
}

/*
 * Take a step of length h from y with the rates k[0]; next is at first the last stage's state. Near a
 * singular position the states of the stages are projected on the loops: there the accelerations
 * off them grow without bound. Return whether they were.
 */
static int step(double t, const double *y, const double *p, double h, double k[][N], double *last,
                double *next, int onto)
{
    for (int s = 1; s <= STAGES; s++) {
        const double *weights = s < STAGES ? A[s] : B;
        double *out = s < STAGES ? last : next;
        for (int i = 0; i < N; i++) {
            double sum = 0.0;
            for (int j = 0; j < s; j++) sum += weights[j] * k[j][i];
            out[i] = y[i] + h * sum;
        }
        if (s == STAGES) continue;
        if (onto && !land(t + C[s] * h, last, p, MAGNIFIED)) return 0;
        rates(t + C[s] * h, last, p, k[s]);
    }
    return 1;
}

/*
 * Prepare the dense output of order 7 of a leap (Hairer et al., DOP853): none of its three stages is
 * near the middle of the gap in which the singular position lies. Return whether they are on loops.
 */
static int prepare(double t, const double *y, const double *p, double h, double k[][N],
                   const double *next, const double *dy, double dense[][N])
{
    double all[STAGES + 4][N], there[N];
    memcpy(all, k, STAGES * sizeof k[0]);
    memcpy(all[STAGES], dy, sizeof k[0]);
    for (int s = 0; s < 3; s++) {
        for (int i = 0; i < N; i++) {
            double sum = 0.0;
            for (int j = 0; j <= STAGES + s; j++) sum += LATER[s][j] * all[j][i];
            there[i] = y[i] + h * sum;
        }
        if (!land(t + NODES[s] * h, there, p, MAGNIFIED)) return 0;
        rates(t + NODES[s] * h, there, p, all[STAGES + 1 + s]);
    }
    for (int i = 0; i < N; i++) {
        const double rise = next[i] - y[i];
        dense[0][i] = rise;
        dense[1][i] = h * k[0][i] - rise;
        dense[2][i] = 2.0 * rise - h * (dy[i] + k[0][i]);
        for (int row = 0; row < 4; row++) {
            double sum = 0.0;
            for (int j = 0; j < STAGES + 4; j++) sum += DENSE[row][j] * all[j][i];
            dense[3 + row][i] = h * sum;
        }
    }
    return 1;
}

/* Evaluate the dense output at a fraction x of a step from y. */
static void interpolate(double x, const double *y, double dense[][N], double *out)
{
    for (int i = 0; i < N; i++) {
        double sum = 0.0;
        for (int row = 6; row >= 0; row--) sum = (sum + dense[row][i]) * (row % 2 ? 1.0 - x : x);
        out[i] = y[i] + sum;
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
 *
 * Where branches cross, the motion along each is smooth, and only the equations fail. A leap is a
 * step so long that the singular position lies in the middle of the widest gap between its stages.
 */
static int march(Motion *m, const double *p, double *y, Notes *notes, Samples *samples)
{
    double k[STAGES][N], inner[STAGES][N], dense[7][N], last[N], next[N], dy[N], speed;
    int grows = 1;
    const int crosses = m->leap > 0.0;
    const double firm = crosses ? 0.0 : FIRM, closed = crosses ? MAGNIFIED : CLOSED;
    double leap = m->leap, ahead = signed_distance(m->t, y, p, firm, &speed), away = fabs(ahead);
    if (!crosses && away < m->near) return NEAR;
    rates(m->t, y, p, k[0]);
    m->evaluations++;
    if (m->h == 0.0) m->h = first_step(m, y, k[0]);
    while (m->t < m->end) {
        if (m->steps >= m->most) return MANY;
        if (notes->t != NULL && notes->noted >= notes->room) return ROOM;
        double h = fmin(m->h, m->max_step);
        const int leaps = crosses && ahead >= 0.0 && ahead <= leap;
        const double least = crosses ? leap : m->near;
        if (crosses && ahead < 0.0)
            h = fmin(h, fmax(away, leap) / speed);
        else if (speed > 0.0)
            h = fmin(h, fmax(0.5 * (away - least), 0.1 * least) / speed);
        if (leaps) h = ahead / speed / MIDDLE;
        const int ends = m->t + NEARLY * h >= m->end;
        if (ends && leaps) return NEAR;
        if (ends) h = m->end - m->t;
        const int taken = step(m->t, y, p, h, k, last, next, crosses);
        m->evaluations += STAGES - 1;
        double error = taken ? error_of(m, y, next, h, k) : INFINITY;
        if (leaps) error /= LEAP_ERROR;
        if (error <= 1.0 && !land(m->t + h, next, p, closed)) error = INFINITY;
        const double now = ends ? m->end : m->t + h;
        if (error <= 1.0) {
            rates(now, next, p, dy);
            m->evaluations++;
            if (leaps && !prepare(m->t, y, p, h, k, next, dy, dense)) error = INFINITY;
        }
        if (!(error <= 1.0) && leaps) {
            leap *= 0.5;
            if (leap < LEAST_LEAP) return NEAR;
            continue;
        }
        if (!(error <= 1.0)) {
            m->h = h * (error < INFINITY ? fmax(SHRINKAGE, SAFETY / pow(error, EXPONENT))
                                  : SHRINKAGE);
            grows = 0;
            if (m->h < SHORTEST * fmax(1.0, fabs(m->t))) return isfinite(error) ? SMALL : OFF;
            continue;
        }
        for (; samples->done < samples->number; samples->done++) {
            const double time = samples->times[samples->done];
            double *out = samples->states + samples->done * N, idle[N];
            if (time > now) break;
            if (time == now) {
                memcpy(out, next, sizeof next);
                continue;
            }
            if (leaps) {
                interpolate((time - m->t) / h, y, dense, out);
                continue;
            }
            memcpy(inner[0], k[0], sizeof k[0]);
            step(m->t, y, p, time - m->t, inner, idle, out, crosses);
            m->evaluations += STAGES - 1;
            land(time, out, p, closed);
        }
        const int stiff = is_stiff(m, h, last, next, k[STAGES - 1], dy);
        memcpy(y, next, sizeof next);
        memcpy(k[0], dy, sizeof dy);
        const double factor = error > 0.0 ? SAFETY * pow(m->before, DAMPING) / pow(error, EXPONENT)
                                          : GROWTH;
        const double longer = h * fmax(SHRINKAGE, fmin(grows ? GROWTH : 1.0, factor));
        m->h = ends || crosses ? fmax(m->h, longer) : longer;
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
        if (stiff && !crosses) return STIFF;
        ahead = signed_distance(now, y, p, firm, &speed);
        away = fabs(ahead);
        if (!crosses && away < m->near && now < m->end) return NEAR;
        if (crosses && away > PASSED * m->near && now < m->end) return PAST;
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
