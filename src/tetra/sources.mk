# SPDX-License-Identifier: Apache-2.0
# cells: hides TetGen, which is AGPL-3, so that probe-tet alone links this folder
tetra_sources = \
	%D%/enclose.c %D%/enclose.h \
	%D%/peel.c %D%/peel.h \
	%D%/sites.c %D%/sites.h \
	%D%/stretch.c %D%/stretch.h \
	%D%/tetra.c %D%/tetra.h \
	%D%/tetra_cells.h \
	%D%/tetra_check.c \
	%D%/tetra_measure.c \
	%D%/tetra_report.c \
	%D%/tetra_run.c \
	%D%/tetra_stream.c %D%/tetra_stream.h \
	%D%/tetra_tetgen.cc \
	%D%/thin.c %D%/thin.h
