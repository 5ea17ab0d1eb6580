"""Opens a bake in ParaView, ready to look at: the scene's surface, the probes in their colour, the tetrahedra as edges.

    paraview --script=scripts/paraview-open.py            # out/baked.vtu and out/scene.vtp, as scripts/demo leaves them
    pvpython scripts/paraview-open.py BAKED.vtu [SCENE.vtp]
"""
import os
import sys

from paraview.simple import (ColorBy, ExtractEdges, Glyph, Hide, OpenDataFile, Render, ResetCamera, Show, Threshold,
                             GetActiveViewOrCreate)

names = [name for name in sys.argv[1:] if not name.startswith("-")]
baked_name = names[0] if names else os.path.join("out", "baked.vtu")
scene_name = names[1] if len(names) > 1 else os.path.join(os.path.dirname(baked_name), "scene.vtp")
view = GetActiveViewOrCreate("RenderView")
baked = OpenDataFile(baked_name)
baked.UpdatePipeline()
Hide(baked, view)

if os.path.exists(scene_name):
    scene = Show(OpenDataFile(scene_name), view)
    ColorBy(scene, ("CELLS", "colour"))
    scene.MapScalars = 0
    scene.BackfaceRepresentation = "Surface"
    scene.Opacity = 0.3

bounds = baked.GetDataInformation().GetBounds()
side = max(bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4])
count = max(baked.GetDataInformation().GetNumberOfPoints(), 1)
glyph = Glyph(Input=baked, GlyphType="Sphere")
glyph.ScaleFactor = 0.3 * side / count ** (1 / 3)
glyph.GlyphMode = "All Points"
probes = Show(glyph, view)
if baked.PointData.GetArray("colour"):
    ColorBy(probes, ("POINTS", "colour"))
    probes.MapScalars = 0

edges = Show(ExtractEdges(Input=baked), view)
edges.AmbientColor = edges.DiffuseColor = [0.6, 0.7, 0.9]
edges.Opacity = 0.15

if baked.CellData.GetArray("crossed_edges"):
    crossed = Threshold(Input=baked)
    crossed.Scalars = ["CELLS", "crossed_edges"]
    crossed.LowerThreshold = 1
    crossed.ThresholdMethod = "Above Lower Threshold"
    Hide(crossed, view)  # cells that a wall passes through: click the eye to see them

ResetCamera()
Render()
