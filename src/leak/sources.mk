# SPDX-License-Identifier: Apache-2.0
# edges through walls, and their mending
leak_sources = \
	%D%/cells_make.c %D%/cells_make.h \
	%D%/leak.c %D%/leak.h \
	%D%/leak_mend.c %D%/leak_mend.h
