# SPDX-License-Identifier: Apache-2.0
"""vtk_read: looks at .vtu, .vtp and .png files with VTK's own readers, for tests/probe-vtk.t.

    vtk_read.py               for each line of standard input, CHECK<tab>ARGUMENT..., a line:
                              "holds", or what does not; one process, since to load VTK takes longer
                              than all that it is asked

    columns FILE.vtu STREAM       every column, key and command line of the text stream is there,
                                  unchanged
    derived FILE.vtu              derived arrays are what their formulas say, computed here anew
    gradient FILE.vtu X,Y,Z       luminance_gradient of points and cells is this vector everywhere
    value FILE ARRAY X,..         ARRAY of points or cells is this everywhere
    same A.vtu B.vtu              equal geometry, arrays and keys
    solid FILE.vtp AREA VOLUME    area, and volume inside of the fronts
    picture FILE.png WxH          a picture of this size with something in it
"""
import sys

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.util.vtkConstants import VTK_LINE, VTK_TETRA, VTK_TRIANGLE, VTK_VERTEX
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkCommonMisc import vtkErrorCode
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

FAILED = []

# Tables of cells by their corners, and what they are in VTK.
TABLES = {1: "point", 2: "segment", 3: "tri", 4: "tet"}
KINDS = {1: VTK_VERTEX, 2: VTK_LINE, 3: VTK_TRIANGLE, 4: VTK_TETRA}


def check(holds, what):
    if not np.all(holds):
        FAILED.append(what)


def close(a, b, tolerance, what):
    a, b = np.asarray(a, float), np.asarray(b, float)
    check(a.shape == b.shape, f"{what}: shape {a.shape}, expected {b.shape}")
    if a.shape == b.shape and a.size:
        error = np.abs(a - b) / np.maximum(np.abs(b).max(), 1e-30)
        worst = error.argmax()
        check(error.max() <= tolerance, f"{what}: {a.flat[worst]!r} instead of {b.flat[worst]!r}")


def read(path):
    if path.endswith(".vtp"):
        reader = vtkXMLPolyDataReader()
    else:
        reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    if reader.GetErrorCode():
        why = vtkErrorCode.GetStringFromErrorCode(reader.GetErrorCode())
        raise ValueError(f"{path}: not readable: {why}")
    return reader.GetOutput()


def arrays(attributes):
    found = {}
    for i in range(attributes.GetNumberOfArrays()):
        a = attributes.GetArray(i)
        found[a.GetName()] = vtk_to_numpy(a).reshape(a.GetNumberOfTuples(), -1)
    return found


def component_names(attributes, name):
    a = attributes.GetArray(name)
    return [a.GetComponentName(k) for k in range(a.GetNumberOfComponents())]


def texts(data):
    field = data.GetFieldData()
    found = {}
    for i in range(field.GetNumberOfArrays()):
        a = field.GetAbstractArray(i)
        found[a.GetName()] = [a.GetValue(k) for k in range(a.GetNumberOfValues())]
    return found


def geometry(data):
    cells = data.GetPolys() if isinstance(data, vtkPolyData) else data.GetCells()
    count = max(cells.GetNumberOfCells(), 1)
    points = vtk_to_numpy(data.GetPoints().GetData())
    return points, vtk_to_numpy(cells.GetConnectivityArray()).reshape(count, -1)


def read_stream(path):
    keys, commands, tables = {}, [], {}
    with open(path, encoding="utf-8") as file:
        lines = file.read().split("\n")
    columns = None
    for line in lines[1:]:
        words = line.split()
        if not words or words[0] == "end":
            continue
        if words[0] == "table":
            columns = [word.split(":") for word in words[2:]]
            tables[words[1]] = (columns, [])
            rows = tables[words[1]][1]
        elif columns:
            rows.append(words)
        elif words[0] == "#":
            commands.append(line[2:])
        else:
            keys[words[0]] = line[len(words[0]) + 1:]
    types = {"f32": np.float32, "f64": np.float64, "i32": np.int32}
    result = {}
    for name, (columns, rows) in tables.items():
        at, result[name] = 0, {}
        for column, kind, width in columns:
            values = np.array([row[at:at + int(width)] for row in rows])
            result[name][column] = values.astype(np.float64).astype(types[kind])
            at += int(width)
    return keys, commands, result


def check_columns(path, stream):
    data = read(path)
    keys, commands, tables = read_stream(stream)
    cell_table = next((t for t in TABLES.values() if t in tables), None)
    for table, attributes in (("probe", data.GetPointData()), (cell_table, data.GetCellData())):
        found = arrays(attributes)
        for name, values in tables.get(table, {}).items():
            if name not in found:
                check(False, f"{table}: there is no array {name}")
                continue
            check(found[name].dtype == values.dtype, f"{table}: {name} is {found[name].dtype}")
            check(np.array_equal(found[name], np.nan_to_num(values, nan=0)),
                  f"{table}: {name} has other values")
        for name, values in found.items():
            check(np.isfinite(values).all(), f"{table}: {name} is not finite everywhere")
    points, cells = geometry(data)
    kinds = np.array([data.GetCellType(i) for i in range(len(cells))])
    check(np.array_equal(points, tables["probe"]["position"]), "points are not the positions")
    if cell_table:
        corners = cells.shape[1]
        check(TABLES[corners] == cell_table, f"cells of {cell_table} have {corners} corners")
        check(np.array_equal(cells, tables[cell_table]["vertex"]), "cells are not the vertices")
        check(kinds == KINDS[corners], f"cells are not those of {cell_table}")
        if corners == 4:
            check(np.linalg.det(points[cells[:, 1:]] - points[cells[:, :1]]) > 0,
                  "cells are turned inside out")
    else:
        check(np.array_equal(cells[:, 0], np.arange(len(points))), "cells are not the points")
        check(kinds == VTK_VERTEX, "cells are not vertices")
    if "sh" in tables["probe"]:
        width = tables["probe"]["sh"].shape[1]
        names = [f"L{l}{m}.{c}" for l in range(6) for m in range(-l, l + 1) for c in "rgb"]
        check(component_names(data.GetPointData(), "sh") == names[:width],
              "names of the components of sh")
    if "sh_gradient" in tables["probe"]:
        names = component_names(data.GetPointData(), "sh_gradient")
        first = ["L00.r.x", "L00.g.x", "L00.b.x", "L1-1.r.x"]
        check(names[:4] == first and names[-1].endswith(".b.z"),
              f"names of the components of sh_gradient: {names[:4]}")
    field = texts(data)
    for key, value in keys.items():
        check(field.get(key) == [value], f"key {key} is {field.get(key)}, expected {value}")
    check(field.get("Provenance", []) == commands, f"provenance is {field.get('Provenance')}")


def content(edge):
    """Volume, area or length of simplices, from their edges at a corner."""
    size = np.sqrt(np.maximum(np.linalg.det(edge @ edge.transpose(0, 2, 1)), 0))
    return size / [1, 1, 2, 6][edge.shape[1]]


def lengths(p):
    """Of all edges of simplices."""
    pairs = [(i, j) for i in range(p.shape[1]) for j in range(i)]
    return np.array([np.linalg.norm(p[:, i] - p[:, j], axis=1) for i, j in pairs])


def least_angle(p):
    """Of triangles, by the law of cosines."""
    c, b, a = lengths(p)
    angles = [np.arccos(np.clip((y ** 2 + z ** 2 - x ** 2) / (2 * y * z), -1, 1))
              for x, y, z in ((a, b, c), (b, c, a), (c, a, b))]
    return np.degrees(np.min(angles, axis=0))


def check_quality(at_cells, p, size):
    """That of tetrahedra, triangles and segments, and no other."""
    corners = p.shape[1]
    name = {4: "volume", 3: "area", 2: "length"}[corners]
    own = {name, {4: "min_dihedral", 3: "min_angle"}.get(corners)}
    for other in {"volume", "area", "length", "min_dihedral", "min_angle"} - own:
        check(other not in at_cells, f"cells of {corners} corners have {other}")
    close(at_cells[name][:, 0], size, 1e-12 if corners == 4 else 1e-9, name)
    if corners == 4:
        close(at_cells["min_dihedral"][:, 0], least_dihedral(p), 1e-6, "min_dihedral")
        area = sum(np.linalg.norm(np.cross(p[:, b] - p[:, a], p[:, c] - p[:, a]), axis=1) / 2
                   for a, b, c in ([1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]))
        aspect = lengths(p).max(axis=0) * area / (6 * np.sqrt(6) * size)
    elif corners == 3:
        close(at_cells["min_angle"][:, 0], least_angle(p), 1e-6, "min_angle")
        aspect = lengths(p).max(axis=0) * lengths(p).sum(axis=0) / (4 * np.sqrt(3) * size)
    if corners > 2:
        close(np.log(at_cells["aspect_ratio"][:, 0]), np.log(aspect), 1e-6, "aspect_ratio")


def least_dihedral(p):
    """By the angle, in the plane across each edge, of the directions to the two other corners."""
    angles = []
    for i in range(4):
        for j in range(i + 1, 4):
            k, l = (x for x in range(4) if x not in (i, j))
            e = p[:, j] - p[:, i]
            e /= np.linalg.norm(e, axis=1, keepdims=True)
            a, b = p[:, k] - p[:, i], p[:, l] - p[:, i]
            a -= e * (a * e).sum(1, keepdims=True)
            b -= e * (b * e).sum(1, keepdims=True)
            cosine = (a * b).sum(1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
            angles.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return np.min(angles, axis=0)


def check_derived(path):
    data = read(path)
    at_points, at_cells = arrays(data.GetPointData()), arrays(data.GetCellData())
    field = texts(data)
    points, cells = geometry(data)
    sh = at_points["sh"].astype(float).reshape(len(points), -1, 3)
    convolved = field.get("sh-content") == ["irradiance"]
    factor = 0.28209479177387814 * (1 if convolved else np.pi)
    irradiance = factor * sh[:, 0]
    luminance = irradiance @ [0.2126, 0.7152, 0.0722]
    close(at_points["irradiance"], irradiance, 1e-6, "irradiance")
    close(at_points["luminance"][:, 0], luminance, 1e-6, "luminance")
    if sh.shape[1] > 1:
        brightest = sh[:, [3, 1, 2]] @ [0.2126, 0.7152, 0.0722]
        close(at_points["brightest"], brightest / (2 * np.pi / 3 if convolved else 1), 1e-5,
              "brightest")
    exposure = float(field["Exposure"][0])
    lit = np.sort(luminance[luminance > 0])
    close(exposure * lit[(len(lit) - 1) * 95 // 100], 0.7, 1e-6, "exposure")
    x = np.clip(exposure * irradiance, 0, 1)
    code = 255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    check(np.abs(at_points["colour"] - code) <= 0.51,
          "colour is not the sRGB code of exposed irradiance")
    edge = points[cells[:, 1:]] - points[cells[:, :1]]
    difference = luminance[cells[:, 1:]] - luminance[cells[:, :1]]
    # along the plane or line of a triangle or segment
    gradient = (np.linalg.pinv(edge) @ difference[:, :, None])[:, :, 0]
    volume = content(edge)
    check_quality(at_cells, points[cells], volume)
    scale = np.abs(difference).max(axis=1) * np.linalg.norm(np.linalg.pinv(edge), axis=(1, 2))
    of_cells = at_cells["luminance_gradient"]
    check(np.abs(of_cells - gradient).max(axis=1) <= 1e-5 * scale + 1e-30,
          "luminance_gradient of cells")
    total, weight = np.zeros((len(points), 3)), np.zeros(len(points))
    for corner in cells.T:
        np.add.at(total, corner, volume[:, None] * of_cells)
        np.add.at(weight, corner, volume)
    total /= np.maximum(weight, 1e-300)[:, None]
    close(at_points["luminance_gradient"], total, 1e-5, "luminance_gradient of points")
    outside = at_cells["neighbour"] < 0
    check(np.array_equal(at_cells["hull_faces"][:, 0], outside.sum(axis=1)), "hull_faces")
    hull = np.zeros(len(points), int)
    for i in range(cells.shape[1]):
        hull[np.delete(cells[outside[:, i]], i, axis=1)] = 1
    check(np.array_equal(at_points["hull"][:, 0], hull), "hull")
    if "occlusion" in at_cells:
        occlusion = at_cells["occlusion"]
        for name, marked in (("crossed_edges", occlusion > 0), ("leaking_edges", occlusion == 2)):
            check(np.array_equal(at_cells[name][:, 0], marked.sum(axis=1)), name)
    if "sight" in at_cells:
        nearest = np.maximum(at_cells["sight"].max(axis=1), 1)
        close(at_cells["free_way"][:, 0], 1 / nearest, 1e-6, "free_way")
        check(nearest.max() > 1, "nothing stands in any cell")


def check_gradient(path, vector):
    """To the rounding of the luminances, which a thin cell magnifies."""
    data = read(path)
    points, cells = geometry(data)
    edge = points[cells[:, 1:]] - points[cells[:, :1]]
    # Of a difference of two: each was rounded to 2^-24 of itself as SH, as irradiance and as
    # luminance.
    rounding = 2 * 3 * 2 ** -24 * np.abs(arrays(data.GetPointData())["luminance"]).max()
    flat = content(edge) < 1e-12
    full = np.where(flat[:, None, None], np.eye(3)[:edge.shape[1]], edge)
    allowed = rounding * np.linalg.norm(np.linalg.pinv(full), axis=(1, 2))
    of_cells = arrays(data.GetCellData())["luminance_gradient"]
    of_points = arrays(data.GetPointData())["luminance_gradient"]
    check(np.abs(of_cells - vector).max(axis=1) <= allowed, f"gradient of cells: {of_cells[:3]}")
    around = np.zeros(len(points))
    for corner in cells.T:
        np.maximum.at(around, corner, allowed)
    check(np.abs(of_points - vector).max(axis=1) <= around,
          f"gradient of points: {of_points[:3]}")


def check_value(path, name, values):
    data = read(path)
    found = {**arrays(data.GetCellData()), **arrays(data.GetPointData())}.get(name)
    if found is None:
        raise ValueError(f"there is no array {name}")
    close(found, np.tile(values, (len(found), 1)), 1e-7, name)


def check_same(one, other):
    a, b = read(one), read(other)
    check(all(np.array_equal(x, y) for x, y in zip(geometry(a), geometry(b))), "other geometry")
    one_field, other_field = texts(a), texts(b)
    check(bool(one_field.pop("Provenance") and other_field.pop("Provenance")), "no provenance")
    check(one_field == other_field, "other keys")
    for x, y in ((a.GetPointData(), b.GetPointData()), (a.GetCellData(), b.GetCellData())):
        x, y = arrays(x), arrays(y)
        check(list(x) == list(y) and len(x) > 0, f"other arrays: {list(x)}, {list(y)}")
        check(all(np.array_equal(x[name], y[name]) for name in x), "other values")


def check_solid(path, area, volume):
    points, cells = geometry(read(path))
    p = points[cells]
    across = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    close(np.linalg.norm(across, axis=1).sum() / 2, area, 1e-6, "area")
    close(np.linalg.det(p - points.mean(axis=0)).sum() / 6, volume, 1e-6, "volume")


def check_picture(path, size):
    reader = vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    check("x".join(str(n) for n in image.GetDimensions()[:2]) == size,
          f"size {image.GetDimensions()}")
    pixels = vtk_to_numpy(image.GetPointData().GetScalars())[:, :3]
    width = image.GetDimensions()[0]
    rows = pixels.reshape(-1, width, 3).astype(int)
    # the background alone changes from row to row only
    drawn = (np.ptp(rows, axis=1).max(axis=1) > 8).mean()
    check(drawn > 0.4, f"only {100 * drawn:.0f} % of the rows show anything")
    check(len(np.unique(pixels, axis=0)) > 500, "fewer than 500 colours")


def number_list(text):
    return [float(x) for x in text.split(",")]


CHECKS = {
    "columns": check_columns,
    "derived": check_derived,
    "gradient": lambda path, wanted: check_gradient(path, number_list(wanted)),
    "value": lambda path, name, wanted: check_value(path, name, number_list(wanted)),
    "same": check_same,
    "solid": lambda path, area, volume: check_solid(path, float(area), float(volume)),
    "picture": check_picture,
}


def main():
    for line in sys.stdin:
        what, *arguments = line.rstrip("\n").split("\t")
        FAILED.clear()
        try:
            CHECKS[what](*arguments)
        except Exception as error:  # whatever it is, this check fails and the next is asked
            FAILED.append(f"{what}: {error!r}")
        print("; ".join(FAILED) or "holds", flush=True)


main()
