# SPDX-License-Identifier: Apache-2.0
# camera, light of a picture, overlay, films
render_sources = \
	%D%/camera.c %D%/camera.h \
	%D%/film.c %D%/film.h \
	%D%/object.c %D%/object.h \
	%D%/overlay.c %D%/overlay.h \
	%D%/render.c %D%/render.h \
	%D%/render_options.c %D%/render_options.h \
	%D%/scene_film.c %D%/scene_film.h \
	%D%/shot.c %D%/shot.h \
	%D%/view.c %D%/view.h
