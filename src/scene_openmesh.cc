/* Which pieces of a scene's surface enclose a volume: OpenMesh's half-edges.
 *
 * OpenMesh wants manifold faces, real files give what they have. So each corner of a face first gets a vertex of its
 * own, and corners become one where faces meet: across an edge that joins exactly two faces of consistent orientation.
 * First faces are joined that share vertices in the file, then what is left by equal positions. Boxes that touch, stand
 * on each other or share an edge stay apart that way, and closed each; walls of a room that the file keeps in several
 * meshes become one.
 *
 * Meshes that are placed once are joined in the scene's coordinates; a mesh that is placed often is looked at once, by
 * itself.
 */
#include "scene_private.h"

#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <OpenMesh/Core/System/omstream.hh>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <vector>

namespace {

struct point {
    double x, y, z;
    bool operator<(const point &b) const { return x != b.x ? x < b.x : y != b.y ? y < b.y : z < b.z; }
    bool operator==(const point &b) const { return x == b.x && y == b.y && z == b.z; }
};

/* Triangles, front side out: corner k of triangle t is corner[3 t + k]. */
struct surface {
    std::vector<point> vertices;
    std::vector<uint32_t> corner;
};

/* Pieces of a surface, numbered by their first triangle. */
struct pieces {
    std::vector<uint32_t> of; /* each triangle */
    std::vector<char> closed;
    std::vector<double> volume; /* of closed pieces, else 0 */
};

/* Disjoint sets of corners. */
class corner_sets {
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

uint32_t next_corner(uint32_t corner)
{
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

/* Vertices that stand in the same place get the same number. */
std::vector<uint32_t> weld(const std::vector<point> &vertices)
{
    std::vector<uint32_t> order(vertices.size()), number(vertices.size());
    for (size_t i = 0; i < order.size(); i++)
        order[i] = (uint32_t)i;
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return vertices[a] < vertices[b]; });
    for (size_t i = 0, first = 0; i < order.size(); i++) {
        first = i > 0 && vertices[order[i]] == vertices[order[first]] ? first : i;
        number[order[i]] = order[first];
    }
    return number;
}

/* The edge that begins at a corner, between the vertices a < b. */
struct edge {
    uint32_t a, b, corner;
    bool forward; /* from a to b */
    bool operator<(const edge &e) const { return a != e.a ? a < e.a : b != e.b ? b < e.b : corner < e.corner; }
};

/* Joins the faces on either side of every edge that has one on each and was not joined before. vertex: a number for
 * each corner. */
void join_edges(const std::vector<uint32_t> &vertex, corner_sets &sets, std::vector<char> &joined)
{
    std::vector<edge> edges;
    for (uint32_t c = 0; c < vertex.size(); c++) {
        const uint32_t from = vertex[c], to = vertex[next_corner(c)];
        if (!joined[c] && from != to)
            edges.push_back({std::min(from, to), std::max(from, to), c, from < to});
    }
    std::sort(edges.begin(), edges.end());
    for (size_t i = 0, end; i < edges.size(); i = end) {
        for (end = i + 1; end < edges.size() && edges[end].a == edges[i].a && edges[end].b == edges[i].b;)
            end++;
        if (end - i != 2 || edges[i].forward == edges[i + 1].forward)
            continue;
        const uint32_t c = edges[i].corner, d = edges[i + 1].corner;
        sets.join(c, next_corner(d));
        sets.join(next_corner(c), d);
        joined[c] = joined[d] = 1;
    }
}

/* A connectivity whose complaints about faces that do not fit are not printed. */
struct half_edges : OpenMesh::TriConnectivity {
    half_edges() : printed(omerr().is_enabled()) { omerr().disable(); }
    ~half_edges() override
    {
        if (printed)
            omerr().enable();
    }
    const bool printed;
};

/* Whether each triangle has a neighbour across all three edges. */
std::vector<char> find_neighbours(const std::vector<uint32_t> &vertex)
{
    half_edges mesh;
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
double wedge(const surface &s, size_t triangle, const point &o)
{
    const point &a = s.vertices[s.corner[3 * triangle]], &b = s.vertices[s.corner[3 * triangle + 1]],
                &c = s.vertices[s.corner[3 * triangle + 2]];
    const struct vec3 p = {a.x - o.x, a.y - o.y, a.z - o.z}, q = {b.x - o.x, b.y - o.y, b.z - o.z},
                      r = {c.x - o.x, c.y - o.y, c.z - o.z};
    return vec3_dot(p, vec3_cross(q, r));
}

pieces find_pieces(const surface &s)
{
    const size_t corners = s.corner.size(), triangles = corners / 3;
    corner_sets sets(corners);
    std::vector<char> joined(corners);
    std::vector<uint32_t> vertex = s.corner;
    join_edges(vertex, sets, joined);
    const std::vector<uint32_t> number = weld(s.vertices);
    for (uint32_t &v : vertex)
        v = number[v];
    join_edges(vertex, sets, joined);
    for (uint32_t c = 0; c < corners; c++)
        vertex[c] = sets.find(c);
    const std::vector<char> surrounded = find_neighbours(vertex);

    for (uint32_t t = 0; t < triangles; t++) { /* from vertices to pieces: the corners of a face belong together */
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

double determinant(const double *m)
{
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
           m[2] * (m[4] * m[9] - m[5] * m[8]);
}

/* Adds a mesh, placed by m. Zeros lose their sign, so that they weld; a mirrored mesh keeps its front. */
void add_mesh(surface &s, const struct scene_mesh &mesh, const double *m)
{
    const uint32_t base = (uint32_t)s.vertices.size();
    const bool turned = determinant(m) < 0;
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        const double *p = mesh.position + 3 * v;
        s.vertices.push_back({m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3] + 0.0,
                              m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7] + 0.0,
                              m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11] + 0.0});
    }
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        const uint32_t *i = mesh.index + 3 * t;
        s.corner.insert(s.corner.end(), {base + i[0], base + i[turned ? 2 : 1], base + i[turned ? 1 : 2]});
    }
}

/* The pieces of all instances, put together. */
class gatherer {
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

struct error *hand_out(const gatherer &g, const std::vector<size_t> &offset, struct scene_solids *solids)
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
    std::vector<size_t> offset(scene->instance_count), placed(scene->mesh_count);
    size_t count = 0;
    for (size_t i = 0; i < scene->instance_count; i++) {
        const size_t mesh = scene->instances[i].mesh;
        offset[i] = count;
        count += scene->meshes[mesh].triangle_count;
        placed[mesh]++;
    }
    if (count > std::numeric_limits<int>::max() / 6)
        return error_new("%zu triangles, expected at most %d to look for closed pieces", count,
                         std::numeric_limits<int>::max() / 6);
    gatherer g(scene);
    surface together;
    for (size_t i = 0; i < scene->instance_count; i++)
        if (placed[scene->instances[i].mesh] == 1)
            add_mesh(together, scene->meshes[scene->instances[i].mesh], scene->instances[i].transform);
    const pieces joint = find_pieces(together);
    g.append(joint, 1);
    size_t at = 0;
    std::vector<pieces> alone(scene->mesh_count);
    for (size_t i = 0; i < scene->instance_count; i++) {
        const size_t mesh = scene->instances[i].mesh, triangles = scene->meshes[mesh].triangle_count;
        if (placed[mesh] == 1) {
            std::copy_n(joint.of.begin() + (std::ptrdiff_t)at, triangles,
                        g.piece_of.begin() + (std::ptrdiff_t)offset[i]);
            at += triangles;
            continue;
        }
        if (alone[mesh].of.empty()) {
            surface one;
            add_mesh(one, scene->meshes[mesh], scene_identity);
            alone[mesh] = find_pieces(one);
        }
        const uint32_t base = g.append(alone[mesh], std::fabs(determinant(scene->instances[i].transform)));
        for (size_t t = 0; t < triangles; t++)
            g.piece_of[offset[i] + t] = base + alone[mesh].of[t];
    }
    return hand_out(g, offset, solids);
}

} /* namespace */

struct error *scene_solids(const struct scene *scene, struct scene_solids *solids, struct warnings *)
{
    memset(solids, 0, sizeof *solids);
    struct error *err = scene_guard([=] { return find_solids(scene, solids); });
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
