# edges through walls, and their mending
leak_sources = \
	%D%/leak.c %D%/leak.h
