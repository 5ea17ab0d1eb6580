# SPDX-License-Identifier: Apache-2.0
# light of probes as a weighted sum of parts: for probe-relight
relight_sources = \
	%D%/compress.c %D%/compress.h \
	%D%/compressed.c %D%/compressed.h \
	%D%/lamp_blend.c %D%/lamp_blend.h \
	%D%/other_light.c %D%/other_light.h \
	%D%/pca.c %D%/pca.h \
	%D%/radiosity.c %D%/radiosity.h \
	%D%/relight.c %D%/relight.h \
	%D%/relight_senders.c %D%/relight_senders.h \
	%D%/relight_stream.c %D%/relight_stream.h \
	%D%/sky_bands.c %D%/sky_bands.h \
	%D%/sun_blend.c %D%/sun_blend.h \
	%D%/weights.c %D%/weights.h
