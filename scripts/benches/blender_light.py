# SPDX-License-Identifier: Apache-2.0
"""Light at points by Cycles: runs in Blender, for the cycles part (cycles.py).

blender -b --factory-startup -P blender_light.py -- JOB.json RESULT.json

JOB: scene, points (x y z each), sky (r g b), suns (direction that light goes, r g b), threads,
size of pictures, runs (samples and a seed each). RESULT: load_s of the scene, empty_s of a picture
next to none, and of each run, each point: seconds of CPU and 27 coefficients of irradiance.

The cheapest way to all directions that Cycles has: a mirror ball's picture, which gives each pixel
in a disc the same solid angle (an equirectangular one wastes a fifth of its rays at the poles), of
few pixels with many samples each, which spread better than few samples of many. Of 32 by 32 pixels
light is within .4 % of what it is of more; 16 by 16 are as good, but 1 % off, 64 by 64 take half as
long again to the same error.
"""
import json
import os
import resource
import sys

import bpy
import numpy as np


def cpu_seconds():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def load(path):
    """Imports a scene; returns the matrix from its axes to Blender's."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if path.endswith(".obj"):
        bpy.ops.wm.obj_import(filepath=path, forward_axis="Y", up_axis="Z")
        return np.eye(3)
    np.bool = bool  # the importer of Blender 3.4 asks for what NumPy 1.24 has no longer
    bpy.ops.import_scene.gltf(filepath=path)
    return np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)


def feed(tree, source, target):
    """Gives a socket what another one has: its link or its value."""
    if source.is_linked:
        tree.links.new(source.links[0].from_socket, target)
    else:
        target.default_value = source.default_value


def make_diffuse(material):
    """Reflects as probe-capture has it, by the cosine alone, emits and lets through as before."""
    tree = material.node_tree
    old = next((n for n in tree.nodes if n.type == "BSDF_PRINCIPLED"), None)
    out = next((n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"), None)
    if not old or not out:
        return
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    feed(tree, old.inputs["Base Color"], diffuse.inputs["Color"])
    shader = diffuse.outputs[0]
    glow = old.inputs["Emission"]
    if glow.is_linked or max(glow.default_value[:3]) > 0:
        emission = tree.nodes.new("ShaderNodeEmission")
        feed(tree, glow, emission.inputs["Color"])
        feed(tree, old.inputs["Emission Strength"], emission.inputs["Strength"])
        both = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(shader, both.inputs[0])
        tree.links.new(emission.outputs[0], both.inputs[1])
        shader = both.outputs[0]
    alpha = old.inputs["Alpha"]
    if alpha.is_linked or alpha.default_value < 1:
        opaque = tree.nodes.new("ShaderNodeMath")
        opaque.operation = "GREATER_THAN" if material.blend_method == "CLIP" else "ADD"
        feed(tree, alpha, opaque.inputs[0])
        opaque.inputs[1].default_value = (material.alpha_threshold
                                          if material.blend_method == "CLIP" else 0)
        mix = tree.nodes.new("ShaderNodeMixShader")
        clear = tree.nodes.new("ShaderNodeBsdfTransparent")
        tree.links.new(opaque.outputs[0], mix.inputs[0])
        tree.links.new(clear.outputs[0], mix.inputs[1])
        tree.links.new(shader, mix.inputs[2])
        shader = mix.outputs[0]
    tree.links.new(shader, out.inputs["Surface"])


def set_world(scene, colour):
    world = bpy.data.worlds.new("light")
    scene.world = world
    world.use_nodes = True
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (*colour, 1)
    return world.node_tree, background


def add_sun(scene, axes, sun):
    from mathutils import Vector
    lamp = bpy.data.lights.new("sun", "SUN")
    lamp.energy = max(sun[3:]) or 1
    lamp.color = [c / lamp.energy for c in sun[3:]]
    lamp.angle = 0
    lamp.cycles.max_bounces = 1024
    thing = bpy.data.objects.new("sun", lamp)
    thing.rotation_mode = "QUATERNION"
    thing.rotation_quaternion = Vector(axes @ np.array(sun[:3])).to_track_quat("-Z", "Y")
    scene.collection.objects.link(thing)


def set_up(scene, job):
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    cycles.device = "CPU"
    render.threads_mode, render.threads = "FIXED", job["threads"]
    render.use_persistent_data = True
    render.resolution_x = render.resolution_y = job["size"]
    render.resolution_percentage = 100
    render.film_transparent = False
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode = "RGB"
    render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    cycles.pixel_filter_type = "BOX"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.max_bounces = cycles.diffuse_bounces = 64
    cycles.transparent_max_bounces = 64
    cycles.light_sampling_threshold = 0
    camera = bpy.data.cameras.new("probe")
    camera.type = "PANO"
    camera.cycles.panorama_type = "MIRRORBALL"
    camera.clip_start = 1e-6
    thing = bpy.data.objects.new("probe", camera)
    scene.collection.objects.link(thing)
    scene.camera = thing
    return thing


class Pictures:
    def __init__(self, scene, file):
        self.scene, self.file = scene, file

    def render(self, samples, seed):
        """A picture, pixels by 3, and the seconds of CPU that it took."""
        self.scene.cycles.samples, self.scene.cycles.seed = samples, seed
        start = cpu_seconds()
        bpy.ops.render.render()
        seconds = cpu_seconds() - start
        bpy.data.images["Render Result"].save_render(self.file, scene=self.scene)
        image = bpy.data.images.load(self.file)
        image.colorspace_settings.name = "Raw"
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
        return pixels.reshape(-1, 4)[:, :3].astype(float), seconds


def directions(scene, pictures):
    """The mean direction of each pixel, and the share of it that has any: what worlds show that
    are coloured by them."""
    tree, background = set_world(scene, (1, 1, 1))
    share = pictures.render(64, 1)[0][:, 0]
    at = tree.nodes.new("ShaderNodeTexCoord")
    apart = tree.nodes.new("ShaderNodeVectorMath")
    apart.operation = "ADD"
    apart.inputs[1].default_value = (2, 2, 2)  # colours are not negative
    tree.links.new(at.outputs["Generated"], apart.inputs[0])
    tree.links.new(apart.outputs[0], background.inputs["Color"])
    seen = pictures.render(64, 1)[0] - 2 * share[:, None]
    length = np.linalg.norm(seen, axis=1, keepdims=True)
    return seen / np.maximum(length, 1e-9), share


def cosine_basis(direction):
    """Of directions, in the scene's axes, the 9 coefficients of the irradiance that unit light
    from there makes."""
    x, y, z = direction.T
    basis = [0.282095 + 0 * x, 0.488603 * y, 0.488603 * z, 0.488603 * x, 1.092548 * x * y,
             1.092548 * y * z, 0.315392 * (3 * z * z - 1), 1.092548 * x * z,
             0.546274 * (x * x - y * y)]
    cosine = np.pi * np.array([1] + 3 * [2 / 3] + 5 * [1 / 4])
    return cosine[:, None] * np.array(basis)


def to_irradiance(axes, seen, share):
    """The matrix from pixels to 9 coefficients of irradiance."""
    return cosine_basis(seen @ axes) * 4 * np.pi / share.sum()


def sun_seen(scene, axes, point, suns):
    """Coefficients of irradiance of the suns that a point sees: a probe of probe-capture has them,
    a camera does not see them."""
    from mathutils import Vector
    light = np.zeros((9, 3))
    for sun in suns:
        towards = -np.array(sun[:3]) / np.linalg.norm(sun[:3])
        if not scene.ray_cast(bpy.context.evaluated_depsgraph_get(), Vector(axes @ point),
                              Vector(axes @ towards))[0]:
            light += np.outer(cosine_basis(towards[None, :]), sun[3:])
    return light


def main():
    job_file, result_file = sys.argv[sys.argv.index("--") + 1:]
    with open(job_file) as f:
        job = json.load(f)
    start = cpu_seconds()
    axes = load(job["scene"])
    scene = bpy.context.scene
    things = [o for o in scene.objects if o.type == "MESH"]
    for thing in [o for o in scene.objects if o.type in ("LIGHT", "CAMERA")]:
        bpy.data.objects.remove(thing)
    for material in bpy.data.materials:
        if material.node_tree:
            make_diffuse(material)
    camera = set_up(scene, job)
    pictures = Pictures(scene, result_file + ".exr")
    for thing in things:
        thing.hide_render = True
    matrix = to_irradiance(axes, *directions(scene, pictures))
    for thing in things:
        thing.hide_render = False
    set_world(scene, job["sky"])
    for sun in job["suns"]:
        add_sun(scene, axes, sun)
    pictures.render(1, 0)
    result = {"load_s": cpu_seconds() - start, "runs": []}
    render = scene.render
    render.resolution_x = render.resolution_y = 2
    empty = sorted(pictures.render(1, i)[1] for i in range(5))
    result["empty_s"] = empty[2]
    render.resolution_x = render.resolution_y = job["size"]
    pictures.render(1, 0)
    straight = [sun_seen(scene, axes, np.array(p), job["suns"]) for p in job["points"]]
    for samples, seed in job["runs"]:
        points = []
        for point, sun in zip(job["points"], straight):
            camera.location = axes @ np.array(point)
            pixels, seconds = pictures.render(samples, seed)
            points.append({"s": seconds, "light": (matrix @ pixels + sun).ravel().tolist()})
        result["runs"].append({"samples": samples, "seed": seed, "points": points})
    with open(result_file, "w") as f:
        json.dump(result, f)
    os.remove(result_file + ".exr")


main()
