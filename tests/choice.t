#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What of a scene is left out by name: --exclude and --only, in every program that reads one; what
# it says should be, and what of it makes all probes black.
. "${SRC:?}/tests/support/setup.sh"

# A cube of -1..1, whose fronts are outside, and a floor of -1..1, both by glTF's buffer.
one='\000\000\200\077' less='\000\000\200\277' zero='\000\000\000\000'
{
    for z in "$less" "$one"; do
        printf "$less$less$z$one$less$z$one$one$z$less$one$z"
    done
    for i in 0 3 2 0 2 1 4 5 6 4 6 7 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7; do
        printf "\\$i\\000"
    done
    printf "$less$zero$less$less$zero$one$one$zero$one$one$zero$less"
    for i in 0 1 2 0 2 3; do printf "\\$i\\000"; done
} >buffer
cat >head <<GLTF
{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_unlit"],
 "buffers": [{"byteLength": 228,
   "uri": "data:application/octet-stream;base64,$(base64 -w0 buffer)"}],
 "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72},
   {"buffer": 0, "byteOffset": 168, "byteLength": 48},
   {"buffer": 0, "byteOffset": 216, "byteLength": 12}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
   {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
   {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC3"},
   {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"}],
GLTF
# gltf JSON...: the scene of these meshes, materials and nodes, of which node 0 is the root
gltf() {
    cat head
    printf '%s\n' "$@" '"scenes": [{"nodes": [0]}]}'
}
floor='{"attributes": {"POSITION": 2}, "indices": 3, "material": 0}'
cube='{"attributes": {"POSITION": 0}, "indices": 1, "material": 1}'
meshes="\"meshes\": [{\"name\": \"Floor\", \"primitives\": [$floor]},
    {\"name\": \"Box\", \"primitives\": [$cube]}, {\"primitives\": [$floor, $cube]}],"
gltf '"extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "name": "Bulb"}]}},' \
    "$meshes" '"materials": [{"name": "stone"}, {"name": "wood"}], "nodes": [
    {"name": "Hall", "children": [1, 2, 8]},
    {"name": "Ground", "mesh": 0, "scale": [9, 1, 9]},
    {"name": "my props", "children": [3, 4, 5, 6, 7]},
    {"name": "Crate1", "mesh": 1, "translation": [3, 1, 0]},
    {"name": "Crate[1]", "mesh": 1, "translation": [-3, 1, 0]},
    {"name": "a/b", "mesh": 1, "translation": [0, 1, 3]},
    {"name": "Möbel", "mesh": 1, "translation": [0, 1, -3]},
    {"mesh": 2, "translation": [6, 1, 6]},
    {"name": "Lamp", "translation": [0, 5, 0],
     "extensions": {"KHR_lights_punctual": {"light": 0}}}],' >hall.gltf

# lists KIND COUNT NAME...: names of --list and how many triangles they have
tab=$(printf '\t')
lists() {
    while [ $# -ge 3 ]; do
        grep -qxF "$1$tab$2$tab$3" list || { cat list; return 1; }
        shift 3
    done
}
# left OPTION...: how many triangles of the hall are left, and lights
left() {
    probe-place --list "$@" hall.gltf 2>err >list || { cat err; return 1; }
    awk -F "$tab" '$1 == "material" { n += $2 } END { print n }' list
}
leaves() {
    leaves_count=$1
    shift
    [ "$(left "$@")" = "$leaves_count" ]
}
# -- names -----------------------------------------------------------------------------------------
check "names are listed, with what hangs from them" into list probe-place --list hall.gltf and \
    lists node 64 Hall node 2 Hall/Ground node 62 'Hall/my props' node 12 'Hall/my props/Crate[1]' \
    node 12 'Hall/my props/Möbel' node 14 'Hall/my props/node 7' node 0 Hall/Lamp \
    light 0 Hall/Lamp/Bulb mesh 2 Floor mesh 48 Box mesh 14 'mesh 2' material 4 stone \
    material 60 wood
check "a node goes by its name" leaves 52 --exclude Crate1
check "with what hangs from it, and a blank in its name" leaves 2 --exclude 'my props'
check "which a warning says" says err 'hall.gltf: --exclude and --only leave out 62 of 64 triangles'
check "a pattern names several" leaves 40 --exclude 'Crate*'
check "a name as it stands is none" leaves 52 --exclude 'Crate[1]'
check "what it would match as one is said" \
    says err "'Crate\[1\]' is a name as it stands.*the 1 names"
check "but not where it matches nothing more" leaves 52 --exclude 'M?bel' and lacks err 'stands'
check "as --list prints it, too" leaves 52 --exclude 'Hall/my props/Crate[1]'
check "which a shell's pattern may match" leaves 40 --exclude 'Hall/my props/Crate*'
check "nor is one whose pattern is quoted" leaves 52 --exclude 'Crate\[1\]'
check "a slash is no end of a name" leaves 52 --exclude 'a/b'
check "nodes by what they hang from" leaves 40 --exclude 'Hall/*/Crate*'
check "from any on" leaves 40 --exclude 'my props/Crate*'
check "? is a letter of UTF-8" leaves 52 --exclude 'M?bel'
check "what has no name is known by its number" leaves 50 --exclude 'node 7'
check "a mesh" leaves 16 --exclude Box
check "a mesh without a name" leaves 50 --exclude 'mesh 2'
check "a material of a part of a mesh" leaves 4 --exclude wood
check "--only a node" leaves 2 --only Ground
check "--only what hangs from one, but for some" leaves 14 --only 'my props' --exclude Box
check "--only a material" leaves 4 --only stone
check "a mesh that is kept as a whole here, in part there" leaves 16 --only stone --only Crate1
check "patterns repeat" leaves 28 --exclude Crate1 --exclude 'Crate\[1\]' --exclude a/b
refused 1 "hall.gltf: --exclude 'crate1': nothing has such a name; the \
nearest: node 'Crate1', node 'Crate[1]'" probe-place --list --exclude crate1 hall.gltf
refused 1 "the nearest: node 'my props'" \
    probe-place --list --only '*props?' hall.gltf
refused 1 'leave none of its 64 triangles' \
    probe-place --list --exclude Hall hall.gltf
refused 2 'expected a name' probe-place --list --only '' hall.gltf
refused 2 'need a SCENE' \
    probe-place grid --bounds 0,0,0,1,1,1 --spacing 1 --only x

# -- OBJ, and files without names ------------------------------------------------------------------
cat >yard.obj <<'OBJ'
v 0 0 0
v 1 0 0
v 1 0 1
v 0 0 1
usemtl grass
f 1 2 3
o my house
g wall north
f 1 2 3 4
g wall south
f 1 2 3
f 1 2 3 3
usemtl tile
o my house
f 4 3 2 1
o roof # of tiles
f 1 3 4
OBJ
yard() { # TRIANGLES OPTION...
    yard_count=$1
    shift
    probe-place --list "$@" yard.obj 2>err >list && awk -F "$tab" -v n="$yard_count" \
        '$1 == "material" { sum += $2 } END { exit sum != n }' list
}
check "an OBJ has objects, groups, and materials" yard 8 and lists object 6 'my house' \
    group 2 'my house/wall north' group 2 'my house/wall south' object 1 roof
check "an object, with its groups" yard 2 --exclude 'my house'
check "one of the groups that faces are in" yard 6 --exclude north
check "all of one" yard 4 --exclude wall
check "both as they are named" yard 6 --exclude 'wall north'
check "by path" yard 4 --exclude 'my house/wall*'
check "--only an object" yard 1 --only roof
check "materials are known by number where the file defines none" yard 8 and \
    lists material 8 'material 0'
printf '%s\n' 'v 0 0 0' 'v 1 0 0' 'v 0 1 0' 'f 1 2 3' >bare.obj
printf '%s\n' 'OFF' '3 1 0' '0 0 0' '1 0 0' '0 1 0' '3 0 1 2' >bare.off
refused 1 "bare.obj: --exclude 'x': this file names nothing" \
    probe-place --list --exclude x bare.obj
refused 1 'PLY, OFF and STL have no names' probe-place --list --only x bare.off
check "a scene from a pipe" sh -c 'cat hall.gltf | probe-place --list --only Ground - >list' and \
    lists material 2 stone material 0 wood

# -- the bake --------------------------------------------------------------------------------------
# An unlit dome shuts the sky out. The same scene without it, by hand:
domed() { # CHILDREN
    gltf "$meshes" "\"materials\": [{\"name\": \"stone\"}, {\"name\": \"sky\",
        \"extensions\": {\"KHR_materials_unlit\": {}}}], \"nodes\": [
        {\"name\": \"Root\", \"children\": [$1]}, {\"name\": \"Ground\", \"mesh\": 0,
         \"scale\": [9, 1, 9]}, {\"name\": \"Dome\", \"mesh\": 1, \"scale\": [20, 20, 20]}],"
}
domed '1, 2' >domed.gltf
domed 1 >open.gltf
echo '0 2 0' >point.txt
light='--rays 64 --sky 1,1,1 --sun 0,-1,0,3,3,3'
place() { probe-place points -q --inside keep --text "$@"; }
values() { probe-cat --text --tables probe "$1" | numbers; }
place point.txt open.gltf | probe-capture -q $light open.gltf >open.probe
place --exclude Dome point.txt domed.gltf >placed.probe
check "the header keeps what was left out" says placed.probe '^exclude-1 Dome$'
probe-capture $light domed.gltf placed.probe >captured.probe 2>err
values open.probe >want
values captured.probe >have
check "the next program leaves it out as well: the light is that of the scene without it" \
    cmp want have and says captured.probe '^exclude-1 Dome$'
place point.txt domed.gltf | probe-capture -q $light --exclude Dome domed.gltf >late.probe
values late.probe >have
check "or the first that says so" cmp want have and says late.probe '^exclude-1 Dome$'
cat domed.gltf | probe-capture -q $light --again - captured.probe >again.probe
values again.probe >have
check "a scene from a pipe, by the header" cmp want have
probe-capture $light --only Ground domed.gltf placed.probe >other.probe 2>err
check "another choice takes the header's place, and is named" says other.probe '^only-1 Ground$' \
    and says err "scene with --exclude 'Dome'; --only 'Ground' takes its place" and \
    sh -c '! grep -q ^exclude-1 other.probe'
refused 1 'captured in another scene' probe-capture --only '*' domed.gltf captured.probe

printf '%s\n' '-5 1 -5' '5 1 -5' '0 1 5' '0 5 0' >four.txt
place --exclude Dome four.txt domed.gltf | probe-capture -q $light domed.gltf | probe-tet -q |
    probe-leakfix -q domed.gltf >baked.probe
check "probe-leakfix knows it" says baked.probe '^exclude-1 Dome$'
check "probe-error measures the same scene" into out \
    probe-error -q -n 4 --truth-rays 16 --paths 0 domed.gltf baked.probe
refused 1 'not the scene' \
    probe-error -q -n 4 --only '*' domed.gltf baked.probe
probe-vtk -q --text -o baked.vtu --scene domed.gltf baked.probe
check "probe-vtk shows the same scene" says baked.scene.vtp 'NumberOfPolys="2"'
probe-vtk -q --text -o baked.vtu --scene domed.gltf --only '*' baked.probe
check "or another" says baked.scene.vtp 'NumberOfPolys="14"'
refused 2 'need --scene' probe-vtk -o baked.vtu --only '*' baked.probe
view='--eye 0,3,0 --look-at 1,9,0 --size 8x8 --samples 1 --mode truth'
probe-render -q $view --pfm with.pfm domed.gltf baked.probe >out
probe-render -q $view --pfm without.pfm --only '*' open.gltf baked.probe >out
check "probe-render, too" cmp with.pfm without.pfm

# -- hints -----------------------------------------------------------------------------------------
# said PATTERN COUNT COMMAND...: so many lines of what it says match
said() {
    said_pattern=$1
    said_count=$2
    shift 2
    "$@" >out 2>err || { cat err; return 1; }
    [ "$(grep -c "$said_pattern" err)" -eq "$said_count" ] || { cat err; return 1; }
}
check "an unlit dome is named once, with the option" said "node 'Dome' is unlit and surrounds all \
else.*--exclude 'Dome' leaves it out" 1 probe-place --list domed.gltf
check "in one warning" has_lines 1 err
check "which is silent when it is left out" said . 1 probe-place --list --exclude Dome domed.gltf \
    and says err 'leave out'
# dome MATERIAL ROOT: a dome of this material in a node of this name
dome() {
    gltf "$meshes" "\"materials\": [{\"name\": \"stone\"}, {\"name\": \"m\", $1}], \"nodes\": [
        {\"name\": \"Root\", \"children\": [1, 2]}, {\"name\": \"Ground\", \"mesh\": 0,
         \"scale\": [9, 1, 9]}, {\"name\": \"$2\", \"mesh\": 1, \"scale\": [20, 20, 20]}],"
}
plain='"doubleSided": false'
unlit='"extensions": {"KHR_materials_unlit": {}}'
emits='"emissiveFactor": [1, 1, 1]'
place point.txt open.gltf >bare.probe
capture() { probe-capture -r 4 "$@" bare.probe; }
dome "$plain" Walls >room.gltf
check "walls are no dome" said . 0 probe-place --list room.gltf and \
    said surrounds 0 capture --sky 1,1,1 room.gltf
dome "$plain" sky_box >sky.gltf
check "a box is one by its name" said "node 'sky_box' surrounds all else" 1 \
    probe-place --list sky.gltf
dome "$emits" Walls >lamps.gltf
check "one that emits is light" said surrounds 0 capture lamps.gltf
check "where there is no sky to be shut out" said "'Walls' emits and surrounds" 1 \
    capture --sky 1,1,1 lamps.gltf
dome "$unlit, \"alphaMode\": \"BLEND\"" Veil >veil.gltf
check "what lets light through is none" said surrounds 0 probe-place --list veil.gltf
sed 's/"scale": \[20, 20, 20\]/"scale": [8, 8, 8]/' domed.gltf >small.gltf
check "nor what is smaller than the rest; it is told that it is unlit" said surrounds 0 \
    probe-place --list small.gltf and says err "material 'sky' is unlit"

# Half a ball over a square, in OBJ: rings of 12 corners.
ball() { # RADIUS HEIGHT of the square
    awk -v r="$1" -v h="$2" 'BEGIN {
        for (j = 0; j < 6; j++) for (i = 0; i < 12; i++) {
            a = j * 3.14159265 / 12; b = i * 3.14159265 / 6
            print "v", r * cos(a) * cos(b), r * sin(a), r * cos(a) * sin(b)
        }
        print "v 0", r, "0\ng ball"
        for (j = 0; j < 5; j++) for (i = 0; i < 12; i++) {
            k = (i + 1) % 12
            print "f", j * 12 + i + 1, j * 12 + 12 + i + 1, j * 12 + 12 + k + 1, j * 12 + k + 1
        }
        for (i = 0; i < 12; i++) print "f", 61 + i, 73, 61 + (i + 1) % 12
        print "v -1", h, "-1\nv 1", h, "-1\nv 1", h, "1\nv -1", h, "1\ng floor\nf -1 -2 -3 -4"
    }'
}
ball 10 0 >half.obj
check "half a ball, as a group" said "group 'ball' is round and surrounds all else" 1 \
    probe-place --list half.obj
ball 10 -1 >half.obj
check "though the ground is below its rim" said "group 'ball' is round" 1 \
    probe-place --list half.obj
ball 1.5 0 >half.obj
check "but not close to what it holds" said surrounds 0 probe-place --list half.obj

# names NAME...: nodes of these names, each a box, and a mesh that says nothing
named() {
    {
        cat head
        echo "$meshes" '"materials": [{"name": "a"}, {"name": "b"}],'
        echo '"nodes": [{"name": "Root", "children": [1'
        named_last=1
        for named_name; do
            named_last=$((named_last + 1))
            echo ", $named_last"
        done
        echo ']}, {"mesh": 0}'
        for named_name; do echo ", {\"name\": \"$named_name\", \"mesh\": 1}"; done
        echo '], "scenes": [{"nodes": [0]}]}'
    } >named.gltf
}
named UCX_Wall_01 UCX_Wall_02
check "hulls by name, in one warning, with a pattern for all" said \
    "node 'UCX_Wall_01', 12 triangles, .*--exclude 'UCX_\*' leaves it out (and 1 more like it)" 1 \
    probe-place --list named.gltf
check "which then is silent" said 'collision' 0 probe-place --list --exclude 'UCX_*' named.gltf
for name in wall-colonly Wall-col.001 MyCollisionMesh box_collider Wall-occ; do
    named "$name"
    check "$name is one" said "node '$name', .*--exclude" 1 probe-place --list named.gltf
    pattern=$(sed "s/.*--exclude '\([^']*\)'.*/\1/" err)
    check "and its pattern leaves it out" said 'named as' 0 \
        probe-place --list --exclude "$pattern" named.gltf
done
named Column protocol colour Colony.001 Ucx Cliff-colour 'Iron collar' Explode1 pilot2
check "names that are none" said . 0 probe-place --list named.gltf
named rock_LOD0 rock_LOD1 rock_LOD2
check "coarser forms of what is there" said "'rock_LOD1', .*--exclude '\*LOD\[1-9\]\*'.*1 more" 1 \
    probe-place --list named.gltf
check "the pattern leaves them out" said . 1 probe-place --list --exclude '*LOD[1-9]*' named.gltf
named rock_LOD1
check "but not where they are all there is" said . 0 probe-place --list named.gltf

# -- all black -------------------------------------------------------------------------------------
place four.txt room.gltf >shut.probe
black='all 4 probes are black though there is light'
dark() { probe-capture -r 16 "$@" shut.probe; }
check "a sky that is shut out is said, with what is in the way" said \
    "$black; .* 100 % are stopped, first by material 'm' of node 'Root/Walls'" 1 \
    dark --sky 1,1,1 room.gltf
check "a sun" said "$black; .*'Root/Walls' (100 %)" 1 dark --sun 0,-1,0,1,1,1 room.gltf
check "a lamp" said "$black; .*'Root/Walls' (100 %)" 1 dark --point 0,50,0,1,1,1 room.gltf
check "a spot that shines elsewhere" said "$black, and little stands in its way" 1 \
    dark --spot 0,50,0,0,1,0,10,20,1,1,1 room.gltf
check "nothing where some light comes" said black 0 dark --point 0,3,0,1,1,1 room.gltf
check "nor where there is none: that is another warning" said 'all probes are black' 1 \
    dark room.gltf and says err 'no light'
printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n' >night.hdr
head -c 128 /dev/zero >>night.hdr
check "a black picture of the sky is none" said 'there is no light' 1 \
    dark --sky night.hdr room.gltf and lacks err "$black"
check "nor are a sun and a lamp of 0" said 'there is no light' 1 \
    dark --sun 0,-1,0,0,0,0 --point 0,3,0,0,0,0 room.gltf
check "a lamp that was left out is none" said 'there is no light' 1 \
    dark --exclude Walls lamps.gltf
ball 10 0 >lamp.obj
printf '%s\n' 'newmtl l' 'Ke 1 1 1' >l.mtl
{ echo mtllib l.mtl; cat lamp.obj; printf '%s\n' 'v 0 20 0' 'v 1 20 0' 'v 0 20 1' 'usemtl l' \
    'g lamp' 'f -1 -2 -3'; } >lamp2.obj
echo '0 1 0' | place - lamp2.obj >one.probe
check "a lamp of the file, behind a group" said "of group 'ball' (100 %)" 1 \
    probe-capture -r 16 lamp2.obj one.probe

# -- decimated -------------------------------------------------------------------------------------
place point.txt domed.gltf >point.probe
check "what is left out is, before the scene is decimated" into thin.probe \
    probe-capture -q -r 16 $light --decimate .5 --exclude Dome domed.gltf point.probe and \
    says thin.probe '^exclude-1 Dome$'
check "and where the header says so" into again.probe \
    probe-capture -q -r 16 --again domed.gltf thin.probe
check "what is in the way has its name when decimated" \
    said "first by material 'm' of node 'Root/Walls'" 1 \
    dark --sky 1,1,1 --decimate .9 room.gltf
check "and its group" said "of group 'ball' (100 %)" 1 \
    probe-capture -r 16 --decimate .5 lamp2.obj one.probe

tap_done
