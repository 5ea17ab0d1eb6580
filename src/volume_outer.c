/* Based on:
 * Cupisz, "Light probe interpolation using tetrahedral tessellations", GDC 2012: a cell beyond each facet of the hull, bounded
 * by rays
 * from its corners; light is constant along rays.
 * Ericson, "Real-Time Collision Detection", 2004, sec. 5.1.5: the nearest point of a triangle.
 *
 * A corner p of the hull sends out a ray p + t n. The outer cell of a facet abc holds the points u_a (a + t n_a) + u_b (b + t
 * n_b) + u_c (c + t n_c) with
 * u >= 0, sum 1, t >= 0, and gives them the light of the facet at u. For a point P, t is a root of det(b - a + t (n_b - n_a), c
 * - a + t (n_c - n_a),
 * P - a - t n_a), a cubic; of facets whose rays are parallel, or meet in a line, a line or a quadratic.
 *
 * Which rays. Normals of the hull's corners, a mean of its facets' as Cupisz takes them, fold the outer cells over one another
 * wherever the
 * hull is nearly flat: the normals of neighbouring corners there differ by noise, so that det(n_a, n_b, n_c) has any sign, and
 * where it is below 0 the cell turns inside
 * out farther up; at the rim of a slab a mean of normals looks away from one of its facets. Rays are instead chosen such that no
 * cell folds, which is checked:
 * the Jacobian of a cell's map is linear in u for each t, so it is positive everywhere if at each corner i the quadratic J_i(t)
 * = A_i + B_i t + C t^2 is, for all t >= 0, where
 *     A_i = det(e1, e2, n_i),  B_i = det(e1, f2, n_i) + det(f1, e2, n_i),  C = det(n_a, n_b, n_c),   e: edges from a; f:
 * differences of rays from n_a.
 * If all are, every point outside has exactly one (facet, t, u): the number of its preimages, all counted with the same sign, is
 * the degree of the map, which is 1 for
 * rays that leave the hull.
 *
 * The rays are p - core(p), core(p) the nearest point of a box within the hull: those of the box's outer parallel surfaces,
 * which never meet, as the
 * box is convex. Between corners they are linear, so this is only nearly so; the box is halved until the check holds. In the end
 * it is a point c, and the rays p - c have
 * J_i(t) = (1 + t)^2 A_i > 0 for any convex hull around c.
 */
#include "volume.h"

#include <math.h>

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Nearest point of triangle abc (whose corners may fall together) to p, as barycentric weights. Returns the squared distance. */
static double nearest_on_triangle(const double p[3], const double a[3], const double b[3], const double c[3], double w[3])
{
    double ab[3], ac[3], ap[3], bp[3], cp[3];
    for (int k = 0; k < 3; k++) {
        ab[k] = b[k] - a[k];
        ac[k] = c[k] - a[k];
        ap[k] = p[k] - a[k];
        bp[k] = p[k] - b[k];
        cp[k] = p[k] - c[k];
    }
    const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp), d6 = dot(ac, cp);
    const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2, sum = va + vb + vc;
    w[0] = w[1] = w[2] = 0;
    if (d1 <= 0 && d2 <= 0) {
        w[0] = 1;
    } else if (d3 >= 0 && d4 <= d3) {
        w[1] = 1;
    } else if (d6 >= 0 && d5 <= d6) {
        w[2] = 1;
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        w[1] = d1 / (d1 - d3);
        w[0] = 1 - w[1];
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        w[2] = d2 / (d2 - d6);
        w[0] = 1 - w[2];
    } else if ((va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) || !(sum > 0)) {
        const double whole = d4 - d3 + d5 - d6;
        w[2] = whole > 0 ? (d4 - d3) / whole : 0;
        w[1] = 1 - w[2];
    } else {
        w[1] = vb / sum;
        w[2] = vc / sum;
        w[0] = 1 - w[1] - w[2];
    }
    double total = 0;
    for (int k = 0; k < 3; k++) { /* rounding may leave a weight a little below 0 */
        w[k] = w[k] > 0 ? w[k] : 0;
        total += w[k];
    }
    double d[3];
    for (int k = 0; k < 3; k++)
        w[k] /= total;
    for (int k = 0; k < 3; k++)
        d[k] = w[0] * a[k] + w[1] * b[k] + w[2] * c[k] - p[k];
    return dot(d, d);
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
    const double square = nearest_on_triangle(n->p, volume_site(n->volume, vertex[0]), volume_site(n->volume, vertex[1]),
                                              volume_site(n->volume, vertex[2]), w);
    if (!(square < n->square))
        return;
    n->square = square;
    n->facet = facet;
    for (int k = 0; k < 3; k++)
        n->weight[k] = w[k];
}

/* A facet's corners with their weights, as a place in its cell. */
static void place_on_facet(const struct probe_volume *v, size_t facet, const double weight[3], struct probe_place *place)
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

/* -- rays ---------------------------------------------------------------------------------------- */

/* det(a, b, c) */
static double det(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

void volume_outer_ray(const struct probe_volume *v, int32_t probe, double ray[3])
{
    for (int k = 0; k < 3; k++) {
        const double x = volume_site(v, probe)[k] - v->centre[k], most = v->core[k];
        ray[k] = x > most ? x - most : x < -most ? x + most : 0;
    }
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

static bool unfolded(const struct prism *s)
{
    double size = 0;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            size = fmax(size, fabs(s->n[i][k]));
    const double c = det(s->n[0], s->n[1], s->n[2]), noise = 1e-14 * size * size * size;
    if (c < -noise)
        return false;
    for (int i = 0; i < 3; i++) {
        const double a = det(s->e[0], s->e[1], s->n[i]), b = det(s->e[0], s->f[1], s->n[i]) + det(s->f[0], s->e[1], s->n[i]);
        if (!(a > 0) || (b < 0 && !(b * b < 4 * a * c * (1 - 1e-6))))
            return false;
    }
    return true;
}

/* The middle of all cells, and the share of the box of all sites around it (as far as it reaches to every side) that is within
 * the hull. */
static double find_core(const struct probe_volume *v, double centre[3], double half[3])
{
    double total = 0, share = 1;
    centre[0] = centre[1] = centre[2] = 0;
    for (size_t i = 0; i < v->cells; i++) {
        const double *s[4];
        double e[3][3];
        for (int c = 0; c < 4; c++)
            s[c] = volume_site(v, volume_vertex(v, i, c));
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < 3; k++)
                e[c][k] = s[c + 1][k] - s[0][k];
        const double volume = det(e[0], e[1], e[2]);
        total += volume;
        for (int k = 0; k < 3; k++)
            centre[k] += volume * (s[0][k] + s[1][k] + s[2][k] + s[3][k]) / 4;
    }
    for (int k = 0; k < 3; k++) {
        centre[k] /= total;
        half[k] = fmin(centre[k] - v->low[k], v->high[k] - centre[k]);
    }
    for (size_t i = 0; i < v->facets; i++) {
        int32_t vertex[3];
        double e[2][3], n[3], away = 0, reach = 0;
        volume_facet_vertex(v, &v->facet[i], vertex);
        const double *a = volume_site(v, vertex[0]);
        for (int c = 0; c < 2; c++)
            for (int k = 0; k < 3; k++)
                e[c][k] = volume_site(v, vertex[c + 1])[k] - a[k];
        for (int k = 0; k < 3; k++) {
            n[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
            away += n[k] * (a[k] - centre[k]);
            reach += fabs(n[k]) * half[k];
        }
        share = fmin(share, away / reach);
    }
    return share;
}

void volume_outer_init(struct probe_volume *v)
{
    enum { HALVINGS = 5 };
    double half[3];
    if (!v->convex)
        return;
    const double share = find_core(v, v->centre, half);
    for (int attempt = 0; attempt <= HALVINGS && !v->rays && share > 0; attempt++) {
        for (int k = 0; k < 3; k++)
            v->core[k] = attempt == HALVINGS ? 0 : 0.75 * share / (1 << attempt) * half[k];
        v->rays = true;
        for (size_t i = 0; i < v->facets && v->rays; i++) {
            struct prism s;
            make_prism(v, i, &s);
            v->rays = unfolded(&s);
        }
    }
}

/* -- the outer cell of a point ------------------------------------------------------------------- */

static double cubic(const double c[4], double t)
{
    return ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
}

/* The root between two places where the signs differ. */
static double bisect(const double c[4], double low, double high)
{
    const bool rising = cubic(c, low) < 0;
    for (int i = 0; i < 200; i++) {
        const double middle = low + (high - low) / 2;
        if (!(middle > low && middle < high))
            break;
        if ((cubic(c, middle) < 0) == rising)
            low = middle;
        else
            high = middle;
    }
    return low + (high - low) / 2;
}

/* The roots t >= 0 of a cubic, ascending; returns how many. Between its turning points it is monotone. */
static int roots(const double c[4], double root[3])
{
    double turn[4] = {0, INFINITY, INFINITY, INFINITY};
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
        if (!(high < INFINITY)) { /* the last stretch: as far as the sign stays */
            high = low > 0 ? 2 * low : 1;
            for (int k = 0; k < 400 && (cubic(c, high) < 0) == (cubic(c, low) < 0); k++)
                high *= 2;
        }
        if (cubic(c, low) == 0)
            root[count++] = low;
        else if ((cubic(c, low) < 0) != (cubic(c, high) < 0) && isfinite(high))
            root[count++] = bisect(c, low, high);
    }
    return count;
}

/* How well the outer cell of a facet holds a point. */
struct hold {
    double off;       /* how far p's place is from the facet, moved to where p is in its plane: 0 within it, lattice units. A distance, as weights alone are noise in
                       * facets that are slivers */
    double weight[3]; /* brought to >= 0 */
    int beyond;       /* the corner whose weight is least: across the edge opposite to go on */
};

/* Weights >= 0 from w: of x itself, or of the nearest point of the edges of (0, a, b), whose distance is returned. */
static double bring_within(const double x[3], const double a[3], const double b[3], const double w[3], double weight[3])
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

static struct hold solve(const struct probe_volume *v, size_t facet, const double p[3])
{
    struct hold best = {.off = INFINITY, .weight = {1, 0, 0}, .beyond = -1};
    struct prism s;
    make_prism(v, facet, &s);
    double q[3], t[3];
    for (int k = 0; k < 3; k++)
        q[k] = p[k] - s.p[0][k];
    const double *e1 = s.e[0], *e2 = s.e[1], *f1 = s.f[0], *f2 = s.f[1], *n = s.n[0];
    const double c[4] = {det(e1, e2, q), det(f1, e2, q) + det(e1, f2, q) - det(e1, e2, n), det(f1, f2, q) - det(f1, e2, n) - det(e1, f2, n),
                         -det(f1, f2, n)};
    const int count = roots(c, t);
    for (int r = 0; r < count; r++) {
        double x[3], u1[3], u2[3], normal[3], w[3];
        struct hold here;
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
        if (here.off < best.off)
            best = here;
    }
    return best;
}

/* From the facet nearest to p to the one whose outer cell holds it. Steps are counted; where they do not arrive, all facets are
 * tried, so it ends. */
static void find_prism(const struct probe_volume *v, const double p[3], size_t *found, double weight[3])
{
    double size = 0;
    for (int k = 0; k < 3; k++)
        size = fmax(size, fmax(v->high[k] - v->low[k], fabs(p[k])));
    const double rounding = 1e-9 * size;
    size_t facet = *found;
    struct hold hold = {.off = INFINITY};
    for (int step = 0; step < 64; step++) {
        hold = solve(v, facet, p);
        if (hold.off <= rounding || hold.beyond < 0 || v->facet[facet].across[hold.beyond] < 0)
            break;
        facet = (size_t)v->facet[facet].across[hold.beyond];
    }
    for (size_t i = 0; i < v->facets && !(hold.off <= rounding); i++) {
        const struct hold other = solve(v, i, p);
        if (!(other.off < hold.off))
            continue;
        hold = other;
        facet = i;
    }
    if (!(hold.off < INFINITY))
        return; /* no facet has a root: p is on the hull but for rounding */
    *found = facet;
    for (int k = 0; k < 3; k++)
        weight[k] = hold.weight[k];
}

void volume_outer(const struct probe_volume *v, const double p[3], struct probe_place *place)
{
    struct nearest n = {.volume = v, .p = p, .square = INFINITY, .weight = {1, 0, 0}};
    volume_tree_search(&v->facet_tree, p, &n.square, try_facet, &n);
    if (v->rays && n.square > 1) /* nearer to the hull than a step of the lattice, rounding decides which side p is on */
        find_prism(v, p, &n.facet, n.weight);
    place->distance = sqrt(n.square) * v->lattice.step;
    place_on_facet(v, n.facet, n.weight, place);
}
