// The shim around TetGen: point set in, cells out. It runs in a child process (tetra.c): TetGen prints, asserts, aborts and
// frees twice on its error path, and none of that may reach the program.
#include "tetra.h"

#include <cstdlib>
#include <cstring>
#define TETLIBRARY
#include <tetgen.h>

extern "C" long tetra_tetgen(size_t count, const double *position, int32_t **vertex, int32_t **neighbour)
{
    *vertex = *neighbour = nullptr;
    try {
        // TetGen's destructor frees, on errors twice; the process ends soon, so both stay.
        static tetgenio *const in_kept = new tetgenio, *const out_kept = new tetgenio;
        tetgenio &in = *in_kept, &out = *out_kept;
        in.numberofpoints = static_cast<int>(count);
        in.pointlist = new double[3 * count];
        std::memcpy(in.pointlist, position, 3 * count * sizeof(double));
        char switches[] = "Qzn";
        tetrahedralize(switches, &in, &out);
        static_assert(sizeof(int) == sizeof(int32_t), "TetGen's indices are 32 bits");
        *vertex = out.tetrahedronlist;
        *neighbour = out.neighborlist;
        return out.tetrahedronlist && out.neighborlist ? out.numberoftetrahedra : -1;
    } catch (...) { // TetGen throws integers
        return -1;
    }
}
