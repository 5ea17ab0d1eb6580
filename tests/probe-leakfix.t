#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-leakfix as users run it.
. "${SRC:?}/tests/support/setup.sh"
rooms=$SRC/scenes/two-rooms.obj

# placed RAYS OPTION...: probes in a grid, captured, with cells
placed() {
    placed_rays=$1
    shift
    probe-place grid -q --count 120 "$rooms" |
        probe-capture -q --rays "$placed_rays" --bounces 4 "$@" "$rooms" | probe-tet
}
# count_leaks SAID: edges that leak before and after
count_leaks() {
    before=$(sed -n 's/.*before: \([0-9]*\) of .*/\1/p' "$1")
    before=${before:-0}
    after=$(sed -n 's/.*after: \([0-9]*\) of .*/\1/p' "$1")
    after=${after:-99}
}
# all_lit STREAM: no probe is without light
all_lit() {
    probe-cat --text "$1" >all_lit.text || return
    says all_lit.text '^[0-9-]' && lacks all_lit.text nan
}

# -- a grid of probes and a wall -------------------------------------------------------------------
placed 32 >cells.probe
probe-leakfix --rounds 4 "$rooms" cells.probe >baked.probe 2>said
count_leaks said
check "leaking edges: $before before, $after after" \
    [ "$before" -gt 10 ] and [ "$after" -lt $((before / 10)) ]
check "the cells are sound" probe-tet --verify baked.probe
check "every probe has light" all_lit baked.probe
probe-cat --text baked.probe >baked.text
check "the cells' edges are marked" says baked.text '^table tet .*occlusion:i32:6'
for threads in 1 2 4; do
    probe-leakfix --rounds 4 -q --threads $threads "$rooms" cells.probe >threads$threads.probe
done
check "1, 2 and 4 threads give the same bytes" \
    cmp threads1.probe threads2.probe and cmp threads1.probe threads4.probe \
    and test -s threads1.probe

# captured_anew OPTION...: light that probe-capture gives at the places of baked.probe
captured_anew() {
    probe-place points places.txt |
        probe-capture -q --rays 32 --bounces 4 "$@" "$rooms" >anew.probe
    rows_of position,sh anew.probe
}
rows_of position baked.probe >places.txt
rows_of position,sh baked.probe >baked.rows
captured_anew >anew.rows
check "new probes are captured as the others were" cmp anew.rows baked.rows and test -s baked.rows

# The same where they were captured in a scene of fewer triangles; leaks are looked for in the whole
# scene.
probe-cat --tables probe --columns position cells.probe |
    probe-capture --again -q --rays 32 --bounces 4 --decimate .6 "$rooms" | probe-tet >few.probe
probe-leakfix --rounds 4 "$rooms" few.probe >fewer.probe 2>err
grep edges said >wanted
grep edges err >got
check "leaks are those of the whole scene" cmp got wanted and test -s wanted
rows_of position,sh fewer.probe >fewer.rows
captured_anew --decimate .6 >anew.rows
check "new probes are captured in the scene that the others were captured in" \
    cmp anew.rows fewer.rows and differ fewer.rows baked.rows

# Light at the far side of the wall, beside it, low in the dark room: less than before it was
# mended, as behind a closed wall.
awk 'BEGIN { for (i = 0; i < 20; i++) print 4.3, 0.6 + i * .09, 0.5, 1, 0, 0 }' >behind.txt
light_behind() { probe-query -q "$1" behind.txt | awk '{ sum += $1 } END { print sum }'; }
{ light_behind cells.probe; light_behind baked.probe; } | paste -s -d ' ' - >leaky_and_mended
check "less light comes through the wall" every 'NF == 2 && $2 < 0.7 * $1' leaky_and_mended

# -- sight -----------------------------------------------------------------------------------------
# The same wall without a probe more: what blends the cells goes by what points see.
probe-leakfix "$rooms" cells.probe >seen.probe 2>said
check "how many cells have walls in them is said" says said 'of [0-9]* cells have walls in them'
probe-cat --text seen.probe >seen.text
check "cells keep what their points see" says seen.text '^table tet .*sight:f32:12 stand_in:i32:1'
for threads in 1 2 4; do
    probe-leakfix -q --threads $threads "$rooms" cells.probe >threads$threads.probe
done
check "1, 2 and 4 threads give the same bytes" \
    cmp threads1.probe threads2.probe and cmp threads1.probe threads4.probe \
    and test -s threads1.probe
{ light_behind cells.probe; light_behind seen.probe; } | paste -s -d ' ' - >leaky_and_seen
check "less light comes through the wall" every 'NF == 2 && $2 < 0.7 * $1' leaky_and_seen
probe-tet -q seen.probe | probe-cat --text >anew.text
check "cells that are made anew have none" \
    says anew.text '^table tet' and lacks anew.text 'sight:f32'

# -- options, and what is said ---------------------------------------------------------------------
probe-leakfix "$rooms" cells.probe >seen.probe 2>err
rows=$(row_count probe cells.probe)
check "no probe goes in that was not asked for" \
    [ "$rows" -gt 0 ] and [ "$(row_count probe seen.probe)" = "$rows" ]
probe-leakfix -q --no-sight "$rooms" seen.probe | probe-cat --text >counted.text
check "--no-sight only counts and marks, and forgets what was seen" \
    says counted.text '^table tet .*occlusion:i32:6' and lacks counted.text 'sight:f32'
probe-leakfix -q "$rooms" cells.probe 2>err >/dev/null
check "--quiet says nothing" empty err
probe-leakfix --rounds 4 --max-probes 105 "$rooms" cells.probe >limited.probe 2>err
check "--max-probes stops it, and says so" says err 'max-probes'
probe-place grid -q --count 120 "$rooms" | probe-tet >dark.probe
probe-leakfix --rounds 4 "$rooms" dark.probe >fixed.probe 2>err
check "probes without light get none, with a note" says err 'run probe-capture'
probe-leakfix --rounds 1 "$SRC/scenes/cornell-box.obj" cells.probe 2>err >/dev/null
check "another scene is warned about" says err 'not the scene'

# -- what is refused -------------------------------------------------------------------------------
probe-place grid -q --count 20 "$rooms" >loose.probe
refused 1 "run probe-tet" probe-leakfix "$rooms" <loose.probe
mkdir alone
cp "$BUILD/src/probe-leakfix" alone/
refused 1 "probe-tet" env PATH=/nowhere alone/probe-leakfix --rounds 4 -q "$rooms" cells.probe
refused 1 "expected a probe stream, got nothing" probe-leakfix "$rooms" </dev/null
head -c 3000 cells.probe >cut.probe
refused 1 "cut.probe" probe-leakfix "$rooms" cut.probe
refused 1 "No space left" into /dev/full probe-leakfix -q "$rooms" cells.probe
refused 2 "--margin" probe-leakfix --margin 2 "$rooms" cells.probe
refused 2 "SCENE" probe-leakfix

# -- probes in a plane, a tilted one too, on a line, two of them and one ---------------------------
# What leaks past the wall is mended within the plane or line; or there is nothing to look along.
in_plane() { # HEIGHT: an expression of x and z
    awk 'BEGIN { for (x = 0; x < 8; x++) for (z = 0; z < 4; z++) print x + .25, '"$1"', z + .375 }'
}
in_plane 1.25 >plane.txt
in_plane '.75 + x / 8 + z / 4' >tilted.txt
awk 'BEGIN { for (x = 0; x < 8; x++) print x + .25, 1.25, 3.5 }' >line.txt
printf '%s\n' '1 1.25 3.5' '7 1.25 3.5' >two.txt
echo '1 1.25 3.5' >one.txt
captured() { # NAME: the points of NAME.txt with light and cells
    probe-place points -q "$1.txt" | probe-capture -q --rays 16 --bounces 2 "$rooms" | probe-tet -q
}
printf '%s\n' '3.5 1.2 3.5' '4.5 1.2 3.5' >sides.txt # of the wall
for flat in plane:tri:3 tilted:tri:3 line:segment:1 two:segment:1; do
    IFS=: read -r name table edges <<FLAT
$flat
FLAT
    captured $name >$name.probe
    probe-cat --text $name.probe >text
    check "$name: its cells are those of table $table" says text "^table $table "
    probe-leakfix --rounds 0 "$rooms" $name.probe 2>said | probe-cat --text >marked.text
    check "$name: --rounds 0 marks the edges" \
        says marked.text "^table $table .*occlusion:i32:$edges"
    probe-leakfix --rounds 4 "$rooms" $name.probe >mended.probe 2>said
    count_leaks said
    check "$name: leaking edges: $before before, $after after" \
        [ "$before" -gt 0 ] and [ "$after" -lt "$before" ]
    probe-cat --text mended.probe >text
    check "$name: they are those of table $table still" says text "^table $table "
    check "$name: the cells are sound, and every probe has light" \
        probe-tet --verify mended.probe and all_lit mended.probe
    probe-query -q mended.probe sides.txt | cut -d ' ' -f 1 | paste -s -d ' ' - >light
    check "$name: mended, it answers on both sides of the wall" \
        every 'NF == 2 && $1 > 2 * $2 && $2 > 0' light
done
captured one >one.probe
probe-leakfix --rounds 4 "$rooms" one.probe 2>said >mended.probe
check "one probe: there is nothing to look along" \
    says said '0 of 0 edges leak' and same_stream one.probe mended.probe
tap_done
