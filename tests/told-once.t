#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What is wrong with a scene is said once in a bake, by the first program that sees it.
. "${SRC:?}/tests/support/setup.sh"

# A room with a missing texture, a triangle without an area and a material that nobody defines.
printf '%s\n' 'newmtl wall' 'Kd .5 .5 .5' 'map_Kd missing.png' 'newmtl lamp' 'Ke 5 5 5' >room.mtl
cat >room.obj <<'OBJ'
mtllib room.mtl
v 0 0 0
v 4 0 0
v 4 3 0
v 0 3 0
v 0 0 4
v 4 0 4
v 4 3 4
v 0 3 4
usemtl wall
f 1 2 3 4
f 8 7 6 5
f 5 6 2 1
f 6 7 3 2
usemtl lamp
f 7 8 4 3
usemtl nobody
f 8 5 1 4
f 1 1 2
OBJ
# warns COUNT FILE...: so many warnings in all
warns() {
    warns_count=$1
    shift
    [ "$(cat "$@" | grep -c warning:)" -eq "$warns_count" ] || { cat "$@"; return 1; }
}
probe-place grid --count 30 room.obj >placed.probe 2>place.err
check "place says what is wrong: three kinds" warns 3 place.err
probe-capture -r 16 room.obj placed.probe >captured.probe 2>capture.err
probe-tet captured.probe >tets.probe 2>tet.err
probe-leakfix --rounds 1 room.obj tets.probe >baked.probe 2>leakfix.err
probe-error -n 4 --truth-rays 16 --paths 1 room.obj baked.probe >out 2>error.err
probe-vtk -o baked.vtu --scene room.obj baked.probe 2>vtk.err
probe-render -o picture.png --size 16x16 --samples 1 room.obj baked.probe >out 2>render.err
grep -h 'room\.\|missing' capture.err leakfix.err error.err vtk.err render.err >again
check "the others do not repeat it" empty again and test -s baked.probe and test -s picture.png \
    and test -s baked.scene.vtp
check "wherever the scene is seen from" sh -c 'mkdir below && cd below &&
    probe-capture -r 4 --again ../room.obj ../captured.probe 2>../below.err >/dev/null' and \
    warns 0 below.err

probe-place grid -q --count 30 room.obj >quiet.probe
probe-capture -r 4 room.obj quiet.probe >quiet2.probe 2>err
check "--quiet tells nothing, so the next does" warns 3 err
probe-capture -r 4 --again room.obj quiet2.probe 2>err >out
check "and that is enough" warns 0 err
probe-capture -q -r 4 room.obj quiet.probe >quiet2.probe
check "unless it is quiet as well" sh -c '! grep -aq ^scene-told quiet2.probe'

sed 's/^v 4 3 4/v 4 3 5/' room.obj >other.obj
probe-capture -r 4 --again other.obj captured.probe 2>err >out
check "another scene is told of anew" warns 3 err
probe-capture -r 4 --again --max-albedo .3 room.obj captured.probe >limited.probe 2>err
check "another warning of the same scene is told" warns 1 err and says err 'limited to 0.3'
probe-capture -r 4 --again room.obj limited.probe >out 2>err
check "once" warns 0 err

for part in 1 2; do probe-capture -r 4 --slice $part/2 room.obj quiet.probe >$part.probe 2>err; done
probe-capture -q -r 4 --slice 2/2 room.obj quiet.probe >2.probe
check "slices that told and that did not go together without a word" \
    sh -c 'probe-cat --fill 2.probe 1.probe >all.probe 2>err' and warns 0 err

tap_done
