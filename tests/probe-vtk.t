#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-vtk: what it writes arrives in VTK's own readers (tests/support/vtk_read.py, on Debian's
# python3-vtk9) as it stood in the stream, derived arrays are what the manual says, and what cannot
# be written leaves the old file. scripts/picture draws it.
. "${SRC:?}/tests/support/setup.sh"

if [ ! -x "$BUILD/src/probe-vtk" ]; then
    printf '1..0 # SKIP probe-vtk is not built (--without-vtk)\n'
    exit 0
fi

python=/usr/bin/python3
if sanitized; then
    skip "what arrives in VTK's readers is seen in the plain build"
    look() { :; }
elif "$python" -c 'import numpy, vtkmodules.vtkIOXML' 2>/dev/null; then
    mkfifo asked answered
    "$python" "$SRC/tests/support/vtk_read.py" <asked >answered 2>looked &
    exec 8>asked 9<answered
    look() { # look NAME CHECK ARGUMENT...
        look_name=$1
        shift
        (
            IFS='	'
            printf '%s\n' "$*" >&8
        )
        look_said=
        IFS= read -r look_said <&9
        case $look_said in
        holds) pass "$look_name" ;;
        *) fail "$look_name" "$* gave: $look_said" ;;
        esac
    }
else
    look() { skip "$1: python3-vtk9 or python3-numpy is not installed"; }
fi

# warning COMMAND...: what it says, in warned
warning() { "$@" 2>warned; }

# -- a baked scene ---------------------------------------------------------------------------------
rooms=$SRC/scenes/two-rooms.obj
probe-place grid --quiet --count 60 "$rooms" | probe-capture --quiet --rays 16 "$rooms" |
    probe-tet --quiet | probe-leakfix --quiet --rounds 1 "$rooms" | probe-cat --text >baked.txt
probe-cat --binary baked.txt >baked.probe
check "a baked stream is written" probe-vtk --quiet -o baked.vtu baked.txt
look "every column, key and command line arrives unchanged, cells keep their orientation" \
    columns baked.vtu baked.txt
look "derived arrays are what their formulas say" derived baked.vtu
probe-cat --content irradiance baked.probe | probe-vtk --quiet -o convolved.vtu
look "and of irradiance" derived convolved.vtu
probe-vtk --quiet -o text.vtu --text baked.probe
look "as text, from a binary stream: the same" same baked.vtu text.vtu
probe-vtk --quiet -o compressed.vtu --compress baked.txt
look "compressed: the same" same baked.vtu compressed.vtu
check "compressed is smaller" [ "$(wc -c <compressed.vtu)" -lt "$(wc -c <baked.vtu)" ]
probe-vtk --quiet -o - <baked.txt >piped.vtu
check "standard input to standard output: the same bytes" cmp baked.vtu piped.vtu
probe-vtk --quiet -o exposed.vtu --exposure 1e-9 baked.probe
look "--exposure sets the display colour" value exposed.vtu colour 0,0,0
check "the same input gives the same bytes" \
    probe-vtk --quiet -o again.vtu baked.txt and cmp baked.vtu again.vtu

# -- small streams of known shape ------------------------------------------------------------------
cat >regular.txt <<'STREAM'
#?probe 1
# made by hand <&">
sh-order 1
sh-content irradiance
note unknown keys & "quotes" pass
table probe position:f64:3 sh:f32:3 colour:i32:1 own:f64:2
0 0 0 1 1 1 7 1e-300 0.1
1 0 0 1 1 1 8 -2.5 1e300
0.5 0.86602540378443865 0 1 1 1 9 3 4
0.5 0.28867513459481288 0.81649658092772603 1 1 1 -2147483648 5 6
table tet vertex:i32:4 neighbour:i32:4 volume:f32:1
0 1 2 3 -1 -1 -1 -1 42
table other x:f32:1
1
end
STREAM
check "a stream with columns, keys and tables of its own is written" \
    warning probe-vtk -o regular.vtu regular.txt
check "a table without shape is left out with a warning" says warned 'warning: table other'
look "columns win over derived arrays of their name, and arrive to the bit" \
    columns regular.vtu regular.txt
look "a regular tetrahedron: dihedral angles of 70.5288 degrees" \
    value regular.vtu min_dihedral 70.528779365509308
look "a regular tetrahedron: aspect ratio 1" value regular.vtu aspect_ratio 1
look "one cell: all four faces are on the hull" value regular.vtu hull_faces 4
look "one cell: all four probes are on the hull" value regular.vtu hull 1
look "convolved coefficients are not convolved again" \
    value regular.vtu luminance 0.28209479177387814
sed 's/ volume:f32:1//; s/ 42$//' regular.txt | probe-vtk --quiet -o plain.vtu
look "a regular tetrahedron: volume 1/sqrt(72)" value plain.vtu volume 0.11785113019775793

# A field that is linear in space has one gradient: in every cell, at every probe.
awk 'BEGIN {
        srand(3)
        for (i = 0; i < 200; i++) print 10 * rand(), 3 * rand(), 5 + 4 * rand()
    }' >points.txt
# with_light GRADIENT [KEY]: positions to a stream of cells whose light has it, times pi Y00
with_light() {
    probe-place points --quiet - | probe-tet --quiet | probe-cat --text |
        awk -v gradient="$1" -v key="${2-}" '
            BEGIN { CONVFMT = "%.9g"; split(gradient, g, ",") }
            /^table/ { rows = 0 }
            rows && /^[-0-9]/ {
                value = 20 + g[1] * $1 + g[2] * $2 + g[3] * $3
                $0 = $0 " " value " " value " " value
            }
            /^table probe/ {
                print "sh-order 1"
                if (key) print key
                rows = 1
                $0 = $0 " sh:f32:3"
            }
            { print }'
}
with_light 0.5,-2,1.25 <points.txt >linear.txt
probe-vtk --quiet -o linear.vtu linear.txt
# pi Y00 = 0.88622693 times (0.5, -2, 1.25)
look "the gradient of a linear field is exact" gradient linear.vtu 0.44311346,-1.77245385,1.10778366

# Probes in a plane, a tilted one too, on a line, at one place, and two of them.
flat_stream() { with_light "$1" "sh-content radiance"; }
awk '/^[0-9]/ { print $1, 2, $3 }' points.txt | flat_stream 2,0,-3 >plane.txt
awk '/^[0-9]/ { u = int(99 * $1); v = int(99 * $3); print u + v, u - v, 2 * u }' points.txt |
    flat_stream 2,1,0.5 >tilted.txt
seq 0 10 | awk '{ u = 7 * $1 % 11; print 2 * u, -u, 3 }' | flat_stream 4,-2,0 >line.txt
printf '%s\n' '1 2 3' '4 6 3' | flat_stream 3,4,0 >two.txt
printf '%s\n' '1 2 3' '1 2 3' | flat_stream 1,1,1 >one.txt
for name in plane:tri tilted:tri line:segment two:segment one:point; do
    table=${name#*:}
    name=${name%:*}
    check "$name: its cells are those of table $table" says $name.txt "^table $table "
    check "$name: is written" probe-vtk --quiet -o $name.vtu $name.txt
    look "$name: every column arrives, in cells of their kind" columns $name.vtu $name.txt
    [ $name = one ] ||
        look "$name: quality, hull, light and gradients are what their formulas say" \
            derived $name.vtu
done
# pi Y00 = 0.88622693 times the part of the gradient along the plane or line
look "a plane: the gradient of a linear field is exact" gradient plane.vtu 1.77245385,0,-2.65868078
look "a tilted plane: the same, along the plane" \
    gradient tilted.vtu 1.03393141,0.14770449,1.18163590
look "a line: the same" gradient line.vtu 3.54490770,-1.77245385,0
look "two probes: the same, from one segment" gradient two.vtu 2.65868078,3.54490770,0
look "two probes: 5 apart" value two.vtu length 5
look "two probes: both are ends" value two.vtu hull 1
look "one place: its light" value one.vtu captured 1
printf '%s\n' '0 0 0' '1 0 0' '0.5 0.86602540378443865 0' | flat_stream 1,0,0 >equal.txt
probe-vtk --quiet -o equal.vtu equal.txt
look "an equilateral triangle: angles of 60 degrees" value equal.vtu min_angle 60
look "an equilateral triangle: aspect ratio 1" value equal.vtu aspect_ratio 1
look "an equilateral triangle: area sqrt(3)/4" value equal.vtu area 0.43301270189221932

# Degenerate cells come out finite.
sed 's/^0.5 0.28867513459481288 0.8164965809277260*[0-9]*/0.5 0.28867513459481288 0/' \
    regular.txt >flat.txt
probe-vtk --quiet -o flat.vtu flat.txt
look "a flat cell has an angle of 0" value flat.vtu min_dihedral 0
look "and no gradient" gradient flat.vtu 0,0,0

# Probes alone, with and without light, some of them not captured.
none='0 0 0 0 0 0 0 0 0'
nan7='nan nan nan nan nan nan nan'
cat >partly.txt <<STREAM
#?probe 1
sh-order 2
table probe position:f64:3 sh:f32:12 depth:f32:1 sh_gradient:f32:36
0 0 0 1 1 1 0 0 0 0 0 0 2 2 2 5 1 1 1 $none 2 2 2 $none 3 3 3 $none
1 0 0 $nan7 $nan7 $nan7 $nan7 $nan7 $nan7 $nan7
end
STREAM
check "probes alone are written" warning probe-vtk -o partly.vtu partly.txt
look "as vertices, missing values as 0" columns partly.vtu partly.txt
check "missing values are counted in a warning" \
    says warned 'column sh: 1 of 2 values are missing: 0 is written (and 2 more'
sed '/nan/d' partly.txt | probe-vtk --quiet -o whole.vtu
look "a captured probe says so" value whole.vtu captured 1
sed '/^0 0 0 1/d' partly.txt | probe-vtk --quiet -o missing.vtu
look "one that is not says so" value missing.vtu captured 0
look "light from +x is brightest there" value whole.vtu brightest 2,0,0
look "the gradient column gives the gradient of luminance" \
    value whole.vtu sh_luminance_gradient 0.88622693,1.77245385,2.65868078
grep -v '^[a-z]' points.txt | probe-place points --quiet - >dark.probe
check "probes without light are written" warning probe-vtk -o dark.vtu dark.probe
check "with a warning" says warned 'no light'
probe-vtk --quiet --text -o - dark.probe >dark.vtu
check "and nothing that would need light" \
    test -s dark.vtu and lacks dark.vtu irradiance luminance colour

# -- the scene -------------------------------------------------------------------------------------
cat >cube.obj <<'OBJ'
mtllib cube.mtl
v 0 0 0
v 2 0 0
v 2 2 0
v 0 2 0
v 0 0 2
v 2 0 2
v 2 2 2
v 0 2 2
usemtl half
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 3 4 8 7
f 2 3 7 6
f 1 5 8 4
OBJ
printf 'newmtl half\nKd 0.5 0.25 1\n' >cube.mtl
probe-vtk --quiet -o beside.vtu --scene cube.obj dark.probe
look "the scene goes beside the probes, with its area and its fronts outside" \
    solid beside.scene.vtp 24 8
look "with its albedo" value beside.scene.vtp albedo 0.5,0.25,1
look "and its colour: sRGB of the albedo" value beside.scene.vtp colour 188,137,255
probe-vtk --quiet -o beside.vtu --scene cube.obj --scene-output elsewhere.vtp --text dark.probe
look "--scene-output names it" solid elsewhere.vtp 24 8
probe-cat --text dark.probe | sed 's/^table probe/albedo-scale 0.5\n&/' |
    probe-vtk --quiet -o scaled.vtu --scene cube.obj
look "the bake's settings apply to it" value scaled.scene.vtp albedo 0.25,0.125,0.5
# One tetrahedron, placed as it stands and mirrored: fronts stay outside (glTF 2.0, 3.7.4).
"$python" - >mirrored.gltf <<'PYTHON'
import base64, json, struct
data = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
data += struct.pack("<12H", 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)
uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
print(json.dumps({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "nodes": [{"mesh": 0}, {"mesh": 0, "scale": [-2, 1, 1], "translation": [-1, 0, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "buffers": [{"byteLength": len(data), "uri": uri}],
    "bufferViews": [{"buffer": 0, "byteLength": 48},
                    {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 1, 1]},
                  {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]}))
PYTHON
probe-vtk --quiet -o mirrored.vtu --scene mirrored.gltf dark.probe
look "instances are placed, and a mirrored one keeps its fronts" \
    solid mirrored.scene.vtp 6.3660254 0.5

# -- what is refused -------------------------------------------------------------------------------
refused 2 "expected --output FILE.vtu" probe-vtk baked.probe
refused 2 "--scene-output needs --scene" probe-vtk -o x.vtu --scene-output y.vtp baked.probe
refused 2 "--scene needs --scene-output" probe-vtk -o - --scene cube.obj baked.probe
refused 2 "are the same" probe-vtk -o x.vtu --scene cube.obj --scene-output x.vtu baked.probe
refused 2 "--exposure: expected a number greater than 0, got 0" \
    probe-vtk -o x.vtu --exposure 0 baked.probe
refused 2 "unexpected operand" probe-vtk -o x.vtu baked.probe baked.probe
refused 1 "nothing.probe: No such file" probe-vtk -o x.vtu nothing.probe
refused 1 "stdin: expected a probe stream, got nothing" probe-vtk -o x.vtu </dev/null
head -c 3000 baked.probe >cut.probe
refused 1 "it is not whole" probe-vtk -o x.vtu cut.probe
printf '%s\n' '#?probe 1' end >none.probe
refused 1 "none.probe: there are no probes" probe-vtk -o x.vtu none.probe
printf '%s\n' '0 0 0' 'table tet quality:f32:1' 1 |
    stream_of 'table probe position:f64:3' >shapeless.probe
refused 1 "column vertex:i32" probe-vtk -o x.vtu shapeless.probe
refused 1 "nothing.obj: No such file" probe-vtk -o x.vtu --scene nothing.obj baked.probe
check "nothing was written by what was refused" [ ! -e x.vtu ]
refused 1 "nowhere/x.vtu: No such file or directory" probe-vtk -o nowhere/x.vtu baked.probe
refused 1 "/dev/full: No space left on device" probe-vtk -o /dev/full baked.probe
check "/dev/full is still there" test -c /dev/full
refused 1 "stdout: No space left on device" into /dev/full probe-vtk -o - baked.probe

# A disk that fills up, at several places, with VTK's writers halfway: the old file stays, and
# nothing beside it.
mkdir full
full_after() ( # BLOCKS COMMAND...
    trap '' XFSZ
    ulimit -f "$1"
    shift
    "$@" 2>said
)
for encoding in --text --compress --quiet; do
    for blocks in 4 16 64; do
        printf 'old' >full/old.vtu
        full_after "$blocks" probe-vtk --quiet "$encoding" -o full/old.vtu linear.txt
        status=$?
        check "full after $blocks blocks ($encoding): one message, the old file stays" \
            [ $status -eq 1 ] and [ "$(cat full/old.vtu)" = old ] and [ "$(ls full)" = old.vtu ] \
            and says said '^probe-vtk: full/old.vtu: File too large$' and has_lines 1 said
    done
done

# -- pictures --------------------------------------------------------------------------------------
probe-vtk --quiet -o rooms.vtu --scene "$rooms" baked.probe
if sanitized; then
    skip "scripts/picture: it runs nothing that is built with sanitizers"
elif ! "$python" -c 'import numpy, vtkmodules.vtkIOXML' 2>/dev/null; then
    skip "scripts/picture: python3-vtk9 or python3-numpy is not installed"
elif [ -z "${DISPLAY:-}" ] && ! command -v Xvfb >/dev/null; then
    skip "scripts/picture: there is neither a display nor Xvfb"
else
    picture=$SRC/scripts/picture
    whats='probes cells both slice'
    drawing=
    for what in $whats; do
        { "$picture" --scene rooms.scene.vtp --what "$what" --size 320x200 "$what.png" rooms.vtu
            echo $?; } >"$what.said" 2>&1 &
        drawing="$drawing $!"
    done
    wait $drawing
    for what in $whats; do
        check "picture of $what, of four at once" given 0 diff - "$what.said"
        look "it shows something" picture "$what.png" 320x200
    done
    probe-cat -q --drop sight,stand_in baked.probe >blind.probe
    for light in baked blind; do
        "$picture" --what slice --light $light.probe --exposure 1 --size 320x200 $light.png \
            rooms.vtu
    done
    look "a slice by probe-query shows something" picture baked.png 320x200
    check "what probe-query sees of walls is in it" differ baked.png blind.png
    refused 1 "nothing.probe: probe-query answers nothing" \
        "$picture" --what slice --light nothing.probe x.png rooms.vtu
    refused 2 "--light is of --what slice" "$picture" --light baked.probe x.png rooms.vtu
    check "picture without light, scene or cells" "$picture" --size 320x200 dark.png dark.vtu
    refused 1 "dark.vtu: there are no tetrahedra" "$picture" --what cells x.png dark.vtu
    refused 1 "nothing.vtu: no such file" "$picture" x.png nothing.vtu
    refused 1 "baked.txt: expected a file of probe-vtk" "$picture" x.png baked.txt
    refused 1 "nowhere/x.png: No such file or directory" \
        "$picture" --size 32x32 nowhere/x.png dark.vtu
    mkdir broken
    printf '%s\n' '#!/bin/sh' 'echo no room >&2' 'exit 3' >broken/Xvfb
    chmod +x broken/Xvfb
    refused 1 "picture: Xvfb does not start: no room" \
        env -u DISPLAY PATH="$PWD/broken:$PATH" "$picture" --size 32x32 x.png dark.vtu
    refused 2 "--size" "$picture" --size 5 x.png dark.vtu
fi
tap_done
