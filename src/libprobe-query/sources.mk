# SPDX-License-Identifier: Apache-2.0
# all that a game links: volume, walk, outside of the hull, blend, packed file, discs, lattice, SH.
# Nothing but libc and libm
libprobe_query_sources = \
	%D%/discs.c %D%/discs.h \
	%D%/half.h \
	%D%/lattice.c %D%/lattice.h \
	%D%/sh.c %D%/sh.h \
	%D%/sight.h \
	%D%/span.c %D%/span.h \
	%D%/surface.c \
	%D%/volume.c %D%/volume.h \
	%D%/volume_blend.c \
	%D%/volume_image.c \
	%D%/volume_make.c \
	%D%/volume_outer.c \
	%D%/volume_sight.c \
	%D%/volume_tetra.c \
	%D%/volume_tree.c %D%/volume_tree.h \
	%D%/volume_walk.c
