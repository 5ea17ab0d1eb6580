/* SPDX-License-Identifier: Apache-2.0 */
/* scene_choice: what of a scene is left out, or alone kept, by the names that its file gives.
 *
 * A pattern is a path as scene_list_names prints it, where there is one; else a name as it stands;
 * else a shell's pattern (fnmatch(3), case counts, * and ? match a slash too). It names what it
 * matches: nodes, meshes, objects, groups, materials and lights. A pattern with a slash is held
 * against paths as well: "hall/lamp*" is all lamps that hang from a hall. With a node goes what
 * hangs from it, with an object its groups, with nodes their lights.
 */
#ifndef SCENE_CHOICE_H
#define SCENE_CHOICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

struct error;
struct option_row;
struct scene;
struct stream_header;
struct warnings;

struct scene_pattern {
    char *text; /* owned */
    bool only;  /* --only, else --exclude */
};

/* Starts as {0}. */
struct scene_choice {
    struct scene_pattern *list; /* owned */
    size_t count, capacity;
    bool inherited; /* from a header: the first of the command line takes the place of them all */
    char *before;   /* the header's, as options; NULL: it says nothing. Owned */
};

void scene_choice_clear(struct scene_choice *choice);

enum { SCENE_CHOICE_ROWS = 2 };

/* Fills rows with --exclude and --only. */
void scene_choice_rows(struct scene_choice *choice, struct option_row *rows);

/* Header keys exclude-1 PATTERN, only-2 PATTERN, numbered in one sequence. What the command line
 * gave stays when a header is read over it. */
struct error *scene_choice_to_header(const struct scene_choice *choice,
                                     struct stream_header *header);
struct error *scene_choice_from_header(struct scene_choice *choice,
                                       const struct stream_header *header);

/* Leaves out of a scene that an importer has read what the choice says: where there are --only, all
 * that none of them matches; then what an --exclude matches. Errors: a pattern that matches nothing
 * (it names the nearest), a choice that leaves no triangle. One warning says how much went, another
 * where the choice is not the header's. */
struct error *scene_choose(struct scene *scene, const struct scene_choice *choice,
                           struct warnings *warnings);

/* -- names ----------------------------------------------------------------------------------- */

/* "node", "mesh", ...; by scene_part_kind */
extern const char *const scene_part_kinds[];

/* Writes the path of a part, "hall/lamp", to text[0..size), its beginning cut off where it is too
 * long; "" for part 0. Control characters become '?'. */
void scene_part_path(const struct scene *scene, uint32_t part, char *text, size_t size);

/* The name of a material, or its number, where it has none: "material 3". */
void scene_material_name(const struct scene *scene, int32_t material, char *text, size_t size);

/* The object or group that a triangle of a mesh belongs to, or 0. */
struct scene_mesh;
uint32_t scene_part_of(const struct scene_mesh *mesh, size_t triangle);

/* Sets the flags (to 1) of what a pattern names: of parts (scene->part_count + 1 flags, by number;
 * what hangs from one is not among it) and of materials; NULL: these are not looked at. How many it
 * names. */
size_t scene_match_names(const struct scene *scene, const char *pattern, unsigned char *part,
                         unsigned char *material);

/* How many triangles hang from each part, as placed: scene->part_count + 1 numbers, and how many
 * have each material. Arrays that the caller frees. */
struct error *scene_count_names(const struct scene *scene, size_t **of_part, size_t **of_material);

/* Prints a line for each name: its kind, how many triangles it has, its path; separated by tabs. */
struct error *scene_list_names(const struct scene *scene, FILE *out);

#endif
