# SPDX-License-Identifier: Apache-2.0
# a scene file to a scene: hides tinyobjloader and tinygltf
import_sources = \
	%D%/import.c %D%/import.h \
	%D%/import_colour.c \
	%D%/import_faces.c \
	%D%/import_files.c \
	%D%/import_gltf.cc %D%/import_gltf.h \
	%D%/import_gltf_file.cc \
	%D%/import_obj.cc \
	%D%/import_off.c \
	%D%/import_ply.c \
	%D%/import_scene.h \
	%D%/import_stl.c \
	%D%/polygon.c %D%/polygon.h
