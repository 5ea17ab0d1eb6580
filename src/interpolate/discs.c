/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/discs.h"
#include "base/error.h"

struct error *discs_create(struct discs **discs, const struct disc_points *points)
{
    switch (discs_make(discs, points)) {
    case PROBE_OK: return NULL;
    case PROBE_NO_DISCS:
        return error_new("no surface probe has both irradiance and a radius: probe-capture adds "
                         "the one, --radius tells the other");
    case PROBE_DISCS_APART:
        return error_new("surface probes are too far from one another for discs");
    case PROBE_DISCS_LARGE:
        return error_new("discs are so large beside the distance of their points that they touch "
                         "more than %u cells: expected a smaller --radius",
                         UINT32_MAX);
    default: return error_memory();
    }
}
