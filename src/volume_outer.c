/* Based on:
 * Cupisz, "Light probe interpolation using tetrahedral tessellations", GDC 2012.
 * Ericson, "Real-Time Collision Detection", 2004, sec. 5.1.5: the nearest point of a triangle.
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

void volume_outer(const struct probe_volume *v, const double p[3], struct probe_place *place)
{
    struct nearest n = {.volume = v, .p = p, .square = INFINITY, .weight = {1, 0, 0}};
    volume_tree_search(&v->facet_tree, p, &n.square, try_facet, &n);
    place->distance = sqrt(n.square) * v->lattice.step;
    place_on_facet(v, n.facet, n.weight, place);
}

enum probe_status volume_outer_init(struct probe_volume *v)
{
    (void)v;
    return PROBE_OK;
}
