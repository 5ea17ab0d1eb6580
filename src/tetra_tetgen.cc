// The shim around TetGen: point set in, cells out. It runs in a child process (tetra_run.c): TetGen prints, asserts, aborts and
// frees twice on its error path, and none of that may reach the program. It is driven by its inner steps rather than by
// tetrahedralize(), which would copy its result twice, put its own tolerance (1e-8 of the box) upon the points, and start from any four
// that do not look flat in rounded arithmetic, flat ones among them.
#include "tetra.h"

#include <algorithm>
#include <memory>
#include <vector>
#define TETLIBRARY
#include <tetgen.h>

namespace {

// The corners opposite which TetGen's faces 0 .. 3 of a tetrahedron lie, and its corners, in the words of that tetrahedron.
constexpr int FIRST_CORNER = 4;

int corner(tetgenmesh &mesh, tetgenmesh::tetrahedron *t, int k)
{
    return mesh.pointmark(reinterpret_cast<tetgenmesh::point>(t[FIRST_CORNER + k]));
}

// An even permutation that begins with corner k.
constexpr int turned[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}};

// Numbers the cells in order of their least corner, and counts them.
size_t number_cells(tetgenmesh &mesh, size_t count)
{
    std::vector<int> start(count + 1, 0);
    size_t cells = 0;
    mesh.tetrahedrons->traversalinit();
    for (tetgenmesh::tetrahedron *t; (t = mesh.tetrahedrontraverse()); cells++) {
        const int least = std::min(std::min(corner(mesh, t, 0), corner(mesh, t, 1)), std::min(corner(mesh, t, 2), corner(mesh, t, 3)));
        mesh.setelemindex(t, least);
        start[static_cast<size_t>(least) + 1]++;
    }
    for (size_t i = 0; i < count; i++)
        start[i + 1] += start[i];
    mesh.tetrahedrons->traversalinit();
    for (tetgenmesh::tetrahedron *t; (t = mesh.tetrahedrontraverse());)
        mesh.setelemindex(t, start[static_cast<size_t>(mesh.elemindex(t))]++);
    return cells;
}

void write_cells(tetgenmesh &mesh, int32_t *vertex, int32_t *neighbour)
{
    mesh.tetrahedrons->traversalinit();
    for (tetgenmesh::tetrahedron *t; (t = mesh.tetrahedrontraverse());) {
        int v[4], n[4];
        for (int k = 0; k < 4; k++) {
            tetgenmesh::triface across;
            mesh.decode(t[k], across);
            v[k] = corner(mesh, t, k);
            n[tetgenmesh::oppopivot[k] - FIRST_CORNER] = mesh.ishulltet(across) ? -1 : mesh.elemindex(across.tet);
        }
        const int *turn = turned[std::min_element(v, v + 4) - v];
        const size_t at = 4 * static_cast<size_t>(mesh.elemindex(t));
        for (size_t k = 0; k < 4; k++) {
            vertex[at + k] = v[turn[k]];
            neighbour[at + k] = n[turn[k]];
        }
    }
}

// The points in the order in which they are to be inserted, numbered as they were given.
void transfer(tetgenmesh &mesh, tetgenio &in, size_t count, const double *position, const int32_t *order)
{
    std::vector<double> ordered(3 * count);
    for (size_t i = 0; i < count; i++)
        std::copy_n(position + 3 * static_cast<size_t>(order[i]), 3, &ordered[3 * i]);
    in.numberofpoints = static_cast<int>(count);
    in.pointlist = ordered.data();
    mesh.transfernodes();
    in.pointlist = nullptr;
    mesh.points->traversalinit();
    for (size_t i = 0; i < count; i++)
        mesh.setpointmark(mesh.pointtraverse(), order[i]);
}

} // namespace

extern "C" long tetra_tetgen(size_t count, const double *position, const int32_t *order, int32_t *(*room)(void *context, size_t cells), void *context)
{
    tetgenmesh *mesh = nullptr;
    tetgenio in;
    try {
        tetgenbehavior behaviour;
        char switches[] = "Qzn";
        behaviour.parse_commandline(switches);
        behaviour.epsilon = 1e-40; // less than any volume of the lattice: nothing counts as flat that is not
        behaviour.no_sort = 1;
        mesh = new tetgenmesh;
        mesh->b = &behaviour;
        mesh->in = &in;
        exactinit(0, 0, 0, 1, 1, 1);
        mesh->initializepools();
        transfer(*mesh, in, count, position, order);
        exactinit(0, 0, 0, mesh->xmax - mesh->xmin, mesh->ymax - mesh->ymin, mesh->zmax - mesh->zmin); // of its static filters
        clock_t ticks;
        mesh->incrementaldelaunay(ticks);
        const size_t cells = number_cells(*mesh, count);
        int32_t *const vertex = room(context, cells);
        static_assert(sizeof(int) == sizeof(int32_t), "TetGen's indices are 32 bits");
        if (vertex)
            write_cells(*mesh, vertex, vertex + 4 * cells);
        delete mesh;
        return vertex && cells ? static_cast<long>(cells) : -1;
    } catch (...) { // TetGen throws integers, after it has freed what the mesh would free again: the mesh stays
        return -1;
    }
}
