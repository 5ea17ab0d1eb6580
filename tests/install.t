#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What is installed is whole: it runs without the source and the build, below a DESTDIR, and under
# other names; --prefix is heeded, and uninstalling leaves nothing.
. "${SRC:?}/tests/support/setup.sh"
unset MAKEFLAGS MFLAGS MAKELEVEL
scene=$SRC/scenes/two-rooms.obj
with_vtk=false
[ ! -x "$BUILD/src/probe-vtk" ] || with_vtk=true

# installed DIRECTORY: every file below it, by its name
installed() {
    find "$1" ! -type d | sed 's:.*/::' | sort
}
nothing_below() {
    [ -z "$(find "$1" ! -type d)" ]
}

# -- everything, below a DESTDIR -------------------------------------------------------------------
make -s -C "$BUILD" install DESTDIR="$PWD/root" >log 2>&1 || fail "make install" "$(cat log)"
bin=$(dirname "$(find root -name probe-tet)")
lib=$PWD/root$LIBDIR
man=$(dirname "$(find root -name probe.5)")/..
{
    for page in "$SRC"/man/*.[1357]; do echo "${page##*/}"; done
    for program in "$SRC"/src/probe-*.c; do basename "$program" .c; done
    printf '%s\n' probe-query.h libprobe-query.pc example.c example_groups.c example_surface.c
} | if $with_vtk; then cat; else grep -vx 'probe-vtk'; fi | sort >expected
installed root | grep -v '^libprobe-query\.\(so\|a\|la\)' >got
check "programs, pages, header, pkg-config file and examples, and no more" diff expected got
check "the library" test -e "$lib/libprobe-query.a" -o -e "$lib/libprobe-query.so"

# env -i: nothing helps but what every system has
bare="env -i LC_ALL=C TMPDIR=$PWD PATH=$PWD/$bin:/usr/bin:/bin"
cat >bake.sh <<'SH'
probe-place grid -q --count 60 "$1" | probe-capture -q --rays 32 --emit front "$1" |
    probe-tet -q >cells.probe
probe-leakfix -q --rounds 1 "$1" cells.probe >baked.probe
SH
$bare sh bake.sh "$scene"
mv baked.probe by-installed
sh bake.sh "$scene"
check "they bake what those of the build do" test -s by-installed and cmp baked.probe by-installed
echo '1 1 1' | $bare probe-query -q by-installed >light
check "a query" every 'NF > 26' light
check "a measurement" $bare probe-error -q --points 20 --truth-rays 16 "$scene" by-installed
check "a picture" $bare probe-render -q --size 16x9 --samples 1 -o picture.png "$scene" by-installed
check "a look at a stream" $bare probe-cat --info by-installed
if $with_vtk; then
    check "a file for ParaView" $bare probe-vtk -q -o baked.vtu by-installed and test -s baked.vtu
fi
for page in probe-tet.1 probe.5 libprobe-query.3 probe-tools.7; do
    check "page $page" cmp "$SRC/man/$page" "$man/man${page##*.}/$page"
done
sed -n 's/^#define PACKAGE_VERSION "\(.*\)"/\1/p' "$BUILD/config.h" >version
check "the pkg-config file has the version and the place" \
    grep -qx "Version: $(cat version)" "$lib/pkgconfig/libprobe-query.pc" \
    and grep -qx "libdir=$LIBDIR\|libdir=[$]{.*lib.*" "$lib/pkgconfig/libprobe-query.pc"

make -s -C "$BUILD" uninstall DESTDIR="$PWD/root" >log 2>&1 || fail "make uninstall" "$(cat log)"
check "uninstalled, nothing is left" nothing_below root

# -- under other names -----------------------------------------------------------------------------
# probe-leakfix runs probe-tet, and finds it by its own name
for names in 's/^/my-/' 's/$/-2/' 's/^probe/light/' 's/^/leak-/;s/$/.bin/'; do
    tet=named/$(echo probe-tet | sed "$names")
    leakfix=named/$(echo probe-leakfix | sed "$names")
    rm -rf named
    mkdir named
    cp "$BUILD/src/probe-tet" "$tet"
    cp "$BUILD/src/probe-leakfix" "$leakfix"
    env -i PATH=/nowhere "$leakfix" -q --rounds 1 "$scene" cells.probe >fixed
    check "names by $names: leakfix makes cells" test -s fixed and cmp fixed by-installed
done
rm -f "$tet"
refused 1 "probe-tet: No such file" \
    env -i PATH=/nowhere "$leakfix" -q --rounds 1 "$scene" cells.probe

# -- --prefix --------------------------------------------------------------------------------------
# As make is told, since to configure anew takes longer than all of this.
wanted=$PWD/wanted
placed() { # placed TARGET...: of that prefix and those names
    make -s -C "$BUILD" prefix="$wanted" program_transform_name='s/^/my-/' "$@" >log 2>&1 ||
        fail "make $*" "$(cat log)"
}
placed install-man install-includeHEADERS install-dist_exampleDATA
check "the prefix is where things go" test -s "$wanted/share/man/man1/my-probe-tet.1" \
    and test -s "$wanted/include/probe-query.h"
placed uninstall-man uninstall-includeHEADERS uninstall-dist_exampleDATA
check "and where they leave from" nothing_below "$wanted"
tap_done
