/* SPDX-License-Identifier: Apache-2.0 */
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
    std::vector<char> unoriented;
    std::vector<char> turned; /* each triangle; empty: none */
};

/* Whether each triangle has a neighbour across all three edges. */
std::vector<char> find_neighbours(const std::vector<uint32_t> &vertex)
{
    const openmesh_silence silence;
    OpenMesh::TriConnectivity mesh;
    std::vector<OpenMesh::VertexHandle> handle(vertex.size());
    std::vector<OpenMesh::FaceHandle> face(vertex.size() / 3);
    size_t vertices = 0;
    for (size_t c = 0; c < vertex.size(); c++)
        vertices += vertex[c] == c; /* the first corner of its set */
    mesh.reserve(vertices, face.size() + vertices, face.size());
    for (size_t c = 0; c < vertex.size(); c++)
        if (vertex[c] == c)
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

pieces find_pieces(surface &s)
{
    const size_t corners = s.corner.size(), triangles = corners / 3;
    const std::vector<uint32_t> place = surface_weld(s);
    corner_sets sets(corners);
    surface_sides sides;
    if (surface_join(s, place, sets)) {
        sides = surface_orient(s, place);
        sets = corner_sets(corners);
        surface_join(s, place, sets);
    }
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
            out.unoriented.push_back(!sides.unknown.empty() && sides.unknown[t]);
        }
        out.of[t] = piece;
        out.closed[piece] = out.closed[piece] && surrounded[t];
        out.volume[piece] += surface_wedge(s, t, s.vertices[s.corner[3 * first[piece]]]) / 6;
    }
    for (size_t p = 0; p < first.size(); p++)
        if (!out.closed[p])
            out.volume[p] = 0;
    out.turned = std::move(sides.turned);
    return out;
}

/* The pieces of all instances, put together. */
class gatherer
{
  public:
    explicit gatherer(const struct scene *scene)
        : piece_of(scene_triangle_count(scene)), turned(piece_of.size())
    {
    }

    /* Appends pieces; volumes are multiplied by scale. Returns the number of the first. */
    uint32_t append(const pieces &p, double scale)
    {
        const uint32_t base = (uint32_t)closed.size();
        closed.insert(closed.end(), p.closed.begin(), p.closed.end());
        for (double v : p.volume)
            volume.push_back(v * scale);
        unoriented.insert(unoriented.end(), p.unoriented.begin(), p.unoriented.end());
        return base;
    }

    std::vector<uint32_t> piece_of;
    std::vector<char> turned; /* each triangle */
    std::vector<char> closed;
    std::vector<double> volume;
    std::vector<char> unoriented;
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
    if (!err)
        err = array_create(&solids->unoriented, g.closed.size(), sizeof *solids->unoriented);
    if (!err)
        err = array_create(&solids->turned, g.turned.size(), sizeof *solids->turned);
    if (err)
        return err;
    std::copy(offset.begin(), offset.end(), solids->offset);
    std::copy(g.piece_of.begin(), g.piece_of.end(), solids->piece_of);
    std::copy(g.closed.begin(), g.closed.end(), solids->closed);
    std::copy(g.volume.begin(), g.volume.end(), solids->volume);
    std::copy(g.unoriented.begin(), g.unoriented.end(), solids->unoriented);
    std::copy(g.turned.begin(), g.turned.end(), solids->turned);
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
            for (size_t t = 0; t < triangles && !joint.turned.empty(); t++)
                g.turned[offset[i] + t] = joint.turned[at + t];
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
        for (size_t t = 0; t < triangles && !alone[mesh].turned.empty(); t++)
            g.turned[offset[i] + t] = alone[mesh].turned[t];
    }
    return hand_out(g, offset, solids);
}

} /* namespace */

void scene_solids_tell(const struct scene *scene, const struct scene_solids *solids,
                       struct warnings *warnings)
{
    const size_t count = scene_triangle_count(scene);
    size_t turned = 0, unknown = 0;
    for (size_t t = 0; t < count; t++) {
        turned += solids->turned[t];
        unknown += solids->unoriented[solids->piece_of[t]];
    }
    if (turned)
        warnings_add(warnings, "faces turned",
                     "%zu of %zu triangles look to another side than their neighbours of the same "
                     "closed piece: taken as turned round",
                     turned, count);
    if (unknown)
        warnings_add(warnings, "orientation",
                     "%zu of %zu triangles are of open pieces whose faces look to both sides: "
                     "their backs do not tell inside from outside",
                     unknown, count);
}

struct error *scene_solids(const struct scene *scene, struct scene_solids *solids,
                           struct warnings *warnings)
{
    memset(solids, 0, sizeof *solids);
    struct error *err = surface_check_count(scene);
    if (!err)
        err = error_guard([=] { return find_solids(scene, solids); });
    if (err)
        scene_solids_clear(solids);
    else
        scene_solids_tell(scene, solids, warnings);
    return err;
}

void scene_solids_clear(struct scene_solids *solids)
{
    free(solids->offset);
    free(solids->piece_of);
    free(solids->closed);
    free(solids->volume);
    free(solids->unoriented);
    free(solids->turned);
    memset(solids, 0, sizeof *solids);
}
