/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: McTaggart, "Half-Life 2 / Valve Source shading", GDC 2004. Iwanicki, Sloan, "Ambient
 * dice", Eurographics Symposium on Rendering (EI&I) 2017. Alfeld, Neamtu, Schumaker,
 * "Bernstein-Bezier polynomials on spheres and sphere-like surfaces", CAGD 13, 1996. Foley, Opitz,
 * "Hybrid cubic Bezier triangle patches", in: Mathematical methods in computer aided geometric
 * design II, 1992. */
#include "light/basis.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "libprobe-query/sh.h"
#include "math/angle.h"
#include "math/luminance.h"
#include "math/vec.h"
#include "stream/stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FUNCTIONS_MOST = BASIS_WIDTH_MOST / 3 };

static const struct {
    const char *name, *column;
    size_t width;
} bases[BASIS_COUNT] = {[BASIS_CUBE] = {"cube", "ambient_cube", 18},
                        [BASIS_DICE] = {"dice", "ambient_dice", 36},
                        [BASIS_DICE_CUBIC] = {"dice-cubic", "ambient_dice_cubic", 108},
                        [BASIS_AHD] = {"ahd", "ahd", 9}};

const char *basis_name(enum basis basis)
{
    return bases[basis].name;
}

const char *basis_column(enum basis basis)
{
    return bases[basis].column;
}

size_t basis_width(enum basis basis)
{
    return bases[basis].width;
}

struct error *basis_parse(bool basis[BASIS_COUNT], const char *text)
{
    for (const char *at = text;;) {
        const size_t length = strcspn(at, ",");
        int i = 0;
        while (i < BASIS_COUNT &&
               (strlen(bases[i].name) != length || strncmp(bases[i].name, at, length)))
            i++;
        if (i == BASIS_COUNT)
            return error_usage(
                "expected some of cube, dice, dice-cubic, ahd, separated by commas, got '%s'",
                text);
        basis[i] = true;
        if (!at[length])
            return NULL;
        at += length + 1;
    }
}

/* -- functions -------------------------------------------------------------------------------- */

static void cube_functions(const double n[3], double *value)
{
    for (int axis = 0; axis < 3; axis++) {
        const int below = n[axis] < 0;
        value[2 * axis + below] = n[axis] * n[axis];
        value[2 * axis + !below] = 0;
    }
}

enum { CORNERS = 12 };

static struct vec3 corner(int i)
{
    double p[3] = {0};
    p[i / 4] = (i & 2 ? -1 : 1) * 0.8506508083520399;
    p[(i / 4 + 1) % 3] = (i & 1 ? -1 : 1) * 0.5257311121191336;
    return vec3_load(p);
}

/* The tangents at a corner. */
static void corner_frame(int i, struct vec3 *u, struct vec3 *v)
{
    double p[3] = {0};
    p[(i / 4 + 2) % 3] = 1;
    *u = vec3_load(p);
    *v = vec3_cross(corner(i), *u);
}

static void dice_functions(const double n[3], double *value)
{
    for (int i = 0; i < CORNERS; i++) {
        const double cosine = fmax(vec3_dot(corner(i), vec3_load(n)), 0), square = cosine * cosine;
        value[i] = 0.7 / 2 * square + 0.3 * 5 / 6 * square * square;
    }
}

/* The corners of the face that n meets are the three nearest. */
static void nearest_corners(struct vec3 n, int nearest[3])
{
    double best[3] = {-2, -2, -2};
    for (int i = 0; i < CORNERS; i++) {
        const double cosine = vec3_dot(corner(i), n);
        int place = 3;
        while (place > 0 && cosine > best[place - 1])
            place--;
        for (int k = 2; k > place; k--) {
            best[k] = best[k - 1];
            nearest[k] = nearest[k - 1];
        }
        if (place < 3) {
            best[place] = cosine;
            nearest[place] = i;
        }
    }
}

/* Adds weight times the control value next to corner i on the edge towards corner k, cos(edge) f_i
 * + v_k . grad f_i / 3, with which the edge's cubic has the value and the derivative of corner i.
 * Values are f, df/du, df/dv of each corner. */
static void add_control(int i, int k, double weight, double *value)
{
    static const double edge_cosine = 0.4472135954999579; /* 1 / sqrt(5) */
    struct vec3 u, v;
    corner_frame(i, &u, &v);
    value[3 * i] += weight * edge_cosine;
    value[3 * i + 1] += weight * vec3_dot(corner(k), u) / 3;
    value[3 * i + 2] += weight * vec3_dot(corner(k), v) / 3;
}

/* The derivative across an edge is quadratic in the edge's two coordinates, with the ends' e1 and
 * e2 as its outer coefficients; it is the blend of e1 and e2 that is constant where they agree if
 * the middle one is cos(edge) (e1 + e2) / 2. That gives the control value in the middle, as this
 * edge wants it: a0 (f_j + f_k) + a1 (c_jjk + c_kkj) + a2 (c_jji + c_kki), i the corner across from
 * it. */
static void add_middle(int i, int j, int k, double weight, double *value)
{
    static const double a0 = -0.06909830056250526, /* (sqrt(5) - 5) / 40 */
        a1 = 0.23991869381244214,                  /* (11 sqrt(5) - 15) / 40 */
        a2 = 0.22360679774997896;                  /* sqrt(5) / 10 */
    value[3 * j] += weight * a0;
    value[3 * k] += weight * a0;
    add_control(j, k, weight * a1, value);
    add_control(k, j, weight * a1, value);
    add_control(j, i, weight * a2, value);
    add_control(k, i, weight * a2, value);
}

static void cubic_functions(const double n[3], double *value)
{
    int at[3];
    double b[3]; /* n = sum of b_i times corner i */
    const struct vec3 d = vec3_load(n);
    nearest_corners(d, at);
    for (int i = 0; i < 3; i++) {
        const struct vec3 across = vec3_cross(corner(at[(i + 1) % 3]), corner(at[(i + 2) % 3]));
        b[i] = fmax(vec3_dot(d, across) / vec3_dot(corner(at[i]), across), 0);
    }
    memset(value, 0, 3 * CORNERS * sizeof *value);
    const double pairs = b[0] * b[1] + b[1] * b[2] + b[2] * b[0];
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        value[3 * at[i]] += b[i] * b[i] * b[i];
        add_control(at[i], at[j], 3 * b[i] * b[i] * b[j], value);
        add_control(at[i], at[k], 3 * b[i] * b[i] * b[k], value);
        if (pairs > 0) /* each edge has its say where it is near (Foley and Opitz) */
            add_middle(at[i], at[j], at[k], 6 * b[0] * b[1] * b[2] * b[j] * b[k] / pairs, value);
    }
}

/* Values of all functions of a linear basis. */
static void functions_at(enum basis basis, const double n[3], double *value)
{
    if (basis == BASIS_CUBE)
        cube_functions(n, value);
    else if (basis == BASIS_DICE)
        dice_functions(n, value);
    else
        cubic_functions(n, value);
}

void basis_irradiance(enum basis basis, const float *c, const double n[3], double rgb[3])
{
    double value[FUNCTIONS_MOST];
    if (basis == BASIS_AHD) {
        const double cosine =
            fmax(n[0] * (double)c[6] + n[1] * (double)c[7] + n[2] * (double)c[8], 0);
        for (int k = 0; k < 3; k++)
            rgb[k] = (double)c[k] + cosine * (double)c[3 + k];
        return;
    }
    functions_at(basis, n, value);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (size_t i = 0; i < bases[basis].width / 3; i++)
        for (size_t k = 0; k < 3; k++)
            rgb[k] += value[i] * (double)c[3 * i + k];
}

/* -- directions ------------------------------------------------------------------------------- */

/* Calls body with directions and weights that sum to the sphere's area: cells x cells patches on
 * each quarter of a cube's sides, which no function of the ambient cube has a kink inside; in each,
 * Gauss and Legendre's points x points. */
typedef void direction_body(void *context, const double n[3], double weight);

static void for_directions(int cells, int points, direction_body *body, void *context)
{
    static const double node[2][4] = {
        {0}, {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526}};
    static const double share[2][4] = {
        {2}, {0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538}};
    const int rule = points == 4, steps = 2 * cells * points;
    for (int side = 0; side < 6; side++) {
        for (int i = 0; i < steps; i++) {
            for (int k = 0; k < steps; k++) {
                const double s = (i / points + 0.5 + 0.5 * node[rule][i % points]) / cells - 1;
                const double t = (k / points + 0.5 + 0.5 * node[rule][k % points]) / cells - 1;
                const double square = 1 + s * s + t * t, length = sqrt(square);
                double n[3];
                n[side / 2] = (side % 2 ? -1 : 1) / length;
                n[(side / 2 + 1) % 3] = s / length;
                n[(side / 2 + 2) % 3] = t / length;
                body(context, n,
                     share[rule][i % points] * share[rule][k % points] / (4 * cells * cells) /
                         (square * length));
            }
        }
    }
}

/* -- fits of linear bases --------------------------------------------------------------------- */

struct basis_fit {
    enum basis basis;
    int order, functions;
    /* integrals of products; then its Cholesky factor */
    double gram[FUNCTIONS_MOST][FUNCTIONS_MOST];
    double matrix[FUNCTIONS_MOST][SH_COUNT_MAX]; /* from irradiance's coefficients to the basis's */
    struct vec3 start[384];                      /* ahd: where a search may begin */
    int starts;
};

static void add_products(void *context, const double n[3], double weight)
{
    struct basis_fit *fit = context;
    double value[FUNCTIONS_MOST], y[SH_COUNT_MAX];
    functions_at(fit->basis, n, value);
    sh_basis(fit->order, n, y);
    for (int i = 0; i < fit->functions; i++) {
        for (int k = 0; k < fit->functions; k++)
            fit->gram[i][k] += weight * value[i] * value[k];
        for (int k = 0; k < fit->order * fit->order; k++)
            fit->matrix[i][k] += weight * value[i] * y[k];
    }
}

/* Solves gram x = matrix in place, for all columns (Cholesky). */
static void solve(struct basis_fit *fit)
{
    double(*l)[FUNCTIONS_MOST] = fit->gram;
    const int count = fit->functions;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k <= i; k++) {
            double sum = l[i][k];
            for (int m = 0; m < k; m++)
                sum -= l[i][m] * l[k][m];
            l[i][k] = i == k ? sqrt(sum) : sum / l[k][k];
        }
    }
    for (int column = 0; column < fit->order * fit->order; column++) {
        for (int i = 0; i < count; i++) {
            for (int m = 0; m < i; m++)
                fit->matrix[i][column] -= l[i][m] * fit->matrix[m][column];
            fit->matrix[i][column] /= l[i][i];
        }
        for (int i = count - 1; i >= 0; i--) {
            for (int m = i + 1; m < count; m++)
                fit->matrix[i][column] -= l[m][i] * fit->matrix[m][column];
            fit->matrix[i][column] /= l[i][i];
        }
    }
}

static void add_start(void *context, const double n[3], double weight)
{
    (void)weight;
    struct basis_fit *fit = context;
    fit->start[fit->starts++] = vec3_load(n);
}

struct error *basis_fit_create(struct basis_fit **fit, enum basis basis, int order)
{
    struct error *err = array_create(fit, 1, sizeof **fit);
    if (err)
        return err;
    (*fit)->basis = basis;
    (*fit)->order = order;
    if (basis == BASIS_AHD) {
        for_directions(4, 1, add_start, *fit);
        return NULL;
    }
    (*fit)->functions = (int)(bases[basis].width / 3);
    for_directions(4, 4, add_products, *fit);
    solve(*fit);
    return NULL;
}

void basis_fit_destroy(struct basis_fit *fit)
{
    free(fit);
}

/* -- ambient and highlight and direction ------------------------------------------------------ */

/* A probe's irradiance against A + H c, c(n) = max(0, n . d). With <1, 1> = 4 pi, <1, c> = pi, <c,
 * c> = 2 pi / 3 and, by Funk and Hecke, <E, c> = sum of A_l E_lm Y_lm(d), best A and H of a colour
 * follow in closed form, and so does what they take off the square of the distance, A <E, 1> + H
 * <E, c>. Its sum over colours is searched for its highest place. */
struct highlight {
    int order;
    double twice[3 * SH_COUNT_MAX]; /* A_l E_lm */
    double whole[3];                /* <E, 1> */
};

static double fit_colours(const struct highlight *h, struct vec3 d, double ambient[3],
                          double light[3])
{
    double y[SH_COUNT_MAX], part[3] = {0}, gain = 0;
    sh_basis(h->order, (const double[3]){d.x, d.y, d.z}, y);
    for (int i = 0; i < h->order * h->order; i++)
        for (int k = 0; k < 3; k++)
            part[k] += y[i] * h->twice[3 * i + k];
    for (int k = 0; k < 3; k++) {
        light[k] = (part[k] - h->whole[k] / 4) * 12 / (5 * ANGLE_PI);
        ambient[k] = (h->whole[k] - ANGLE_PI * light[k]) / (4 * ANGLE_PI);
        if (light[k] < 0) {
            light[k] = 0;
            ambient[k] = h->whole[k] / (4 * ANGLE_PI);
        } else if (ambient[k] < 0) {
            light[k] = part[k] * 3 / (2 * ANGLE_PI);
            ambient[k] = 0;
        }
        light[k] = fmax(light[k], 0);
        ambient[k] = fmax(ambient[k], 0);
        gain += ambient[k] * h->whole[k] + light[k] * part[k];
    }
    return gain;
}

static void fit_highlight(const struct basis_fit *fit, const double *e, float *c)
{
    struct highlight h = {.order = fit->order};
    double ambient[3], light[3], best = -1;
    struct vec3 d = {0, 0, 1};
    for (int l = 0, i = 0; l < fit->order; l++)
        for (; i < 3 * (l + 1) * (l + 1); i++)
            h.twice[i] = sh_cosine(l) * e[i];
    for (int k = 0; k < 3; k++)
        h.whole[k] = e[k] * 3.5449077018110318; /* sqrt(4 pi) */
    for (int i = 0; i < fit->starts; i++) {
        const double gain = fit_colours(&h, fit->start[i], ambient, light);
        if (gain > best) {
            best = gain;
            d = fit->start[i];
        }
    }
    double step = 0.1;
    for (int moves = 0; step > 1e-7 && moves < 1000; moves++) { /* a compass search from there */
        const struct vec3 other = fabs(d.x) < 0.6 ? (struct vec3){1, 0, 0} : (struct vec3){0, 1, 0};
        const struct vec3 across = vec3_normalize(vec3_cross(d, other)),
                          along = vec3_cross(d, across);
        bool better = false;
        for (int way = 0; way < 4 && !better; way++) {
            const struct vec3 to =
                vec3_normalize(vec3_fma(d, way & 1 ? -step : step, way & 2 ? across : along));
            const double gain = fit_colours(&h, to, ambient, light);
            better = gain > best;
            d = better ? to : d;
            best = better ? gain : best;
        }
        if (!better)
            step /= 2;
    }
    c[6] = (float)d.x, c[7] = (float)d.y, c[8] = (float)d.z;
    fit_colours(&h, d, ambient, light);
    for (int k = 0; k < 3; k++) {
        c[k] = (float)ambient[k];
        c[3 + k] = (float)light[k];
    }
}

/* -- probes ----------------------------------------------------------------------------------- */

void basis_fit_probe(const struct basis_fit *fit, bool convolved, const float *sh, float *c)
{
    double e[3 * SH_COUNT_MAX];
    for (int l = 0, i = 0; l < fit->order; l++)
        for (; i < 3 * (l + 1) * (l + 1); i++)
            e[i] = (convolved ? 1 : sh_cosine(l)) * (double)sh[i];
    if (fit->basis == BASIS_AHD) {
        fit_highlight(fit, e, c);
        return;
    }
    for (int i = 0; i < fit->functions; i++) {
        for (int k = 0; k < 3; k++) {
            double sum = 0;
            for (int j = 0; j < fit->order * fit->order; j++)
                sum += fit->matrix[i][j] * e[3 * j + k];
            c[3 * i + k] = (float)sum;
        }
    }
}

struct probe_error {
    /* mean over directions, of the mean irradiance; negative: does not count */
    double square, worst;
};

struct job {
    const struct basis_fit *fit;
    bool convolved;
    const float *sh;
    float *value;
    struct probe_error *error; /* NULL: not asked for */
};

/* One probe's comparison. */
struct comparison {
    const struct job *job;
    const float *sh, *value;
    double area, square, worst;
};

static void compare(void *context, const double n[3], double weight)
{
    struct comparison *c = context;
    double is[3], was[3];
    basis_irradiance(c->job->fit->basis, c->value, n, is);
    sh_irradiance(c->job->fit->order, c->sh, c->job->convolved, n, was);
    const double off = fabs(luminance_f64(is) - luminance_f64(was));
    c->area += weight;
    c->square += weight * off * off;
    c->worst = fmax(c->worst, off);
}

static struct probe_error error_of(const struct job *job, const float *sh, const float *value)
{
    const double mean = luminance_f32(sh) * SH_Y00 * (job->convolved ? 1 : ANGLE_PI);
    if (!(mean > 0))
        return (struct probe_error){.square = -1};
    struct comparison c = {.job = job, .sh = sh, .value = value};
    for_directions(4, 1, compare, &c);
    return (struct probe_error){.square = c.square / c.area / (mean * mean),
                                .worst = c.worst / mean};
}

static struct error *convert_one(void *context, size_t row, int thread)
{
    (void)thread;
    const struct job *job = context;
    const size_t width = bases[job->fit->basis].width;
    const float *sh = job->sh + row * (size_t)(3 * job->fit->order * job->fit->order);
    float *value = job->value + row * width;
    if (job->error)
        job->error[row].square = -1;
    if (isnan(sh[0]))
        return NULL; /* the column is missing there as well */
    basis_fit_probe(job->fit, job->convolved, sh, value);
    for (size_t k = 0; k < width; k++)
        if (!isfinite(value[k]))
            return error_new("probe %zu: %s is beyond what 32 bits can hold", row,
                             bases[job->fit->basis].column);
    if (job->error)
        job->error[row] = error_of(job, sh, value);
    return NULL;
}

struct error *basis_convert(struct table *probes, enum basis basis, bool convolved, int threads,
                            struct basis_error *error)
{
    struct column *sh, *column;
    struct basis_fit *fit = NULL;
    struct job job = {.convolved = convolved};
    if (error)
        *error = (struct basis_error){0};
    struct error *err = table_require(probes, "sh", COLUMN_F32, 0, &sh);
    if (!err)
        err = basis_fit_create(&fit, basis, sh_order_of(sh->width));
    if (!err)
        err =
            table_add_column(probes, bases[basis].column, COLUMN_F32, bases[basis].width, &column);
    if (!err && error)
        err = array_create(&job.error, probes->rows, sizeof *job.error);
    if (!err) {
        job.fit = fit;
        job.sh = column_f32(table_column(probes, "sh"));
        job.value = column_f32(column);
        err = threads_for(threads, probes->rows, convert_one, &job);
    }
    double square = 0;
    for (size_t i = 0; error && !err && i < probes->rows; i++) {
        if (job.error[i].square < 0)
            continue;
        error->probes++;
        square += job.error[i].square;
        if (job.error[i].worst > error->worst) {
            error->worst = job.error[i].worst;
            error->worst_probe = i;
        }
    }
    if (error && error->probes)
        error->rms = sqrt(square / (double)error->probes);
    free(job.error);
    basis_fit_destroy(fit);
    return err;
}

void basis_drop(struct table *probes)
{
    for (int i = 0; i < BASIS_COUNT; i++)
        table_remove_column(probes, bases[i].column);
}
