#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What a program reads it does not overwrite, whatever it is called; a stream in place it may.
. "${SRC:?}/tests/support/setup.sh"

# a scene, and all kinds of files that it names
cat >box.obj <<'END'
mtllib box.mtl
v 0 0 0
v 1 0 0
v 1 0 1
v 0 0 1
vt .5 .5
usemtl red
f 4/1 3/1 2/1 1/1
END
printf '%s\n' 'newmtl red' 'map_Kd red.hdr' 'Ke 1 1 1' >box.mtl
printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\200\100\100\200' >red.hdr
cp red.hdr sky.hdr
printf '%s\n' '{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "buffers": [{"uri": "one.bin", "byteLength": 36}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [0, 0, 0], "max": [1, 1, 0]}]}' >one.gltf
printf '\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0' >one.bin
printf '%s\n' '.2 .2 .3' '.7 .2 .3' '.3 .3 .8' '.4 .8 .4' >at.txt
probe-place points at.txt | probe-capture -q --rays 16 box.obj | probe-tet -q >baked.probe
probe-query --pack float -o packed baked.probe
mkdir sub
ln box.obj linked.obj
ln -s ../box.obj sub/named.obj
for file in *.* packed; do cp "$file" "sub/$file"; done

# keeps FILE OPTION COMMAND...: refused as wrong use, before any work; the file is as it was
keeps() {
    keeps_file=$1 keeps_said=$2
    shift 2
    "$@" >keeps.out 2>keeps.err </dev/null
    keeps_status=$?
    check "$*" [ $keeps_status -eq 2 ] and says keeps.err "$keeps_said would overwrite it" \
        and cmp "$keeps_file" "sub/$keeps_file" and test ! -s keeps.out
}
keeps box.obj --output probe-place grid --count 8 box.obj -o box.obj
keeps box.obj --output probe-place grid --count 8 ./sub/../linked.obj -o sub/named.obj
keeps box.mtl --output probe-place grid --count 8 box.obj -o box.mtl
check "what would be overwritten is named" says keeps.err 'file box.mtl: it is read'
keeps red.hdr --output probe-place vertices box.obj -o red.hdr
check "as a texture, too" says keeps.err 'texture red.hdr: it is read'
keeps one.bin --output probe-place vertices one.gltf -o one.bin
keeps at.txt --output probe-place points at.txt -o at.txt
keeps at.txt --output probe-place grid --count 8 --reach at.txt box.obj -o at.txt
keeps at.txt --output probe-place reach at.txt box.obj -o at.txt
keeps box.obj --curve probe-place adaptive --probes 4 --curve box.obj box.obj
keeps baked.probe --output probe-place unlit baked.probe -o baked.probe
keeps box.mtl --output probe-capture box.obj baked.probe -o box.mtl
keeps sky.hdr --output probe-capture --sky sky.hdr box.obj baked.probe -o sky.hdr
keeps box.obj --output probe-leakfix box.obj baked.probe -o box.obj
keeps baked.probe --map probe-error box.obj baked.probe --map baked.probe
keeps at.txt --map probe-error box.obj baked.probe --at at.txt --map at.txt
refused 2 "x: --map and --truth are the same file" \
    probe-error box.obj baked.probe --truth x --map x
keeps at.txt --output probe-error box.obj baked.probe --at at.txt -o at.txt
keeps at.txt --output probe-query baked.probe at.txt -o at.txt
keeps baked.probe --output probe-query baked.probe at.txt --to stream -o baked.probe
keeps baked.probe --output probe-query --pack float baked.probe -o baked.probe
keeps packed --output probe-query packed at.txt -o packed
keeps baked.probe --output probe-render box.obj baked.probe -o baked.probe
keeps box.obj --pfm probe-render box.obj baked.probe -o x.png --pfm box.obj
keeps baked.probe --output probe-vtk baked.probe -o baked.probe
keeps box.obj --scene-output probe-vtk --scene box.obj baked.probe -o x.vtu --scene-output box.obj
keeps box.obj --output probe-bake box.obj -o box.obj
keeps red.hdr --pack probe-bake box.obj -o x.probe --pack red.hdr
keeps at.txt --output probe-bake box.obj --reach at.txt -o at.txt
cp sky.hdr probes.png
cp sky.hdr sub/probes.png
keeps probes.png --report probe-bake box.obj --sky probes.png --report . -o x.probe
check "no output is there" not ls x.*
refused 2 "x: --curve and --output are the same file" \
    probe-place adaptive --probes 4 --curve x box.obj -o sub/../x

# into what is read, as a shell does it, nothing goes; a stream in its place, when it is whole, does
refused 2 "standard output would overwrite it" sh -c 'probe-cat at.probe >>at.probe'
refused 2 "standard output would overwrite it" sh -c 'probe-error box.obj baked.probe >>baked.probe'
refused 2 "standard output would overwrite it" \
    sh -c 'probe-error box.obj baked.probe --at at.txt >>at.txt'
check "and they are as they were" cmp baked.probe sub/baked.probe
refused 2 "stdout: --curve and standard output are the same file" \
    sh -c 'probe-place adaptive --probes 4 --curve both box.obj >both'
refused 2 "stdout: --output and standard output are the same file" \
    sh -c 'probe-bake box.obj -o both >both'
for run in "probe-cat --text" "probe-tet" "probe-leakfix -q box.obj" \
    "probe-capture -q --again box.obj"; do
    cp sub/baked.probe same.probe
    $run baked.probe >other.probe 2>said
    $run same.probe -o same.probe 2>said
    check "$run, in place" same_stream same.probe other.probe and test -s same.probe
done
cp sub/baked.probe same.probe
probe-cat -q sub/baked.probe baked.probe >other.probe
probe-cat -q sub/baked.probe same.probe -o same.probe
check "one of several" cmp same.probe other.probe
check "standard input" into /dev/null probe-cat -o same.probe <same.probe
check "a device is nobody's" probe-query baked.probe /dev/null -o /dev/null

tap_done
