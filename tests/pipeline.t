#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The whole pipe as users run it, on the bundled scenes: it works in one line, gives the same bytes
# for any number of threads and in both encodings, does not depend on the order of the probes, and a
# failure anywhere leaves nothing that passes for whole.
looks_for_leaks=yes
. "${SRC:?}/tests/support/setup.sh"

scenes=$SRC/scenes
rooms=$scenes/two-rooms.obj

# bake SCENE THREADS ENCODING FILE: the pipeline of README.
bake() {
    probe-place grid --quiet --count 350 --"$3" "$1" |
        probe-capture --quiet --threads "$2" --rays 64 --bounces 3 "$1" |
        probe-tet --quiet |
        probe-leakfix --quiet --threads "$2" --rounds 2 "$1" >"$4"
}

for scene in "$scenes"/*.obj "$scenes"/*.gltf; do
    name=${scene##*/}
    bake "$scene" 2 binary "$name.probe"
    check "$name: the pipe gives a whole stream" \
        into info probe-cat --info "$name.probe" and says info tet
    probe-cat --text --tables probe "$name.probe" | grep -v '^#' >text
    check "$name: no probe is left without light" says text '^[0-9-]' and lacks text nan
    rows_of position,sh "$name.probe" |
        awk '{ n++ } $4 > 0 { lit++ } END { print n + 0, lit + 0 }' >lit
    check "$name: most probes are lit" every '$1 > 20 && $2 > $1 / 2' lit
done

for threads in 1 2 4; do
    bake "$rooms" "$threads" binary "threads$threads.probe"
done
check "1 and 2 threads give the same bytes" \
    cmp threads1.probe threads2.probe and test -s threads1.probe
check "1 and 4 threads give the same bytes" \
    cmp threads1.probe threads4.probe and test -s threads1.probe
bake "$rooms" 2 text text.probe
check "text and binary pipes say the same" same_stream threads2.probe text.probe
for encoding in threads2 text; do head -n 1 $encoding.probe >$encoding.head; done
check "binary is binary, text is text" \
    says threads2.head binary and says text.head '^#?probe' and lacks text.head binary

# The same probes in another order: the same light at every point.
probe-place grid --quiet --count 100 --text "$rooms" | numbers >points.txt
sort points.txt >sorted.txt
awk '{ print $1 * 0.97 + 0.01, $2 * 0.97 + 0.01, $3 * 0.97 + 0.01 }' points.txt >asked.txt
for order in points sorted; do
    probe-place points --quiet "$order.txt" | probe-capture --quiet --rays 32 "$rooms" |
        probe-tet --quiet >"$order.probe"
    probe-query "$order.probe" <asked.txt >"$order.light"
done
check "the order of the probes does not change the light" \
    cmp points.light sorted.light and test -s points.light

# The header says how the probes were made.
probe-cat --text threads2.probe | sed '/^table/q' |
    grep -cE '^# probe-(place|capture|tet|leakfix)( |$)' >stages
check "the provenance names every stage" [ "$(cat stages)" = 4 ]

# A stage that fails: the next refuses what it got.
: >empty.obj
probe-place grid --quiet --spacing 1 empty.obj 2>err1 |
    probe-capture --quiet "$rooms" >out 2>err2
tail -n 1 out >last
check "an empty scene is refused with its name" says err1 'empty.obj'
check "the next stage refuses what it got" says err2 'stdin'
check "nothing that passes for whole came out" lacks last '^end'

# No light at all is legal, and said.
probe-place grid --quiet --bounds 0,0,0,1,1,1 --spacing 0.5 >dark-placed.probe
printf '%s\n' 'v 0 -1 0' 'v 1 -1 0' 'v 0 -1 1' 'f 1 2 3' >dark.obj
probe-capture --rays 16 --text dark.obj dark-placed.probe >dark.probe 2>err
check "a scene without light is captured" says dark.probe '^end'
check "and warned about" says err '[wW]arning.*light'
tap_done
