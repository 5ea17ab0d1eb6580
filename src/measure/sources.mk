# SPDX-License-Identifier: Apache-2.0
# truth, error, leaks, report
measure_sources = \
	%D%/assess.c %D%/assess.h \
	%D%/bootstrap.c %D%/bootstrap.h \
	%D%/measure.c %D%/measure.h \
	%D%/narrow.c %D%/narrow.h \
	%D%/ratio.c %D%/ratio.h \
	%D%/report.c %D%/report.h \
	%D%/ruler.c %D%/ruler.h \
	%D%/sphere.c %D%/sphere.h \
	%D%/truth.c %D%/truth.h \
	%D%/unseen.c %D%/unseen.h \
	%D%/unseen_outside.c %D%/unseen_outside.h
