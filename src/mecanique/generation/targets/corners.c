/*
 * The corners of a motion: in which mode each element that switches is, which follows where a margin
 * passes zero, and impacts (F. Pfeiffer, C. Glocker, Multibody Dynamics with Unilateral Contacts,
 * 1996). All modes are tried, so that none, one and several solutions are told apart.
 *
 * Defined above this text: N, NQ and NV as for the steps; ELEMENTS and ROWS, the numbers of elements
 * and of their rows; MODE, the place in p from which on the state of each element stands, and then
 * the two parts of each heading along which it slips; for each
 * element the rows normal[], tangents[][2] and pressing[], −1 for none, whether it is struck[], elastic[],
 * impacts in_turn[] or by_impulse[] (Poisson's law) or has a side with ends[], and its name[]; whether a row is positional[], the rate of a gap; LENGTH, a
 * characteristic length; tolerances in capital letters, which derivation/tolerances.py explains;
 * measure(t, y, p, out), which gives Terms; and for each element collide[](t, y, p, out), what
 * velocities change by as it is struck by itself, then the impulses of all rows, or NULL.
 */
#include <stdbool.h>
#include <stdio.h>

/*
 * HELD: closed, or sticks. BEGINS: slips in space, along the heading in which slip grows, as slow slip
 * turns towards that at once. SLIPS: in space, along a heading. AHEAD_KEPT and BACK_KEPT: sticks with all its static friction, as what
 * else is held leaves it no slip; of the forces that rigid bodies do not determine these are some.
 */
enum Element { OPEN_ELEMENT, HELD, FORWARD, BACKWARD, BEGINS, SLIPS, AHEAD_KEPT, BACK_KEPT, CHOICES };
enum { MODE_SIZE = 3 * ELEMENTS };
enum { LONGEST = (int)NV > (int)ROWS ? (int)NV : (int)ROWS };
enum { MOST_AT_ONCE = 50, MOST_IN_TURN = 10000, MOST_FOLLOWING = 16, SENTENCE = 400 };

typedef struct {
    double first[NQ], mass[NV][NV], load[NV];            /* rates of q, M, forces less bias */
    double slopes[ROWS][NV], gamma[ROWS], gap[ROWS], rate[ROWS];
    double inside[ELEMENTS];                             /* how far from the ends of its side */
    double kinetic[ELEMENTS], sticking[ELEMENTS], restitution[ELEMENTS], stiffness[ELEMENTS];
    double holds[ELEMENTS];
} Terms;

/* What a mode is solved for: accelerations under loads, or changes of velocities at an impact. */
typedef struct {
    bool impact, expands;                                /* expands: the impulses of normals are known */
    double load[NV], wanted[ROWS], sticking[ELEMENTS], holds[ELEMENTS], given[ROWS];
} Drive;

typedef struct {
    double mode[MODE_SIZE], a[NV], force[ROWS];
} Solved;

/* The size of a vector along the tangents of an element, and its part along a heading. */
static double size_along(int e, const double *rows)
{
    const int rub = tangents[e][0], across = tangents[e][1];
    return rub < 0 ? 0.0 : across < 0 ? fabs(rows[rub]) : hypot(rows[rub], rows[across]);
}

static double part_along(int e, const double *rows, const double *heading)
{
    const int across = tangents[e][1];
    return heading[0] * rows[tangents[e][0]] + (across < 0 ? 0.0 : heading[1] * rows[across]);
}

static const double *heading_of(const double *mode, int e)
{
    return mode + ELEMENTS + 2 * e;
}

/* Put an element into a state; in a plane its heading is forward or backward. */
static void put_state(double *mode, int e, int state, double x, double y)
{
    mode[e] = state;
    mode[ELEMENTS + 2 * e] = x;
    mode[ELEMENTS + 2 * e + 1] = y;
}

static void put_in_plane(double *mode, int e, int state)
{
    const bool ahead = state == FORWARD || state == AHEAD_KEPT;
    put_state(mode, e, state, state < FORWARD ? 0.0 : ahead ? 1.0 : -1.0, 0.0);
}

static void put_along(double *mode, int e, const double *slip)
{
    const double speed = size_along(e, slip);
    put_state(mode, e, SLIPS, slip[tangents[e][0]] / speed, slip[tangents[e][1]] / speed);
}

static void know(double t, const double *y, const double *p, Terms *k)
{
    measure(t, y, p, (double *)k);
}

/*
 * Solve n equations with columns of right sides by elimination with the largest pivot of all; return
 * the rank. Unknowns without a pivot become zero.
 */
static int eliminate(int n, int columns, double *matrix, double *right)
{
    int order[LONGEST], rank = 0;
    double first = 0.0;
    for (int i = 0; i < n; i++) order[i] = i;
    for (; rank < n; rank++) {
        int row = rank, column = rank;
        for (int i = rank; i < n; i++)
            for (int j = rank; j < n; j++)
                if (fabs(matrix[i * n + j]) > fabs(matrix[row * n + column])) row = i, column = j;
        const double pivot = matrix[row * n + column];
        if (rank == 0) first = fabs(pivot);
        if (!(fabs(pivot) > REDUNDANT * first)) break;
        for (int j = 0; j < n; j++) {
            const double kept = matrix[row * n + j];
            matrix[row * n + j] = matrix[rank * n + j];
            matrix[rank * n + j] = kept;
        }
        for (int i = 0; i < n; i++) {
            const double kept = matrix[i * n + column];
            matrix[i * n + column] = matrix[i * n + rank];
            matrix[i * n + rank] = kept;
        }
        for (int c = 0; c < columns; c++) {
            const double kept = right[row * columns + c];
            right[row * columns + c] = right[rank * columns + c];
            right[rank * columns + c] = kept;
        }
        const int place = order[column];
        order[column] = order[rank];
        order[rank] = place;
        for (int i = rank + 1; i < n; i++) {
            const double part = matrix[i * n + rank] / pivot;
            if (part == 0.0) continue;
            for (int j = rank; j < n; j++) matrix[i * n + j] -= part * matrix[rank * n + j];
            for (int c = 0; c < columns; c++)
                right[i * columns + c] -= part * right[rank * columns + c];
        }
    }
    for (int c = 0; c < columns; c++) {
        double solved[LONGEST] = {0.0};
        for (int i = rank - 1; i >= 0; i--) {
            double sum = right[i * columns + c];
            for (int j = i + 1; j < rank; j++) sum -= matrix[i * n + j] * solved[order[j]];
            solved[order[i]] = sum / matrix[i * n + i];
        }
        for (int i = 0; i < n; i++) right[i * columns + c] = solved[i];
    }
    return rank;
}

/* Replace columns of generalized forces, NV by `columns`, by the accelerations they cause. */
static void by_mass(const Terms *k, int columns, double *forces)
{
    double mass[NV * NV];
    memcpy(mass, k->mass, sizeof mass);
    eliminate(NV, columns, mass, forces);
}

static double along(const double *a, const double *b)
{
    double sum = 0.0;
    for (int i = 0; i < NV; i++) sum += a[i] * b[i];
    return sum;
}

static double within(const double *a, const double *b)
{
    double sum = 0.0;
    for (int i = 0; i < NV; i++) sum += fabs(a[i] * b[i]);
    return sum;
}

/* Find accelerations and forces in a mode; return whether rigid bodies determine them. */
static bool solve_mode(const Terms *k, const Drive *drive, const double *mode, Solved *solved)
{
    int rows[ROWS], held = 0;
    double known[ROWS] = {0.0}, share[ROWS][ROWS] = {{0.0}};
    for (int e = 0; e < ELEMENTS; e++) {
        const int press = normal[e];
        if (mode[e] == OPEN_ELEMENT) continue;
        if (press >= 0 && elastic[e]) known[press] = drive->impact ? 0.0 : -k->stiffness[e] * k->gap[press];
        else if (press >= 0 && drive->expands) known[press] = drive->given[press];
        else if (press >= 0) rows[held++] = press;
        for (int i = 0; i < 2 && mode[e] == HELD; i++)
            if (tangents[e][i] >= 0) rows[held++] = tangents[e][i];
    }
    for (int e = 0; e < ELEMENTS; e++) {
        if (mode[e] < FORWARD) continue;
        const double most = mode[e] > SLIPS ? drive->sticking[e] : k->kinetic[e];
        bool is_held = false;
        for (int r = 0; r < held; r++) is_held = is_held || rows[r] == pressing[e];
        for (int i = 0; i < 2 && tangents[e][i] >= 0; i++) {
            const double friction = -most * heading_of(mode, e)[i];
            if (pressing[e] < 0) known[tangents[e][i]] = drive->impact ? 0.0 : friction;
            else if (is_held) share[pressing[e]][tangents[e][i]] = friction;
            else known[tangents[e][i]] = friction * known[pressing[e]];
        }
    }
    double response[NV * (ROWS + 1)], system[ROWS * ROWS], force[ROWS], size[ROWS];
    const int columns = held + 1;
    for (int i = 0; i < NV; i++) {
        double load = drive->load[i];
        for (int r = 0; r < ROWS; r++) load += k->slopes[r][i] * known[r];
        response[i * columns] = load;
        for (int c = 0; c < held; c++) {
            double sum = k->slopes[rows[c]][i];
            for (int r = 0; r < ROWS; r++) sum += share[rows[c]][r] * k->slopes[r][i];
            response[i * columns + 1 + c] = sum;
        }
    }
    by_mass(k, columns, response);
    /* rows in the metric of kinetic energy, so that pivots are comparable */
    for (int r = 0; r < held; r++) {
        double there[NV];
        memcpy(there, k->slopes[rows[r]], sizeof there);
        by_mass(k, 1, there);
        size[r] = sqrt(along(k->slopes[rows[r]], there));
        if (size[r] == 0.0) size[r] = 1.0;
    }
    double largest = 0.0;
    for (int r = 0; r < held; r++) {
        const double *slopes = k->slopes[rows[r]];
        double free = 0.0;
        for (int i = 0; i < NV; i++) free += slopes[i] * response[i * columns];
        force[r] = (drive->wanted[rows[r]] - free) / size[r];
        for (int c = 0; c < held; c++) {
            double sum = 0.0, terms = 0.0;
            for (int i = 0; i < NV; i++) {
                sum += slopes[i] * response[i * columns + 1 + c];
                terms += fabs(slopes[i] * response[i * columns + 1 + c]);
            }
            system[r * held + c] = sum / size[r] / size[c];
            largest = fmax(largest, terms / size[r] / size[c]);
        }
    }
    if (held == 1 && !(fabs(system[0]) > REDUNDANT * largest)) return false;
    if (held && eliminate(held, 1, system, force) < held) return false;
    for (int i = 0; i < NV; i++) {
        solved->a[i] = response[i * columns];
        for (int c = 0; c < held; c++)
            solved->a[i] += response[i * columns + 1 + c] * force[c] / size[c];
    }
    memcpy(solved->force, known, sizeof known);
    for (int c = 0; c < held; c++) {
        solved->force[rows[c]] += force[c] / size[c];
        for (int r = 0; r < ROWS; r++) solved->force[r] += share[rows[c]][r] * force[c] / size[c];
    }
    for (int r = 0; r < held; r++) {
        /* a coordinate that sticks does not creep, not even by rounding */
        int entries = 0, last = 0;
        for (int i = 0; i < NV; i++)
            if (k->slopes[rows[r]][i] != 0.0) entries++, last = i;
        if (entries == 1) solved->a[last] = drive->wanted[rows[r]] / k->slopes[rows[r]][last];
    }
    memcpy(solved->mode, mode, sizeof solved->mode);
    return true;
}

static Drive accelerate(const Terms *k)
{
    Drive drive = {false, false, {0.0}, {0.0}, {0.0}, {0.0}, {0.0}};
    memcpy(drive.load, k->load, sizeof drive.load);
    memcpy(drive.sticking, k->sticking, sizeof drive.sticking);
    memcpy(drive.holds, k->holds, sizeof drive.holds);
    for (int r = 0; r < ROWS; r++) drive.wanted[r] = -k->gamma[r];
    return drive;
}

/*
 * Newton's law: the rate of a gap after an impact is −e times that before, if bodies approach. By
 * Poisson's it is zero, and then the impulses of compression return, e times each.
 */
static Drive bounce(const Terms *k)
{
    Drive drive = {true, false, {0.0}, {0.0}, {0.0}, {0.0}, {0.0}};
    memcpy(drive.sticking, k->kinetic, sizeof drive.sticking);
    for (int r = 0; r < ROWS; r++) drive.wanted[r] = -k->rate[r];
    for (int e = 0; e < ELEMENTS; e++)
        if (struck[e] && !by_impulse[e])
            drive.wanted[normal[e]] -= k->restitution[e] * fmin(k->rate[normal[e]], 0.0);
    return drive;
}

static Drive expand(const Terms *k, const Solved *pressed)
{
    Drive drive = bounce(k);
    drive.expands = true;
    for (int e = 0; e < ELEMENTS; e++) {
        if (!struck[e]) continue;
        drive.wanted[normal[e]] = -k->rate[normal[e]];
        drive.given[normal[e]] = k->restitution[e] * pressed->force[normal[e]];
    }
    return drive;
}

/* Return the speed below which the rates of rows are rounding of velocities. */
static double rounding(const Terms *k, const double *v)
{
    double most = 0.0;
    for (int r = 0; r < ROWS; r++)
        most = fmax(most, within(k->slopes[r], v) + fabs(k->rate[r] - along(k->slopes[r], v)));
    return STILL * most;
}

/* Return the speed below which the rate of a row is rounding. */
static double still_speed(const Terms *k, const double *v)
{
    double free[NV], usual = 0.0;
    memcpy(free, k->load, sizeof free);
    by_mass(k, 1, free);
    for (int r = 0; r < ROWS; r++) usual = fmax(usual, within(k->slopes[r], free));
    return fmax(STILL * sqrt(LENGTH * usual), rounding(k, v)) + 1e-300;
}

/*
 * Point slip in space along that of a state: as rounding, or past its end, slip points anywhere, and
 * the mode's heading is kept. Return of which elements it is that of the state, bit by bit.
 */
static int point_slip(const Terms *k, double least, const double *mode, double *pointed)
{
    int followed = 0;
    memcpy(pointed, mode, MODE_SIZE * sizeof *mode);
    for (int e = 0; e < ELEMENTS; e++) {
        if (mode[e] != SLIPS) continue;
        const double speed = size_along(e, k->rate), ahead = part_along(e, k->rate, heading_of(mode, e));
        if (!(speed > least && ahead > SAME_WAY * speed)) continue;
        put_along(pointed, e, k->rate);
        followed |= 1 << e;
    }
    return followed;
}

/* Solve a mode with the slip of elements along angles; find what of its growth goes across. */
static bool head(const Terms *k, const Drive *drive, double *mode, const int *begin, int number,
                 const double *angles, double *across, Solved *solved)
{
    double gained[ROWS];
    for (int i = 0; i < number; i++) put_state(mode, begin[i], BEGINS, cos(angles[i]), sin(angles[i]));
    if (!solve_mode(k, drive, mode, solved)) return false;
    for (int r = 0; r < ROWS; r++) gained[r] = along(k->slopes[r], solved->a) - drive->wanted[r];
    for (int i = 0; i < number; i++) {
        const double way[2] = {-sin(angles[i]), cos(angles[i])};
        across[i] = part_along(begin[i], gained, way);
    }
    return true;
}

/* The same of one element: return what goes across, NAN if the mode has no solution. */
static double find_across(const Terms *k, const Drive *drive, double *mode, int e, double angle,
                          Solved *solved)
{
    double across;
    return head(k, drive, mode, &e, 1, &angle, &across, solved) ? across : NAN;
}

/*
 * Solve a mode in which slip begins along the heading in which it grows, between two angles where it
 * goes across by `first` and `last`; return whether there is one.
 */
static bool begin_slip(const Terms *k, const Drive *drive, double *mode, int e, double low, double high,
                       double first, double last, Solved *solved)
{
    if (!(first * last <= 0.0 && first != last)) return false;
    for (double middle = 0.5 * (low + high); low < middle && middle < high; middle = 0.5 * (low + high))
        if (find_across(k, drive, mode, e, middle, solved) * first > 0.0) low = middle;
        else high = middle;
    return !isnan(find_across(k, drive, mode, e, high, solved));
}

/* Solve a mode next to the headings of slip that begins, along its growth, by Newton's method. */
static bool solve_begun(const Terms *k, const Drive *drive, double *mode, Solved *solved)
{
    int begin[ELEMENTS], number = 0;
    double angles[ELEMENTS], missed[ELEMENTS], across[ELEMENTS], slopes[ELEMENTS * ELEMENTS];
    for (int e = 0; e < ELEMENTS; e++) {
        if (mode[e] != BEGINS) continue;
        angles[number] = atan2(heading_of(mode, e)[1], heading_of(mode, e)[0]);
        begin[number++] = e;
    }
    if (!number) return solve_mode(k, drive, mode, solved);
    for (int step = 0; step < DIRECTION_STEPS; step++) {
        double largest = 0.0;
        if (!head(k, drive, mode, begin, number, angles, missed, solved)) return false;
        for (int j = 0; j < number; j++) {
            const double angle = angles[j];
            angles[j] += SMALL_TURN;
            if (!head(k, drive, mode, begin, number, angles, across, solved)) return false;
            angles[j] = angle;
            for (int i = 0; i < number; i++) slopes[i * number + j] = (across[i] - missed[i]) / SMALL_TURN;
        }
        if (eliminate(number, 1, slopes, missed) < number) return false;
        for (int i = 0; i < number; i++) largest = fmax(largest, fabs(missed[i]));
        if (largest <= SAME_DIRECTION) return head(k, drive, mode, begin, number, angles, missed, solved);
        for (int i = 0; i < number; i++) angles[i] -= missed[i] * fmin(1.0, acos(SAME_WAY) / largest);
    }
    return false;
}

/* Find the growth of slip of elements along their tangents, and their most friction. */
static bool find_growth(const Terms *k, const Drive *drive, const double *mode, const int *begin,
                        int number, double *found)
{
    Solved solved;
    if (!solve_mode(k, drive, mode, &solved)) return false;
    for (int i = 0; i < number; i++) {
        const int e = begin[i];
        for (int j = 0; j < 2; j++) {
            const int row = tangents[e][j];
            found[2 * i + j] = along(k->slopes[row], solved.a) - drive->wanted[row];
        }
        found[2 * number + i] = k->kinetic[e] * (pressing[e] < 0 ? 1.0 : solved.force[pressing[e]]);
    }
    return true;
}

/*
 * Point elements near the headings in which they begin to slip: friction takes away as much of the
 * growth of slip as what presses allows, a fixed point of projections on disks.
 */
static bool find_start(const Terms *k, const Drive *drive, double *mode, const int *begin, int number)
{
    enum { MOST = 3 * ELEMENTS };
    double base[MOST], slopes[2 * ELEMENTS][MOST], rub[2 * ELEMENTS] = {0.0}, squares = 0.0;
    for (int i = 0; i < number; i++) put_state(mode, begin[i], SLIPS, 0.0, 0.0);
    if (!find_growth(k, drive, mode, begin, number, base)) return false;
    for (int j = 0; j < 2 * number; j++) {
        Drive pushed = *drive;
        for (int i = 0; i < NV; i++) pushed.load[i] += k->slopes[tangents[begin[j / 2]][j % 2]][i];
        if (!find_growth(k, &pushed, mode, begin, number, slopes[j])) return false;
        for (int i = 0; i < 3 * number; i++) slopes[j][i] -= base[i];
        for (int i = 0; i < 2 * number; i++) squares += slopes[j][i] * slopes[j][i];
    }
    /* steps no longer than the inverse of the largest eigenvalue, up to which projections contract */
    for (int round = 0; round < PROJECTIONS; round++) {
        double now[MOST];
        for (int i = 0; i < 3 * number; i++) {
            now[i] = base[i];
            for (int j = 0; j < 2 * number; j++) now[i] += slopes[j][i] * rub[j];
        }
        for (int i = 0; i < 2 * number; i++) rub[i] -= now[i] / sqrt(squares);
        for (int i = 0; i < number; i++) {
            const double size = hypot(rub[2 * i], rub[2 * i + 1]), most = fmax(0.0, now[2 * number + i]);
            const double part = size > most ? most / size : 1.0;
            rub[2 * i] *= part, rub[2 * i + 1] *= part;
        }
    }
    for (int i = 0; i < number; i++) put_state(mode, begin[i], BEGINS, -rub[2 * i], -rub[2 * i + 1]);
    return true;
}

/* Solve the mode of p in a state. */
static bool solve_present(const Terms *k, const Drive *drive, const double *y, const double *p,
                          Solved *solved)
{
    double pointed[MODE_SIZE];
    point_slip(k, rounding(k, y + NQ), p + MODE, pointed);
    return solve_begun(k, drive, pointed, solved);
}

static void rates(double t, const double *y, const double *p, double *out)
{
    Terms k;
    Solved solved;
    know(t, y, p, &k);
    const Drive drive = accelerate(&k);
    memcpy(out, k.first, sizeof k.first);
    const bool known = solve_present(&k, &drive, y, p, &solved);
    for (int i = 0; i < NV; i++) out[NQ + i] = known ? solved.a[i] : NAN;
}

/*
 * Find what each element has left in its state, two numbers: its gap or what presses; the reserve of
 * static friction or the speed of slip; 1 where there is none. Gaps and slips are those of the state,
 * or what the rows gain by at a corner.
 */
static void find_left(const Drive *drive, const Solved *solved, const double *gap,
                      const double *slip, double *left)
{
    for (int e = 0; e < ELEMENTS; e++) {
        const int press = normal[e];
        const double state = solved->mode[e], *force = solved->force;
        left[2 * e] = left[2 * e + 1] = 1.0;
        if (press >= 0 && (state == OPEN_ELEMENT || elastic[e])) {
            left[2 * e] = state == OPEN_ELEMENT ? gap[press] : -gap[press];
            continue;
        }
        if (press >= 0) left[2 * e] = force[press] + drive->holds[e];
        if (tangents[e][0] < 0) continue;
        if (state == HELD)
            left[2 * e + 1] = drive->sticking[e] * (pressing[e] < 0 ? 1.0 : force[pressing[e]])
                              - size_along(e, force);
        if (state >= FORWARD && state <= SLIPS)
            left[2 * e + 1] = part_along(e, slip, heading_of(solved->mode, e));
    }
}

/* Find what each element has left, more than its rounding. */
static void give_margins(double t, const double *y, const double *p, double *out)
{
    Terms k;
    Solved solved;
    double load = 0.0;
    know(t, y, p, &k);
    const Drive drive = accelerate(&k);
    if (!solve_present(&k, &drive, y, p, &solved)) {
        for (int j = 0; j < 2 * ELEMENTS; j++) out[j] = NAN;
        return;
    }
    memcpy(solved.mode, p + MODE, sizeof solved.mode);
    find_left(&drive, &solved, k.gap, k.rate, out);
    for (int i = 0; i < NV; i++) load = fmax(load, fabs(k.load[i]));
    for (int e = 0; e < ELEMENTS; e++) {
        /* what is closed opens beyond an end; what is open closes without a gap and inside */
        if (!ends[e]) continue;
        if (p[MODE + e] == OPEN_ELEMENT) out[2 * e] = fmax(out[2 * e], -k.inside[e]);
        else out[2 * e] = fmin(out[2 * e], k.inside[e] * load / LENGTH);
    }
    const double pull = DEAD * load + LEAST_MARGIN;
    for (int e = 0; e < ELEMENTS; e++) {
        if (normal[e] >= 0 && p[MODE + e] == OPEN_ELEMENT) out[2 * e] += EVEN * LENGTH;
        else if (!elastic[e]) out[2 * e] += pull;
        if (tangents[e][0] >= 0 && p[MODE + e] == HELD) out[2 * e + 1] += pull;
        /* slip in space ends, or has begun, or has turned */
        if (p[MODE + e] == BEGINS) {
            const double slow = still_speed(&k, y + NQ), speed = out[2 * e + 1];
            out[2 * e + 1] = fmin(slow + speed, BEGUN * slow - speed);
        }
        if (p[MODE + e] == SLIPS) out[2 * e + 1] -= TURNED * size_along(e, k.rate);
    }
}

/* Return whether an element is between the ends of its side; always without ends. */
static bool is_inside(const Terms *k, int e)
{
    return k->inside[e] >= -EVEN * LENGTH;
}

/* Return whether the bodies of an element are one within the other. */
static bool is_within(const Terms *k, int e)
{
    return struck[e] && k->gap[normal[e]] < -CLOSED_GAP * LENGTH;
}

static double state_of(double mode)
{
    return mode > SLIPS ? HELD : mode;
}

static void give_states(double t, const double *y, const double *p, double *out)
{
    (void)t; (void)y;
    /* in space an element slips in one state, in a plane in two */
    for (int e = 0; e < ELEMENTS; e++)
        out[e] = p[MODE + e] == SLIPS || p[MODE + e] == BEGINS ? FORWARD : state_of(p[MODE + e]);
}

/* on the rows that are held ------------------------------------------------------------------- */

/* The rows that a mode holds; return their number. */
static int list_held(const double *mode, int *rows)
{
    int held = 0;
    for (int e = 0; e < ELEMENTS; e++) {
        if (struck[e] && mode[e] != OPEN_ELEMENT) rows[held++] = normal[e];
        for (int i = 0; i < 2 && mode[e] == HELD; i++)
            if (tangents[e][i] >= 0) rows[held++] = tangents[e][i];
    }
    return held;
}

/* Find the least change, by kinetic energy, that takes away amounts along rows. */
static void take_away(const Terms *k, int held, const int *rows, const double *amounts, double *change)
{
    double response[NV * (ROWS + 1)], system[ROWS * ROWS], part[ROWS];
    for (int c = 0; c < held; c++)
        for (int i = 0; i < NV; i++) response[i * held + c] = k->slopes[rows[c]][i];
    by_mass(k, held, response);
    for (int r = 0; r < held; r++) {
        part[r] = -amounts[r];
        for (int c = 0; c < held; c++) {
            system[r * held + c] = 0.0;
            for (int i = 0; i < NV; i++)
                system[r * held + c] += k->slopes[rows[r]][i] * response[i * held + c];
        }
    }
    eliminate(held, 1, system, part);
    for (int i = 0; i < NV; i++) {
        change[i] = 0.0;
        for (int c = 0; c < held; c++) change[i] += response[i * held + c] * part[c];
    }
}

/* Bring gaps of some rows to zero. */
static void close_gaps(double t, double *y, const double *p, int held, const int *rows)
{
    for (int sweep = 0; sweep < 4; sweep++) {
        Terms k, there;
        int closed = 0, some[ROWS];
        double gaps[ROWS], way[NV], moved[N], still[N];
        know(t, y, p, &k);
        for (int r = 0; r < held; r++) {
            if (!positional[rows[r]]) continue;
            gaps[closed] = k.gap[rows[r]];
            some[closed++] = rows[r];
        }
        if (!closed) return;
        take_away(&k, closed, some, gaps, way);
        memcpy(moved, y, sizeof moved);
        memcpy(still, y, sizeof still);
        for (int i = 0; i < NV; i++) moved[NQ + i] = way[i], still[NQ + i] = 0.0;
        know(t, moved, p, &there);
        know(t, still, p, &k);
        for (int i = 0; i < NQ; i++) y[i] += there.first[i] - k.first[i];
        land(t, y, p, CLOSED);
    }
}

/* Bring a state on some rows, then their rates to zero. */
static void project(double t, double *y, const double *p, int held, const int *rows)
{
    Terms k;
    double amounts[ROWS], change[NV];
    if (!held) return;
    close_gaps(t, y, p, held, rows);
    know(t, y, p, &k);
    for (int r = 0; r < held; r++) amounts[r] = k.rate[rows[r]];
    take_away(&k, held, rows, amounts, change);
    for (int i = 0; i < NV; i++) y[NQ + i] += change[i];
}

/* which mode follows -------------------------------------------------------------------------- */

/* Return whether what a mode holds keeps a row from changing. */
static bool is_kept(const Terms *k, const double *mode, int row)
{
    int rows[ROWS];
    double pushed[NV], change[NV], amounts[ROWS];
    const int held = list_held(mode, rows);
    memcpy(pushed, k->slopes[row], sizeof pushed);
    by_mass(k, 1, pushed);
    for (int r = 0; r < held; r++) amounts[r] = along(k->slopes[rows[r]], pushed);
    take_away(k, held, rows, amounts, change);
    const double size = along(k->slopes[row], pushed);
    return size + along(k->slopes[row], change) <= REDUNDANT * size;
}

/* What the rate of each row gains by, and below what that is rounding. */
static void find_gains(const Terms *k, const Drive *drive, const double *a, double still, double *gained,
                       double *size)
{
    double free[NV], moved[NV];
    memcpy(free, drive->load, sizeof free);
    by_mass(k, 1, free);
    for (int i = 0; i < NV; i++) moved[i] = fabs(a[i]) + fabs(free[i]);
    for (int r = 0; r < ROWS; r++) {
        gained[r] = along(k->slopes[r], a) - drive->wanted[r];
        size[r] = SLACK * (within(k->slopes[r], moved) + fabs(drive->wanted[r]) + still);
    }
}

/* Return whether what a mode presupposes is so: of elements that are near and open the gap must not
 * shrink, of those whose slip begins it must grow. */
static bool is_sound(const Terms *k, const Drive *drive, const Solved *solved, const bool *near,
                     const bool *beginning, double still)
{
    double gained[ROWS], size[ROWS], left[2 * ELEMENTS];
    double pull = 0.0, load = 0.0, longest = 0.0;
    find_gains(k, drive, solved->a, still, gained, size);
    for (int i = 0; i < NV; i++) load = fmax(load, fabs(drive->load[i]));
    for (int r = 0; r < ROWS; r++) {
        pull = fmax(pull, fabs(solved->force[r]));
        for (int i = 0; i < NV; i++) longest = fmax(longest, fabs(k->slopes[r][i]));
    }
    pull = SLACK * (pull + (longest > 0.0 ? load / longest : 0.0));
    find_left(drive, solved, gained, gained, left);
    for (int e = 0; e < ELEMENTS; e++) {
        const double state = solved->mode[e];
        if (elastic[e]) continue;
        if (normal[e] >= 0 && state == OPEN_ELEMENT) {
            if (near[e] && left[2 * e] < -size[normal[e]]) return false;
            continue;
        }
        const int rub = tangents[e][0], across = rub < 0 || tangents[e][1] < 0 ? rub : tangents[e][1];
        if (state >= FORWARD && tangents[e][1] < 0 && beginning[e] && !drive->impact) {
            /* a row that is not at rest is kept nowhere, as at a dead center */
            const bool kept = fabs(gained[rub]) <= size[rub] && is_kept(k, solved->mode, rub);
            if (kept != (state > SLIPS)) return false;
        }
        const bool slips = state >= FORWARD && state <= SLIPS;
        if (slips && beginning[e] && left[2 * e + 1] < -fmax(size[rub], size[across])) return false;
        if (normal[e] >= 0 && left[2 * e] < -pull) return false;
        if (rub >= 0 && state == HELD && left[2 * e + 1] < -pull) return false;
    }
    return true;
}

/* Return whether two solutions have the same accelerations or velocities. */
static bool is_same(const double *a, const double *b, const double *free, double still)
{
    double apart = 0.0, size = 0.0, most = 0.0;
    for (int i = 0; i < NV; i++) {
        apart = fmax(apart, fabs(a[i] - b[i]));
        size = fmax(size, fmax(fabs(a[i]), fabs(b[i])));
        most = fmax(most, fabs(free[i]));
    }
    return apart <= SAME_ANSWER * (size + most) + still;
}

/* Return the least of what presses and of the reserves of static friction. */
static double find_least(const Terms *k, const Drive *drive, const Solved *solved)
{
    double left[2 * ELEMENTS], least = HUGE_VAL;
    find_left(drive, solved, k->gap, k->rate, left);
    for (int e = 0; e < ELEMENTS; e++) {
        const double state = solved->mode[e];
        if (struck[e] && state != OPEN_ELEMENT) least = fmin(least, left[2 * e]);
        if (tangents[e][0] >= 0 && state == HELD) least = fmin(least, left[2 * e + 1]);
    }
    return least;
}

/* Return whether a rival is another share of the same forces, which leaves more. */
static bool shares_better(const Terms *k, const Drive *drive, const Solved *solved, const Solved *rival)
{
    for (int e = 0; e < ELEMENTS; e++)
        if (state_of(solved->mode[e]) != state_of(rival->mode[e])) return false;
    return find_least(k, drive, rival) > find_least(k, drive, solved);
}

/* Return whether a rival leaves a mode out: what can stick sticks, and latches keep closed. */
static bool yields_to(const Terms *k, const Solved *solved, const Solved *rival)
{
    bool differs = false;
    for (int e = 0; e < ELEMENTS; e++) {
        const double state = solved->mode[e], other = rival->mode[e];
        if (state == other) continue;
        differs = true;
        const bool slips = state >= FORWARD && state <= SLIPS, rubs = tangents[e][0] >= 0;
        const bool sticks = other == HELD && rubs && slips && k->sticking[e] > k->kinetic[e];
        const bool latched = other == HELD && !rubs && k->holds[e] > 0.0;
        if (!sticks && !latched) return false;
    }
    return differs;
}

/*
 * Leave out modes in which an element sticks that has spent its static friction, bit by bit, unless
 * others take some of it; return how many are left. If there is none that goes on, all are.
 */
static int leave_spent(const Terms *k, const Drive *drive, int spent, int number, Solved *sound)
{
    double load = 0.0;
    int lasting = 0;
    for (int i = 0; i < NV; i++) load = fmax(load, fabs(k->load[i]));
    for (int i = 0; spent && i < number; i++) {
        bool goes_on = find_least(k, drive, sound + i) > SLACK * load;
        int sticking = 0;
        for (int e = 0; e < ELEMENTS; e++)
            sticking |= (tangents[e][0] >= 0 && state_of(sound[i].mode[e]) == HELD) << e;
        if (goes_on || !(sticking & spent)) {
            const Solved kept = sound[lasting];
            sound[lasting++] = sound[i];
            sound[i] = kept;
        }
    }
    return lasting ? lasting : number;
}

/*
 * Solve a mode; if an element begins to slip in space, along each heading that it goes along. Return
 * how many solutions there are.
 */
static int solve_in_space(const Terms *k, const Drive *drive, double *mode, const int *begin, int begins,
                          int most, Solved *solved)
{
    int number = 0;
    if (!begins) return most > 0 && solve_mode(k, drive, mode, solved);
    if (begins > 1)
        return most > 0 && find_start(k, drive, mode, begin, begins) && solve_begun(k, drive, mode, solved);
    double low = 0.01, first = find_across(k, drive, mode, *begin, low, solved);
    for (int i = 0; i < ANGLES && number < most; i++) {
        const double high = 0.01 + (i + 1) * 8.0 * atan(1.0) / ANGLES;
        const double last = find_across(k, drive, mode, *begin, high, solved + number);
        number += begin_slip(k, drive, mode, *begin, low, high, first, last, solved + number);
        low = high, first = last;
    }
    return number;
}

/*
 * Find every mode of the states allowed of each element, bit by bit, whose conditions are met; return
 * how many have different solutions, −1 if several may begin to slip in space at once along headings
 * that were not found. These are only looked for if there is no other mode.
 */
static int solve_all(const Terms *k, const Drive *drive, const int *allowed, const bool *near,
                     const bool *beginning, int spent, double still, Solved *kept)
{
    Solved sound[MOST_FOLLOWING];
    double mode[MODE_SIZE], free[NV];
    int number = 0, count = 0;
    long modes = 1;
    bool several = false;
    for (int e = 0; e < ELEMENTS; e++) modes *= CHOICES;
    for (long code = 0; code < 2 * modes; code++) {
        const bool together = code >= modes;
        if (together && (number || !several)) break;
        bool tried = true;
        int begin[ELEMENTS], begins = 0;
        long rest = code % modes;
        for (int e = 0; e < ELEMENTS && tried; e++, rest /= CHOICES) {
            const int state = (int)(rest % CHOICES);
            tried = allowed[e] >> state & 1;
            put_in_plane(mode, e, state);
            if (!tried || state != SLIPS) continue;
            if (beginning[e]) begin[begins++] = e;
            else put_along(mode, e, k->rate);
        }
        if (!tried) continue;
        several |= begins > 1;
        if ((begins > 1) != together) continue;
        const int most = MOST_FOLLOWING - number;
        const int solved = solve_in_space(k, drive, mode, begin, begins, most, sound + number);
        for (int i = 0, first = number; i < solved; i++)
            if (is_sound(k, drive, sound + first + i, near, beginning, still))
                sound[number++] = sound[first + i];
    }
    if (several && !number) return -1;
    number = leave_spent(k, drive, spent, number, sound);
    memcpy(free, drive->load, sizeof free);
    by_mass(k, 1, free);
    for (int i = 0; i < number; i++) {
        bool wanted = true;
        for (int j = 0; j < number && !drive->impact; j++)
            wanted = wanted && !(j != i && yields_to(k, sound + i, sound + j));
        for (int j = 0; j < count && wanted; j++) {
            if (!is_same(sound[i].a, kept[j].a, free, drive->impact ? still : 0.0)) continue;
            if (shares_better(k, drive, kept + j, sound + i)) kept[j] = sound[i];
            wanted = false;
        }
        if (wanted) kept[count++] = sound[i];
    }
    return count;
}

static int candidates(const Terms *k, int e, bool touches, double still)
{
    const int press = normal[e];
    if (elastic[e]) {
        const bool inside = touches && (k->gap[press] < 0.0 || k->rate[press] < 0.0);
        return 1 << (inside ? HELD : OPEN_ELEMENT);
    }
    if (press >= 0 && (!touches || k->rate[press] > still)) return 1 << OPEN_ELEMENT;
    const int apart = press >= 0 ? 1 << OPEN_ELEMENT : 0;
    if (tangents[e][0] < 0) return apart | 1 << HELD;
    const bool moves = size_along(e, k->rate) > still;
    if (tangents[e][1] >= 0) return apart | 1 << SLIPS | (moves ? 0 : 1 << HELD);
    if (moves) return apart | 1 << (k->rate[tangents[e][0]] > 0.0 ? FORWARD : BACKWARD);
    return apart | ((1 << CHOICES) - (1 << HELD) - (1 << BEGINS) - (1 << SLIPS));
}

static bool is_touching(const Terms *k, int e, double state)
{
    if (!struck[e]) return state != OPEN_ELEMENT && normal[e] >= 0;
    return state != OPEN_ELEMENT || (k->gap[normal[e]] <= CLOSED_GAP * LENGTH && is_inside(k, e));
}

/* Strike an element by itself; return whether there is a solution. */
static int strike_alone(double t, double *y, const double *p, int e)
{
    Terms k;
    double out[NV + ROWS];
    know(t, y, p, &k);
    collide[e](t, y, p, out);
    const double before = k.rate[normal[e]], after = before + along(k.slopes[normal[e]], out);
    /* friction jams what should part by Newton's law */
    if (!by_impulse[e] && after < (SAME_ANSWER - k.restitution[e]) * before) return 0;
    for (int i = 0; i < NV; i++) y[NQ + i] += out[i];
    return 1;
}

/*
 * Strike contacts together; return how many solutions there are, none also where the bodies still
 * approach after Poisson's expansion or contacts have both laws.
 */
static int strike(double t, double *y, const double *p, const bool *near, double still)
{
    int allowed[ELEMENTS], numbers[2] = {0, 0}, last = 0;
    for (int e = 0; e < ELEMENTS; e++) {
        allowed[e] = 1 << OPEN_ELEMENT;
        if (near[e]) allowed[e] |= 1 << HELD, numbers[by_impulse[e]]++, last = e;
        if (near[e] && tangents[e][0] >= 0)
            allowed[e] |= tangents[e][1] < 0 ? 1 << FORWARD | 1 << BACKWARD : 1 << SLIPS;
    }
    if (numbers[0] + numbers[1] == 1 && collide[last]) return strike_alone(t, y, p, last);
    if (numbers[0] && numbers[1]) return 0;
    Solved kept[MOST_FOLLOWING];
    for (int phase = 0; phase < (numbers[1] ? 2 : 1); phase++) {
        Terms k;
        know(t, y, p, &k);
        for (int e = 0; phase && e < ELEMENTS; e++)
            if (near[e]) allowed[e] -= 1 << OPEN_ELEMENT;
        const Drive drive = phase ? expand(&k, kept) : bounce(&k);
        const int count = solve_all(&k, &drive, allowed, near, near, 0, still, kept);
        if (count != 1) return count;
        for (int i = 0; i < NV; i++) y[NQ + i] += kept[0].a[i];
        for (int e = 0; phase && e < ELEMENTS; e++) {
            const double *slopes = k.slopes[normal[e] < 0 ? 0 : normal[e]];
            const double size = within(slopes, kept[0].a) + fabs(k.rate[normal[e] < 0 ? 0 : normal[e]]);
            if (near[e] && k.rate[normal[e]] + along(slopes, kept[0].a) < -SLACK * size - still) return 0;
        }
    }
    return 1;
}

/* Strike the contacts that touch, together or in turn; return how many solutions there are. */
static int impact(double t, double *y, const double *p, const bool *touching, double still)
{
    bool turns = false;
    for (int e = 0; e < ELEMENTS; e++) turns = turns || (touching[e] && struck[e] && in_turn[e]);
    for (int round = 0; round < MOST_IN_TURN; round++) {
        Terms k;
        bool near[ELEMENTS];
        int fastest = -1;
        know(t, y, p, &k);
        for (int e = 0; e < ELEMENTS; e++)
            if (touching[e] && struck[e]
                && (fastest < 0 || k.rate[normal[e]] < k.rate[normal[fastest]]))
                fastest = e;
        if (fastest < 0 || k.rate[normal[fastest]] >= -still) return 1;
        for (int e = 0; e < ELEMENTS; e++) near[e] = turns ? e == fastest : touching[e] && struck[e];
        const int count = strike(t, y, p, near, still);
        if (count != 1 || !turns) return count;
    }
    return 0;
}

/* Find the modes that follow in a state; return how many there are. */
static int find_next(const Terms *k, const bool *touching, const int *forbidden, int spent,
                     double still, Solved *kept)
{
    bool near[ELEMENTS], beginning[ELEMENTS];
    int allowed[ELEMENTS];
    for (int e = 0; e < ELEMENTS; e++) {
        const int press = normal[e];
        allowed[e] = candidates(k, e, touching[e], still) & ~forbidden[e];
        near[e] = touching[e] && struck[e] && k->rate[press] <= still;
        beginning[e] = size_along(e, k->rate) <= still;
    }
    const Drive drive = accelerate(k);
    return solve_all(k, &drive, allowed, near, beginning, spent, 0.0, kept);
}

/* Find what follows; what has begun to slip, bit by bit, sticks only where nothing else does. */
static int find_following(const Terms *k, int begun, const bool *touching, const int *forbidden, int spent,
                          double still, Solved *kept)
{
    int ends[ELEMENTS];
    for (int e = 0; e < ELEMENTS; e++) ends[e] = forbidden[e] | (begun >> e & 1) << HELD;
    const int count = begun ? find_next(k, touching, ends, spent, still, kept) : 0;
    return count ? count : find_next(k, touching, forbidden, spent, still, kept);
}

/*
 * What began to slip just now and goes on, bit by bit: where several begin at once by symmetry, one and
 * another would stick in turn without end.
 */
static int list_begun(const Terms *k, const double *y, const double *p)
{
    Solved solved;
    int begun = 0;
    double growth[ROWS], size[ROWS];
    const double still = still_speed(k, y + NQ);
    const Drive drive = accelerate(k);
    if (!solve_present(k, &drive, y, p, &solved)) return 0;
    find_gains(k, &drive, solved.a, 0.0, growth, size);
    for (int e = 0; e < ELEMENTS; e++) {
        if (!(solved.mode[e] >= FORWARD && solved.mode[e] <= SLIPS)) continue;
        const bool grows = part_along(e, growth, heading_of(solved.mode, e)) >= -size_along(e, size);
        if (grows && size_along(e, k->rate) <= still) begun |= 1 << e;
    }
    return begun;
}

/*
 * Take away the rates of contacts whose bounces are over, those left staying below `lowest`, while
 * what follows holds together; return whether there are any. All bounces left out press as much as
 * what rests meanwhile, less the impulse that ends them now: that takes its friction along.
 */
static bool rest(double t, double *y, const double *p, const bool *touching, const int *forbidden,
                 int spent, double still, double lowest, Solved *next)
{
    Terms k, ended;
    Solved solved;
    double change[NV], amounts[ROWS], after[N];
    int rows[ROWS], held = list_held(next->mode, rows);
    const int kept = held;
    know(t, y, p, &k);
    for (int e = 0; e < ELEMENTS; e++) {
        if (!touching[e] || !struck[e]) continue;
        const double speed = k.rate[normal[e]];
        const double fall = -along(k.slopes[normal[e]], next->a) - k.gamma[normal[e]];
        if (!(k.restitution[e] < 1.0 && speed > still && fall > 0.0)) continue;
        if (speed * speed / (2.0 * fall) <= lowest) rows[held++] = normal[e];
    }
    if (held == kept) return false;
    for (int r = 0; r < held; r++) amounts[r] = k.rate[rows[r]];
    take_away(&k, held, rows, amounts, change);
    memcpy(after, y, sizeof after);
    for (int i = 0; i < NV; i++) after[NQ + i] += change[i];
    know(t, after, p, &ended);
    const Drive drive = bounce(&k);
    const bool follows = find_next(&ended, touching, forbidden, spent, still, next) == 1;
    if (follows && solve_mode(&k, &drive, next->mode, &solved)) memcpy(change, solved.a, sizeof change);
    for (int i = 0; i < NV; i++) y[NQ + i] += change[i];
    return true;
}

/* Say how many velocities or modes follow, if it is not one; return whether it is. */
static bool is_decided(int count, const char *what, double t, char *words)
{
    if (count < 0)
        snprintf(words, SENTENCE, "no mode follows at t = %.9g s whose forces rigid bodies determine, and "
                 "no directions were found in which contacts begin to slip in space at once", t);
    else if (count != 1)
        snprintf(words, SENTENCE, what, count, t);
    return count == 1;
}

/*
 * Resolve impacts, then choose the mode that follows; return whether there is one, and say why not.
 * `forbidden` has the states of each element that end here, bit by bit; `spent`
 * those whose static friction is spent, `begun` those whose slip has begun; `early` is the tolerance by
 * which an importing tool found the corner, zero if it is found here.
 */
static bool change(double t, double *y, double *p, bool *touching, const int *forbidden, int spent,
                   int begun, double early, char *words)
{
    Terms k;
    Solved kept[MOST_FOLLOWING];
    const int none[ELEMENTS] = {0};
    const double lowest = fmax(TAIL, early) * LENGTH;
    bool strikes = false;
    int rows[ROWS], met = 0;
    know(t, y, p, &k);
    double still = still_speed(&k, y + NQ);
    for (int e = 0; e < ELEMENTS; e++)
        if (touching[e] && struck[e] && k.rate[normal[e]] < -still) rows[met++] = normal[e], strikes = true;
    if (strikes) {
        double before[NV];
        /* an importing tool finds the corner by its own tolerance, a little late */
        close_gaps(t, y, p, met, rows);
        memcpy(before, y + NQ, sizeof before);
        const int count = impact(t, y, p, touching, still);
        if (!is_decided(count, "%d velocities follow after an impact at t = %.9g s, where one is "
                        "expected", t, words))
            return false;
        for (int i = 0; i < NV; i++) before[i] = fmax(fabs(before[i]), fabs(y[NQ + i]));
        know(t, y, p, &k);
        still = still_speed(&k, before);
    }
    int count = find_following(&k, begun, touching, forbidden, spent, still, kept);
    if (strikes && count == 1
        && rest(t, y, p, touching, forbidden, spent, still, lowest, kept)) {
        know(t, y, p, &k);
        count = find_following(&k, begun, touching, forbidden, spent, still, kept);
    }
    /* an importing tool finds the corner a little early as well: the mode goes on for now */
    if (count == 0 && early > 0.0) count = find_next(&k, touching, none, 0, still, kept);
    if (!is_decided(count, "%d modes that rigid bodies determine follow at t = %.9g s, where one is "
                    "expected (Painleve)", t, words))
        return false;
    /* where another element switches meanwhile, slip that begins still does */
    for (int e = 0; e < ELEMENTS; e++) {
        const bool slow = size_along(e, k.rate) < 0.5 * BEGUN * still;
        if (slow && kept[0].mode[e] == SLIPS && p[MODE + e] == BEGINS) kept[0].mode[e] = BEGINS;
    }
    memcpy(p + MODE, kept[0].mode, sizeof kept[0].mode);
    project(t, y, p, list_held(p + MODE, rows), rows);
    return true;
}

static bool begin(double t, double *y, double *p, double early, char *words)
{
    Terms k;
    bool touching[ELEMENTS];
    const int none[ELEMENTS] = {0};
    know(t, y, p, &k);
    for (int e = 0; e < ELEMENTS; e++) {
        if (is_within(&k, e) && is_inside(&k, e)) {
            snprintf(words, SENTENCE, "%s starts with its bodies one within the other, by %.3g",
                     name[e], -k.gap[normal[e]]);
            return false;
        }
        touching[e] = elastic[e] ? k.gap[normal[e]] < 0.0 : is_touching(&k, e, OPEN_ELEMENT);
        put_in_plane(p + MODE, e, normal[e] >= 0 ? OPEN_ELEMENT : HELD);
    }
    return change(t, y, p, touching, none, 0, 0, early, words);
}

/* Return the speed of slip that an importing tool leaves, which finds its end by its own tolerance. */
static double late_speed(const Terms *k, const double *y, double early)
{
    return still_speed(k, y + NQ) * fmax(1.0, early / STILL);
}

/* Switch where margin j of a state has passed zero. */
static bool switch_at(double t, double *y, double *p, int j, double early, char *words)
{
    Terms k;
    const int e = j / 2, which = j % 2;
    const double state = p[MODE + e];
    bool touching[ELEMENTS];
    int forbidden[ELEMENTS] = {0}, rows[ROWS];
    know(t, y, p, &k);
    for (int i = 0; i < ELEMENTS; i++) touching[i] = is_touching(&k, i, p[MODE + i]);
    const int begun = list_begun(&k, y, p);
    if (which == 1 && state != HELD) {
        double mode[MODE_SIZE], least = late_speed(&k, y, early);
        if (state == BEGINS) {
            p[MODE + e] = SLIPS;
            least = 0.5 * BEGUN * still_speed(&k, y + NQ);
        }
        const int followed = point_slip(&k, least, p + MODE, mode);
        if (followed >> e & 1) {
            /* slip in space that has begun, or goes on in another direction, is followed from there */
            memcpy(p + MODE, mode, sizeof mode);
            return true;
        }
        /* the slip, which is zero to rounding, is zero */
        mode[e] = HELD;
        project(t, y, p, list_held(mode, rows), rows);
    }
    /* as it passes an end, not as it meets the side */
    const bool beside = ends[e] && is_within(&k, e) && k.inside[e] < -k.gap[normal[e]];
    if (which == 0 && state == OPEN_ELEMENT && beside) {
        snprintf(words, SENTENCE, "%s comes in from beyond an end of its side, below it, at t = %.9g s",
                 name[e], t);
        return false;
    }
    if (which == 0) touching[e] = state == OPEN_ELEMENT || (struck[e] && is_inside(&k, e));
    int spent = which == 1 && state == HELD ? 1 << e : 0;
    if (spent) forbidden[e] = 1 << HELD;
    if (which == 0 && state != OPEN_ELEMENT && touching[e]) {
        for (int i = 0; i < ELEMENTS; i++)
            if (p[MODE + i] > SLIPS) spent |= 1 << i, forbidden[i] = 1 << (int)p[MODE + i];
        if (!spent) forbidden[e] = ~(1 << OPEN_ELEMENT);
    }
    return change(t, y, p, touching, forbidden, spent, begun & ~(1 << e), early, words);
}

/* in co-simulation ---------------------------------------------------------------------------- */

enum { LOOKS = 4, HALVINGS = 60, CORNER = 100 };

/* The state at a time within a step from y. */
static void follow(double from, const double *y, const double *p, double t, double *out)
{
    double k[STAGES][N], last[N];
    if (t == from) {
        memcpy(out, y, N * sizeof *out);
        return;
    }
    rates(from, y, p, k[0]);
    step(from, y, p, t - from, k, last, out, 0);
    land(t, out, p, CLOSED);
}

static double margin_at(double from, const double *y, const double *p, double t, int j)
{
    double state[N], left[2 * ELEMENTS];
    follow(from, y, p, t, state);
    give_margins(t, state, p, left);
    return left[j];
}

/*
 * Find the first corner within a step from y; return the margin that passes zero there, or −1. Just
 * after a corner a margin may be zero to rounding: when it passes zero is found from where it has left.
 */
static int find_corner(double from, double to, const double *y, const double *p, double *before,
                       double *when)
{
    double low = from;
    for (int look = 1; look <= LOOKS; look++) {
        const double high = look == LOOKS ? to : from + (to - from) * look / LOOKS;
        double state[N], left[2 * ELEMENTS];
        int first = -1;
        follow(from, y, p, high, state);
        give_margins(high, state, p, left);
        for (int j = 0; j < 2 * ELEMENTS; j++) {
            if (!(left[j] < 0.0)) continue;
            double begun = low, width = high - low;
            bool leaves = before[j] > 0.0;
            for (int s = 0; s < HALVINGS && !leaves; s++) {
                width *= 0.5;
                begun = low + width;
                leaves = margin_at(from, y, p, begun, j) > 0.0;
            }
            /* friction that does not leave zero passes it at once, as where two begin to slip together */
            if (!leaves && j % 2 == 0) continue;
            double inside = leaves ? begun : low, outside = leaves ? high : low;
            for (int s = 0; s < HALVINGS; s++) {
                const double middle = 0.5 * (inside + outside);
                if (middle <= inside || middle >= outside) break;
                if (margin_at(from, y, p, middle, j) < 0.0) outside = middle;
                else inside = middle;
            }
            if (first < 0 || outside < *when) *when = outside, first = j;
        }
        if (first >= 0) return first;
        memcpy(before, left, sizeof left);
        low = high;
    }
    return -1;
}

/* As march, from corner to corner; CORNER if no mode follows at one, and why. */
static int march_on(Motion *m, double *p, double *y, char *words)
{
    Notes none = {0, 0, NULL, NULL, NULL};
    Samples samples = {0, 0, NULL, NULL};
    double before[2 * ELEMENTS], start[N], passed = NAN;
    int rows[ROWS], at_once = 0, reason = END;
    for (int j = 0; j < 2 * ELEMENTS; j++) {
        /* inputs may have jumped */
        give_margins(m->t, y, p, before);
        if (before[j] < 0.0 && !switch_at(m->t, y, p, j, 0.0, words)) return CORNER;
    }
    give_margins(m->t, y, p, before);
    while (m->t < m->end) {
        const double from = m->t;
        memcpy(start, y, sizeof start);
        m->most = m->steps + 1;
        m->at_limit = 0;        /* stiff motions are also computed correctly, though slowly */
        reason = march(m, p, y, &none, &samples);
        if (reason != END && reason != MANY && reason != STIFF) return reason;
        double when = m->t;
        const int j = find_corner(from, m->t, start, p, before, &when);
        if (j < 0) {
            project(m->t, y, p, list_held(p + MODE, rows), rows);
            continue;
        }
        follow(from, start, p, when, y);
        at_once = when == passed ? at_once + 1 : 0;
        passed = when;
        m->t = when;
        m->h = 0.0;
        if (at_once > MOST_AT_ONCE) {
            snprintf(words, SENTENCE, "%s switches without end at t = %.9g s", name[j / 2], when);
            return CORNER;
        }
        if (!switch_at(when, y, p, j, 0.0, words)) return CORNER;
        give_margins(m->t, y, p, before);
    }
    return END;
}

/* Return how far a state has strayed from the rows that are held, in characteristic lengths. */
static double creep(double t, const double *y, const double *p)
{
    Terms k;
    int rows[ROWS];
    double worst = 0.0;
    know(t, y, p, &k);
    const int held = list_held(p + MODE, rows);
    for (int r = 0; r < held; r++) {
        worst = fmax(worst, fabs(k.rate[rows[r]]) / LENGTH);
        if (positional[rows[r]]) worst = fmax(worst, fabs(k.gap[rows[r]]) / LENGTH);
    }
    return worst;
}

/* for tests: a mode's accelerations and forces, or the velocities after an impact and impulses --- */

/* Strike an element in a known mode: the changes of velocities and the impulses. */
static bool strike_in(double t, const double *y, const double *p, const double *mode, int e, double *out)
{
    double after[N];
    Solved solved;
    memcpy(after, y, sizeof after);
    memset(out, 0, (NV + ROWS) * sizeof *out);
    for (int phase = 0; phase < (by_impulse[e] ? 2 : 1); phase++) {
        Terms k;
        know(t, after, p, &k);
        Drive drive = phase ? expand(&k, &solved) : bounce(&k);
        if (!by_impulse[e]) drive.wanted[normal[e]] = -(1.0 + k.restitution[e]) * k.rate[normal[e]];
        if (!solve_mode(&k, &drive, mode, &solved)) return false;
        for (int i = 0; i < NV; i++) out[i] += solved.a[i], after[NQ + i] += solved.a[i];
        for (int r = 0; r < ROWS; r++) out[NV + r] += solved.force[r];
    }
    return true;
}

#ifdef _WIN32
__declspec(dllexport)
#else
__attribute__((visibility("default")))
#endif
int mecanique_mode(double t, const double *y, const double *p, const double *states, int strikes,
                   double *out)
{
    Terms k;
    Solved solved;
    double mode[MODE_SIZE];
    know(t, y, p, &k);
    const Drive drive = accelerate(&k);
    for (int e = 0; e < ELEMENTS; e++) {
        put_in_plane(mode, e, (int)states[e]);
        if (states[e] == FORWARD && tangents[e][1] >= 0) put_along(mode, e, k.rate);
    }
    for (int e = 0; strikes && e < ELEMENTS; e++) {
        if (mode[e] == OPEN_ELEMENT) continue;
        if (collide[e]) collide[e](t, y, p, out);
        else if (!strike_in(t, y, p, mode, e, out)) return 0;
        for (int i = 0; i < NV; i++) out[i] += y[NQ + i];
        return 1;
    }
    if (!solve_mode(&k, &drive, mode, &solved)) return 0;
    memcpy(out, solved.a, sizeof solved.a);
    memcpy(out + NV, solved.force, sizeof solved.force);
    return 1;
}
