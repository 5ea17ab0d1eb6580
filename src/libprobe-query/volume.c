/* SPDX-License-Identifier: Apache-2.0 */
/* What all parts ask a volume and its cells. */
#include "volume.h"

#include <string.h>

const int volume_facet_corner[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

/* Lattice units along the axes that tell places of a lower-dimensional mesh apart. */
static lattice_volume cross_2d(const struct probe_volume *v, const double a[3], const double b[3],
                               const double c[3])
{
    const int x = v->axis[0], y = v->axis[1];
    return (lattice_volume)lattice_whole(b[x] - a[x]) * lattice_whole(c[y] - a[y]) -
           (lattice_volume)lattice_whole(b[y] - a[y]) * lattice_whole(c[x] - a[x]);
}

void volume_measure(const struct probe_volume *v, size_t cell, const double p[3],
                    lattice_volume volume[4])
{
    const double *s[4] = {p, p, p, p};
    for (int i = 0; i < v->corners; i++)
        s[i] = volume_span_site(v, volume_vertex(v, cell, i));
    volume[0] = volume[1] = volume[2] = volume[3] = 0;
    switch (v->corners) {
    case 4:
        volume[0] = lattice_orient(p, s[1], s[2], s[3]);
        volume[1] = lattice_orient(s[0], p, s[2], s[3]);
        volume[2] = lattice_orient(s[0], s[1], p, s[3]);
        volume[3] = lattice_orient(s[0], s[1], s[2], p);
        break;
    case 3:
        volume[0] = cross_2d(v, p, s[1], s[2]);
        volume[1] = cross_2d(v, s[0], p, s[2]);
        volume[2] = cross_2d(v, s[0], s[1], p);
        break;
    case 2:
        volume[0] = lattice_whole(s[1][v->axis[0]] - p[v->axis[0]]);
        volume[1] = lattice_whole(p[v->axis[0]] - s[0][v->axis[0]]);
        break;
    default: volume[0] = 1;
    }
    /* which way these run round is not said */
    if (v->corners < 4 && volume[0] + volume[1] + volume[2] < 0)
        for (int i = 0; i < 3; i++)
            volume[i] = -volume[i];
}

int volume_facet_vertex(const struct probe_volume *v, const struct volume_facet *facet,
                        int32_t vertex[3])
{
    const size_t cell = (size_t)facet->cell;
    const int count = facet->corner < 0 ? v->corners : v->corners > 1 ? v->corners - 1 : 1;
    for (int k = 0; k < 3; k++) {
        const int other = k < count ? k : count - 1;
        const int corner = v->corners == 4   ? volume_facet_corner[facet->corner][k]
                           : v->corners == 1 ? 0
                                             : (facet->corner + 1 + other) % v->corners;
        vertex[k] = volume_vertex(v, cell, corner);
    }
    return count;
}

const char *probe_status_text(enum probe_status status)
{
    switch (status) {
    case PROBE_OK: return "done";
    case PROBE_NO_MEMORY: return "out of memory";
    case PROBE_BAD_ARGUMENT: return "a count that cannot be";
    case PROBE_NO_CELLS: return "there are no cells";
    case PROBE_BAD_POSITION: return "a position is not finite";
    case PROBE_BAD_VERTEX: return "a cell names a probe that does not exist";
    case PROBE_BAD_NEIGHBOUR:
        return "a cell names a neighbour that does not exist or does not share the face";
    case PROBE_BAD_SHAPE: return "a cell has no positive volume";
    case PROBE_BAD_POINT: return "a point is not finite";
    case PROBE_NOT_AN_IMAGE: return "this is not a packed file of a version that is known";
    case PROBE_BAD_IMAGE: return "the packed file is damaged";
    case PROBE_BAD_SIGHT: return "sight is not finite, or the stand-in no probe";
    case PROBE_NO_DISCS: return "there are no discs, or none that faces as the point does";
    case PROBE_BAD_DISC: return "a normal or irradiance is not finite";
    case PROBE_DISCS_APART: return "surface probes are too far from one another for discs";
    case PROBE_NO_GROUPS: return "the packed file has no groups of lights";
    case PROBE_DISCS_LARGE: return "discs are too large for the distance of their points";
    }
    return "an unknown status";
}

size_t probe_volume_probes(const struct probe_volume *v)
{
    return v->probes;
}

size_t probe_volume_cells(const struct probe_volume *v)
{
    return v->cells;
}

int probe_volume_corners(const struct probe_volume *v)
{
    return v->corners;
}

int probe_volume_extends(const struct probe_volume *v)
{
    return v->rays;
}

size_t probe_volume_bytes(const struct probe_volume *v)
{
    return v->bytes;
}

size_t probe_volume_groups(const struct probe_volume *v)
{
    return v->groups;
}

const char *probe_volume_group_name(const struct probe_volume *v, size_t group)
{
    const char *name = v->group_names;
    if (group >= v->groups)
        return NULL;
    while (group--)
        name += strlen(name) + 1;
    return name;
}
