# SPDX-License-Identifier: Apache-2.0
# triangles, materials, lights, groups of them, sky, settings, shading
scene_sources = \
	%D%/groups.c %D%/groups.h \
	%D%/relit.c %D%/relit.h \
	%D%/scene.c %D%/scene.h \
	%D%/scene_build.c %D%/scene_build.h \
	%D%/scene_choice.c %D%/scene_choice.h \
	%D%/scene_finish.c \
	%D%/scene_hints.c %D%/scene_hints.h \
	%D%/scene_settings.c %D%/scene_settings.h \
	%D%/scene_shade.c %D%/scene_shade.h \
	%D%/scene_sky.c %D%/scene_sky.h \
	%D%/scene_told.c %D%/scene_told.h
