# closed pieces, joined vertices, decimation: hides OpenMesh
topology_sources = \
	%D%/decimate.cc \
	%D%/solids.cc \
	%D%/surface.cc %D%/surface.h
