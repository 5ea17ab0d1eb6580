# SPDX-License-Identifier: Apache-2.0
# pictures: decoding, display, colour maps, differences, text on them
image_sources = \
	%D%/annotate.c %D%/annotate.h \
	%D%/cielab.c %D%/cielab.h \
	%D%/colour_map.c %D%/colour_map.h \
	%D%/compare.c %D%/compare.h \
	%D%/display.c %D%/display.h \
	%D%/flip.c %D%/flip.h \
	%D%/image.c %D%/image.h \
	%D%/image_formats.h %D%/image_exr.c %D%/image_hdr.c \
	%D%/picture.c %D%/picture.h
