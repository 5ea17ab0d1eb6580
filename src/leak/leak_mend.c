/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/leak_mend.h"
#include "base/array.h"
#include "base/error.h"
#include "base/warning.h"
#include "leak/cells_make.h"
#include "leak/sight.h"
#include "place/place.h"
#include "place/place_inside.h"
#include "stream/cells.h"
#include "stream/stream.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct error *leak_mesh_of(const struct stream *stream, struct leak_mesh *mesh)
{
    struct cells cells;
    const struct table *probes = stream_table(stream, "probe");
    if (!probes)
        return error_new("there are no cells: run probe-tet");
    struct error *err = cells_find(stream, &cells);
    if (err)
        return err;
    *mesh = (struct leak_mesh){.probe_count = probes->rows,
                               .position = column_f64(table_column(probes, "position")),
                               .corners = cells.corners,
                               .cell_count = cells.table->rows,
                               .vertex = cells.vertex};
    return NULL;
}

/* Finds leaks, and the probes that would mend them, but for those that would stand inside
 * solids. */
static struct error *find(struct leaks *leaks, const struct tracer *tracer,
                          const struct leak_settings *settings, const struct stream *stream)
{
    struct place_inside_settings inside_settings = place_inside_default();
    enum place_side *side = NULL;
    leaks_clear(leaks);
    struct leak_mesh mesh;
    struct error *err = leak_mesh_of(stream, &mesh);
    if (!err)
        err = leak_find(leaks, tracer, settings, &mesh);
    if (err || !leaks->probe_count)
        return err;
    inside_settings.threads = settings->threads;
    const struct place place = {.position = leaks->probe, .count = leaks->probe_count};
    err = array_create(&side, leaks->probe_count, sizeof *side);
    if (!err)
        err = place_inside(&place, tracer, &inside_settings, side, NULL);
    size_t kept = 0;
    for (size_t i = 0; i < leaks->probe_count && !err; i++)
        if (side[i] == PLACE_AIR)
            memmove(leaks->probe + 3 * kept++, leaks->probe + 3 * i, 3 * sizeof *leaks->probe);
    leaks->probe_count = kept;
    free(side);
    return err;
}

/* Adds the probes that the leaks ask for, and makes cells of all. */
static struct error *add_probes(struct stream *stream, const struct leaks *leaks)
{
    struct table *probes = stream_table(stream, "probe");
    const size_t before = probes->rows;
    struct error *err = table_resize(probes, before + leaks->probe_count);
    if (err)
        return err;
    memcpy(column_f64(table_column(probes, "position")) + 3 * before, leaks->probe,
           3 * leaks->probe_count * sizeof(double));
    return cells_make(stream);
}

static struct error *store_occlusion(struct stream *stream, const struct leaks *leaks)
{
    struct cells cells;
    struct column *occlusion = NULL;
    struct error *err = cells_find(stream, &cells);
    const size_t edges = err ? 0 : (size_t)leak_edges_of(cells.corners);
    if (!edges) /* a single probe has none */
        return err;
    err = table_add_column(cells.table, "occlusion", COLUMN_I32, edges, &occlusion);
    if (!err)
        memcpy(occlusion->data, leaks->cell_edges, edges * cells.table->rows * sizeof(int32_t));
    return err;
}

static struct error *store_sight(struct stream *stream, const struct leak_mend_job *job)
{
    struct cells cells;
    struct leak_mesh mesh;
    struct sights sights = {0};
    struct column *sight = NULL, *stand_in = NULL;
    struct error *err = leak_mesh_of(stream, &mesh);
    if (!err)
        err = cells_find(stream, &cells);
    const size_t width = err ? 0 : (size_t)(cells.corners * (cells.corners - 1));
    if (!width) /* a single probe is seen from everywhere */
        return err;
    err = sight_find(&sights, job->tracer, &mesh, job->settings.threads);
    if (!err)
        err = table_add_column(cells.table, "sight", COLUMN_F32, width, &sight);
    if (!err)
        err = table_add_column(cells.table, "stand_in", COLUMN_I32, 1, &stand_in);
    if (!err) {
        sight = table_column(cells.table, "sight"); /* the table has moved its columns since */
        memcpy(column_f32(sight), sights.sight, width * mesh.cell_count * sizeof *sights.sight);
        memcpy(column_i32(stand_in), sights.stand_in, mesh.cell_count * sizeof *sights.stand_in);
    }
    if (!err && job->program)
        fprintf(stderr, "%s: sight: %zu of %zu cells have walls in them, %zu a stand-in\n",
                job->program, sights.walled, mesh.cell_count, sights.stood_in);
    sights_clear(&sights);
    return err;
}

static struct error *drop_sight(struct stream *stream)
{
    struct cells cells;
    struct error *err = cells_find(stream, &cells);
    if (!err) {
        table_remove_column(cells.table, "sight");
        table_remove_column(cells.table, "stand_in");
    }
    return err;
}

static void say(const struct leak_mend_job *job, const char *when, const struct leaks *leaks,
                const struct stream *stream)
{
    const char *program = job->program;
    const bool shadows = job->settings.edges != LEAK_WALLS;
    if (!program)
        return;
    fprintf(stderr,
            "%s: %s: %zu of %zu edges leak (%.2f %%), %zu pass through a surface, %zu probes\n",
            program, when, leaks->leaking, leaks->edges,
            leaks->edges ? 100.0 * (double)leaks->leaking / (double)leaks->edges : 0.0,
            leaks->crossed, stream_table(stream, "probe")->rows);
    if (shadows)
        fprintf(stderr, "%s: %s: %zu edges go through the border of a shadow\n", program, when,
                leaks->shadowed);
}

struct error *leak_mend(struct stream *stream, const struct leak_mend_job *job,
                        struct warnings *warnings)
{
    struct leaks leaks = {0};
    struct leak_settings settings = job->settings;
    const double separation_least = 2 * settings.offset;
    struct error *err = drop_sight(stream);
    if (!err)
        err = find(&leaks, job->tracer, &settings, stream);
    if (!err)
        say(job, "before", &leaks, stream);
    for (int64_t round = 0; !err && leaks.asking && round < job->rounds; round++) {
        const size_t rows = stream_table(stream, "probe")->rows + leaks.probe_count;
        if ((double)rows > job->probes_most) {
            warnings_add(warnings, "max-probes",
                         "%zu more probes would be more than --max-probes %.0f: edges still leak",
                         leaks.probe_count, job->probes_most);
            break;
        }
        if (!leaks.probe_count && settings.separation <= separation_least)
            break; /* what still leaks has probes as near as they may be */
        if (leaks.probe_count)
            err = add_probes(stream, &leaks);
        settings.separation = fmax(settings.separation / 2, separation_least);
        if (!err)
            err = find(&leaks, job->tracer, &settings, stream);
    }
    if (!err && job->rounds)
        say(job, "after", &leaks, stream);
    if (!err)
        err = store_occlusion(stream, &leaks);
    if (!err && job->sight)
        err = store_sight(stream, job);
    leaks_clear(&leaks);
    return err;
}
