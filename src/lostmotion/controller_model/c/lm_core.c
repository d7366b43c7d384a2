/* See lm_core.h. Notation: `turn` is a rotation matrix row by row, `point` an origin, both of a place in the axes of the base. */
#include "lm_core.h"
#include "lm_tables.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

#ifdef LM_FLOAT
#define LM_SIN sinf
#define LM_COS cosf
#define LM_SQRT sqrtf
#define LM_FABS fabsf
#define LM_POW powf
#define LM_ATAN2 atan2f
#define LM_ACOS acosf
#define LM_LOG logf
#define LM_EXP expf
#define LM_MAX FLT_MAX
#define LM_ROUNDING ((lm_real)1e-5) /* a load below this share of the whole wrench is rounding */
#define LM_LEAST ((lm_real)1e-18)   /* smaller loads have no direction */
#define LM_FARTHEST ((lm_real)8) /* standard deviations: the share of robots beyond is rounding */
#define LM_AGREES ((lm_real)1e-4)
#define LM_UNCUT ((lm_real)1e-6) /* a command beyond a joint limit by less (rad or m) is not cut */
#define LM_AFAR ((lm_real)1e-6) /* a motion of the tool by a smaller share of the reach is rounding */
#else
#define LM_SIN sin
#define LM_COS cos
#define LM_SQRT sqrt
#define LM_FABS fabs
#define LM_POW pow
#define LM_ATAN2 atan2
#define LM_ACOS acos
#define LM_LOG log
#define LM_EXP exp
#define LM_MAX DBL_MAX
#define LM_ROUNDING ((lm_real)1e-9)
#define LM_LEAST ((lm_real)1e-140)
#define LM_FARTHEST ((lm_real)12)
#define LM_AGREES ((lm_real)1e-9)
#define LM_UNCUT ((lm_real)1e-12)
#define LM_AFAR ((lm_real)1e-12)
#endif

#define LM_ZERO ((lm_real)0)
/* A larger share of robots is all of them. */
#define LM_ALL ((lm_real)0.999999)
#define LM_ONE ((lm_real)1)
/* Least damping of the inverse, m^2; length that turns a rotation into a displacement, m. */
#define LM_LEAST_DAMPING ((lm_real)1e-8)
#define LM_ROTATION_LENGTH ((lm_real)0.1)
/* A change of the command is sent whole where the share of it that makes the error smallest is at least the inverse, as at regular poses. */
#define LM_NEAR_BEST ((lm_real)1.25)
/* A pose whose position Jacobian has a smaller singular value (m) is near a singular one: elsewhere a step is as large as the bending that it
 * corrects, and has no limit. */
#define LM_REGULAR ((lm_real)0.1)
/* A command is sent that leaves at most this share of the squared error: both are computed to less. */
#define LM_WORTH ((lm_real)0.98)
/* Motions of the tool that are rounding, m. */
#define LM_UNSEEN (LM_AFAR * lm_valid.reach)

static const lm_output lm_no_output = {0};
static const lm_command lm_no_command = {0};

/* Frames of all places, and the wrench on each of them from everything outboard, about its origin in the axes of the base. */
typedef struct {
    lm_real turn[LM_PLACES][9];
    lm_real point[LM_PLACES][3];
    lm_real moment[LM_PLACES][3];
    lm_real force[LM_PLACES][3];
} lm_state;

static lm_real lm_least_of(lm_real a, lm_real b)
{
    return (a < b) ? a : b;
}

static lm_real lm_largest_of(lm_real a, lm_real b)
{
    return (a > b) ? a : b;
}

static lm_real lm_clip(lm_real value, lm_real low, lm_real high)
{
    return lm_least_of(lm_largest_of(value, low), high);
}

static lm_real lm_dot(const lm_real a[], const lm_real b[], int count)
{
    lm_real sum = LM_ZERO;
    int k;
    for (k = 0; k < count; k++) {
        sum += a[k] * b[k];
    }
    return sum;
}

static lm_real lm_dot3(const lm_real a[3], const lm_real b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* sum += a x b */
static void lm_add_cross(const lm_real a[3], const lm_real b[3], lm_real sum[3])
{
    sum[0] += a[1] * b[2] - a[2] * b[1];
    sum[1] += a[2] * b[0] - a[0] * b[2];
    sum[2] += a[0] * b[1] - a[1] * b[0];
}

static int lm_finite(const lm_real values[], int count)
{
    int good = 1;
    int k;
    for (k = 0; k < count; k++) {
        /* false for what is not a number */
        good = ((values[k] >= -LM_MAX) && (values[k] <= LM_MAX)) ? good : 0;
    }
    return good;
}

static int lm_within(const lm_real values[], int count, lm_real low, lm_real high)
{
    int good = 1;
    int k;
    for (k = 0; k < count; k++) {
        good = ((values[k] >= low) && (values[k] <= high)) ? good : 0;
    }
    return good;
}

static int lm_check(const lm_input *input)
{
    int finite = lm_finite(input->q, LM_JOINTS) & lm_finite(input->load, 10) & lm_finite(input->gravity, 3);
    int range = 1;
    int load;
    int status;
    int k;
    finite &= lm_within(input->side, LM_JOINTS, -LM_ONE, LM_ONE);
    for (k = 0; k < LM_JOINTS; k++) {
        range &= lm_within(&input->q[k], 1, lm_limits[2 * k], lm_limits[2 * k + 1]);
    }
    load = lm_within(&input->load[0], 1, LM_ZERO, lm_valid.payload);
    load &= lm_within(&input->load[1], 3, -lm_valid.reach, lm_valid.reach);
    load &= lm_within(&input->load[4], 3, -lm_valid.force, lm_valid.force);
    load &= lm_within(&input->load[7], 3, -lm_valid.moment, lm_valid.moment);
    load &= lm_within(input->gravity, 3, -lm_valid.gravity, lm_valid.gravity);
    if (finite == 0) {
        status = LM_INPUT;
    } else if (range == 0) {
        status = LM_RANGE;
    } else if (load == 0) {
        status = LM_LOAD;
    } else {
        status = LM_OK;
    }
    return status;
}

/* Displace a frame by a twist in its own axes: the exponential of the twist, by series that are exact to rounding below a radian. */
static void lm_displace_frame(const lm_real twist[6], lm_real turn[9], lm_real point[3])
{
    /* 1/1!, 1/3!, .. and 1/2!, 1/4!, .. with alternating signs, from the last term to the first */
    static const lm_real odd[8] = {
        (lm_real)-7.647163731819816e-13, (lm_real)1.6059043836821613e-10, (lm_real)-2.505210838544172e-08, (lm_real)2.7557319223985893e-06,
        (lm_real)-0.0001984126984126984, (lm_real)0.008333333333333333, (lm_real)-0.16666666666666666, (lm_real)1.0};
    static const lm_real even[8] = {
        (lm_real)-4.779477332387385e-14, (lm_real)1.1470745597729725e-11, (lm_real)-2.08767569878681e-09, (lm_real)2.755731922398589e-07,
        (lm_real)-2.48015873015873e-05, (lm_real)0.001388888888888889, (lm_real)-0.041666666666666664, (lm_real)0.5};
    const lm_real square = lm_dot3(twist, twist);
    lm_real sine = LM_ZERO;   /* sin t / t */
    lm_real cosine = LM_ZERO; /* (1 - cos t) / t^2 */
    lm_real rest = LM_ZERO;   /* (t - sin t) / t^3 */
    const lm_real x = twist[0];
    const lm_real y = twist[1];
    const lm_real z = twist[2];
    lm_real spin[9];
    lm_real once[3];
    lm_real moved[3];
    int k;
    for (k = 0; k < 8; k++) {
        sine = sine * square + odd[k];
        cosine = cosine * square + even[k];
        rest = (k < 7) ? rest * square - odd[k] : rest;
    }
    once[0] = y * twist[5] - z * twist[4];
    once[1] = z * twist[3] - x * twist[5];
    once[2] = x * twist[4] - y * twist[3];
    moved[0] = twist[3] + cosine * once[0] + rest * (y * once[2] - z * once[1]);
    moved[1] = twist[4] + cosine * once[1] + rest * (z * once[0] - x * once[2]);
    moved[2] = twist[5] + cosine * once[2] + rest * (x * once[1] - y * once[0]);
    spin[0] = -cosine * (y * y + z * z);
    spin[1] = cosine * x * y - sine * z;
    spin[2] = cosine * x * z + sine * y;
    spin[3] = cosine * x * y + sine * z;
    spin[4] = -cosine * (x * x + z * z);
    spin[5] = cosine * y * z - sine * x;
    spin[6] = cosine * x * z - sine * y;
    spin[7] = cosine * y * z + sine * x;
    spin[8] = -cosine * (x * x + y * y);
    for (k = 0; k < 3; k++) {
        lm_real *row = &turn[3 * k];
        const lm_real a = row[0];
        const lm_real b = row[1];
        const lm_real c = row[2];
        point[k] += a * moved[0] + b * moved[1] + c * moved[2];
        row[0] += a * spin[0] + b * spin[3] + c * spin[6];
        row[1] += a * spin[1] + b * spin[4] + c * spin[7];
        row[2] += a * spin[2] + b * spin[5] + c * spin[8];
    }
}

/* Frames of all places: each is fixed to its parent, turns about or slides along its z axis, and is displaced by its twist; NULL: none. */
static void lm_frames(const lm_real q[], const lm_real twists[LM_PLACES][6], lm_state *state)
{
    int k;
    int i;
    for (i = 0; i < 9; i++) {
        state->turn[0][i] = lm_places[0].rotation[i];
    }
    for (i = 0; i < 3; i++) {
        state->point[0][i] = lm_places[0].offset[i];
    }
    for (k = 0; k < LM_PLACES; k++) {
        const lm_place *place = &lm_places[k];
        lm_real *turn = state->turn[k];
        lm_real *point = state->point[k];
        for (i = 0; (i < 3) && (k > 0); i++) {
            const lm_real *row = &state->turn[place->parent][3 * i];
            turn[3 * i] = row[0] * place->rotation[0] + row[1] * place->rotation[3] + row[2] * place->rotation[6];
            turn[3 * i + 1] = row[0] * place->rotation[1] + row[1] * place->rotation[4] + row[2] * place->rotation[7];
            turn[3 * i + 2] = row[0] * place->rotation[2] + row[1] * place->rotation[5] + row[2] * place->rotation[8];
            point[i] = state->point[place->parent][i] + lm_dot3(row, place->offset);
        }
        if (place->joint >= 0) {
            const lm_real value = q[place->joint];
            if (place->axis == 5) {
                for (i = 0; i < 3; i++) {
                    point[i] += turn[3 * i + 2] * value;
                }
            } else {
                const lm_real cosine = LM_COS(value);
                const lm_real sine = LM_SIN(value);
                for (i = 0; i < 3; i++) {
                    const lm_real x = turn[3 * i];
                    const lm_real y = turn[3 * i + 1];
                    turn[3 * i] = cosine * x + sine * y;
                    turn[3 * i + 1] = cosine * y - sine * x;
                }
            }
        }
        if ((twists != NULL) && (place->errs != 0)) {
            lm_displace_frame(twists[k], turn, point);
        }
    }
}

static lm_real lm_sign(lm_real value)
{
    return (value > LM_ZERO) ? LM_ONE : ((value < LM_ZERO) ? -LM_ONE : LM_ZERO);
}

static lm_real lm_dot6(const lm_real a[6], const lm_real b[6])
{
    return (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + (a[3] * b[3] + a[4] * b[4] + a[5] * b[5]);
}

static lm_real lm_pieces_at(lm_real at, lm_real base, int first, int count)
{
    lm_real sum = base;
    int k;
    for (k = first; k < first + count; k++) {
        sum += lm_pieces[k].slope * lm_clip(at - lm_pieces[k].start, LM_ZERO, lm_pieces[k].width);
    }
    return sum;
}

#if LM_SEATS > 0
/* Share of a standard normal law above x >= 0, in the same time for every x, unlike erfc: exp(-x^2/2) times a rational function that was fitted
 * for the smallest relative error, 7e-15 up to x = 12. */
static lm_real lm_tail(lm_real x)
{
    static const lm_real above[8] = {
        (lm_real)2.9031124030944885e-05, (lm_real)0.0006061198578455047, (lm_real)0.006034220035795207, (lm_real)0.03665924845328299,
        (lm_real)0.14619089138165467, (lm_real)0.38393593407644405, (lm_real)0.6225523832588457, (lm_real)0.4999999999999972};
    static const lm_real below[9] = {
        (lm_real)7.277023885180274e-05, (lm_real)0.0015193169568400427, (lm_real)0.015198325512259452, (lm_real)0.0934102074318661,
        (lm_real)0.38143006257911344, (lm_real)1.0511868675224953, (lm_real)1.897941510330385, (lm_real)2.042989327319648,
        (lm_real)1.0};
    const lm_real at = lm_least_of(x, LM_FARTHEST);
    lm_real numerator = LM_ZERO;
    lm_real denominator = below[0];
    int k;
    for (k = 0; k < 8; k++) {
        numerator = numerator * at + above[k];
        denominator = denominator * at + below[k + 1];
    }
    return LM_EXP(-(lm_real)0.5 * at * at) * (numerator / denominator);
}

/* Share of robots in which a load closes the play, and share in which it does not: both with all digits, also where they are small. */
static void lm_shares(const lm_friction *friction, lm_real load, lm_real whole, lm_real *closed, lm_real *open)
{
    const lm_real rounding = LM_ROUNDING * whole / friction->lever;
    const lm_real real = ((load > rounding) || (friction->nominal > rounding)) ? load : LM_ZERO;
    lm_real share;
    lm_real rest;
    if (friction->tolerance > LM_ZERO) {
        const lm_real beyond = (real - friction->nominal) / friction->tolerance;
        if (friction->count > 0) {
            share = lm_pieces_at(beyond, friction->base, friction->first, friction->count);
            rest = LM_ONE - share;
        } else {
            const lm_real at = friction->scale * beyond;
            const lm_real least = lm_largest_of((lm_tail(LM_FABS(at)) - friction->low) / friction->whole, LM_ZERO);
            const lm_real most = LM_ONE - least;
            share = (at > LM_ZERO) ? most : least;
            rest = (at > LM_ZERO) ? least : most;
        }
    } else {
        share = ((real > LM_ZERO) && (real >= friction->nominal)) ? LM_ONE : LM_ZERO;
        rest = LM_ONE - share;
    }
    *closed = lm_largest_of(*closed, share);
    *open = lm_least_of(*open, rest);
}
#endif

#if LM_TABLES > 0
/* The four cubic B-splines that are not zero at a coordinate, and the index of the first. */
static int lm_splines(const lm_real knots[], int nodes, lm_real at, lm_real values[4])
{
    int interval = 3;
    int degree;
    int k;
    for (k = 4; k < nodes; k++) {
        interval += (at >= knots[k]) ? 1 : 0;
    }
    values[0] = LM_ONE;
    for (degree = 1; degree <= 3; degree++) {
        lm_real saved = LM_ZERO;
        for (k = 0; k < degree; k++) {
            const lm_real right = knots[interval + k + 1];
            const lm_real left = knots[interval + 1 - degree + k];
            const lm_real part = values[k] / (right - left);
            values[k] = saved + (right - at) * part;
            saved = (at - left) * part;
        }
        values[degree] = saved;
    }
    return interval - 3;
}

static void lm_spline_at(const lm_load_table *table, const lm_spline *spline, const lm_real at[3], lm_real out[3])
{
    lm_real weights[3][4];
    int first[3];
    lm_real growth = LM_ONE;
    int i;
    int j;
    int k;
    for (k = 0; k < 3; k++) {
        if (spline->nodes[k] > 1) {
            first[k] = lm_splines(spline->knots[k], spline->nodes[k], at[k], weights[k]);
        } else {
            first[k] = 0;
            weights[k][0] = LM_ONE;
            weights[k][1] = LM_ZERO;
            weights[k][2] = LM_ZERO;
            weights[k][3] = LM_ZERO;
        }
        out[k] = LM_ZERO;
    }
    for (i = 0; i < 4; i++) {
        for (j = 0; j < 4; j++) {
            const lm_real *row = &spline->coefficients[3 * (((first[0] + i) * spline->nodes[1] + first[1] + j) * spline->nodes[2] + first[2])];
            const lm_real weight = weights[0][i] * weights[1][j];
            const int count = (spline->nodes[2] > 1) ? 4 : 1;
            for (k = 0; k < count; k++) {
                const lm_real here = weight * weights[2][k];
                out[0] += here * row[3 * k];
                out[1] += here * row[3 * k + 1];
                out[2] += here * row[3 * k + 2];
            }
        }
    }
    if (spline->preloaded != 0) {
        growth = LM_POW(lm_largest_of(at[0], table->bottom), (lm_real)2 / table->power);
    }
    for (k = 0; k < 3; k++) {
        out[k] *= growth;
    }
}

/* Nine factors of a table: of each row and of the axis its deflection, its edge and its growth. Return 0 for a load beyond the table. */
static int lm_displacements(const lm_load_table *table, const lm_real loads[][3], const lm_real lengths[], lm_real out[9])
{
    const lm_real half_turn = (lm_real)1.57079632679489662 - table->rim;
    const lm_real behind = LM_POW(lengths[table->seats[0]], table->power);
    const lm_real ahead = LM_POW(lengths[table->seats[1]], table->power);
    const lm_real along = (table->axial != 0) ? loads[table->seats[2]][0] : LM_ZERO;
    const lm_real axial = lm_sign(along) * LM_POW(LM_FABS(along), table->power);
    const lm_real radial = LM_SQRT(behind * behind + ahead * ahead);
    const lm_real size = LM_SQRT(LM_SQRT(radial * radial + axial * axial) / table->top);
    lm_real at[3];
    lm_real whole[3];
    lm_real edge[3] = {LM_ZERO, LM_ZERO, LM_ZERO};
    lm_real wider[3] = {LM_ZERO, LM_ZERO, LM_ZERO};
    int k;
    at[0] = lm_least_of(size, LM_ONE);
    at[1] = lm_clip(LM_ATAN2(ahead, behind), table->rim, half_turn);
    at[2] = lm_clip(LM_ATAN2(axial, radial), -half_turn, half_turn);
    lm_spline_at(table, table->own, at, whole);
    if (table->wider != NULL) {
        lm_spline_at(table, table->wider, at, wider);
        for (k = 0; (k < 3) && (table->step > LM_ZERO); k++) {
            wider[k] = (wider[k] - whole[k]) / table->step;
        }
    }
    if (table->own->has_clearance != 0) {
        at[0] = LM_ZERO;
        lm_spline_at(table, table->own, at, edge);
        edge[0] = lm_largest_of(edge[0], LM_ZERO);
        edge[1] = lm_largest_of(edge[1], LM_ZERO);
    }
    for (k = 0; k < 3; k++) {
        out[3 * k] = whole[k] - edge[k];
        out[3 * k + 1] = edge[k];
        out[3 * k + 2] = wider[k];
    }
    return (size <= LM_ONE) ? 1 : 0;
}
#endif

typedef struct {
    lm_real wrench[6];
#if LM_FED_FORWARD > 0
    lm_real process[6]; /* part of the wrench by the process force and moment */
#endif
    lm_real gravity[3];
    lm_real factors[LM_FACTORS];
    lm_real sizes[LM_SIZES];
    lm_real behind[3]; /* side factors: 1, -side, 1 - side^2 */
    int open_play; /* flags */
    int beyond; /* a load beyond a table */
} lm_local;

/* All factors of a place in their order. */
static void lm_find_factors(const lm_place *place, lm_real value, lm_local *local)
{
    lm_real *factors = local->factors;
    int count = 1;
    int k;
#if LM_SEATS > 0
    lm_real loads[LM_SEATS][3];
    lm_real lengths[LM_SEATS] = {LM_ZERO};
#endif
    factors[0] = LM_ONE;
    for (k = place->curve; k < place->curve + place->curves; k++) {
        const lm_curve *curve = &lm_curves[k];
#if LM_FED_FORWARD > 0
        const lm_real known = (curve->weights != 0) ? lm_dot6(curve->way, local->process) : LM_ZERO;
        const lm_real load = lm_dot6(curve->way, local->wrench) - known;
#else
        const lm_real load = lm_dot6(curve->way, local->wrench);
#endif
        const lm_real size = lm_pieces_at((curve->travels != 0) ? value : LM_FABS(load), curve->base, curve->first, curve->count);
        factors[count] = (curve->odd != 0) ? lm_sign(load) * size : size;
        count++;
    }
    for (k = place->harmonic; k < place->harmonic + place->harmonics; k++) {
        const lm_harmonic *harmonic = &lm_harmonics[k];
        const lm_real phase = harmonic->order * (harmonic->turns * value);
        factors[count] = (harmonic->cosine != 0) ? LM_COS(phase) : LM_SIN(phase);
        count++;
    }
#if LM_SEATS > 0
    for (k = 0; k < place->seats; k++) {
        const lm_seat *seat = &lm_seats[place->seat + k];
        lm_real inverse;
        int i;
        for (i = 0; i < seat->size; i++) {
            loads[k][i] = lm_dot6(&seat->way[6 * i], local->wrench);
        }
        lengths[k] = LM_SQRT(lm_dot(loads[k], loads[k], seat->size));
        if (lengths[k] <= LM_LEAST) {
            lengths[k] = LM_ZERO;
        }
        inverse = (lengths[k] > LM_ZERO) ? LM_ONE / lengths[k] : LM_ONE;
        for (i = 0; i < seat->size; i++) {
            factors[count] = loads[k][i] * inverse;
            count++;
        }
    }
    if (place->thresholds > 0) {
        const lm_real whole = LM_SQRT(lm_dot6(local->wrench, local->wrench));
        for (k = place->threshold; k < place->threshold + place->thresholds; k++) {
            const lm_threshold *threshold = &lm_thresholds[k];
            lm_real closed = LM_ZERO;
            lm_real open = LM_ONE;
            int i;
            for (i = threshold->first; i < threshold->first + threshold->count; i++) {
                lm_shares(&lm_frictions[i], lengths[lm_frictions[i].seat], whole, &closed, &open);
            }
            factors[count] = closed;
            factors[count + 1] = open;
            factors[count + 2] = LM_SQRT(closed * open);
            count += 3;
            local->open_play |= (closed < LM_ALL) ? place->play : 0;
        }
    }
#endif
#if LM_TABLES > 0
    for (k = place->table; k < place->table + place->tables; k++) {
        local->beyond |= (lm_displacements(&lm_load_tables[k], (const lm_real(*)[3])loads, lengths, &factors[count]) != 0) ? 0 : 1;
        count += 9;
    }
#endif
}

#ifdef LM_ACCURATE_LENGTH
#define LM_SADDLE_STEPS 8
#define LM_NODES 10

typedef struct {
    lm_real re, im;
} lm_complex;

/* Of a scaled covariance C and mean b: eigenvalues, tr C, sum of principal minors, det C, and b'b, b'(tr C - C)b, b' adj(C) b. */
typedef struct {
    lm_real values[3];
    lm_real trace, minors, determinant;
    lm_real zero, one, two;
} lm_invariants;

static lm_complex lm_times(lm_complex a, lm_complex b)
{
    lm_complex product;
    product.re = a.re * b.re - a.im * b.im;
    product.im = a.re * b.im + a.im * b.re;
    return product;
}

static lm_complex lm_over(lm_complex a, lm_complex b)
{
    const lm_real size = b.re * b.re + b.im * b.im;
    lm_complex quotient;
    quotient.re = (a.re * b.re + a.im * b.im) / size;
    quotient.im = (a.im * b.re - a.re * b.im) / size;
    return quotient;
}

static lm_real lm_determinant(const lm_real m[9])
{
    return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
}

static void lm_find_invariants(const lm_real b[3], const lm_real c[9], const lm_real c2[9], lm_invariants *found)
{
    const lm_real third = (c[0] + c[4] + c[8]) / (lm_real)3;
    lm_real rest[9];
    lm_real cb[3];
    lm_real c2b[3];
    lm_real size;
    lm_real angle = LM_ZERO;
    int k;
    for (k = 0; k < 9; k++) {
        rest[k] = c[k] - (((k % 4) == 0) ? third : LM_ZERO);
    }
    for (k = 0; k < 3; k++) {
        cb[k] = lm_dot3(&c[3 * k], b);
        c2b[k] = lm_dot3(&c2[3 * k], b);
    }
    found->trace = (lm_real)3 * third;
    found->minors = (found->trace * found->trace - (c2[0] + c2[4] + c2[8])) / (lm_real)2;
    found->determinant = lm_determinant(c);
    found->zero = lm_dot3(b, b);
    found->one = found->trace * found->zero - lm_dot3(b, cb);
    found->two = lm_dot3(b, c2b) - found->trace * lm_dot3(b, cb) + found->minors * found->zero;
    size = LM_SQRT(lm_dot(rest, rest, 9) / (lm_real)6);
    if (size > LM_ZERO) {
        for (k = 0; k < 9; k++) {
            rest[k] /= size;
        }
        angle = LM_ACOS(lm_clip(lm_determinant(rest) / (lm_real)2, -LM_ONE, LM_ONE)) / (lm_real)3;
    }
    for (k = 0; k < 3; k++) {
        const lm_real turn = (lm_real)k * (lm_real)2.0943951023931953;
        found->values[k] = lm_largest_of(third + (lm_real)2 * size * LM_COS(angle + turn), LM_ZERO);
    }
}

/* First three derivatives of log M(t) - t x - log t, where M is the moment generating function of the squared length. */
static void lm_derivatives(const lm_invariants *found, lm_real t, lm_real x, lm_real out[3])
{
    const lm_real d1 = -(lm_real)2 * found->trace + (lm_real)8 * t * found->minors - (lm_real)24 * t * t * found->determinant;
    const lm_real d2 = (lm_real)8 * found->minors - (lm_real)48 * t * found->determinant;
    const lm_real d3 = -(lm_real)48 * found->determinant;
    const lm_real m0 = t * (found->zero - (lm_real)2 * t * found->one + (lm_real)4 * t * t * found->two);
    const lm_real m1 = found->zero - (lm_real)4 * t * found->one + (lm_real)12 * t * t * found->two;
    const lm_real m2 = -(lm_real)4 * found->one + (lm_real)24 * t * found->two;
    const lm_real m3 = (lm_real)24 * found->two;
    lm_real d = LM_ONE;
    lm_real g;
    lm_real g1;
    lm_real g2;
    lm_real g3;
    int k;
    out[0] = -x - LM_ONE / t;
    out[1] = LM_ONE / (t * t);
    out[2] = -(lm_real)2 / (t * t * t);
    for (k = 0; k < 3; k++) {
        const lm_real factor = LM_ONE - (lm_real)2 * found->values[k] * t;
        const lm_real part = found->values[k] / factor;
        d *= factor;
        out[0] += part;
        out[1] += (lm_real)2 * part * part;
        out[2] += (lm_real)8 * part * part * part;
    }
    g = m0 / d;
    g1 = (m1 - g * d1) / d;
    g2 = (m2 - (lm_real)2 * g1 * d1 - g * d2) / d;
    g3 = (m3 - (lm_real)3 * g2 * d1 - (lm_real)3 * g1 * d2 - g * d3) / d;
    out[0] += g1;
    out[1] += g2;
    out[2] += g3;
}

/* One Newton step for the squared length that 5 % exceed, by an integral along a path through the saddle point: 0.2 % of the length. */
static lm_real lm_accurate(const lm_real b[3], const lm_real c[9], const lm_real c2[9], lm_real x)
{
    lm_invariants found;
    lm_real slopes[3];
    lm_real low = LM_ZERO;
    lm_real high;
    lm_real saddle;
    lm_real width;
    lm_real bend;
    lm_real tail = LM_ZERO;
    lm_real density = LM_ZERO;
    int k;
    lm_find_invariants(b, c, c2, &found);
    high = (lm_real)0.5 / found.values[0];
    saddle = high / (lm_real)2;
    for (k = 0; k < LM_SADDLE_STEPS; k++) {
        lm_real to;
        lm_derivatives(&found, saddle, x, slopes);
        if (slopes[0] < LM_ZERO) {
            low = saddle;
        } else {
            high = saddle;
        }
        to = saddle - slopes[0] / slopes[1];
        saddle = ((to >= low) && (to <= high)) ? to : (low + high) / (lm_real)2;
    }
    lm_derivatives(&found, saddle, x, slopes);
    width = LM_ONE / LM_SQRT(slopes[1]);
    bend = lm_largest_of(slopes[2], LM_ZERO) / ((lm_real)6 * slopes[1] * slopes[1]);
    for (k = 0; k < LM_NODES; k++) {
        const lm_real y = ((lm_real)k + (lm_real)0.5) * (lm_real)0.5;
        lm_complex t;
        lm_complex step;
        lm_complex below = {LM_ONE, LM_ZERO};
        lm_complex above;
        lm_complex exponent;
        lm_complex weight;
        lm_real size;
        int j;
        t.re = saddle + bend * y * y;
        t.im = y * width;
        step.re = (lm_real)2 * bend * y;
        step.im = width;
        above = lm_times(t, t);
        above.re = found.zero - (lm_real)2 * t.re * found.one + (lm_real)4 * above.re * found.two;
        above.im = -(lm_real)2 * t.im * found.one + (lm_real)4 * above.im * found.two;
        above = lm_times(above, t);
        exponent.re = -t.re * x;
        exponent.im = -t.im * x;
        for (j = 0; j < 3; j++) {
            lm_complex factor;
            factor.re = LM_ONE - (lm_real)2 * found.values[j] * t.re;
            factor.im = -(lm_real)2 * found.values[j] * t.im;
            below = lm_times(below, factor);
            /* the logarithm of each factor by itself has the right branch */
            exponent.re -= LM_LOG(factor.re * factor.re + factor.im * factor.im) / (lm_real)4;
            exponent.im -= LM_ATAN2(factor.im, factor.re) / (lm_real)2;
        }
        above = lm_over(above, below);
        exponent.re += above.re;
        exponent.im += above.im;
        size = LM_EXP(exponent.re);
        weight.re = size * LM_COS(exponent.im);
        weight.im = size * LM_SIN(exponent.im);
        weight = lm_times(weight, step);
        density += weight.im;
        weight = lm_over(weight, t);
        tail += weight.im;
    }
    /* spacing 1/2 over pi */
    tail *= (lm_real)0.15915494309189535;
    density *= (lm_real)0.15915494309189535;
    return x + (tail - (lm_real)0.05) / density;
}
#endif

/* 95th percentile of the length of a normal vector: P. Hall 1983; E. Wilson, M. Hilferty 1931. Scaled, so that no power underflows. */
static lm_real lm_percentile(const lm_real mean[3], const lm_real covariance[6], lm_real mean_square)
{
    lm_real length = LM_ZERO;
    if (mean_square > LM_ZERO) {
        const lm_real scale = LM_ONE / mean_square;
        const lm_real root = LM_SQRT(scale);
        lm_real c[9];
        lm_real c2[9];
        lm_real b[3];
        lm_real cb[3];
        lm_real second;
        lm_real third;
        int i;
        int j;
        for (i = 0; i < 3; i++) {
            b[i] = mean[i] * root;
        }
        c[0] = covariance[0] * scale;
        c[1] = covariance[1] * scale;
        c[2] = covariance[2] * scale;
        c[4] = covariance[3] * scale;
        c[5] = covariance[4] * scale;
        c[8] = covariance[5] * scale;
        c[3] = c[1];
        c[6] = c[2];
        c[7] = c[5];
        for (i = 0; i < 3; i++) {
            for (j = 0; j < 3; j++) {
                c2[3 * i + j] = lm_dot3(&c[3 * i], &c[3 * j]);
            }
            cb[i] = lm_dot3(&c[3 * i], b);
        }
        second = c2[0] + c2[4] + c2[8] + (lm_real)2 * lm_dot3(b, cb);
        third = lm_dot(c2, c, 9) + (lm_real)3 * lm_dot3(cb, cb);
        length = mean_square;
        if (second > (lm_real)1e-12) {
            const lm_real freedom = second * second * second / (third * third);
            const lm_real part = (lm_real)2 / ((lm_real)9 * freedom);
            const lm_real cube = LM_ONE - part + (lm_real)1.6448536269514722 * LM_SQRT(part);
            length = mean_square * (LM_ONE + LM_SQRT(second / freedom) * freedom * (cube * cube * cube - LM_ONE));
        }
#ifdef LM_ACCURATE_LENGTH
        if (second > (lm_real)1e-10) {
            length = mean_square * lm_accurate(b, c, c2, length * scale);
        }
#endif
        length = LM_SQRT(length);
    }
    return length;
}

/* Status, flags and length of the error, from torques, screw and covariance. */
static void lm_finish(lm_output *output, int open_play, int beyond)
{
    int k;
    output->status = LM_OK;
    output->flags = open_play;
    for (k = 0; k < LM_JOINTS; k++) {
        output->flags |= (LM_FABS(output->torques[k]) > lm_rated[k]) ? LM_OVERLOAD : 0;
    }
    output->mean_square = output->covariance[0] + output->covariance[3] + output->covariance[5] + lm_dot3(&output->screw[3], &output->screw[3]);
    output->length95 = lm_percentile(&output->screw[3], output->covariance, output->mean_square);
    if (beyond != 0) {
        *output = lm_no_output;
        output->status = LM_LOAD;
    }
}

/* sum += turn v */
static void lm_add_turned(const lm_real turn[9], const lm_real v[3], lm_real sum[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        sum[k] += lm_dot3(&turn[3 * k], v);
    }
}

/* out = turn' v */
static void lm_into(const lm_real turn[9], const lm_real v[3], lm_real out[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        out[k] = turn[k] * v[0] + turn[3 + k] * v[1] + turn[6 + k] * v[2];
    }
}

/* sum += factor v */
static void lm_add6(lm_real factor, const lm_real v[6], lm_real sum[6])
{
    sum[0] += factor * v[0];
    sum[1] += factor * v[1];
    sum[2] += factor * v[2];
    sum[3] += factor * v[3];
    sum[4] += factor * v[4];
    sum[5] += factor * v[5];
}

/* Wrenches: each place carries its own weight, the payload where it is the tool, and the wrenches of its children. */
static void lm_wrenches(const lm_input *input, lm_state *state)
{
    int k;
    int i;
    for (k = 0; k < LM_PLACES; k++) {
        for (i = 0; i < 3; i++) {
            state->moment[k][i] = LM_ZERO;
            state->force[k][i] = LM_ZERO;
        }
    }
    for (k = LM_PLACES - 1; k >= 0; k--) {
        const lm_place *place = &lm_places[k];
        lm_real *moment = state->moment[k];
        lm_real *force = state->force[k];
        lm_real mass = place->mass;
        lm_real first[3];
        lm_real lever[3] = {LM_ZERO, LM_ZERO, LM_ZERO};
        for (i = 0; i < 3; i++) {
            first[i] = place->moment[i];
        }
        if (k == LM_PLACES - 1) {
            mass += input->load[0];
            for (i = 0; i < 3; i++) {
                first[i] += input->load[0] * input->load[1 + i];
            }
            lm_add_turned(state->turn[k], &input->load[4], force);
            lm_add_turned(state->turn[k], &input->load[7], moment);
        }
        lm_add_turned(state->turn[k], first, lever);
        lm_add_cross(lever, input->gravity, moment);
        for (i = 0; i < 3; i++) {
            force[i] += mass * input->gravity[i];
        }
        if (k > 0) {
            lm_real arm[3];
            for (i = 0; i < 3; i++) {
                arm[i] = state->point[k][i] - state->point[place->parent][i];
                state->force[place->parent][i] += force[i];
                state->moment[place->parent][i] += moment[i];
            }
            lm_add_cross(arm, force, state->moment[place->parent]);
        }
    }
}

/* All sizes of a place: products of its factors. */
static void lm_find_sizes(const lm_place *place, lm_local *local)
{
    const lm_real *factors = local->factors;
    int k;
    for (k = 0; k < place->sizes; k++) {
        const lm_size *size = &lm_sizes[place->size + k];
        local->sizes[k] = factors[size->a] * factors[size->b] * factors[size->c];
    }
}

/* out += compliance wrench + own_weight gravity + entries */
static void lm_add_linear(const lm_local *local, const lm_real *compliance, const lm_real *own_weight, lm_real out[6])
{
    int k;
    if (compliance != NULL) {
        for (k = 0; k < 6; k++) {
            out[k] += lm_dot6(&compliance[6 * k], local->wrench);
        }
    }
    if (own_weight != NULL) {
        for (k = 0; k < 6; k++) {
            out[k] += lm_dot3(&own_weight[3 * k], local->gravity);
        }
    }
}

static void lm_add_entries(const lm_local *local, int first, int count, lm_real out[6])
{
    int k;
    for (k = first; k < first + count; k++) {
        const lm_entry *entry = &lm_entries[k];
        const lm_real factor = local->sizes[entry->size] * local->behind[entry->side];
        lm_add6(factor, entry->direction, out);
    }
}

#if LM_FED_FORWARD > 0
/* Wrench of the process force and moment on a place, in its own axes. */
static void lm_process(const lm_input *input, const lm_state *state, int k, lm_real out[6])
{
    const lm_real *tool = state->turn[LM_PLACES - 1];
    lm_real force[3] = {LM_ZERO, LM_ZERO, LM_ZERO};
    lm_real moment[3] = {LM_ZERO, LM_ZERO, LM_ZERO};
    lm_real arm[3];
    int i;
    for (i = 0; i < 3; i++) {
        arm[i] = state->point[LM_PLACES - 1][i] - state->point[k][i];
    }
    lm_add_turned(tool, &input->load[4], force);
    lm_add_turned(tool, &input->load[7], moment);
    lm_add_cross(arm, force, moment);
    lm_into(state->turn[k], moment, &out[0]);
    lm_into(state->turn[k], force, &out[3]);
}
#endif

/* Wrench and expected twist of a place in its own axes, and what of it is linear in the loads. */
static void lm_expect(const lm_input *input, const lm_real q[LM_JOINTS], const lm_state *state, int k, lm_local *local, lm_real linear[6], lm_real mean[6])
{
    const lm_place *place = &lm_places[k];
    lm_real side = LM_ZERO;
    lm_real value = LM_ZERO;
    int i;
    lm_into(state->turn[k], state->moment[k], &local->wrench[0]);
    lm_into(state->turn[k], state->force[k], &local->wrench[3]);
    if (place->joint >= 0) {
        side = input->side[place->joint];
        value = q[place->joint];
    }
    local->behind[0] = LM_ONE;
    local->behind[1] = -side;
    local->behind[2] = LM_ONE - side * side;
    lm_into(state->turn[k], input->gravity, local->gravity);
#if LM_FED_FORWARD > 0
    lm_process(input, state, k, local->process);
#endif
    lm_find_factors(place, value, local);
    lm_find_sizes(place, local);
    for (i = 0; i < 6; i++) {
        linear[i] = LM_ZERO;
    }
    lm_add_linear(local, place->compliance, place->own_weight, linear);
    for (i = 0; i < 6; i++) {
        mean[i] = place->mean[i] + linear[i];
    }
    lm_add_entries(local, place->entry, place->entries, mean);
    for (i = place->axis_entry; i < place->axis_entry + place->axis_entries; i++) {
        const lm_axis_entry *entry = &lm_axis_entries[i];
        mean[place->axis] += local->sizes[entry->size] * local->behind[entry->side] * entry->value;
    }
}

/* a . b over the joints */
static lm_real lm_joint_dot(const lm_real a[], const lm_real b[]);

/* The prediction at inputs that were checked, and the expected twists of all places in their own axes. */
static void lm_predict_valid(const lm_input *input, lm_output *output, lm_real twists[LM_PLACES][6]);

#ifdef LM_UNROLLED
#include "lm_unrolled.h"
#else
static lm_real lm_joint_dot(const lm_real a[], const lm_real b[])
{
    return lm_dot(a, b, LM_JOINTS);
}

/* Index of an element of a symmetric 6 x 6 matrix in its upper triangle. */
static const int lm_upper[6][6] = {{0, 1, 2, 3, 4, 5},    {1, 6, 7, 8, 9, 10},   {2, 7, 11, 12, 13, 14},
                                   {3, 8, 12, 15, 16, 17}, {4, 9, 13, 16, 18, 19}, {5, 10, 14, 17, 19, 20}};

/* sum += v v', as xx xy xz yy yz zz */
static void lm_add_square(lm_real factor, const lm_real v[3], lm_real sum[6])
{
    const lm_real x = factor * v[0];
    const lm_real y = factor * v[1];
    sum[0] += x * v[0];
    sum[1] += x * v[1];
    sum[2] += x * v[2];
    sum[3] += y * v[1];
    sum[4] += y * v[2];
    sum[5] += factor * v[2] * v[2];
}

/* Twist of the tool per twist at a place: columns of turn, and their cross products with the vector to the tool point. */
static void lm_carry(const lm_real turn[9], const lm_real to_tool[3], lm_real shift[3][6])
{
    int j;
    for (j = 0; j < 3; j++) {
        const lm_real x = turn[j];
        const lm_real y = turn[3 + j];
        const lm_real z = turn[6 + j];
        shift[0][j] = y * to_tool[2] - z * to_tool[1];
        shift[1][j] = z * to_tool[0] - x * to_tool[2];
        shift[2][j] = x * to_tool[1] - y * to_tool[0];
        shift[0][3 + j] = x;
        shift[1][3 + j] = y;
        shift[2][3 + j] = z;
    }
}

/* covariance += S of the place, carried to the tool */
static void lm_add_covariance(const lm_place *place, const lm_local *local, const lm_real shift[3][6], lm_real covariance[6])
{
    lm_real variance = place->axis_variance;
    lm_real v[3];
    int k;
    int i;
    for (k = place->axis_product; k < place->axis_product + place->axis_products; k++) {
        const lm_axis_product *product = &lm_axis_products[k];
        variance += local->sizes[product->first] * local->sizes[product->second] * local->behind[product->side] * product->value;
    }
    if (place->joint >= 0) {
        for (i = 0; i < 3; i++) {
            v[i] = shift[i][place->axis];
        }
        lm_add_square(variance, v, covariance);
    }
    for (k = place->column; k < place->column + place->columns; k++) {
        for (i = 0; i < 3; i++) {
            v[i] = lm_dot6(shift[i], lm_columns[k].direction);
        }
        lm_add_square(LM_ONE, v, covariance);
    }
    if (place->products > 0) {
        lm_real own[21];
        lm_real part[3][6];
        for (k = 0; k < 21; k++) {
            own[k] = LM_ZERO;
        }
        for (k = place->product; k < place->product + place->products; k++) {
            const lm_product *product = &lm_products[k];
            const lm_real factor = local->sizes[product->first] * local->sizes[product->second] * local->behind[product->side];
            for (i = 0; i < 21; i++) {
                own[i] += factor * product->matrix[i];
            }
        }
        for (i = 0; i < 6; i++) {
            lm_real row[6];
            for (k = 0; k < 6; k++) {
                row[k] = own[lm_upper[i][k]];
            }
            for (k = 0; k < 3; k++) {
                part[k][i] = lm_dot6(shift[k], row);
            }
        }
        covariance[0] += lm_dot6(part[0], shift[0]);
        covariance[1] += lm_dot6(part[0], shift[1]);
        covariance[2] += lm_dot6(part[0], shift[2]);
        covariance[3] += lm_dot6(part[1], shift[1]);
        covariance[4] += lm_dot6(part[1], shift[2]);
        covariance[5] += lm_dot6(part[2], shift[2]);
    }
}

static void lm_predict_valid(const lm_input *input, lm_output *output, lm_real twists[LM_PLACES][6])
{
    lm_state state;
    lm_local local;
    lm_real draws[LM_DRAWS][3];
    const lm_real *tool;
    int k;
    int i;
    *output = lm_no_output;
    lm_frames(input->q, NULL, &state);
    tool = state.point[LM_PLACES - 1];
    lm_wrenches(input, &state);
    local.open_play = 0;
    local.beyond = 0;
    for (k = 0; k < LM_DRAWS; k++) {
        for (i = 0; i < 3; i++) {
            draws[k][i] = LM_ZERO;
        }
    }
    for (i = 0; i < 9; i++) {
        output->turn[i] = state.turn[LM_PLACES - 1][i];
    }
    for (i = 0; i < 3; i++) {
        output->point[i] = tool[i];
    }
    for (k = 0; k < LM_PLACES; k++) {
        const lm_place *place = &lm_places[k];
        const lm_real *turn = state.turn[k];
        if (place->joint >= 0) {
            const lm_real *load = (place->axis == 2) ? state.moment[k] : state.force[k];
            output->torques[place->joint] = -(turn[2] * load[0] + turn[5] * load[1] + turn[8] * load[2]);
        }
        if (place->errs != 0) {
            lm_real to_tool[3];
            lm_real shift[3][6];
            lm_real linear[6];
            lm_real *mean = twists[k];
            lm_real along = LM_ZERO;
            for (i = 0; i < 3; i++) {
                to_tool[i] = tool[i] - state.point[k][i];
            }
            lm_expect(input, input->q, &state, k, &local, linear, mean);
            lm_carry(turn, to_tool, shift);
            if (place->joint >= 0) {
                const int axis = place->axis;
                along = mean[axis];
                output->joints[place->joint] = along;
                mean[axis] = LM_ZERO;
                for (i = 0; i < 3; i++) {
                    const lm_real spin = (axis == 2) ? turn[3 * i + 2] : LM_ZERO;
                    output->jacobian[LM_JOINTS * i + place->joint] = spin;
                    output->jacobian[LM_JOINTS * (3 + i) + place->joint] = shift[i][axis];
                    output->screw[i] += spin * along;
                    output->screw[3 + i] += shift[i][axis] * along;
                }
            }
            lm_add_turned(turn, mean, output->elsewhere);
            for (i = 0; i < 3; i++) {
                output->elsewhere[3 + i] += lm_dot6(shift[i], mean);
            }
            lm_add_covariance(place, &local, (const lm_real(*)[6])shift, output->covariance);
            for (i = place->shared; i < place->shared + place->shareds; i++) {
                const lm_shared *shared = &lm_shareds[i];
                lm_real own[6] = {LM_ZERO, LM_ZERO, LM_ZERO, LM_ZERO, LM_ZERO, LM_ZERO};
                int j;
                lm_add6(shared->share, linear, own);
                lm_add_linear(&local, shared->compliance, shared->own_weight, own);
                lm_add_entries(&local, shared->first, shared->count, own);
                for (j = 0; j < 3; j++) {
                    draws[shared->draw][j] += lm_dot6(shift[j], own);
                }
            }
            if (place->joint >= 0) {
                mean[place->axis] = along;
            }
        } else {
            for (i = 0; i < 6; i++) {
                twists[k][i] = LM_ZERO;
            }
        }
    }
    for (k = 0; k < LM_DRAWS; k++) {
        lm_add_square(LM_ONE, draws[k], output->covariance);
    }
    for (i = 0; i < 6; i++) {
        output->screw[i] += output->elsewhere[i];
    }
    lm_finish(output, local.open_play, local.beyond);
}
#endif

void lm_defaults(lm_input *input)
{
    int k;
    for (k = 0; k < LM_JOINTS; k++) {
        const lm_real low = lm_limits[2 * k];
        const lm_real high = lm_limits[2 * k + 1];
        input->q[k] = ((low <= LM_ZERO) && (high >= LM_ZERO)) ? LM_ZERO : low + (high - low) / (lm_real)2;
        input->side[k] = LM_ZERO;
    }
    for (k = 0; k < 10; k++) {
        input->load[k] = lm_load[k];
    }
    for (k = 0; k < 3; k++) {
        input->gravity[k] = lm_gravity[k];
    }
}

void lm_default_options(lm_options *options)
{
    options->passes = 1;
    options->whole_pose = 0;
    options->damping = (lm_real)1e-5;
    options->largest_step = (lm_real)0.01;
}

int lm_predict(const lm_input *input, lm_output *output)
{
    const int status = lm_check(input);
    if (status == LM_OK) {
        lm_real twists[LM_PLACES][6];
        lm_predict_valid(input, output, twists);
    } else {
        *output = lm_no_output;
        output->status = status;
    }
    return output->status;
}

/* rows rows' + damping, as xx xy xz yy yz zz */
static void lm_squares(const lm_real rows[3 * LM_JOINTS], lm_real damping, lm_real out[6])
{
    const lm_real *x = rows;
    const lm_real *y = &rows[LM_JOINTS];
    const lm_real *z = &rows[2 * LM_JOINTS];
    out[0] = lm_joint_dot(x, x) + damping;
    out[1] = lm_joint_dot(x, y);
    out[2] = lm_joint_dot(x, z);
    out[3] = lm_joint_dot(y, y) + damping;
    out[4] = lm_joint_dot(y, z);
    out[5] = lm_joint_dot(z, z) + damping;
}

/* Eliminate a symmetric positive definite matrix, as xx xy xz yy yz zz: inverse pivots, and what rows are multiplied by. */
static void lm_eliminate(const lm_real a[6], lm_real parts[6])
{
    lm_real rest;
    parts[0] = LM_ONE / lm_largest_of(a[0], LM_LEAST_DAMPING);
    parts[1] = a[1] * parts[0];
    parts[2] = a[2] * parts[0];
    parts[3] = LM_ONE / lm_largest_of(a[3] - a[1] * parts[1], LM_LEAST_DAMPING);
    rest = a[4] - a[1] * parts[2];
    parts[4] = rest * parts[3];
    parts[5] = LM_ONE / lm_largest_of(a[5] - a[2] * parts[2] - rest * parts[4], LM_LEAST_DAMPING);
}

/* x = a^-1 b by the parts of a; x may be b */
static void lm_solve(const lm_real parts[6], const lm_real b[3], lm_real x[3])
{
    const lm_real second = b[1] - parts[1] * b[0];
    const lm_real third = b[2] - parts[2] * b[0] - parts[4] * second;
    x[2] = third * parts[5];
    x[1] = second * parts[3] - parts[4] * x[2];
    x[0] = b[0] * parts[0] - parts[1] * x[1] - parts[2] * x[2];
}

/* The damped normal matrix of the Jacobian, in which the rotation is eliminated first where the whole pose is corrected. */
typedef struct {
    lm_real shift[6];
    lm_real turn[6];
    lm_real both[3][3];
    lm_real per[3][3];
    lm_real damping;
    int whole_pose;
} lm_normal;

static void lm_find_normal(const lm_real jacobian[6 * LM_JOINTS], const lm_options *options, lm_normal *normal)
{
    const lm_real *turns = jacobian;
    const lm_real *shifts = &jacobian[3 * LM_JOINTS];
    lm_real squares[6];
    normal->damping = options->damping;
    normal->whole_pose = options->whole_pose;
    lm_squares(shifts, options->damping, squares);
    if (options->whole_pose != 0) {
        lm_real turning[6];
        int i;
        int j;
        lm_squares(turns, options->damping / (LM_ROTATION_LENGTH * LM_ROTATION_LENGTH), turning);
        lm_eliminate(turning, normal->turn);
        for (i = 0; i < 3; i++) {
            for (j = 0; j < 3; j++) {
                normal->both[i][j] = lm_joint_dot(&shifts[LM_JOINTS * i], &turns[LM_JOINTS * j]);
            }
            lm_solve(normal->turn, normal->both[i], normal->per[i]);
        }
        squares[0] -= lm_dot3(normal->both[0], normal->per[0]);
        squares[1] -= lm_dot3(normal->both[0], normal->per[1]);
        squares[2] -= lm_dot3(normal->both[0], normal->per[2]);
        squares[3] -= lm_dot3(normal->both[1], normal->per[1]);
        squares[4] -= lm_dot3(normal->both[1], normal->per[2]);
        squares[5] -= lm_dot3(normal->both[2], normal->per[2]);
    }
    lm_eliminate(squares, normal->shift);
}

/* What the transposed Jacobian is multiplied by to remove an error of the tool; `out` may be the error. */
static void lm_invert(const lm_normal *normal, const lm_real error[6], lm_real out[6])
{
    lm_real shift[3] = {error[3], error[4], error[5]};
    lm_real turn[3] = {LM_ZERO, LM_ZERO, LM_ZERO};
    int i;
    if (normal->whole_pose != 0) {
        lm_solve(normal->turn, error, turn);
        for (i = 0; i < 3; i++) {
            shift[i] -= lm_dot3(normal->both[i], turn);
        }
    }
    lm_solve(normal->shift, shift, shift);
    for (i = 0; i < 3; i++) {
        if (normal->whole_pose != 0) {
            turn[i] -= normal->per[0][i] * shift[0] + normal->per[1][i] * shift[1] + normal->per[2][i] * shift[2];
        }
        out[i] = turn[i];
        out[3 + i] = shift[i];
    }
}

/* Step of the joints that removes an error of the tool. Return 1 where its size was reduced: where it exceeds the largest step, and what the error
 * takes at regular poses. Solved twice, the second time for what damping left, so that only its square remains. */
static int lm_step(const lm_real jacobian[6 * LM_JOINTS], const lm_normal *normal, const lm_real error[6], lm_real largest_step,
                   lm_real step[LM_JOINTS])
{
    const lm_real length = (normal->whole_pose != 0) ? LM_ROTATION_LENGTH : LM_ZERO;
    const lm_real size = LM_SQRT(lm_dot3(&error[3], &error[3]) + length * length * lm_dot3(error, error));
    const lm_real most = lm_largest_of(largest_step, size / LM_REGULAR);
    lm_real once[6];
    lm_real again[6];
    lm_real largest = LM_ZERO;
    int j;
    lm_invert(normal, error, once);
    for (j = 0; j < 3; j++) {
        again[j] = normal->damping / (LM_ROTATION_LENGTH * LM_ROTATION_LENGTH) * once[j];
        again[3 + j] = normal->damping * once[3 + j];
    }
    lm_invert(normal, again, again);
    for (j = 0; j < 6; j++) {
        once[j] += again[j];
    }
    for (j = 0; j < LM_JOINTS; j++) {
        const lm_real *column = &jacobian[j];
        step[j] = -(column[0] * once[0] + column[LM_JOINTS] * once[1] + column[2 * LM_JOINTS] * once[2]);
        step[j] -= column[3 * LM_JOINTS] * once[3] + column[4 * LM_JOINTS] * once[4] + column[5 * LM_JOINTS] * once[5];
        largest = lm_largest_of(largest, LM_FABS(step[j]));
    }
    if (largest > most) {
        for (j = 0; j < LM_JOINTS; j++) {
            step[j] *= most / largest;
        }
    }
    return (largest > most) ? 1 : 0;
}

/* Motion of the tool due to a change of the joints; the displacement to second order: each joint turns the motions of those behind it. */
static void lm_displace(const lm_real jacobian[6 * LM_JOINTS], const lm_real change[LM_JOINTS], lm_real moved[6])
{
    lm_real bend[3] = {LM_ZERO, LM_ZERO, LM_ZERO};
    int j;
    for (j = 0; j < 6; j++) {
        moved[j] = LM_ZERO;
    }
    for (j = 0; j < LM_JOINTS; j++) {
        const lm_real *column = &jacobian[j];
        const lm_real half = (lm_real)0.5 * change[j];
        const lm_real turn[3] = {half * column[0], half * column[LM_JOINTS], half * column[2 * LM_JOINTS]};
        const lm_real shift[3] = {change[j] * column[3 * LM_JOINTS], change[j] * column[4 * LM_JOINTS], change[j] * column[5 * LM_JOINTS]};
        moved[0] += turn[0];
        moved[1] += turn[1];
        moved[2] += turn[2];
        lm_add_cross(moved, shift, bend);
        moved[0] += turn[0];
        moved[1] += turn[1];
        moved[2] += turn[2];
        moved[3] += shift[0];
        moved[4] += shift[1];
        moved[5] += shift[2];
    }
    moved[3] += bend[0];
    moved[4] += bend[1];
    moved[5] += bend[2];
}

/* Product of two motions of the tool in the rows that are corrected, m^2. */
static lm_real lm_inner(const lm_real a[6], const lm_real b[6], int whole_pose)
{
    const lm_real weight = (whole_pose != 0) ? LM_ROTATION_LENGTH * LM_ROTATION_LENGTH : LM_ZERO;
    return lm_dot3(&a[3], &b[3]) + weight * lm_dot3(a, b);
}

/* Change the command `sent` within the limits by `change`, which is cut to them. `drift` is where the joints stand beyond where they should, and
 * `start` the motion of the tool by it: the change begins with its negative. `error` is that of the tool. A change that a limit cuts, or whose step
 * was `reduced`, may add to the error. It is sent whole where the share of it that makes the error smallest is at least 1 / LM_NEAR_BEST. Return 1
 * where it was cut or reduced. */
static int lm_send(const lm_output *at, const lm_real drift[LM_JOINTS], const lm_real start[6], lm_real change[LM_JOINTS], int reduced,
                   int whole_pose, const lm_real error[6], lm_real sent[LM_JOINTS])
{
    lm_real reached[LM_JOINTS];
    lm_real effect[6];
    lm_real share = LM_ONE;
    int cut = reduced;
    int j;
    for (j = 0; j < LM_JOINTS; j++) {
        const lm_real asked = sent[j] + change[j];
        const lm_real within = lm_clip(asked, lm_limits[2 * j], lm_limits[2 * j + 1]);
        if (LM_FABS(within - asked) > LM_UNCUT) {
            change[j] = within - sent[j];
            cut = 1;
        }
        reached[j] = drift[j] + change[j];
    }
    lm_displace(at->jacobian, reached, effect);
    for (j = 0; j < 6; j++) {
        effect[j] -= start[j];
    }
    if ((cut != 0) && (lm_inner(effect, effect, whole_pose) > LM_ZERO)) {
        share = lm_clip(-LM_NEAR_BEST * lm_inner(effect, error, whole_pose) / lm_inner(effect, effect, whole_pose), LM_ZERO, LM_ONE);
    }
    for (j = 0; j < LM_JOINTS; j++) {
        sent[j] = lm_clip(sent[j] + share * change[j], lm_limits[2 * j], lm_limits[2 * j + 1]);
    }
    return cut;
}

/* Let an arm that is commanded to q stand under the loads that act where it stands with these twists: one step to its equilibrium. Replace the
 * twists, and find how far the tool is from where it stands without errors. Return 0 for a load beyond a table. */
static int lm_stand(const lm_input *input, const lm_output *at, const lm_real q[LM_JOINTS], lm_real twists[LM_PLACES][6], lm_real off[6])
{
    lm_state state;
    lm_local local;
    lm_real linear[6];
    lm_real spin[3] = {LM_ZERO, LM_ZERO, LM_ZERO};
    const lm_real *turn = state.turn[LM_PLACES - 1];
    int k;
    local.open_play = 0;
    local.beyond = 0;
    lm_frames(q, (const lm_real(*)[6])twists, &state);
    lm_wrenches(input, &state);
    for (k = 0; k < LM_PLACES; k++) {
        if (lm_places[k].errs != 0) {
            lm_expect(input, q, &state, k, &local, linear, twists[k]);
        }
    }
    lm_frames(q, (const lm_real(*)[6])twists, &state);
    for (k = 0; k < 3; k++) { /* half the sum of column x column: small rotations */
        const lm_real before[3] = {at->turn[k], at->turn[3 + k], at->turn[6 + k]};
        const lm_real after[3] = {turn[k], turn[3 + k], turn[6 + k]};
        lm_add_cross(before, after, spin);
    }
    for (k = 0; k < 3; k++) {
        off[k] = (lm_real)0.5 * spin[k];
        off[3 + k] = state.point[LM_PLACES - 1][k] - at->point[k];
    }
    return (local.beyond != 0) ? 0 : 1;
}

/* What twists move the joints. */
static void lm_along_joints(const lm_real twists[LM_PLACES][6], lm_real along[LM_JOINTS])
{
    int k;
    for (k = 0; k < LM_PLACES; k++) {
        if (lm_places[k].joint >= 0) {
            along[lm_places[k].joint] = twists[k][lm_places[k].axis];
        }
    }
}

static void lm_copy_twists(const lm_real from[LM_PLACES][6], lm_real to[LM_PLACES][6])
{
    int k;
    int j;
    for (k = 0; k < LM_PLACES; k++) {
        for (j = 0; j < 6; j++) {
            to[k][j] = from[k][j];
        }
    }
}

static const lm_real lm_rigid[LM_PLACES][6] = {{LM_ZERO}};

/* The command for valid inputs, from the prediction at the wanted pose with its twists. */
static void lm_correct(const lm_input *input, const lm_options *options, const lm_output *at, const lm_real start[LM_PLACES][6], lm_command *command)
{
    const int steps = (options->passes > 1) ? 4 : 1; /* a share of the error remains of each, of the size of the angles by which the parts bend */
    lm_normal normal;
    lm_real twists[LM_PLACES][6];
    lm_real along[LM_JOINTS];
    lm_real drift[LM_JOINTS];
    lm_real change[LM_JOINTS];
    lm_real moved[6];
    lm_real gap[6];
    lm_real without[6];
    lm_real before;
    lm_real after;
    int reduced = 0;
    int valid = 1;
    int pass;
    int j;
    lm_find_normal(at->jacobian, options, &normal);
    lm_copy_twists(start, twists);
    for (j = 0; j < LM_JOINTS; j++) {
        command->q[j] = input->q[j];
        along[j] = at->joints[j];
        drift[j] = at->joints[j];
    }
    for (j = 0; j < 6; j++) {
        command->left[j] = at->screw[j];
        moved[j] = at->screw[j] - at->elsewhere[j];
    }
    for (pass = 0; pass < steps; pass++) {
        int capped;
        for (j = 0; j < 6; j++) {
            gap[j] = command->left[j] - moved[j];
        }
        capped = lm_step(at->jacobian, &normal, gap, options->largest_step, change);
        for (j = 0; j < LM_JOINTS; j++) {
            change[j] -= drift[j];
        }
        reduced |= lm_send(at, drift, moved, change, capped, options->whole_pose, command->left, command->q);
        valid &= lm_stand(input, at, command->q, twists, command->left);
        for (j = 0; j < LM_JOINTS; j++) {
            drift[j] = -along[j];
        }
        lm_along_joints((const lm_real(*)[6])twists, along);
        for (j = 0; j < LM_JOINTS; j++) {
            drift[j] += along[j];
        }
        lm_displace(at->jacobian, drift, moved);
    }
    /* A joint limit, or a play that turns over, may leave more than there was. */
    lm_copy_twists(start, twists);
    (void)lm_stand(input, at, input->q, twists, without);
    before = lm_inner(without, without, options->whole_pose);
    after = lm_inner(command->left, command->left, options->whole_pose);
    /* On the way from the command to where it stands, a play may stay on the side that the loads at the command close; and of a soft arm one step from
     * the wanted pose may miss the equilibrium. */
    lm_copy_twists(lm_rigid, twists);
    for (pass = 0; pass < 3; pass++) {
        (void)lm_stand(input, at, command->q, twists, gap);
    }
    after = lm_largest_of(after, lm_inner(gap, gap, options->whole_pose));
    reduced = (after > before + LM_UNSEEN * LM_UNSEEN) ? 1 : reduced;
    if (after > LM_WORTH * before + LM_UNSEEN * LM_UNSEEN) {
        for (j = 0; j < LM_JOINTS; j++) {
            command->q[j] = input->q[j];
        }
        for (j = 0; j < 6; j++) {
            command->left[j] = without[j];
        }
    }
    command->status = (reduced != 0) ? LM_SINGULAR : LM_OK;
    if (valid == 0) {
        *command = lm_no_command;
        command->status = LM_LOAD;
    }
}

int lm_compensate(const lm_input *input, const lm_options *options, lm_output *output, lm_command *command)
{
    int status = lm_check(input);
    int valid = lm_within(&options->damping, 1, LM_LEAST_DAMPING, LM_ONE);
    valid &= lm_within(&options->largest_step, 1, LM_ZERO, LM_MAX);
    status = (valid != 0) ? status : LM_INPUT;
    *command = lm_no_command;
    *output = lm_no_output;
    output->status = status;
    if (status == LM_OK) {
        lm_real twists[LM_PLACES][6];
        lm_predict_valid(input, output, twists);
        if (output->status == LM_OK) {
            lm_correct(input, options, output, (const lm_real(*)[6])twists, command);
        } else {
            command->status = output->status;
        }
    } else {
        command->status = status;
    }
    return command->status;
}

static int lm_agrees(const lm_real found[], const lm_real expected[], int count)
{
    lm_real largest = LM_ZERO;
    int good = 1;
    int k;
    for (k = 0; k < count; k++) {
        largest = lm_largest_of(largest, LM_FABS(expected[k]));
    }
    for (k = 0; k < count; k++) {
        good &= (LM_FABS(found[k] - expected[k]) <= LM_AGREES * largest) ? 1 : 0;
    }
    return good;
}

int lm_self_test(void)
{
    lm_options options;
    int failed = 0;
    int k;
    lm_default_options(&options);
    for (k = 0; k < LM_VECTORS; k++) {
        const lm_vector *vector = &lm_vectors[k];
        lm_output output;
        lm_command command;
        const int status = lm_compensate(&vector->input, &options, &output, &command);
        int good = ((status == LM_OK) || (status == LM_SINGULAR)) ? 1 : 0;
        good &= lm_agrees(output.point, vector->point, 3);
        good &= lm_agrees(output.screw, vector->screw, 6);
        good &= lm_agrees(output.covariance, vector->covariance, 6);
        good &= lm_agrees(output.torques, vector->torques, LM_JOINTS);
#ifndef LM_ACCURATE_LENGTH /* the stored lengths are those of the closed form */
        good &= lm_agrees(&output.length95, &vector->length95, 1);
#endif
        good &= lm_agrees(command.q, vector->command, LM_JOINTS);
        failed += (good != 0) ? 0 : 1;
    }
    return failed;
}
