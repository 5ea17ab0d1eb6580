/* SPDX-License-Identifier: Apache-2.0 */
/* Based on:
 * Cupisz, "Light probe interpolation using tetrahedral tessellations", GDC 2012: a cell beyond each
 * facet of the hull, bounded by rays from its corners; light is constant along rays. van Oosterom,
 * Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 30(2), 1983.
 *
 * A corner p of the hull sends out a ray p + t n. The outer cell of a facet abc holds the points
 * u_a (a + t n_a) + u_b (b + t n_b) + u_c (c + t n_c) with u >= 0, sum 1, t >= 0, and gives them
 * the light of the facet at u. For a point P, t is a root of det(b - a + t (n_b - n_a), c - a + t
 * (n_c - n_a), P - a - t n_a), a cubic; of facets whose rays are parallel, or meet in a line, a
 * line or a quadratic.
 *
 * Which rays. Normals of the hull's corners, a mean of its facets' as Cupisz takes them, fold the
 * outer cells over one another wherever the hull is nearly flat: the normals of neighbouring
 * corners there differ by noise, so that det(n_a, n_b, n_c) has any sign, and where it is below 0
 * the cell turns inside out farther up; at the rim of a slab a mean of normals looks away from one
 * of its facets. Rays are instead chosen such that no cell folds, which is checked: the Jacobian of
 * a cell's map is linear in u for each t, so it is positive everywhere if at each corner i the
 * quadratic J_i(t) = A_i + B_i t + C t^2 is, for all t >= 0, where
 *
 *     A_i = det(e1, e2, n_i),  B_i = det(e1, f2, n_i) + det(f1, e2, n_i),  C = det(n_a, n_b, n_c),
 *
 * e: edges from a; f: differences of rays from n_a.
 *
 * The rays are p - core(p), core(p) the nearest point of a box within the hull: those of the box's
 * outer parallel surfaces, which never meet, as the box is convex. Between corners they are linear,
 * so this is only nearly so; the box is halved until the check holds. In the end it is a point c,
 * and the rays p - c have J_i(t) = (1 + t)^2 A_i, above 0 for any hull that c sees all of. The box
 * lies along the lattice's axes, or along those of the mesh's second moments where it is much
 * larger so: of a slab or a row of probes that is turned.
 *
 * Why each point is then in one cell, dents or not. Take all cells, inner ones mapped identically
 * and outer ones by p + t n, as one map of a space into R^3. Inner cells have positive volumes,
 * outer ones a positive Jacobian, and all walls between are shared, those between outer cells
 * because the hull is closed. So the number of preimages of a point does not change across walls,
 * and is the same everywhere: the degree of the map, as far out as one likes. There only outer
 * cells are, and they go around as often as the directions n do around the origin. n(p) is p less a
 * point of the core; where the hull does not touch the core that point can be moved to the core's
 * centre, and n never is 0 on the way: the degree is how often the hull winds around the centre,
 * which is measured, and must be 1. That the hull is of one piece, or simply connected, need not be
 * asked: a hollow within has facets which the centre sees from behind, where J < 0, and what lies
 * beside it has them on its near side.
 *
 * Where to look. What the map p -> image(p), to a parallel surface of the core, makes of a ray is
 * nearly one point. So the facet whose image is nearest to that of a point is the one whose outer
 * cell holds it, or a step or two away.
 */
#include "volume.h"

#include <math.h>
#include <stdlib.h>

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* det(a, b, c) */
static double det(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* Weights >= 0 from w: of x itself, or of the nearest point of the edges of (0, a, b), whose
 * distance is returned. */
static double bring_within(const double x[3], const double a[3], const double b[3],
                           const double w[3], double weight[3])
{
    static const double origin[3] = {0, 0, 0};
    const double *corner[3] = {origin, a, b};
    for (int i = 0; i < 3; i++)
        weight[i] = w[i];
    if (w[0] >= 0 && w[1] >= 0 && w[2] >= 0)
        return 0;
    double least = INFINITY;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3;
        double edge[3], from[3], off[3];
        for (int k = 0; k < 3; k++) {
            edge[k] = corner[j][k] - corner[i][k];
            from[k] = x[k] - corner[i][k];
        }
        const double along = fmin(fmax(dot(from, edge) / dot(edge, edge), 0), 1);
        for (int k = 0; k < 3; k++)
            off[k] = from[k] - along * edge[k];
        const double square = dot(off, off);
        if (!(square < least))
            continue;
        least = square;
        weight[i] = 1 - along;
        weight[j] = along;
        weight[3 - i - j] = 0;
    }
    return sqrt(least);
}

/* Nearest point of triangle abc (whose corners may fall together) to p, as barycentric weights:
 * those of p's foot in the plane, or of the nearest point of an edge. Returns the squared
 * distance. */
static double nearest_on_triangle(const double p[3], const double a[3], const double b[3],
                                  const double c[3], double weight[3])
{
    double ab[3], ac[3], ap[3], normal[3], w[3], square = 0;
    for (int k = 0; k < 3; k++) {
        ab[k] = b[k] - a[k];
        ac[k] = c[k] - a[k];
        ap[k] = p[k] - a[k];
    }
    for (int k = 0; k < 3; k++)
        normal[k] = ab[(k + 1) % 3] * ac[(k + 2) % 3] - ab[(k + 2) % 3] * ac[(k + 1) % 3];
    /* by the normal: products of edges alone cancel in slivers */
    w[1] = det(ap, ac, normal) / dot(normal, normal);
    w[2] = det(ab, ap, normal) / dot(normal, normal);
    w[0] = 1 - w[1] - w[2];
    bring_within(ap, ab, ac, w, weight);
    for (int k = 0; k < 3; k++) {
        const double d = ap[k] - weight[1] * ab[k] - weight[2] * ac[k];
        square += d * d;
    }
    return square;
}

struct nearest {
    const struct probe_volume *volume;
    const double *p;
    double square, weight[3];
    size_t facet;
};

static void try_facet(void *context, size_t facet)
{
    struct nearest *n = context;
    int32_t vertex[3];
    double w[3];
    volume_facet_vertex(n->volume, &n->volume->facet[facet], vertex);
    const double square = nearest_on_triangle(n->p, volume_span_site(n->volume, vertex[0]),
                                              volume_span_site(n->volume, vertex[1]),
                                              volume_span_site(n->volume, vertex[2]), w);
    if (!(square < n->square))
        return;
    n->square = square;
    n->facet = facet;
    for (int k = 0; k < 3; k++)
        n->weight[k] = w[k];
}

/* A facet's corners with their weights, as a place in its cell. */
static void place_on_facet(const struct probe_volume *v, size_t facet, const double weight[3],
                           struct probe_place *place)
{
    const size_t cell = (size_t)v->facet[facet].cell;
    double w[4] = {0};
    int32_t vertex[3];
    volume_facet_vertex(v, &v->facet[facet], vertex);
    for (int i = 0; i < v->corners; i++)
        for (int k = 0; k < 3; k++)
            w[i] += volume_vertex(v, cell, i) == vertex[k] ? weight[k] : 0;
    volume_place(v, cell, w, place);
}

/* -- rays ------------------------------------------------------------------------------------- */

static double beyond(double x, double most)
{
    return x > most ? x - most : x < -most ? x + most : 0;
}

void volume_outer_ray(const struct probe_volume *v, int32_t probe, double ray[3])
{
    double d[3];
    for (int k = 0; k < 3; k++)
        d[k] = volume_site(v, probe)[k] - v->centre[k];
    if (!v->turned) {
        for (int k = 0; k < 3; k++)
            ray[k] = beyond(d[k], v->core[k]);
        return;
    }
    double x[3];
    for (int k = 0; k < 3; k++)
        x[k] = beyond(dot(v->core_axis[k], d), v->core[k]);
    for (int k = 0; k < 3; k++)
        ray[k] = x[0] * v->core_axis[0][k] + x[1] * v->core_axis[1][k] + x[2] * v->core_axis[2][k];
}

/* p moved along the line from the nearest point of the core to the core's parallel surface at the
 * size of the hull: about the same for all of a ray, and another for each ray. */
static void image_of(const struct probe_volume *v, const double p[3], double image[3])
{
    double d[3], off[3], size = 0, square = 0;
    for (int k = 0; k < 3; k++) {
        d[k] = p[k] - v->centre[k];
        size = fmax(size, v->high[k] - v->low[k]);
    }
    for (int k = 0; k < 3; k++) {
        const double x = v->turned ? dot(v->core_axis[k], d) : d[k];
        off[k] = beyond(x, v->core[k]);
        image[k] = x - off[k];
        square += off[k] * off[k];
    }
    for (int k = 0; k < 3 && square > 0; k++)
        image[k] += off[k] * (size / sqrt(square));
}

static enum probe_status make_images(struct probe_volume *v)
{
    const enum probe_status status = volume_tree_init(&v->image_tree, v->facets);
    for (size_t i = 0; !status && i < v->facets; i++) {
        int32_t vertex[3];
        double middle[3] = {0}, image[3];
        volume_facet_vertex(v, &v->facet[i], vertex);
        for (int c = 0; c < 9; c++)
            middle[c % 3] += volume_site(v, vertex[c / 3])[c % 3] / 3;
        image_of(v, middle, image);
        volume_tree_add(&v->image_tree, i, image);
        for (int k = 0; k < 3; k++)
            v->facet[i].image[k] = (float)image[k];
    }
    if (!status)
        volume_tree_finish(&v->image_tree);
    return status;
}

/* A facet with its rays: corners p, rays n, edges e and differences of rays f from corner 0. */
struct prism {
    double p[3][3], n[3][3], e[2][3], f[2][3];
};

static void make_prism(const struct probe_volume *v, size_t facet, struct prism *s)
{
    int32_t vertex[3];
    volume_facet_vertex(v, &v->facet[facet], vertex);
    for (int i = 0; i < 3; i++) {
        volume_outer_ray(v, vertex[i], s->n[i]);
        for (int k = 0; k < 3; k++)
            s->p[i][k] = volume_site(v, vertex[i])[k];
    }
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 3; k++) {
            s->e[i][k] = s->p[i + 1][k] - s->p[0][k];
            s->f[i][k] = s->n[i + 1][k] - s->n[0][k];
        }
}

/* det(a, b, c), and how far rounding may have put it off. */
static double det_within(const double a[3], const double b[3], const double c[3], double *error)
{
    double size = 0;
    for (int k = 0; k < 3; k++)
        size += fabs(a[k]) *
                (fabs(b[(k + 1) % 3] * c[(k + 2) % 3]) + fabs(b[(k + 2) % 3] * c[(k + 1) % 3]));
    *error = 0x1p-49 * size;
    return det(a, b, c);
}

/* A is certainly above 0. C, of flat facets often 0, counts as that within rounding: it tells on
 * the sign only from 2^40 sizes away. */
static bool unfolded(const struct prism *s)
{
    double error;
    const double c = det_within(s->n[0], s->n[1], s->n[2], &error);
    if (c < -error)
        return false;
    for (int i = 0; i < 3; i++) {
        const double a = det_within(s->e[0], s->e[1], s->n[i], &error),
                     b = det(s->e[0], s->f[1], s->n[i]) + det(s->f[0], s->e[1], s->n[i]);
        if (!(a > error) || (b < 0 && !(b * b < 4 * a * c * (1 - 1e-6))))
            return false;
    }
    return true;
}

/* -- the core --------------------------------------------------------------------------------- */

/* A box: half[k] to either side of centre along axis[k]. */
struct core {
    double centre[3], axis[3][3], half[3];
};

/* A cell's corners as seen from a point, and their sum; returns 6 times its volume. */
static double cell_from(const struct probe_volume *v, size_t cell, const double from[3],
                        double d[4][3], double sum[3])
{
    double e[3][3];
    sum[0] = sum[1] = sum[2] = 0;
    for (int c = 0; c < 4; c++)
        for (int k = 0; k < 3; k++)
            sum[k] += d[c][k] = volume_site(v, volume_vertex(v, cell, c))[k] - from[k];
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
            e[c][k] = d[c + 1][k] - d[0][k];
    return det(e[0], e[1], e[2]);
}

/* The middle of all cells, and the second moments about it. */
static void find_middle(const struct probe_volume *v, double middle[3], double moment[3][3])
{
    static const double origin[3] = {0, 0, 0};
    double d[4][3], all[3], total = 0, sum[3] = {0};
    for (size_t i = 0; i < v->cells; i++) {
        const double volume = cell_from(v, i, origin, d, all);
        total += volume;
        for (int k = 0; k < 3; k++)
            sum[k] += volume * all[k] / 4;
    }
    for (int k = 0; k < 3; k++)
        middle[k] = sum[k] / total;
    for (size_t i = 0; i < v->cells; i++) {
        const double share = cell_from(v, i, middle, d, all) / total;
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++)
                moment[j][k] += share / 20 *
                                (d[0][j] * d[0][k] + d[1][j] * d[1][k] + d[2][j] * d[2][k] +
                                 d[3][j] * d[3][k] + all[j] * all[k]);
    }
}

/* The mean of the probes on the hull and within, each once: what probe-tet keeps in sight of the
 * whole hull (peel.h). */
static bool find_mean(const struct probe_volume *v, double mean[3])
{
    unsigned char *seen = calloc(v->probes ? v->probes : 1, 1);
    double count = 0;
    if (!seen)
        return false;
    mean[0] = mean[1] = mean[2] = 0;
    for (size_t i = 0; i < 4 * v->cells; i++) {
        const int32_t probe = volume_vertex(v, i / 4, (int)(i % 4));
        for (int k = 0; k < 3 && !seen[probe]; k++)
            mean[k] += volume_site(v, probe)[k];
        count += !seen[probe];
        seen[probe] = 1;
    }
    for (int k = 0; k < 3; k++)
        mean[k] /= count;
    free(seen);
    return true;
}

/* Corners of a facet from the core's centre, along its axes. */
static void along_axes(const struct probe_volume *v, size_t facet, const struct core *core,
                       double x[3][3])
{
    int32_t vertex[3];
    volume_facet_vertex(v, &v->facet[facet], vertex);
    for (int i = 0; i < 3; i++) {
        double d[3];
        for (int k = 0; k < 3; k++)
            d[k] = volume_site(v, vertex[i])[k] - core->centre[k];
        for (int k = 0; k < 3; k++)
            x[i][k] = dot(core->axis[k], d);
    }
}

/* The largest scale at which a box is apart from a facet: by one of the box's axes, or by the
 * facet's normal. */
static double separation(double x[3][3], const double half[3])
{
    double e[2][3], n[3], away = 0, reach = 0, best = 0;
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 3; k++)
            e[i][k] = x[i + 1][k] - x[0][k];
    for (int k = 0; k < 3; k++) {
        n[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
        away += n[k] * x[0][k];
        reach += fabs(n[k]) * half[k];
        const double low = fmin(fmin(x[0][k], x[1][k]), x[2][k]),
                     high = fmax(fmax(x[0][k], x[1][k]), x[2][k]);
        best = fmax(best, fmax(low, -high) / half[k]);
    }
    return fmax(best, away / reach);
}

/* Makes a box as far from its centre as the hull reaches along each axis, scaled until it does not
 * touch the hull. Returns its volume. */
static double fit_core(const struct probe_volume *v, struct core *core)
{
    double x[3][3], low[3] = {0}, high[3] = {0}, share = 1;
    for (size_t i = 0; i < v->facets; i++) {
        along_axes(v, i, core, x);
        for (int c = 0; c < 9; c++) {
            low[c % 3] = fmin(low[c % 3], x[c / 3][c % 3]);
            high[c % 3] = fmax(high[c % 3], x[c / 3][c % 3]);
        }
    }
    for (int k = 0; k < 3; k++)
        core->half[k] = fmin(-low[k], high[k]);
    for (size_t i = 0; i < v->facets; i++) {
        along_axes(v, i, core, x);
        share = fmin(share, separation(x, core->half));
    }
    share = share > 0 ? share : 0; /* NaN: the hull does not even go around the centre */
    for (int k = 0; k < 3; k++)
        core->half[k] *= share;
    return core->half[0] * core->half[1] * core->half[2];
}

/* How often the hull winds around the core's centre: the solid angles of its facets (van Oosterom
 * and Strackee 1983), over a sphere's. */
static int winding(const struct probe_volume *v)
{
    double sum = 0;
    for (size_t i = 0; i < v->facets; i++) {
        int32_t vertex[3];
        double x[3][3], length[3];
        volume_facet_vertex(v, &v->facet[i], vertex);
        for (int c = 0; c < 3; c++) {
            for (int k = 0; k < 3; k++)
                x[c][k] = volume_site(v, vertex[c])[k] - v->centre[k];
            length[c] = sqrt(dot(x[c], x[c]));
        }
        sum += 2 * atan2(det(x[0], x[1], x[2]),
                         length[0] * length[1] * length[2] + dot(x[0], x[1]) * length[2] +
                             dot(x[1], x[2]) * length[0] + dot(x[2], x[0]) * length[1]);
    }
    return (int)rint(sum / (4 * 3.14159265358979323846));
}

/* Takes a core, scaled, if no outer cell folds. */
static void try_core(struct probe_volume *v, const struct core *core, double scale)
{
    v->turned = false;
    for (int k = 0; k < 3; k++) {
        v->centre[k] = core->centre[k];
        v->core[k] = scale * core->half[k];
        for (int j = 0; j < 3; j++) {
            v->core_axis[k][j] = core->axis[k][j];
            v->turned = v->turned || (scale > 0 && core->axis[k][j] != (j == k));
        }
    }
    v->rays = true;
    for (size_t i = 0; i < v->facets && v->rays; i++) {
        struct prism s;
        make_prism(v, i, &s);
        v->rays = unfolded(&s);
    }
    v->rays = v->rays && winding(v) == 1;
}

enum probe_status volume_outer_init(struct probe_volume *v)
{
    enum {
        HALVINGS = 5, /* of the core, before it is a point */
        /* of them, for rays that are not asked for: those of a small core run along the hull rather
         * than away from it, and bring its light from afar */
        UNASKED = 2,
        /* times the volume that a turned core must have: even of a cube along its diagonal it is
         * 5 */
        TURNED = 8,
    };
    struct core core = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, turned;
    double moment[3][3] = {{0}};
    if (!v->closed)
        return PROBE_OK;
    find_middle(v, core.centre, moment);
    turned = core;
    span_axes(moment, turned.axis);
    const double volume = fit_core(v, &core);
    if (fit_core(v, &turned) > TURNED * volume)
        core = turned;
    const bool asked = v->flags & PROBE_EXTEND;
    for (int attempt = 0; attempt <= (asked ? HALVINGS : UNASKED) && !v->rays; attempt++)
        try_core(v, &core, attempt == HALVINGS ? 0 : 0.75 / (1 << attempt));
    if (!asked && !v->rays)
        return PROBE_OK;
    if (!v->rays && !find_mean(v, core.centre))
        return PROBE_NO_MEMORY;
    if (!v->rays)
        try_core(v, &core, 0);
    return v->rays ? make_images(v) : PROBE_OK;
}

/* -- the outer cell of a point ---------------------------------------------------------------- */

static double cubic(const double c[4], double t)
{
    return ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
}

/* The root between two places where the signs differ: Newton's steps, and a half's where they would
 * leave what is between. */
static double root_between(const double c[4], double low, double high)
{
    const bool rising = cubic(c, low) < 0;
    double t = low + (high - low) / 2;
    for (int i = 0; i < 200; i++) {
        const double value = cubic(c, t), slope = (3 * c[3] * t + 2 * c[2]) * t + c[1];
        if ((value < 0) == rising)
            low = t;
        else
            high = t;
        double next = t - value / slope;
        if (!(next > low && next < high))
            next = low + (high - low) / 2;
        const bool still = !(fabs(next - t) > 0x1p-52 * t);
        t = next;
        if (still)
            break;
    }
    return t;
}

/* The roots t >= 0 of a cubic, ascending; returns how many. Between its turning points it is
 * monotone. */
static int roots(const double c[4], double root[3])
{
    double turn[4] = {0, INFINITY, INFINITY, INFINITY};
    /* its sign is that far out */
    const double last = c[3] != 0 ? c[3] : c[2] != 0 ? c[2] : c[1] != 0 ? c[1] : c[0];
    int turns = 1, count = 0;
    const double a = 3 * c[3], b = c[2], d = b * b - a * c[1]; /* a t^2 + 2 b t + c1 = 0 */
    if (d > 0) {
        const double q = -(b + (b < 0 ? -sqrt(d) : sqrt(d))), first = q / a, second = c[1] / q;
        const double low = fmin(first, second), high = fmax(first, second);
        if (low > 0 && low < INFINITY)
            turn[turns++] = low;
        if (high > 0 && high < INFINITY && high > low)
            turn[turns++] = high;
    } else if (a == 0 && b != 0 && -c[1] / (2 * b) > 0) {
        turn[turns++] = -c[1] / (2 * b);
    }
    for (int i = 0; i < turns; i++) {
        const double low = turn[i];
        double high = turn[i + 1];
        /* the last stretch: as far as the sign stays, if it changes at all */
        if (!(high < INFINITY)) {
            if ((last < 0) == (cubic(c, low) < 0) && cubic(c, low) != 0)
                break;
            high = low > 0 ? 2 * low : 1;
            for (int k = 0; k < 400 && (cubic(c, high) < 0) == (cubic(c, low) < 0); k++)
                high *= 2;
        }
        if (cubic(c, low) == 0)
            root[count++] = low;
        else if ((cubic(c, low) < 0) != (cubic(c, high) < 0) && isfinite(high))
            root[count++] = root_between(c, low, high);
    }
    return count;
}

/* How well the outer cell of a facet holds a point. */
struct hold {
    /* how far p's place is from the facet, moved to where p is in its plane: 0 within it, lattice
     * units. A distance, as weights alone are noise in facets that are slivers */
    double off;
    double weight[3]; /* brought to >= 0 */
    double t;         /* along the rays */
    int beyond;       /* the corner whose weight is least: across the edge opposite to go on */
};

static struct hold solve(const struct probe_volume *v, size_t facet, const double p[3])
{
    struct hold best = {.off = INFINITY, .weight = {1, 0, 0}, .beyond = -1};
    struct prism s;
    make_prism(v, facet, &s);
    double q[3], t[3];
    for (int k = 0; k < 3; k++)
        q[k] = p[k] - s.p[0][k];
    const double *e1 = s.e[0], *e2 = s.e[1], *f1 = s.f[0], *f2 = s.f[1], *n = s.n[0];
    const double c[4] = {det(e1, e2, q), det(f1, e2, q) + det(e1, f2, q) - det(e1, e2, n),
                         det(f1, f2, q) - det(f1, e2, n) - det(e1, f2, n), -det(f1, f2, n)};
    int count = roots(c, t);
    const bool before = count == 0; /* p is on the other side of the facet: but where from it? */
    if (before)
        t[count++] = 0;
    for (int r = 0; r < count; r++) {
        double x[3], u1[3], u2[3], normal[3], w[3];
        struct hold here = {.t = t[r]};
        for (int k = 0; k < 3; k++) {
            u1[k] = e1[k] + t[r] * f1[k];
            u2[k] = e2[k] + t[r] * f2[k];
            x[k] = q[k] - t[r] * n[k];
        }
        for (int k = 0; k < 3; k++)
            normal[k] = u1[(k + 1) % 3] * u2[(k + 2) % 3] - u1[(k + 2) % 3] * u2[(k + 1) % 3];
        w[1] = det(x, u2, normal) / dot(normal, normal);
        w[2] = det(u1, x, normal) / dot(normal, normal);
        w[0] = 1 - w[1] - w[2];
        here.beyond = w[0] <= w[1] ? (w[0] <= w[2] ? 0 : 2) : (w[1] <= w[2] ? 1 : 2);
        here.off = bring_within(x, u1, u2, w, here.weight);
        if (before)
            here.off = INFINITY;
        if (before || here.off < best.off)
            best = here;
        if (before && w[here.beyond] >= 0)
            best.beyond = -1;
    }
    return best;
}

/* How far p is from its place beyond a facet. */
static double miss(const struct probe_volume *v, size_t facet, const struct hold *hold,
                   const double p[3])
{
    struct prism s;
    double off[3] = {-p[0], -p[1], -p[2]};
    make_prism(v, facet, &s);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            off[k] += hold->weight[i] * (s.p[i][k] + hold->t * s.n[i][k]);
    return sqrt(dot(off, off));
}

/* The facet whose image is nearest. */
struct image {
    const struct volume_facet *facet;
    const double *p;
    double square;
    size_t nearest;
};

static void try_image(void *context, size_t facet)
{
    struct image *n = context;
    double square = 0;
    for (int k = 0; k < 3; k++) {
        const double d = (double)n->facet[facet].image[k] - n->p[k];
        square += d * d;
    }
    if (!(square < n->square))
        return;
    n->square = square;
    n->nearest = facet;
}

/* Looking through all facets, those first whose images are near that of p. */
struct through {
    const struct probe_volume *volume;
    const double *p;
    double square; /* how far images may be away */
    double rounding;
    size_t facet;
    struct hold hold;
};

static void try_prism(void *context, size_t facet)
{
    struct through *t = context;
    const struct hold here = solve(t->volume, facet, t->p);
    if (!(t->square >= 0 && here.off < t->hold.off))
        return;
    t->hold = here;
    t->facet = facet;
    if (here.off <= t->rounding)
        t->square = -1;
}

/* The facet whose outer cell holds p: a walk from one whose image is near that of p. Steps are
 * counted; where they do not arrive, all facets are tried, so it ends. Returns false when no facet
 * has a root: p is on the hull but for rounding. */
static bool find_prism(const struct probe_volume *v, const double p[3], size_t *facet,
                       struct hold *hold)
{
    double size = 0, image[3];
    for (int k = 0; k < 3; k++)
        size = fmax(size, fmax(v->high[k] - v->low[k], fabs(p[k])));
    const double rounding = 1e-9 * size;
    image_of(v, p, image);
    struct image nearest = {.facet = v->facet, .p = image, .square = INFINITY};
    volume_tree_search(&v->image_tree, image, &nearest.square, try_image, &nearest);
    *facet = nearest.nearest;
    for (int step = 0; step < 64; step++) {
        *hold = solve(v, *facet, p);
        if (hold->off <= rounding)
            return true;
        if (hold->beyond < 0)
            break;
        *facet = (size_t)v->facet[*facet].across[hold->beyond];
    }
    struct through t = {.volume = v,
                        .p = p,
                        .square = INFINITY,
                        .rounding = rounding,
                        .facet = *facet,
                        .hold = {.off = INFINITY}};
    volume_tree_search(&v->image_tree, image, &t.square, try_prism, &t);
    *facet = t.facet;
    *hold = t.hold;
    return hold->off < INFINITY;
}

/* How far p is from a place, steps. */
static double distance_from(const struct probe_volume *v, const struct probe_place *place,
                            const double p[3])
{
    double off[3] = {-p[0], -p[1], -p[2]};
    for (int c = 0; c < 3 * v->corners; c++)
        off[c % 3] += place->weight[c / 3] * volume_site(v, place->probe[c / 3])[c % 3];
    return sqrt(dot(off, off));
}

/* Whether p is beyond the rim at the place that is nearest to it: some of it is open there, where a
 * corner has no weight, and p is on the side away from that corner. */
static bool beyond_rim(const struct probe_volume *v, size_t cell, const double weight[4],
                       const double p[3])
{
    double off[3] = {p[0], p[1], p[2]};
    for (int c = 0; c < 3 * v->corners; c++)
        off[c % 3] -= weight[c / 3] * volume_site(v, volume_vertex(v, cell, c / 3))[c % 3];
    for (int i = 0; i < v->corners; i++) {
        double inward[3], foot[3] = {0};
        if (volume_neighbour(v, cell, i) >= 0 || weight[i] > 0)
            continue;
        /* from the facet's foot of the corner: its edge's nearest point, or its other end */
        const double *a = volume_site(v, volume_vertex(v, cell, (i + 1) % v->corners)),
                     *b = volume_site(v, volume_vertex(v, cell, (i + 2) % v->corners)),
                     *c = volume_site(v, volume_vertex(v, cell, i));
        double ab[3], ac[3];
        for (int k = 0; k < 3; k++) {
            ab[k] = v->corners == 3 ? b[k] - a[k] : 0;
            ac[k] = c[k] - a[k];
        }
        const double along = v->corners == 3 ? dot(ab, ac) / dot(ab, ab) : 0;
        for (int k = 0; k < 3; k++) {
            foot[k] = along * ab[k];
            inward[k] = ac[k] - foot[k];
        }
        if (dot(off, inward) < -1e-9 * sqrt(dot(off, off) * dot(inward, inward)))
            return true;
    }
    return false;
}

bool volume_outer(const struct probe_volume *v, const double p[3], struct probe_place *place)
{
    double flat[3];
    const double *q = p; /* where facets are looked for */
    if (v->flat) {
        span_flatten(&v->frame, v->corners, p, flat);
        q = flat;
    }
    struct nearest n = {.volume = v, .p = q, .square = INFINITY, .weight = {1, 0, 0}};
    struct hold hold;
    size_t facet = 0;
    const bool held = v->rays && find_prism(v, p, &facet, &hold);
    const size_t first = held ? facet : volume_tree_near(&v->facet_tree, q);
    /* the nearer what is known, the less is searched */
    for (size_t i = first; i < v->facets && i < first + (held ? 1 : VOLUME_LEAF); i++)
        try_facet(&n, i);
    volume_tree_search(&v->facet_tree, q, &n.square, try_facet, &n);
    const double distance = sqrt(n.square);
    place->distance = distance * v->lattice.step;
    /* nearer to the hull than a step of the lattice, rounding decides which side p is on */
    if (held && distance > 1)
        place_on_facet(v, facet, hold.weight, place);
    else
        place_on_facet(v, n.facet, n.weight, place);
    if (v->flat)
        place->distance = distance_from(v, place, p) * v->lattice.step;
    if (v->bent)
        return beyond_rim(v, (size_t)v->facet[n.facet].cell, place->weight, p);
    return held && distance > 2 + 2 * miss(v, facet, &hold, p);
}
