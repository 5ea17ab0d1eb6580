# SPDX-License-Identifier: Apache-2.0
# edges through walls, and their mending
leak_sources = \
	%D%/aim.c %D%/aim.h \
	%D%/cells_make.c %D%/cells_make.h \
	%D%/dilate.c %D%/dilate.h \
	%D%/leak.c %D%/leak.h \
	%D%/leak_mend.c %D%/leak_mend.h \
	%D%/leak_need.c %D%/leak_need.h \
	%D%/outside.c %D%/outside.h \
	%D%/shadow.c %D%/shadow.h \
	%D%/sight.c %D%/sight.h \
	%D%/sight_fit.c %D%/sight_fit.h \
	%D%/stand_in.c %D%/stand_in.h \
	%D%/stars.c %D%/stars.h
