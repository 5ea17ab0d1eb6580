"""Reads a .vtu or .vtp and prints what is in it, an array a line, for probe-vtk.t.

    vtk_read.py FILE          points, cells, and each array: where, name, components, first component's name, range
    vtk_read.py FILE ARRAY    the numbers of one point array, a tuple a line
"""
import sys

import vtk

reader = vtk.vtkXMLUnstructuredGridReader() if sys.argv[1].endswith(".vtu") else vtk.vtkXMLPolyDataReader()
reader.SetFileName(sys.argv[1])
reader.Update()
data = reader.GetOutput()
if len(sys.argv) > 2:
    array = data.GetPointData().GetArray(sys.argv[2]) or data.GetCellData().GetArray(sys.argv[2])
    for i in range(array.GetNumberOfTuples()):
        print(*(repr(x) for x in array.GetTuple(i)))
    sys.exit()
print("points", data.GetNumberOfPoints())
print("cells", data.GetNumberOfCells(), data.GetCellType(0) if data.GetNumberOfCells() else "-")
for where, attributes in (("point", data.GetPointData()), ("cell", data.GetCellData())):
    for i in range(attributes.GetNumberOfArrays()):
        array = attributes.GetArray(i)
        print(where, array.GetName(), array.GetNumberOfComponents(), array.GetComponentName(0), *array.GetRange())
for i in range(data.GetFieldData().GetNumberOfArrays()):
    array = data.GetFieldData().GetAbstractArray(i)
    print("field", array.GetName(), array.GetValue(0))
volume = 0.0
area = 0.0
for i in range(data.GetNumberOfCells()):
    cell = data.GetCell(i)
    p = [cell.GetPoints().GetPoint(k) for k in range(cell.GetNumberOfPoints())]
    if cell.GetCellType() == vtk.VTK_TETRA:
        a, b, c = ([p[k][m] - p[0][m] for m in range(3)] for k in (1, 2, 3))
        six = (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]))
        if six <= 0:
            print("inverted", i)
        volume += six / 6
    elif cell.GetCellType() == vtk.VTK_TRIANGLE:
        area += vtk.vtkTriangle.TriangleArea(*p)
print("volume %.9g area %.9g" % (volume, area))
