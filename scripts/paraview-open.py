# SPDX-License-Identifier: Apache-2.0
"""paraview-open: opens a bake in ParaView, ready to look at.

    paraview --script=scripts/paraview-open.py
    pvpython scripts/paraview-open.py [BAKED.vtu [SCENE.vtp]] [OUT.png | OUT.pvsm]

Without names: the environment's BAKED and SCENE, or out/baked.vtu as scripts/demo leaves it. The
scene is looked for as probe-vtk and the demo name it: BAKED.scene.vtp, then scene.vtp beside it.
OUT.png is a picture, OUT.pvsm a state to open.

Shown: the scene's surface, without what faces away; the probes as spheres in their colour; the
edges of the tetrahedra; in red those of cells that leak. Made and hidden (the eye in the pipeline
browser): the scene's back half, for scenes that cannot be looked into; arrows towards the light and
along the gradient of luminance; a level slice through the tetrahedra."""
import os
import sys

from paraview.simple import (Clip, ColorBy, ExtractEdges, GetActiveViewOrCreate, Glyph, Hide,
                             OpenDataFile, RenameSource, Render, ResetCamera, SaveScreenshot,
                             SaveState, Show, Slice, Threshold)


def spacing(data):
    """About how far probes are from each other."""
    bounds = data.GetDataInformation().GetBounds()
    sides = [max(bounds[2 * i + 1] - bounds[2 * i], 1e-300) for i in range(3)]
    volume = 1.0
    for side in sides:
        volume *= max(side, 0.05 * max(sides))
    return (volume / max(data.GetDataInformation().GetNumberOfPoints(), 1)) ** (1 / 3)


def in_own_colour(shown, where):
    ColorBy(shown, (where, "colour"))
    shown.MapScalars = 0


def in_one_colour(shown, colour, opacity):
    shown.ColorArrayName = ["POINTS", ""]
    shown.AmbientColor = shown.DiffuseColor = colour
    shown.Opacity = opacity


def show_scene(path, view):
    scene = OpenDataFile(path)
    RenameSource("scene", scene)
    shown = Show(scene, view)
    in_own_colour(shown, "CELLS")
    shown.BackfaceRepresentation = "Cull Backface"
    half = Clip(Input=scene)
    RenameSource("scene, back half", half)
    half.ClipType.Normal = [0, 0, 1]
    in_own_colour(Show(half, view), "CELLS")
    Hide(half, view)


def arrows(name, data, vectors, length, colour, view):
    glyph = Glyph(Input=data, GlyphType="Arrow")
    RenameSource(name, glyph)
    glyph.OrientationArray = ["POINTS", vectors]
    glyph.ScaleArray = ["POINTS", "No scale array"]
    glyph.ScaleFactor = length
    glyph.GlyphMode = "All Points"
    in_one_colour(Show(glyph, view), colour, 1.0)
    Hide(glyph, view)


def show_bake(path, view):
    baked = OpenDataFile(path)
    RenameSource("baked", baked)
    baked.UpdatePipeline()
    Hide(baked, view)
    distance = spacing(baked)
    lit = baked.PointData.GetArray("colour") is not None
    tetrahedra = baked.CellData.GetArray("min_dihedral") is not None
    flat = any(baked.CellData.GetArray(name) is not None
               for name in ("min_angle", "length"))  # triangles, segments

    probes = Glyph(Input=baked, GlyphType="Sphere")
    RenameSource("probes", probes)
    probes.ScaleArray = ["POINTS", "No scale array"]
    probes.ScaleFactor = 0.3 * distance
    probes.GlyphMode = "All Points"
    shown = Show(probes, view)
    if lit:
        in_own_colour(shown, "POINTS")
        arrows("towards the light", baked, "brightest", 0.6 * distance, [1.0, 0.85, 0.4], view)
    if not tetrahedra and not flat:
        return
    edges = ExtractEdges(Input=baked)
    RenameSource("edges", edges)
    in_one_colour(Show(edges, view), [0.7, 0.8, 1.0], 0.25)
    if lit:
        arrows("gradient of luminance", baked, "luminance_gradient", 0.6 * distance,
               [0.4, 0.9, 0.6], view)
    if lit and tetrahedra:
        level = Slice(Input=baked)
        RenameSource("slice", level)
        level.SliceType.Normal = [0, 1, 0]
        in_own_colour(Show(level, view), "POINTS")
        Hide(level, view)
    leaking = baked.CellData.GetArray("leaking_edges")
    if leaking is not None and leaking.GetRange()[1] > 0:
        leaks = Threshold(Input=baked)
        RenameSource("cells that leak", leaks)
        leaks.Scalars = ["CELLS", "leaking_edges"]
        leaks.LowerThreshold, leaks.UpperThreshold = 1, 6
        outline = ExtractEdges(Input=leaks)
        RenameSource("edges of cells that leak", outline)
        Hide(leaks, view)
        in_one_colour(Show(outline, view), [1.0, 0.28, 0.15], 0.5)


def main():
    names = [name for name in sys.argv[1:] if not name.startswith("-")]
    outputs = [name for name in names if name.endswith((".png", ".pvsm"))]
    names = [name for name in names if name not in outputs]
    baked = names[0] if names else os.environ.get("BAKED", os.path.join("out", "baked.vtu"))
    if not os.path.isfile(baked):
        sys.exit(f"paraview-open: {baked}: no such file: give it as an argument, or in the"
                 " environment as BAKED")
    scenes = [os.environ.get("SCENE", ""), os.path.splitext(baked)[0] + ".scene.vtp",
              os.path.join(os.path.dirname(baked), "scene.vtp")]
    found = names[1:2] or [name for name in scenes if os.path.isfile(name)]

    view = GetActiveViewOrCreate("RenderView")
    if found:
        show_scene(found[0], view)
    show_bake(baked, view)
    ResetCamera(view)
    camera = view.GetActiveCamera()
    camera.Azimuth(25)
    camera.Elevation(20)
    ResetCamera(view)
    Render(view)
    for name in outputs:
        if name.endswith(".png"):
            SaveScreenshot(name, view, ImageResolution=[1280, 800])
        else:
            SaveState(name)


main()
