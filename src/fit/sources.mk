# SPDX-License-Identifier: Apache-2.0
# values of probes by least squares: for probe-fit
fit_sources = \
	%D%/fit_stream.c %D%/fit_stream.h \
	%D%/fit_surface.c %D%/fit_surface.h \
	%D%/least_squares.c %D%/least_squares.h
