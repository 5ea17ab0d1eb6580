# SPDX-License-Identifier: Apache-2.0
"""Drawing probes, cells, slices and the scene into a renderer, and saving what it shows."""
import os
import subprocess
import sys

import numpy as np
import vtkmodules.vtkRenderingFreeType  # noqa: F401 (captions; VTK finds it by itself)
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.util.vtkConstants import VTK_ID_TYPE
from vtkmodules.vtkCommonCore import vtkIdList
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPlane, vtkPolyData
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkFiltersCore import vtkClipPolyData, vtkCutter, vtkTriangleFilter
from vtkmodules.vtkFiltersExtraction import vtkExtractCells, vtkExtractEdges
from vtkmodules.vtkFiltersGeneral import vtkShrinkFilter, vtkTransformFilter
from vtkmodules.vtkFiltersModeling import vtkAdaptiveSubdivisionFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor, vtkDataSetMapper, vtkRenderWindow, vtkTextActor, vtkWindowToImageFilter)

from .data import array, set_colours, to_display, to_srgb, triangles, unit

FINE = (0.75, 0.85, 1.0)  # lines
LEAK = (1.0, 0.28, 0.15)


def add(renderer, data, colour=None, opacity=1.0, width=1.0, ambient=1.0):
    mapper = vtkDataSetMapper()
    mapper.SetInputData(data)
    if colour is None:
        mapper.SetColorModeToDirectScalars()
    else:
        mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    if colour is not None:
        look.SetColor(*colour)
    look.SetOpacity(opacity)
    look.SetLineWidth(width)
    look.SetAmbient(ambient)
    look.SetDiffuse(1 - ambient)
    look.SetInterpolationToFlat()
    if ambient == 1:
        look.LightingOff()
    renderer.AddActor(actor)


def draw_scene(renderer, scene, eye, openness, brightness, opacity):
    keep = scene.shown(eye, openness)
    opaque = array(scene.data.GetCellData(), "opacity")
    keep &= opaque > 0.1
    shown = triangles(scene.points, scene.index[keep])
    albedo = array(scene.data.GetCellData(), "albedo")[keep]
    glow = array(scene.data.GetCellData(), "emission")[keep]
    facing = np.abs(np.einsum("ij,ij->i", scene.normal[keep], unit(eye - scene.centre[keep])))
    upward = scene.normal[keep] @ scene.up
    shade = brightness * (0.28 + 0.3 * facing + 0.12 * upward)
    brightest = glow.max(axis=1, keepdims=True)
    rgb = np.where(brightest > 0, glow / np.maximum(brightest, 1e-30),
                   albedo * np.maximum(shade, 0.05)[:, None])
    set_colours(shown.GetCellData(), to_srgb(rgb))
    if openness == 2:  # through the triangles that the plane meets
        origin, normal = scene.cut(eye)
        plane = vtkPlane()
        plane.SetOrigin(*(origin + 0.05 * scene.size * normal))
        plane.SetNormal(*-normal)
        clip = vtkClipPolyData()
        clip.SetInputData(shown)
        clip.SetClipFunction(plane)
        clip.Update()
        shown = clip.GetOutput()
    add(renderer, shown, opacity=opacity)


def draw_probes(renderer, baked, exposure, share, chosen):
    """Each probe as a small sphere, coloured at every point with its irradiance for that normal;
    those without light, such as stand inside of walls, as smaller ones."""
    points = baked.points[chosen]
    source = vtkSphereSource()
    fine = len(points) < 20000
    source.SetThetaResolution(20 if fine else 10)
    source.SetPhiResolution(14 if fine else 8)
    source.SetRadius(1)
    source.Update()
    ball = vtk_to_numpy(source.GetOutput().GetPoints().GetData()).astype(float)
    index = vtk_to_numpy(source.GetOutput().GetPolys().GetConnectivityArray()).reshape(-1, 3)
    extent = np.ptp(baked.points, axis=0)
    volume = np.prod(np.maximum(extent, 0.05 * extent.max() or 1.0))
    radius = share * (volume / len(baked.points)) ** (1 / 3)
    rgb = np.full((len(points), len(ball), 3), 0.5)
    radii = np.full((len(points), 1, 1), radius)
    if baked.sh is not None:
        rgb = exposure * baked.light(ball)[chosen]
        radii[rgb.max(axis=(1, 2)) < 1e-3] *= 0.4
    first = len(ball) * np.arange(len(points))
    shown = triangles((points[:, None] + radii * ball).reshape(-1, 3), index + first[:, None, None])
    set_colours(shown.GetPointData(), to_display(rgb.reshape(-1, 3)))
    add(renderer, shown)


def edges_of(data):
    edges = vtkExtractEdges()
    edges.SetInputData(data)
    edges.Update()
    return edges.GetOutput()


def extract(grid, ids):
    chosen = vtkIdList()
    for i in ids:
        chosen.InsertNextId(int(i))
    extracted = vtkExtractCells()
    extracted.SetInputData(grid)
    extracted.SetCellList(chosen)
    extracted.Update()
    return extracted.GetOutput()


def draw_leaks(renderer, baked, cells):
    """The edges along which light leaks: 2 in column occlusion (man probe.5)."""
    occlusion = array(baked.grid.GetCellData(), "occlusion")
    if occlusion is None:
        return
    leaks = (occlusion == 2) & cells[:, None]
    ends = baked.vertex[:, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]][leaks]
    if len(ends):
        each = np.unique(np.sort(ends, axis=1), axis=0).astype(np.int64)
        lines = vtkCellArray()
        lines.SetData(2, numpy_to_vtk(each.ravel(), deep=True, array_type=VTK_ID_TYPE))
        data = vtkPolyData()
        data.SetPoints(baked.grid.GetPoints())
        data.SetLines(lines)
        add(renderer, data, LEAK, opacity=min(0.9, max(0.2, 400 / len(ends))), width=1.5)


def draw_cells(renderer, baked, exposure, behind):
    """The cells behind a cut, each a little smaller than it is; of the others the edges."""
    part = extract(baked.grid, np.flatnonzero(behind))
    cells = vtk_to_numpy(part.GetCells().GetConnectivityArray()).reshape(-1, 4)
    light = array(part.GetPointData(), "irradiance")
    rgb = np.full((len(cells), 3), 0.4)
    if light is not None:
        rgb = exposure * light[cells].mean(axis=1) + 0.02
    set_colours(part.GetCellData(), to_display(rgb))
    shrink = vtkShrinkFilter()
    shrink.SetInputData(part)
    shrink.SetShrinkFactor(0.82)
    shrink.Update()
    add(renderer, shrink.GetOutput(), ambient=0.45)
    add(renderer, edges_of(extract(baked.grid, np.flatnonzero(~behind))), FINE,
        opacity=min(0.15, 150 / len(behind)))
    draw_leaks(renderer, baked, behind)


FINENESS = 400  # parts of a slice's longer side


def fine(surface, across):
    """The same in triangles so small that light can end between their corners."""
    flat = vtkTriangleFilter()
    flat.SetInputData(surface)
    parts = vtkAdaptiveSubdivisionFilter()
    parts.SetInputConnection(flat.GetOutputPort())
    parts.SetMaximumEdgeLength(across / FINENESS)
    parts.SetMaximumTriangleArea(across ** 2)
    parts.Update()
    return parts.GetOutput()


def query(points, light):
    """Mean irradiance at points, by probe-query."""
    try:
        asked = subprocess.run(["probe-query", "-q", "--from", "binary", "--to", "binary", light],
                               input=np.ascontiguousarray(points, "<f8").tobytes(),
                               stdout=subprocess.PIPE, check=False)
    except FileNotFoundError:
        sys.exit("picture: --light needs probe-query on the PATH")
    sh = np.frombuffer(asked.stdout, "<f4")
    if asked.returncode or not sh.size:
        sys.exit(f"picture: {light}: probe-query answers nothing")
    return np.pi * 0.282095 * sh.reshape(len(points), -1)[:, :3]


def draw_slice(renderer, baked, scene, exposure, up, options):
    plane = vtkPlane()
    height = baked.points @ up
    origin = baked.middle + up * (height.min() + options.at * np.ptp(height) - baked.middle @ up)
    plane.SetOrigin(*origin)
    plane.SetNormal(*up)

    def cut(data):
        cutter = vtkCutter()
        cutter.SetInputData(data)
        cutter.SetCutFunction(plane)
        cutter.Update()
        return cutter.GetOutput()

    surface = cut(baked.grid)
    if not surface.GetNumberOfCells():
        sys.exit(f"picture: {options.baked}: the plane meets no tetrahedron")
    lines = edges_of(surface)
    light = array(surface.GetPointData(), "irradiance")
    if options.light:
        surface = fine(surface, np.ptp(baked.points, axis=0).max())
        light = query(vtk_to_numpy(surface.GetPoints().GetData()), options.light)
        if baked.convolved:
            light /= np.pi
    set_colours(surface.GetPointData(), to_display(exposure * light))
    add(renderer, surface)
    lift = 1e-3 * np.linalg.norm(np.ptp(baked.points, axis=0)) * up

    def raised(data):
        move = vtkTransform()
        move.Translate(*lift)
        filtered = vtkTransformFilter()
        filtered.SetTransform(move)
        filtered.SetInputData(data)
        filtered.Update()
        return filtered.GetOutput()

    add(renderer, raised(lines), FINE, opacity=0.25)
    if scene is not None:
        add(renderer, raised(cut(scene.data)), (0.95, 0.55, 0.1), width=3)
        below = vtkClipPolyData()
        opposite = vtkPlane()
        opposite.SetOrigin(*origin)
        opposite.SetNormal(*-up)
        albedo = array(scene.data.GetCellData(), "albedo")
        shade = 0.25 + 0.2 * np.abs(scene.normal @ up)[:, None]
        solid = triangles(scene.points, scene.index)
        set_colours(solid.GetCellData(), to_srgb(albedo * shade))
        below.SetInputData(solid)
        below.SetClipFunction(opposite)
        below.Update()
        add(renderer, below.GetOutput())


def add_caption(renderer, baked, exposure, options):
    words = [f"{len(baked.points)} probes"]
    if baked.has_cells:
        words.append(f"{baked.grid.GetNumberOfCells()} tetrahedra")
        leaking = array(baked.grid.GetCellData(), "leaking_edges")
        if leaking is not None and options.what in ("cells", "both"):
            words.append(f"walls on edges of {np.count_nonzero(leaking)} (red)")
    if baked.sh is not None:
        words.append(f"exposure {exposure:.3g}")
    caption = vtkTextActor()
    caption.SetInput(",  ".join(words))
    caption.SetPosition(12, 10)
    caption.GetTextProperty().SetFontSize(max(10, options.size[1] // 50))
    caption.GetTextProperty().SetColor(0.85, 0.87, 0.9)
    renderer.AddViewProp(caption)


def save(renderer, options):
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetAlphaBitPlanes(1)
    window.SetSize(*options.size)
    window.AddRenderer(renderer)
    window.Render()
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    writer = vtkPNGWriter()
    writer.WriteToMemoryOn()
    writer.SetInputConnection(grab.GetOutputPort())
    writer.Write()
    beside = f"{options.output}.{os.getpid()}"
    try:
        with open(beside, "wb") as file:
            file.write(vtk_to_numpy(writer.GetResult()).tobytes())
        os.replace(beside, options.output)
    except OSError as error:
        if os.path.exists(beside):
            os.remove(beside)
        sys.exit(f"picture: {options.output}: {error.strerror}")


def draw(renderer, baked, scene, eye, openness, exposure, options):
    what, up = options.what, unit(options.up)
    if what == "slice":
        draw_slice(renderer, baked, scene, exposure, up, options)
        return
    if scene is not None:
        brightness, opacity = {"probes": (1, 1), "cells": (1, 0.35), "both": (0.4, 1)}[what]
        draw_scene(renderer, scene, eye, openness, brightness, opacity)
    if what == "cells":
        centres = baked.points[baked.vertex].mean(axis=1)
        if openness == 2:  # the cut that the scene has
            behind = ~scene.before_cut(centres, eye)
        else:  # the upright plane, through the middle, that faces the camera
            towards = eye - baked.middle
            behind = (centres - baked.middle) @ (towards - up * (towards @ up)) < 0
        draw_cells(renderer, baked, exposure, behind)
        return
    chosen = np.ones(len(baked.points), bool)
    if openness == 2:
        chosen = ~scene.before_cut(baked.points, eye)
    draw_probes(renderer, baked, exposure, 0.17 if what == "probes" else 0.12, chosen)
    if what == "both":
        cells = chosen[baked.vertex].all(axis=1)
        add(renderer, edges_of(extract(baked.grid, np.flatnonzero(cells))), FINE, opacity=0.25)
        draw_leaks(renderer, baked, cells)
