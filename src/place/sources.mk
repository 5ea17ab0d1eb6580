# SPDX-License-Identifier: Apache-2.0
# where probes go: a file a method, and what is inside solids
place_sources = \
	%D%/exposed.c %D%/exposed.h \
	%D%/patches.c %D%/patches.h \
	%D%/place.c %D%/place.h \
	%D%/place_faces.c \
	%D%/place_grid.c %D%/place_grid.h \
	%D%/place_ground.c %D%/place_ground.h \
	%D%/place_inside.c %D%/place_inside.h \
	%D%/place_lights.c \
	%D%/place_look.c %D%/place_look.h \
	%D%/place_pieces.c %D%/place_pieces.h \
	%D%/place_method.c %D%/place_method.h \
	%D%/place_path.c \
	%D%/place_points.c \
	%D%/place_poisson.c \
	%D%/place_reach.c \
	%D%/place_samples.c \
	%D%/place_vertices.c \
	%D%/point_grid.c %D%/point_grid.h \
	%D%/poisson.c %D%/poisson.h \
	%D%/reach.c %D%/reach.h \
	%D%/space.c %D%/space.h \
	%D%/up.c %D%/up.h \
	%D%/vertices.c %D%/vertices.h
