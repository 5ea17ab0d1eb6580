# SPDX-License-Identifier: Apache-2.0
# errors, arrays, warnings, threads, what is made once, signals, progress, clock, numbers as text,
# options, bytes of files, which are read and which written, where other programs are, main memory
base_sources = \
	%D%/array.c %D%/array.h \
	%D%/claim.c %D%/claim.h \
	%D%/clock.c %D%/clock.h \
	%D%/error.c %D%/error.h \
	%D%/error_guard.h \
	%D%/file.c %D%/file.h \
	%D%/interrupt.c %D%/interrupt.h \
	%D%/memory.c %D%/memory.h \
	%D%/number.cc %D%/number.h \
	%D%/once.c %D%/once.h \
	%D%/options.c %D%/options.h \
	%D%/progress.c %D%/progress.h \
	%D%/sibling.c %D%/sibling.h \
	%D%/threads.c %D%/threads.h \
	%D%/warning.c %D%/warning.h
