/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/capture_stream.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "capture/capture_cache.h"
#include "capture/probe_split.h"
#include "light/convert.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "scene/scene_told.h"
#include "stream/sight_key.h"
#include "stream/stream_edit.h"
#include "trace/lit.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 1024 };

static struct error *open_writer(struct capture_run *run)
{
    const struct capture_options *o = &run->options;
    const struct stream_header *before = stream_reader_header(run->reader);
    char key[SCENE_KEY_ROOM];
    struct stream_header senders = {0};
    scene_key_text(run->scene, header_key(before, "scene-key"), key);
    const struct capture_record record = {.settings = &o->capture,
                                          .cache = &o->cache,
                                          .light = &o->scene,
                                          .split = &o->split,
                                          .senders = o->transfer_surfaces ? &senders
                                                     : o->transfer_given  ? NULL
                                                                          : before,
                                          .scene_key = key,
                                          .again = o->again,
                                          .command_line = run->command_line};
    struct error *err = o->transfer_surfaces ? senders_to_header(&run->links.senders, &senders)
                                             : NULL;
    if (!err)
        err = capture_make_header(&run->header, before, &record);
    header_clear(&senders);
    if (!err && run->told)
        err = header_set_key(&run->header, SCENE_TOLD_KEY, run->told);
    run->other_sight = !err && sight_key_other_scene(&run->header, scene_surface_key(run->scene));
    if (run->other_sight)
        sight_key_remove(&run->header);
    const enum stream_encoding read = stream_reader_encoding(run->reader),
                               asked = o->common.encoding;
    return err ? err
               : stream_writer_open(&run->writer, o->common.output,
                                    asked == STREAM_AS_READ ? read : asked, &run->header);
}

static struct capture_job make_job(const struct capture_run *run)
{
    const struct capture_options *o = &run->options;
    return (struct capture_job){.path = run->path,
                                .settings = &o->capture,
                                .again = o->again,
                                .slice = &o->slice,
                                .threads = o->common.threads,
                                .progress = run->progress};
}

/* Remembers what was captured in a table, whose first row is the slice's next. */
static void note(struct capture_run *run, const struct table *out, const struct capture_job *job)
{
    struct capture_slice *slice = &run->options.slice;
    run->captured += job->captured;
    run->left += job->left;
    for (size_t i = 0; i < out->rows; i++)
        run->probes += (slice->number + i) % slice->parts == slice->part;
    slice->number += out->rows;
    const struct column *sky = table_column(out, "sky");
    for (size_t i = 0; sky && i < out->rows; i++)
        run->sky += isnan(column_f32(sky)[i]) ? 0 : (double)column_f32(sky)[i];
    dering_count_add(&run->dering, out);
    capture_black_note(&run->black, out);
}

/* The table that is to be written: what came, and what capture adds. */
static struct error *make_schema(const struct capture_run *run, const struct table *schema,
                                 struct table *out)
{
    struct error *err = table_copy_schema(out, schema);
    if (!err && run->options.again && run->options.capture.light != CAPTURE_NONE)
        capture_drop_stale(out);
    if (!err)
        err = capture_add_columns(&run->options.capture, out);
    return err ? err : capture_links_columns(&run->links, &run->options.capture, out);
}

/* Takes the rows of `in` over into `out`, whose other columns are missing. */
static struct error *take_rows(const struct capture_run *run, const struct table *in,
                               struct table *out)
{
    struct error *err = table_resize(out, 0); /* rows that are new again hold missing values */
    if (!err)
        err = table_resize(out, in->rows);
    if (!err)
        table_copy_rows(out, 0, in, 0, in->rows);
    if (!err && run->options.capture.light == CAPTURE_NONE)
        return capture_forget_unlit(&run->options.capture, out);
    return !err && run->options.again ? capture_forget(out) : err;
}

/* Captures the probes block by block, so that they go on while others are still to come. */
static struct error *capture_blocks(struct capture_run *run, const struct table *schema,
                                    struct table *out)
{
    struct capture_job job = make_job(run);
    struct table in = {0};
    struct error *err = table_copy_schema(&in, schema);
    if (!err)
        err = stream_writer_table(run->writer, out);
    for (size_t got = 1; !err && got;) {
        err = table_resize(&in, 0);
        if (!err)
            err = stream_reader_rows(run->reader, &in, BLOCK, &got);
        if (!err)
            err = take_rows(run, &in, out);
        if (!err)
            err = capture_rows(&job, out, 0, got);
        if (!err)
            err = capture_links_rows(&run->links, out, 0, got);
        if (err)
            break;
        note(run, out, &job);
        err = stream_writer_rows(run->writer, out, 0, got);
    }
    table_clear(&in);
    return err;
}

/* Reads all probes that are left, and makes room for what is captured. */
static struct error *read_all(struct capture_run *run, const struct table *schema,
                              struct table *out)
{
    struct table in = {0};
    size_t got = 1;
    struct error *err = table_copy_schema(&in, schema);
    while (!err && got)
        err = stream_reader_rows(run->reader, &in, BLOCK, &got);
    if (!err)
        err = take_rows(run, &in, out);
    table_clear(&in);
    return err;
}

/* Opens the cache for rays of all probes, where there is to be one. */
static struct error *open_cache(struct capture_run *run, const struct table *probes,
                                struct capture_cache *cache)
{
    const struct capture_options *o = &run->options;
    struct error *err = capture_cache_open_rows(cache, run->path, &o->capture, &o->cache,
                                                run->scene, probes, 0, probes->rows,
                                                o->common.threads);
    if (!err)
        memcpy(run->cache_told, cache->told, sizeof run->cache_told);
    return err;
}

/* Writes it, if that was asked for. */
static struct error *write_cache(const struct capture_run *run, const struct capture_cache *cache)
{
    const struct capture_options *o = &run->options;
    return o->cache_out && !interrupt_came()
               ? capture_cache_write(cache, o->cache_out, &o->capture, run->scene, &run->header)
               : NULL;
}

/* Captures all probes with a cache for their rays. */
static struct error *capture_cached(struct capture_run *run, const struct table *schema,
                                    struct table *out)
{
    struct capture_job job = make_job(run);
    struct capture_cache cache = {0};
    struct error *err = read_all(run, schema, out);
    if (!err)
        err = open_cache(run, out, &cache);
    if (!err)
        err = write_cache(run, &cache);
    if (!err)
        err = capture_rows(&job, out, 0, out->rows);
    path_use_cache(run->path, NULL);
    if (!err)
        err = capture_links_rows(&run->links, out, 0, out->rows);
    if (!err)
        err = stream_writer_table(run->writer, out);
    if (!err)
        note(run, out, &job);
    if (!err)
        err = stream_writer_rows(run->writer, out, 0, out->rows);
    capture_cache_clear(&cache);
    return err;
}

/* Captures all probes to the highest order, and keeps the least that loses no more than it may. */
static struct error *capture_to_least_order(struct capture_run *run, const struct table *schema,
                                            struct table *out)
{
    struct capture_options *o = &run->options;
    struct capture_job job = make_job(run);
    struct capture_cache cache = {0};
    double lost = 0;
    struct error *err = read_all(run, schema, out);
    if (!err)
        err = open_cache(run, out, &cache);
    if (!err)
        err = capture_least_order(&job, out, o->order_loss, &o->capture.order, &lost);
    path_use_cache(run->path, NULL);
    if (!err)
        err = open_writer(run);
    if (!err)
        err = write_cache(run, &cache);
    if (!err)
        err = stream_writer_table(run->writer, out);
    if (!err)
        err = stream_writer_rows(run->writer, out, 0, out->rows);
    if (!err)
        note(run, out, &job);
    if (!err && !job.left)
        run->order_lost = lost;
    capture_cache_clear(&cache);
    return err;
}

/* Says what parts of light take. */
static void say_parts(const struct capture_run *run, const struct table *out, FILE *to)
{
    const struct split *split = &run->options.split.split;
    const size_t sky = (size_t)(split->sky_order * split->sky_order);
    size_t parts;
    const size_t all = capture_row_bytes(out, &parts);
    fprintf(to, "%s: a probe takes %zu bytes", run->program, all);
    if (parts)
        fprintf(to, ", %zu of them for %zu groups, %zu functions of a sky, %zu suns and %zu points",
                parts, split_sky(split), sky, split->sun_count, split->point_count);
    fputc('\n', to);
}

/* Says what all would take. */
static struct error *say_all(struct capture_run *run, const struct table *schema,
                             const struct table *out)
{
    struct table in = {0};
    size_t probes = 0, got = 1, parts;
    const double row = (double)capture_row_bytes(out, &parts);
    struct error *err = table_copy_schema(&in, schema);
    while (!err && got) {
        err = table_resize(&in, 0);
        if (!err)
            err = stream_reader_rows(run->reader, &in, BLOCK, &got);
        probes += err ? 0 : got;
    }
    table_clear(&in);
    if (err)
        return err;
    const bool whole = !run->writer && (run->options.order_auto || run->options.cache.name);
    const double at_once = row * (whole || probes < BLOCK ? (double)probes : BLOCK),
                 thread = parts ? (double)probe_split_bytes(&run->options.split.split) : 0;
    say_parts(run, out, stdout);
    printf("%s: %zu probes take %.4g MB in the stream, %.4g MB in memory and %.4g MB a thread\n",
           run->program, probes, 1e-6 * row * (double)probes, 1e-6 * at_once, 1e-6 * thread);
    if (run->links.on)
        printf(
            "%s: %zu senders take %.4g MB in the stream and in memory, and %.4g MB a thread\n",
            run->program, run->links.senders.count, 1e-6 * (double)capture_links_bytes(&run->links),
            1e-6 * (double)capture_senders_bytes(&run->links.senders, run->options.capture.rays));
    return NULL;
}

/* Captures the links of senders, and writes them. */
static struct error *do_senders(struct capture_run *run)
{
    const struct capture_options *o = &run->options;
    struct error *err = capture_links_start(&run->links, run->path, &o->capture, o->common.threads);
    return err ? err : capture_links_write(&run->links, run->writer);
}

/* That the senders are there which probes have links to. */
static struct error *find_senders(const struct capture_run *run)
{
    const struct capture_options *o = &run->options;
    if (run->links.on || o->transfer_given ||
        !header_key(stream_reader_header(run->reader), SENDERS_KEY))
        return NULL;
    return error_new("the probes have links to senders (key %s): expected table %s before table "
                     "probe",
                     SENDERS_KEY, SENDERS_TABLE);
}

static struct error *capture_table(struct capture_run *run, const struct table *schema)
{
    struct table out = {0};
    struct error *err = find_senders(run);
    if (!err)
        err = make_schema(run, schema, &out);
    const bool surface = table_column(schema, "normal"),
               choose = run->options.order_auto && !surface;
    if (!err && run->options.dry_run) {
        err = say_all(run, schema, &out);
        table_clear(&out);
        return err;
    }
    if (!err && run->say && capture_split_count(&run->options.split))
        say_parts(run, &out, run->say);
    if (!err && choose && run->writer)
        err = error_new("--order auto: expected table probe before the others");
    if (!err && !choose && !run->writer)
        err = open_writer(run);
    if (!err)
        err = do_senders(run);
    if (!err)
        err = choose                    ? capture_to_least_order(run, schema, &out)
              : run->options.cache.name ? capture_cached(run, schema, &out)
                                        : capture_blocks(run, schema, &out);
    table_clear(&out);
    return err;
}

/* Passes a table on as it is, but for what its cells keep of the sight of other surfaces. */
static struct error *pass_table(struct capture_run *run, const struct table *schema)
{
    const struct stream_selection others = {.drop = SIGHT_COLUMNS, .step = 1, .end = -1};
    if (!run->other_sight || !stream_cell_corners(schema->name))
        return stream_copy_table(run->reader, run->writer, schema);
    run->sight_dropped = run->sight_dropped || table_column(schema, "sight");
    return stream_filter_table(run->reader, run->writer, schema, &others);
}

/* Table sender of the stream: taken over, or other ones are asked for. */
static struct error *take_senders(struct capture_run *run, struct table *schema)
{
    if (run->options.transfer_given)
        return NULL;
    return capture_links_take(&run->links, run->reader, schema, stream_reader_header(run->reader));
}

/* Makes sunlit points for probes to look for: where there is a sun, and no cache with its own. */
static struct error *look_for_suns(struct capture_run *run, struct lit **lit)
{
    enum { PARTICLES = 1 << 14 };
    const struct capture_options *o = &run->options;
    const struct lit_sources sources = {run->path->tracer, &run->path->lights, &run->path->sky};
    *lit = NULL;
    if (o->cache.name || o->dry_run || !run->path->sun_count ||
        o->capture.light == CAPTURE_DIRECT || o->capture.light == CAPTURE_NONE)
        return NULL;
    struct error *err = lit_create(lit, &sources, PARTICLES, o->capture.seed, o->common.threads);
    path_use_lit(run->path, *lit);
    return err;
}

struct error *capture_stream(struct capture_run *run)
{
    const char *surfaces = run->options.transfer_surfaces;
    struct lit *lit = NULL;
    struct error *err = surfaces ? capture_links_read(&run->links, surfaces, run->options.links)
                                 : NULL;
    if (!err)
        err = look_for_suns(run, &lit);
    for (bool more = true; !err && more;) {
        struct table schema = {0};
        err = stream_reader_next_table(run->reader, &schema, &more);
        const bool probes = !err && more && !strcmp(schema.name, "probe"),
                   senders = !err && more && !strcmp(schema.name, SENDERS_TABLE);
        if (!err && !probes && !senders && !run->writer && !run->options.dry_run)
            err = open_writer(run);
        if (probes)
            err = capture_table(run, &schema);
        else if (senders)
            err = take_senders(run, &schema);
        else if (!err && more && !run->options.dry_run)
            err = pass_table(run, &schema);
        table_clear(&schema);
    }
    path_use_lit(run->path, NULL);
    lit_destroy(lit);
    return err;
}
