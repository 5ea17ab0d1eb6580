# where probes go
place_sources = \
	%D%/place.c %D%/place.h \
	%D%/vertices.c %D%/vertices.h
