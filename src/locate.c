#include "locate.h"
#include "error.h"
#include "mesh.h"

struct error *locate_create(struct locate **locate, size_t probe_count, const double *position, size_t cell_count,
                            const int32_t *vertex, const int32_t *neighbour)
{
    const struct probe_mesh mesh = {.probes = probe_count, .position = position, .corners = 4, .cells = cell_count,
                                    .vertex = vertex, .neighbour = neighbour};
    return locate_create_mesh(locate, &mesh);
}

struct error *locate_create_mesh(struct locate **locate, const struct probe_mesh *mesh)
{
    struct probe_volume *volume;
    struct error *err = mesh_volume(mesh, PROBE_NEAREST, &volume);
    *locate = (struct locate *)volume;
    return err;
}

void locate_destroy(struct locate *l)
{
    probe_volume_destroy((struct probe_volume *)l);
}

void locate_point(const struct locate *l, const double position[3], struct locate_weights *w)
{
    struct probe_place place = {.cell = w->cell};
    probe_volume_locate((const struct probe_volume *)l, position, &place);
    w->cell = place.cell;
    for (int i = 0; i < 4; i++) {
        w->vertex[i] = place.probe[i];
        w->weight[i] = place.weight[i];
    }
    w->inside = place.inside;
    w->distance = place.distance;
}

void locate_blend(const struct locate_weights *w, const float *value, size_t width, float *out)
{
    const float *v[4];
    int most = 0;
    for (int i = 1; i < 4; i++)
        most = w->weight[i] > w->weight[most] ? i : most;
    for (int i = 0; i < 4; i++) /* what has no weight has no say, not even as a missing value */
        v[i] = value + (size_t)w->vertex[w->weight[i] > 0 ? i : most] * width;
    for (size_t k = 0; k < width; k++)
        out[k] = (float)(w->weight[0] * (double)v[0][k] + w->weight[1] * (double)v[1][k] + w->weight[2] * (double)v[2][k] +
                         w->weight[3] * (double)v[3][k]);
}
