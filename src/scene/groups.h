/* SPDX-License-Identifier: Apache-2.0 */
/* groups: lights that are switched and dimmed together.
 *
 * Light adds up (Akenine-Moeller et al., "Real-time rendering", 4th ed., eq. 11.36): what a probe
 * gets is the sum of what it gets of each group of lights, and a group that shines w times as
 * bright gives w times as much. A file names the groups, a line each:
 *
 *     # a comment
 *     lamps:   material=lamp* light="Hall/Ceiling lamp"
 *     outside: sun sky
 *
 * Terms: material=PATTERN, emissive surfaces by their material; light=PATTERN, lights and emissive
 * surfaces by a name of the file (light, node, mesh, object, group) and what hangs from it; the
 * same with emissive, point, spot or sun for `light`: those of that kind alone; emissive, point,
 * spot, sun, sky: all of that kind; sun-1, point-2, spot-3: lights of options, by the header's key.
 * PATTERN is as for --exclude (scene_choice.h). What has blanks stands in quotes, where \" is a
 * quote. Every light is in one group: what no line names is in the last one, `rest`, which there is
 * only where something is left.
 *
 *     groups_read(&groups, "lamps.txt");
 *     groups_resolve(&groups, scene, &(struct groups_way){.added = settings.light_count}, &map);
 *     ... map.of_light[i], map.of_sky, group_of_surface(&map, scene, ...): places in groups.list
 */
#ifndef GROUPS_H
#define GROUPS_H

#include "scene/scene.h"

struct error;
struct stream_header;

enum group_term_kind {
    GROUP_MATERIAL,
    GROUP_LIGHT, /* emissive surfaces, point, spot and sun lights */
    GROUP_EMISSIVE,
    GROUP_POINT,
    GROUP_SPOT,
    GROUP_SUN,
    GROUP_SKY,
    GROUP_NUMBER /* a light of the options */
};

struct group_term {
    enum group_term_kind kind;
    char *pattern; /* owned; NULL: all of the kind */
    /* NUMBER: which it must be, and its place, from 1 */
    enum scene_light_kind light;
    size_t number;
};

struct light_group {
    char *name;              /* owned: [a-z0-9_-]+ */
    struct group_term *term; /* owned; none: the rest */
    size_t term_count, term_capacity;
    size_t line; /* of the file; 0: of a header */
};

/* Starts as {0}. */
struct light_groups {
    struct light_group *list; /* owned */
    size_t count, capacity;
    bool each;    /* every light and emissive material is one: groups_resolve makes them */
    char *source; /* the file, for messages; NULL: a header. Owned */
};

void groups_clear(struct light_groups *groups);

/* Reads a file ("-": standard input); "each" is no file. Errors name file and line: what is no
 * line of the kind above, a name that no column can have, one that stands twice, no group. */
struct error *groups_read(struct light_groups *groups, const char *path);

/* Header keys group-1 NAME TERM TERM ..., in the order of the list, and back; those that were
 * there go. No key: no groups. */
struct error *groups_to_header(const struct light_groups *groups, struct stream_header *header);
struct error *groups_from_header(struct light_groups *groups, const struct stream_header *header);

/* Which group every light of a scene is in. */
struct group_map {
    size_t count;          /* groups */
    uint16_t of_sky;       /* GROUP_NONE: it does not shine */
    uint16_t *of_light;    /* by scene->lights; owned */
    uint16_t *of_material; /* of surfaces that emit, where what follows says nothing; owned */
    /* by instance NULL, or by triangle its group or GROUP_NONE; owned */
    uint16_t **of_instance;
    size_t instance_count;
};

enum { GROUP_NONE = UINT16_MAX, GROUPS_MOST = 4096 };

/* How groups are looked for. */
struct groups_way {
    size_t added; /* lights of options, the last of scene->lights */
    bool lenient; /* names that match nothing are let be, as where a header's light has changed */
};

/* Finds all groups in a finished scene, makes them where groups->each, and adds `rest` to the list
 * where something is left. Errors: a name that matches nothing that shines (it lists what there
 * is), a light in two groups. map: cleared by the caller, on error too. */
struct error *groups_resolve(struct light_groups *groups, const struct scene *scene,
                             const struct groups_way *way, struct group_map *map);

void group_map_clear(struct group_map *map);

/* The group of an emissive surface: of a triangle of an instance with this material. */
static inline size_t group_of_surface(const struct group_map *map, const struct scene *scene,
                                      size_t instance, size_t triangle,
                                      const struct scene_material *material)
{
    const uint16_t *of = map->of_instance[instance];
    return of && of[triangle] != GROUP_NONE ? of[triangle]
                                            : map->of_material[material - scene->materials];
}

/* Which part of weights lights a scene: a tracer's light is not negative, so that what weights
 * below 0 take away is traced by itself, and subtracted. */
enum groups_part { GROUPS_ADDED, GROUPS_TAKEN };

/* Scales a scene's light, before it is traced: that of group g by weight[3 * g + channel] (finite)
 * where that is above 0; or, TAKEN, by its magnitude where it is below; else it is black. The
 * scene keeps its keys. The map is that of the scene as it was, and not to be used with it
 * afterwards: materials and meshes that lights of several groups share become several. */
struct error *groups_scale(struct scene *scene, const struct group_map *map, const double *weight,
                           enum groups_part part);

#endif
