/* SPDX-License-Identifier: Apache-2.0 */
/* facts: what a report says of a scene and of a bake without measuring anything.
 */
#ifndef FACTS_H
#define FACTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct scene_settings;

struct scene_facts {
    size_t triangles, emissive; /* and how many of them emit */
    size_t points, spots, suns;
    bool sky;  /* it is not black */
    bool dark; /* there is no light at all */
    double low[3], high[3];
};

/* Reads the scene's file; its warnings are left to who reads it next. */
struct error *scene_facts_of(const char *path, const struct scene_settings *settings,
                             struct scene_facts *facts);

struct bake_facts {
    size_t probes, cells;
    size_t black;     /* probes that no light reaches */
    size_t in_matter; /* that see more backs than fronts */
    uint64_t bytes;   /* of the file */
};

/* Reads the stream, a file. */
struct error *bake_facts_of(const char *path, struct bake_facts *facts);

/* The size of a file. */
struct error *file_bytes(const char *path, uint64_t *bytes);

#endif
