/* SPDX-License-Identifier: Apache-2.0 */
/* Fewer triangles for nearly the same surface: OpenMesh's decimater, with quadric errors.
 *
 * Based on: Garland and Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH
 * 1997 (planes weighted by area, sec. 4; planes through borders, sec. 6). Vertices move into
 * neighbours (half-edge collapses), so none is new, and texture coordinates are those of the file.
 * How far a texture slides over the surface counts beside the distance, as in Hoppe, "New quadric
 * metric for simplifying meshes with appearance attributes", Visualization 1999, but against the
 * surface as it is before the collapse; so does how far colours of vertices change.
 *
 * Creases are edges with a face on one side alone, and those where material, texture or colour
 * differ. A vertex on no crease may move into any neighbour, one with exactly two crease edges
 * along these, any other stays: ends and branches of creases.
 */
#ifndef __clang__ /* OpenMesh's vectors begin without a value */
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#ifndef NDEBUG
#define NDEBUG /* in OpenMesh: else each look at a property is a dynamic_cast by the name of its   \
                  type, a fifth of the time */
#endif

extern "C" {
#include "topology/decimate.h"
}
#include "topology/surface.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Geometry/QuadricT.hh> /* in this order: it uses what the first declares */
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>

#include <array>
#include <map>

namespace
{

using quadric = OpenMesh::Geometry::Quadricd;
using point = OpenMesh::Vec3d;

struct traits : OpenMesh::DefaultTraits {
    using Point = point;
    using Normal = point;
};
using half_edges = OpenMesh::TriMesh_ArrayKernelT<traits>;

/* A crease's plane counts this many times as much as a face as long and as wide: borders are
 * silhouettes. */
const double crease_weight = 4;
/* What a texture slides, as a share of what a surface moves. */
const double slide_weight = 0.1;
/* Of two ways without error, the shorter is better: planes then keep well-shaped triangles. Too
 * little to count beside an error. */
const double length_weight = 1e-7;
/* No face may turn farther than 60 degrees, nor become a needle. */
const double cos_turn_most = 0.5, sin_corner_least = 1e-5;

/* What is looked at about a vertex grows with the square of its faces: one with more than the first
 * number stays, and no collapse makes such a one; one with more than the second stays with all its
 * faces. */
const uint32_t fan_most = 128, fan_taken_most = 1024;

/* Triangles to be decimated: a surface, and what belongs to its faces. */
struct part {
    surface s;
    /* of each corner: `width` numbers, u and v; and where some mesh has them, those of emission
     * maps and the colour of its vertex */
    std::vector<float> look;
    size_t width = 2;
    std::vector<int32_t> material;
    std::vector<uint32_t> name; /* of each face, of the scene's parts; 0: none */
    bool has_uv = false, has_emission_uv = false, has_colour = false;
    size_t count() const { return material.size(); }
};

enum { EMISSION_UV = 2, COLOUR = 4, WIDE = 8 }; /* places in a corner's look, and its width */

/* Makes room for what a mesh has. To be called of all meshes of a part before one is added. */
void part_widen(part &p, const struct scene_mesh &mesh)
{
    p.has_uv = p.has_uv || mesh.uv;
    p.has_emission_uv = p.has_emission_uv || mesh.emission_uv;
    p.has_colour = p.has_colour || mesh.colour;
    p.width = p.has_emission_uv || p.has_colour ? WIDE : 2;
}

/* `name` of the faces that no object or group has. */
void part_add(part &p, const struct scene_mesh &mesh, const double *m, uint32_t name)
{
    const bool turned = affine_mirrors(m);
    surface_add(p.s, mesh, m);
    for (size_t t = 0, run = 0; t < mesh.triangle_count; t++) {
        while (run < mesh.run_count && mesh.runs[run].first <= t)
            run++;
        const uint32_t own = run ? mesh.runs[run - 1].part : 0;
        p.name.push_back(own ? own : name);
    }
    p.material.insert(p.material.end(), mesh.material, mesh.material + mesh.triangle_count);
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        for (size_t k = 0; k < 3; k++) {
            const size_t c = 3 * t + (turned && k ? 3 - k : k);
            const float *uv = mesh.uv ? mesh.uv + 2 * c : nullptr;
            p.look.insert(p.look.end(), {uv ? uv[0] : 0.0f, uv ? uv[1] : 0.0f});
            if (p.width != WIDE)
                continue;
            uv = mesh.emission_uv ? mesh.emission_uv + 2 * c : uv;
            p.look.insert(p.look.end(), {uv ? uv[0] : 0.0f, uv ? uv[1] : 0.0f});
            for (size_t i = 0; i < 4; i++)
                p.look.push_back(mesh.colour ? (float)mesh.colour[4 * (size_t)mesh.index[c] + i]
                                             : UINT16_MAX);
        }
    }
}

/* A part as OpenMesh's half-edges, within a cube from -1 to 1. */
struct topology {
    half_edges mesh;
    std::vector<uint32_t> triangle;           /* of each face */
    std::vector<half_edges::FaceHandle> face; /* of each triangle; invalid: not taken */
    std::vector<int> vertex;                  /* of each corner */
    std::vector<uint32_t> origin;             /* of each vertex: in the part */
    std::vector<uint32_t> fan;                /* faces about each vertex */
};

/* The error of a collapse, and whether it is legal. Keeps the corners' vertices and looks up to
 * date, and the fans. */
class collapses : public OpenMesh::Decimater::ModBaseT<half_edges>
{
  public:
    using Base = OpenMesh::Decimater::ModBaseT<half_edges>;
    using Handle = OpenMesh::Decimater::ModHandleT<collapses>;

    explicit collapses(half_edges &mesh) : Base(mesh, false) {}

    const std::string &name() const override
    {
        static const std::string own("collapses");
        return own;
    }

    /* All stay the caller's. */
    void begin(const struct scene *its_scene, part *its_part, topology *its_topology)
    {
        scene = its_scene;
        p = its_part;
        o = its_topology;
        quadrics.assign(mesh().n_vertices(), quadric());
        for (const auto f : mesh().faces())
            add_planes(f);
    }

    float collapse_priority(const CollapseInfo &ci) override
    {
        const uint32_t fan = fan_after(ci);
        if (fan > fan_most && fan > o->fan[(size_t)ci.v1.idx()])
            return ILLEGAL_COLLAPSE;
        const int count = creases_at(ci.v0v1);
        if (count && !(count == 2 && is_crease(ci.v0v1)))
            return ILLEGAL_COLLAPSE;
        double slide = 0;
        const bool legal = each_remaining(ci, [&](uint32_t t, uint32_t corner, const float *look) {
            return face_allows(ci, t, corner, look, slide);
        });
        if (!legal)
            return ILLEGAL_COLLAPSE;
        quadric q = quadrics[(size_t)ci.v0.idx()];
        q += quadrics[(size_t)ci.v1.idx()];
        const double length = (ci.p1 - ci.p0).sqrnorm();
        return (float)(std::max(q(ci.p1), 0.0) + slide_weight * slide +
                       length_weight * length * length);
    }

    void preprocess_collapse(const CollapseInfo &ci) override
    {
        quadrics[(size_t)ci.v1.idx()] += quadrics[(size_t)ci.v0.idx()];
        o->fan[(size_t)ci.v1.idx()] = fan_after(ci);
        for (const auto v : {ci.vl, ci.vr})
            if (v.is_valid())
                o->fan[(size_t)v.idx()]--;
        moves.clear();
        each_remaining(ci, [&](uint32_t, uint32_t corner, const float *look) {
            move m = {corner, {}};
            std::copy_n(look, p->width, m.look);
            moves.push_back(m);
            return true;
        });
        for (const move &m : moves) { /* now that nothing more is asked of the faces as they were */
            o->vertex[m.corner] = ci.v1.idx();
            std::copy_n(m.look, p->width, look_of(m.corner));
        }
        counted = half_edges::VertexHandle();
    }

  private:
    struct move {
        uint32_t corner;
        float look[WIDE];
    };

    /* Faces about v1 after the collapse. */
    uint32_t fan_after(const CollapseInfo &ci) const
    {
        return o->fan[(size_t)ci.v0.idx()] + o->fan[(size_t)ci.v1.idx()] -
               2 * (uint32_t)ci.fl.is_valid() - 2 * (uint32_t)ci.fr.is_valid();
    }

    uint32_t triangle_of(half_edges::FaceHandle f) const { return o->triangle[(size_t)f.idx()]; }

    /* The corner of a triangle that stands on a vertex. */
    uint32_t corner_at(uint32_t t, half_edges::VertexHandle v) const
    {
        uint32_t c = 3 * t;
        while (c < 3 * t + 2 && o->vertex[c] != v.idx())
            c++;
        return c;
    }

    float *look_of(uint32_t corner) const { return &p->look[p->width * (size_t)corner]; }

    const float *look_at(uint32_t t, half_edges::VertexHandle v) const
    {
        return look_of(corner_at(t, v));
    }

    bool is_textured(uint32_t t) const
    {
        return (p->has_uv || p->has_emission_uv) && scene->materials[p->material[t]].textured;
    }

    /* Whether a triangle's surface looks otherwise with the one than with the other. */
    bool differs(uint32_t t, const float *a, const float *b) const
    {
        const size_t uv_end = std::min<size_t>(p->width, COLOUR);
        return (is_textured(t) && !std::equal(a, a + uv_end, b)) ||
               (p->has_colour && !std::equal(a + COLOUR, a + WIDE, b + COLOUR));
    }

    bool is_crease(half_edges::HalfedgeHandle h)
    {
        const auto f = mesh().face_handle(h),
                   g = mesh().face_handle(mesh().opposite_halfedge_handle(h));
        if (!f.is_valid() || !g.is_valid())
            return true;
        const uint32_t t = triangle_of(f), u = triangle_of(g);
        if (p->material[t] != p->material[u])
            return true;
        const auto differ_at = [&](half_edges::VertexHandle v) {
            return differs(t, look_at(t, v), look_at(u, v));
        };
        return differ_at(mesh().from_vertex_handle(h)) || differ_at(mesh().to_vertex_handle(h));
    }

    /* The creases that end at the vertex where h begins. OpenMesh asks for one vertex's collapses
     * one after the other: what was counted last is kept until the next collapse. */
    int creases_at(half_edges::HalfedgeHandle h)
    {
        const auto v = mesh().from_vertex_handle(h);
        if (v == counted)
            return creases;
        counted = v;
        creases = 0;
        const half_edges::HalfedgeHandle first = h;
        do {
            creases += is_crease(h);
            h = mesh().ccw_rotated_halfedge_handle(h);
        } while (h != first);
        return creases;
    }

    /* Calls visit(triangle, its corner on v0, the look that this is to get) for each face about v0
     * that the collapse leaves, until that is false. The look is that of v1 on the same side of the
     * crease through v0. */
    template <class Visit> bool each_remaining(const CollapseInfo &ci, const Visit &visit)
    {
        half_edges::HalfedgeHandle h = ci.v0v1;
        half_edges::FaceHandle side = ci.fl;
        const bool has_creases = creases_at(h) > 0;
        bool going = true;
        do {
            if (has_creases && h != ci.v0v1 && is_crease(h))
                side = ci.fr;
            const auto f = mesh().face_handle(h);
            if (f.is_valid() && f != ci.fl && f != ci.fr) {
                const uint32_t t = triangle_of(f);
                going = side.is_valid() &&
                        visit(t, corner_at(t, ci.v0), look_at(triangle_of(side), ci.v1));
            }
            h = mesh().ccw_rotated_halfedge_handle(h);
        } while (going && h != ci.v0v1);
        return going;
    }

    point position(uint32_t corner)
    {
        return mesh().point(half_edges::VertexHandle(o->vertex[corner]));
    }

    /* Whether a face may follow its corner from v0 to v1; adds what its texture slides, and what
     * its colour changes: from black to white counts as a slide of its size. */
    bool face_allows(const CollapseInfo &ci, uint32_t t, uint32_t corner, const float *look,
                     double &slide)
    {
        const uint32_t next = next_corner(corner), last = next_corner(next);
        const point b = position(next) - ci.p0, c = position(last) - ci.p0, shift = ci.p1 - ci.p0;
        const point normal = cross(b, c), moved = cross(b - shift, c - shift);
        const double area = normal.norm(), moved_area = moved.norm();
        const double longest =
            std::max({(b - shift).sqrnorm(), (c - shift).sqrnorm(), (b - c).sqrnorm()});
        if (!(area > 0 && moved_area > sin_corner_least * longest &&
              dot(normal, moved) >= cos_turn_most * area * moved_area))
            return false;
        if (!is_textured(t) && !p->has_colour)
            return true;
        /* the face's own look at v1, against what it is to get there */
        const double along_b = dot(cross(shift, c), normal) / (area * area),
                     along_c = dot(cross(b, shift), normal) / (area * area);
        const double weight = area / 2 * (b.sqrnorm() + c.sqrnorm());
        double size = 0;
        const auto off = [&](size_t begin, size_t end) {
            const float *own = look_of(corner), *at_b = look_of(next), *at_c = look_of(last);
            double sum = 0;
            size = 0;
            for (size_t i = begin; i < end; i++) {
                const double to_b = (double)at_b[i] - (double)own[i],
                             to_c = (double)at_c[i] - (double)own[i];
                const double d = (double)look[i] -
                                 ((double)own[i] + along_b * to_b + along_c * to_c);
                sum += d * d;
                size += to_b * to_b + to_c * to_c;
            }
            return sum;
        };
        for (size_t i = 0; is_textured(t) && i < std::min<size_t>(p->width, COLOUR); i += 2) {
            const double slid = off(i, i + 2);
            if (size > 0)
                slide += weight * slid / size;
        }
        if (p->has_colour)
            slide += weight * off(COLOUR, WIDE) / (65535.0 * 65535.0);
        return true;
    }

    /* Adds a face's plane to its vertices, and to the ends of its creases the plane that stands on
     * it there. */
    void add_planes(half_edges::FaceHandle f)
    {
        const uint32_t t = triangle_of(f);
        const point a = position(3 * t);
        point normal = cross(position(3 * t + 1) - a, position(3 * t + 2) - a);
        const double area = normal.norm();
        if (!(area > 0))
            return;
        normal /= area;
        quadric face(normal, a);
        face *= area / 2;
        for (uint32_t k = 0; k < 3; k++)
            quadrics[(size_t)o->vertex[3 * t + k]] += face;
        half_edges::HalfedgeHandle h = mesh().halfedge_handle(f);
        for (int k = 0; k < 3; k++, h = mesh().next_halfedge_handle(h)) {
            if (!is_crease(h))
                continue;
            const auto from = mesh().from_vertex_handle(h), to = mesh().to_vertex_handle(h);
            const point edge = mesh().point(to) - mesh().point(from);
            point across = cross(edge, normal);
            const double length = across.norm();
            if (!(length > 0))
                continue;
            across /= length;
            quadric crease(across, mesh().point(from));
            crease *= crease_weight * length * length;
            quadrics[(size_t)from.idx()] += crease;
            quadrics[(size_t)to.idx()] += crease;
        }
    }

    const struct scene *scene = nullptr;
    part *p = nullptr;
    topology *o = nullptr;
    std::vector<quadric> quadrics;
    std::vector<move> moves;
    half_edges::VertexHandle counted; /* the vertex that `creases` is of */
    int creases = 0;
};

void add_vertices(topology &o, const part &p, corner_sets &sets)
{
    surface_point low = p.s.vertices[0], high = low;
    for (const surface_point &v : p.s.vertices) {
        low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
        high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
    }
    const surface_point middle = {low.x / 2 + high.x / 2, low.y / 2 + high.y / 2,
                                  low.z / 2 + high.z / 2};
    const double half =
        std::max({high.x / 2 - low.x / 2, high.y / 2 - low.y / 2, high.z / 2 - low.z / 2});
    o.vertex.resize(p.s.corner.size());
    for (uint32_t c = 0; c < p.s.corner.size(); c++) {
        const uint32_t first = sets.find(c);
        if (first == c) {
            const surface_point &v = p.s.vertices[p.s.corner[c]];
            o.vertex[c] = o.mesh
                              .add_vertex(point((v.x - middle.x) / half, (v.y - middle.y) / half,
                                                (v.z - middle.z) / half))
                              .idx();
            o.origin.push_back(p.s.corner[c]);
        } else {
            o.vertex[c] = o.vertex[first];
        }
    }
}

void add_faces(topology &o, const part &p)
{
    o.face.resize(p.count());
    o.fan.resize(o.origin.size());
    for (const int v : o.vertex)
        o.fan[(size_t)v]++;
    for (uint32_t t = 0; t < p.count(); t++) {
        const int *v = &o.vertex[3 * (size_t)t];
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
            continue;
        if (std::max({o.fan[(size_t)v[0]], o.fan[(size_t)v[1]], o.fan[(size_t)v[2]]}) >
            fan_taken_most)
            continue;
        o.face[t] = o.mesh.add_face(half_edges::VertexHandle(v[0]), half_edges::VertexHandle(v[1]),
                                    half_edges::VertexHandle(v[2]));
        if (o.face[t].is_valid())
            o.triangle.push_back(t);
    }
}

/* Locks what must stay: the corners of emissive triangles, whose area is light; those of triangles
 * that were not taken; the ends of borders along which other surfaces run, from which a gap would
 * part them; and large fans. */
void lock_vertices(topology &o, const struct scene *scene, const part &p,
                   const std::vector<uint32_t> &place)
{
    std::vector<uint32_t> at(p.s.corner.size()); /* where each corner stands */
    for (size_t c = 0; c < at.size(); c++)
        at[c] = place[p.s.corner[c]];
    std::vector<char> locked_place(p.s.vertices.size());
    const auto lock_corner = [&](uint32_t c) {
        o.mesh.status(half_edges::VertexHandle(o.vertex[c])).set_locked(true);
    };
    for (uint32_t t = 0; t < p.count(); t++) {
        const bool emits = scene_emits(&scene->materials[p.material[t]]);
        for (uint32_t c = 3 * t; c < 3 * t + 3; c++) {
            if (emits || o.fan[(size_t)o.vertex[c]] > fan_most)
                lock_corner(c);
            if (!o.face[t].is_valid())
                locked_place[at[c]] = 1;
        }
    }
    const auto is_border = [&](const surface_edge &e) {
        const auto h =
            o.mesh.find_halfedge(half_edges::VertexHandle(o.vertex[e.corner]),
                                 half_edges::VertexHandle(o.vertex[next_corner(e.corner)]));
        return !h.is_valid() || o.mesh.is_boundary(o.mesh.edge_handle(h));
    };
    const std::vector<surface_edge> edges = surface_edges(at, [](uint32_t) { return true; });
    for (size_t i = 0, end; i < edges.size(); i = end) {
        for (end = i + 1; end < edges.size() && edges[end].meets(edges[i]);)
            end++;
        if (end - i > 1 && std::any_of(edges.begin() + (std::ptrdiff_t)i,
                                       edges.begin() + (std::ptrdiff_t)end, is_border))
            locked_place[edges[i].a] = locked_place[edges[i].b] = 1;
    }
    for (uint32_t c = 0; c < at.size(); c++)
        if (locked_place[at[c]])
            lock_corner(c);
}

/* Keeps of a part what the collapses left. */
void reduce(part &p, const topology &o)
{
    size_t kept = 0;
    for (size_t t = 0; t < p.count(); t++) {
        if (o.face[t].is_valid() && o.mesh.status(o.face[t]).deleted())
            continue;
        for (size_t k = 0; k < 3; k++)
            p.s.corner[3 * kept + k] = (uint32_t)o.vertex[3 * t + k];
        std::copy_n(&p.look[3 * p.width * t], 3 * p.width, &p.look[3 * p.width * kept]);
        p.name[kept] = p.name[t];
        p.material[kept++] = p.material[t];
    }
    p.s.corner.resize(3 * kept);
    p.look.resize(3 * p.width * kept);
    p.material.resize(kept);
    p.name.resize(kept);
    std::vector<surface_point> vertices;
    for (const uint32_t v : o.origin)
        vertices.push_back(p.s.vertices[v]);
    p.s.vertices.swap(vertices);
}

/* Takes triangles away until at most `target` are left, or none can go. */
void decimate(part &p, const struct scene *scene, size_t target)
{
    const openmesh_silence silence;
    topology o;
    {
        corner_sets sets(p.s.corner.size());
        const std::vector<uint32_t> place = surface_weld(p.s);
        surface_join(p.s, place, sets);
        add_vertices(o, p, sets);
        o.mesh.request_vertex_status();
        o.mesh.request_edge_status();
        o.mesh.request_face_status();
        add_faces(o, p);
        lock_vertices(o, scene, p, place);
    }
    const size_t outside = p.count() - o.triangle.size();
    OpenMesh::Decimater::DecimaterT<half_edges> decimater(o.mesh);
    collapses::Handle handle;
    decimater.add(handle);
    decimater.initialize();
    decimater.module(handle).begin(scene, &p, &o);
    decimater.decimate_to_faces(0, target > outside ? target - outside : 0);
    reduce(p, o);
}

/* Gives corners that stand on one vertex in other colours vertices of their own. Returns the colour
 * of each vertex. */
std::vector<std::array<float, 4>> part_colours(part &p)
{
    std::vector<std::array<float, 4>> colour(p.s.vertices.size());
    std::vector<char> taken(colour.size());
    std::map<std::pair<uint32_t, std::array<float, 4>>, uint32_t> more;
    for (size_t c = 0; c < p.s.corner.size(); c++) {
        uint32_t &v = p.s.corner[c];
        std::array<float, 4> own;
        std::copy_n(&p.look[p.width * c + COLOUR], 4, own.begin());
        if (!taken[v]) {
            taken[v] = 1;
            colour[v] = own;
        } else if (colour[v] != own) {
            const auto split = more.insert({{v, own}, (uint32_t)colour.size()});
            if (split.second) {
                const surface_point place = p.s.vertices[v];
                p.s.vertices.push_back(place);
                colour.push_back(own);
            }
            v = split.first->second;
        }
    }
    return colour;
}

/* Texture coordinates of the corners, from those places of their looks. */
struct error *store_uv(float **uv, const part &p, size_t at)
{
    struct error *err = array_create(uv, 2 * p.s.corner.size(), sizeof **uv);
    for (size_t c = 0; c < p.s.corner.size() && !err; c++)
        std::copy_n(&p.look[p.width * c + at], 2, *uv + 2 * c);
    return err;
}

/* The runs of faces of one name. */
struct error *store_runs(struct scene_mesh *mesh, const part &p)
{
    size_t count = 0;
    for (size_t t = 0; t < p.count(); t++)
        count += p.name[t] != (t ? p.name[t - 1] : 0);
    struct error *err = count ? array_create(&mesh->runs, count, sizeof *mesh->runs) : nullptr;
    for (size_t t = 0; t < p.count() && count && !err; t++)
        if (p.name[t] != (t ? p.name[t - 1] : 0))
            mesh->runs[mesh->run_count++] = {t, p.name[t]};
    return err;
}

/* Puts a part in a mesh's place. */
struct error *store(struct scene_mesh *mesh, part &p)
{
    std::vector<std::array<float, 4>> colour;
    if (p.has_colour)
        colour = part_colours(p);
    struct scene_mesh made = {};
    made.vertex_count = p.s.vertices.size();
    made.triangle_count = p.count();
    struct error *err = array_create(&made.position, 3 * made.vertex_count, sizeof *made.position);
    if (!err)
        err = array_create(&made.index, 3 * made.triangle_count, sizeof *made.index);
    if (!err)
        err = array_create(&made.material, made.triangle_count, sizeof *made.material);
    if (!err && p.has_uv)
        err = store_uv(&made.uv, p, 0);
    if (!err && p.has_emission_uv)
        err = store_uv(&made.emission_uv, p, EMISSION_UV);
    if (!err && p.has_colour)
        err = array_create(&made.colour, 4 * made.vertex_count, sizeof *made.colour);
    if (!err)
        err = store_runs(&made, p);
    if (err) {
        scene_mesh_clear(&made);
        return err;
    }
    made.part = mesh->part;
    for (size_t v = 0; v < made.vertex_count; v++) {
        const double position[] = {p.s.vertices[v].x, p.s.vertices[v].y, p.s.vertices[v].z};
        std::copy_n(position, 3, made.position + 3 * v);
    }
    std::copy(p.s.corner.begin(), p.s.corner.end(), made.index);
    std::copy(p.material.begin(), p.material.end(), made.material);
    for (size_t v = 0; v < colour.size(); v++)
        std::transform(colour[v].begin(), colour[v].end(), made.colour + 4 * v,
                       [](float code) { return (uint16_t)code; });
    scene_mesh_clear(mesh);
    *mesh = made;
    return nullptr;
}

/* Decimates all that is placed once as one; it becomes the mesh of the first of these instances.
 * The others keep meshes of no triangles, which scene_finish_geometry drops. */
struct error *decimate_joint(struct scene *scene, double share, const std::vector<size_t> &placed)
{
    part joint;
    struct scene_instance *first = nullptr;
    for (size_t i = 0; i < scene->mesh_count; i++)
        if (placed[i] == 1)
            part_widen(joint, scene->meshes[i]);
    for (size_t i = 0; i < scene->instance_count; i++) {
        struct scene_instance *instance = &scene->instances[i];
        if (placed[instance->mesh] != 1)
            continue;
        first = first ? first : instance;
        part_add(joint, scene->meshes[instance->mesh], instance->transform, instance->part);
        scene_mesh_clear(&scene->meshes[instance->mesh]);
    }
    if (!first)
        return nullptr;
    std::copy_n(scene_identity, 12, first->transform);
    first->part = 0;
    scene->meshes[first->mesh].part = 0;
    decimate(joint, scene, (size_t)(share * (double)joint.count()));
    return store(&scene->meshes[first->mesh], joint);
}

struct error *decimate_scene(struct scene *scene, double share)
{
    const std::vector<size_t> placed = surface_placed(scene);
    struct error *err = decimate_joint(scene, share, placed);
    for (size_t i = 0; i < scene->mesh_count && !err; i++) {
        if (placed[i] < 2)
            continue;
        part alone;
        part_widen(alone, scene->meshes[i]);
        part_add(alone, scene->meshes[i], scene_identity, 0);
        decimate(alone, scene, (size_t)(share * (double)alone.count()));
        err = store(&scene->meshes[i], alone);
    }
    return err;
}

} /* namespace */

struct error *scene_decimate(struct scene *scene, double share, struct warnings *warnings)
{
    if (!(share > 0 && share <= 1))
        return error_new("expected a share of the triangles above 0 and at most 1, got %g", share);
    const size_t before = scene_triangle_count(scene), degenerate = scene->degenerate_count;
    if (share == 1 || !before)
        return nullptr;
    scene_keep_keys(scene);
    struct error *err = surface_check_count(scene);
    if (!err)
        err = error_guard([=] { return decimate_scene(scene, share); });
    if (!err)
        err = scene_finish_geometry(scene, warnings);
    if (err)
        return err;
    scene->degenerate_count = degenerate;
    const size_t after = scene_triangle_count(scene);
    if ((double)after > std::ceil(share * (double)before))
        warnings_add(
            warnings, "decimated",
            "%s%s%zu of %zu triangles are left (%.1f %%): the others that were to go hold borders, "
            "changes of material, or emit light",
            scene->path ? scene->path : "", scene->path ? ": " : "", after, before,
            100 * (double)after / (double)before);
    return nullptr;
}
