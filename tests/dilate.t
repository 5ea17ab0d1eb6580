#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-leakfix --dilate: probes in matter get the light of those in the air that they see, and what
# is dark in the air stays dark.
. "${SRC:?}/tests/support/setup.sh"

# box NAME X0 X1 Y0 Y1 Z0 Z1 WAY: a box whose faces look out, or in
box() {
    awk -v a="$2" -v b="$3" -v c="$4" -v d="$5" -v e="$6" -v f="$7" -v way="$8" -v name="$1" '
        BEGIN {
            print "o " name
            for (i = 0; i < 8; i++)
                print "v", (i % 2 ? b : a), (int(i / 2) % 2 ? d : c), (i > 3 ? f : e)
            split("1 3 4 2 5 6 8 7 1 2 6 5 3 7 8 4 1 5 7 3 2 4 8 6", v, " ")
            for (i = 1; i < 24; i += 4)
                if (way == "out") print "f", v[i] - 9, v[i + 1] - 9, v[i + 2] - 9, v[i + 3] - 9
                else print "f", v[i + 3] - 9, v[i + 2] - 9, v[i + 1] - 9, v[i] - 9
        }'
}
# Two rooms without a door, a block of .8 between them, and a slab in the lit one, off the block.
{
    box shell 0 8 0 3 0 4 in
    box block 3.6 4.4 -.1 3.1 -.1 4.1 out
} >rooms.obj
{ cat rooms.obj; box slab 3.2 3.3 -.1 3.1 -.1 4.1 out; } >slab.obj
lamp='--point 2,2.5,2,9,9,9'

# baked SCENE PLACES: with light and cells
baked() {
    # shellcheck disable=SC2086
    probe-place points -q "$2" | probe-capture -q --rays 64 --bounces 2 \
        --columns sh_error,sh_gradient,validity $lamp "$1" | probe-tet -q --thin 0
}
column_of() { rows_of position,"$1" "$2" | cut -d ' ' -f 4-; }
sh_of() { column_of sh "$1"; }
row() { sed -n "$1p" "$2"; }

printf '%s\n' '2 1.5 2' '3 1.4 2.2' '3.8 1.5 2.1' '4.2 1.6 2' '5 1.5 2.3' '6 1.4 2' >places.txt
baked rooms.obj places.txt >rooms.probe
column_of validity rooms.probe >validity
check "in the air validity is 1, in the block near 0" \
    [ "$(awk '{ printf "%d", ($1 > .5) }' validity)" = 110011 ]
probe-leakfix --dilate 'validity < 0.5' rooms.obj rooms.probe >filled.probe 2>said
check "how many were filled is said" \
    says said '2 of 6 probes hold the light of another: 2 of one that they see, 0 of the nearest'
column_of filled filled.probe >filled
check "column filled says which" [ "$(paste -s -d ' ' - <filled)" = '0 0 1 1 0 0' ]
for column in sh sh,sh_error sh,sh_gradient; do
    column_of $column rooms.probe >before
    column_of $column filled.probe >after
    for pair in '3 2' '4 5'; do row "${pair#* }" before; done >wanted
    sed -n '3,4p' after >got
    check "$column: each has that of the probe at its side of the block" \
        cmp got wanted and test -s wanted
    sed '3,4d' before >wanted
    sed '3,4d' after >got
    check "$column: what stands in the air keeps its own" cmp got wanted and test -s wanted
done
sh_of filled.probe | sed -n '4,6p' >dark
check "the dark room stays dark, and so does its side of the block" \
    every 'NF == 27 && !/[1-9]/' dark
column_of validity filled.probe >again
check "what a probe is stays known" cmp again validity
probe-leakfix -q --dilate 'validity < 0.5' rooms.obj filled.probe >twice.probe
for stream in filled twice; do rows_of position,sh,filled $stream.probe >$stream.rows; done
check "once more changes nothing" cmp filled.rows twice.rows and test -s twice.rows
probe-leakfix -q --dilate 'validity < 0.5' --dilate 'position[0] > 4' rooms.obj rooms.probe |
    column_of filled - | paste -s -d ' ' - >filled
check "of two conditions both must hold" says filled '^0 0 0 1 0 0$'
# shellcheck disable=SC2086
probe-place grid -q --clearance .4 --inside mark --spacing 1.3 --bounds 1,.5,.5,7,2.5,3.5 \
    rooms.obj |
    probe-capture -q --rays 16 --bounces 1 $lamp rooms.obj | probe-tet -q >marked.probe
probe-leakfix -q --dilate 'inside > 0' rooms.obj marked.probe | column_of filled - >filled
probe-leakfix -q --dilate 'validity < 0.5' rooms.obj marked.probe | column_of filled - >wanted
check "what probe-place marked as in a solid is what validity says" \
    cmp filled wanted and says filled 1 0
for threads in 1 3; do
    probe-leakfix -q --threads $threads --dilate 'validity < 0.5' rooms.obj rooms.probe \
        >threads$threads.probe
done
check "1 and 3 threads give the same bytes" \
    cmp threads1.probe threads3.probe and cmp threads1.probe filled.probe
# shellcheck disable=SC2086
probe-capture -q --again --rays 8 --bounces 1 $lamp rooms.obj filled.probe | probe-cat --text >text
check "captured again, nothing is filled" says text '^table probe.*sh:f32' and lacks text 'filled'

# The nearest stands behind the slab, whose front is in the way: it is not asked.
printf '%s\n' '2.9 1.5 2' '3.45 .4 .5' '3.7 1.5 2' '2 1 1.5' '3.45 2.6 .2' >places.txt
baked slab.obj places.txt >slab.probe
probe-leakfix --dilate 'validity < 0.5' slab.obj slab.probe >filled.probe 2>said
sh_of filled.probe >after
row 2 after >wanted
row 3 after >got
row 1 after >near
check "the nearest that is seen, not the nearest" cmp got wanted and differ near wanted
# Where none is seen, it is the nearest.
printf '%s\n' '2.9 1.5 2' '3.7 1.5 2' '2 1 1.5' '2.5 .4 1' '2.6 2 .4' >places.txt
baked slab.obj places.txt >slab.probe
probe-leakfix --dilate 'validity < 0.5' slab.obj slab.probe >filled.probe 2>said
sh_of filled.probe >after
row 1 after >wanted
row 2 after >got
check "where none is seen, the nearest" cmp got wanted and test -s wanted \
    and says said '1 of 5 .*: 0 of one that they see, 1 of the nearest'

# A black room is not invalid.
probe-leakfix --dilate 'validity < 0.5' "$SRC/scenes/two-rooms.obj" 2>said >filled.probe <<END
$(probe-place grid -q --count 40 "$SRC/scenes/two-rooms.obj" | probe-capture -q --rays 8 \
    --bounces 0 --light direct "$SRC/scenes/two-rooms.obj" | probe-tet -q | probe-cat --text)
END
check "probes in the air are left, however dark" says said ' 0 of [0-9]* probes hold the light'

# -- what is refused -------------------------------------------------------------------------------
refused 1 'all 6 probes with light are invalid' \
    probe-leakfix --dilate 'validity <= 1' rooms.obj rooms.probe
refused 1 'there is no column wetness' probe-leakfix --dilate 'wetness < 1' rooms.obj rooms.probe
refused 2 'expected COLUMN OP NUMBER' probe-leakfix --dilate validity rooms.obj rooms.probe
probe-cat --tables probe,tet --drop sh,sh_error,sh_gradient rooms.probe >dark.probe
refused 1 'no column sh' probe-leakfix --dilate 'validity < 0.5' rooms.obj dark.probe
tap_done
