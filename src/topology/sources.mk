# SPDX-License-Identifier: Apache-2.0
# closed pieces, joined vertices, decimation: hides OpenMesh
topology_sources = \
	%D%/decimate.cc %D%/decimate.h \
	%D%/orient.cc \
	%D%/solids.cc %D%/solids.h \
	%D%/surface.cc %D%/surface.h
