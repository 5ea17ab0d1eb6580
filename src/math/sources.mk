# vectors, angles, powers, random numbers, cells, cubes of space: the same bits on every machine
math_sources = \
	%D%/angle.c %D%/angle.h \
	%D%/cell.c %D%/cell.h \
	%D%/cubes.c %D%/cubes.h \
	%D%/power.c %D%/power.h \
	%D%/random.c %D%/random.h \
	%D%/vec.h
