#!/bin/sh
# probe-place as users run it.
. "${SRC:?}/tests/support/setup.sh"
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

# -- vertices --------------------------------------------------------------------------------------
# each STREAM CONDITION: every row passes it, and there are rows
each() { probe-cat --text "$1" | awk '/^[0-9-]/ { rows++; if (!('"$2"')) bad = 1 } END { exit bad || !rows }'; }
# holds STREAM ROWS
holds() { [ "$(probe-cat --text "$1" | grep -c '^[0-9-]')" -eq "$2" ]; }
probe-place vertices --offset .25 --text cube.obj >vertices.probe
check "a cube has 24 vertices, three at each corner" holds vertices.probe 24
check "which stand off their faces, along axes" each vertices.probe '$4 * $4 + $5 * $5 + $6 * $6 == 1 && ($4 == 0) + ($5 == 0) + ($6 == 0) == 2 &&
    ($1 - 2) * $4 + ($2 - 2) * $5 + ($3 - 2) * $6 == 1.25 && ($1 - 2) ^ 2 + ($2 - 2) ^ 2 + ($3 - 2) ^ 2 == 1.25 ^ 2 + 2'
check "four on each face" sh -c "[ \$(grep '^[0-9-]' vertices.probe | cut -d ' ' -f 4-6 | sort | uniq -c | grep -c '^ *4 ') -eq 6 ]"
{ grep '^v' cube.obj; grep '^f' cube.obj | tac; } >turned.obj
check "whatever the order of the faces" sh -c "grep '^[0-9]' vertices.probe | sort >wanted
    probe-place vertices --offset .25 --text turned.obj | grep '^[0-9]' | sort | cmp - wanted"
probe-place vertices --crease 180 --text cube.obj >corners.probe
check "without creases it has 8" holds corners.probe 8
check "whose normals do not depend on how its faces are cut into triangles" each corners.probe '$4 * $4 == 0.57735026 ^ 2 && $5 * $5 == $4 * $4 &&
    $6 * $6 == $4 * $4 && ($1 - 2) * $4 > 0 && ($2 - 2) * $5 > 0 && ($3 - 2) * $6 > 0'
check "by default the offset is 0.001 of the diagonal" each corners.probe '(d = sqrt(($1 - 2) ^ 2 + ($2 - 2) ^ 2 + ($3 - 2) ^ 2) - sqrt(3) * 1.002) < 1e-12 && d > -1e-12'

# A prism of six sides, which turn by 60 degrees, without its ends; each side has corners of its own.
awk 'BEGIN { for (i = 0; i < 6; i++) for (k = 0; k < 2; k++) for (z = 0; z < 2; z++) {
        a = (i + k) % 6 * 3.14159265358979323846 / 3; printf "v %.17g %.17g %d\n", cos(a), sin(a), z }
    for (i = 0; i < 6; i++) printf "f %d %d %d %d\n", 4 * i + 1, 4 * i + 3, 4 * i + 4, 4 * i + 2 }' >prism.obj
probe-place vertices prism.obj >prism.probe
check "a crease of just --crease is smooth: corners of six sides are welded" holds prism.probe 12
check "and their normals look outward along the corners" each prism.probe '$6 == 0 && (d = $1 * $4 + $2 * $5 - sqrt($1 * $1 + $2 * $2)) < 1e-7 && d > -1e-7'
probe-place vertices --crease 59.99 prism.obj >prism.probe
check "a sharper one is not" holds prism.probe 24

# A sphere of 24 by 12, every triangle with corners of its own.
awk 'function v(i, j) { s = j % 12 ? sin(j * pi / 12) : 0; printf "v %.17g %.17g %.17g\n", 5 + s * cos(i % 24 * pi / 12), s * sin(i % 24 * pi / 12), cos(j * pi / 12) }
    function f(a, b, c, d, e, g) { v(a, b); v(c, d); v(e, g); print "f -3 -2 -1" }
    BEGIN { pi = 3.14159265358979323846
        for (i = 0; i < 24; i++) for (j = 0; j < 12; j++) {
            if (j < 11) f(i, j, i, j + 1, i + 1, j + 1)
            if (j > 0) f(i, j, i + 1, j + 1, i + 1, j) } }' >sphere.obj
probe-place vertices --offset .5 sphere.obj >sphere.probe
check "a sphere has one probe a vertex" holds sphere.probe 266
check "whose normal points away from the centre" each sphere.probe '($1 - 5) * $4 + $2 * $5 + $3 * $6 > 1.5 * 0.9999'

printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\nf 1 2 2\n' >sheet.obj
probe-place vertices -q --text sheet.obj >sheet.probe
check "a sheet with faces on both sides has probes on both" sh -c "[ \$(grep -c ' 0 0 1$' sheet.probe) -eq 3 ] &&
    [ \$(grep -c ' 0 0 -1$' sheet.probe) -eq 3 ] && [ \$(grep -c '^[0-9-]' sheet.probe) -eq 6 ]"

# The triangle (0 0 0) (1 0 0) (0 1 0), once as it stands and once mirrored in x.
triangle=$(printf '\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\077\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\077\0\0\0\0' | base64)
cat >mirror.gltf <<JSON
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}], "nodes": [{"mesh": 0}, {"mesh": 0, "scale": [-1, 1, 1]}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,$triangle"}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}]}
JSON
probe-place vertices --text mirror.gltf >mirror.probe
check "instances are placed, and welded with each other" holds mirror.probe 4
check "and keep their front when mirrored" each mirror.probe '$4 == 0 && $5 == 0 && $6 == 1'

{ cat cube.obj; sed 's/ 3/ 4/g; s/ 1/ 2/g' cube.obj | grep '^v'
    grep '^f' cube.obj | awk '{ print $1, $2 - 9, $3 - 9, $4 - 9, $5 - 9 }'; } >cubes.obj
check "probes inside solids stay" sh -c "[ \$(probe-place vertices --text cubes.obj | grep -c '^[0-9]') -eq 48 ]"
check "unless told otherwise" sh -c "[ \$(probe-place vertices -q --inside drop --text cubes.obj | grep -c '^[0-9]') -eq 42 ]"
probe-place vertices -q --inside drop --threads 1 cubes.obj >one.probe
probe-place vertices -q --inside drop --threads 3 cubes.obj >three.probe
check "on any number of threads alike" cmp one.probe three.probe
probe-capture -q --sky 1,1,1 --rays 64 --columns none cube.obj vertices.probe >lit.probe
check "probe-capture takes them as surfaces: under an even sky of 1 a cube receives pi" sh -c "
    grep -q '^table probe position:f64:3 normal:f32:3 irradiance:f32:3$' lit.probe"
check "everywhere" each lit.probe '$7 > 3.14159 && $7 < 3.1416 && $8 == $7 && $9 == $7'

refused 2 "vertices: expected a SCENE" probe-place vertices
refused 2 "go with the method vertices" probe-place grid --spacing 1 --offset 1 cube.obj
refused 2 "go with the method vertices" probe-place points --crease 1 points.txt
refused 2 "--spacing, --count and --bounds go with" probe-place vertices --spacing 1 cube.obj
refused 2 "--step goes with" probe-place vertices --step 1 cube.obj
refused 2 "unexpected operand 'x'" probe-place vertices cube.obj x
refused 2 "--offset" probe-place vertices --offset 0 cube.obj
refused 2 "--crease" probe-place vertices --crease 181 cube.obj
refused 1 "this makes 24 probes, more than --max-probes 23" probe-place vertices --max-probes 23 cube.obj

refused 1 "all 8 probes are inside solids" probe-place grid --spacing .5 --bounds 1.5,1.5,1.5,2.5,2.5,2.5 cube.obj
refused 1 "1000000000 probes" probe-place grid --spacing .001 --bounds 0,0,0,1,1,1
check "unless --max-probes says so" sh -c "probe-place grid --spacing .01 --bounds 0,0,0,1,1,1.1 --max-probes 1200000 >/dev/null"
refused 2 "expected a method grid, points, path or vertices, got 'net'" probe-place net "$rooms"
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
