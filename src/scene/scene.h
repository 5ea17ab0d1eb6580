/* scene: triangles, materials, textures, lights and sky, as read from a file.
 *
 * scene_read imports OBJ (with MTL), glTF and GLB, PLY, OFF and STL. What it makes is plain data:
 * meshes in their own coordinates, instances that place them, materials by index. Positions are
 * double from file to here; nothing is flipped, welded, scaled or clamped. Degenerate triangles
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
 * Files: scene.c (this data and its key), scene_settings.c (options, header keys), scene_finish.c
 * (what makes a scene legal), scene_shade.c (maps, sky, lights). Reading files is import/, pieces
 * and decimation are topology/.
 */
#ifndef SCENE_H
#define SCENE_H

#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct option_row;
struct stream_header;
struct warnings;

enum { SCENE_NONE = -1 }; /* no texture, no material */

/* Triangles in coordinates of their own. Owned arrays. */
struct scene_mesh {
    double *position; /* 3 * vertex_count */
    size_t vertex_count;
    uint32_t *index; /* 3 * triangle_count, counter-clockwise seen from the front */
    size_t triangle_count;
    /* 6 * triangle_count: (u, v) of each corner, v up as in OBJ; NULL when the mesh has none. The
     * importer converts: texture row 0 (the image's top) is v = 1. */
    float *uv;
    int32_t *material; /* triangle_count: index into scene->materials, never SCENE_NONE */
};

/* A mesh placed in the scene: p -> M p + t, as rows of a 3x4 matrix. The front of a triangle is its
 * mesh's: a transform that mirrors (negative determinant) turns the winding round, not the front
 * (glTF 2.0, 3.7.4). */
struct scene_instance {
    size_t mesh;
    double transform[12];
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
};

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
};

/* Radiance from where there is no surface. */
struct scene_sky {
    double radiance[3]; /* uniform, or the factor of the picture */
    /* owned; NULL: uniform. Equirectangular, float RGB; +Y up, the picture's centre column looks
     * along +X, its right quarter along +Z (man probe-tools(7)) */
    struct scene_texture *picture;
};

/* What the user may change of a scene, the same options in every program that reads one; kept in
 * the stream's header so that a later stage sees the same light. */
struct scene_settings {
    double sky[3];
    char *sky_file;             /* owned; NULL: uniform sky */
    struct scene_light *lights; /* from --sun, --point, --spot; owned */
    size_t light_count, light_capacity;
    /* of the lights, those of a header: the first one of the command line takes the place of them
     * all */
    size_t inherited;
    bool emit_front_only; /* --emit front */
    double albedo_scale;  /* multiplies every albedo factor */
    double max_albedo;    /* limits every albedo after that, at most 1 */
    /* multiplies the file's emission and lights; not the sky, nor lights from options */
    double light_scale;
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
    struct scene_sky sky;
    bool emit_front_only;
    float max_albedo; /* scene_albedo is at most this, channel by channel */
    /* of all instances in the scene's coordinates; min > max when there is no triangle */
    struct vec3 box_min, box_max;
    size_t degenerate_count; /* triangles left out */
    /* by scene_decimate; scene_key is then whole_key, of what it was */
    bool decimated;
    uint64_t whole_key;
    /* room in the lists */
    size_t mesh_capacity, instance_capacity, material_capacity, texture_capacity, light_capacity;
};

/* -- settings --------------------------------------------------------------------------------- */

/* black sky, no lights, scales 1, max_albedo 1, emit both sides */
struct scene_settings scene_settings_default(void);
void scene_settings_clear(struct scene_settings *settings);

enum { SCENE_SETTINGS_ROWS = 9 };

/* Fills rows (SCENE_SETTINGS_ROWS) with --sky, --sun, --point, --spot, --emit, --albedo-scale,
 * --max-albedo, --light-scale. */
const struct option_row *scene_settings_rows(struct scene_settings *settings,
                                             struct option_row *rows);

/* Writes the settings as header keys, numbers separated by commas as in the options:
 *
 *     sky 0.5,0.6,0.8                     radiance; 0,0,0 beside
 *     sky-file clouds.hdr                 (only when there is one)
 *     sun-1 DX,DY,DZ,R,G,B                lights are numbered in one sequence; directions have
 *                                         length 1
 *     point-2 X,Y,Z,R,G,B
 *     spot-3 X,Y,Z,DX,DY,DZ,COS_INNER,COS_OUTER,R,G,B     cosines where the option has degrees
 *     emit both                           or front
 *     albedo-scale 1
 *     max-albedo 1
 *     light-scale 1
 *
 * and reads them back into default settings: scene_settings_from_header(x) of
 * scene_settings_to_header(x) is x to the bit. Keys that are missing keep their default; lights
 * that the header held before are removed. */
struct error *scene_settings_to_header(const struct scene_settings *settings,
                                       struct stream_header *header);
struct error *scene_settings_from_header(struct scene_settings *settings,
                                         const struct stream_header *header);

/* -- scenes ----------------------------------------------------------------------------------- */

/* Reads a scene by its file name's ending, or by its content where the ending is unknown, and
 * applies the settings. Errors name the file and what is wrong with it: unreadable, without any
 * triangle (legal only for a caller that passes empty_allowed), cut off, a missing buffer, a
 * required extension that is unknown. Missing textures and whatever is not used are warnings. */
struct error *scene_read(struct scene **scene, const char *path,
                         const struct scene_settings *settings, bool empty_allowed,
                         struct warnings *warnings);

/* A scene without anything, for callers that build one (tests); free with scene_destroy. */
struct error *scene_create(struct scene **scene);

/* Adds a mesh with one material, placed once as it stands; copies the arrays. */
struct error *scene_add_mesh(struct scene *scene, size_t vertex_count, const double *position,
                             size_t triangle_count, const uint32_t *index,
                             const struct scene_material *material);

/* To be called once after the parts were put together by hand or by an importer: leaves out
 * degenerate triangles, computes the box, applies settings, checks every index and that everything
 * is finite. */
struct error *scene_finish(struct scene *scene, const struct scene_settings *settings,
                           struct warnings *warnings);

void scene_destroy(struct scene *scene);

/* A key of everything that light depends on (geometry, materials, textures, lights, sky): equal
 * scenes have equal keys on every machine. XXH3-64. A decimated scene keeps the key of the scene
 * that it was. */
uint64_t scene_key(const struct scene *scene);

/* with instances counted as often as placed */
size_t scene_triangle_count(const struct scene *scene);

/* -- shading ---------------------------------------------------------------------------------- */

/* Value of a map at (u, v): linear RGB, and alpha (1 where the texture has none). */
void scene_map_sample(const struct scene *scene, const struct scene_map *map, float u, float v,
                      float rgba[4]);

struct vec3f scene_albedo(const struct scene *scene, const struct scene_material *m, float u,
                          float v);

/* The same of one texel, drawn with the weight that it has in the interpolation: the right albedo
 * in the mean, at a quarter of the reads from memory. scene_texel_draw (`bits`: 32 random bits)
 * sends for it, scene_texel_albedo reads it: what is done between the two hides the way to
 * memory. */
struct scene_texel {
    const struct scene_material *material;
    const uint8_t *code; /* NULL: to be interpolated, at: */
    float u, v;
};
struct scene_texel scene_texel_draw(const struct scene *scene, const struct scene_material *m,
                                    float u, float v, uint32_t bits);
struct vec3f scene_texel_albedo(const struct scene *scene, const struct scene_texel *texel);

struct vec3f scene_emission(const struct scene *scene, const struct scene_material *m, float u,
                            float v);
/* The share of light that passes through the surface here: 0 opaque, 1 hole. */
float scene_transparency(const struct scene *scene, const struct scene_material *m, float u,
                         float v);
static inline bool scene_emits(const struct scene_material *m)
{
    return m->emission.x > 0 || m->emission.y > 0 || m->emission.z > 0;
}

/* Radiance of the sky from a unit direction (pointing away from the viewer). */
struct vec3f scene_sky_radiance(const struct scene *scene, struct vec3f direction);

/* Irradiance-like strength of a punctual light at p, unoccluded: *to_light is the unit direction
 * towards it, *distance how far (INFINITY for a sun); rgb: what falls on a surface that faces it.
 * At the light itself: distance 0, no direction, black. */
void scene_light_at(const struct scene_light *light, const double p[3], double to_light[3],
                    double *distance, double rgb[3]);

/* -- topology (OpenMesh) ---------------------------------------------------------------------- */

/* Connected pieces of the scene's surface: faces that share vertices in their file, or stand at
 * equal positions, across an edge of exactly two faces of consistent orientation. Closed: every
 * edge has a face on each side, so that "inside" has a meaning. Meshes that are placed once are
 * joined with each other; a mesh that is placed often is looked at by itself. */
struct scene_solids {
    size_t count, closed_count;
    /* for triangle t of instance i: piece_of[offset[i] + t]; closed[piece]; volume[piece] signed:
     * negative when turned inside out, 0 when not closed */
    size_t *offset;
    uint32_t *piece_of;
    bool *closed;
    double *volume;
};
struct error *scene_solids(const struct scene *scene, struct scene_solids *solids,
                           struct warnings *warnings);
void scene_solids_clear(struct scene_solids *solids);

/* Takes triangles away until `share` of them is left (above 0; 1 leaves the scene as it is), those
 * first that change the surface least: quadric errors (Garland and Heckbert 1997), one order for
 * all meshes that are placed once, which become one mesh in the scene's coordinates; a mesh that is
 * placed often is decimated by itself, to the same share. Vertices that stay are where they were;
 * closed pieces stay closed. Borders, changes of material and seams of a texture keep their course
 * as the surface does. What stays whatever the share: emissive triangles, branches of borders and
 * seams, and borders along which other surfaces run. When more than the share is left for that, it
 * is a warning that says how much. The same scene gives the same triangles on every machine. */
struct error *scene_decimate(struct scene *scene, double share, struct warnings *warnings);

#endif
