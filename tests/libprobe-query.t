#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# libprobe-query as it is installed: nothing shown but probe_*, no dependency but libc and libm, a
# header for C and C++, the same binary interface as the last release, and an example that a
# compiler and pkg-config suffice for.
. "${SRC:?}/tests/support/setup.sh"
unset MAKEFLAGS MFLAGS MAKELEVEL

shared=$BUILD/src/libprobe-query/.libs/libprobe-query.so
archive=$BUILD/src/libprobe-query/.libs/libprobe-query.a

make -s -C "$BUILD" install-libLTLIBRARIES install-includeHEADERS install-pkgconfigDATA \
    install-dist_exampleDATA exampledir=/doc DESTDIR="$PWD/root" >install.log 2>&1 ||
    fail "make install" "$(cat install.log)"
lib=$PWD/root$LIBDIR
include=$PWD/root$INCLUDEDIR

# -- names -----------------------------------------------------------------------------------------
shown() { # shown NM-OPTION... FILE: names that the file defines for others; not a sanitizer's
    $NM --defined-only "$@" | awk 'NF == 3 && $3 !~ /^__odr_asan\./ { print $3 }' | sort -u
}
sed -n 's/^[a-z].*[ *]\(probe_[a-z_]*\)(.*/\1/p' "$include/probe-query.h" | sort -u >promised
if [ -e "$shared" ]; then
    shown -D "$shared" | sed 's/@.*//' | grep -vx 'PROBE_QUERY_[0-9.]*' >shown
    check "the shared library shows what the header promises, and no more" diff promised shown
    readelf -d "$shared" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | sort >needed
    if sanitized; then
        skip "a sanitizer's libraries are needed besides"
    else
        printf 'libc.so.6\nlibm.so.6\n' >expected
        check "it needs libc and libm alone" diff expected needed
    fi
    readelf -d "$shared" >dynamic
    check "its soname is libprobe-query.so.0" says dynamic 'SONAME.*\[libprobe-query.so.0\]'
    grep -v '^#' "$SRC/tests/libprobe-query.abi" >promised.abi
    { shown -D --with-symbol-versions "$shared" | grep '^probe_'; "$BUILD/tests/abi"; } >built.abi
    check "the binary interface is that of tests/libprobe-query.abi" diff promised.abi built.abi
else
    skip "there is no shared library"
fi
if [ -e "$archive" ]; then
    shown -g "$archive" >shown
    check "every name of the static library begins with probe_" every '/^probe_/' shown
    grep -v '^probe_private_' shown >public
    check "all that the header promises is in it, and all else is probe_private_" \
        diff promised public
    # a game with names of its own, which takes in the whole library
    cat >game.c <<'C'
#include <probe-query.h>
#include <stdio.h>
int volume_place(void), volume_finish, sh_basis(int), lattice_fit;
int volume_place(void) { return 1; }
int sh_basis(int order) { return order + lattice_fit + volume_finish; }
int main(void) { return puts(probe_status_text(PROBE_OK)) < 0 || sh_basis(0) || !volume_place(); }
C
    # shellcheck disable=SC2086 # lists of options
    check "a program with names like its own links it" $CC $LDFLAGS -I"$include" -o game game.c \
        -Wl,--whole-archive "$lib/libprobe-query.a" -Wl,--no-whole-archive -lm \
        and into said ./game and says said '^done$'
else
    skip "there is no static library"
fi

while read -r name; do
    grep -qx "\\.Fn $name .*" "$SRC/man/libprobe-query.3" || echo "$name"
done <promised >unsaid
check "each function is in the manual" empty unsaid and test -s promised

# -- the header ------------------------------------------------------------------------------------
printf '#include <probe-query.h>\nstruct probe_place place;\n' >alone.c
cp alone.c alone.cc
strict="-Wall -Wextra -pedantic -Werror -I$include -fsyntax-only"
for standard in c99 c11 c17; do
    check "the header alone is $standard" $CC -std=$standard $strict alone.c
done
for standard in c++98 c++17; do # long long, which C++98 does not know, is the system's
    check "the header alone is $standard" $CXX -std=$standard $strict -Wno-long-long alone.cc
done

# -- the folder alone ------------------------------------------------------------------------------
for compiler in "$CC" clang; do
    name="the folder is all that ${compiler##*/} needs"
    if command -v "${compiler%% *}" >/dev/null; then
        rm -rf copy
        mkdir copy
        cp "$SRC"/src/libprobe-query/*.[ch] "$SRC/doc/example.c" copy
        (cd copy && $compiler -std=c17 -Wall -Wextra -Werror -c [!e]*.c &&
            $compiler -std=c17 -Wall -Wextra -Werror -I. -o example example.c [!e]*.o -lm) >log 2>&1
        copy/example copy/example.c 0 0 0 1 1 1 >said 2>&1
        check "$name" empty log and says said 'not a packed file'
    else
        skip "$name: it is not installed"
    fi
done

# -- the example -----------------------------------------------------------------------------------
check "the example has less than 60 lines" [ "$(wc -l <"$SRC/doc/example.c")" -lt 60 ]
cat >light.awk <<'AWK'
BEGIN { srand(5) }
{
    printf "%s %s %s", $1, $2, $3
    for (k = 0; k < 27; k++) printf " %.9g", rand() - (k > 2) / 2
    print ""
}
AWK
probe-place grid --spacing 1 --bounds 0,0,0,8,4,4 --text | numbers >positions
seq -1 9 | awk '{ print $1, 2 + $1 / 10 + .1, 1, 0, 1, 0 }' >points
if command -v pkg-config >/dev/null; then
    export PKG_CONFIG_PATH="$lib/pkgconfig" PKG_CONFIG_SYSROOT_DIR="$PWD/root"
    export PKG_CONFIG_ALLOW_SYSTEM_CFLAGS=1 PKG_CONFIG_ALLOW_SYSTEM_LIBS=1
    # where the library is an archive alone, what it needs is asked for as well
    static=
    [ -e "$shared" ] || static=--static
    # shellcheck disable=SC2046,SC2086 # lists of options
    check "the example builds with what pkg-config says" \
        $CC $LDFLAGS root/doc/example.c $(pkg-config $static --cflags --libs libprobe-query)
else
    skip "pkg-config is not installed"
    cp "$BUILD/doc/example" a.out
fi
for content in radiance irradiance; do
    awk -f light.awk positions |
        stream_of "sh-order 3" "sh-content $content" "table probe position:f64:3 sh:f32:27" |
        probe-tet -q >$content.probe
    for packing in float half; do
        probe-query --pack $packing -o $content.pack $content.probe
        LD_LIBRARY_PATH=$lib ./a.out $content.pack -1 2 1 9 3 1 >said
        tail -n +2 said | perl -ne 'print pack("f<3", (split)[4 .. 6])' >got
        probe-query -q --to binary $content.pack points >expected
        check "it gives probe-query's bytes ($content, $packing)" \
            test -s expected and cmp got expected
    done
done

# -- groups of lights ------------------------------------------------------------------------------
check "and that of groups" [ "$(wc -l <"$SRC/doc/example_groups.c")" -lt 60 ]
probe-place grid --spacing 2 --bounds 0,0,0,8,4,4 --text | numbers | awk '
BEGIN { srand(6) }
{
    printf "%s %s %s", $1, $2, $3
    for (k = 0; k < 54; k++) { part[k] = rand() - (k % 27 > 2) / 2; $(4 + k) = part[k] }
    for (k = 0; k < 27; k++) printf " %.9g", part[k] + part[27 + k]
    for (k = 0; k < 54; k++) printf " %.9g", part[k]
    print ""
}' | stream_of "sh-order 3" "sh-content radiance" "group-1 alarm light=alarm" "group-2 rest" \
    "table probe position:f64:3 sh:f32:27 sh_alarm:f32:27 sh_rest:f32:27" |
    probe-tet -q >groups.probe
echo 3.3 1.7 2.2 0 1 0 >here
for red in 0 2; do
    probe-relight -w rest=.25 -w alarm=$red,0,0 groups.probe >lit.probe
    probe-query -q --to binary lit.probe here >lit.$red
done
cat lit.0 lit.2 lit.0 lit.2 >expected
probe-query --pack float --groups -o groups.pack groups.probe
probe-query --pack half --groups -o half.pack groups.probe
"$BUILD/doc/example_groups" groups.pack alarm 3.3 1.7 2.2 >got.text
perl -ne 'print pack("f<3", split)' got.text >got
"$BUILD/doc/example_groups" half.pack alarm 3.3 1.7 2.2 >half.text
check "a lamp blinks: bytes of probe-relight and probe-query" \
    test -s expected and cmp got expected and differ lit.0 lit.2
check "and nearly these of halves" near 2e-3 got.text half.text and test -s half.text \
    and differ got.text half.text
for column in sh sh_alarm sh_rest; do
    probe-query -q --to binary --column $column groups.probe here >expected
    probe-query -q --to binary --column $column groups.pack here >got
    check "column $column of the packed file is that of the stream" \
        test -s expected and cmp got expected
done
# weights of a sky are its SH, those of a sun its irradiance: all .25, as the example has them
sed 's/^ *//' >sky.probe <<'END'
    #?probe 1
    sh-order 2
    sh-content radiance
    table probe position:f64:3 sh:f32:12
    0 0 0 .25 .25 .25 .25 .25 .25 .25 .25 .25 .25 .25 .25
    end
END
awk 'BEGIN {
    srand(7)
    for (i = 0; i < 16; i++) {
        printf "%d %d %d", i % 2, int(i / 2) % 2, int(i / 4)
        for (k = 0; k < 108; k++) printf " %.6f", rand()
        print ""
    }
}' | stream_of "sh-order 2" "sh-content radiance" "sky 0,0,0" "group-1 alarm light=alarm" \
    "group-2 rest" "transfer-sky 2" "transfer-sun-1 0,1,0" "transfer-sun-2 1,0,0" \
    "table probe position:f64:3 sh:f32:12 sh_alarm:f32:12 sh_rest:f32:12 transfer_sky:f32:48 \
transfer_suns:f32:24" | probe-tet -q >parts.probe
probe-query --pack float --groups --transfer -o parts.pack parts.probe
probe-relight -q -w rest=.25 -w alarm=0 --sky-probe sky.probe --sun 0,1,0,.25,.25,.25 \
    --sun 1,0,0,.25,.25,.25 parts.probe | probe-query -q - here >expected
"$BUILD/doc/example_groups" parts.pack alarm 3.3 1.7 2.2 | head -n 1 >got
check "blocks of transfers are groups: a sky and two suns" near 1e-5 got expected and test -s got
sed -e /^group/d parts.probe | probe-cat --drop sh_alarm,sh_rest >whole.probe
probe-query --pack float --transfer -o whole.pack whole.probe
probe-query -q --column sh_rest whole.pack here >whole
probe-query -q whole.probe here >expected
check "without groups all light is one" near 1e-6 whole expected and test -s whole
refused 1 "no transfer (no column transfer_sky, _suns or _points): run probe-capture --transfer" \
    probe-query --pack half --transfer -o x groups.probe
printf '\001' | cat groups.pack - >longer.pack
refused 1 "damaged" probe-query longer.pack here

# -- surfaces --------------------------------------------------------------------------------------
check "so has the example of surfaces" [ "$(wc -l <"$SRC/doc/example_surface.c")" -lt 60 ]
probe-place grid --spacing 1 --bounds 0,0,0,8,.1,8 --text | numbers |
    awk '{ print $1, 0, $3, 0, 1, 0, 1, .1 + $1, 2, 3 / (1 + $3)
        print $1, 0, $3, 0, -1, 0, 1, 7, 8, 9 }' |
    stream_of "table probe position:f64:3 normal:f32:3 radius:f32:1 irradiance:f32:3" >sheet.probe
seq 1 40 | awk '{ print $1 / 5, .01 * ($1 % 2), 8 - $1 / 6, 0, $1 % 3 ? 1 : -1, 0 }' >on-sheet
for packing in float half; do
    probe-query --interpolate discs --pack $packing -o sheet.pack sheet.probe
    "$BUILD/doc/example_surface" sheet.pack <on-sheet >got
    sed 's/  by.*//' got | perl -ne 'print pack("f<3", split)' >got.bin
    probe-query -q --interpolate discs --to binary sheet.pack on-sheet >expected.bin
    check "surfaces: it gives probe-query's bytes ($packing)" \
        test -s expected.bin and cmp got.bin expected.bin
done
probe-query --interpolate discs --pack float -o sheet.pack sheet.probe
probe-query -q --interpolate discs --to binary sheet.probe on-sheet >expected.bin
probe-query -q --interpolate discs --to binary sheet.pack on-sheet >got.bin
probe-query -q --interpolate discs sheet.pack on-sheet >got
check "and those of the stream, of either side its own" cmp got.bin expected.bin \
    and every '(NR % 3 == 0) == near($1, 7, 1e-5) && (NR % 3 || near($3, 9, 1e-5))' got
head -c 5000 radiance.pack >short.pack
refused 1 "damaged" env LD_LIBRARY_PATH="$lib" ./a.out short.pack 0 0 0 1 1 1
tap_done
