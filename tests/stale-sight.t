#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What cells keep of sight (probe-leakfix) is used as long as it is true: of these surfaces, these
# probes and cells. What is not is left out, and said once.
. "${SRC:?}/tests/support/setup.sh"
rooms=$SRC/scenes/two-rooms.obj
cp "$SRC/scenes/two-rooms.mtl" .
sed 's/^v 4 /v 4.01 /' "$rooms" >moved.obj # a side of the wall
sed 's/^Kd .*/Kd .5 .5 .5/' two-rooms.mtl >grey.mtl
sed 's/two-rooms.mtl/grey.mtl/' "$rooms" >grey.obj

probe-place grid -q --count 60 "$rooms" >places.probe
capture() { probe-capture -q --rays 8 --bounces 1 "$@"; }
capture "$rooms" places.probe | probe-tet -q >cells.probe
probe-leakfix -q "$rooms" cells.probe >seen.probe
probe-cat --text seen.probe >seen.text
check "the header says what sight is true of" \
    says seen.text '^sight-scene [0-9a-f]*$' '^sight-cells [0-9a-f]*$'
echo '3.7 1.4 1.2' >point.txt
probe-query --visible all -q seen.probe point.txt >all
probe-query seen.probe point.txt >kept 2>said
check "it is used while it is true, and nothing is said" differ all kept and empty said

# -- surfaces --------------------------------------------------------------------------------------
# again NAME OPTION... SCENE: seen.probe captured again
again() {
    again_name=$1
    shift
    probe-capture --again --rays 8 --bounces 1 "$@" seen.probe 2>said >"$again_name.probe"
    probe-cat --text "$again_name.probe" >text
}
again same "$rooms"
check "the same scene again keeps it" says text 'sight:f32:12' '^sight-scene' and lacks said sight
again sun --sun 0,-1,0,1,1,1 "$rooms"
check "so does the scene in other light" \
    says text 'sight:f32:12' '^sight-scene' and lacks said sight
again grey grey.obj
check "and in other colours" says text 'sight:f32:12' '^sight-scene' and lacks said sight
again few --decimate .9 "$rooms"
check "and decimated" says text 'sight:f32:12' '^sight-scene' and lacks said sight
again moved moved.obj
check "another place of a wall drops it, and says so" \
    says text '^table tet vertex:i32:4 neighbour:i32:4$' and lacks text '^sight-' \
    and says said 'moved.obj.*of other surfaces: left out (probe-leakfix'
probe-query moved.probe point.txt 2>said >light
check "that is not said again" empty said and test -s light
probe-tet -q places.probe | probe-leakfix -q "$rooms" >dark.probe
probe-capture --rays 8 --bounces 1 moved.obj dark.probe 2>said | probe-cat --text >dark.text
check "what probe-error marked goes as well" \
    into marked.probe probe-error -q -n 4 --truth-rays 8 --paths 0 -o - "$rooms" seen.probe and \
    into text probe-cat --text marked.probe and says text 'sight:f32:12.* leak:f32' and \
    into again.probe capture --again moved.obj marked.probe and \
    into text probe-cat --text again.probe and lacks text ' leak[_:]' and says text '^table tet'
check "so it does of probes that had no light" \
    says dark.text '^table tet' and lacks dark.text 'sight:f32' \
    and says said 'of other surfaces: left out'

# Looked at in a scene that it is not of, it is what a game has, and that is said.
probe-leakfix -q moved.obj cells.probe >elsewhere.probe
probe-error -n 4 --truth-rays 8 --paths 0 --leak-samples 0 "$rooms" elsewhere.probe >out 2>said
check "probe-error says that sight is of other surfaces" \
    says said 'two-rooms.obj: what cells keep .* is of other surfaces (probe-leakfix' \
    and test -s out
probe-render --size 8x8 --samples 1 -o elsewhere.png "$rooms" elsewhere.probe 2>said
check "so does probe-render" says said 'two-rooms.obj: what cells keep .* is of other surfaces'
probe-cat --drop sight,stand_in elsewhere.probe >blind.probe
probe-error -n 4 --truth-rays 8 --paths 0 --leak-samples 0 "$rooms" blind.probe >out 2>said
check "where there is none, nothing is said" lacks said surfaces and test -s out

# -- probes and cells ------------------------------------------------------------------------------
# Who writes the text can change all of it: a place, the corners of a cell.
awk '/^table/ { in_probes = /^table probe/; print; next }
    in_probes { $1 += .001; in_probes = 0 } 1' seen.text >shifted.probe
awk '/^table/ { in_cells = /^table tet/; print; next }
    in_cells { swap = $1; $1 = $2; $2 = $3; $3 = swap; swap = $5; $5 = $6; $6 = $7; $7 = swap
        in_cells = 0 } 1' seen.text >turned.probe
for changed in shifted turned; do
    probe-query --visible all -q $changed.probe point.txt >all
    probe-query $changed.probe point.txt >light 2>said
    check "$changed: sight is left out, with a warning" \
        cmp light all and says said 'of other probes or cells: left out (probe-leakfix' \
        and has_lines 1 said
done
probe-query -q shifted.probe point.txt 2>said >light
check "--quiet says nothing" empty said and test -s light
probe-query --pack half shifted.probe -o packed 2>said
probe-query packed point.txt >light 2>err
check "a packed file is made without it" says said 'left out' and empty err and test -s light
probe-error -n 4 --truth-rays 8 --paths 0 --leak-samples 0 "$rooms" shifted.probe >report 2>said
check "probe-error says so" says said 'of other probes or cells: left out' and test -s report
probe-render --size 8x8 --samples 1 -o picture.png "$rooms" shifted.probe 2>said >out
check "probe-render says so" says said 'of other probes or cells: left out' and test -s picture.png
probe-vtk --text -o cells.vtu shifted.probe 2>said
check "probe-vtk says so, and writes none" \
    says said 'of other probes or cells: left out' and lacks cells.vtu '"sight"'
probe-leakfix "$rooms" shifted.probe 2>said | probe-cat --text >text
probe-query text point.txt 2>err >light
check "probe-leakfix looks anew" says text 'sight:f32:12' and empty err and lacks said 'left out'

# Keys go where cells go.
probe-cat -q --text seen.probe dark.probe 2>said >text
check "merged streams have none" lacks text '^sight-' and lacks said 'sight-'
probe-cat -q --text --rows 0:10 seen.probe >text
check "nor have some of the probes" lacks text '^sight-' and says text '^table probe'
probe-cat --text --fill seen.probe cells.probe >text 2>said
check "nor what is filled from a stream that has" lacks text '^sight-' and empty said
probe-tet -q seen.probe | probe-cat --text >text
check "nor cells that are made anew" lacks text '^sight-' and says text '^table tet'

# -- missing values --------------------------------------------------------------------------------
probe-cat --text --columns position,sh,vertex,neighbour,sight,stand_in seen.probe |
    awk '/^table/ { in_cells = /^table tet/; print; next }
        in_cells { for (i = 9; i <= 20; i++) $i = "nan"; in_cells = 0 } 1' >holes.probe
refused 1 "holes.probe: cell 0: sight is not finite" probe-query holes.probe point.txt
probe-query --visible rays --scene "$rooms" seen.probe point.txt >rays
check "rays need none of it" \
    into light probe-query --visible rays --scene "$rooms" holes.probe point.txt and cmp light rays
tap_done
