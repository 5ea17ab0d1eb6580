# SPDX-License-Identifier: Apache-2.0
# a whole bake: the pipe as it is run, what a quality means, the report
bake_sources = \
	%D%/facts.c %D%/facts.h \
	%D%/figures.c %D%/figures.h \
	%D%/page.c %D%/page.h \
	%D%/pipe.c %D%/pipe.h \
	%D%/paths.c %D%/paths.h \
	%D%/plan.c %D%/plan.h \
	%D%/run.c %D%/run.h \
	%D%/words.c %D%/words.h
