# SPDX-License-Identifier: Apache-2.0
"""What else interpolates in tetrahedra: scipy's LinearNDInterpolator and VTK's vtkProbeFilter."""
import statistics
import time

from .running import output_of


def read_cells(path):
    """Positions, coefficients and cells of a stream, as arrays."""
    import numpy
    tables = output_of("probe-cat", "--text", path).split("\ntable ")

    def numbers(lines):
        rows = [line for line in lines.split("\n")[1:] if line and line != "end"]
        return numpy.loadtxt(rows, comments="#")

    probes, cells = numbers(tables[1]), numbers(tables[2])
    return probes[:, :3], probes[:, 3:30], cells[:, :4].astype(numpy.int64)


def vtk_probe(position, light, vertex):
    """A function that has VTK interpolate at points."""
    import numpy
    import vtkmodules.all as vtk
    from vtkmodules.util import numpy_support
    grid = vtk.vtkUnstructuredGrid()
    at = vtk.vtkPoints()
    at.SetData(numpy_support.numpy_to_vtk(position, deep=True))
    grid.SetPoints(at)
    array = vtk.vtkCellArray()
    offsets = numpy_support.numpy_to_vtkIdTypeArray(4 * numpy.arange(len(vertex) + 1), deep=True)
    array.SetData(offsets, numpy_support.numpy_to_vtkIdTypeArray(vertex.ravel(), deep=True))
    grid.SetCells(vtk.VTK_TETRA, array)
    values = numpy_support.numpy_to_vtk(light.astype(numpy.float32), deep=True)
    values.SetName("sh")
    grid.GetPointData().AddArray(values)
    probe = vtk.vtkProbeFilter()
    probe.SetSourceData(grid)
    vtk.vtkSMPTools.Initialize(1)

    def ask(points):
        data, where = vtk.vtkPolyData(), vtk.vtkPoints()
        where.SetData(numpy_support.numpy_to_vtk(points, deep=True))
        data.SetPoints(where)
        probe.SetInputData(data)
        probe.Update()

    return ask


def rates_of_peers(stream, points, runs):
    """Points a second of each peer at each of these arrays, on one thread, set-up not counted."""
    import scipy.interpolate
    position, light, vertex = read_cells(stream)
    peers = {"scipy LinearNDInterpolator": scipy.interpolate.LinearNDInterpolator(position, light),
             "vtkProbeFilter": vtk_probe(position, light, vertex)}
    rates = {}
    for name, ask in peers.items():
        rates[name] = []
        for p in points:
            ask(p[:100])  # makes the locator
            times = []
            for _ in range(runs):
                start = time.perf_counter()
                ask(p)
                times.append(time.perf_counter() - start)
            rates[name].append(len(p) / statistics.median(times))
    return rates
