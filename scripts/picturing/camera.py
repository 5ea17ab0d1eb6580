# SPDX-License-Identifier: Apache-2.0
"""Where to look from: the view that shows most of the probes and of the scene."""
import numpy as np

from .data import unit

VIEW_ANGLE = 30.0  # of the camera, degrees, from top to bottom


def fit(corners, direction, up, options):
    """Where a camera that looks along -direction stands, and at what, so that all corners are seen,
    and large."""
    back = unit(direction)
    right = unit(np.cross(up, back))
    top = np.cross(back, right)
    tangent = np.tan(np.radians(VIEW_ANGLE / 2)) * 0.98  # a margin
    aspect = options.size[0] / options.size[1]
    target = (corners.min(axis=0) + corners.max(axis=0)) / 2
    for _ in range(8):
        x, y, z = (corners - target) @ right, (corners - target) @ top, (corners - target) @ back
        distance = max((np.abs(x) / (aspect * tangent) + z).max(), (np.abs(y) / tangent + z).max())
        # Aim between the outermost corners as they are seen.
        u, v = x / (distance - z), y / (distance - z)
        target = target + distance / 2 * ((u.min() + u.max()) * right + (v.min() + v.max()) * top)
    return target + distance * back, target


def views_of(corners, options):
    """Penalty, eye and target of the views to choose from."""
    up = unit(options.up)
    flat = np.ptp(corners, axis=0) * (1 - np.abs(up))
    along = unit(np.eye(3)[flat.argmax()] - up * up[flat.argmax()])
    front = np.cross(along, up)
    if options.camera is not None:
        return [(0, options.camera[:3], options.camera[3:])]
    if options.what == "slice":
        return [(0, *fit(corners, 0.55 * front + up, up, options))]
    views = []
    # From above at an angle, or nearly straight; rather at the long side.
    for height, aside, sides, penalty in ((32, 28, (0, 180), 0), (32, 28, (90, 270), 0.1),
                                          (10, 10, (0, 180), 0.35), (10, 10, (90, 270), 0.45)):
        for turn in (side + sign * aside for side in sides for sign in (1, -1)):
            h, t = np.radians(height), np.radians(turn)
            direction = np.cos(h) * (np.cos(t) * front + np.sin(t) * along) + np.sin(h) * up
            views.append((penalty, *fit(corners, direction, up, options)))
    return views


def choose_view(baked, scene, corners, options):
    """Eye, target and openness: of some views the one that shows most of the probes and of the
    scene."""
    views = views_of(corners, options)
    if scene is None or options.what == "slice":
        return views[0][1], views[0][2], 0
    sample = baked.points[::max(1, len(baked.points) // 40)]
    best = None
    for penalty, eye, target in views:
        between = scene.in_front_of(eye, sample)
        lost = 1 - scene.area[scene.shown(eye, 0)].sum() / scene.area.sum()
        for openness in (0, 1, 2):
            shown = scene.shown(eye, openness)
            hidden = np.mean([shown[ids].any() for ids in between])
            score = penalty + hidden + 1.5 * lost + 0.2 * openness
            if best is None or score < best[0] - 1e-9:
                best = score, eye, target, openness
    _, eye, target, openness = best
    if openness == 2 and options.camera is None:  # what is left is nearer the middle
        origin, normal = scene.cut(eye)
        left = corners - np.maximum((corners - origin) @ normal, 0)[:, None] * normal
        eye, target = fit(left, eye - target, unit(options.up), options)
    return eye, target, openness


def box_corners(baked, scene, up, sliced):
    """Of everything; where it is sliced, of what is below."""
    low, high = baked.points.min(axis=0), baked.points.max(axis=0)
    if scene is not None:
        low, high = np.minimum(low, scene.low), np.maximum(high, scene.high)
    if sliced:
        high = high - up * ((high - baked.middle) @ up)
    # room for the spheres, and around a single one
    margin = 0.02 * np.linalg.norm(high - low) or 1.0
    low, high = low - margin, high + margin
    return np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)])
