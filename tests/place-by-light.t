#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-place spawn-merge, ascent and unlit: probes come where light differs and go where it does
# not, climb to lit walls and through none, and some stand for those in the dark; each rule ends
# them and says so, and nothing depends on threads or the order of what is given.
. "${SRC:?}/tests/support/setup.sh"

# room X0 X1 MATERIAL [OTHER]: a closed room, seen from within; its wall at X1 is of the OTHER one
room() {
    printf 'v %s 0 0\nv %s 0 0\nv %s 2 0\nv %s 2 0\nv %s 0 2\nv %s 0 2\nv %s 2 2\nv %s 2 2\n' \
        "$1" "$2" "$2" "$1" "$1" "$2" "$2" "$1"
    printf 'usemtl %s\n' "$3"
    for face in '-8 -7 -6' '-8 -6 -5' '-4 -1 -2' '-4 -2 -3' '-8 -4 -3' '-8 -3 -7' '-5 -6 -2' \
        '-5 -2 -1' '-8 -5 -1' '-8 -1 -4'; do
        echo "f $face"
    done
    printf 'usemtl %s\nf -7 -3 -2\nf -7 -2 -6\n' "${4-$3}"
}
cat >light.mtl <<'MTL'
newmtl one
Kd 0 0 0
Ke 1 1 1
newmtl four
Kd 0 0 0
Ke 4 4 4
newmtl black
Kd 0 0 0
newmtl wall
Kd .6 .5 .4
newmtl lamp
Kd 0 0 0
Ke 40 40 40
MTL
scene() { echo 'mtllib light.mtl' && "$@"; }
{ scene room 0 2 one; } >even.obj
{ scene room 0 2.1 one && room 2.12 4 four; } >halves.obj
{ scene room 0 1.8 black one && room 2 4 black; } >lit-wall.obj
{ scene room 0 3 wall && room 3.02 6 wall && printf '%s\n' 'v 2.4 .6 .6' 'v 2.4 1.4 .6' \
    'v 2.4 1 1.4' 'v 5.6 .2 1.9' 'v 5.9 .2 1.9' 'v 5.9 .5 1.9' 'usemtl lamp' 'f -6 -4 -5' \
    'f -3 -1 -2'; } >lamps.obj
{ scene room 0 3 black && room 4 6 one && room 7 8 black; } >dark.obj

# probes OBJ OPTION...: the method, into placed.probe and said; their numbers in rows
probes() {
    probes_of=$1
    shift
    probe-place "$@" --text "$probes_of" >placed.probe 2>said || return
    numbers <placed.probe >rows
}
placed() { row_count probe placed.probe; }
# how many nodes of the grid are in the air
started() { sed -n 's/.*round 0: \([0-9]*\) probes.*/\1/p' said; }

# -- spawn-merge -----------------------------------------------------------------------------------
all="--light all --rays 256 --clearance 50% --spacing .4"
probes even.obj spawn-merge $all
check "light that is the same everywhere leaves less than 3 in 10 ($(placed) of $(started))" \
    [ $((10 * $(placed))) -le $((3 * $(started))) ] and says said ', 0 merged, 0 added' \
    ': nothing changed$'
check "they are positions, and what placed them" says placed.probe \
    '^table probe position:f64:3 origin:i32:1$' and every '$4 == 6' rows
probes halves.obj spawn-merge $all --rounds 3
awk '($1 - 2.1) ^ 2 < .17' rows >border
check "two lights give a sheet at the border ($(wc -l <border) of $(placed))" \
    [ "$(wc -l <border)" -ge 60 ] \
    and [ $((10 * ($(placed) - $(wc -l <border)))) -le $((3 * $(started))) ]
check "--rounds ends it" says said 'round 3: ' 'as --rounds allows$' and lacks said 'round 4: '
probes halves.obj spawn-merge $all --merge-distance 0 --max-probes $(($(started) + 40))
check "--max-probes ends it" [ "$(placed)" -eq $(($(started) + 40)) ] \
    and says said 'as --max-probes allows$'
check "and what came is not nearer to another than spacing / 2^levels" every '$1 >= .1' <<END
$(awk '{ x[NR] = $1; y[NR] = $2; z[NR] = $3 }
    END { for (i in x) for (k in x) if (i < k) {
              d = sqrt((x[i] - x[k]) ^ 2 + (y[i] - y[k]) ^ 2 + (z[i] - z[k]) ^ 2)
              if (!least || d < least) least = d }
          print least + 1e-9 }' rows)
END
for kind in six twentysix 'mse --merge-contrast .01 --spawn-contrast 1'; do
    check "--contrast $kind" probes halves.obj spawn-merge $all --rounds 1 --contrast $kind \
        and says said 'round 1: .* [1-9][0-9]* merged, [1-9][0-9]* added'
done
check "relative" probes halves.obj spawn-merge $all --rounds 1 --contrast-form relative \
    and says said 'round 1: .* [1-9][0-9]* merged, [1-9][0-9]* added'

printf '%s\n' '.5 .5 .5' '1.5 1.4 1.3' '3.1 1 1' | probe-place points - >kept.probe
printf '%s\n' '3.1 1 1' '1.5 1.4 1.3' '.5 .5 .5' | probe-place points - >turned.probe
some="spawn-merge $all --rounds 2"
check "--keep" probes halves.obj $some --keep kept.probe --threads 1
head -n 3 rows >first
check "has them first, and they stay" says first '^0.5 0.5 0.5 -1' '^1.5 1.4' '^3.1 1 1 -1$'
sort rows >sorted
probes halves.obj $some --keep turned.probe --threads 3
sort rows >others
check "the same for any order of them, and any threads" cmp sorted others and test -s others

# -- ascent ----------------------------------------------------------------------------------------
all="--light all --rays 64 --clearance 50% --spacing .5 --merge-distance 0"
probes lit-wall.obj ascent $all
check "one lit wall in the dark: all end before it" \
    every '$10 > 0 || ($1 > 1.4 && $1 < 1.8 && $5 > 1)' rows and says said \
    ': steps are below a 32nd of the spacing$'
grep ' [1-9][0-9]*$' rows >standing
check "but one, that stands for those in the dark room" has_lines 1 standing \
    and says said 'black probes in 1 areas: 1 stand for them'
check "they tell gradient, steps, steps back and cluster" says placed.probe \
    '^table probe position:f64:3 origin:i32:1 gradient:f32:3 steps:i32:1 back:i32:1 cluster:i32:1'
# of_rooms OPTION...: how many end in either of the rooms that a thin wall parts
of_rooms() {
    probes lamps.obj ascent --rays 64 --clearance 50% --spacing .6 --merge-distance 0 "$@"
    awk '{ n[$1 > 3]++ } END { print n[0] + 0, n[1] + 0 }' rows
}
of_rooms --rounds 1 >before
of_rooms >walls
of_rooms --step-back dark >dark
check "--step-back wall lets none through a wall ($(cat walls))" cmp before walls
check "dark, the source's way, does ($(cat dark))" differ before dark
# distance: of all from the lamp, in the mean
distance() {
    awk '{ s += sqrt(($1 - .2) ^ 2 + ($2 - .3) ^ 2 + ($3 - 1.9) ^ 2) } END { print s / NR }' rows
}
{ scene room 0 3 wall && printf '%s\n' 'v .1 .2 1.9' 'v .4 .2 1.9' 'v .1 .5 1.9' 'usemtl lamp' \
    'f -3 -1 -2'; } >lamp.obj
probes lamp.obj ascent --rays 64 --clearance 50% --spacing .5 --merge-distance 0
apart=$(distance)
probes lamp.obj ascent $all
check "by all light they run to the lamp ($(distance)), by indirect light less ($apart)" \
    every "\$1 < .7 * $apart" <<END
$(distance)
END
cp placed.probe many
check "any number of threads gives the same" probes lamp.obj ascent $all --threads 1 \
    and same_stream placed.probe many
check "probes that arrived together merge" probes lamp.obj ascent --light all --rays 64 \
    --clearance 50% --spacing .5 --merge-contrast .2 and says said ' [1-9][0-9]* merged'
check "--rounds" probes lamp.obj ascent $all --rounds 2 and says said 'as --rounds allows$'

# -- unlit -----------------------------------------------------------------------------------------
probe-place grid -q --clearance 50% --spacing .5 dark.obj >grid.probe
probe-capture -q --rays 16 dark.obj grid.probe >captured.probe
lit=$(rows_of position,sh captured.probe | awk '$4 > 0' | wc -l)
for k in 1 2 6; do
    probe-place unlit captured.probe --unlit $k --text -o $k.probe 2>said
    rows_of position,origin,cluster $k.probe | awk '$4 == 8' >of-$k
    check "--unlit $k keeps all with light and $k" \
        [ "$(row_count probe $k.probe)" -eq $((lit + k)) ] and has_lines $k of-$k \
        and says $k.probe ' sh:f32:27 .* cluster:i32:1' '^capture-rays 16'
done
check "one is in the larger dark room" every '$1 < 3 && $5 > 20' of-1
check "two are in both, the larger first" every '(NR == 1) == ($1 < 3)' of-2
check "and six in both by size" [ "$(awk '$1 < 3' of-6 | wc -l)" -ge 4 ] \
    and [ "$(awk '$1 > 7' of-6 | wc -l)" -ge 1 ]
probe-place unlit captured.probe --text dark.obj >seen.probe 2>said
check "by default one for each dark room, with the scene too" \
    says said 'in 2 areas: 2 stand for them' \
    and into rows rows_of position,origin,cluster seen.probe \
    and into others rows_of position,origin,cluster 2.probe and cmp rows others and test -s rows

{
    rows_of position grid.probe
    awk 'BEGIN { for (i = 0; i < 1000; i++)
        print 4.6 + i % 10 / 10, .6 + int(i / 10) % 10 / 10, .6 + int(i / 100) / 10 }'
} >both.txt
probe-place points both.txt | probe-capture -q --rays 16 dark.obj >captured.probe
probe-place unlit captured.probe 2>said >both.probe
check "and the same where those with light are many and near" \
    says said 'in 2 areas: 2 stand for them'

# -- probes that stay where nobody would put them --------------------------------------------------
printf '%s\n' '.5 .5 .5' '.5 .5 .5' '.4 .5 .5' '.5 9 .5' | probe-place points - >odd.probe
probe-place $some --keep odd.probe -o odd.placed halves.obj 2>said
check "probes of --keep that are twice there or far off are told of" \
    says said 'keep: 1 of 4 probes are where another one is: all stay' \
    'keep: 1 of 4 probes are far outside of the scene.s box: they stay' and lacks said 'in no air'

# -- what cannot be --------------------------------------------------------------------------------
refused 2 'expected --merge-contrast below --spawn-contrast, got 0.5 and 0.3' \
    probe-place spawn-merge --count 100 --merge-contrast .5 even.obj
refused 2 'mse has no bound' probe-place spawn-merge --count 100 --contrast mse even.obj
refused 2 'expected either --spacing or --count' probe-place ascent even.obj
refused 2 '--levels goes with the methods' \
    probe-place ascent --count 9 --levels 1 even.obj
refused 2 'ascent: expected --order 2 or more' probe-place ascent --count 9 --order 1 even.obj
refused 1 'no light that surfaces scatter reaches the' probe-place ascent --count 100 even.obj
refused 1 'more of them (--count) may find some, and --light all' \
    probe-place spawn-merge --count 100 even.obj
refused 1 'there is no light: --sky' probe-place spawn-merge --count 9 --light-scale 0 even.obj
refused 1 'is in the air' probe-place spawn-merge --count 9 --bounds 8,8,8,9,9,9 even.obj
refused 1 'grid.probe: expected captured probes' probe-place unlit grid.probe

tap_done
