/* Which pieces of a scene's surface enclose a volume: OpenMesh's half-edges. */
extern "C" {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow" /* C names a struct and a function scene_solids */
#include "topology/solids.h"
#pragma GCC diagnostic pop
}
#include "topology/surface.h"

#include <OpenMesh/Core/Mesh/TriConnectivity.hh>

#include <array>
#include <cstdlib>
#include <cstring>
#include <limits>

namespace
{

/* Pieces of a surface, numbered by their first triangle. */
struct pieces {
    std::vector<uint32_t> of; /* each triangle */
    std::vector<char> closed;
    std::vector<double> volume; /* of closed pieces, else 0 */
};

/* Whether each triangle has a neighbour across all three edges. */
std::vector<char> find_neighbours(const std::vector<uint32_t> &vertex)
{
    const openmesh_silence silence;
    OpenMesh::TriConnectivity mesh;
    std::vector<OpenMesh::VertexHandle> handle(vertex.size());
    std::vector<OpenMesh::FaceHandle> face(vertex.size() / 3);
    for (size_t c = 0; c < vertex.size(); c++)
        if (vertex[c] == c) /* the first corner of its set */
            handle[c] = mesh.new_vertex();
    for (size_t t = 0; t < face.size(); t++) {
        const uint32_t *v = &vertex[3 * t];
        if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0])
            face[t] = mesh.add_face(handle[v[0]], handle[v[1]], handle[v[2]]);
    }
    std::vector<char> surrounded(face.size());
    for (size_t t = 0; t < face.size(); t++) {
        if (!face[t].is_valid())
            continue;
        OpenMesh::HalfedgeHandle h = mesh.halfedge_handle(face[t]);
        surrounded[t] = 1;
        for (int k = 0; k < 3; k++, h = mesh.next_halfedge_handle(h))
            surrounded[t] = surrounded[t] && !mesh.is_boundary(mesh.opposite_halfedge_handle(h));
    }
    return surrounded;
}

/* Six times the signed volume of the tetrahedron between a triangle and a point. */
double wedge(const surface &s, size_t triangle, const surface_point &o)
{
    const surface_point &a = s.vertices[s.corner[3 * triangle]],
                        &b = s.vertices[s.corner[3 * triangle + 1]],
                        &c = s.vertices[s.corner[3 * triangle + 2]];
    const struct vec3 p = {a.x - o.x, a.y - o.y, a.z - o.z}, q = {b.x - o.x, b.y - o.y, b.z - o.z},
                      r = {c.x - o.x, c.y - o.y, c.z - o.z};
    return vec3_dot(p, vec3_cross(q, r));
}

pieces find_pieces(const surface &s)
{
    const size_t corners = s.corner.size(), triangles = corners / 3;
    corner_sets sets(corners);
    surface_join(s, surface_weld(s), sets);
    std::vector<uint32_t> vertex(corners);
    for (uint32_t c = 0; c < corners; c++)
        vertex[c] = sets.find(c);
    const std::vector<char> surrounded = find_neighbours(vertex);

    /* from vertices to pieces: the corners of a face belong together */
    for (uint32_t t = 0; t < triangles; t++) {
        sets.join(3 * t, 3 * t + 1);
        sets.join(3 * t, 3 * t + 2);
    }
    const uint32_t none = std::numeric_limits<uint32_t>::max();
    std::vector<uint32_t> piece_of_set(corners, none), first;
    pieces out;
    out.of.resize(triangles);
    for (uint32_t t = 0; t < triangles; t++) {
        uint32_t &piece = piece_of_set[sets.find(3 * t)];
        if (piece == none) {
            piece = (uint32_t)first.size();
            first.push_back(t);
            out.closed.push_back(1);
            out.volume.push_back(0);
        }
        out.of[t] = piece;
        out.closed[piece] = out.closed[piece] && surrounded[t];
        out.volume[piece] += wedge(s, t, s.vertices[s.corner[3 * first[piece]]]) / 6;
    }
    for (size_t p = 0; p < first.size(); p++)
        if (!out.closed[p])
            out.volume[p] = 0;
    return out;
}

/* The pieces of all instances, put together. */
class gatherer
{
  public:
    explicit gatherer(const struct scene *scene) : piece_of(scene_triangle_count(scene)) {}

    /* Appends pieces; volumes are multiplied by scale. Returns the number of the first. */
    uint32_t append(const pieces &p, double scale)
    {
        const uint32_t base = (uint32_t)closed.size();
        closed.insert(closed.end(), p.closed.begin(), p.closed.end());
        for (double v : p.volume)
            volume.push_back(v * scale);
        return base;
    }

    std::vector<uint32_t> piece_of;
    std::vector<char> closed;
    std::vector<double> volume;
};

struct error *hand_out(const gatherer &g, const std::vector<size_t> &offset,
                       struct scene_solids *solids)
{
    struct error *err = array_create(&solids->offset, offset.size(), sizeof *solids->offset);
    if (!err)
        err = array_create(&solids->piece_of, g.piece_of.size(), sizeof *solids->piece_of);
    if (!err)
        err = array_create(&solids->closed, g.closed.size(), sizeof *solids->closed);
    if (!err)
        err = array_create(&solids->volume, g.volume.size(), sizeof *solids->volume);
    if (err)
        return err;
    std::copy(offset.begin(), offset.end(), solids->offset);
    std::copy(g.piece_of.begin(), g.piece_of.end(), solids->piece_of);
    std::copy(g.closed.begin(), g.closed.end(), solids->closed);
    std::copy(g.volume.begin(), g.volume.end(), solids->volume);
    solids->count = g.closed.size();
    solids->closed_count = (size_t)std::count(g.closed.begin(), g.closed.end(), 1);
    return nullptr;
}

struct error *find_solids(const struct scene *scene, struct scene_solids *solids)
{
    const std::vector<size_t> placed = surface_placed(scene);
    std::vector<size_t> offset(scene->instance_count);
    size_t count = 0;
    for (size_t i = 0; i < scene->instance_count; i++) {
        offset[i] = count;
        count += scene->meshes[scene->instances[i].mesh].triangle_count;
    }
    gatherer g(scene);
    surface together;
    for (size_t i = 0; i < scene->instance_count; i++)
        if (placed[scene->instances[i].mesh] == 1)
            surface_add(together, scene->meshes[scene->instances[i].mesh],
                        scene->instances[i].transform);
    const pieces joint = find_pieces(together);
    g.append(joint, 1);
    size_t at = 0;
    std::vector<pieces> alone(scene->mesh_count);
    for (size_t i = 0; i < scene->instance_count; i++) {
        const size_t mesh = scene->instances[i].mesh,
                     triangles = scene->meshes[mesh].triangle_count;
        if (placed[mesh] == 1) {
            std::copy_n(joint.of.begin() + (std::ptrdiff_t)at, triangles,
                        g.piece_of.begin() + (std::ptrdiff_t)offset[i]);
            at += triangles;
            continue;
        }
        if (alone[mesh].of.empty()) {
            surface one;
            surface_add(one, scene->meshes[mesh], scene_identity);
            alone[mesh] = find_pieces(one);
        }
        const uint32_t base =
            g.append(alone[mesh], std::fabs(affine_determinant(scene->instances[i].transform)));
        for (size_t t = 0; t < triangles; t++)
            g.piece_of[offset[i] + t] = base + alone[mesh].of[t];
    }
    return hand_out(g, offset, solids);
}

} /* namespace */

struct error *scene_solids(const struct scene *scene, struct scene_solids *solids,
                           struct warnings *)
{
    memset(solids, 0, sizeof *solids);
    struct error *err = surface_check_count(scene);
    if (!err)
        err = error_guard([=] { return find_solids(scene, solids); });
    if (err)
        scene_solids_clear(solids);
    return err;
}

void scene_solids_clear(struct scene_solids *solids)
{
    free(solids->offset);
    free(solids->piece_of);
    free(solids->closed);
    free(solids->volume);
    memset(solids, 0, sizeof *solids);
}
