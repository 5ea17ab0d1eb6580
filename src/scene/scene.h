/* SPDX-License-Identifier: Apache-2.0 */
/* scene: triangles, materials, textures, lights and sky, as read from a file.
 *
 * What scene_read (import/import_scene.h) makes of a file, and scene_build.h by hand, is plain
 * data: meshes in their own coordinates, instances that place them, materials by index. Positions
 * are double from file to here; nothing is flipped, welded, scaled or clamped. Degenerate triangles
 * (no area beyond the rounding of double, not finite, a corner that is no vertex) are left out,
 * with one warning; their count is kept. So every mesh of a finished scene has triangles, every
 * vertex is used, every instance's matrix can be inverted (what is squeezed flat gets a mesh of its
 * own), and all numbers are finite.
 *
 * Light and colour: linear RGB, Rec. 709 (design: "Conventions of light and space", man
 * probe-tools(7)). sRGB textures are made linear on reading. Every surface is Lambertian, opaque
 * but for its cut-out, and scatters and emits on both sides (scene_settings.emit_front_only
 * confines emission to the front).
 *
 * Beside it: scene_build.h (making one), scene_settings.h (what options change of it),
 * scene_shade.h (what it looks like); topology/ has its closed pieces and decimation.
 */
#ifndef SCENE_H
#define SCENE_H

#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { SCENE_NONE = -1 }; /* no texture, no material */

/* What a file has a name for, beside materials. Parts are known by their place in scene->parts,
 * counted from 1; 0 is none. */
enum scene_part_kind { SCENE_NODE, SCENE_MESH, SCENE_OBJECT, SCENE_GROUP, SCENE_LIGHT };
struct scene_part {
    enum scene_part_kind kind;
    char *name;     /* UTF-8, owned; of what has none its kind and number: "node 12" */
    uint32_t above; /* what it hangs from, which comes before it: a node's parent, a group's object,
                     * a light's node */
};

/* Triangles of a mesh that belong to a part: from `first` on, until the next run begins. */
struct scene_run {
    size_t first;
    uint32_t part;
};

/* Triangles in coordinates of their own. Owned arrays. */
struct scene_mesh {
    double *position; /* 3 * vertex_count */
    size_t vertex_count;
    uint32_t *index; /* 3 * triangle_count, counter-clockwise seen from the front */
    size_t triangle_count;
    /* 6 * triangle_count: (u, v) of each corner, v up as in OBJ; NULL when the mesh has none. The
     * importer converts: texture row 0 (the image's top) is v = 1. */
    float *uv;
    /* the same for the emission maps of its materials; NULL: they read uv */
    float *emission_uv;
    /* 4 * vertex_count: linear RGB and alpha, 65535 is 1, between which triangles interpolate;
     * factors of albedo and opacity. NULL: 1 everywhere */
    uint16_t *colour;
    int32_t *material; /* triangle_count: index into scene->materials, never SCENE_NONE */
    uint32_t part;     /* a mesh's name */
    /* objects and groups, where the file has them; owned, in order, the first from triangle 0 */
    struct scene_run *runs;
    size_t run_count;
};

/* A mesh placed in the scene: p -> M p + t, as rows of a 3x4 matrix. The front of a triangle is its
 * mesh's: a transform that mirrors (negative determinant) turns the winding round, not the front
 * (glTF 2.0, 3.7.4). */
struct scene_instance {
    size_t mesh;
    double transform[12];
    uint32_t part; /* the node that places it */
};

enum scene_wrap { SCENE_REPEAT, SCENE_CLAMP, SCENE_MIRROR };

/* A picture, already linear. Sampled bilinearly (or nearest where the file says so) at (u, v). */
struct scene_texture {
    uint32_t width, height;
    unsigned channels; /* 1 (alpha alone), 3 or 4 (RGB, alpha) */
    /* texels are 8-bit codes to be looked up in image_linear (RGB sRGB, alpha linear), else
     * float */
    bool bytes;
    void *texels; /* owned: width * height * channels of uint8_t or float, top row first */
    enum scene_wrap wrap_u, wrap_v;
    bool nearest;
};

/* How a material reads a texture: which, and the affine map of (u, v) before sampling
 * (KHR_texture_transform, OBJ -o and -s), as rows of a 2x3 matrix. */
struct scene_map {
    int32_t texture; /* SCENE_NONE: no texture, the factor alone */
    float transform[6];
};

enum scene_alpha { SCENE_OPAQUE, SCENE_CUTOUT, SCENE_BLEND };

struct scene_material {
    char *name;          /* UTF-8, owned; may be empty */
    struct vec3f albedo; /* factor; times albedo_map where there is one */
    struct scene_map albedo_map;
    struct vec3f emission; /* radiance factor; times emission_map */
    struct scene_map emission_map;
    /* CUTOUT: a ray passes where alpha < cutoff; BLEND: passes with probability 1-alpha */
    enum scene_alpha alpha;
    float opacity, cutoff; /* factor of alpha */
    /* reads the texture's alpha (channels 4) or its single channel (channels 1) */
    struct scene_map alpha_map;
    bool textured; /* some map has a texture; set by scene_finish */
    /* the file says that its back is seen as well: that a back is seen means nothing then */
    bool two_sided;
    bool unlit; /* the file says that light has no say in its colour */
};

static inline bool scene_emits(const struct scene_material *m)
{
    return m->emission.x > 0 || m->emission.y > 0 || m->emission.z > 0;
}

enum scene_light_kind { SCENE_POINT, SCENE_SPOT, SCENE_SUN };

/* A light without a surface. */
struct scene_light {
    enum scene_light_kind kind;
    struct vec3 position;  /* POINT, SPOT */
    struct vec3 direction; /* SPOT, SUN: unit, the way the light travels */
    /* POINT, SPOT: radiant intensity (cd), E = I / d^2; SUN: irradiance on a perpendicular surface
     * (lux) */
    double intensity[3];
    /* KHR_lights_punctual range; 0: none. Kept, not used: it is a run-time hint, not physics */
    double range;
    /* SPOT: glTF cone falloff, clamp((cos - cos_outer) / (cos_inner - cos_outer))^2 */
    double cos_inner, cos_outer;
    uint32_t part; /* its name, or its node */
};

/* Radiance from where there is no surface. */
struct scene_sky {
    double radiance[3]; /* uniform, or the factor of the picture */
    /* owned; NULL: uniform. Equirectangular, float RGB; +Y up, the picture's centre column looks
     * along +X, its right quarter along +Z (man probe-tools(7)) */
    struct scene_texture *picture;
    /* whether the picture is turned; then where its centre, its upper edge and its right quarter
     * look, instead of +X, +Y and +Z */
    bool turned;
    struct vec3 front, up, right;
    /* where the picture was found: its absolute name, and its name from the scene's folder (NULL:
     * they have nothing in common, or the scene is no file); XXH3-64 of its bytes; owned */
    char *file, *from_scene;
    uint64_t key;
    bool changed; /* it is not that of the header's key, as a warning has said */
};

struct scene {
    char *path;
    struct scene_mesh *meshes;
    size_t mesh_count;
    struct scene_instance *instances;
    size_t instance_count;
    struct scene_material *materials;
    size_t material_count;
    struct scene_texture *textures;
    size_t texture_count;
    struct scene_light *lights; /* the file's, then the settings' */
    size_t light_count;
    struct scene_part *parts;
    size_t part_count;
    struct scene_sky sky;
    bool emit_front_only;
    float max_albedo; /* scene_albedo is at most this, channel by channel */
    /* of all instances in the scene's coordinates; min > max when there is no triangle */
    struct vec3 box_min, box_max;
    size_t degenerate_count; /* triangles left out */
    bool keys_kept;          /* by scene_keep_keys: */
    uint64_t kept_key, kept_key_with_sky, kept_surface_key;
    /* room in the lists */
    size_t mesh_capacity, instance_capacity, material_capacity, texture_capacity, light_capacity,
        part_capacity;
};

/* takes NULL */
void scene_destroy(struct scene *scene);

/* Leaves a sky black. */
void scene_sky_clear(struct scene_sky *sky);

/* Frees a mesh that is not in a scene. */
void scene_mesh_clear(struct scene_mesh *mesh);

/* A key of everything that light depends on (geometry, materials, textures, lights, sky) but for
 * the sky's picture, which has its own: equal scenes have equal keys on every machine. XXH3-64. A
 * decimated or dimmed scene keeps the key of the scene that it was. scene_key_with_sky is of the
 * picture, too, as keys of streams were at first. */
uint64_t scene_key(const struct scene *scene);
uint64_t scene_key_with_sky(const struct scene *scene);

/* The same of what decides what is seen from where: geometry, and what surfaces let through. */
uint64_t scene_surface_key(const struct scene *scene);

/* From here on the scene's keys are those that it has now, whatever is changed of it. */
void scene_keep_keys(struct scene *scene);

/* with instances counted as often as placed */
size_t scene_triangle_count(const struct scene *scene);

#endif
