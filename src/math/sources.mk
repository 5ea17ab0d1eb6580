# SPDX-License-Identifier: Apache-2.0
# vectors, affine maps, boxes, directions, luminance, angles, powers, hashes, random numbers,
# even points, a rule of integration, eigenvectors, sorting, cells, sums of
# shares, cubes of space, places on a lattice: the same bits on every machine
math_sources = \
	%D%/affine.h \
	%D%/angle.c %D%/angle.h \
	%D%/box.h \
	%D%/cell.c %D%/cell.h \
	%D%/convex.c %D%/convex.h \
	%D%/cubes.c %D%/cubes.h \
	%D%/direction.h \
	%D%/eigen.c %D%/eigen.h \
	%D%/hash.c %D%/hash.h \
	%D%/luminance.h \
	%D%/places.c %D%/places.h \
	%D%/power.c %D%/power.h \
	%D%/random.c %D%/random.h \
	%D%/sobol.h \
	%D%/sort.c %D%/sort.h \
	%D%/sphere_rule.c %D%/sphere_rule.h \
	%D%/vec.h
