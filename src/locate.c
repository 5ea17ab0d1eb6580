/* Based on: Cupisz, "Light probe interpolation using tetrahedral tessellations", GDC 2012: barycentric walk from the last cell. */
#include "locate.h"
#include "array.h"
#include "cell.h"
#include "error.h"
#include "lattice.h"
#include "vec.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STARTS_MOST = 4096 }; /* cells that a cold search compares */
enum { LEAF_FACES = 4, STACK_MOST = 64 };

/* A face of the hull: the face of `cell` opposite its vertex `opposite`. */
struct hull_face {
    int32_t cell;
    int8_t opposite;
};

/* A box around hull faces first .. first+count-1, or around the two nodes right_child and this + 1. */
struct hull_node {
    double low[3], high[3]; /* lattice coordinates */
    int32_t first, count;   /* count 0: an inner node */
    int32_t right_child;
};

struct locate {
    struct lattice lattice;
    double *site; /* 3 * probe_count: where the cells were made */
    size_t probe_count, cell_count;
    const int32_t *vertex, *neighbour;
    int32_t *start; /* cells spread over all, for a cold start; owned */
    size_t start_count;
    struct hull_face *face; /* ordered by the tree below */
    size_t face_count;
    struct hull_node *node; /* a tree of boxes, root first: finds the nearest hull face */
    size_t node_count;
};

static struct vec3 corner(const struct locate *l, size_t cell, int i)
{
    return vec3_load(l->site + 3 * (size_t)l->vertex[4 * cell + (size_t)i]);
}

/* -- making ----------------------------------------------------------------------------------- */

static struct error *check_cells(const struct locate *l)
{
    for (size_t cell = 0; cell < l->cell_count; cell++) {
        const int32_t *v = l->vertex + 4 * cell;
        for (size_t i = 0; i < 4; i++) {
            if (v[i] < 0 || (size_t)v[i] >= l->probe_count)
                return error_new("cell %zu: probe %d does not exist", cell, v[i]);
            const int32_t n = l->neighbour[4 * cell + i];
            if (n < -1 || n >= (int32_t)l->cell_count)
                return error_new("cell %zu: neighbour %d does not exist", cell, n);
        }
        if (lattice_orient(l->site + 3 * (size_t)v[0], l->site + 3 * (size_t)v[1], l->site + 3 * (size_t)v[2],
                           l->site + 3 * (size_t)v[3]) <= 0)
            return error_new("cell %zu (probes %d %d %d %d) has no positive volume", cell, v[0], v[1], v[2], v[3]);
    }
    return NULL;
}

/* A face's corners, in lattice coordinates. */
static void face_points(const struct locate *l, const struct hull_face *face, struct vec3 p[3])
{
    for (int k = 0; k < 3; k++)
        p[k] = corner(l, (size_t)face->cell, cell_face[face->opposite][k]);
}

static double component(struct vec3 p, int axis)
{
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

/* Three times a face's centre along an axis. */
static double face_centre(const struct locate *l, const struct hull_face *face, int axis)
{
    struct vec3 p[3];
    face_points(l, face, p);
    return component(p[0], axis) + component(p[1], axis) + component(p[2], axis);
}

/* Moves the `half` faces with the smallest centres to the front (Hoare's selection). */
static void select_half(const struct locate *l, struct hull_face *face, size_t count, size_t half, int axis)
{
    size_t low = 0, high = count - 1;
    while (low < high) {
        const double pivot = face_centre(l, &face[low + (high - low) / 2], axis);
        size_t i = low, j = high;
        while (i <= j) {
            while (face_centre(l, &face[i], axis) < pivot)
                i++;
            while (face_centre(l, &face[j], axis) > pivot)
                j--;
            if (i > j)
                break;
            const struct hull_face swap = face[i];
            face[i++] = face[j];
            face[j] = swap;
            if (j == 0)
                break;
            j--;
        }
        if (half <= j)
            high = j;
        else if (half >= i)
            low = i;
        else
            break;
    }
}

/* Builds the tree over faces first .. first+count-1 and returns its root's index. */
static size_t build_node(struct locate *l, size_t first, size_t count)
{
    const size_t index = l->node_count++;
    struct hull_node node = {.first = (int32_t)first, .count = (int32_t)count};
    int widest = 0;
    for (int axis = 0; axis < 3; axis++) {
        node.low[axis] = INFINITY;
        node.high[axis] = -INFINITY;
        for (size_t i = first; i < first + count; i++) {
            struct vec3 p[3];
            face_points(l, &l->face[i], p);
            for (int k = 0; k < 3; k++) {
                node.low[axis] = fmin(node.low[axis], component(p[k], axis));
                node.high[axis] = fmax(node.high[axis], component(p[k], axis));
            }
        }
        if (node.high[axis] - node.low[axis] > node.high[widest] - node.low[widest])
            widest = axis;
    }
    if (count > LEAF_FACES) {
        const size_t half = count / 2;
        select_half(l, l->face + first, count, half, widest);
        build_node(l, first, half);
        node.right_child = (int32_t)build_node(l, first + half, count - half);
        node.count = 0;
    }
    l->node[index] = node;
    return index;
}

static struct error *build_hull(struct locate *l)
{
    for (size_t i = 0; i < 4 * l->cell_count; i++)
        l->face_count += l->neighbour[i] < 0;
    if (!l->face_count)
        return error_new("the cells have no hull: no neighbour is -1");
    struct error *err = array_create(&l->face, l->face_count, sizeof *l->face);
    if (!err)
        err = array_create(&l->node, 2 * l->face_count, sizeof *l->node);
    if (err)
        return err;
    size_t n = 0;
    for (size_t i = 0; i < 4 * l->cell_count; i++)
        if (l->neighbour[i] < 0)
            l->face[n++] = (struct hull_face){.cell = (int32_t)(i / 4), .opposite = (int8_t)(i % 4)};
    build_node(l, 0, l->face_count);
    return NULL;
}

struct error *locate_create(struct locate **locate, size_t probe_count, const double *position, size_t cell_count,
                            const int32_t *vertex, const int32_t *neighbour)
{
    struct locate *l = NULL;
    *locate = NULL;
    if (!cell_count)
        return error_new("there are no cells");
    struct error *err = array_create(&l, 1, sizeof *l);
    if (err)
        return err;
    *l = (struct locate){.probe_count = probe_count, .cell_count = cell_count, .vertex = vertex, .neighbour = neighbour,
                         .lattice = lattice_fit(probe_count, position)};
    l->start_count = cell_count < STARTS_MOST ? cell_count : STARTS_MOST;
    err = array_create(&l->site, 3 * probe_count, sizeof *l->site);
    if (!err)
        err = array_create(&l->start, l->start_count, sizeof *l->start);
    if (!err) {
        for (size_t i = 0; i < probe_count; i++)
            lattice_snap(&l->lattice, position + 3 * i, l->site + 3 * i);
        for (size_t i = 0; i < l->start_count; i++)
            l->start[i] = (int32_t)(i * cell_count / l->start_count);
        err = check_cells(l);
    }
    if (!err)
        err = build_hull(l);
    if (err)
        locate_destroy(l);
    else
        *locate = l;
    return err;
}

void locate_destroy(struct locate *l)
{
    if (!l)
        return;
    free(l->site);
    free(l->start);
    free(l->face);
    free(l->node);
    free(l);
}

/* -- inside ----------------------------------------------------------------------------------- */

static double extent(struct vec3 a)
{
    return fmax(fmax(fabs(a.x), fabs(a.y)), fabs(a.z));
}

/* Six times the volumes of p with each face: the barycentric coordinates before they are divided by their sum. p is a site of
 * the lattice. In doubles; where these are small beside what was added up, as in cells that are flat or needles, exactly: signs are
 * always right. */
static void face_volumes(const struct locate *l, size_t cell, struct vec3 p, double volume[4])
{
    const struct vec3 a = vec3_sub(corner(l, cell, 0), p), b = vec3_sub(corner(l, cell, 1), p),
                      c = vec3_sub(corner(l, cell, 2), p), d = vec3_sub(corner(l, cell, 3), p);
    const struct vec3 cd = vec3_cross(c, d), ab = vec3_cross(a, b);
    volume[0] = vec3_dot(b, cd);
    volume[1] = -vec3_dot(a, cd);
    volume[2] = vec3_dot(d, ab);
    volume[3] = -vec3_dot(c, ab);
    const double size = extent(a) + extent(b) + extent(c) + extent(d), trusted = 1e-12 * size * size * size;
    if (fabs(volume[0]) > trusted && fabs(volume[1]) > trusted && fabs(volume[2]) > trusted && fabs(volume[3]) > trusted)
        return;
    if (!(size < 0x1p42)) /* beyond what the lattice's arithmetic can hold: far outside */
        return;
    const double site[3] = {p.x, p.y, p.z};
    const double *v[4];
    for (size_t i = 0; i < 4; i++)
        v[i] = l->site + 3 * (size_t)l->vertex[4 * cell + i];
    volume[0] = (double)lattice_orient(site, v[1], v[2], v[3]);
    volume[1] = (double)lattice_orient(v[0], site, v[2], v[3]);
    volume[2] = (double)lattice_orient(v[0], v[1], site, v[3]);
    volume[3] = (double)lattice_orient(v[0], v[1], v[2], site);
}

static int least_of(const double value[4])
{
    int least = 0;
    for (int i = 1; i < 4; i++)
        if (value[i] < value[least])
            least = i;
    return least;
}

/* Weights from volumes, of which rounding may have left some a little below 0. */
static void set_weights(const struct locate *l, size_t cell, const double volume[4], struct locate_weights *w)
{
    double sum = 0;
    for (int i = 0; i < 4; i++) {
        w->weight[i] = volume[i] > 0 ? volume[i] : 0;
        sum += w->weight[i];
    }
    for (int i = 0; i < 4; i++) {
        w->weight[i] = sum > 0 ? w->weight[i] / sum : 0.25; /* a point in a cell without extent: any weights do */
        w->vertex[i] = l->vertex[4 * cell + (size_t)i];
    }
    w->cell = (int32_t)cell;
}

/* The start cell whose first corner is nearest. */
static size_t cold_start(const struct locate *l, struct vec3 p)
{
    size_t best = 0;
    double best_square = INFINITY;
    for (size_t i = 0; i < l->start_count; i++) {
        const struct vec3 d = vec3_sub(corner(l, (size_t)l->start[i], 0), p);
        const double square = vec3_dot(d, d);
        if (square < best_square) {
            best_square = square;
            best = (size_t)l->start[i];
        }
    }
    return best;
}

/* -- outside ---------------------------------------------------------------------------------- */

/* Nearest point of triangle abc to p, as barycentric weights (Ericson, "Real-Time Collision Detection", 2004, sec. 5.1.5). Returns the
 * squared distance. */
static double nearest_on_triangle(struct vec3 p, struct vec3 a, struct vec3 b, struct vec3 c, double w[3])
{
    const struct vec3 ab = vec3_sub(b, a), ac = vec3_sub(c, a), ap = vec3_sub(p, a), bp = vec3_sub(p, b), cp = vec3_sub(p, c);
    const double d1 = vec3_dot(ab, ap), d2 = vec3_dot(ac, ap), d3 = vec3_dot(ab, bp), d4 = vec3_dot(ac, bp),
                 d5 = vec3_dot(ab, cp), d6 = vec3_dot(ac, cp);
    const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
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
    } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        w[2] = (d4 - d3) / (d4 - d3 + d5 - d6);
        w[1] = 1 - w[2];
    } else {
        const double sum = va + vb + vc;
        w[1] = vb / sum;
        w[2] = vc / sum;
        w[0] = 1 - w[1] - w[2];
    }
    const struct vec3 q = vec3_add(vec3_scale(w[0], a), vec3_add(vec3_scale(w[1], b), vec3_scale(w[2], c)));
    const struct vec3 d = vec3_sub(p, q);
    return vec3_dot(d, d);
}

/* Nearest point of the face opposite vertex i of the cell: sets w if it is nearer than *square. */
static void try_face(const struct locate *l, size_t cell, int i, struct vec3 p, double *square, struct locate_weights *w)
{
    double weight[3];
    const int *f = cell_face[i];
    const double d = nearest_on_triangle(p, corner(l, cell, f[0]), corner(l, cell, f[1]), corner(l, cell, f[2]), weight);
    if (!(d < *square))
        return;
    *square = d;
    w->cell = (int32_t)cell;
    for (int k = 0; k < 4; k++) {
        w->vertex[k] = l->vertex[4 * cell + (size_t)k];
        w->weight[k] = 0;
    }
    double sum = 0;
    for (int k = 0; k < 3; k++)
        sum += weight[k] > 0 ? weight[k] : 0;
    for (int k = 0; k < 3; k++) /* rounding may leave a weight a little below 0 */
        w->weight[f[k]] = weight[k] > 0 ? weight[k] / sum : 0;
}

static double box_square(const struct hull_node *node, struct vec3 p)
{
    double square = 0;
    for (int axis = 0; axis < 3; axis++) {
        const double x = component(p, axis), d = fmax(fmax(node->low[axis] - x, x - node->high[axis]), 0);
        square += d * d;
    }
    return square;
}

/* The nearest point of the hull. */
static void locate_outside(const struct locate *l, struct vec3 p, struct locate_weights *w)
{
    int32_t stack[STACK_MOST]; /* halving 2^31 faces takes 31 levels */
    int depth = 0;
    double square = INFINITY;
    stack[depth++] = 0;
    while (depth) {
        const int32_t index = stack[--depth];
        const struct hull_node *node = &l->node[index];
        if (box_square(node, p) >= square)
            continue;
        for (int32_t i = node->first; i < node->first + node->count; i++)
            try_face(l, (size_t)l->face[i].cell, l->face[i].opposite, p, &square, w);
        if (!node->count) { /* the nearer child first */
            const int32_t left = index + 1, right = node->right_child;
            const bool left_nearer = box_square(&l->node[left], p) <= box_square(&l->node[right], p);
            stack[depth++] = left_nearer ? right : left;
            stack[depth++] = left_nearer ? left : right;
        }
    }
    w->inside = false;
    w->distance = sqrt(square) * l->lattice.step;
}

/* -- searching -------------------------------------------------------------------------------- */

/* The cell that holds p best, among all. */
static void locate_exhaustive(const struct locate *l, struct vec3 p, struct locate_weights *w)
{
    double best = -INFINITY;
    size_t best_cell = 0;
    for (size_t cell = 0; cell < l->cell_count; cell++) {
        double volume[4];
        face_volumes(l, cell, p, volume);
        const double sum = volume[0] + volume[1] + volume[2] + volume[3];
        const double least = sum > 0 ? volume[least_of(volume)] / sum : -INFINITY;
        if (least > best) {
            best = least;
            best_cell = cell;
        }
    }
    if (best < -1e-9) {
        locate_outside(l, p, w);
        return;
    }
    double volume[4];
    face_volumes(l, best_cell, p, volume);
    set_weights(l, best_cell, volume, w);
}

/* Lattice coordinates of a point; one that is so far away that they are beyond reach is brought nearer, in its direction. */
static struct vec3 reachable(const struct locate *l, const double position[3])
{
    const double reach = 0x1p60;
    double coordinates[3], most = 0, size = 0;
    lattice_coordinates(&l->lattice, position, coordinates);
    for (int k = 0; k < 3; k++) {
        most = fmax(most, fabs(coordinates[k]));
        size = fmax(size, fabs(position[k]));
    }
    for (int k = 0; k < 3 && !(most <= reach); k++)
        coordinates[k] = position[k] / size * reach;
    return vec3_load(coordinates);
}

void locate_point(const struct locate *l, const double position[3], struct locate_weights *w)
{
    const struct vec3 exactly = reachable(l, position);
    const struct vec3 p = {rint(exactly.x), rint(exactly.y), rint(exactly.z)}; /* on the lattice, where the walk's arithmetic is exact */
    size_t cell = w->cell >= 0 && (size_t)w->cell < l->cell_count ? (size_t)w->cell : cold_start(l, p);
    w->inside = true;
    w->distance = 0;
    /* Signs are exact, so a walk through Delaunay cells visits none twice (Edelsbrunner 1990) and ends; where a stream's cells are
     * not Delaunay, or the point is too far for exact arithmetic, it may not, and a search through all takes over. */
    const double steps_most = 64 + 32 * cbrt((double)l->cell_count);
    for (double step = 0; step < steps_most; step++) {
        double volume[4];
        face_volumes(l, cell, p, volume);
        const int least = least_of(volume);
        if (volume[least] >= 0) {
            set_weights(l, cell, volume, w);
            return;
        }
        const int32_t next = l->neighbour[4 * cell + (size_t)least];
        if (next < 0) { /* beyond a face of a convex hull */
            locate_outside(l, exactly, w);
            return;
        }
        cell = (size_t)next;
    }
    locate_exhaustive(l, p, w);
}

void locate_blend(const struct locate_weights *w, const float *value, size_t width, float *out)
{
    const float *v[4];
    int most = 0;
    for (int i = 1; i < 4; i++)
        most = w->weight[i] > w->weight[most] ? i : most;
    for (int i = 0; i < 4; i++) /* what has no weight has no say, not even as a missing value */
        v[i] = value + (size_t)w->vertex[w->weight[i] > 0 ? i : most] * width;
    for (size_t k = 0; k < width; k++)
        out[k] = (float)(w->weight[0] * (double)v[0][k] + w->weight[1] * (double)v[1][k] + w->weight[2] * (double)v[2][k] +
                         w->weight[3] * (double)v[3][k]);
}
