/* SPDX-License-Identifier: Apache-2.0 */
// The shim around TetGen: point set in, cells out. It runs in a child process (tetra_run.c): TetGen
// prints, asserts, aborts and frees twice on its error path, and none of that may reach the
// program. It is driven by its inner steps rather than by tetrahedralize(), which would copy its
// result twice, put its own tolerance (1e-8 of the box) upon the points, and start from any four
// that do not look flat in rounded arithmetic, flat ones among them.
#include "tetra/tetra.h"

#include <algorithm>
#include <cstring>
#include <thread>
#include <vector>
#define TETLIBRARY
#include <tetgen.h>

namespace
{

using cell = tetgenmesh::tetrahedron *;

// Where a tetrahedron holds its corners; faces 0 .. 3 lie opposite oppopivot[0 .. 3].
constexpr int FIRST_CORNER = 4;
// Where the numbers of its corners are kept once TetGen is done, in place of the middle two of its
// pointers to them. The first and the last tell the pool which cells are alive and not beyond the
// hull.
constexpr int NUMBERS = 5;
// Where its index is.
constexpr int INDEX = 10;

constexpr size_t BATCH = 32;
constexpr size_t CELLS_A_THREAD = 20000; // fewer are not worth one

// TetGen's cells, which lie in blocks, shared out among threads: each takes as many blocks, one
// after the other.
class cells
{
  public:
    cells(tetgenmesh &owner, int threads) : mesh(owner)
    {
        const auto *pool = mesh.tetrahedrons;
        for (void **block = pool->firstblock; block;
             block = block == pool->nowblock ? nullptr : static_cast<void **>(*block))
            blocks.push_back(block);
        const size_t most = static_cast<size_t>(pool->items) / CELLS_A_THREAD + 1;
        shares = std::min(static_cast<size_t>(threads < 1 ? 1 : threads), most);
    }

    size_t share_count() const { return shares; }

    // Calls work(share, cell) for each cell that is alive and inside the hull, and ahead(cell) some
    // time before, to fetch what work will need; beyond(cell) for each beyond the hull. The same
    // cells are in the same share each time.
    template <class Ahead, class Work, class Beyond>
    void each(Ahead ahead, Work work, Beyond beyond) const
    {
        std::vector<std::thread> others;
        for (size_t share = 1; share < shares; share++)
            others.emplace_back([=, this_ = this] { this_->each_of(share, ahead, work, beyond); });
        each_of(0, ahead, work, beyond);
        for (auto &other : others)
            other.join();
    }

    template <class Ahead, class Work> void each(Ahead ahead, Work work) const
    {
        each(ahead, work, [](cell) {});
    }

  private:
    template <class Ahead, class Work, class Beyond>
    void each_of(size_t share, Ahead ahead, Work work, Beyond beyond) const
    {
        const auto *pool = mesh.tetrahedrons;
        const size_t align = static_cast<size_t>(pool->alignbytes),
                     bytes = static_cast<size_t>(pool->itembytes);
        cell batch[BATCH];
        size_t got = 0;
        const auto flush = [&] {
            for (size_t i = 0; i < got; i++)
                work(share, batch[i]);
            got = 0;
        };
        for (size_t b = share * blocks.size() / shares; b < (share + 1) * blocks.size() / shares;
             b++) {
            const auto past =
                reinterpret_cast<uintptr_t>(blocks[b] + 1); // the link to the next block
            char *item = reinterpret_cast<char *>(past + align - past % align);
            for (int i = 0; i < pool->itemsperblock && item != pool->nextitem; i++, item += bytes) {
                const cell t = reinterpret_cast<cell>(item);
                if (!t[FIRST_CORNER])
                    continue;
                if (reinterpret_cast<tetgenmesh::point>(t[FIRST_CORNER + 3]) == mesh.dummypoint) {
                    beyond(t);
                    continue;
                }
                ahead(t);
                batch[got++] = t;
                if (got == BATCH)
                    flush();
            }
        }
        flush();
    }

    tetgenmesh &mesh;
    std::vector<void **> blocks;
    size_t shares;
};

// An even permutation that begins with corner k.
constexpr int turned[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}};

// Numbers the cells in order of their least corner, those beyond the hull -1, and counts them.
size_t number_cells(tetgenmesh &mesh, const cells &all, size_t count)
{
    std::vector<std::vector<int>> start(all.share_count()); // by share and least corner
    for (auto &s : start)
        s.assign(count, 0);
    all.each(
        [&mesh](cell t) {
            for (int k = 0; k < 4; k++)
                __builtin_prefetch(reinterpret_cast<int *>(t[FIRST_CORNER + k]) +
                                   mesh.pointmarkindex);
        },
        [&mesh, &start](size_t share, cell t) {
            int v[4];
            for (int k = 0; k < 4; k++)
                v[k] = mesh.pointmark(reinterpret_cast<tetgenmesh::point>(t[FIRST_CORNER + k]));
            const int least = *std::min_element(v, v + 4);
            std::memcpy(&t[NUMBERS], v, sizeof v);
            mesh.setelemindex(t, least);
            start[share][static_cast<size_t>(least)]++;
        },
        [&mesh](cell t) { mesh.setelemindex(t, -1); });
    int sum = 0;
    for (size_t i = 0; i < count; i++)
        for (auto &s : start) {
            const int here = s[i];
            s[i] = sum;
            sum += here;
        }
    all.each([](cell) {},
             [&mesh, &start](size_t share, cell t) {
                 mesh.setelemindex(t, start[share][static_cast<size_t>(mesh.elemindex(t))]++);
             });
    return static_cast<size_t>(sum);
}

void write_cells(tetgenmesh &mesh, const cells &all, int32_t *vertex, int32_t *neighbour)
{
    const auto across = [&mesh](cell t, int k) {
        tetgenmesh::triface face;
        mesh.decode(t[k], face);
        return face.tet;
    };
    all.each(
        [&mesh, across, vertex, neighbour](cell t) {
            const size_t at = 4 * static_cast<size_t>(mesh.elemindex(t));
            __builtin_prefetch(vertex + at, 1);
            __builtin_prefetch(neighbour + at, 1);
            for (int k = 0; k < 4; k++)
                __builtin_prefetch(across(t, k) + INDEX);
        },
        [&mesh, across, vertex, neighbour](size_t, cell t) {
            int v[4], n[4];
            std::memcpy(v, &t[NUMBERS], sizeof v);
            for (int k = 0; k < 4; k++)
                n[tetgenmesh::oppopivot[k] - FIRST_CORNER] = mesh.elemindex(across(t, k));
            const int *turn = turned[std::min_element(v, v + 4) - v];
            const size_t at = 4 * static_cast<size_t>(mesh.elemindex(t));
            for (size_t k = 0; k < 4; k++) {
                vertex[at + k] = v[turn[k]];
                neighbour[at + k] = n[turn[k]];
            }
        });
}

// The points in the order in which they are to be inserted, numbered as they were given.
void transfer(tetgenmesh &mesh, tetgenio &in, size_t count, const double *position,
              const int32_t *order)
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

extern "C" long tetra_tetgen(size_t count, const double *position, const int32_t *order,
                             int threads, const tetra_sink *sink)
{
    tetgenmesh *mesh = nullptr;
    tetgenio in;
    try {
        tetgenbehavior behaviour;
        char switches[] = "Qzn";
        behaviour.parse_commandline(switches);
        behaviour.epsilon =
            1e-40; // less than any volume of the lattice: nothing counts as flat that is not
        behaviour.no_sort = 1;
        mesh = new tetgenmesh;
        mesh->b = &behaviour;
        mesh->in = &in;
        exactinit(0, 0, 0, 1, 1, 1);
        mesh->initializepools();
        transfer(*mesh, in, count, position, order);
        exactinit(0, 0, 0, mesh->xmax - mesh->xmin, mesh->ymax - mesh->ymin,
                  mesh->zmax - mesh->zmin); // of its static filters
        clock_t ticks;
        mesh->incrementaldelaunay(ticks);
        const cells all(*mesh, threads);
        const size_t made = number_cells(*mesh, all, count);
        delete mesh->points; // their room is for the result
        mesh->points = nullptr;
        int32_t *const vertex = sink->room(sink->context, made);
        static_assert(sizeof(int) == sizeof(int32_t), "TetGen's indices are 32 bits");
        if (vertex) {
            write_cells(*mesh, all, vertex, vertex + 4 * made);
            sink->whole(sink->context);
        }
        delete mesh;
        return vertex && made ? static_cast<long>(made) : -1;
    } catch (...) { // TetGen throws integers, after it has freed what the mesh would free again:
                    // the mesh stays
        return -1;
    }
}
