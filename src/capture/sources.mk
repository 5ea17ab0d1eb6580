# SPDX-License-Identifier: Apache-2.0
# the light that reaches a probe
capture_sources = \
	%D%/ask_lit.c %D%/ask_lit.h \
	%D%/cache_gather.c %D%/cache_gather.h \
	%D%/cache_options.c %D%/cache_options.h \
	%D%/cache_points.c %D%/cache_points.h \
	%D%/cache_spots.c %D%/cache_spots.h \
	%D%/capture.c %D%/capture.h \
	%D%/capture_auto.c \
	%D%/capture_cache.c %D%/capture_cache.h \
	%D%/capture_black.c %D%/capture_black.h \
	%D%/capture_links.c %D%/capture_links.h \
	%D%/capture_options.c %D%/capture_options.h \
	%D%/capture_probe.c \
	%D%/capture_scene.c \
	%D%/capture_senders.c %D%/capture_senders.h \
	%D%/capture_split.c %D%/capture_split.h \
	%D%/capture_stream.c %D%/capture_stream.h \
	%D%/probe_split.c %D%/probe_split.h \
	%D%/sender_tree.c %D%/sender_tree.h \
	%D%/senders.c %D%/senders.h \
	%D%/gradient.c %D%/gradient.h \
	%D%/guide.c %D%/guide.h \
	%D%/occlusion.c %D%/occlusion.h \
	%D%/openings.c %D%/openings.h \
	%D%/stage.c %D%/stage.h \
	%D%/strata.c %D%/strata.h
