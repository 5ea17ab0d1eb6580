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

# holds_number VALUE LEAST MOST
holds_number() {
    awk -v v="$1" -v least="$2" -v most="$3" \
        'BEGIN { exit !(v != "" && v + 0 >= least + 0 && v + 0 <= most + 0) }'
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
for threads in 1 3; do
    probe-leakfix --rounds 4 -q --threads $threads "$rooms" cells.probe >threads$threads.probe
done
check "1 and 3 threads give the same bytes" \
    cmp threads1.probe threads3.probe and test -s threads1.probe

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
for threads in 1 3; do
    probe-leakfix -q --threads $threads "$rooms" cells.probe >threads$threads.probe
done
check "1 and 3 threads give the same bytes" \
    cmp threads1.probe threads3.probe and test -s threads1.probe
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
most=$((rows + 10))
probe-leakfix --rounds 4 --max-probes $most "$rooms" cells.probe >limited.probe 2>err
limited=$(row_count probe limited.probe)
check "--max-probes: what mends most goes in ($limited of $most), and that is said" \
    [ "$limited" -le $most ] and [ "$limited" -gt $((most - 2)) ] \
    and says err "max-probes $most: $((limited - rows)) probes went in .* edges still leak"
# Undone where no less leaks, and then tried with others: some always help.
unseen_after() { sed -n 's/.*unseen weight .*) *\([0-9.e-]*\) %.*/\1/p;
    s/.*unseen weight *\([0-9.e-]*\) % ([^)]*) *$/\1/p' "$1" | paste -s -d ' ' -; }
for room in 1 2 3; do
    probe-leakfix --no-sight --rounds 4 --max-probes $((rows + room)) "$rooms" cells.probe \
        >limited.probe 2>err
    unseen_after err >before_after
    check "room for $room: one at least goes in, and less leaks ($(cat before_after))" \
        [ "$(row_count probe limited.probe)" -gt "$rows" ] \
        and every 'NF == 2 && $2 < $1' before_after
done
probe-leakfix --rounds 4 --max-probes "$rows" "$rooms" cells.probe >limited.probe 2>err
check "or nothing, where there is no room" [ "$(row_count probe limited.probe)" = "$rows" ] \
    and says err "max-probes $rows: 0 probes went in"
probe-place grid -q --count 100 "$rooms" | probe-tet >round.probe
probe-leakfix --points 2000 "$rooms" round.probe 2>err >/dev/null
check "what rounding leaves is nothing" says err 'outside: unseen' and lacks err 'e-1[0-9]'
probe-place grid -q --count 120 "$rooms" | probe-tet >dark.probe
probe-leakfix --rounds 4 "$rooms" dark.probe >fixed.probe 2>err
check "probes without light get none, with a note" says err 'run probe-capture'
probe-leakfix --rounds 1 "$SRC/scenes/cornell-box.obj" cells.probe 2>err >/dev/null
check "another scene is warned about" says err 'not the scene'

# -- through a cache -------------------------------------------------------------------------------
# New probes use the cache through which the others were captured, whose name the header has.
probe-place grid -q --count 120 "$rooms" |
    probe-capture -q --rays 4096 --bounces 4 --cache auto --cache-out rooms.cache "$rooms" \
        >of.probe
placed 32 --cache rooms.cache --cache-error 20% >cached.probe
probe-leakfix --rounds 1 "$rooms" cached.probe >mended.probe 2>said
rows_of position mended.probe >places.txt
rows_of position,sh mended.probe >cached.rows
captured_anew --cache rooms.cache --cache-error 20% >anew.rows
check "new probes use the cache of the others" \
    says said 'probe-leakfix: cache: .* points change' and cmp anew.rows cached.rows \
    and [ "$(wc -l <cached.rows)" -gt 120 ]
probe-leakfix -q --rounds 1 --cache off "$rooms" cached.probe >plain.probe
rows_of position,sh plain.probe >plain.rows
check "and none with --cache off" test -s plain.rows and \
    sh -c '! cmp -s plain.rows cached.rows'
placed 32 --light-scale .5 >dim.probe
refused 1 "--cache: rooms.cache: the cache is of another scene, or of other light in it" \
    probe-leakfix --rounds 1 --cache rooms.cache "$rooms" dim.probe
check "a cache of other light is renewed" into renewed.probe \
    probe-leakfix -q --rounds 1 --cache rooms.cache --cache-renew "$rooms" dim.probe
mv rooms.cache gone.cache
refused 1 "the cache of the stream's probes (--cache off: without it): rooms.cache: No such" \
    probe-leakfix --rounds 1 "$rooms" cached.probe
refused 2 "--cache is for new probes" probe-leakfix --cache auto "$rooms" cached.probe
refused 2 "--cache: expected auto, a file's name or off" \
    probe-leakfix --rounds 1 --cache '' "$rooms" cached.probe
refused 2 "--cache-renew needs --cache FILE" probe-leakfix --cache-renew "$rooms" dim.probe

# -- what leaks ------------------------------------------------------------------------------------
# figure SAID N: the N-th percentage of the row, in the last of its tables
figure() {
    grep "  $2  " "$1" | tail -n 1 | sed 's/^.*  '"$2"'  *//; s/([^)]*)//g' | cut -d '%' -f "$3"
}
probe-leakfix "$rooms" cells.probe >seen.probe 2>said
probe-error --tsv --points 20 --truth-rays 16 --paths 0 --leak-samples 400 "$rooms" seen.probe \
    2>err >report
tab=$(printf '\t')
of_error() { grep "^$1${tab}$2$tab" report | cut -f "$3"; }
check "what leaks is said, of all probes and by what is seen" \
    says said 'of all probes  *by what is seen' 'light that leaks  ' 'worst cell  *[0-9]* at '
awk -v all="$(figure said 'unseen weight' 1)" -v seen="$(figure said 'unseen weight' 2)" \
    -v low="$(of_error leak_volume all-probes 4)" -v high="$(of_error leak_volume all-probes 5)" \
    -v least="$(of_error leak_volume all 4)" -v most="$(of_error leak_volume all 5)" \
    'BEGIN { print all / 100, low, high, seen / 100, least, most }' >both
check "as probe-error says from other points" \
    every '$1 > $2 - 2 * ($3 - $2) && $1 < $3 + 2 * ($3 - $2) && $4 < $1 / 4 && $4 < 4 * $6' both
probe-cat --text seen.probe >seen.text
check "cells have their share" says seen.text '^table tet .*leak:f32:1'
probe-leakfix --points 0 "$rooms" cells.probe 2>said | probe-cat --text >unmeasured.text
check "--points 0 measures nothing" lacks said 'light that leaks' \
    and lacks unmeasured.text 'leak:f32' and says unmeasured.text 'sight:f32'

probe-leakfix -q --max-leak 0.5 "$rooms" cells.probe >gated.probe 2>err
check "--max-leak lets through what leaks no more" same_stream gated.probe seen.probe and empty err
probe-leakfix -q --no-sight --max-leak 0.0001 "$rooms" cells.probe >gated.probe 2>err
status=$?
check "what leaks more has a status of its own, and a message, and is written" [ $status = 3 ] \
    and says err 'light that leaks .* above --max-leak 0.0001; worst cell' \
    and probe-tet --verify gated.probe
probe-leakfix --max-leak 0.0001 --no-sight "$rooms" dark.probe >gated.probe 2>err
status=$?
check "without light the gate is of weight, and what is not known is left out" [ $status = 3 ] \
    and says err 'light that leaks  *not known' 'unseen weight .* above --max-leak'

# no surface near: nothing leaks, for certain
printf 'v 0 0 0\nv 0.001 0 0\nv 0 0.001 0\nf 1 2 3\n' >speck.obj
probe-place grid --spacing 1 --bounds 10,10,10,13,13,13 |
    probe-capture -q --sky 1,1,1 --rays 16 speck.obj | probe-tet >open.probe
probe-leakfix --max-leak 0 speck.obj open.probe 2>said >kept.probe
check "in the open nothing leaks, for certain" \
    [ $? = 0 ] and says said 'unseen weight  *0 % (0 \.\. 0)' 'worst cell  *none'

# A gap between two sheets that no probe is in, with cells through both.
for x in 0.35 0.65; do
    y=$([ $x = 0.35 ] && echo 50 || echo -50)
    printf 'v %s %s -50\n' $x $((-y)) $x $y
    printf 'v %s %s 50\n' $x $y $x $((-y))
done >sheets.obj
printf 'f 1 2 3 4\nf 5 6 7 8\n' >>sheets.obj
awk 'BEGIN { for (x = 0; x < 2; x++) for (y = 0; y < 4; y++) for (z = 0; z < 4; z++)
    print x, y, z }' >sides.txt
probe-place points -q sides.txt | probe-capture -q --sky 1,1,1 --rays 64 sheets.obj |
    probe-tet -q >gap.probe
probe-leakfix sheets.obj gap.probe >/dev/null 2>said
share=$(figure said 'see no probe' 1)
# all of x from 0.35 to 0.65
check "points of a gap see no probe: $share %, by its volume 30 %" \
    holds_number "$share" 29 31
# closed_box HALF: a closed room, twice that wide along x, that no probe is in
closed_box() {
    awk -v half="$1" 'BEGIN {
        for (i = 0; i < 8; i++)
            print "v", .5 + (i % 2 ? half : -half), int(i / 2) % 2 ? 2.4 : .6, i < 4 ? .6 : 2.4
        print "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4"
    }'
}
for half in .06 .2; do
    closed_box $half >box.obj
    probe-place points -q sides.txt | probe-tet -q | probe-leakfix box.obj >/dev/null 2>said$half
done
share=$(figure said.2 'see no probe' 1)
# .4 x 1.8 x 1.8 of 9, to its corners
check "a closed room that got no probe counts: $share %, by its volume 14.4 %" \
    holds_number "$share" 13.7 15.1
share=$(figure said.06 'see no probe' 1)
check "the void of a wall does not: $share %, by its volume 4.3 %" holds_number "$share" 0 .1
for budget in 1 8 100; do
    probe-leakfix --points 2000 --probes $budget sheets.obj gap.probe >more$budget.probe \
        2>said$budget
    more=$(($(row_count probe more$budget.probe) - 32))
    check "--probes $budget puts $more in, and less leaks" \
        [ $more -ge 1 ] and [ $more -le $budget ] and holds_number \
        "$(figure said$budget 'unseen weight' 2)" 0 "$(figure said 'unseen weight' 2)"
done
probe-cat --text --columns position more8.probe | sed '1,/^table probe/d; /^table/,$d; /^end/d' |
    tail -n +33 >added
check "they stand in the gap" every '$1 > 0.35 && $1 < 0.65' added
echo '0.5 1.5 1.5' | probe-query -q more8.probe - | cut -d ' ' -f 1 >in_gap
echo '0.1 1.5 1.5' | probe-query -q more8.probe - | cut -d ' ' -f 1 >beside
paste -d ' ' in_gap beside >gap_and_beside
check "and it is dark there, and not beside it" every '$1 < 0.05 * $2 && $2 > 1' gap_and_beside
for threads in 1 4; do
    probe-leakfix -q --points 2000 --probes 8 --threads $threads sheets.obj gap.probe \
        >threads$threads.probe
done
check "1 and 4 threads put the same in" cmp threads1.probe threads4.probe \
    and same_stream threads1.probe more8.probe
probe-leakfix -q --points 2000 --probes 100 --max-leak 5% sheets.obj gap.probe >enough.probe 2>err
check "no more than --max-leak needs" [ $? = 0 ] \
    and [ "$(row_count probe enough.probe)" -le "$(row_count probe more100.probe)" ]
probe-leakfix --points 2000 --probes 100 --max-leak 1 sheets.obj gap.probe >enough.probe 2>err
check "which may be none" [ "$(row_count probe enough.probe)" = 32 ]
probe-leakfix --points 2000 --probes 100 --max-probes 34 sheets.obj gap.probe >limited.probe 2>err
check "--max-probes bounds --probes, and that is said" [ "$(row_count probe limited.probe)" = 34 ] \
    and says err 'max-probes 34: 2 of --probes 100 went in'
probe-place points -q sides.txt | probe-tet -q >gap-dark.probe
probe-leakfix --points 2000 --probes 4 sheets.obj gap-dark.probe >mended.probe 2>err
check "probes without light are put where weight is unseen" \
    [ "$(row_count probe mended.probe)" -gt 32 ] and says err 'run probe-capture'

# Before a flat sheet sight is exact, but for what rounding leaves: that asks for no probe.
sed -n 's|^v 0.35|v 0.5|p' sheets.obj >sheet.obj
echo 'f 1 2 3 4' >>sheet.obj
probe-place points -q sides.txt | probe-capture -q --sky 1,1,1 --rays 64 sheet.obj |
    probe-tet -q >sheet.probe
probe-leakfix --probes 100 sheet.obj sheet.probe >more.probe 2>said
check "where only rounding leaks no probe goes in" [ "$(row_count probe more.probe)" = 32 ] \
    and holds_number "$(figure said 'unseen weight' 1)" 10 60 \
    and holds_number "$(figure said 'unseen weight' 2)" 1e-30 1e-4

# A curtain in folds, of which a probe mends little: a round counts by more points than chose it.
awk 'BEGIN { for (i = 0; i <= 60; i++) {
        z = 0.3 + 3.4 * i / 60; x = 3 + 0.12 * sin(12 * z)
        print "v", x, 0.05, z; print "v", x, 2.3, z }
    for (i = 1; i < 121; i += 2) print "f", i, i + 1, i + 3, i + 2 }' >curtain.obj
awk 'BEGIN { for (x = 0.5; x < 6; x += 0.8) for (y = 0.3; y < 2.5; y += 0.6)
    for (z = 0.3; z < 4; z += 0.7) print x, y, z }' >around.txt
probe-place points -q around.txt | probe-tet -q >curtain.probe
certified() {
    probe-leakfix --points 100000 curtain.obj "$1" 2>said >/dev/null
    figure said 'unseen weight' 2
}
if plain_build "what rounds leave of leaks"; then
    before=$(certified curtain.probe)
    for points in 500 1000; do
        probe-leakfix -q --points $points --probes 1 curtain.obj curtain.probe >more.probe
        after=$(certified more.probe)
        check "no round counts that leaves more: $before % unseen before, $after % after" \
            holds_number "$after" 1e-9 "$(awk -v b="$before" 'BEGIN { print 1.02 * b }')"
    done
    probe-leakfix --points 1000 --probes 60 curtain.obj curtain.probe >more.probe 2>err
    after=$(certified more.probe)
    check "after a round that was undone others are tried: $before % unseen, $after % after" \
        says err 'was undone' and \
        holds_number "$after" 1e-9 "$(awk -v b="$before" 'BEGIN { print 0.6 * b }')"
fi

# a sight that makes no sense is made anew
probe-cat --text seen.probe | awk '/^table/ { tet = /^table tet/ } tet && /^[0-9]/ {
    for (i = 9; i <= 20; i++) $i = "nan" } { print }' >nan.text
kept() { probe-cat --text --no-provenance --columns position,sight,stand_in,leak "$1"; }
probe-leakfix -q "$rooms" nan.text >anew.probe
kept anew.probe >anew.text
kept seen.probe >was.text
check "a sight of NaN is looked for anew" cmp anew.text was.text and differ nan.text seen.text \
    and says was.text 'sight:f32:12'

# a round that leaves no less is undone
if plain_build "a round that is undone"; then
    undone=0
    for round in 1 2 3 4 5 6 7 8; do
        probe-leakfix --no-sight --rounds $round --margin 0.01 --graze 0.01 --offset 0.001 \
            "$rooms" cells.probe >round$round.probe 2>err
        grep -q 'a round of [0-9]* probes was undone, since no less leaks' err || continue
        undone=$round
        break
    done
    check "a round after which no less leaks is undone: the $undone., and that is said" \
        [ $undone -gt 1 ]
    check "what comes is as it was before" \
        same_stream round$undone.probe round$((undone - 1)).probe \
        and probe-tet --verify round$undone.probe and all_lit round$undone.probe
fi

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
refused 2 "--max-leak needs --points" probe-leakfix --points 0 --max-leak 0.1 "$rooms" cells.probe
refused 2 "--probes needs --points" probe-leakfix --points 0 --probes 1 "$rooms" cells.probe
refused 2 "--points: expected 0 or at least 100" probe-leakfix --points 3 "$rooms" cells.probe
refused 2 "--max-leak: expected a share from 0 to 1, or a percentage as in 10%, got '101%'" \
    probe-leakfix --max-leak 101% "$rooms" cells.probe
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
refused 1 "max-leak is of what leaks in cells: the cell is a point" \
    probe-leakfix --max-leak 1 "$rooms" one.probe
tap_done
