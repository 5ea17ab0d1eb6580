#include "tetra.h"
#include "angle.h"
#include "array.h"
#include "cell.h"
#include "error.h"
#include "lattice.h"
#include "vec.h"
#include "warning.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/* -- canonical points ------------------------------------------------------------------------- */

/* Distinct sites in lexicographic order, and which row each stands for. */
struct sites {
    double *site; /* 3 * count */
    int32_t *row;
    size_t count;
};

static void sites_clear(struct sites *sites)
{
    free(sites->site);
    free(sites->row);
}

static int compare_sites(const double *a, const double *b)
{
    for (int k = 0; k < 3; k++)
        if (a[k] != b[k])
            return a[k] < b[k] ? -1 : 1;
    return 0;
}

static int compare_rows(const void *a, const void *b, void *context)
{
    const int32_t i = *(const int32_t *)a, j = *(const int32_t *)b;
    const double *site = context;
    const int order = compare_sites(site + 3 * (size_t)i, site + 3 * (size_t)j);
    return order ? order : i < j ? -1 : i > j;
}

/* Snaps, sorts, and drops what shares a site with an earlier row. */
static struct error *sites_make(struct sites *sites, size_t count, const double *position, struct warnings *warnings)
{
    *sites = (struct sites){0};
    double *all = NULL;
    struct error *err = count > INT32_MAX ? error_new("more than %d probes", INT32_MAX) : NULL;
    for (size_t i = 0; i < 3 * count && !err; i++)
        if (!isfinite(position[i]))
            err = error_new("probe %zu: expected a finite position, got %g", i / 3, position[i]);
    if (!err)
        err = array_create(&all, 3 * count, sizeof *all);
    if (!err)
        err = array_create(&sites->site, 3 * count, sizeof *sites->site);
    if (!err)
        err = array_create(&sites->row, count, sizeof *sites->row);
    if (!err) {
        const struct lattice lattice = lattice_fit(count, position);
        for (size_t i = 0; i < count; i++) {
            lattice_snap(&lattice, position + 3 * i, all + 3 * i);
            sites->row[i] = (int32_t)i;
        }
        qsort_r(sites->row, count, sizeof *sites->row, compare_rows, all);
        for (size_t i = 0; i < count; i++) {
            const int32_t row = sites->row[i];
            const double *site = all + 3 * (size_t)row;
            if (sites->count && !compare_sites(site, sites->site + 3 * (sites->count - 1))) {
                warnings_add(warnings, "duplicate probe", "probe %d is where probe %d is: it is in no cell", row,
                             sites->row[sites->count - 1]);
                continue;
            }
            memcpy(sites->site + 3 * sites->count, site, 3 * sizeof *site);
            sites->row[sites->count++] = row;
        }
    }
    free(all);
    if (err)
        sites_clear(sites);
    return err;
}

static bool collinear(const double *a, const double *b, const double *c)
{
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const lattice_volume u = (lattice_volume)(b[i] - a[i]) * (int64_t)(c[j] - a[j]);
        const lattice_volume v = (lattice_volume)(b[j] - a[j]) * (int64_t)(c[i] - a[i]);
        if (u != v)
            return false;
    }
    return true;
}

/* Four points that span space, or the error that says what they span. */
static struct error *check_rank(const struct sites *sites)
{
    const double *site = sites->site;
    if (sites->count < 4)
        return error_new("expected at least 4 probes at different places, got %zu", sites->count);
    size_t third = 2;
    while (third < sites->count && collinear(site, site + 3, site + 3 * third))
        third++;
    if (third == sites->count)
        return error_new("expected probes that span space, got %zu on a line", sites->count);
    for (size_t fourth = third + 1; fourth < sites->count; fourth++)
        if (lattice_orient(site, site + 3, site + 3 * third, site + 3 * fourth))
            return NULL;
    return error_new("expected probes that span space, got %zu in a plane", sites->count);
}

/* -- TetGen in a child ------------------------------------------------------------------------- */

static bool write_all(int fd, const void *data, size_t bytes)
{
    for (const char *at = data; bytes;) {
        const ssize_t put = write(fd, at, bytes);
        if (put < 0 && errno != EINTR)
            return false;
        at += put > 0 ? put : 0;
        bytes -= put > 0 ? (size_t)put : 0;
    }
    return true;
}

static bool read_all(int fd, void *data, size_t bytes, off_t offset)
{
    for (char *at = data; bytes;) {
        const ssize_t got = pread(fd, at, bytes, offset);
        if (got == 0 || (got < 0 && errno != EINTR))
            return false;
        at += got > 0 ? got : 0;
        bytes -= got > 0 ? (size_t)got : 0;
        offset += got > 0 ? got : 0;
    }
    return true;
}

/* What the child does: its streams go nowhere, its result into the file. */
static _Noreturn void child(int file, size_t count, const double *position)
{
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
    int32_t *vertex, *neighbour;
    const long cells = tetra_tetgen(count, position, &vertex, &neighbour);
    if (cells < 0)
        _exit(1);
    const size_t bytes = 4 * (size_t)cells * sizeof(int32_t);
    _exit(write_all(file, &cells, sizeof cells) && write_all(file, vertex, bytes) && write_all(file, neighbour, bytes) ? 0 : 2);
}

static struct error *read_result(int file, size_t count, struct tetra *tetra)
{
    long cells = 0;
    if (!read_all(file, &cells, sizeof cells, 0) || cells <= 0)
        return error_new("TetGen made no cells of %zu probes", count);
    const size_t indices = 4 * (size_t)cells, bytes = indices * sizeof(int32_t);
    struct error *err = array_create(&tetra->vertex, indices, sizeof *tetra->vertex);
    if (!err)
        err = array_create(&tetra->neighbour, indices, sizeof *tetra->neighbour);
    if (!err && (!read_all(file, tetra->vertex, bytes, sizeof cells) ||
                 !read_all(file, tetra->neighbour, bytes, (off_t)(sizeof cells + bytes))))
        err = error_new("TetGen's result for %zu probes is cut short", count);
    tetra->cell_count = (size_t)cells;
    return err;
}

static struct error *run_tetgen(size_t count, const double *position, struct tetra *tetra)
{
    const int file = memfd_create("tetra", MFD_CLOEXEC);
    if (file < 0)
        return error_system(errno, "memory for the cells");
    struct error *err = NULL;
    int status = 0;
    const pid_t pid = fork();
    if (pid == 0)
        child(file, count, position);
    if (pid < 0)
        err = error_system(errno, "starting TetGen");
    while (!err && waitpid(pid, &status, 0) < 0)
        if (errno != EINTR)
            err = error_system(errno, "waiting for TetGen");
    if (!err && WIFSIGNALED(status))
        err = error_new("TetGen died on %zu probes: %s", count, strsignal(WTERMSIG(status)));
    else if (!err && WEXITSTATUS(status) == 2)
        err = error_new("TetGen's cells of %zu probes do not fit into memory", count);
    else if (!err && WEXITSTATUS(status))
        err = error_new("TetGen failed on %zu probes", count);
    if (!err)
        err = read_result(file, count, tetra);
    close(file);
    return err;
}

/* -- the hull --------------------------------------------------------------------------------- */

/* Calls for every hull face with its outward corners (rows). */
#define FOR_HULL_FACES(cell, i, cell_count, neighbour) \
    for (size_t cell = 0; cell < (cell_count); cell++) \
        for (size_t i = 0; i < 4; i++)                 \
            if ((neighbour)[4 * cell + i] < 0)

/* Angle-weighted vertex normals (Thuermer and Wuethrich, "Computing vertex normals from polygonal facets", 1998). */
static struct error *hull_normals(struct tetra *tetra, size_t count, const double *position)
{
    struct vec3 *sum = NULL;
    struct error *err = array_create(&sum, count, sizeof *sum);
    if (!err)
        err = array_create(&tetra->hull_normal, 3 * count, sizeof *tetra->hull_normal);
    if (err) {
        free(sum);
        return err;
    }
    const struct lattice lattice = lattice_fit(count, position);
    FOR_HULL_FACES(cell, i, tetra->cell_count, tetra->neighbour) {
        int32_t row[3];
        struct vec3 p[3];
        for (int k = 0; k < 3; k++) {
            double coordinates[3];
            row[k] = tetra->vertex[4 * cell + (size_t)cell_face[i][k]];
            lattice_snap(&lattice, position + 3 * (size_t)row[k], coordinates);
            p[k] = vec3_scale(0x1p-40, vec3_load(coordinates));
        }
        const struct vec3 normal = vec3_normalize(vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])));
        for (int k = 0; k < 3; k++) {
            const struct vec3 a = vec3_sub(p[(k + 1) % 3], p[k]), b = vec3_sub(p[(k + 2) % 3], p[k]);
            const double angle = angle_atan2(vec3_length(vec3_cross(a, b)), vec3_dot(a, b));
            sum[row[k]] = vec3_fma(sum[row[k]], angle, normal);
        }
    }
    for (size_t i = 0; i < count; i++) {
        const struct vec3 n = vec3_normalize(sum[i]);
        tetra->hull_normal[3 * i] = (float)n.x;
        tetra->hull_normal[3 * i + 1] = (float)n.y;
        tetra->hull_normal[3 * i + 2] = (float)n.z;
    }
    free(sum);
    return NULL;
}

/* -- building --------------------------------------------------------------------------------- */

struct error *tetra_build(struct tetra *tetra, size_t count, const double *position, struct warnings *warnings)
{
    *tetra = (struct tetra){0};
    struct sites sites = {0};
    struct error *err = sites_make(&sites, count, position, warnings);
    if (!err)
        err = check_rank(&sites);
    if (!err) {
        for (size_t i = 0; i < 3 * sites.count; i++)
            sites.site[i] *= 0x1p-40; /* near 1: exact */
        err = run_tetgen(sites.count, sites.site, tetra);
    }
    for (size_t i = 0; !err && i < 4 * tetra->cell_count; i++) {
        const int32_t canonical = tetra->vertex[i];
        if (canonical < 0 || (size_t)canonical >= sites.count)
            err = error_new("TetGen made a cell of a probe that does not exist");
        else
            tetra->vertex[i] = sites.row[canonical];
    }
    if (!err)
        err = tetra_check(tetra->cell_count, tetra->vertex, tetra->neighbour, count, position);
    if (!err)
        err = hull_normals(tetra, count, position);
    sites_clear(&sites);
    if (err)
        tetra_clear(tetra);
    return err;
}

void tetra_clear(struct tetra *tetra)
{
    free(tetra->vertex);
    free(tetra->neighbour);
    free(tetra->hull_normal);
    *tetra = (struct tetra){0};
}

/* -- checking --------------------------------------------------------------------------------- */

static struct error *snap_all(size_t count, const double *position, double **sites)
{
    struct error *err = array_create(sites, 3 * count, sizeof **sites);
    const struct lattice lattice = lattice_fit(count, position);
    for (size_t i = 0; i < count && !err; i++)
        lattice_snap(&lattice, position + 3 * i, *sites + 3 * i);
    return err;
}

/* Which face of `cell` looks back at `from` over the face with these corners, or -1. */
static int face_back(const int32_t *vertex, const int32_t *neighbour, size_t cell, size_t from, size_t from_face)
{
    for (int j = 0; j < 4; j++) {
        if (neighbour[4 * cell + (size_t)j] != (int32_t)from)
            continue;
        int shared = 0;
        for (int k = 0; k < 3; k++)
            for (int m = 0; m < 3; m++)
                shared += vertex[4 * cell + (size_t)cell_face[j][k]] == vertex[4 * from + (size_t)cell_face[from_face][m]];
        if (shared == 3)
            return j;
    }
    return -1;
}

static struct error *check_cell(size_t cell, size_t cell_count, const int32_t *vertex, const int32_t *neighbour,
                                size_t point_count, const double *site)
{
    const int32_t *v = vertex + 4 * cell;
    const double *p[4];
    for (size_t i = 0; i < 4; i++) {
        if (v[i] < 0 || (size_t)v[i] >= point_count)
            return error_new("cell %zu: probe %d does not exist", cell, v[i]);
        p[i] = site + 3 * (size_t)v[i];
    }
    if (lattice_orient(p[0], p[1], p[2], p[3]) <= 0)
        return error_new("cell %zu (probes %d %d %d %d) has no positive volume", cell, v[0], v[1], v[2], v[3]);
    for (size_t i = 0; i < 4; i++) {
        const int32_t n = neighbour[4 * cell + i];
        if (n < -1 || n >= (int32_t)cell_count)
            return error_new("cell %zu: neighbour %d does not exist", cell, n);
        if (n >= 0 && face_back(vertex, neighbour, (size_t)n, cell, i) < 0)
            return error_new("cell %zu: its neighbour %d does not share the face opposite probe %d", cell, n, v[i]);
    }
    return NULL;
}

/* An edge of a hull face, from its smaller row to its larger, and the face's third corner. */
struct hull_edge {
    int32_t low, high;
    bool forward; /* the face runs from low to high */
    int32_t corner[3], cell;
};

static int compare_edges(const void *a, const void *b)
{
    const struct hull_edge *e = a, *f = b;
    if (e->low != f->low)
        return e->low < f->low ? -1 : 1;
    if (e->high != f->high)
        return e->high < f->high ? -1 : 1;
    return (int)e->forward - (int)f->forward;
}

/* Partial sums over the hull's faces may wrap; the total fits. */
__extension__ typedef unsigned __int128 wrapping_volume;

/* The hull is closed and oriented (each edge in two faces, once each way), convex at each edge, and holds the cells' volume. */
static struct error *check_hull(size_t cell_count, const int32_t *vertex, const int32_t *neighbour, const double *site,
                                lattice_volume volume)
{
    size_t faces = 0;
    FOR_HULL_FACES(cell, i, cell_count, neighbour)
        faces++;
    struct hull_edge *edge = NULL;
    struct error *err = array_create(&edge, 3 * faces, sizeof *edge);
    if (err)
        return err;
    size_t count = 0;
    wrapping_volume hull = 0;
    const double *reference = site + 3 * (size_t)vertex[0];
    FOR_HULL_FACES(cell, i, cell_count, neighbour) {
        int32_t c[3];
        for (int k = 0; k < 3; k++)
            c[k] = vertex[4 * cell + (size_t)cell_face[i][k]];
        hull += (wrapping_volume)lattice_orient(reference, site + 3 * (size_t)c[0], site + 3 * (size_t)c[1],
                                                site + 3 * (size_t)c[2]);
        for (int k = 0; k < 3; k++) {
            const int32_t from = c[k], to = c[(k + 1) % 3];
            edge[count++] = (struct hull_edge){.low = from < to ? from : to, .high = from < to ? to : from,
                                               .forward = from < to, .corner = {c[0], c[1], c[2]}, .cell = (int32_t)cell};
        }
    }
    qsort(edge, count, sizeof *edge, compare_edges);
    for (size_t i = 0; i < count && !err; i += 2) {
        const struct hull_edge *e = &edge[i], *f = &edge[i + 1];
        if (i + 1 == count || e->low != f->low || e->high != f->high || e->forward || !f->forward ||
            (i + 2 < count && edge[i + 2].low == e->low && edge[i + 2].high == e->high)) {
            err = error_new("the hull is not closed at the edge of probes %d and %d of cell %d", e->low, e->high, e->cell);
            break;
        }
        for (int k = 0; k < 3 && !err; k++)
            if (lattice_orient(site + 3 * (size_t)e->corner[0], site + 3 * (size_t)e->corner[1],
                               site + 3 * (size_t)e->corner[2], site + 3 * (size_t)f->corner[k]) > 0)
                err = error_new("the hull is not convex at the edge of probes %d and %d of cell %d", e->low, e->high, e->cell);
    }
    if (!err && (lattice_volume)hull != volume)
        err = error_new("the volumes of the cells do not sum up to the hull's");
    free(edge);
    return err;
}

struct error *tetra_check(size_t cell_count, const int32_t *vertex, const int32_t *neighbour, size_t point_count,
                          const double *position)
{
    if (!cell_count)
        return error_new("there are no cells");
    double *site = NULL;
    struct error *err = snap_all(point_count, position, &site);
    lattice_volume volume = 0;
    for (size_t cell = 0; cell < cell_count && !err; cell++) {
        err = check_cell(cell, cell_count, vertex, neighbour, point_count, site);
        const int32_t *v = vertex + 4 * cell;
        if (!err)
            volume += lattice_orient(site + 3 * (size_t)v[0], site + 3 * (size_t)v[1], site + 3 * (size_t)v[2],
                                     site + 3 * (size_t)v[3]);
        if (!err && volume >> 126)
            err = error_new("cell %zu: the cells overlap: together they have more volume than the probes' box", cell);
    }
    if (!err)
        err = check_hull(cell_count, vertex, neighbour, site, volume);
    free(site);
    return err;
}

/* -- measuring -------------------------------------------------------------------------------- */

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

struct error *tetra_measure(size_t cell_count, const int32_t *vertex, const int32_t *neighbour, size_t point_count,
                            const double *position, struct tetra_report *report)
{
    *report = (struct tetra_report){.cells = cell_count, .angle_least = 180};
    double *site = NULL, *volume = NULL;
    unsigned char *seen = NULL; /* 1: in a cell, 2: on the hull */
    struct error *err = snap_all(point_count, position, &site);
    if (!err)
        err = array_create(&volume, cell_count, sizeof *volume);
    if (!err)
        err = array_create(&seen, point_count, 1);
    if (err || !cell_count)
        goto done;
    const double step = lattice_fit(point_count, position).step, unit = step * step * step / 6;
    for (size_t cell = 0; cell < cell_count; cell++) {
        double p[4][3], angle[6], least = 180;
        for (size_t i = 0; i < 4; i++) {
            const int32_t row = vertex[4 * cell + i];
            memcpy(p[i], site + 3 * (size_t)row, sizeof p[i]);
            seen[row] |= 1;
        }
        volume[cell] = (double)lattice_orient(p[0], p[1], p[2], p[3]) * unit;
        report->volume += volume[cell];
        cell_dihedral((const double(*)[3])p, angle);
        for (int k = 0; k < 6; k++) {
            least = fmin(least, angle[k]);
            report->angle_most = fmax(report->angle_most, angle[k]);
        }
        report->angle_least = fmin(report->angle_least, least);
        report->angle_histogram[least < 70 ? (int)(least / 5) : 14]++;
    }
    FOR_HULL_FACES(cell, i, cell_count, neighbour) {
        int32_t c[3];
        for (int k = 0; k < 3; k++) {
            c[k] = vertex[4 * cell + (size_t)cell_face[i][k]];
            seen[c[k]] |= 2;
        }
        report->hull_volume += (double)lattice_orient(site + 3 * (size_t)vertex[0], site + 3 * (size_t)c[0],
                                                      site + 3 * (size_t)c[1], site + 3 * (size_t)c[2]) * unit;
        report->hull_faces++;
    }
    for (size_t i = 0; i < point_count; i++) {
        report->hull_vertices += seen[i] >> 1;
        report->unused_points += !seen[i];
    }
    qsort(volume, cell_count, sizeof *volume, compare_doubles);
    report->volume_least = volume[0];
    report->volume_median = volume[cell_count / 2];
    report->volume_most = volume[cell_count - 1];
done:
    free(site);
    free(volume);
    free(seen);
    return err;
}
