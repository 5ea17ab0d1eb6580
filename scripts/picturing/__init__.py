# SPDX-License-Identifier: Apache-2.0
"""What scripts/picture is made of: data (what probe-vtk wrote), camera, drawing."""
