#!/bin/sh
# probe-leakfix as users run it.
. "${SRC:?}/tests/support/setup.sh"
rooms=$SRC/scenes/two-rooms.obj
probe-place grid -q --count 120 "$rooms" | probe-capture -q --rays 32 --bounces 4 "$rooms" | probe-tet >cells.probe

probe-leakfix "$rooms" cells.probe >baked.probe 2>said
before=$(sed -n 's/.*before: \([0-9]*\) of .*/\1/p' said)
after=$(sed -n 's/.*after: \([0-9]*\) of .*/\1/p' said)
if [ "${before:-0}" -gt 10 ] && [ "${after:-99}" -lt $((before / 10)) ]; then
    pass "leaking edges: $before before, $after after"
else
    fail "leaking edges: $before before, $after after" "$(cat said)"
fi
check "the cells are sound" probe-tet --verify baked.probe
check "every probe has light" sh -c "! probe-cat --text baked.probe | grep -q nan"
check "the cells' edges are marked" sh -c "probe-cat --text baked.probe | grep -q '^table tet .*occlusion:i32:6'"
for threads in 1 2 4; do probe-leakfix -q --threads $threads "$rooms" cells.probe >t$threads.probe; done
check "1, 2 and 4 threads give the same bytes" sh -c "cmp t1.probe t2.probe && cmp t1.probe t4.probe"
# New probes have the light that probe-capture gives at their places.
probe-cat --text --tables probe --columns position baked.probe | grep '^[0-9-]' >all.txt
probe-place points all.txt | probe-capture -q --rays 32 --bounces 4 "$rooms" | probe-cat --text --no-provenance --tables probe --columns position,sh |
    grep '^[0-9-]' >captured.txt
probe-cat --text --no-provenance --tables probe --columns position,sh baked.probe | grep '^[0-9-]' >baked.txt
check "new probes are captured as the others were" cmp captured.txt baked.txt

# The same where they were captured in a scene of fewer triangles; leaks are looked for in the whole scene.
probe-cat --tables probe --columns position cells.probe | probe-capture --again -q --rays 32 --bounces 4 --decimate .6 "$rooms" | probe-tet >few.probe
check "leaks are those of the whole scene" sh -c "probe-leakfix '$rooms' few.probe 2>err >fewer.probe; grep edges said >x; grep edges err | cmp - x"
probe-place points all.txt | probe-capture -q --rays 32 --bounces 4 --decimate .6 "$rooms" |
    probe-cat --text --no-provenance --tables probe --columns position,sh | grep '^[0-9-]' >captured.txt
probe-cat --text --no-provenance --tables probe --columns position,sh fewer.probe | grep '^[0-9-]' >fewer.txt
check "new probes are captured in the scene that the others were captured in" sh -c "cmp captured.txt fewer.txt && ! cmp -s fewer.txt baked.txt"

# Light at the far side of the wall, beside it, low in the dark room: less than before it was mended, as behind a closed wall.
awk 'BEGIN { for (i = 0; i < 20; i++) print 4.3, 0.6 + i * .09, 0.5, 1, 0, 0 }' >behind.txt
probe-query -q cells.probe behind.txt | awk '{ s += $1 } END { print s }' >leaky
probe-query -q baked.probe behind.txt | awk '{ s += $1 } END { print s }' >mended
check "less light comes through the wall" awk 'NR == FNR { leaky = $1; next } { exit !($1 < 0.7 * leaky) }' leaky mended

probe-leakfix --rounds 0 "$rooms" cells.probe >counted.probe 2>err
check "--rounds 0 only counts" sh -c "[ \$(probe-cat --info counted.probe | grep -c \"table probe: \$(probe-cat --info cells.probe | sed -n 's/table probe: //p')\") -eq 1 ]"
check "--quiet says nothing" sh -c "[ -z \"\$(probe-leakfix -q '$rooms' cells.probe 2>&1 >/dev/null)\" ]"
probe-leakfix --max-probes 105 "$rooms" cells.probe >limited.probe 2>err
check "--max-probes stops it, and says so" grep -q 'max-probes' err
probe-place grid -q --count 120 "$rooms" | probe-tet >dark.probe
probe-leakfix "$rooms" dark.probe >fixed.probe 2>err
check "probes without light get none, with a note" grep -q 'run probe-capture' err
probe-leakfix --rounds 1 "$SRC/scenes/cornell-box.obj" cells.probe 2>err >/dev/null
check "another scene is warned about" grep -q 'not the scene' err

refused 1 "run probe-tet" sh -c "probe-place grid -q --count 20 '$rooms' | probe-leakfix '$rooms'"
mkdir alone && cp "$BUILD/src/probe-leakfix" alone/
refused 1 "probe-tet" sh -c "PATH=/nowhere alone/probe-leakfix -q '$rooms' cells.probe"
refused 1 "expected a probe stream, got nothing" sh -c "probe-leakfix '$rooms' </dev/null"
head -c 3000 cells.probe >cut.probe
refused 1 "cut.probe" probe-leakfix "$rooms" cut.probe
refused 1 "No space left" sh -c "probe-leakfix -q '$rooms' cells.probe >/dev/full"
refused 2 "--margin" probe-leakfix --margin 2 "$rooms" cells.probe
refused 2 "SCENE" probe-leakfix
# Probes in a plane, a tilted one too, on a line, two of them and one: what leaks past the wall is mended within the plane
# or line; or there is nothing to look along.
awk 'BEGIN { for (x = 0; x < 8; x++) for (z = 0; z < 4; z++) print x + .25, 1.25, z + .375 }' >plane.txt
awk 'BEGIN { for (x = 0; x < 8; x++) for (z = 0; z < 4; z++) print x + .25, .75 + x / 8 + z / 4, z + .375 }' >tilted.txt
awk 'BEGIN { for (x = 0; x < 8; x++) print x + .25, 1.25, 3.5 }' >line.txt
printf '1 1.25 3.5\n7 1.25 3.5\n' >two.txt
printf '1 1.25 3.5\n' >one.txt
for flat in plane:tri:3 tilted:tri:3 line:segment:1 two:segment:1; do
    name=${flat%%:*}
    table=${flat#*:}
    edges=${table#*:}
    table=${table%:*}
    probe-place points -q $name.txt | probe-capture -q --rays 16 --bounces 2 "$rooms" | probe-tet -q >$name.probe
    check "$name: its cells are those of table $table" sh -c "probe-cat --text $name.probe | grep -q '^table $table '"
    check "$name: --rounds 0 marks the edges" sh -c "probe-leakfix --rounds 0 '$rooms' $name.probe 2>said | probe-cat --text >marked.probe
        grep -q '^table $table .*occlusion:i32:$edges' marked.probe"
    probe-leakfix "$rooms" $name.probe >mended.probe 2>said
    before=$(sed -n 's/.*before: \([0-9]*\) of .*/\1/p' said)
    after=$(sed -n 's/.*after: \([0-9]*\) of .*/\1/p' said)
    check "$name: leaking edges: $before before, $after after" test "${before:-0}" -gt 0 -a "${after:-99}" -lt "${before:-0}"
    check "$name: they are those of table $table still" sh -c "probe-cat --text mended.probe | grep -q '^table $table '"
    check "$name: the cells are sound, and every probe has light" sh -c "probe-tet --verify mended.probe && ! probe-cat --text mended.probe | grep -q nan"
    check "$name: mended, it answers on both sides of the wall" sh -c "printf '3.5 1.2 3.5\n4.5 1.2 3.5\n' | probe-query -q mended.probe | awk '{ v[NR] = \$1 } END { exit !(v[1] > 2 * v[2] && v[2] > 0) }'"
done
probe-place points -q one.txt | probe-capture -q --rays 16 --bounces 2 "$rooms" | probe-tet -q >one.probe
check "one probe: there is nothing to look along" sh -c "probe-leakfix '$rooms' one.probe 2>said >mended.probe && grep -q '0 of 0 edges leak' said &&
    probe-cat --text --no-provenance one.probe >a && probe-cat --text --no-provenance mended.probe | cmp a -"
tap_done
