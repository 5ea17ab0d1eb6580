# SPDX-License-Identifier: Apache-2.0
# files for ParaView: hides VTK, so that probe-vtk alone links this folder
vtk_sources = \
	%D%/vtk_derive.c %D%/vtk_derive.h \
	%D%/vtk_export.cc %D%/vtk_export.h \
	%D%/vtk_fields.c %D%/vtk_fields.h \
	%D%/vtk_probes.c %D%/vtk_probes.h \
	%D%/vtk_scene.c %D%/vtk_scene.h
