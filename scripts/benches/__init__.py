# SPDX-License-Identifier: Apache-2.0
"""The parts of scripts/bench: one module each, whose first lines --help shows and whose function
bench(options) measures and prints. A new part is a file here and its name below.

What parts share: running (commands, bench programs, tables), inputs (scenes, probes, streams),
light (of a capture, and how far it is from the truth), octree, peers; and blender_light, which
Blender runs.
"""
PARTS = ("stream", "threads", "rays", "error", "render", "columns", "bases", "measure", "tet",
         "decimate", "query", "interpolate", "discs", "unasked", "visibility", "scene", "sight",
         "place", "cache", "cycles", "occlusion")
# not run unless they are named
ON_REQUEST = ("bases", "decimate", "query", "interpolate", "discs", "unasked", "visibility",
              "scene", "place", "cache", "cycles", "occlusion")
