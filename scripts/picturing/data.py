# SPDX-License-Identifier: Apache-2.0
"""What probe-vtk wrote: the probes with their tetrahedra, the scene; and colours for a screen."""
import os
import sys

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.util.vtkConstants import VTK_ID_TYPE, VTK_TETRA, VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonCore import vtkIdList, vtkLogger, vtkObject, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersGeneral import vtkOBBTree
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader


def read(reader, path):
    if not os.path.isfile(path):
        sys.exit(f"picture: {path}: no such file")
    vtkObject.GlobalWarningDisplayOff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    reader.SetFileName(path)
    reader.Update()
    data = reader.GetOutput()
    if reader.GetErrorCode() or data is None or data.GetNumberOfPoints() == 0:
        sys.exit(f"picture: {path}: expected a file of probe-vtk")
    return data


def array(attributes, name):
    found = attributes.GetArray(name)
    return None if found is None else vtk_to_numpy(found)


def unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)


def to_display(linear):
    """sRGB codes; bright light fades into white instead of stopping there."""
    x = 1 - np.exp(-np.maximum(linear, 0))
    code = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return (255 * code + 0.5).astype(np.uint8)


def to_srgb(linear):
    return to_display(-np.log1p(-np.clip(linear, 0, 1 - 1e-6)))


def set_colours(attributes, rgb):
    shown = numpy_to_vtk(np.ascontiguousarray(rgb), deep=True, array_type=VTK_UNSIGNED_CHAR)
    shown.SetName("shown")
    attributes.AddArray(shown)
    attributes.SetActiveScalars("shown")


def triangles(points, index):
    data = vtkPolyData()
    place = vtkPoints()
    place.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
    data.SetPoints(place)
    polys = vtkCellArray()
    polys.SetData(3, numpy_to_vtk(np.ascontiguousarray(index.ravel()), deep=True,
                                  array_type=VTK_ID_TYPE))
    data.SetPolys(polys)
    return data


class Baked:
    """The probes and tetrahedra."""

    def __init__(self, path):
        self.grid = read(vtkXMLUnstructuredGridReader(), path)
        self.points = vtk_to_numpy(self.grid.GetPoints().GetData())
        self.middle = (self.points.min(axis=0) + self.points.max(axis=0)) / 2
        self.has_cells = self.grid.GetCellType(0) == VTK_TETRA
        vertex = vtk_to_numpy(self.grid.GetCells().GetConnectivityArray())
        self.vertex = vertex.reshape(-1, 4 if self.has_cells else 1)
        sh = array(self.grid.GetPointData(), "sh")
        self.irradiance = array(self.grid.GetPointData(), "irradiance")
        self.sh = None
        if sh is not None and self.irradiance is not None:
            self.sh = sh.reshape(len(self.points), -1, 3).astype(float)
        self.convolved = self.text("sh-content") == "irradiance"
        self.exposure = float(self.text("Exposure") or 1)

    def text(self, name):
        lines = self.grid.GetFieldData().GetAbstractArray(name)
        return lines.GetValue(0) if lines else None

    def light(self, normals):
        """Irradiance of each probe for each normal (Ramamoorthi and Hanrahan 2001, eq. 8), without
        bands from 3 on."""
        x, y, z = normals.T
        basis = np.stack([0.282095 + 0 * x, 0.488603 * y, 0.488603 * z, 0.488603 * x,
                          1.092548 * x * y, 1.092548 * y * z, 0.315392 * (3 * z * z - 1),
                          1.092548 * x * z, 0.546274 * (x * x - y * y)])
        cosine = np.ones(9)
        if not self.convolved:
            cosine = np.array([np.pi] + 3 * [2 * np.pi / 3] + 5 * [np.pi / 4])
        count = min(9, self.sh.shape[1])
        return np.einsum("pic,ij->pjc", self.sh[:, :count], (cosine[:, None] * basis)[:count])


class Scene:
    """The scene's triangles, with what is needed to look into it."""

    def __init__(self, path, up):
        self.data = read(vtkXMLPolyDataReader(), path)
        self.index = vtk_to_numpy(self.data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        self.points = vtk_to_numpy(self.data.GetPoints().GetData())
        self.up = up
        corner = self.points[self.index]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        self.area = np.linalg.norm(normal, axis=1) / 2
        self.normal = unit(normal)
        self.centre = corner.mean(axis=1)
        self.low, self.high = corner.min(axis=(0, 1)), corner.max(axis=(0, 1))
        self.size = np.maximum(self.high - self.low, 1e-9 * np.linalg.norm(self.high - self.low))
        self.tree = vtkOBBTree()
        self.tree.SetDataSet(self.data)
        self.tree.BuildLocator()

    def shown(self, eye, openness):
        """Which triangles stay when one looks from `eye`: at openness 0 all but those of the
        outermost shell that is between the eye and the middle, at 1 only those that face the eye,
        at 2 only those behind a cut."""
        place = (self.centre - (self.low + self.high) / 2) / self.size
        axis = np.abs(place).argmax(axis=1)
        rows = np.arange(len(place))
        side = np.sign(place[rows, axis])
        wall = np.where(side > 0, self.high[axis], self.low[axis])
        shown = ~((np.abs(place[rows, axis]) > 0.47) & (side * (eye[axis] - wall) > 0))
        if openness == 1:
            shown &= np.einsum("ij,ij->i", self.normal, eye - self.centre) > 0
        if openness == 2:
            shown &= ~self.before_cut(self.centre, eye)
        return shown

    def cut(self, eye):
        """The plane, through the middle and upright, that faces the eye."""
        towards = eye - (self.low + self.high) / 2
        towards = towards - self.up * (towards @ self.up)
        axis = np.abs(unit(towards)).argmax()
        return (self.low + self.high) / 2, np.eye(3)[axis] * np.sign(towards[axis])

    def before_cut(self, points, eye):
        origin, normal = self.cut(eye)
        return (points - origin) @ normal > 0.05 * (self.size @ np.abs(normal))

    def in_front_of(self, eye, points):
        """For each point the triangles between it and the eye."""
        hit, ids = vtkPoints(), vtkIdList()
        result = []
        for p in points:
            self.tree.IntersectWithLine(p + 1e-3 * (eye - p), eye, hit, ids)
            result.append([ids.GetId(i) for i in range(ids.GetNumberOfIds())])
        return result
