# SPDX-License-Identifier: Apache-2.0
# probes where they lower the error, by light
adapt_sources = \
	%D%/adapt.c %D%/adapt.h \
	%D%/adapt_place.c \
	%D%/candidates.c %D%/candidates.h \
	%D%/cavity.c %D%/cavity.h \
	%D%/choice.c %D%/choice.h \
	%D%/cloud.c %D%/cloud.h \
	%D%/contrast.c %D%/contrast.h \
	%D%/gains.c %D%/gains.h \
	%D%/insert.c %D%/insert.h \
	%D%/mean_error.c %D%/mean_error.h \
	%D%/move.c %D%/move.h \
	%D%/place_ascent.c \
	%D%/place_light.c %D%/place_light.h \
	%D%/place_methods.c \
	%D%/place_octree.c \
	%D%/place_spawn_merge.c \
	%D%/place_unlit.c \
	%D%/quick_square.c %D%/quick_square.h \
	%D%/rank.h \
	%D%/seen.c %D%/seen.h \
	%D%/thin_out.c %D%/thin_out.h \
	%D%/unlit.c %D%/unlit.h \
	%D%/voxels.c %D%/voxels.h
