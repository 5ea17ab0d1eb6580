/* SPDX-License-Identifier: Apache-2.0 */
#include "light/light_options.h"
#include "base/error.h"
#include "base/options.h"
#include "light/dering.h"

#include <string.h>

const struct option_row *light_dering_rows(struct dering_settings *settings,
                                           struct option_row *rows)
{
    static const char *const targets[] = {[DERING_NONE] = "none",
                                          [DERING_IRRADIANCE] = "irradiance",
                                          [DERING_RADIANCE] = "radiance",
                                          NULL};
    const struct option_row all[LIGHT_DERING_ROWS] = {
        {.name = "dering",
         .argument = "WHAT",
         .kind = OPTION_CHOICE,
         .choices = targets,
         .value = OPTION_ENUM(settings->target),
         .help = "window each probe as little as keeps its irradiance, or\n"
                 "its radiance, above --dering-floor in all directions"},
        {.name = "dering-floor",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &settings->floor,
         .most = DERING_FLOOR_MOST,
         .help = "of its mean over directions"},
        {0}};
    memcpy(rows, all, sizeof all);
    return rows;
}

struct error *light_dering_check(const struct dering_settings *settings)
{
    return settings->floor > 0 && settings->target == DERING_NONE
               ? error_usage("--dering-floor needs --dering")
               : NULL;
}
