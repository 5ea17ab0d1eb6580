#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Where a body gets to: probe-place reach, and --reach of the other methods and of probe-error.
# The body is the default one: .3 wide to each side, 1.8 high, climbs .4, falls 3; cells of .15.
. "${SRC:?}/tests/support/setup.sh"

# box X0 Y0 Z0 X1 Y1 Z1 [in]: the faces of a box, looking outward or in
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
# walked SCENE START [OPTION]...: middles of bodies, in rows
walked() {
    walked_scene=$1 walked_start=$2
    shift 2
    echo "$walked_start" | probe-place reach -j1 --text "$@" - "$walked_scene" 2>err | numbers >rows
}
# gets CONDITION: somebody does, of rows
gets() {
    awk 'function near(a, b, eps) { return (a - b) ^ 2 <= eps ^ 2 }
        '"$1"' { n++ } END { exit !n }' rows
}
# each_row STREAM CONDITION
each_row() {
    rows_of position "$1" >rows
    every "$2" rows
}

box 0 0 0 4 3 4 in >room.obj
walked room.obj '2 1 2'
check "a room of 4 by 4 has 23 x 23 places, as far from its walls as the body is wide" \
    has_lines 529 rows and every 'near($2, .9, 1e-5) && $1 > .34 && $1 < 3.66' rows
for y in 0 -.001 .02 2.9 2.97; do # at the feet or the eyes; above its head, below the ceiling
    walked room.obj "2 $y 2"
    has_lines 529 rows && echo so
done >same
check "from wherever in it a start is" has_lines 5 same
walked room.obj '2 1 2' --fly
check "and 16 layers of them for a ball" has_lines 8464 rows
awk '/^v/ { print $1, 100 * $2, 100 * $3, 100 * $4; next } { print }' room.obj >cm.obj
walked room.obj '2 1 2' --fly --cell .2
check "or 17 x 17 x 12 of another lattice" has_lines 3468 rows
walked cm.obj '200 100 200' --radius 30 --height 180 --climb 40 --drop 300
check "lengths are in units of the scene" has_lines 529 rows
walked cm.obj '200 1 200' --max-cells 5000
check "one that is too fine is refused" \
    says err 'stdin:1: .* more than 5000 cells of 0.15: --cell .* --max-cells'

# stairs HEIGHT: five steps along X to a platform
stairs() {
    box 0 0 0 8 6 2 in
    for k in 0 1 2 3 4; do
        echo "$k $1" | awk '{ print 2.5 + .6 * $1, -.1, -.1, 8.1, $2 * ($1 + 1), 2.1 }'
    done | while read -r corners; do
        # shellcheck disable=SC2086
        box $corners
    done
}
stairs .2 >low.obj
walked low.obj '1 1 1'
check "stairs of .2 are climbed" gets 'near($2, 1.9, 1e-5)'
stairs .6 >high.obj
walked high.obj '1 1 1'
check "those of .6 are not" every 'near($2, .9, 1e-5)' rows
walked high.obj '6.5 4 1'
check "but they are fallen down" gets '$2 < 1'
walked high.obj '6.5 4 1' --drop .55
check "by a body that may fall so far" every 'near($2, 3.9, 1e-5)' rows

# door WIDTH: in a wall between two rooms
door() {
    box 0 0 0 8 3 4 in
    box 3.9 -.1 -.1 4.1 3.1 "$(echo "$1" | awk '{ print 2 - $1 / 2 }')"
    box 3.9 -.1 "$(echo "$1" | awk '{ print 2 + $1 / 2 }')" 4.1 3.1 4.1
}
door .55 >narrow.obj
walked narrow.obj '1 1 1.93'
check "a door narrower than the body is none" every '$1 < 3.7' rows
door .76 >wide.obj
walked wide.obj '1 1 1.93'
check "one wider by a cell is, wherever the cells are" gets '$1 > 4.3'
awk '/^v/ { c = cos(.5); s = sin(.5); print $1, c * $2 + s * $4, $3, c * $4 - s * $2; next }
    { print }' wide.obj >turned.obj
for z in 1.85 1.95 2.05; do
    awk -v z=$z 'BEGIN { c = cos(.5); s = sin(.5); print c + s * z, 1, c * z - s }' >start
    walked turned.obj "$(cat start)"
    gets 'cos(.5) * $1 - sin(.5) * $3 > 4.3' && echo passed
done >passed
check "and where the wall is turned" has_lines 3 passed
for height in 1.75 1.85; do
    { box 0 0 0 8 3 4 in; box 4 $height -.1 8.1 3.1 4.1; } >ceiling.obj
    walked ceiling.obj '1 1 2'
    awk '$1 > 5 { n++ } END { print (n > 0) }' rows
done | paste -s -d ' ' - >passed
check "nobody gets below a ceiling of 1.75, but below one of 1.85" says passed '^0 1$'
for height in .39 .41; do
    { box 0 0 0 8 3 4 in; box 3.97 -.1 -.1 4.03 $height 4.1; } >fence$height.obj
    walked fence$height.obj '1 1 2'
    awk '$1 > 5 { n++ } END { print (n > 0) }' rows
done | paste -s -d ' ' - >passed
check "a thin fence of .39 is stepped over, one of .41 is not" says passed '^1 0$'
walked fence.41.obj '1 1 2' --fly
check "it is flown over" gets '$1 > 5'
{
    box 0 0 0 9 6 4 in
    box 6 2.2 -.1 9.1 2.4 4.1
    printf '%s\n' 'v 1 0 -.1' 'v 1 0 4.1' 'v 6.05 2.41 4.1' 'v 6.05 2.41 -.1' 'f -4 -3 -2 -1'
} >levels.obj
walked levels.obj '8 1 2' --drop 0
check "a level above is reached by a ramp from below, to which nobody gets through it" \
    every '$1 > 4.5 && near($2, .9, 1e-5)' rows
walked levels.obj '.5 1 2'
check "from before it" gets '$1 > 8 && near($2, 3.3, 1e-3)' and gets '$1 < .5 && $2 < 1'
check "and what is below by falling off, no more" every '$2 < 3.4' rows
awk 'BEGIN {
    for (i = -10; i < 10; i++)
        for (k = -3; k < 3; k++)
            for (c = 0; c < 4; c++) {
                x = i + (c == 2 || c == 3); z = k + (c == 1 || c == 2)
                print "v", x, 2 + 2 * sin(x / 3), z
                if (c == 3) print "f -4 -3 -2 -1"
            }
    }' >hills.obj
walked hills.obj '0 3 0' --cell .3
check "on open hills it follows the ground" \
    every 'near($2 - .9, 2 + 2 * sin($1 / 3), .05)' rows and gets '$1 < -9.5' and gets '$1 > 9.5'

printf '%s\n' 'v -3 0 -3' 'v -3 0 3' 'v 3 0 3' 'v 3 0 -3' 'f 1 2 3 4' >flat.obj
walked flat.obj '0 0 0' --cell .3
check "and a flat one to its ends" has_lines 441 rows

# -- starts ----------------------------------------------------------------------------------------
# A room with a block, and another room; nothing is between them.
{ box 0 0 0 4 3 4 in; box 1 -.1 1 2 2 2; box 6 0 0 9 3 4 in; } >two.obj
printf '%s\n' '3 1 3' '7 1 1 # the other one' >starts.txt
probe-place reach starts.txt two.obj >both.probe 2>err
check "a region that is cut is kept, and said" \
    says err 'starts.txt: the region is cut in 2, nobody gets from one to another: all are kept'
printf '%s\n' '3 1 3' '3 1 1' >same.txt
probe-place reach same.txt two.obj >/dev/null 2>err
check "two starts in one part are no cut" lacks err 'cut in'
refuse() { # refuse MESSAGE START [OPTION]...
    refuse_message=$1
    { echo '# two'; echo '3 1 3'; echo "$2"; } >refused.txt
    shift 2
    refused 1 "refused.txt:3: $refuse_message" probe-place reach "$@" refused.txt two.obj
}
refuse 'the start 1.5 1 1.5 is inside a solid' '1.5 1 1.5'
refuse 'the start 5 1 2 is outside of a closed room' '5 1 2'
refuse 'the start 5 1 20 is outside of the scene, which is from 0' '5 1 20'
refuse 'no body of radius 0.3 fits at 3.9 1 2: a surface, higher than it climbs, is 0.1 from' \
    '3.9 1 2'
refused 1 'no body of height 3.2 fits at 3 1 3: what is above the floor leaves 3 (--height' \
    probe-place reach --height 3.2 starts.txt two.obj
refuse 'a ball of radius 0.3 does not fit at 3.9 1 2: a surface is 0.1 away' '3.9 1 2' --fly
refuse 'there is no floor below 3 2.9 2, no farther than 2.8 down' '3 2.9 2' --drop 1
refuse 'a ball of radius 0.3 does not fit at 3 2.9 2: a surface is 0.1 away' '3 2.9 2' --fly
refuse 'there is no floor below 3 2.97 2, no farther than 2.8 down' '3 2.97 2' --drop 1
refused 1 'a step of at most half the height, 0.1, that the body climbs, got 0.4 (--climb)' \
    probe-place reach --height .2 starts.txt two.obj
refused 1 'a radius of at most half the height, 0.45, got 0.6 (--radius, --height;' \
    probe-place reach --radius .6 --height .9 starts.txt two.obj
refused 1 'at most 1000 times as high as its radius, got 1.8 and 1e-05' \
    probe-place reach --radius 1e-5 starts.txt two.obj
refused 2 "reach: expected a SCENE" probe-place reach starts.txt
refused 2 "reach goes with other methods" probe-place reach --reach starts.txt starts.txt two.obj
refused 2 "radius goes with --reach, or the method reach" \
    probe-place grid --radius .2 --count 9 two.obj
for option in height climb drop headroom; do
    refused 2 "$option is of a body that walks: --fly" \
        probe-place reach --fly --$option .5 starts.txt two.obj
done
refused 2 "drop is of a body that walks" probe-place grid --count 9 --reach x --fly --drop 1 two.obj
refused 2 "climb is of a body that walks" probe-error --reach x --fly --climb .1 two.obj x.probe
refused 2 "headroom is of a body that walks" probe-bake --reach x --fly --headroom .1 two.obj
refused 2 "FILE and the start points of --reach cannot both" probe-place points - --reach - two.obj
refused 2 "start points of --reach and the probes of --keep cannot both" \
    probe-place adaptive --probes 9 --reach - --keep /dev/stdin two.obj
refused 2 "reach needs a SCENE" \
    probe-place grid --reach starts.txt --spacing 1 --bounds 0,0,0,1,1,1
refused 2 "standard input: it is read more than once" probe-error --reach - two.obj starts.txt

probe-place reach --progress --cell .5 starts.txt two.obj 2>said | probe-cat --text | numbers >rows
check "the flood shows how far it is" says said 'probe-place: [1-9][0-9]* places, ' \
    and test -s rows

# -- what takes it ---------------------------------------------------------------------------------
echo '3 1 3' >start.txt
probe-place grid -q --spacing .8 --reach start.txt two.obj >grid.probe
check "a grid is in the region and a cell around it" \
    each_row grid.probe '$1 < 4 && $2 < 2.9'
probe-place grid -q --count 200 --reach start.txt two.obj >count.probe
check "and by count as fine as that allows" [ "$(row_count probe count.probe)" -gt 120 ] and \
    [ "$(row_count probe count.probe)" -le 200 ]
probe-place grid -q --count 100 --ground 2 --reach start.txt two.obj >ground.probe
check "on the floor of a room with a ceiling, too" [ "$(row_count probe ground.probe)" -gt 40 ] \
    and [ "$(row_count probe ground.probe)" -le 100 ] and each_row ground.probe '$2 < 2.9'
probe-place points --reach start.txt --text starts.txt two.obj >points.probe 2>err
check "points that are out of reach go" says points.probe '^3 1 3' and lacks points.probe '^7 1 1' \
    and says err '1 of 2 positions are out of reach: dropped'
for threads in 1 2; do
    probe-place reach -q --threads $threads starts.txt two.obj >threads$threads.probe
done
check "the same bytes for any number of threads" \
    cmp threads1.probe threads2.probe and test -s threads1.probe
lamp='--point 2,2.5,3,9,9,9 --point 8,2.5,3,9,9,9'
# shellcheck disable=SC2086
probe-place adaptive -q --probes 8 --rays 16 --bounces 0 --reach start.txt $lamp two.obj \
    >adaptive.probe
check "adaptive probes are in it" each_row adaptive.probe '$1 < 4 && $2 < 2.2'
# shellcheck disable=SC2086
probe-place spawn-merge -q $lamp --count 60 --rays 16 --rounds 2 --reach start.txt two.obj \
    >merged.probe
check "spawn-merge starts in it" each_row merged.probe '$1 < 4.2'
# a lamp above a block that is too high to climb
{ box 0 0 0 4 3 4 in; box 3 -.1 -.1 4.1 1.2 4.1; } >block.obj
echo '1 1 2' >low.txt
probe-place ascent -q --light direct --point 3.6,2,2,9,9,9 --spacing .5 --rays 64 --rounds 8 \
    --merge-distance 0 --reach low.txt block.obj >climbed.probe
rows_of position,steps climbed.probe >rows
check "no step of ascent leaves it" every '$4 == 0 || ($1 < 3.1 && $2 < 2.11)' rows \
    and awk '$4 { n++ } END { exit n < 9 }' rows
probe-place octree -q --levels 0:2 --cut all --bounds 0,0,0,9,3,4 --cells 4,2,2 \
    --reach start.txt --inset .01 two.obj >tree.probe
rows_of position,level tree.probe >rows
check "an octree is cut where it comes into a cell alone" every '$4 == 0 || $1 < 4.5' rows \
    and awk '$4 == 2 { n++ } END { exit n < 99 }' rows
probe-place octree -q --levels 0:2 --cut all --reach start.txt two.obj >tree.probe
check "and of its box" each_row tree.probe '$1 < 4.1 && $2 < 2.2' \
    and [ "$(row_count probe tree.probe)" -gt 99 ]
# shellcheck disable=SC2086
probe-capture -q --rays 16 --bounces 0 $lamp two.obj tree.probe >tree.baked
check "and can be interpolated" given '3 1 3' into lookup probe-query -q \
    --interpolate trilinear tree.baked and test -s lookup
# shellcheck disable=SC2086
probe-place lights -q $lamp --reach start.txt --offset 1 two.obj >lights.probe
check "of a lamp's probes those in it stay" [ "$(row_count probe lights.probe)" -lt 6 ] \
    and each_row lights.probe '$1 < 4 && $2 < 2.2'
probe-place vertices -q --volume --offset .2 --reach start.txt two.obj >vertices.probe
check "and of vertices" each_row vertices.probe '$1 < 4 && $2 < 2.2'
# shellcheck disable=SC2086
probe-capture -q --rays 16 --bounces 0 $lamp two.obj grid.probe | probe-tet -q >baked.probe
error="probe-error -q -n 100 --truth-rays 2 --paths 2 --leak-samples 0 --truth truth"
$error --reach start.txt --map map.probe two.obj baked.probe >/dev/null
check "errors are of points in it" each_row map.probe '$1 < 4 && $2 < 2.2'
$error --reach start.txt two.obj baked.probe >/dev/null 2>err
check "whose truth serves again" empty err
refused 1 "this truth has truth-reach" $error --reach starts.txt two.obj baked.probe
refused 1 "this truth has truth-reach" $error --reach start.txt --climb .1 two.obj baked.probe
refused 1 "this truth has truth-reach" $error --reach start.txt --body-radius .2 two.obj baked.probe
refused 2 "body-radius goes with --reach" probe-error --body-radius .2 two.obj baked.probe
tap_done
