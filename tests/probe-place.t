#!/bin/sh
# probe-place as users run it.
. "${SRC:?}/tests/setup.sh"
rooms=$SRC/scenes/two-rooms.obj

positions() { grep -v '^[#a-z]' "$1"; }

check "a grid by count" sh -c "probe-place grid -q --count 100 --text '$rooms' >grid.probe"
check "is a whole stream of at most 100 probes" sh -c "probe-cat --info grid.probe | grep -qE 'table probe: ([1-9][0-9]?|100) rows'"
check "a grid by spacing and bounds, without a scene" sh -c "probe-place grid --spacing 1,2,4 --bounds 0,0,0,4,4,4 --text >box.probe"
check "has 4 x 2 x 1 probes" sh -c "[ \$(grep -c '^[0-9]' box.probe) -eq 8 ] && grep -qx '0.5 1 2' box.probe"
printf '# two\n1 2 3\n\n-4 5e1 .5\n' >points.txt
check "points come as they are" sh -c "probe-place points points.txt --text | grep -qx -- '-4 50 0.5'"
check "from standard input as well" sh -c "probe-place points - --text <points.txt | grep -qx '1 2 3'"
printf '0 0 0\n10 0 0\n' | probe-place path - --step 2.5 --text >path.probe
check "a path has its ends and its steps" sh -c "grep -qx '0 0 0' path.probe && grep -qx '2.5 0 0' path.probe && grep -qx '10 0 0' path.probe"

# A cube of 2 in a grid of 4: the inside goes, stays, or is marked.
cat >cube.obj <<'OBJ'
v 1 1 1
v 3 1 1
v 3 3 1
v 1 3 1
v 1 1 3
v 3 1 3
v 3 3 3
v 1 3 3
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
OBJ
grid="probe-place grid --spacing 1 --bounds 0,0,0,4,4,4 --text"
$grid cube.obj >dropped.probe 2>err
check "8 of 64 probes inside a cube are dropped" sh -c "[ \$(grep -c '^[0-9]' dropped.probe) -eq 56 ] && grep -q '8 of 64' err"
check "or kept" sh -c "[ \$($grid --inside keep cube.obj | grep -c '^[0-9]') -eq 64 ]"
$grid -q --inside mark cube.obj | probe-cat --columns position,inside >marked.probe
check "or marked: 1 for the 8, 0 for the others" sh -c "grep -q '^table probe inside:i32:1 position:f64:3' marked.probe &&
    [ \$(grep -c '^1 [12].5 [12].5 [12].5\$' marked.probe) -eq 8 ] && [ \$(grep -c '^0 ' marked.probe) -eq 56 ]"
probe-place grid -q --spacing 1 --bounds 0,0,0,4,4,4 --threads 1 cube.obj >one.probe
probe-place grid -q --spacing 1 --bounds 0,0,0,4,4,4 --threads 3 cube.obj >three.probe
check "any number of threads gives the same bytes" cmp one.probe three.probe

refused 1 "all 8 probes are inside solids" probe-place grid --spacing .5 --bounds 1.5,1.5,1.5,2.5,2.5,2.5 cube.obj
refused 1 "1000000000 probes" probe-place grid --spacing .001 --bounds 0,0,0,1,1,1
check "unless --max-probes says so" sh -c "probe-place grid --spacing .01 --bounds 0,0,0,1,1,1.1 --max-probes 1200000 >/dev/null"
refused 2 "expected a method grid, points or path, got 'net'" probe-place net "$rooms"
refused 2 "expected either --spacing or --count" probe-place grid "$rooms"
refused 2 "expected either --spacing or --count" probe-place grid --spacing 1 --count 3 "$rooms"
refused 2 "expected a SCENE or --bounds" probe-place grid --spacing 1
refused 2 "expected --step" probe-place path points.txt
refused 2 "greater than 0, got 0" probe-place grid --spacing 0 "$rooms"
refused 2 "above" probe-place grid --spacing 1 --bounds 1,0,0,0,1,1
refused 1 "nothing.obj" probe-place grid --count 10 nothing.obj
: >empty.obj
refused 1 "empty.obj" probe-place grid --count 10 empty.obj
printf '1 2\n' >short.txt
refused 1 "short.txt:1: expected x y z" probe-place points short.txt
printf '1 2 x\n' >rubbish.txt
refused 1 "rubbish.txt:1: expected a number, got 'x'" probe-place points rubbish.txt
printf '1 2 nan\n' >nan.txt
refused 1 "nan.txt:1: expected finite numbers, got nan" probe-place points nan.txt
: >none.txt
refused 1 "none.txt: expected at least one position" probe-place points none.txt
refused 1 "No space left" sh -c "probe-place points points.txt >/dev/full"
tap_done
