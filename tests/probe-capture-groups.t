#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-capture --groups and --transfer: light by groups that add up to all of it, the response to a
# sky and to suns, against closed forms and captures of that light alone; what other programs make
# of such streams.
. "${SRC:?}/tests/support/setup.sh"

cat >m.mtl <<'END'
newmtl grey
Kd .5 .4 .3
newmtl black
Kd 0 0 0
newmtl red lamp
Kd 0 0 0
Ke 5 0 0
newmtl blue
Kd .2 .2 .2
Ke 0 1 4
END
# A hall without a roof, with two lamps.
cat >hall.obj <<'END'
mtllib m.mtl
v -2 0 -2
v 2 0 -2
v 2 0 2
v -2 0 2
v -2 2 -2
v 2 2 -2
v 2 2 2
v -2 2 2
v -1 1.9 -1
v -1 1.9 -.5
v -.5 1.9 -.5
v -.5 1.9 -1
v 1 .1 1
v 1.5 .1 1
v 1 .1 1.5
usemtl grey
f 4 3 2 1
f 1 2 6 5
f 3 4 8 7
f 2 3 7 6
f 4 1 5 8
usemtl red lamp
f 9 10 11 12
usemtl blue
f 13 14 15
END
lights='--sky .2,.3,.4 --sun 1,-3,.5,2,2,1 --point 0,1.5,0,1,.5,0 --spot 1,1.8,0,0,-1,0,10,40,3,3,3'
cat >lamps.txt <<'END'
# two of the file's, and what comes from outside
lamps: material="red lamp" blue=x
END
awk 'BEGIN { for (i = 0; i < 24; i++)
    print (i % 4 - 1.5) * .9, (int(i / 4) % 2 + .5) * .8, (int(i / 8) - 1) * 1.2 }' >in.txt
probe-place points -q in.txt hall.obj >in.probe

# capture OPTION...: of the hall's probes; -j1: the machine may have others
capture() {
    # shellcheck disable=SC2086
    probe-capture -q -j1 --rays 256 --bounces 8 $lights "$@" hall.obj in.probe
}
# column_of COLUMNS STREAM: their values
column_of() {
    probe-cat --text --no-provenance --tables probe "$2" | awk -v list="$1" '
        /^table/ {
            n = split(list, want, ",")
            for (i = 3; i <= NF; i++) {
                split($i, part, ":")
                first[part[1]] = at + 1; width[part[1]] = part[3]; at += part[3]
            }
        }
        /^[0-9-]/ {
            line = ""
            for (i = 1; i <= n; i++)
                for (k = 0; k < width[want[i]]; k++) line = line " " $(first[want[i]] + k)
            print substr(line, 2)
        }'
}

# -- bad input -------------------------------------------------------------------------------------
refused 1 "lamps.txt:2: group 'lamps': expected material=NAME, light=NAME" \
    capture --groups lamps.txt
printf 'a: material=red*\nb: emissive\n' >twice.txt
refused 1 "material=red lamp is in two groups, 'a' and 'b'" capture --groups twice.txt
printf 'a: material=green\n' >none.txt
refused 1 \
    'none.txt:1: material=green: nothing that shines is called so; there is material="red lamp"' \
    capture --groups none.txt
refused 1 'expected groups of lights' capture --groups /dev/null
refused 1 'nothing.txt: No such file' capture --groups nothing.txt
refused 2 '--groups needs --cache off' capture --groups each --cache auto
refused 2 '--transfer needs --cache off' capture --transfer sky:2 --cache auto
refused 2 'expected sky:N, N from 1 to 5' capture --transfer sky:6
printf '0 1 0\n0 0 0\n' >suns.bad
refused 1 'suns.bad:2: expected a direction' capture --transfer suns:suns.bad
printf '0 95\n' >suns.bad
refused 1 'suns.bad:1: expected an azimuth' capture --transfer suns:suns.bad
refused 1 'expected suns, a direction a line, got none' capture --transfer suns:/dev/null
printf '1 2 3\n1 2 3\n' | stream_of 'table probe position:f64:3' >points.bad
refused 1 'points.bad: expected each in a place of its own, got two at 1 2 3' \
    capture --transfer points:points.bad
stream_of 'table probe position:f64:3' </dev/null >points.bad
refused 1 'points.bad: expected point lights, a probe each, got none' \
    capture --transfer points:points.bad
refused 1 '/dev/null: expected a probe stream' capture --transfer points:/dev/null
refused 2 '--groups and the probes cannot both come from standard input' \
    probe-capture --groups - hall.obj
refused 1 'there is no light in the scene' \
    probe-capture -q --light-scale 0 --groups each hall.obj in.probe
awk 'BEGIN { for (i = 0; i < 6000; i++) print 1, i, 2 }' >suns.many
refused 1 'a stream holds at most 1048576 bytes' capture --transfer suns:suns.many

# -- groups ----------------------------------------------------------------------------------------
cat >lamps.txt <<'END'
# two of the file's, and what comes from outside
lamps: material="red lamp" material=blue
outside: sun-1 sky
END
capture >plain.probe
capture --groups lamps.txt >groups.probe
check "the header says what each group is" into head probe-cat --text groups.probe and says head \
    '^group-1 lamps material="red lamp" material=blue$' '^group-2 outside sun-1 sky$' \
    '^group-3 rest$'
for column in sh sh_error validity depth sky; do
    column_of $column plain.probe >wanted
    column_of $column groups.probe >got
    check "$column is to the bit what it is without groups" cmp got wanted and test -s got
done
# adds_up STREAM GROUP...: sh is their sum, to rounding of the largest of them
adds_up() {
    adds_stream=$1 adds_list=sh
    shift
    for adds_group; do adds_list=$adds_list,sh_$adds_group; done
    column_of "$adds_list" "$adds_stream" | awk -v n=$# '
        { w = NF / (n + 1)
          for (k = 1; k <= w; k++) {
              s = m = 0
              for (g = 1; g <= n; g++) {
                  s += $(g * w + k)
                  a = $(g * w + 1 + (k - 1) % 3); m = a * a > m * m ? a : m
              }
              if ((s - $k) ^ 2 > (2e-6 * m) ^ 2 + 1e-30) { print NR, k, s, $k; bad = 1 }
          } }
        END { exit bad || !NR || w < 3 }'
}
check "groups add up to all light" adds_up groups.probe lamps outside rest
capture --groups each --light indirect >each.probe
check "and one of each, of indirect light" \
    adds_up each.probe red_lamp blue sun-1 point-2 spot-3 sky
capture --groups lamps.txt --light direct --content irradiance --dering irradiance >direct.probe
check "and of direct light that was de-rung and made irradiance" \
    adds_up direct.probe lamps outside rest

# alike A ERROR_A B ERROR_B: two captures of the same light differ by what their errors say. Values
# of one probe go together, and few rays miss a lamp: of 300 probes and 1024 rays it is .87 to .95.
alike() {
    paste -d ' ' "$1" "$2" "$3" "$4" | awk '
        { w = NF / 4
          for (k = 1; k <= w; k++) {
              v = $(w + k) ^ 2 + $(3 * w + k) ^ 2
              if (v > 0) { s += ($k - $(2 * w + k)) ^ 2 / v; n++ }
              else if (($k - $(2 * w + k)) ^ 2 > 1e-12) { print NR, k; bad = 1 }
          } }
        END { print n, sqrt(s / n); exit bad || !n || !(s / n < 1.2 ^ 2) || !(s / n > .5) }'
}
# alone GROUP OPTION...: a group against a capture of its light alone
alone() {
    alone_group=$1
    shift
    probe-capture -q -j1 --seed 7 --rays 256 --bounces 8 "$@" hall.obj in.probe >alone.probe
    column_of "sh_$alone_group" groups.probe >a
    column_of "sh_error_$alone_group" groups.probe >b
    column_of sh alone.probe >c
    column_of sh_error alone.probe >d
    alike a b c d
}
if plain_build "each group's light alone"; then
    check "lamps alone" alone lamps
    check "sun and sky alone" alone outside --light-scale 0 --sky .2,.3,.4 --sun 1,-3,.5,2,2,1
    check "point and spot alone" alone rest --light-scale 0 --point 0,1.5,0,1,.5,0 \
        --spot 1,1.8,0,0,-1,0,10,40,3,3,3
fi

# Of a lamp that no ray finds it is said what it could be, though others are found.
sed 's/usemtl blue/v 1 -1 1\nv 1 -1 2\nv 2 -1 1\n&\nf 16 17 18/; s/^f 13.*//' hall.obj >cellar.obj
probe-capture -q -j1 --rays 64 --light direct --groups each --sky 1,1,1 cellar.obj in.probe \
    >cellar.probe
column_of sh_blue,sh_error_blue cellar.probe >got
check "a lamp that is hidden has an error" every 'NF == 54 && $1 == 0 && $3 == 0 && $28 == 0 &&
    $30 > 1e-5 && $30 < 1' got
# So of one that is dim and so seldom asked for that no question went to it.
sed 's/^f .*//; /^usemtl/d' hall.obj >dim.obj
printf 'v %s\n' '-1 -.5 -1' '1 -.5 -1' '0 -.5 1' '0 9 0' '.1 9 0' '0 9 .1' >>dim.obj
{ cat dim.obj; printf 'usemtl blue\nf -3 -2 -1\n'; } >dim-alone.obj
{ cat dim.obj; printf 'usemtl red lamp\nf -6 -5 -4\nusemtl blue\nf -3 -2 -1\n'; } >dim.both.obj
probe-capture -q -j1 --rays 64 --light direct --groups each dim.both.obj in.probe >dim.probe
probe-capture -q -j1 --rays 1024 --light direct dim-alone.obj in.probe >dim-alone.probe
column_of sh_blue,sh_error_blue dim.probe >a
column_of sh dim-alone.probe | paste -d ' ' a - >got
check "or that no ray asked for" every 'NF == 81 && $30 > 0 && ($3 - $57) ^ 2 < (6 * $30) ^ 2' got

# -- transfer --------------------------------------------------------------------------------------
# Nothing but sky: each function of it comes as it is.
printf 'mtllib m.mtl\nusemtl black\nv 0 -90 0\nv .001 -90 0\nv 0 -90 .001\nf 1 2 3\n' >air.obj
echo 0 0 0 | probe-place points -q - >air.probe
probe-capture -q --order 3 --rays 4096 --transfer sky:3 air.obj air.probe >open.probe
column_of transfer_sky open.probe | tr ' ' '\n' >values
column_of transfer_sky_error open.probe | tr ' ' '\n' >errors
check "under an open sky the transfer is the identity" test -s values and \
    awk '{ j = int((NR - 1) / 27); i = int((NR - 1) % 27 / 3); getline e <"errors"
        d = ($1 - (i == j)) ^ 2
        if (!(d < (5 * e + 1e-4) ^ 2 && d < .02 ^ 2)) { print NR, $1, e; bad = 1 } }
        END { exit bad || NR != 243 }' values
# So does a lamp of radiant intensity 1, two below: a quarter of the functions.
lamps() { stream_of 'table probe position:f64:3'; }
printf '%s\n' '0 -2 0' '3 0 0' | lamps >lamps.probe
probe-capture -q --rays 64 --transfer points:lamps.probe air.obj air.probe >open.probe
column_of transfer_points open.probe >got
check "of a point, 1 over the distance squared" every 'NF == 54 && near($1, .0705237, 1e-6) &&
    near($4, -.1221506, 1e-6) && near($7, 0, 1e-6) && near($28, .0313438, 1e-6)' got
# Over a plain of albedo rho: (1 + rho) / 2 of Y_0, and of what Y_1-1 (which is y) gives to L_00,
# Y_00 .488603 pi (1 + 4 rho / 3); of a sun above Y_00 (1 + 2 rho). On it: pi Y_00, .488603 2 pi / 3
# and 1; of one at 30 degrees 1 / 2.
printf '%s\n' 'mtllib m.mtl' 'usemtl grey' 'v -9e4 0 -9e4' 'v -9e4 0 9e4' 'v 9e4 0 9e4' \
    'v 9e4 0 -9e4' 'f 1 2 3 4' >plain.obj
printf '# above, and low\n0 2 0\n77 30 # degrees\n' >suns
echo 0 1 0 | probe-place points -q - | probe-capture -q --rays 4096 --transfer sky:2 \
    --transfer suns:suns plain.obj >over.probe
column_of transfer_sky over.probe >sky
column_of transfer_suns over.probe >sun
check "over a plain it is what the plain scatters more" \
    every 'near($1, .75, .003) && near($2, .7, .003) && near($28, .433 * (1 + 2 / 3), .012) &&
        near($30, .433 * 1.4, .012)' sky and every 'near($1, .5642, .002) &&
        near($2, .28209 * 1.8, .002)' sun
probe-place vertices -q plain.obj >corners.probe
probe-cat -q --rows 0 corners.probe | probe-capture -q --rays 4096 --transfer sky:2 \
    --transfer suns:suns --groups each --sky 1,1,1 plain.obj >on.probe
column_of transfer_sky on.probe >sky
column_of transfer_suns on.probe >sun
check "on it, it is that of a surface, of one colour a block" every 'NF == 12 &&
        near($1, .8862, .002) && near($4, 1.0233, .002) && near($7, 0, .01)' sky and \
    every 'NF == 6 && near($1, 1, 1e-6) && near($4, .5, 1e-6)' sun
column_of irradiance,irradiance_sky on.probe >got
check "and of groups" every 'NF == 6 && near($1, 3.14159, .001) && near($1, $4, 1e-5)' got
# In a closed white room no sky comes in.
sed 's/usemtl red lamp/f 5 6 7 8\n&/' hall.obj >closed.obj
probe-capture -q --rays 64 --transfer sky:2 closed.obj in.probe >closed.probe
column_of transfer_sky closed.probe | tr ' ' '\n' | sort -u >got
check "nothing comes into a closed room" [ "$(cat got)" = 0 ]

# Whatever the sky: its coefficients times the blocks are what a capture under it finds.
printf '%s\n' '-1 1 1' '.3 1.5 -.7' | lamps >lamps.probe
capture --transfer sky:2 --transfer suns:suns --transfer points:lamps.probe >transfer.probe
column_of sh transfer.probe >got
column_of sh plain.probe >wanted
check "sh is to the bit what it is without a transfer" cmp got wanted
if plain_build "a transfer against a capture"; then
    # L = s_0 Y_0, s_0 = L / Y_00
    column_of transfer_sky transfer.probe | awk '{ for (k = 1; k <= 27; k++)
        printf "%.9g ", $k * (.1 + .1 * ((k - 1) % 3)) / .28209479; print "" }' >a
    column_of transfer_sky_error transfer.probe | awk '{ for (k = 1; k <= 27; k++)
        printf "%.9g ", $k * (.1 + .1 * ((k - 1) % 3)) / .28209479; print "" }' >b
    probe-capture -q -j1 --seed 7 --rays 256 --bounces 8 --light-scale 0 --sky .1,.2,.3 \
        hall.obj in.probe >sky.probe
    column_of sh sky.probe >c
    column_of sh_error sky.probe >d
    check "a sky by its transfer is that sky" alike a b c d
    column_of transfer_suns transfer.probe | cut -d ' ' -f 28- >a
    column_of transfer_suns_error transfer.probe | cut -d ' ' -f 28- >b
    way=$(probe-cat --text transfer.probe | sed -n 's/^transfer-sun-2 //p' |
        awk -F , '{ printf "%.17g,%.17g,%.17g", -$1, -$2, -$3 }')
    probe-capture -q -j1 --seed 7 --rays 256 --bounces 8 --light-scale 0 \
        --sun "$way,1,1,1" hall.obj in.probe >sun.probe
    column_of sh sun.probe >c
    column_of sh_error sun.probe >d
    check "a sun by its transfer is that sun" alike a b c d
    column_of transfer_points transfer.probe | cut -d ' ' -f 28- >a
    column_of transfer_points_error transfer.probe | cut -d ' ' -f 28- >b
    probe-capture -q -j1 --seed 7 --rays 256 --bounces 8 --light-scale 0 \
        --point .3,1.5,-.7,1,1,1 hall.obj in.probe >point.probe
    column_of sh point.probe >c
    column_of sh_error point.probe >d
    check "a point by its transfer is that point" alike a b c d
fi
probe-capture --dry-run --transfer sky:5 --groups each hall.obj in.probe >told 2>said
check "what it would take is said, and no stream is written" says told \
    'a probe takes 6[0-9]* bytes' '24 probes take 0.1[0-9]* MB in the stream' and \
    lacks told '^#?probe' and empty said

# -- the same bytes, and the rest of the pipe ------------------------------------------------------
split='--groups lamps.txt --transfer sky:2 --transfer points:lamps.probe'
# shellcheck disable=SC2086
{
    capture $split >one.probe
    capture -j3 $split >three.probe
    for i in 1 2; do capture --slice $i/2 $split >slice$i.probe; done
}
check "any number of threads" same_stream one.probe three.probe
probe-cat -q --fill slice2.probe slice1.probe >slices.probe
check "and slices put together" same_stream one.probe slices.probe
probe-cat -q --rows 0:9 one.probe >some.probe
probe-capture -q -j1 hall.obj slice1.probe >rest.probe
for stream in one rest; do
    column_of position,sh_lamps,sh_error_rest,transfer_sky $stream.probe >$stream.rows
done
check "what is missing is captured as the others were" cmp one.rows rest.rows and test -s one.rows
refused 1 'the probes were captured with group-1 lamps' \
    probe-capture -q --groups each hall.obj one.probe
refused 1 'its light is not split as that of the probes to be filled' \
    probe-cat --fill plain.probe slice1.probe
probe-cat -q --rotate-light 0,1,0,90 plain.probe >turned.probe
probe-cat -q --columns position in.probe >wanting.probe
probe-cat -q --rows 0:9 plain.probe >some.plain
probe-cat -q --fill some.plain wanting.probe >part.probe
refused 1 'rotated-light is 0,0,1,0,1,0,-1,0,0, and theirs is none' \
    probe-cat --fill turned.probe part.probe
probe-cat plain.probe turned.probe 2>said >both.probe
check "merged with turned light, that is said" says said 'key rotated-light .* another has none'
capture --groups each >other.probe
refused 1 'the streams cannot be merged: group-1 is' probe-cat one.probe other.probe
probe-cat -q --rows 9: one.probe >others.probe
probe-cat -q some.probe others.probe >merged.probe
for stream in one merged; do column_of sh_rest,transfer_sky $stream.probe >$stream.rows; done
check "merged streams keep them" cmp one.rows merged.rows and test -s one.rows
probe-capture -q -j1 --again --groups off --transfer off hall.obj one.probe >again.probe
probe-cat --text --no-provenance again.probe >text
check "captured again without, nothing of it is left" lacks text sh_lamps transfer group-
# what each program does to sh, it does to the others
probe-cat -q --order 2 one.probe >two.probe
column_of transfer_sky one.probe | awk '{ for (k = 0; k < 108; k++)
    if (k % 27 < 12) printf "%s ", $(k + 1); print "" }' | sed 's/ $//' >wanted
column_of transfer_sky two.probe >got
check "fewer bands" adds_up two.probe lamps outside rest and cmp got wanted and test -s got
probe-cat -q --content irradiance one.probe >irradiance.probe
probe-cat -q --content radiance irradiance.probe >back.probe
for stream in one irradiance back; do
    column_of sh_lamps,sh_error_rest,transfer_sky $stream.probe >$stream.rows
done
check "irradiance and back" adds_up irradiance.probe lamps outside rest and \
    near 1e-5 back.rows one.rows and differ irradiance.rows one.rows and \
    near 1e-5 "$(column_of sh_outside irradiance.probe | cut -d ' ' -f 1 >i.rows; echo i.rows)" \
    "$(column_of sh_outside one.probe | awk '{ print $1 * 3.14159265 }' >r.rows; echo r.rows)"
probe-cat -q --dering radiance one.probe >rung.probe
check "a window is that of the whole" adds_up rung.probe lamps outside rest
probe-tet -q one.probe >tet.probe
probe-leakfix -q -j1 --probes 3 --points 200 hall.obj tet.probe >fixed.probe 2>said
check "probes that probe-leakfix adds have the same parts" \
    adds_up fixed.probe lamps outside rest and \
    [ "$(column_of transfer_sky fixed.probe | grep -c nan)" = 0 ]
probe-leakfix -q -j1 --dilate 'position[0] > 1' hall.obj tet.probe >dilated.probe
check "and those that hold the light of others" adds_up dilated.probe lamps outside rest and \
    differ "$(column_of transfer_sky dilated.probe >d.rows; echo d.rows)" \
    "$(column_of transfer_sky tet.probe >t.rows; echo t.rows)"
# irradiance at points with normals, of each group and of all light; packed, too
printf '.1 1 .2 0 1 0\n-.4 .9 .6 1 0 0\n' >points.txt
for column in sh sh_lamps sh_outside sh_rest; do
    probe-query -q --column $column tet.probe points.txt | numbers >$column.e
    probe-query -q --column $column --pack float tet.probe >$column.pack
    probe-query -q $column.pack points.txt | numbers | cut -d ' ' -f 1-3 >$column.p
done
for column in sh sh_lamps sh_outside sh_rest; do
    cut -d ' ' -f 1-3 $column.e >$column.q
done
paste -d ' ' sh.q sh_lamps.q sh_outside.q sh_rest.q >got
check "a query of groups adds up to that of all light" every 'NF == 12 && $1 > 0 &&
    near($1, $4 + $7 + $10, 1e-5) && near($3, $6 + $9 + $12, 1e-5)' got
check "and so does one of a packed file" near 1e-5 sh_rest.q sh_rest.p and differ sh.p sh_rest.p
refused 2 "--pack packs no column but sh, or that of a group, sh_NAME" \
    probe-query --pack half --column depth tet.probe
refused 1 "gradients are known of all light alone" \
    probe-query --interpolate gradient --column sh_rest tet.probe points.txt
probe-bake --dry-run --groups lamps.txt --transfer sky:2 --transfer suns:suns hall.obj >dry 2>&1
check "a bake hands them to its capture" says dry \
    'probe-capture.* --groups lamps.txt --transfer sky:2 --transfer suns:suns hall.obj'
probe-place adaptive -q -j1 --probes 4 --rays 16 --noise 0 --bounces 1 $lights hall.obj |
    probe-capture -q -j1 --groups lamps.txt hall.obj >adaptive.probe
check "light that was traced for the placement is traced again" \
    adds_up adaptive.probe lamps outside rest
check "in a scene without the lamps it is measured as ever" \
    into report probe-error -q --any-scene --points 20 --truth-rays 16 \
    --exclude 'red*' hall.obj tet.probe
probe-cat --text one.probe | sed 's/transfer-sky 2/transfer-sky 3/' >wrong.probe
refused 1 "column transfer_sky has 4 blocks, but the header's transfer-sky is 3" \
    probe-cat wrong.probe
tap_done
