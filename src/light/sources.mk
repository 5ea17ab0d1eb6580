# SPDX-License-Identifier: Apache-2.0
# what a stream's light is and becomes: content, order, de-ringing, other bases, turned
light_sources = \
	%D%/basis.c %D%/basis.h \
	%D%/blend.c %D%/blend.h \
	%D%/content.c %D%/content.h \
	%D%/convert.c %D%/convert.h \
	%D%/dering.c %D%/dering.h \
	%D%/light_options.c %D%/light_options.h \
	%D%/order.c %D%/order.h \
	%D%/product.c %D%/product.h \
	%D%/rotate.c %D%/rotate.h \
	%D%/visibility.c %D%/visibility.h
