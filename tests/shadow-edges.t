#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-leakfix --edges shadows: pairs of probes stand about the borders of shadows, where these are
# known in closed form: a plate of side 1.6 at height 2, and a lamp above its middle.
. "${SRC:?}/tests/support/setup.sh"
cat >plate.obj <<'END'
v -3 0 -3
v 3 0 -3
v 3 0 3
v -3 0 3
v -.8 2 -.8
v .8 2 -.8
v .8 2 .8
v -.8 2 .8
f 4 3 2 1
f 5 6 7 8
END
sed '/^f 5/d' plate.obj >bare.obj
box=-2.5,.3,-2.5,2.5,1.7,2.5
spot='--spot 0,4,0,0,-1,0,60,80,10,10,10'

# baked SCENE PLACEMENT OPTION...: a grid in light that comes straight
baked() {
    baked_scene=$1 baked_places=$2
    shift 2
    probe-place grid -q --bounds $box $baked_places plate.obj |
        probe-capture -q --light direct --rays 8 --bounces 0 "$@" "$baked_scene" | probe-tet -q
}
# added FIRST STREAM: places of its probes from row FIRST on
added() { rows_of position "$2" | tail -n +$(($1 + 1)); }

rows_of_cells() { probe-cat --text --columns position,occlusion | sed '1,/^table tet/d'; }

# LAMP : HALF SIDE of the shadow about X, at height y
offset=.05
for lamp in "spot:.8 * (4 - y) / 2:0:$spot" 'point:.8 * (3.5 - y) / 1.5:0:--point 0,3.5,0,9,9,9' \
    'sun:.8:(2 - y) / 2:--sun .4472136,-.8944272,0,3,3,3'; do
    IFS=: read -r name half shift options <<LAMP
$lamp
LAMP
    # shellcheck disable=SC2086
    baked plate.obj '--clearance 50% --spacing .7' $options >$name.probe
    before=$(row_count probe $name.probe)
    probe-leakfix --edges shadows --rounds 2 --offset $offset plate.obj $name.probe \
        >$name.fixed 2>said
    check "$name: how many edges go through the border is said" \
        says said ': [1-9][0-9]* edges go through the border of a shadow'
    added "$before" $name.fixed | awk '
        { y = $2; x = $1 - ('"$shift"'); x = x < 0 ? -x : x; z = $3 < 0 ? -$3 : $3
          print (x > z ? x : z) - ('"$half"') }' >off
    # halved to an eighth of the offset; and measured level, from a border that leans
    check "$name: no new probe is farther from the border than the offset" \
        every "near(\$1, 0, 1.3 * $offset)" off
    check "$name: as many are in the shadow as out of it" \
        awk '{ out += $1 > 0 } END { exit !(NR > 20 && out > .4 * NR && out < .6 * NR) }' off
done

error_of() {
    probe-error -q --tsv -n 500 --bounds -2.4,.35,-2.4,2.4,1.65,2.4 --truth truth --truth-rays 8 \
        --paths 0 --leak-samples 0 plate.obj "$1" | awk '$1 == "error" { print $3; exit }'
}
# shellcheck disable=SC2086
baked plate.obj '--clearance 50% --count 500' $spot >many.probe
probe-leakfix -q --edges shadows --rounds 1 --offset $offset plate.obj spot.probe >once.fixed
{ error_of once.fixed; error_of many.probe; error_of spot.probe; } | paste -s -d ' ' - >errors
check "less error than as many probes and more in a grid: $(cat errors) with \
$(row_count probe once.fixed), $(row_count probe many.probe), $(row_count probe spot.probe)" \
    every 'NF == 3 && $1 > 0 && $1 < $2 && $2 < $3' errors and \
    [ $((2 * $(row_count probe once.fixed))) -lt "$(row_count probe many.probe)" ]

for threads in 1 3; do
    probe-leakfix -q --threads $threads --edges both --rounds 1 plate.obj spot.probe \
        >threads$threads.probe
done
check "1 and 3 threads give the same bytes" \
    cmp threads1.probe threads3.probe and test -s threads1.probe

# A spot's cone fades: it is no border. Nor is a wall: what stands on the edge is not a shadow.
# shellcheck disable=SC2086
baked bare.obj '--clearance 50% --spacing .7' $spot >bare.probe
probe-leakfix --edges shadows --rounds 1 bare.obj bare.probe 2>said >fixed
check "the cone of a spot asks for no probe" \
    says said ': 0 edges go through the border' \
    and [ "$(row_count probe fixed)" = "$(row_count probe bare.probe)" ]
probe-leakfix --rounds 1 plate.obj spot.probe 2>said >fixed
check "nor does a shadow, where walls alone are asked for" \
    lacks said shadow and [ "$(row_count probe fixed)" = "$(row_count probe spot.probe)" ]
rooms=$SRC/scenes/two-rooms.obj
probe-place grid -q --count 60 "$rooms" |
    probe-capture -q --light direct --rays 8 --bounces 0 --point 2,1.5,2,9,9,9 "$rooms" |
    probe-tet -q >rooms.probe
for edges in walls shadows both; do
    probe-leakfix --edges $edges --rounds 1 "$rooms" rooms.probe 2>said.$edges >rooms.$edges
    row_count probe rooms.$edges
done | paste -s -d ' ' - >counts
check "two rooms: walls, shadows and both ask for probes: $(cat counts)" \
    every "\$1 > $(row_count probe rooms.probe) && \$2 > $(row_count probe rooms.probe) &&
        \$3 > \$1 && \$3 > \$2" counts
probe-leakfix -q --edges shadows --rounds 0 "$rooms" rooms.probe | rows_of_cells >some
probe-leakfix -q --rounds 0 "$rooms" rooms.probe | rows_of_cells >wanted
check "edges through walls are marked, whatever asks for probes" \
    cmp some wanted and says wanted '2 '

# -- where there is none ---------------------------------------------------------------------------
probe-cat -q --tables probe --columns position spot.probe |
    probe-capture --again -q --light indirect --rays 8 --bounces 1 $spot plate.obj |
    probe-tet >dim.probe
refused 1 'the probes hold indirect light' probe-leakfix --edges both --rounds 1 plate.obj dim.probe
probe-place grid -q --clearance 50% --bounds $box --spacing .9 plate.obj |
    probe-capture -q --sky 1,1,1 --rays 8 plate.obj | probe-tet >sky.probe
probe-leakfix --edges shadows --rounds 1 plate.obj sky.probe 2>said >fixed
check "without lamps there are no borders, and that is said" \
    says said 'there is no sun, point or spot' and says said ': 0 edges'
refused 2 "expected one of" probe-leakfix --edges none plate.obj sky.probe
tap_done
