# SPDX-License-Identifier: Apache-2.0
# surfaces with baked colours as files of others: for probe-export
export_sources = \
	%D%/export_glb.c \
	%D%/export_mesh.c %D%/export_mesh.h \
	%D%/export_ply.c
