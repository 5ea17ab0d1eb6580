/* SPDX-License-Identifier: Apache-2.0 */
/* surface: the triangles of several meshes as one surface, joined where faces meet. What needs
 * OpenMesh's half-edges starts here: solids.cc (closed pieces), decimate.cc. C++ only.
 *
 * OpenMesh wants manifold faces, real files give what they have. So each corner of a face first
 * gets a vertex of its own, and corners become one where faces meet: across an edge that joins
 * exactly two faces of consistent orientation. First faces are joined that share vertices in the
 * file, then what is left by equal positions. Boxes that touch, stand on each other or share an
 * edge stay apart that way, and closed each; walls of a room that the file keeps in several meshes
 * become one.
 *
 * Meshes that are placed once are joined in the scene's coordinates; a mesh that is placed often is
 * looked at once, by itself.
 */
#ifndef SURFACE_H
#define SURFACE_H

#include "base/error_guard.h"
extern "C" {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic" /* vec.h has compound literals */
#include "base/array.h"
#include "base/warning.h"
#include "math/affine.h"
#include "scene/scene.h"
#include "scene/scene_build.h"
#pragma GCC diagnostic pop
}

#include <OpenMesh/Core/System/omstream.hh>

#include <algorithm>
#include <vector>

struct surface_point {
    double x, y, z;
    bool operator<(const surface_point &b) const
    {
        return x != b.x ? x < b.x : y != b.y ? y < b.y : z < b.z;
    }
    bool operator==(const surface_point &b) const { return x == b.x && y == b.y && z == b.z; }
};

/* Triangles, front side out: corner k of triangle t is corner[3 t + k]. */
struct surface {
    std::vector<surface_point> vertices;
    std::vector<uint32_t> corner;
};

/* Disjoint sets of corners; each is known by the first of them. */
class corner_sets
{
  public:
    explicit corner_sets(size_t count) : parent(count)
    {
        for (size_t i = 0; i < count; i++)
            parent[i] = (uint32_t)i;
    }

    uint32_t find(uint32_t i)
    {
        while (parent[i] != i)
            i = parent[i] = parent[parent[i]];
        return i;
    }

    void join(uint32_t a, uint32_t b)
    {
        a = find(a);
        b = find(b);
        parent[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<uint32_t> parent;
};

inline uint32_t next_corner(uint32_t corner)
{
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

/* The edge that begins at a corner, between the vertices a < b. */
struct surface_edge {
    uint32_t a, b, corner;
    bool forward; /* from a to b */
    bool operator<(const surface_edge &e) const
    {
        return a != e.a ? a < e.a : b != e.b ? b < e.b : corner < e.corner;
    }
    bool meets(const surface_edge &e) const { return a == e.a && b == e.b; }
};

/* Sorts edges that are in the order of their corners: by how many begin at each lower vertex (a
 * counting sort: Knuth, "The art of computer programming", vol. 3, sec. 5.2, algorithm D), since
 * few do at one, then those of each. vertices: all are below. */
void surface_sort_edges(std::vector<surface_edge> &edges, size_t vertices);

/* The edge of each corner for which wanted(corner), sorted; none of no length. vertex: a number for
 * each corner. */
template <class Wanted>
std::vector<surface_edge> surface_edges(const std::vector<uint32_t> &vertex, const Wanted &wanted)
{
    std::vector<surface_edge> edges;
    uint32_t most = 0;
    edges.reserve(vertex.size());
    for (uint32_t c = 0; c < vertex.size(); c++) {
        const uint32_t from = vertex[c], to = vertex[next_corner(c)];
        most = std::max(most, from);
        if (from != to && wanted(c))
            edges.push_back({std::min(from, to), std::max(from, to), c, from < to});
    }
    surface_sort_edges(edges, (size_t)most + 1);
    return edges;
}

/* Adds a mesh, placed by m. Zeros lose their sign, so that they weld; a mirrored mesh keeps its
 * front: its triangles' last two corners change places. */
void surface_add(surface &s, const struct scene_mesh &mesh, const double *m);

/* Vertices that stand in the same place get the same number: that of one of them. */
std::vector<uint32_t> surface_weld(const surface &s);

/* Joins the corners of faces that meet. place: surface_weld(s). Returns at how many edges two faces
 * meet that look to different sides, as far as any do: then surface_orient has something to do. */
size_t surface_join(const surface &s, const std::vector<uint32_t> &place, corner_sets &sets);

/* Of each triangle, by surface_orient. */
struct surface_sides {
    std::vector<char> turned;  /* its last two corners changed places */
    std::vector<char> unknown; /* which side is its front cannot be told */
};

/* Where faces that meet look to different sides (soups, exporters that lost the winding), turns
 * those of a closed piece to one side: that of three quarters of its area, else the outside. Open
 * pieces stay as they are, and where more than 5 % of their edges are such, their sides are
 * unknown. */
surface_sides surface_orient(surface &s, const std::vector<uint32_t> &place);

/* Six times the signed volume of the tetrahedron between a triangle and a point. */
double surface_wedge(const surface &s, size_t triangle, const surface_point &o);

/* How often each mesh is placed. */
std::vector<size_t> surface_placed(const struct scene *scene);

/* An error when there are more triangles than OpenMesh can number. */
struct error *surface_check_count(const struct scene *scene);

/* While one lives, OpenMesh's complaints about faces that do not fit are not printed. */
struct openmesh_silence {
    openmesh_silence() : printed(omerr().is_enabled()) { omerr().disable(); }
    ~openmesh_silence()
    {
        if (printed)
            omerr().enable();
    }
    openmesh_silence(const openmesh_silence &) = delete;
    openmesh_silence &operator=(const openmesh_silence &) = delete;
    const bool printed;
};

#endif
