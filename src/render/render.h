/* SPDX-License-Identifier: Apache-2.0 */
/* render: what a camera sees of a scene, by its true light or by that of probes.
 *
 * A picture is cut into tiles, which threads share; each pixel takes samples spread over its area
 * (Roberts' R2 sequence, shifted by chance). A pixel is random by (seed, pixel, sample), so the
 * same picture comes out for any number of threads, and the samples of all kinds of light go
 * through the same points of a pixel: edges and textures cancel when two pictures are compared.
 *
 * Surfaces are Lambertian: what light makes of them is radiance E albedo / pi, and emission.
 */
#ifndef RENDER_H
#define RENDER_H

#include "image/picture.h"
#include "interpolate/baked.h"
#include "render/camera.h"
#include "trace/path.h"

#include <stdint.h>

struct error;
struct progress;

enum render_light {
    RENDER_TRUTH, /* all light, path traced */
    /* light that comes straight from emitters, sky, point, spot and sun lights: traced, without
     * another bounce */
    RENDER_DIRECT,
    RENDER_PROBES, /* E is what the probes say */
    /* direct light traced, and E of the probes besides: for probes of indirect light */
    RENDER_MIXED,
};

/* A thing that moves through the scene: instances `first` to the last, which probes light as games
 * do, by one lookup for all of it. */
struct render_object {
    size_t first; /* SIZE_MAX: there is none */
    struct vec3 centre;
    bool sphere;    /* about the centre: its normals are smooth */
    bool per_pixel; /* a lookup at each point of it, as for the scene */
};

struct render {
    const struct path_tracer *path;
    const struct camera *camera;
    const struct baked *baked; /* complete; PROBES and MIXED alone */
    struct render_object object;
    double offset; /* probes are looked up this far off a surface, along its normal; scene units */
    int samples;   /* a pixel; of the first round where error is set */
    /* 0: samples alone count. Else rounds of as many are added to each pixel until the standard
     * error of its luminance is at most this share of it, or of a tenth of its tile's mean where
     * that is more, or it has samples_most. */
    double error;
    int samples_most;
    uint64_t seed;
    int threads;
};

/* A ray of the camera against the scene. */
struct render_ray {
    struct vec3f origin, direction; /* local to the tracer */
    double skipped;                 /* world length between the eye and the origin */
};

struct render_ray render_ray(const struct render *render, struct vec3 direction);

/* Takes the picture. variance (may be NULL): of each pixel's mean, as its samples tell. Pictures
 * are made here, and the caller's to clear. Errors: an eye farther out than 1e9 times the scene's
 * size, light that 32 bits cannot hold. */
struct error *render_picture(const struct render *render, enum render_light light,
                             struct picture *picture, struct picture *variance,
                             struct progress *progress);

enum { RENDER_TILE = 16 };

/* How many tiles render_picture goes through, for its progress. */
size_t render_tiles(const struct camera *camera);

#endif
