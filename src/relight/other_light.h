/* SPDX-License-Identifier: Apache-2.0 */
/* other_light: the sky, the suns and the lamps that a relit stream is to have, as weights of what
 * its transfers hold.
 */
#ifndef OTHER_LIGHT_H
#define OTHER_LIGHT_H

#include "relight/sun_blend.h"
#include "scene/scene_settings.h"

#include <stdbool.h>

struct error;
struct relight;
struct stream_header;
struct warnings;

/* What is asked for. Texts are borrowed. */
struct other_light {
    struct scene_settings settings; /* the sky (where sky_given), suns and points */
    const char *sky_probe;          /* the stream of a probe whose light is the sky; NULL: none */
    const char *sun_path;           /* of the sun at a time; NULL: none */
    double time;
    bool time_given;
    enum sun_between between;
};

struct other_light other_light_default(void);
void other_light_clear(struct other_light *light);

/* Whether a sky is asked for. */
bool other_light_has_sky(const struct other_light *light);

/* A copy, over which what a row of a table gives the options --sky, --sun, --point and --time
 * (NULL: it says nothing) is read: lights take the place of those of the command line. */
struct error *other_light_of_row(struct other_light *row, const struct other_light *all,
                                 const char *sky, const char *sun, const char *point,
                                 const char *time);

/* weight: three for each function of the transfer's sky, then for each of its suns and
 * points. Adds the sun of the time to the settings, and the key of the sky's picture. Errors: a
 * transfer that there is not; a sky or lights of the scene where probes were turned; a picture or a
 * path that cannot be read. */
struct error *other_light_weigh(struct other_light *light, const struct relight *relight,
                                double *weight, struct warnings *warnings);

/* Says in a header what the light became (scene/relit.h). weight: as above. */
struct error *other_light_to_header(const struct other_light *light, const struct relight *relight,
                                    const double *weight, struct stream_header *header);

#endif
