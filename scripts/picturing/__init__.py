"""What scripts/picture is made of: data (what probe-vtk wrote), camera, drawing."""
