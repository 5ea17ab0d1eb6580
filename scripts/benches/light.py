# SPDX-License-Identifier: Apache-2.0
"""The light of a capture, and how far it is from the truth."""
from .inputs import text_rows

COSINE = (3.14159265358979, 2.0943951023932, 0.785398163397448)  # A_l


def captured_light(path):
    """Of each probe: A_l L_lm in luminance, and the rays spent, from a stream of order 3 with
    column rays."""
    rows = [row[3:] for row in text_rows(path, "position,sh,rays")]
    light = []
    for row in rows:
        luminance = [0.2126 * row[3 * i] + 0.7152 * row[3 * i + 1] + 0.0722 * row[3 * i + 2]
                     for i in range(9)]
        light.append([COSINE[int(i ** 0.5)] * luminance[i] for i in range(9)])
    return light, [row[27] for row in rows]


def floor_of(truth):
    """A quarter of the mean over all probes: what is darker counts as that bright."""
    return sum(t[0] for t in truth) / len(truth) / 4


def relative_errors(light, truth):
    """Of each probe, sorted: RMS over directions of what irradiance is off, against the greater of
    its mean and a quarter of all probes'."""
    floor = floor_of(truth)
    return sorted(sum((a - b) ** 2 for a, b in zip(x, t)) ** 0.5 / max(t[0], floor)
                  for x, t in zip(light, truth))


def rms(errors):
    return (sum(e * e for e in errors) / len(errors)) ** 0.5


def percentile(errors, share):
    """Of sorted errors."""
    return errors[int(share * len(errors))]
