# SPDX-License-Identifier: Apache-2.0
# A C program a module (tests/NAME.c on support/tap.h), a shell script a program (tests/NAME.t on
# support/setup.sh). A test that is named here compiles tests/NAME.c and links what sees the scene,
# unless a line below says otherwise.

MODULE_TESTS = \
	tests/base \
	tests/math \
	tests/number \
	tests/sh \
	tests/stream \
	tests/stream_salvage \
	tests/stream_fill \
	tests/stream_edit \
	tests/points \
	tests/content \
	tests/contrast \
	tests/dering \
	tests/basis \
	tests/product \
	tests/rotate \
	tests/query \
	tests/scatter \
	tests/discs \
	tests/senders \
	tests/interpolate \
	tests/octree \
	tests/library \
	tests/image \
	tests/image_exr \
	tests/picture \
	tests/polygon \
	tests/scene \
	tests/groups \
	tests/scene_obj \
	tests/scene_gltf \
	tests/scene_files \
	tests/scenes \
	tests/decimate \
	tests/sky \
	tests/enter \
	tests/particles \
	tests/patches \
	tests/surface \
	tests/poisson \
	tests/path \
	tests/cache \
	tests/openings \
	tests/guide \
	tests/capture \
	tests/capture_error \
	tests/capture_emission \
	tests/capture_colour \
	tests/capture_extras \
	tests/occluders \
	tests/occlusion \
	tests/capture_frames \
	tests/capture_extremes \
	tests/capture_forms \
	tests/place \
	tests/adapt \
	tests/leak \
	tests/sight \
	tests/tetra \
	tests/thin \
	tests/measure \
	tests/render \
	tests/relight \
	tests/fit

# What is broken on purpose: in the build with sanitizers alone, where a fault is seen.
FUZZ_TESTS = \
	tests/fuzz/fuzz_gltf \
	tests/fuzz/fuzz_query \
	tests/fuzz/fuzz_image \
	tests/fuzz/fuzz_scene \
	tests/fuzz/fuzz_stream \
	tests/fuzz/fuzz_tetra

# Scripts in the plain build alone: what they run is the same programs, and as little of what goes
# wrong, that the scripts of the programs run under sanitizers; here the results count.
# The longest are first in both: make starts them in this order, and none is left to run alone.
PLAIN_TESTS = \
	tests/sweep.t \
	tests/install.t \
	tests/bench.t \
	tests/layers.t \
	tests/format.t \
	tests/pipeline.t \
	tests/told-once.t \
	tests/bake-in-pieces.t \
	tests/stale-sight.t \
	tests/sealed-rooms.t
PROGRAM_TESTS = \
	tests/extreme-numbers.t \
	tests/probe-place.t \
	tests/probe-reach.t \
	tests/probe-adaptive.t \
	tests/place-by-light.t \
	tests/probe-capture.t \
	tests/capture-cache.t \
	tests/probe-capture-groups.t \
	tests/libprobe-query.t \
	tests/manual.t \
	tests/probe-bake.t \
	tests/probe-cat.t \
	tests/choice.t \
	tests/overwrite.t \
	tests/sky-file.t \
	tests/light-conversion.t \
	tests/probe-tet.t \
	tests/probe-leakfix.t \
	tests/dilate.t \
	tests/shadow-edges.t \
	tests/probe-error.t \
	tests/probe-query.t \
	tests/probe-relight.t \
	tests/probe-relight-surfaces.t \
	tests/probe-fit.t \
	tests/probe-render.t \
	tests/probe-vtk.t

if SANITIZED
TESTS = $(PROGRAM_TESTS) $(MODULE_TESTS) $(FUZZ_TESTS)
check_PROGRAMS = $(MODULE_TESTS) $(FUZZ_TESTS)
else
TESTS = $(PLAIN_TESTS) $(PROGRAM_TESTS) $(MODULE_TESTS)
check_PROGRAMS = $(MODULE_TESTS)
EXTRA_PROGRAMS = $(FUZZ_TESTS)
endif
TEST_EXTENSIONS = .t
T_LOG_DRIVER = env AM_TAP_AWK='$(AWK)' $(SHELL) $(top_srcdir)/build-aux/tap-driver.sh
LOG_DRIVER = $(T_LOG_DRIVER)
LOG_COMPILER = $(PROBE_TEST_WRAPPER)
AM_TESTS_ENVIRONMENT = PATH="$(abs_top_builddir)/src:$$PATH"; \
	SRC="$(abs_top_srcdir)"; BUILD="$(abs_top_builddir)"; \
	CC="$(CC)"; CXX="$(CXX)"; NM="$(NM)"; CFLAGS="$(CFLAGS)"; LDFLAGS="$(LDFLAGS)"; \
	LIBDIR="$(libdir)"; INCLUDEDIR="$(includedir)"; \
	export PATH SRC BUILD CC CXX NM CFLAGS LDFLAGS LIBDIR INCLUDEDIR;

tests_query_LDADD = $(TETRA_LIBS)
tests_interpolate_LDADD = $(TETRA_LIBS)
tests_tetra_LDADD = $(TETRA_LIBS)
tests_thin_LDADD = $(TETRA_LIBS)
tests_fuzz_fuzz_tetra_LDADD = $(TETRA_LIBS)
IMAGE_TEST_CPPFLAGS = $(AM_CPPFLAGS) $(STB_CFLAGS) $(WEBP_CFLAGS)
tests_image_CPPFLAGS = $(IMAGE_TEST_CPPFLAGS)
tests_image_exr_CPPFLAGS = $(IMAGE_TEST_CPPFLAGS) $(OPENEXR_CFLAGS)
tests_scene_CPPFLAGS = $(IMAGE_TEST_CPPFLAGS)
tests_scene_obj_CPPFLAGS = $(IMAGE_TEST_CPPFLAGS)
tests_scene_gltf_CPPFLAGS = $(IMAGE_TEST_CPPFLAGS)
tests_capture_forms_CPPFLAGS = $(IMAGE_TEST_CPPFLAGS)
tests_fuzz_fuzz_scene_CPPFLAGS = $(IMAGE_TEST_CPPFLAGS)
tests_fuzz_fuzz_gltf_SOURCES = tests/fuzz/fuzz_gltf.c tests/fuzz/fuzz_scene.c
tests_fuzz_fuzz_gltf_CPPFLAGS = $(IMAGE_TEST_CPPFLAGS) -DFUZZ_ENGINE

# the library as others use it, in C alone
check_PROGRAMS += doc/example doc/example_groups doc/example_surface tests/abi
doc_example_LDADD = src/libprobe-query/libprobe-query.la
doc_example_CPPFLAGS = -I$(top_srcdir)/src/libprobe-query
doc_example_LINK = $(LINK_C)
doc_example_groups_LDADD = src/libprobe-query/libprobe-query.la
doc_example_groups_CPPFLAGS = -I$(top_srcdir)/src/libprobe-query
doc_example_groups_LINK = $(LINK_C)
doc_example_surface_LDADD = src/libprobe-query/libprobe-query.la
doc_example_surface_CPPFLAGS = -I$(top_srcdir)/src/libprobe-query
doc_example_surface_LINK = $(LINK_C)
tests_abi_LDADD = src/libprobe-query/libprobe-query.la
tests_abi_LINK = $(LINK_C)
tests_library_LDADD = src/libprobe-query/libprobe-query.la $(TETRA_LIBS)
tests_library_LINK = $(LIBTOOL) $(AM_V_lt) --tag=CXX --mode=link $(LINK) -static \
	$(tests_library_LDFLAGS)
tests_library_LDFLAGS = -Wl,--wrap=malloc,--wrap=calloc,--wrap=aligned_alloc,--wrap=free
exampledir = $(docdir)
dist_example_DATA = doc/example.c doc/example_groups.c doc/example_surface.c

# makes system calls fail; tests/probe-cat.t preloads it
check_DATA = tests/support/failing_io.so
CLEANFILES = $(check_DATA)
tests/support/failing_io.so: tests/support/failing_io.c
	@$(MKDIR_P) tests/support
	$(AM_V_CCLD)$(CC) $(AM_CPPFLAGS) $(CFLAGS) -Wall -Wextra -shared -fPIC -o $@ \
		$(srcdir)/tests/support/failing_io.c -ldl

# what scripts/bench runs, which tests/bench.t does without sanitizers alone
if !SANITIZED
check_PROGRAMS += \
	tests/bench/bench_rays \
	tests/bench/bench_bases \
	tests/bench/bench_cold \
	tests/bench/bench_discs \
	tests/bench/bench_query \
	tests/bench/bench_visibility \
	tests/bench/bench_tetgen
endif
tests_bench_bench_rays_LINK = $(LINK) -Wl,--wrap=rtcIntersect1,--wrap=rtcOccluded1
tests_bench_bench_tetgen_SOURCES = tests/bench/bench_tetgen.cc
tests_bench_bench_tetgen_LDADD = $(TETRA_LIBS)

TEST_FILES = $(PLAIN_TESTS) $(PROGRAM_TESTS) \
	tests/accuracy.tsv \
	tests/libprobe-query.abi \
	tests/support/capture_bench.h \
	tests/support/capture_runs.h \
	tests/support/capture_truth.h \
	tests/support/failing_io.c \
	tests/support/files.h \
	tests/support/point_sets.h \
	tests/support/setup.sh \
	tests/support/sh_light.h \
	tests/support/tap.h \
	tests/support/vtk_read.py
