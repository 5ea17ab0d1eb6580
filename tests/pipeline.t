#!/bin/sh
# The whole pipe as users run it, on the bundled scenes: it works in one line, gives the same bytes
# for any number of threads and in both encodings, does not depend on the order of the probes, and a
# failure anywhere leaves nothing that passes for whole.
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
    check "$name: the pipe gives a whole stream" sh -c "probe-cat --info $name.probe | grep -q tet"
    probe-cat --text --tables probe "$name.probe" | grep -v '^#' >"$name.txt"
    check "$name: no probe is left without light" sh -c "! grep -q nan $name.txt"
    probe-cat --text --columns position,sh --tables probe "$name.probe" |
        awk '/^-?[0-9]/ { n++; if ($4 > 0) lit++ } END { exit !(n > 20 && lit > n / 2) }'
    if [ $? -eq 0 ]; then pass "$name: most probes are lit"; else fail "$name: most probes are lit"; fi
done

for threads in 1 2 4; do
    bake "$rooms" "$threads" binary "threads$threads.probe"
done
check "1 and 2 threads give the same bytes" cmp threads1.probe threads2.probe
check "1 and 4 threads give the same bytes" cmp threads1.probe threads4.probe
bake "$rooms" 2 text text.probe
probe-cat --no-provenance --text threads2.probe >from-binary.txt
probe-cat --no-provenance --text text.probe >from-text.txt
check "text and binary pipes say the same" cmp from-binary.txt from-text.txt
check "binary is binary, text is text" sh -c "head -n 1 threads2.probe | grep -qa 'binary' && ! head -n 1 text.probe | grep -q 'binary'"

# The same probes in another order: the same light at every point.
probe-place grid --quiet --count 100 --text "$rooms" | grep -v '^[#a-z]' >points.txt
sort points.txt >sorted.txt
awk '{ print $1 * 0.97 + 0.01, $2 * 0.97 + 0.01, $3 * 0.97 + 0.01 }' points.txt >asked.txt
for order in points sorted; do
    probe-place points --quiet "$order.txt" | probe-capture --quiet --rays 32 "$rooms" | probe-tet --quiet >"$order.probe"
    probe-query "$order.probe" <asked.txt >"$order.light"
done
check "the order of the probes does not change the light" cmp points.light sorted.light

# A scene that takes back light from nowhere: the header says how the probes were made.
check "the provenance names every stage" sh -c "probe-cat --text threads2.probe | sed '/^table/q' |
    grep -cE '^# probe-(place|capture|tet|leakfix)( |$)' | grep -qx 4"

# A stage that fails: the next refuses what it got.
: >empty.obj
probe-place grid --quiet --spacing 1 empty.obj 2>err1 | probe-capture --quiet "$rooms" >out 2>err2
check "an empty scene is refused with its name" grep -q 'empty.obj' err1
check "the next stage refuses what it got" grep -q 'stdin' err2
check "nothing that passes for whole came out" sh -c "! tail -n 1 out | grep -aq '^end'"

# No light at all is legal, and said.
probe-place grid --quiet --bounds 0,0,0,1,1,1 --spacing 0.5 >dark-placed.probe
cat >dark.obj <<'OBJ'
v 0 -1 0
v 1 -1 0
v 0 -1 1
f 1 2 3
OBJ
probe-capture --rays 16 --text dark.obj dark-placed.probe >dark.probe 2>err
check "a scene without light is captured" grep -q '^end' dark.probe
check "and warned about" grep -qi 'warning.*light' err

tap_done
