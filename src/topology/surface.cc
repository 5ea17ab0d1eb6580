/* SPDX-License-Identifier: Apache-2.0 */
#include "topology/surface.h"

#include <limits>

std::vector<uint32_t> surface_weld(const surface &s)
{
    const std::vector<surface_point> &vertices = s.vertices;
    std::vector<uint32_t> order(vertices.size()), number(vertices.size());
    for (size_t i = 0; i < order.size(); i++)
        order[i] = (uint32_t)i;
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return vertices[a] < vertices[b]; });
    for (size_t i = 0, first = 0; i < order.size(); i++) {
        first = i > 0 && vertices[order[i]] == vertices[order[first]] ? first : i;
        number[order[i]] = order[first];
    }
    return number;
}

void surface_sort_edges(std::vector<surface_edge> &edges, size_t vertices)
{
    std::vector<uint32_t> end(vertices + 1);
    std::vector<surface_edge> sorted(edges.size());
    for (const surface_edge &e : edges)
        end[e.a + 1]++;
    for (size_t v = 0; v < vertices; v++)
        end[v + 1] += end[v];
    for (const surface_edge &e : edges)
        sorted[end[e.a]++] = e;
    for (size_t first = 0, last; first < sorted.size(); first = last) {
        last = end[sorted[first].a];
        std::sort(sorted.begin() + (std::ptrdiff_t)first, sorted.begin() + (std::ptrdiff_t)last);
    }
    edges.swap(sorted);
}

/* Joins the faces on either side of every edge that has one on each and was not joined before.
 * Returns how many edges have two faces that look to different sides. */
static size_t join_edges(const std::vector<uint32_t> &vertex, corner_sets &sets,
                         std::vector<char> &joined)
{
    size_t different = 0;
    const std::vector<surface_edge> edges =
        surface_edges(vertex, [&](uint32_t c) { return !joined[c]; });
    for (size_t i = 0, end; i < edges.size(); i = end) {
        for (end = i + 1; end < edges.size() && edges[end].meets(edges[i]);)
            end++;
        if (end - i != 2)
            continue;
        if (edges[i].forward == edges[i + 1].forward) {
            different++;
            continue;
        }
        const uint32_t c = edges[i].corner, d = edges[i + 1].corner;
        sets.join(c, next_corner(d));
        sets.join(next_corner(c), d);
        joined[c] = joined[d] = 1;
    }
    return different;
}

size_t surface_join(const surface &s, const std::vector<uint32_t> &place, corner_sets &sets)
{
    std::vector<char> joined(s.corner.size());
    size_t different = join_edges(s.corner, sets, joined);
    std::vector<uint32_t> welded = s.corner;
    for (uint32_t &v : welded)
        v = place[v];
    return different + join_edges(welded, sets, joined);
}

void surface_add(surface &s, const struct scene_mesh &mesh, const double *m)
{
    const uint32_t base = (uint32_t)s.vertices.size();
    const bool turned = affine_mirrors(m);
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        const struct vec3 p = affine_point(m, mesh.position + 3 * v);
        s.vertices.push_back({p.x + 0.0, p.y + 0.0, p.z + 0.0});
    }
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        const uint32_t *i = mesh.index + 3 * t;
        s.corner.insert(s.corner.end(),
                        {base + i[0], base + i[turned ? 2 : 1], base + i[turned ? 1 : 2]});
    }
}

std::vector<size_t> surface_placed(const struct scene *scene)
{
    std::vector<size_t> placed(scene->mesh_count);
    for (size_t i = 0; i < scene->instance_count; i++)
        placed[scene->instances[i].mesh]++;
    return placed;
}

struct error *surface_check_count(const struct scene *scene)
{
    const size_t count = scene_triangle_count(scene), most = std::numeric_limits<int>::max() / 6;
    return count > most ? error_new("%zu triangles, expected at most %zu to look for what they "
                                    "enclose, or to decimate them",
                                    count, most)
                        : nullptr;
}

double surface_wedge(const surface &s, size_t triangle, const surface_point &o)
{
    const surface_point &a = s.vertices[s.corner[3 * triangle]],
                        &b = s.vertices[s.corner[3 * triangle + 1]],
                        &c = s.vertices[s.corner[3 * triangle + 2]];
    const struct vec3 p = {a.x - o.x, a.y - o.y, a.z - o.z}, q = {b.x - o.x, b.y - o.y, b.z - o.z},
                      r = {c.x - o.x, c.y - o.y, c.z - o.z};
    return vec3_dot(p, vec3_cross(q, r));
}
