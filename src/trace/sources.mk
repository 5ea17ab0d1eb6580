# SPDX-License-Identifier: Apache-2.0
# rays, the light tree, the sky, particles, paths: hides Embree
trace_sources = \
	%D%/cache.c %D%/cache.h \
	%D%/emission.c %D%/emission.h \
	%D%/enter.c %D%/enter.h \
	%D%/frames.c %D%/frames.h \
	%D%/lights.c %D%/lights.h \
	%D%/particles.c %D%/particles.h \
	%D%/lit.c %D%/lit.h \
	%D%/parts.c %D%/parts.h \
	%D%/path.c %D%/path.h \
	%D%/seen.c %D%/seen.h \
	%D%/sky.c %D%/sky.h \
	%D%/split.c %D%/split.h \
	%D%/trace.c %D%/trace.h \
	%D%/trace_local.h
