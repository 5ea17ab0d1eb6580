/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/interpolate_options.h"
#include "base/error.h"
#include "base/options.h"
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"

#include <math.h>
#include <string.h>

static struct error *parse_kind(void *value, const char *text)
{
    const struct interpolate_kind **kind = value, *found = interpolate_kind_find(text);
    char names[256];
    if (found) {
        *kind = found;
        return NULL;
    }
    interpolate_kind_names(names, sizeof names, false, ", ");
    return error_usage("expected one of %s, got '%s'", names, text);
}

const struct option_row *interpolate_options_rows(struct interpolate_options *o,
                                                  struct option_row *rows)
{
    static const char *const falloffs[] = {[INTERPOLATE_FALL_LINEAR] = "linear",
                                           [INTERPOLATE_FALL_QUADRATIC] = "quadratic",
                                           [INTERPOLATE_FALL_CUBIC] = "cubic",
                                           NULL};
    static const char *const outsides[] = {"auto", "extend", "nearest", NULL};
    if (!o->kind)
        o->kind = interpolate_kinds[0];
    const struct option_row all[INTERPOLATE_OPTIONS_ROWS] = {
        {.name = "interpolate",
         .argument = "HOW",
         .kind = OPTION_CALL,
         .parse = parse_kind,
         .value = &o->kind,
         .shown = o->kind->name,
         .help = "from the cells: barycentric; with gradients too, gradient or cubic.\n"
                 "From the probes alone: nearest or shepard; of surfaces: discs. From the\n"
                 "nodes of a grid or octree: trilinear, tricubic, inverse, or with\n"
                 "gradients trilinear-gradient"},
        {.name = "radius",
         .argument = "LENGTH",
         .kind = OPTION_REAL,
         .value = &o->radius,
         .least = 0,
         .least_open = true,
         .most = (double)INFINITY,
         .shown = "twice the mean distance of neighbours; discs: of column radius",
         .help = "shepard, discs: of what is blended"},
        {.name = "falloff",
         .argument = "SHAPE",
         .kind = OPTION_CHOICE,
         .choices = falloffs,
         .value = OPTION_ENUM(o->falloff),
         .help = "shepard, discs: of the weights, towards the radius"},
        {.name = "outside",
         .argument = "WHAT",
         .kind = OPTION_CHOICE,
         .choices = outsides,
         .value = OPTION_ENUM(o->outside),
         .help = "outside of the hull of the probes: the light of its nearest point\n"
                 "(nearest), light that goes on from it along rays (extend), or one of\n"
                 "these as the hull is (auto: see probe-query's manual)"},
        {0}};
    memcpy(rows, all, sizeof all);
    return rows;
}

struct option_row interpolate_visible_row(enum interpolate_visible *visible)
{
    static const char *const choices[] = {[INTERPOLATE_VISIBLE_KEPT] = "kept",
                                          [INTERPOLATE_VISIBLE_ALL] = "all",
                                          [INTERPOLATE_VISIBLE_RAYS] = "rays",
                                          NULL};
    return (struct option_row){
        .name = "visible",
        .argument = "WHICH",
        .kind = OPTION_CHOICE,
        .choices = choices,
        .value = OPTION_ENUM(*visible),
        .help = "light is taken from the probes of a cell that the point sees by what\n"
                "the cell keeps of it (kept: see probe-leakfix), from all of\n"
                "them, or from those that it sees, by a ray to each (rays)"};
}

unsigned interpolate_visible_flags(enum interpolate_visible visible)
{
    return visible == INTERPOLATE_VISIBLE_KEPT ? 0 : PROBE_SEE_ALL;
}

struct error *interpolate_options_check(const struct interpolate_options *o)
{
    if (!o->kind->has_radius && (o->radius > 0 || o->falloff))
        return error_usage("--radius and --falloff need --interpolate shepard or discs");
    return NULL;
}

/* What a volume is asked for: auto, extend, nearest. Other choices of a program give light outside
 * of the hull no say. */
static unsigned outside_flags(int outside)
{
    return outside == 0 ? 0 : outside == 1 ? PROBE_EXTEND : PROBE_NEAREST;
}

struct interpolate_settings interpolate_options_settings(const struct interpolate_options *o,
                                                         const char *column)
{
    /* what surface probes have in the place of sh */
    if (o->kind->surface && !strcmp(column, "sh"))
        column = "irradiance";
    return (struct interpolate_settings){.kind = o->kind,
                                         .falloff = o->falloff,
                                         .radius = o->radius,
                                         .column = column,
                                         .outside = outside_flags(o->outside)};
}
