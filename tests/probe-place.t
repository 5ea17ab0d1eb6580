#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-place as users run it.
. "${SRC:?}/tests/support/setup.sh"
rooms=$SRC/scenes/two-rooms.obj

# of STREAM: its rows as text, in rows
of() { probe-cat --text "$1" | numbers >rows; }
# each STREAM CONDITION: every row passes it, and there are rows
each() {
    of "$1"
    every "$2" rows
}
# holds STREAM ROWS
holds() {
    of "$1"
    has_lines "$2" rows
}
# among PATTERN COUNT: so many of these rows
among() { [ "$(grep -c "$1" rows)" -eq "$2" ]; }

# -- grids, points, paths --------------------------------------------------------------------------
check "a grid by count" into grid.probe probe-place grid -q --count 100 --text "$rooms"
count=$(row_count probe grid.probe)
check "is a whole stream of at most 100 probes" [ "$count" -ge 1 ] and [ "$count" -le 100 ]
check "a grid by spacing and bounds, without a scene" into box.probe \
    probe-place grid --spacing 1,2,9 --clearance .5 --bounds 0,0,0,4,4,4 --text
check "has 4 x 3 x 1 probes, .5 from its faces" \
    holds box.probe 12 and says rows '^0.5 0.5 2$' '^3.5 2 2$'
probe-place grid --spacing 1.5 --bounds 0,0,0,4,4,4 --text >box.probe
check "by default they are a tenth of what is between two" \
    holds box.probe 64 and says rows '^0.125 0.125 0.125$' '^3.875 1.375 2.625$'
printf '%s\n' '# two' '1 2 3' '' '-4 5e1 .5' >points.txt
probe-place points points.txt --text >points.probe
printf '1 2 3\n4 5 6' >cut.txt
probe-place points cut.txt 2>err >cut.probe
check "a last line without an end may be cut off" says err 'cut.txt:2: nothing ends the last line'
printf '1 2 3\n4 5 6 # so\n' | probe-place points - 2>err >cut.probe
check "one with an end is whole" empty err
printf '4 5 6' | probe-place points - 2>err >cut.probe
check "and one line alone needs none" empty err
printf '\357\273\2771 2 3\r\n\t4\t5\t6 # so\r\n' | probe-place points - --text 2>err >cut.probe
check "points as Windows writes them: byte order mark, tabs, CR" holds cut.probe 2 \
    and says rows '^1 2 3$' '^4 5 6$' and empty err
check "points come as they are" says points.probe '^-4 50 0.5$'
probe-place points - --text <points.txt >points.probe
check "from standard input as well" says points.probe '^1 2 3$'
printf '%s\n' '# two' '1 2 3 0 0 2' '' '-4 5e1 .5 -1e-3 0 0' >normals.txt
probe-place points normals.txt --text >points.probe
check "points with a normal are surface probes, and it has length 1" says points.probe \
    '^table probe position:f64:3 normal:f32:3$' '^1 2 3 0 0 1$' '^-4 50 0.5 -1 0 0$'
echo '3 1 1 1 2 2' | probe-place points - --text --inside drop "$rooms" >points.probe
check "of any length, and with a scene" says points.probe '^3 1 1 0.333'
printf '%s\n' '0 0 0' '10 0 0' | probe-place path - --step 2.5 --text >path.probe
check "a path has its ends and its steps" says path.probe '^0 0 0 0$' '^2.5 0 0 2.5$' '^10 0 0 10$'

check "whose time is how far along they are" says path.probe \
    '^table probe position:f64:3 time:f64:1$' '^2.5 0 0 2.5$' '^10 0 0 10$'
printf '%s\n' '0 0 0 10' '10 0 0 12' '10 8 0 20' |
    probe-place path - --interval 2 --text >path.probe
check "or the 4th number, in steps of --interval" holds path.probe 6 \
    and says rows '^0 0 0 10$' '^10 0 0 12$' '^10 2 0 14$' '^10 8 0 20$'
probe-place path - --step 5 --interval 3 --text >path.probe <<'WAY'
0 0 0 10
10 0 0 12
10 8 0 20
WAY
check "or both" holds path.probe 6 and says rows '^5 0 0 11$' '^10 5.33'
# a quarter of a circle and on
awk 'BEGIN { for (i = 0; i < 6; i++) print cos(i * .3), sin(i * .3), 0, i }' |
    probe-place path - --spline --step .01 --text >path.probe
check "--spline: a smooth way, in even steps" of path.probe and every \
    'near($1 ^ 2 + $2 ^ 2, 1, 4e-3) && near($1, cos($4 * .3), 3e-3) &&
    (NR == 1 || ($1 - x) ^ 2 + ($2 - y) ^ 2 <= 1.001e-4) && (x = $1) + (y = $2) < 9' rows
printf '%s\n' '0 0 0' '1 0 0' '1 0 0' '1 1 0' |
    probe-place path - --spline --step .5 --text >path.probe
check "a point that is given twice is a corner" holds path.probe 6 \
    and says rows '^0.5 0 0 0.5$' '^1 0.5 0 1.5$'
echo '1 2 3' | probe-place path - --step 1 --text >path.probe
check "one point is one probe" holds path.probe 1 and says rows '^1 2 3 0$'
refused 1 "stdin:3: expected times that grow, got 4 after 5" \
    given "0 0 0 1
1 0 0 5
2 0 0 4" probe-place path - --step 1
refused 1 "stdin:1: expected x y z or x y z t, got 6 numbers" \
    given "0 0 0 1 0 0" probe-place path - --step 1
refused 1 "more than --max-probes 5" \
    given "0 0 0
9 0 0" probe-place path - --step 1 --max-probes 5
refused 2 "--spline goes with the method path" probe-place points --spline points.txt

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
grid="probe-place grid --spacing 1 --clearance 50% --bounds 0,0,0,4,4,4"
$grid cube.obj >dropped.probe 2>err
check "8 of 64 probes inside a cube are dropped" holds dropped.probe 56 and says err '8 of 64'
$grid --inside keep cube.obj >kept.probe
check "or kept" holds kept.probe 64
$grid -q --text --inside mark cube.obj | probe-cat --columns inside,position >marked.probe
check "or marked: 1 for the 8, 0 for the others" \
    says marked.probe '^table probe inside:i32:1 position:f64:3' and of marked.probe \
    and among '^1 [12].5 [12].5 [12].5$' 8 and among '^0 ' 56
for threads in 1 3; do $grid -q --threads $threads cube.obj >threads$threads.probe; done
check "any number of threads gives the same bytes" \
    cmp threads1.probe threads3.probe and test -s threads1.probe

# -- vertices --------------------------------------------------------------------------------------
probe-place vertices --offset .25 --text cube.obj >vertices.probe
check "a cube has 24 vertices, three at each corner" holds vertices.probe 24
check "which stand off their faces, along axes" \
    each vertices.probe '$4 ^ 2 + $5 ^ 2 + $6 ^ 2 == 1 && ($4 == 0) + ($5 == 0) + ($6 == 0) == 2 &&
    ($1 - 2) * $4 + ($2 - 2) * $5 + ($3 - 2) * $6 == 1.25 &&
    ($1 - 2) ^ 2 + ($2 - 2) ^ 2 + ($3 - 2) ^ 2 == 1.25 ^ 2 + 2'
numbers <vertices.probe | cut -d ' ' -f 4-6 | sort | uniq -c >faces
check "four on each face" has_lines 6 faces and every '$1 == 4' faces
{ grep '^v' cube.obj; grep '^f' cube.obj | tac; } >turned.obj
probe-place vertices --offset .25 --text turned.obj >turned.probe
for order in vertices turned; do numbers <$order.probe | sort >$order.sorted; done
check "whatever the order of the faces" \
    cmp turned.sorted vertices.sorted and test -s turned.sorted
probe-place vertices --crease 180 --text cube.obj >corners.probe
check "without creases it has 8" holds corners.probe 8
check "whose normals do not depend on how its faces are cut into triangles" \
    each corners.probe '$4 * $4 == 0.57735026 ^ 2 && $5 * $5 == $4 * $4 &&
    $6 * $6 == $4 * $4 &&
    ($1 - 2) * $4 > 0 && ($2 - 2) * $5 > 0 && ($3 - 2) * $6 > 0'
check "by default the offset is 0.001 of the diagonal" each corners.probe \
    'near(sqrt(($1 - 2) ^ 2 + ($2 - 2) ^ 2 + ($3 - 2) ^ 2), sqrt(3) * 1.002, 1e-12)'

probe-place vertices --volume --offset .3 --text cube.obj >volume.probe
check "--volume: one probe in space at a cube's corner, off all three faces" holds volume.probe 8 \
    and says volume.probe '^table probe position:f64:3$' and each volume.probe \
    'near(($1 - 2) ^ 2, (1 + .3 / sqrt(3)) ^ 2, 1e-12) && near(($1 - 2) ^ 2, ($2 - 2) ^ 2, 1e-12) &&
    near(($1 - 2) ^ 2, ($3 - 2) ^ 2, 1e-12)'
probe-place vertices -q --volume --inside keep --crease 60 --text cube.obj >volume.probe
check "or one off each, with a crease that says so" holds volume.probe 24

# -- lights ----------------------------------------------------------------------------------------
cat >lamps.mtl <<'MTL'
newmtl lamp
Ke 3 2 1
newmtl picture
Ke 1 1 1
map_Ke half.ppm
newmtl out
Ke 0 0 0
MTL
white='\377\377\377\377\377\377\377\377\377\377\377\377' black='\0\0\0\0\0\0\0\0\0\0\0\0'
printf "P6 8 1 255\n$white$black" >half.ppm
# lamps MATERIAL: what comes in is of it
lamps() { echo mtllib lamps.mtl; grep '^v' && echo "usemtl $1" && grep '^f' "${2-sheet.faces}"; }
lights="probe-place lights -q --text"
$lights --offset .5 --point 1.75,2,2,5,5,5 --spot 2,2,2,0,1,0,10,20,1,1,1 --inside keep cube.obj \
    >lights.probe
check "a point and a spot have six probes each, on the axes" holds lights.probe 12 and says rows \
    '^1.25 2 2 10$' '^1.75 1.5 2 10$' '^1.75 2 2.5 10$' '^2 2.5 2 10$' '^2 2 1.5 10$'
$lights --offset .5 --point 3.25,2,2,5,5,5 cube.obj >lights.probe
check "but none where a wall is between" holds lights.probe 5 and each lights.probe '$1 > 3'
grep '^f' cube.obj >cube.faces
lamps lamp cube.faces <cube.obj >bulb.obj
$lights --offset .25 --emit front bulb.obj >lights.probe
check "a box that shines has one before each side" holds lights.probe 6 and each lights.probe \
    'near(($1 - 2) ^ 2 + ($2 - 2) ^ 2 + ($3 - 2) ^ 2, 1.25 ^ 2, 1e-9) &&
    near(($1 - 2) * ($2 - 2), 0, 1e-9) && near(($1 - 2) * ($3 - 2), 0, 1e-9)'
printf '%s\n' 'v 0 0 0' 'v 4 0 0' 'v 4 0 2' 'v 0 0 2' 'vt 0 0' 'vt 1 0' 'vt 1 1' 'vt 0 1' >sheet.txt
echo 'f 1/1 2/2 3/3 4/4' >sheet.faces
lamps lamp <sheet.txt >sheet.obj
$lights --offset .5 sheet.obj >lights.probe
check "a sheet one on each side" holds lights.probe 2 and each lights.probe \
    'near($1, 2, 1e-9) && near($3, 1, 1e-9) && $2 ^ 2 == .25'
$lights --offset .5 --emit front sheet.obj >lights.probe
check "or before its front alone" holds lights.probe 1 and each lights.probe '$2 == -.5'
$lights --offset .1 --emit front sheet.obj >lights.probe
check "a large one is cut into pieces of ten offsets" holds lights.probe 8 and each lights.probe \
    'near($1 % 1, .5, .02) && near($3 % 1, .5, .02)'
lamps picture <sheet.txt >picture.obj
$lights --offset .5 --emit front picture.obj >lights.probe
check "where its picture shines" holds lights.probe 1 and each lights.probe \
    'near($1, 1, .3) && near($3, 1, 1e-2)'
sed 's/^v 4/v -1e-3/; s/^v 0 /v -4 /' sheet.txt >other.txt
{ lamps lamp <sheet.txt; cat other.txt; echo 'f 5/1 6/2 7/3 8/4'; } >two.obj
$lights --offset .5 --emit front two.obj >lights.probe
check "what shares no corner is another surface" holds lights.probe 2
lamps out <sheet.txt >out.obj
refused 1 "no point or spot light and no surface that emits" $lights out.obj
refused 1 "no point or spot light and no surface that emits" \
    $lights --sky 1,1,1 --sun 0,-1,0,1,1,1 --point 1,1,1,0,0,0 out.obj
refused 1 "a smaller --offset" $lights --offset 5 --point 2,2,2,1,1,1 cube.obj
refused 1 "are too large for pieces of ten times --offset" $lights --offset 1e-4 sheet.obj
refused 1 "more than --max-probes 5" $lights --max-probes 5 --offset .1 sheet.obj
refused 2 "--volume goes with the method vertices" probe-place grid --volume --spacing 1 cube.obj

# A prism of six sides, which turn by 60 degrees, without its ends; each has corners of its own.
awk 'BEGIN {
        for (i = 0; i < 6; i++)
            for (k = 0; k < 2; k++)
                for (z = 0; z < 2; z++) {
                    a = (i + k) % 6 * 3.14159265358979323846 / 3
                    printf "v %.17g %.17g %d\n", cos(a), sin(a), z
                }
        for (i = 0; i < 6; i++) printf "f %d %d %d %d\n", 4 * i + 1, 4 * i + 3, 4 * i + 4, 4 * i + 2
    }' >prism.obj
probe-place vertices prism.obj >prism.probe
check "a crease of just --crease is smooth: corners of six sides are welded" holds prism.probe 12
check "and their normals look outward along the corners" each prism.probe \
    '$6 == 0 && near($1 * $4 + $2 * $5, sqrt($1 * $1 + $2 * $2), 1e-7)'
probe-place vertices --crease 59.99 prism.obj >prism.probe
check "a sharper one is not" holds prism.probe 24

# A sphere of 24 by 12, every triangle with corners of its own.
awk 'function corner(i, j, s) {
        s = j % 12 ? sin(j * pi / 12) : 0
        i = i % 24 * pi / 12
        printf "v %.17g %.17g %.17g\n", 5 + s * cos(i), s * sin(i), cos(j * pi / 12)
    }
    function face(a, b, c, d, e, g) {
        corner(a, b)
        corner(c, d)
        corner(e, g)
        print "f -3 -2 -1"
    }
    BEGIN {
        pi = 3.14159265358979323846
        for (i = 0; i < 24; i++)
            for (j = 0; j < 12; j++) {
                if (j < 11) face(i, j, i, j + 1, i + 1, j + 1)
                if (j > 0) face(i, j, i + 1, j + 1, i + 1, j)
            }
    }' >sphere.obj
probe-place vertices --offset .5 sphere.obj >sphere.probe
check "a sphere has one probe a vertex" holds sphere.probe 266
check "whose normal points away from the centre" each sphere.probe \
    '($1 - 5) * $4 + $2 * $5 + $3 * $6 > 1.5 * 0.9999'

printf '%s\n' 'v 0 0 0' 'v 1 0 0' 'v 0 1 0' 'f 1 2 3' 'f 3 2 1' 'f 1 2 2' >sheet.obj
probe-place vertices -q --text sheet.obj >sheet.probe
check "a sheet with faces on both sides has probes on both" \
    holds sheet.probe 6 and among ' 0 0 1$' 3 and among ' 0 0 -1$' 3

# The triangle (0 0 0) (1 0 0) (0 1 0), once as it stands and once mirrored in x.
zero='\0\0\0\0'
one='\0\0\200\077'
triangle=$(printf "$zero$zero$zero$one$zero$zero$zero$one$zero" | base64)
cat >mirror.gltf <<JSON
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
 "nodes": [{"mesh": 0}, {"mesh": 0, "scale": [-1, 1, 1]}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,$triangle"}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [0, 0, 0], "max": [1, 1, 0]}]}
JSON
probe-place vertices --text mirror.gltf >mirror.probe
check "instances are placed, and welded with each other" holds mirror.probe 4
check "and keep their front when mirrored" each mirror.probe '$4 == 0 && $5 == 0 && $6 == 1'

{
    cat cube.obj
    sed 's/ 3/ 4/g; s/ 1/ 2/g' cube.obj | grep '^v'
    grep '^f' cube.obj | awk '{ print $1, $2 - 9, $3 - 9, $4 - 9, $5 - 9 }'
} >cubes.obj
probe-place vertices --text cubes.obj >kept.probe
check "probes inside solids stay" holds kept.probe 48
probe-place vertices -q --inside drop --text cubes.obj >dropped.probe
check "unless told otherwise" holds dropped.probe 42
for threads in 1 3; do
    probe-place vertices -q --inside drop --threads $threads cubes.obj >threads$threads.probe
done
check "on any number of threads alike" \
    cmp threads1.probe threads3.probe and test -s threads1.probe
probe-capture -q --sky 1,1,1 --rays 64 --columns none cube.obj vertices.probe >lit.probe
check "probe-capture takes them as surfaces: under an even sky of 1 a cube receives pi" \
    says lit.probe '^table probe position:f64:3 normal:f32:3 irradiance:f32:3$'
check "everywhere" each lit.probe '$7 > 3.14159 && $7 < 3.1416 && $8 == $7 && $9 == $7'

# -- inside and outside ----------------------------------------------------------------------------
# box X0 Y0 Z0 X1 Y1 Z1 [in]: the faces of a box as OBJ with relative indices, looking outward or in
box() {
    echo "$@" | awk '{
        for (i = 0; i < 8; i++)
            print "v", $(i % 2 * 3 + 1), $(int(i / 2) % 2 * 3 + 2), $(int(i / 4) * 3 + 3)
        n = split("0462 1375 0154 2673 0231 4576", face, " ")
        for (i = 1; i <= n; i++) {
            printf "f"
            for (k = 1; k <= 4; k++)
                printf " %d", substr(face[i], $7 == "in" ? 5 - k : k, 1) - 8
            print ""
        }
    }'
}
# voxels IN CONDITION-OF-ijk CELL: what a set of cubes of a 12 x 8 x 12 grid shows outward, or
# inward
voxels() {
    awk -v inward="$1" -v cell="$3" 'function solid(i, j, k) {
            return i >= 0 && j >= 0 && k >= 0 && i < 12 && j < 8 && k < 12 && ('"$2"')
        }
        function vertex(axis, a, u, v) {
            p[axis] = a
            p[(axis + 1) % 3] = u
            p[(axis + 2) % 3] = v
            print "v", p[0] * cell, p[1] * cell, p[2] * cell
        }
        function side(i, j, k, d,    axis, up, s, c, a, u, w) {
            axis = d % 3
            up = d < 3
            s = up ? 1 : -1
            if (solid(i + s * (axis == 0), j + s * (axis == 1), k + s * (axis == 2))) return
            c[0] = i
            c[1] = j
            c[2] = k
            a = c[axis] + up
            u = c[(axis + 1) % 3]
            w = c[(axis + 2) % 3]
            vertex(axis, a, u, w)
            vertex(axis, a, u + 1, w)
            vertex(axis, a, u + 1, w + 1)
            vertex(axis, a, u, w + 1)
            print up == !inward ? "f -4 -3 -2 -1" : "f -1 -2 -3 -4"
        }
        BEGIN {
            for (i = 0; i < 12; i++)
                for (j = 0; j < 8; j++)
                    for (k = 0; k < 12; k++)
                        if (solid(i, j, k))
                            for (d = 0; d < 6; d++) side(i, j, k, d)
        }'
}
# ground HEIGHT-OF-xz [down]: 20 x 20 quads on -10 .. 10, seen from above
ground() {
    awk -v down="${2:-}" 'function vertex(x, z) { print "v", x, ('"$1"'), z }
        BEGIN {
            for (i = -10; i < 10; i++)
                for (k = -10; k < 10; k++) {
                    vertex(i, k)
                    vertex(i, k + 1)
                    vertex(i + 1, k + 1)
                    vertex(i + 1, k)
                    print down ? "f -1 -2 -3 -4" : "f -4 -3 -2 -1"
                }
        }'
}
# told SCENE MATTER [OPTION]...: of a grid, only those go for which MATTER of x y z
told() {
    told_scene=$1 told_matter=$2
    shift 2
    probe-place grid --clearance 37% --inside mark --count 2000 --text "$@" "$told_scene" \
        2>told.err |
        awk -v scale="${scale:-1}" '/^[0-9-]/ {
            rows++
            x = $2 / scale
            y = $3 / scale
            z = $4 / scale
            matter += ('"$told_matter"') != 0
            wrong += ($1 != 0) != (('"$told_matter"') != 0)
        }
        END {
            print rows, "probes,", matter, "in no air,", wrong, "wrong"
            exit wrong || !rows || !matter
        }' >told.out
}
# house walls of half a unit around a room, with a window
walls='!(i > 0 && i < 11 && j > 0 && j < 7 && k > 0 && k < 11) &&
    !(i == 11 && j > 2 && j < 6 && k > 3 && k < 8)'
house='x > 0 && x < 6 && y > 0 && y < 4 && z > 0 && z < 6 &&
    !(x > .5 && x < 5.5 && y > .5 && y < 3.5 && z > .5 && z < 5.5) &&
    !(x > 5 && y > 1.5 && y < 3 && z > 2 && z < 4)'
# no face of it is in a layer of the grid
table='x > 2.1 && x < 3.9 && y > .5 && y < 1.5 && z > 2.1 && z < 3.9'
voxels 0 "$walls" .5 >house.obj
check "a house's walls are matter" told house.obj "$house"
{ cat house.obj; box 2.1 .5 2.1 3.9 1.5 3.9; } >furnished.obj
check "with furniture in it as well" told furnished.obj "$house || $table"
{
    cat furnished.obj
    printf 'mtllib lamp.mtl\nusemtl lamp\n'
    box 2.6 3.2 2.6 3.3 3.6 3.3
} >lamp.obj
printf 'newmtl lamp\nKe 9 9 9\n' >lamp.mtl
lamp='x > 2.6 && x < 3.3 && y > 3.2 && y < 3.6 && z > 2.6 && z < 3.3'
check "with a lamp in its ceiling" told lamp.obj "$house || $table || $lamp"
{ cat furnished.obj; box .2 .6 1 .3 3.4 1.1; box .2 1 .2 5.8 1.1 .3; } >pipes.obj
check "and with pipes in a wall" told pipes.obj "$house || $table"
awk '/^f/ && ++n % 3 == 0 { print $1, $5, $4, $3, $2; next } { print }' furnished.obj >soup.obj
check "and where every third face is turned round" told soup.obj "$house || $table"
turned='look to another side than their neighbours of the same closed piece: taken as turned round'
check "which is told" grep -q "$turned" told.err
for scale in .001 1000; do
    awk -v s=$scale '/^v/ { print $1, $2 * s, $3 * s, $4 * s; next } { print }' furnished.obj \
        >scaled.obj
    check "at a scale of $scale" told scaled.obj "$house || $table"
done
unset scale
box 0 0 0 4 3 .4 >wall.obj
box 1 -.5 .1 1.2 3.5 .3 >>wall.obj
check "a pipe does not make a room of a wall" told wall.obj \
    'z > 0 && z < .4 && x > 0 && x < 4 && y > 0 && y < 3 ||
    x > 1 && x < 1.2 && z > .1 && z < .3 && y > -.5 && y < 3.5' --bounds -2,-1,-2,6,4,2.3
{ box 0 0 0 6 3 5; box 1.03 0 1.03 2.03 1.03 3.03; box 4.03 0 4.03 5.03 2.03 4.83; } >room.obj
furniture='x > 1.03 && x < 2.03 && y < 1.03 && z > 1.03 && z < 3.03 ||
    x > 4.03 && x < 5.03 && y < 2.03 && z > 4.03 && z < 4.83'
check "a box that holds furniture is a room" told room.obj "$furniture"
check "which is told" grep -q 'taken for a room' told.err
check "and outside of it is none" told room.obj \
    "x < 0 || y < 0 || z < 0 || x > 6 || y > 3 || z > 5 || $furniture" \
    --bounds -.97,-.83,-.91,6.71,4.11,6.13
# Things that are turned inside out are matter in the air around them.
thing='x > 2.03 && x < 3.53 && y > .53 && y < 1.97 && z > 2.03 && z < 3.23'
{ box 0 0 0 8 3 6 in; box 2.03 .53 2.03 3.53 1.97 3.23 in; } >thing.obj
check "a thing in a room that is inside out" told thing.obj "$thing"
check "which is told" grep -q 'faces inward, but stands in the air that others are in' told.err
{ cat thing.obj; box 5.03 0 1.03 6.03 1.03 2.03; box 4.53 0 4.03 7.03 2.03 4.83 in; } >things.obj
check "several, beside one that is not" told things.obj "$thing ||
    x > 5.03 && x < 6.03 && y < 1.03 && z > 1.03 && z < 2.03 ||
    x > 4.53 && x < 7.03 && y < 2.03 && z > 4.03 && z < 4.83"
{ box -6 -1 -7 14 0 13; tail -n +15 thing.obj; } >outdoors.obj
check "and on a slab" told outdoors.obj "y < 0 || $thing" --bounds -5.97,-.93,-6.91,13.97,4.1,12.9
{ ground 0; box 2.03 0 2.03 5.03 2.03 5.03 in; box 3 .4 3 3.6 1 3.6; } >hut.obj
check "nothing is known of one that holds another" told hut.obj \
    'y < 0 || x > 3 && x < 3.6 && y > .4 && y < 1 && z > 3 && z < 3.6' --bounds -9,-1,-9,9,4,9
{ box -5 -5 -5 5 5 5; box -2 -2 -2 2 1 3 in; box -1 -2 -1 0 -1 0; } >cave.obj
check "a cave in a rock" told cave.obj \
    '!(x > -2 && x < 2 && y > -2 && y < 1 && z > -2 && z < 3) ||
    x > -1 && x < 0 && y < -1 && z > -1 && z < 0'

hill='5 * exp(-(x * x + z * z) / 30)'
ground "$hill" >hill.obj
under="y < $hill - .15 || y < $hill + .15 && \$1"
check "under a hill is no air" told hill.obj "$under"
probe-place grid -q --inside mark --count 500 --text hill.obj >marked
check "which is marked by 2" says marked '^2 '
check "with more rays as well" told hill.obj "$under" --inside-rays 256
{ cat hill.obj; box -2 3 -2 2 9 2; box 6 -2 6 8 4 8; } >built.obj
check "and under houses on it" told built.obj "$under ||
    x > -2 && x < 2 && y > 3 && z > -2 && z < 2 || x > 6 && x < 8 && y < 4 && z > 6 && z < 8"
ground "$hill" 1 >down.obj
check "a ground that looks down is turned" told down.obj "$under"
waves='2.5 * sin(x) * cos(.8 * z)' valley='-5 * exp(-(x * x + z * z) / 30)'
for ground in "$waves" "$valley" '.5 * x'; do
    ground "$ground" 1 >down.obj
    check "and so is one with as much air below it as above" told down.obj \
        "y < $ground - .6 || y < $ground + .6 && \$1"
done
bowl='.06 * (x * x + z * z)'
{ ground "$bowl"; box 2 .08 2 4 3.08 4; } >bowl.obj
check "a valley is no sky" told bowl.obj "y < $bowl - .15 || y < $bowl + .15 && \$1 ||
    x > 2 && x < 4 && z > 2 && z < 4 && y < 3.08" --count 800 --clearance 10%

# Houses that are sunk into their ground, of which nothing but foundations is seen from below.
ground 0 >sunk.obj
box -8.1 -1.1 -8.1 -2.1 6.3 -2.1 >>sunk.obj
box 1.1 -.3 -8.1 8.3 4.3 -1.1 >>sunk.obj
box -8.1 -.6 1.1 8.3 5.3 8.3 >>sunk.obj
sunk='y < 0 || x > -8.1 && x < -2.1 && z > -8.1 && z < -2.1 && y < 6.3 ||
    x > 1.1 && x < 8.3 && z > -8.1 && z < -1.1 && y < 4.3 ||
    x > -8.1 && x < 8.3 && z > 1.1 && z < 8.3 && y < 5.3'
check "under foundations is no air" told sunk.obj "$sunk" --bounds -10,-2,-10,10,8,10
{ cat built.obj; box -30 -30 -30 30 30 30 in; } >sky.obj
check "a sky box changes nothing" told sky.obj "$under ||
    x > -2 && x < 2 && y > 3 && z > -2 && z < 2 || x > 6 && x < 8 && y < 4 && z > 6 && z < 8" \
    --bounds -9.97,-2,-9.91,9.93,9,9.95
awk 'BEGIN { # crossed quads, of which every other is seen from behind
    for (i = 0; i < 300; i++) {
        x = (i * .618034 % 1) * 19 - 9.5
        z = (i * .754878 % 1) * 19 - 9.5
        c = cos(i)
        s = sin(i)
        for (k = 0; k < 2; k++) {
            print "v", x - c, .05, z - s
            print "v", x + c, .05, z + s
            print "v", x + c, 2.2, z + s
            print "v", x - c, 2.2, z - s
            print "f -4 -3 -2 -1"
            t = c
            c = -s
            s = t
        }
    }
}' >trees.obj
{ ground 0; cat trees.obj; } >wood.obj
cat >in_wood.sh <<'SH'
probe-place grid -q --inside mark --text --count 2000 --bounds -10,-2,-10,10,5,10 "$1" |
    awk '/^[0-9-]/ { all += $3 < 0; kept += $3 < 0 && !$1; lost += $3 > .1 && $1 }
        END { exit kept > .01 * all || lost > .01 * all || !all }'
SH
check "nor does a dense wood hide the ground below it" sh in_wood.sh wood.obj
{ ground 0; awk '/^v/ { print $1, $2, $3 - .3, $4; next } { print }' trees.obj; } >rooted.obj
check "where its trees go into the ground as well" sh in_wood.sh rooted.obj

# A lake, flat, that goes on inside the hills around it.
hills='1.5 * sin(.5 * x) * cos(.4 * z) + .4 * sin(1.3 * x + z)'
{
    ground "$hills"
    printf 'v -10 -.3 -10\nv -10 -.3 10\nv 10 -.3 10\nv 10 -.3 -10\nf -4 -3 -2 -1\n'
} >lake.obj
check "a lake says nothing, its bed and its hills do" told lake.obj \
    "y < $hills - .4 || y < $hills + .4 && \$1" --bounds -9.3,-3,-9.3,9.3,4,9.3

# Houses of walls without thickness that look outward, on a ground: with gates air is in them, and
# without they stand for matter.
{ ground 0; box -3 0 -3 3.01 3 3 | awk '!/^f/ || ++n > 3'; } >paper.obj
check "in a house of paper is air" told paper.obj 'y < 0' --bounds -8,-1.9,-8,8,5,8
{
    ground 0
    awk 'BEGIN { # quads of x y z: three walls, the roof, and the fourth wall beside a doorway
        n = split("-4 0 -4 -4 3 -4 4 3 -4 4 0 -4  -4 0 -4 -4 0 4 -4 3 4 -4 3 -4 " \
            "4 0 -4 4 3 -4 4 3 4 4 0 4  -4 3 -4 -4 3 4 4 3 4 4 3 -4 " \
            "-4 0 4 -.9 0 4 -.9 3 4 -4 3 4  .9 0 4 4 0 4 4 3 4 .9 3 4", v)
        for (i = 1; i <= n; i += 3) {
            print "v", v[i], v[i + 1], v[i + 2]
            if (i % 12 == 10)
                print "f -4 -3 -2 -1"
        }
    }'
} >doorway.obj
check "and in one with a doorway, to its far corners" \
    told doorway.obj 'y < 0' --bounds -8,-1.9,-8,8,5,8
{ ground 0; box -3 0 -3 3.01 3 3 | awk '!/^f/ || ++n != 3'; } >shut.obj
check "but not where it is shut" told shut.obj \
    'y < 0 || x > -3 && x < 3.01 && y < 3 && z > -3 && z < 3' --bounds -8,-1.9,-8,8,5,8

# A walled yard of thick matter; what is built in it has its floor within that of the yard.
yard='j < 1 || i < 1 || i > 10 || k < 1 || k > 10'
voxels 0 "$yard" 1 >yard.obj
box 3.1 .5 3.1 8.9 6.1 8.9 in | awk '!/^f/ || ++n != 4' >>yard.obj
check "what is sunk into a floor does not make a room of its matter" told yard.obj \
    'y < 1 || x < 1 || z < 1 || x > 11 || z > 11 ||
    $1 && !(x > 3.1 && x < 8.9 && z > 3.1 && z < 8.9)'

# An L of corridors, closed; the same with a lid in one piece, whose corners meet no other corner.
corridor='(i < 2 || k < 2) && j < 3'
voxels 1 "$corridor" 1 >corridor.obj
check "outside of a closed corridor is no air" told corridor.obj 'x > 2 && z > 2'
check "which is marked by 3, and told" \
    says told.err 'probes are outside of closed rooms: marked'
{ cat corridor.obj; printf 'mtllib lamp.mtl\nusemtl lamp\n'; box .5 2.5 .5 1 2.8 1; } >lit.obj
check "nor where a lamp is in it" told lit.obj \
    'x > 2 && z > 2 || x > .5 && x < 1 && y > 2.5 && y < 2.8 && z > .5 && z < 1'
{
    voxels 0 "$corridor" 1
    printf 'mtllib lamp.mtl\nusemtl lamp\n'
    printf 'v .5 2.9 .5\nv 1 2.9 .5\nv 1 2.9 1\nv .5 2.9 1\nf -4 -3 -2 -1\n'
} >outward.obj
check "with a lamp, its faces may look outward" told outward.obj 'x > 2 && z > 2'
cat >loose.obj <<'OBJ'
v 0 0 0
v 12 0 0
v 12 0 2
v 2 0 2
v 2 0 12
v 0 0 12
v 0 3 0
v 12 3 0
v 12 3 2
v 2 3 2
v 2 3 12
v 0 3 12
v 0 0 2
v 0 3 2
f 4 3 2 1
f 13 6 5 4
f 1 13 4
f 7 8 9 10
f 14 10 11 12
f 7 10 14
f 1 2 8 7
f 2 3 9 8
f 3 4 10 9
f 4 5 11 10
f 5 6 12 11
f 6 1 7 12
OBJ
check "whose faces need not meet corner by corner" told loose.obj 'x > 2 && z > 2'

# A level whose furniture stands on floors at the same height as its bottoms
{ cat corridor.obj; box 4.01 0 .4 6.03 1 1.6; box .4 0 4 1.6 .7 7; box .3 0 8 1.1 2.2 8.9; } \
    >placed.obj
check "nor is it under furniture" told placed.obj \
    'x > 2 && z > 2 || y < 0 || x > 4.01 && x < 6.03 && y < 1 && z > .4 && z < 1.6 ||
    x > .4 && x < 1.6 && y < .7 && z > 4 && z < 7 ||
    x > .3 && x < 1.1 && y < 2.2 && z > 8 && z < 8.9' --bounds .07,-1.9,.03,11.93,2.91,11.97
awk '/^f/ { print $1, $5, $4, $3, $2; next } { print }' furnished.obj >inverted.obj
check "a house that is turned inside out, with its furniture" told inverted.obj "$house || $table"
check "which is told" grep -q 'whole surface is taken as turned inside out' told.err
voxels 1 "$walls" .5 >bare.obj
check "and with nothing in it" told bare.obj "$house"
{ ground -.05; cat house.obj; } | awk '/^f/ { print $1, $5, $4, $3, $2; next } { print }' \
    >overturned.obj
check "or on a ground that is" told overturned.obj "$house || y < -.05 && \$1" \
    --bounds -9.9,-1,-9.7,9.7,6,9.9
awk '/^v/ { print $1, $2, -$4, $3; next } { print }' overturned.obj >upright.obj
house_z=$(echo "$house" | sed 's/y/w/g; s/z/(-y)/g; s/w/z/g')
check "where Z is up, too" told upright.obj "$house_z || z < -.05 && \$1" \
    --bounds -9.9,-9.9,-1,9.7,9.7,6
# Of many positions, those between others of the same side are not asked.
check "many are told as few are" told furnished.obj "$house || $table" --count 30000
for threads in 1 3; do
    probe-place grid -q --inside mark --count 30000 --threads $threads furnished.obj \
        >many$threads.probe
done
check "by any number of threads" cmp many1.probe many3.probe and test -s many1.probe

# -- open grounds -------------------------------------------------------------------------------
ground 0 >flat.obj
probe-place grid --count 1000 --text flat.obj >flat.probe 2>flat.err
numbers <flat.probe >rows
cut -d ' ' -f 2 rows | sort -u >layers
check "a grid over a flat ground has three layers of air" \
    has_lines 3 layers and [ "$(wc -l <rows)" -le 1000 ]
check "the lowest a tenth of the others' distance above it" \
    every 'NR == 1 ? (low = $1) > 0 : near($1 - low, (NR - 1) * 10 * low, 1e-9)' layers
check "and says so" grep -q 'flat along Y: the grid stands on the ground, in 3 layers' flat.err
box -10 -.2 -10 10 0 10 >slab.obj
probe-place grid -q --spacing 1 --text slab.obj >slab.probe
numbers <slab.probe >rows
check "so has one over a slab" has_lines 1323 rows
check "whose matter has none" each slab.probe '$2 > 0'
box 0 0 0 4 3 4 in >low.obj
probe-place grid -q --spacing 2 --text low.obj | numbers >rows
check "a room does not stand on its floor" has_lines 27 rows

# On a ramp with a bridge over it, whose own fronts look down; and where Z is up.
slope='.5 * x + 5'
{ ground "$slope"; box -2 15 -10 2 16 10; } >ramp.obj
probe-place grid --spacing 5 --ground 2 --clearance 1 ramp.obj >ramp.probe 2>ramp.err
check "columns follow the ground by the clearance and the spacing, and stand on a bridge" \
    each ramp.probe 'near($2 - (.5 * $1 + 5), 1, 1e-4) || near($2 - (.5 * $1 + 5), 6, 1e-4) ||
        $1 * $1 < 4 && near($2, 17, 1e-4) || $1 * $1 < 4 && near($2, 22, 1e-4)'
high=$(awk '$2 > 15.9' rows | wc -l)
check "all of them" holds ramp.probe 60 and [ "$high" -eq 10 ] and empty ramp.err
probe-place grid -q --spacing 5 --ground 2 --clearance 1 --bounds -10,0,-10,10,14,10 ramp.obj \
    >within.probe
check "and stay in the bounds" each within.probe '$2 <= 14' and has_lines 40 rows
awk '/^v/ { print $1, $2, -$4, .9 * $3; next } { print }' hill.obj >up.obj
probe-place grid -q --count 200 --ground 1 --text up.obj >up.probe
check "a hill whose Z is up is stood on, by the count" each up.probe \
    'near($3, 4.5 * exp(-($1 * $1 + $2 * $2) / 30), .6)' and holds up.probe 196

{ ground 0; box -2.1 0 -2.1 2.1 2 2.1 in; } >stand.obj
probe-place grid -q --spacing 4 --ground 1 --clearance .5 stand.obj >stand.probe
check "a box that is inside out is stood on" each stand.probe \
    'near($2, $1 * $1 < 4 && $3 * $3 < 4 ? 2.5 : .5, 1e-4)' and holds stand.probe 36

# Grounds that look down, flat or steep, are taken for what they are meant to be.
ground '2.5 * sin(x) * cos(.8 * z)' >steep.obj
for scene in flat steep; do
    awk '/^f/ { print $1, $2, $5, $4, $3; next } { print }' $scene.obj >down.obj
    for file in $scene down; do
        probe-place grid --count 100 --text $file.obj 2>$file.err | numbers >$file.rows
    done
    paste -d ' ' $scene.rows down.rows >both
    check "a $scene ground that looks down has the probes of one that looks up, and a warning" \
        every 'NF == 6 && near($1, $4, 1e-9) && near($2, $5, 1e-4) && near($3, $6, 1e-9)' both \
        and test -s both and says down.err 'taken as turned inside out' and lacks $scene.err turned
done

# -- turned and several boxes -------------------------------------------------------------------
probe-place grid --spacing 1 --clearance 0 --bounds 0,0,0,4,0,2 --turn 90 --text >quarter.probe
check "a box is turned about its middle" holds quarter.probe 15 and says rows '^1 0 3$' '^3 0 -1$'
probe-place grid --spacing 1 --clearance 0 --bounds 0,0,0,4,0,2 --bounds 3,0,0,6,0,2 --text \
    >two.probe
check "where boxes overlap the first one's nodes are there alone" holds two.probe 21
awk '/^v/ { c = cos(.5); s = sin(.5); print $1, c * $2 + s * $4, $3, c * $4 - s * $2; next }
    { print }' low.obj >askew.obj
probe-place grid -q --count 90 --turn 28.6478897565412 askew.obj >askew.probe
probe-place grid -q --count 90 low.obj >low.probe
check "a scene that is turned gets the grid that is turned with it" \
    [ "$(row_count probe askew.probe)" = "$(row_count probe low.probe)" ] and each askew.probe \
    '(x = cos(.5) * $1 - sin(.5) * $3) > .03 && x < 3.97 &&
    (z = sin(.5) * $1 + cos(.5) * $3) > .03 && z < 3.97'

# -- far pieces -----------------------------------------------------------------------------------
{ ground 0; echo usemtl marker; printf 'v 4e6 0 0\nv 4e6 0 1\nv 4e6 1 0\nf -3 -2 -1\n'; } >far.obj
probe-place grid --count 100 --bounds -9,1,-9,9,5,9 far.obj 2>far.err >/dev/null
check "a lone triangle far away is named" grep -q \
    "1 triangle of material '.*' at 4e+06 .* is 4e+06 units away from the rest" far.err
{ ground 0; printf 'v 400 0 0\nv 400 0 1\nv 400 1 0\nf -3 -2 -1\n'; } >near.obj
probe-place grid --count 100 --bounds -9,1,-9,9,5,9 near.obj 2>near.err >/dev/null
check "but not one that floats reach" sh -c '! grep -q "units away" near.err'

# -- points on surfaces ----------------------------------------------------------------------------
poisson="probe-place poisson --point 4,2,2.5,9,9,9 --text"
$poisson --count 150 "$rooms" >poisson.probe 2>err
check "poisson: normals, radii, occlusion, and what it took is told" says poisson.probe \
    '^table probe position:f64:3 normal:f32:3 origin:i32:1 radius:f32:1 ao:f32:1$' \
    and says err 'probe-place: 1[45].* points, radii .* darts' and each poisson.probe \
    'near($4 ^ 2 + $5 ^ 2 + $6 ^ 2, 1, 1e-5) && $7 == 12 && $8 > 0 && $9 >= 0 && $9 <= 1'
$poisson -q --radii .3,1 "$rooms" >poisson.probe
$poisson -q --radii .3,1 --lift .2 --threads 1 "$rooms" >lifted.probe
check "--lift: the same in space, without normals" says lifted.probe \
    '^table probe position:f64:3 origin:i32:1 radius:f32:1 ao:f32:1$' \
    and [ "$(row_count probe lifted.probe)" -eq "$(row_count probe poisson.probe)" ]
check "and probe-capture gives those with normals irradiance" into lit.probe \
    probe-capture -q --rays 16 --point 4,2,2.5,9,9,9 --text "$rooms" poisson.probe \
    and says lit.probe 'radius:f32:1 ao:f32:1.* irradiance:f32:3'
awk '/^-?[0-9]/ && !seen++ { $1 += .01; $8 = 9 } { print }' poisson.probe >moved.probe
$poisson -q --radii .3,1 --keep moved.probe --threads 1 "$rooms" >kept.probe
check "--keep: those stay, first, and there is room for next to no others" \
    sh -c 'for f in moved kept; do grep "^-*[0-9]" $f.probe | cut -d" " -f 1-6 >$f.rows; done
    head -n $(wc -l <moved.rows) kept.rows | cmp - moved.rows &&
    [ $(wc -l <kept.rows) -le $(($(wc -l <moved.rows) * 21 / 20)) ]'
check "their radii are at most the greatest" each kept.probe '$8 > 0 && $8 <= 1'
refused 2 "expected either --keep or --lift" $poisson --radii .3,1 --lift .2 --keep poisson.probe \
    "$rooms"
refused 1 "lifted.probe: expected surface probes" $poisson --radii .3,1 --keep lifted.probe "$rooms"
refused 1 "--count: expected more than the" $poisson --count 9 --keep poisson.probe "$rooms"
sed '/^[0-9]/ { s/^[^ ]*/1e300/; q; }' poisson.probe >far.probe
echo end >>far.probe
refused 1 "far.probe: probe 0: expected a place within 1e+06 diagonals of the scene, got 1e+300" \
    $poisson --radii .3,1 --keep far.probe "$rooms"
refused 1 "no light gets to any surface: --sky" probe-place poisson --count 9 --light-scale 0 \
    "$rooms"
printf '%s\n' 'v 0 0 0' 'v 1 0 0' 'v 0 0 1' 'v 900 0 0' 'v 901 0 0' 'v 900 0 1' \
    'f 1 2 3' 'f 4 5 6' >islands.obj
for light in "--sky 1,1,1" "--sun .1,-1,0,1,1,1"; do
    probe-place poisson -q --text --count 40 $light islands.obj >set.probe
    check "poisson: $light finds two islands that are small in their sea, both" \
        test "$(grep -c '^90[01]\|^90[01]\.' set.probe)" -ge 10 -a \
        "$(grep -c '^[01]\.' set.probe)" -ge 10
done
check "poisson: and the sun their upper sides alone" lacks set.probe ' 0 -1 0 12 '
refused 1 "none of 15360 particles of light gets to a surface" \
    probe-place poisson --count 9 --spot 0,1,0,0,1,0,10,20,1,1,1 islands.obj
printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\200\200\200\177\100\100\100\177' >two.hdr
printf '%s\n' 'newmtl two' 'map_Kd two.hdr' >two.mtl
printf '%s\n' 'mtllib two.mtl' 'usemtl two' 'v 0 0 0' 'v 4 0 0' 'v 4 0 2' 'v 0 0 2' \
    'vt 0 0' 'vt 1 0' 'vt 1 1' 'vt 0 1' 'f 4/4 3/3 2/2 1/1' >two.obj
two="probe-place poisson --text --radii .3 --sun 0,-1,0,1,1,1"
$two --areas 64 two.obj >two.probe 2>err
check "--areas: those of a lit side sum to its 8, which is told" says two.probe \
    ' radius:f32:1 ao:f32:1 area:f32:1 albedo:f32:3$' \
    and says err 'stand for [78][.0-9]* of surface' \
    and awk '/^[0-9]/ { area += $10 } END { exit !(area > 7.96 && area < 8.04) }' two.probe
check "a texture of .25 and .125 gives each its own mean, all .1875" \
    awk '/^[0-9]/ { area += $10; sum += $10 * $11; low += $11 < .14; high += $11 > .23 }
        END { exit !(sum / area > .186 && sum / area < .189 && low && high) }' two.probe
awk '/^[0-9]/ && n++ % 2 { $8 = "nan" } { print }' two.probe >unknown.probe
$two -q --areas 64 --keep unknown.probe two.obj >kept.probe
check "points whose radius is not known, nan, stay, with MAX at the most" each kept.probe \
    '$8 > 0 && $8 <= .3001' \
    and awk '/^[0-9]/ { area += $10 } END { exit !(area > 7.96 && area < 8.04) }' kept.probe
refused 2 "--areas goes with the method poisson" probe-place grid --areas 9 --count 9 "$rooms"
refused 2 "expected either --radii or --count" probe-place poisson "$rooms"
for radii in 0 0,1 2,1 -1,1 '' nan 1, 1,inf; do
    refused 2 "expected MAX, or MIN,MAX" probe-place poisson --radii "$radii" "$rooms"
done
refused 1 "at most the scene's diagonal" $poisson --radii 1,100 "$rooms"
refused 1 "at least 1e-06 of the scene's diagonal" $poisson --radii 1e-9,1 "$rooms"
refused 1 "make more than --max-probes 20" $poisson -q --radii .1 --max-probes 20 "$rooms"
refused 2 "--radii goes with the method poisson" probe-place grid --radii 1 --count 9 "$rooms"

# -- octrees ---------------------------------------------------------------------------------------
printf '%s\n' 'newmtl glow' 'Kd 0 0 0' 'Ke 1 1 1' 'newmtl dark' 'Kd 0 0 0' >octree.mtl
{
    echo mtllib octree.mtl
    echo usemtl glow
    box 0 0 0 8 8 8 in
    echo usemtl dark
    box 3.5 3.5 3.5 4.5 4.5 4.5
} >octree.obj
octree="probe-place octree --cells 2,2,2 --bounds .1,.1,.1,7.9,7.9,7.9 --rays 64 --text"
$octree -q --cut all --levels 1:1 octree.obj >octree.probe
check "an octree of one level is a grid" holds octree.probe 125 and says octree.probe \
    '^table probe position:f64:3 origin:i32:1 level:i32:1 inside:i32:1 depth:f32:1$' \
    and every '$4 == 9 && ($5 == 0 || $5 == 1) && ($6 == 0) == ($1 != 4 || $2 != 4 || $3 != 4)' rows
reads() { probe-query --interpolate trilinear --column depth "$1" </dev/null; }
$octree --cut geometry --levels 0:3 octree.obj >octree.probe 2>err
check "geometry: cut to the last level where a surface comes in" of octree.probe \
    and every '$5 < 3 || ($1 > 3 && $1 < 5 && $2 > 3 && $2 < 5 && $3 > 3 && $3 < 5)' rows \
    and says err 'level  *nodes' 'probe-place:  *3  *' and reads octree.probe
awk '$5 == 3' rows >fine
check "all around the cube, and its inside is marked" every \
    '($6 == 1) == ($1 > 3.5 && $1 < 4.5 && $2 > 3.5 && $2 < 4.5 && $3 > 3.5 && $3 < 4.5)' fine
cp rows marked
$octree -q --cut distance=.5 --levels 0:2 octree.obj >octree.probe
check "distance: fine at walls and at the cube" reads octree.probe and of octree.probe \
    and every '$5 < 2 || $1 < 2.1 || $1 > 5.9 || $2 < 2.1 || $2 > 5.9 || $3 < 2.1 || $3 > 5.9 ||
    ($1 > 2 && $1 < 6 && $2 > 2 && $2 < 6 && $3 > 2 && $3 < 6)' rows
{ echo mtllib octree.mtl; echo usemtl glow; box 0 0 0 8 8 8 in; } >even.obj
$octree -q --cut all --cull .1 --levels 0:2 even.obj >octree.probe
check "cull: where light is even, all is joined again" holds octree.probe 27
$octree -q --cut all --cull .1 --levels 1:2 even.obj >octree.probe
check "to the first level" holds octree.probe 125
$octree -q --cut contrast,gradient --levels 0:2 even.obj >octree.probe
check "contrast, gradient: and nothing is cut" holds octree.probe 27
# a screen from wall to wall, bright on one side
{
    echo mtllib octree.mtl
    echo usemtl glow
    box 0 0 0 3.2 8 8 in
    echo usemtl dark
    box 3.21 0 0 8 8 8 in
} >halves.obj
for threads in 1 3; do
    $octree -q --cut contrast --levels 0:2 -j $threads halves.obj >halves$threads.probe
done
check "contrast: fine where the light ends, on both sides" of halves1.probe and every \
    '$5 < 1 || $1 < 4.01' rows and reads halves1.probe
check "by any number of threads" cmp halves1.probe halves3.probe
probe-capture -q --rays 16 octree.obj octree.probe | probe-tet -q >octree.tet
check "its probes make cells" probe-query -q --column depth octree.tet points.txt
refused 2 "--cut: expected geometry, distance, gradient, contrast or all" \
    probe-place octree --cut light octree.obj
refused 2 "--cut: all has no threshold" probe-place octree --cut all=1 octree.obj
refused 2 "expected a threshold greater than 0, got 0" \
    probe-place octree --cut distance=0 octree.obj
refused 2 "--levels: expected MAX or MIN:MAX, from 0 to 10, got '2:1'" \
    probe-place octree --levels 2:1 octree.obj
refused 2 "--cells: expected whole numbers from 1" probe-place octree --cells 1,2,.5 octree.obj
refused 1 "an octree needs a box with a volume" \
    probe-place octree --bounds 0,0,0,1,0,1 octree.obj
refused 1 "leaves nothing of the box" probe-place octree --inset 4 octree.obj
refused 1 "more than --max-probes 100" $octree -q --max-probes 100 --cut all octree.obj
refused 2 "--cull goes with the method octree" probe-place grid --spacing 1 --cull 1 octree.obj

# -- what is refused -------------------------------------------------------------------------------
refused 2 "vertices: expected a SCENE" probe-place vertices
refused 2 "--offset goes with the methods vertices and lights" \
    probe-place grid --spacing 1 --offset 1 cube.obj
refused 2 "--bounds goes with the methods grid" \
    probe-place points --bounds 0,0,0,1,1,1 points.txt
refused 2 "--spacing goes with the methods grid" \
    probe-place vertices --spacing 1 cube.obj
refused 2 "--step goes with" probe-place vertices --step 1 cube.obj
refused 2 "unexpected operand 'x'" probe-place vertices cube.obj x
refused 2 "--offset" probe-place vertices --offset 0 cube.obj
refused 2 "--crease" probe-place vertices --crease 181 cube.obj
refused 1 "this makes 24 probes, more than --max-probes 23" \
    probe-place vertices --max-probes 23 cube.obj

refused 1 '1e+20,0,0 is too far out' into /dev/null sh -c 'echo 1e20 0 0 |
    probe-place points - cube.obj'
refused 1 '1e+20,1,1 is too far out' \
    probe-place octree --bounds 0,0,0,1e20,1,1 cube.obj
refused 1 '1e+30,1,1 is too far out' probe-place lights --point 1e30,1,1,1,1,1 cube.obj
refused 1 "all 8 probes are inside solids" \
    probe-place grid --spacing 1 --bounds 1.5,1.5,1.5,2.5,2.5,2.5 cube.obj
refused 1 "1003003001 probes" probe-place grid --spacing .001 --bounds 0,0,0,1,1,1
check "unless --max-probes says so" into /dev/null \
    probe-place grid --spacing .01 --bounds 0,0,0,1,1,1.1 --max-probes 1200000
refused 2 "expected a method grid, points, path, vertices" \
    probe-place net "$rooms"
refused 2 "expected either --spacing or --count" probe-place grid "$rooms"
refused 2 "expected either --spacing or --count" probe-place grid --spacing 1 --count 3 "$rooms"
refused 2 "expected a SCENE or --bounds" probe-place grid --spacing 1
refused 2 "expected --step or --interval" probe-place path points.txt
refused 2 "--ground needs a SCENE" probe-place grid --spacing 1 --ground 1 --bounds 0,0,0,1,1,1
refused 1 "no column of the grid meets a floor" \
    probe-place grid --spacing 1 --ground 1 --bounds 9,9,9,10,10,10 cube.obj
refused 2 "50% of the spacing or less, got 51%" \
    probe-place grid --clearance 51% --spacing 1 "$rooms"
refused 2 "got -1" probe-place grid --clearance -1 --spacing 1 "$rooms"
refused 2 "between -360 and 360, got 361" probe-place grid --turn 361 --spacing 1 "$rooms"
refused 2 "a --count of at least 1 for each of 2 boxes, got 1" \
    probe-place grid --count 1 --bounds 0,0,0,1,1,1 --bounds 2,0,0,3,1,1
refused 2 "greater than 0, got 0" probe-place grid --spacing 0 "$rooms"
refused 2 "above" probe-place grid --spacing 1 --bounds 1,0,0,0,1,1
refused 1 "nothing.obj" probe-place grid --count 10 nothing.obj
: >empty.obj
refused 1 "empty.obj: the file is empty" probe-place grid --count 10 empty.obj
printf '%s\n' 'v 0 0 0' 'v 9 0 0' 'v 0 9 0' 'v 0 0 9' 'f 1 2 3' 'f 1 2 4' 'f 1 2 5' >broken.obj
refused 1 "broken.obj:7: face 3" probe-place grid --count 10 broken.obj
refused 2 "the scene and FILE cannot both" probe-place points - /dev/stdin
probe-place vertices --lenient --text broken.obj >lenient.probe 2>err
check "--lenient leaves out what is broken, says so, and the header keeps it" \
    says err 'warning: broken.obj:7: .*left out' and says lenient.probe '^lenient yes'
probe-place vertices cube.obj >whole 2>err
through_a_pipe() { cat cube.obj | probe-place vertices -; }
as_a_device() { probe-place vertices /dev/stdin <cube.obj; }
by_a_named_pipe() {
    mkfifo named
    cat cube.obj >named &
    probe-place vertices named
}
for way in through_a_pipe as_a_device by_a_named_pipe; do
    $way >piped 2>err
    check "a scene comes ${way}" same_stream piped whole
done
printf '0 0 0 # the origin\n1 0 0# another\n#\n' | probe-place points - --text >commented
check "comments behind points" says commented '^1 0 0'
printf '1 2\n' >short.txt
refused 1 "short.txt:1: expected x y z" probe-place points short.txt
printf '1 2 x\n' >rubbish.txt
refused 1 "rubbish.txt:1: expected a number, got 'x'" probe-place points rubbish.txt
printf '1 2 nan\n' >nan.txt
refused 1 "nan.txt:1: expected finite numbers, got nan" probe-place points nan.txt
: >none.txt
refused 1 "none.txt: expected at least one position" probe-place points none.txt
printf '%s\n' '1 2 3 0 0 1' '1 2 3 0 0 0' >flat.txt
refused 1 "flat.txt:2: expected a normal with a length, got 0 0 0" probe-place points flat.txt
printf '%s\n' '1 2 3 0 0 1' '1 2 3' >mixed.txt
refused 1 "mixed.txt:2: expected 6 numbers, as in the lines before" probe-place points mixed.txt
refused 1 "No space left" into /dev/full probe-place points points.txt
tap_done
