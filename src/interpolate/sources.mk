# SPDX-License-Identifier: Apache-2.0
# light between probes: the kinds of interpolation, the baked stream, the engine of probe-query
interpolate_sources = \
	%D%/baked.c %D%/baked.h \
	%D%/bound.c %D%/bound.h \
	%D%/cells_volume.c %D%/cells_volume.h \
	%D%/discs.c %D%/discs.h \
	%D%/interpolate.c %D%/interpolate.h \
	%D%/interpolate_along.c \
	%D%/interpolate_cells.c \
	%D%/interpolate_discs.c \
	%D%/interpolate_kind.h \
	%D%/interpolate_nodes.c \
	%D%/interpolate_options.c %D%/interpolate_options.h \
	%D%/interpolate_pack.c \
	%D%/interpolate_scattered.c \
	%D%/nodes.c %D%/nodes.h \
	%D%/occluders.c %D%/occluders.h \
	%D%/octree.c %D%/octree.h \
	%D%/query.c %D%/query.h \
	%D%/scatter.c %D%/scatter.h
