/* SPDX-License-Identifier: Apache-2.0 */
/* Which side of a face is its front, where the file does not say it. */
#include "topology/surface.h"

#include <array>
#include <cmath>

namespace
{

/* Disjoint sets of triangles, each of which looks to the same side as the first of its set, or to
 * the other. */
class sided_sets
{
  public:
    explicit sided_sets(size_t count) : parent(count), other(count)
    {
        for (size_t i = 0; i < count; i++)
            parent[i] = (uint32_t)i;
    }

    /* The first of the set; *turned: whether t looks to the other side. */
    uint32_t find(uint32_t t, char *turned)
    {
        uint32_t root = t;
        char side = 0;
        for (; parent[root] != root; root = parent[root])
            side ^= other[root];
        *turned = side;
        while (parent[t] != root && t != root) { /* straight to it, the next time */
            const uint32_t next = parent[t];
            const char step = other[t];
            parent[t] = root;
            other[t] = side;
            side ^= step;
            t = next;
        }
        return root;
    }

    /* False: they are of one set already, and look otherwise than this says. */
    bool join(uint32_t a, uint32_t b, char different)
    {
        char side_a, side_b;
        a = find(a, &side_a);
        b = find(b, &side_b);
        different ^= side_a ^ side_b;
        if (a == b)
            return !different;
        parent[std::max(a, b)] = std::min(a, b);
        other[std::max(a, b)] = different;
        return true;
    }

  private:
    std::vector<uint32_t> parent;
    std::vector<char> other;
};

/* Two faces at an edge that no third one shares. */
struct meeting {
    uint32_t a, b;
    char different; /* they look to different sides */
};

uint32_t third(const std::vector<uint32_t> &vertex, uint32_t corner)
{
    return vertex[next_corner(next_corner(corner))];
}

void meet(const std::vector<uint32_t> &vertex, std::vector<char> &met, std::vector<meeting> &list)
{
    const std::vector<surface_edge> edges =
        surface_edges(vertex, [&](uint32_t c) { return !met[c]; });
    for (size_t i = 0, end; i < edges.size(); i = end) {
        for (end = i + 1; end < edges.size() && edges[end].meets(edges[i]);)
            end++;
        if (end - i != 2)
            continue;
        const surface_edge &e = edges[i], &f = edges[i + 1];
        if (e.forward == f.forward && third(vertex, e.corner) == third(vertex, f.corner))
            continue; /* one face that is there twice */
        met[e.corner] = met[f.corner] = 1;
        list.push_back({e.corner / 3, f.corner / 3, e.forward == f.forward});
    }
}

double area(const surface &s, size_t t)
{
    const surface_point &a = s.vertices[s.corner[3 * t]], &b = s.vertices[s.corner[3 * t + 1]],
                        &c = s.vertices[s.corner[3 * t + 2]];
    return vec3_length(vec3_cross(vec3{b.x - a.x, b.y - a.y, b.z - a.z},
                                  vec3{c.x - a.x, c.y - a.y, c.z - a.z})) /
           2;
}

/* A set of triangles that meet, by its first one. */
struct sheet {
    size_t edges = 0, different = 0;
    bool closed = true, twisted = false; /* a Moebius strip has one side */
    std::array<double, 2> area = {0, 0}; /* of those that look as the first one, and the others */
    double volume = 0;                   /* when all look as the first one */
};

} /* namespace */

surface_sides surface_orient(surface &s, const std::vector<uint32_t> &place)
{
    const size_t triangles = s.corner.size() / 3;
    std::vector<char> met(s.corner.size());
    std::vector<meeting> list;
    meet(s.corner, met, list);
    std::vector<uint32_t> welded = s.corner;
    for (uint32_t &v : welded)
        v = place[v];
    meet(welded, met, list);

    sided_sets sets(triangles);
    std::vector<char> fits(list.size());
    for (size_t i = 0; i < list.size(); i++)
        fits[i] = sets.join(list[i].a, list[i].b, list[i].different);
    std::vector<sheet> sheets(triangles);
    char side;
    for (size_t i = 0; i < list.size(); i++) {
        sheet &of = sheets[sets.find(list[i].a, &side)];
        of.edges++;
        of.different += list[i].different != 0;
        of.twisted = of.twisted || !fits[i];
    }
    for (uint32_t t = 0; t < triangles; t++) {
        const uint32_t first = sets.find(t, &side);
        sheet &of = sheets[first];
        of.closed = of.closed && met[3 * t] && met[3 * t + 1] && met[3 * t + 2];
        of.area[(size_t)side] += area(s, t);
        of.volume += (side ? -1 : 1) * surface_wedge(s, t, s.vertices[s.corner[3 * first]]);
    }
    surface_sides out = {std::vector<char>(triangles), std::vector<char>(triangles)};
    for (uint32_t t = 0; t < triangles; t++) {
        const sheet &of = sheets[sets.find(t, &side)];
        if (!of.different)
            continue;
        if (of.twisted || !of.closed) {
            out.unknown[t] = 20 * of.different > of.edges;
            continue;
        }
        const double all = of.area[0] + of.area[1];
        const char turn_first = of.area[0] >= .75 * all   ? 0
                                : of.area[1] >= .75 * all ? 1
                                                          : of.volume < 0;
        out.turned[t] = side ^ turn_first;
        if (out.turned[t])
            std::swap(s.corner[3 * (size_t)t + 1], s.corner[3 * (size_t)t + 2]);
    }
    return out;
}
