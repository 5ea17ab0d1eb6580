#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Light in other shapes, as users ask for it: irradiance, de-ringing, other bases; from
# probe-capture and from probe-cat, the same.
. "${SRC:?}/tests/support/setup.sh"
scene=$SRC/scenes/two-rooms.obj
lamp="--point 1,1.5,1,9,6,3"
all="--columns sh_error,sh_gradient,validity"
capture() { probe-capture --quiet --rays 32 --bounces 2 $lamp "$@"; }
# rows STREAM: its tables, as text
rows() { probe-cat --text "$1" | sed -n '/^table/,$p'; }
same_rows() { rows "$1" >same.a && rows "$2" >same.b && test -s same.a && cmp same.a same.b; }
info() { probe-cat --info "$1" >info; }
key() { probe-cat --info "$2" | sed -n "s/^key $1 //p"; }

probe-place grid -q --count 60 "$scene" | probe-tet -q >placed.probe
capture $all "$scene" placed.probe >radiance.probe

# -- content ---------------------------------------------------------------------------------------
capture $all --content irradiance "$scene" placed.probe >irradiance.probe
check "the key says what was asked for" \
    [ "$(key sh-content irradiance.probe)/$(key sh-content radiance.probe)" = irradiance/radiance ]
probe-cat --content irradiance radiance.probe >turned.probe
check "capture gives irradiance as probe-cat makes it of radiance, byte for byte" \
    same_rows irradiance.probe turned.probe
probe-cat --content irradiance turned.probe >again.probe
check "what is irradiance already stays" same_rows again.probe turned.probe
probe-cat --text --content radiance turned.probe | numbers | awk 'NF > 10' >back
probe-cat --text radiance.probe | numbers | awk 'NF > 10' >was
paste -d ' ' was back >both
cat >seven_digits.awk <<'AWK'
{
    n = NF / 2
    for (i = 1; i <= n; i++) {
        d = $i - $(i + n)
        m = $i < 0 ? -$i : $i
        if (d > 3e-7 * m || -d > 3e-7 * m) bad = 1
    }
    seen++
}
END { exit bad || seen < 20 }
AWK
check "and becomes radiance again, to 7 digits" awk -f seven_digits.awk both
awk 'BEGIN {
        for (i = 0; i < 12; i++) print .3 + i * .2, .4 + i * .1, .5, (i % 3) - 1, i % 2, .5
    }' >points.txt
probe-query -q radiance.probe points.txt >light.radiance
probe-query -q irradiance.probe points.txt | paste light.radiance - >both
check "probe-query gives the same light of both" every 'near($1, $4, 1e-5 * $1) &&
    near($2, $5, 1e-5 * $2) && near($3, $6, 1e-5 * $3)' both and has_lines 12 both
for i in 1 2; do
    capture $all --content irradiance --slice $i/2 "$scene" placed.probe >slice$i.probe
done
probe-capture -q $all "$scene" slice1.probe >resumed.probe
check "a capture is resumed in the kind that it was begun in" \
    same_rows resumed.probe irradiance.probe
probe-cat --fill slice2.probe slice1.probe >filled.probe
check "and filled from its slices" same_rows filled.probe irradiance.probe
refused 1 "the probes were captured with sh-content irradiance, not radiance" \
    probe-capture --content radiance "$scene" slice1.probe
refused 1 "sh-content is radiance, and theirs is irradiance" \
    probe-cat --fill radiance.probe slice1.probe
probe-leakfix -q --rounds 4 "$scene" irradiance.probe >fixed.irradiance.probe
probe-leakfix -q --rounds 4 "$scene" radiance.probe |
    probe-cat --content irradiance >fixed.radiance.probe
check "probe-leakfix captures new probes in it" \
    same_rows fixed.irradiance.probe fixed.radiance.probe
check "of which there are some" not cmp -s fixed.irradiance.probe irradiance.probe
capture --order 4 --content irradiance "$scene" placed.probe >four.probe
refused 1 "radiance of order 4 cannot be had from irradiance, in which band 3 leaves no trace" \
    probe-cat --content radiance four.probe
probe-cat --order 3 --content radiance four.probe >three.probe
check "--order cuts what cannot be undone" \
    [ "$(key sh-order three.probe)/$(key sh-content three.probe)" = 3/radiance ]
auto() { capture --order auto --order-loss .3 "$@" "$scene" placed.probe; }
auto >auto.radiance.probe
auto --content irradiance >auto.irradiance.probe
probe-cat --content irradiance auto.radiance.probe >turned.probe
check "--order auto chooses the same order" same_rows auto.irradiance.probe turned.probe

# -- order -----------------------------------------------------------------------------------------
capture $all --order 2 "$scene" placed.probe >two.probe
probe-cat --order 2 radiance.probe >cut.probe
check "--order cuts to what a capture of that order is" same_rows cut.probe two.probe
refused 1 "the probes have order 2: it cannot be raised to 3" probe-cat --order 3 two.probe

# -- de-ringing ------------------------------------------------------------------------------------
# plain STREAM [COLUMNS]: probes with columns in one order, without sh_window
columns="position,sh,sh_error,sh_gradient,validity,sh_window"
plain() {
    probe-cat --columns "${2-$columns}" --tables probe "$1" | probe-cat --drop sh_window
}
# probes [OPTION...] STREAM: their rows, as text
probes() { probe-cat -q --text --tables probe "$@" | numbers; }
capture $all --dering irradiance "$scene" placed.probe >derung.probe
probe-cat --dering irradiance radiance.probe >turned.probe 2>said
plain derung.probe >a.probe
plain turned.probe >b.probe
check "capture de-rings as probe-cat does, byte for byte" same_rows a.probe b.probe
check "the header says how" [ "$(key sh-dering derung.probe)" = "irradiance 0" ]
changed=$(probes --columns position,sh_window --where 'sh_window < 1' turned.probe | wc -l)
check "standard error and sh_window count the same, some of them changed" \
    says said "probe-cat: $changed of [0-9]* probes de-rung, the least r is 0\." \
    and [ "$changed" -gt 2 ]
probe-capture --rays 32 --bounces 2 $lamp --dering irradiance "$scene" placed.probe \
    2>said >/dev/null
check "probe-capture says it as well" says said "probe-capture: $changed of"
probes --columns position,sh,sh_window --where 'sh_window = 1' turned.probe |
    cut -d ' ' -f 1-30 >kept
probes --columns position,sh radiance.probe >was
grep -xFf was kept >matches
check "what does not ring keeps its bits" cmp kept matches and [ "$(wc -l <matches)" -gt 2 ]
probe-cat --dering irradiance turned.probe >again.probe 2>said
check "a second pass changes nothing" says said 'probe-cat: 0 of'
check "not a bit" same_rows again.probe turned.probe
bases() { probe-cat -q --dering radiance --dering-floor .1 --basis dice,ahd "$@" radiance.probe; }
for threads in 1 3; do bases --threads $threads >t$threads.probe; done
check "1 and 3 threads give the same bytes" cmp t1.probe t3.probe and test -s t1.probe
for i in 1 2; do
    capture $all --dering irradiance --slice $i/2 "$scene" placed.probe >slice$i.probe
done
probe-capture -q $all "$scene" slice1.probe >resumed.probe
check "a capture is resumed de-ringing as it began" same_rows resumed.probe derung.probe
probe-cat -q --dering radiance --basis cube --report radiance.probe 2>said >/dev/null
check "--quiet says nothing" empty said
probe-capture -q --again --rays 8 "$scene" derung.probe >anew.probe
info anew.probe
check "captured anew, it is derung anew" says info 'sh-dering irradiance'
probe-capture -q --again --rays 8 --dering none "$scene" derung.probe >anew.probe
info anew.probe
check "unless it is not to be: the window is forgotten" \
    says info '^key sh-order' and lacks info sh-dering sh_window
plain_libm probe-cat -q --dering radiance --dering-floor .1 --basis dice,ahd radiance.probe \
    >plain.probe
check "libm's faster instructions change nothing" cmp plain.probe t1.probe
stream_of 'table probe position:f64:3 sh:f32:12' >odd.text <<'END'
0 0 0 -1 1 1 0 0 0 0 0 0 0 0 0
1 0 0 nan nan nan nan nan nan nan nan nan nan nan nan
2 0 0 1 1 1 9 0 0 0 0 0 0 0 0
END
probe-cat --text --dering irradiance odd.text >mended.text 2>said
check "a mean below 0 is left and said to be, what is missing stays missing" \
    says said '1 probes have a mean below 0' ': 1 of 2 probes de-rung' and \
    says mended.text '^0 0 0 -1 1 1 0 0 0 0 0 0 0 0 0 1$' '^1 0 0 nan .* nan$'
refused 1 "the probes were captured with sh-dering irradiance 0, not none" \
    probe-capture --dering none "$scene" slice1.probe
refused 1 "radiance cannot be known from irradiance of an order above 3" \
    probe-cat --dering radiance four.probe
refused 2 "--dering-floor needs --dering" probe-cat --dering-floor .1 radiance.probe
refused 2 "--dering-floor" probe-cat --dering irradiance --dering-floor 1 radiance.probe
refused 2 "--dering" probe-cat --dering everything radiance.probe
refused 2 "--order N does both" \
    probe-capture --order auto --dering radiance --content irradiance "$scene" placed.probe
probe-cat --text slice1.probe | sed '/^sh-dering/d; s/^sh-content.*/&\nsh-dering much/' >odd.probe
refused 1 "header key sh-dering: expected irradiance or radiance and a floor" \
    probe-capture "$scene" odd.probe

four() { capture $all --order 4 "$@" "$scene" placed.probe; }
both="--content irradiance --dering radiance --dering-floor .05"
four $both >four.derung
four | probe-cat -q $both >four.turned
plain four.derung >a.probe
plain four.turned >b.probe
few=position,sh,sh_error,sh_window
for order in 3 auto; do
    loses() { capture --order $order --order-loss .1 "$@" "$scene" placed.probe; }
    loses | probe-cat -q --dering irradiance >c.stream
    loses --dering irradiance >d.stream
    plain c.stream $few >c.probe
    plain d.stream $few >d.probe
    check "--order $order de-rings as probe-cat does after it" same_rows c.probe d.probe
done
check "both at once, too" same_rows a.probe b.probe

# -- bases -----------------------------------------------------------------------------------------
probe-cat --basis cube,dice,dice-cubic,ahd --report radiance.probe >bases.probe 2>said
info bases.probe
check "each basis is a column beside the SH" says info '^  ambient_cube *f32:18' \
    '^  ambient_dice *f32:36' '^  ambient_dice_cubic *f32:108' '^  ahd *f32:9' '^  sh *f32:27'
figures='RMS [0-9.]+ %, worst [0-9.]+ % .* of mean irradiance'
grep -E "^probe-cat: (cube|dice|dice-cubic|ahd): $figures" said >reports
check "the report says how good each is" has_lines 4 reports
probe-cat --basis cube --drop sh,sh_error,sh_gradient radiance.probe >small.probe
info small.probe
check "--drop leaves the basis alone" says info '^  ambient_cube' and lacks info '^  sh'
probe-cat --content irradiance radiance.probe | probe-cat --basis cube --content radiance |
    probe-cat --columns position,ambient_cube --tables probe >a.probe
info a.probe
check "a basis may be asked of either kind" says info 'ambient_cube *f32:18'
probe-cat --dering radiance bases.probe >new.probe 2>err
info new.probe
check "what de-ringing makes untrue goes, with a warning" \
    says err 'column ambient_cube is of the light as it was: dropped' and \
    says info '^  sh ' and lacks info '^  ambient' '^  ahd'
probe-cat -q --dering radiance --basis cube bases.probe >new.probe
info new.probe
check "unless it is made anew" says info '^  ambient_cube' and lacks info '^  ambient_dice'
refused 2 "expected some of cube, dice, dice-cubic, ahd, separated by commas, got 'cubes'" \
    probe-cat --basis cubes radiance.probe
refused 2 "expected some of cube" probe-cat --basis cube, radiance.probe
refused 2 "--report is of --basis" probe-cat --report radiance.probe
refused 1 "the probes have no light (no column sh): run probe-capture" \
    probe-cat --basis cube placed.probe
refused 2 "without conversions" probe-cat --info --basis cube radiance.probe
probe-cat --text bases.probe | sed 's/ambient_cube:f32:18/ambient_cube:f32:18x/' >bad.probe
refused 1 "bad.probe" probe-cat bad.probe
stream_of 'table probe position:f64:3 ahd:f32:3' </dev/null >bad.probe
refused 1 "column ahd: expected f32:9, got f32:3" probe-cat bad.probe

# -- turned ----------------------------------------------------------------------------------------
# turn: X,Y,Z by a third of a turn about (1,1,1), which takes x to y, y to z, z to x, exactly
turn="0,0,1,1,0,0,0,1,0"
printf 'v %s\n' '0 0 0' '4 0 0' '0 0 4' >wall.obj
printf 'v %s\n' '0 0 0' '0 4 0' '4 0 0' >turned.obj
for i in wall turned; do echo 'f 1 2 3' >>$i.obj; done
printf '%s\n' '1 1 1' '2 .5 .3' '.5 2 3' | stream_of 'table probe position:f64:3' >three.probe
printf '%s\n' '1 1 1' '.3 2 .5' '3 .5 2' | stream_of 'table probe position:f64:3' >other.probe
direct="-q --rays 16 --light direct --columns sh_error --order 4"
probe-capture $direct --point 3,2,1,1,2,3 wall.obj three.probe >lit.probe
probe-capture $direct --point 1,3,2,1,2,3 turned.obj other.probe >wanted.probe
probe-cat --text --rotate $turn lit.probe >rotated.probe
probe-cat --text --columns position,sh rotated.probe | numbers >got
probe-cat --text --columns position,sh wanted.probe | numbers >want
check "turned light is what the turned scene has" near 2e-6 want got
probe-cat --text --rotate 1,1,1,120 lit.probe | probe-cat --text --columns position,sh |
    numbers >axis
check "by an axis and an angle, too" near 1e-6 got axis
check "the header says that it was turned" says rotated.probe '^rotated 0,0,1,1,0,0,0,1,0$'
refused 1 "the probes were turned (key rotated), and no scene fits them" \
    probe-capture -q --again wall.obj rotated.probe
probe-tet -q rotated.probe >baked.probe
refused 1 "the probes were turned" probe-error -q wall.obj baked.probe
probe-cat --rotate 1,1,1,-120 rotated.probe >back.probe
info back.probe
check "turned back, it is of its scene again" lacks info '^key rotated' and \
    probe-capture -q --again -o /dev/null wall.obj back.probe
probe-cat --text --rotate-light $turn lit.probe >turned.probe
check "the light alone: probes stay" says turned.probe '^rotated-light 0,0,1,1,0,0,0,1,0$' and \
    lacks turned.probe '^rotated '
probe-cat --text --columns position,sh turned.probe | numbers | cut -d ' ' -f 4- >light
probe-cat --text --columns position,sh rotated.probe | numbers | cut -d ' ' -f 4- >both
check "and have the same light as where all is turned" cmp light both
probe-tet -q turned.probe >baked.probe
refused 1 "the light of the probes was turned" probe-leakfix -q wall.obj baked.probe
probe-cat --rotate $turn turned.probe | probe-cat --rotate 1,1,1,-120 >back.probe
info back.probe
check "one after another: what is turned back goes" \
    says info '^key rotated-light 0,0,1,1,0' and lacks info '^key rotated '
# light between turned probes, and outside of their hull, is that between probes, turned
probe-cat --rotate $turn fixed.radiance.probe >fixed.turned.probe
awk 'BEGIN { srand(3); for (i = 0; i < 200; i++) print 8 * rand() - 2, 5 * rand() - 1,
    8 * rand() - 2, 0, 1, 0 }' >points.txt
awk '{ print $3, $1, $2, $6, $4, $5 }' points.txt >points.turned.txt
probe-query -q fixed.radiance.probe points.txt >a
probe-query -q fixed.turned.probe points.turned.txt >b
info fixed.turned.probe
check "probe-query answers a turned point and normal alike" near 2e-5 a b
check "what cells see outside of the hull turns with them" says info '^  sight_outside'
probe-cat -q --rotate $turn --basis cube bases.probe >a.probe 2>err
info a.probe
check "bases along the axes are made anew" says info 'ambient_cube' and lacks info 'ambient_dice'
refused 2 "the matrix mirrors (its determinant is -1)" probe-cat --rotate -1,0,0,0,1,0,0,0,1
refused 2 "expected a rotation: rows of length 1" probe-cat --rotate 1,0,0,0,2,0,0,0,1
refused 2 "--rotate: expected X,Y,Z,DEGREES or the nine numbers of a matrix, got '1,2'" \
    probe-cat --rotate 1,2
refused 2 "expected an axis, got 0,0,0" probe-cat --rotate 0,0,0,90
refused 2 "got both" probe-cat --rotate 0,1,0,90 --rotate-light 0,1,0,90
refused 1 "the probes have no light to turn" probe-cat --rotate-light 0,1,0,90 placed.probe
probe-cat -q --rotate 0,1,0,90 three.probe >a.probe
info a.probe
check "bare probes are turned, and of no scene" lacks info '^key rotated'

# -- surfaces have neither -------------------------------------------------------------------------
echo '1 0.5 0.5 0 1 0' | stream_of 'table probe position:f64:3 normal:f32:3' >surface.probe
capture "$scene" surface.probe >plain.probe
capture --content irradiance --dering irradiance "$scene" surface.probe >asked.probe
refused 1 "the probes are of surfaces: they have irradiance (one colour), no SH to convert" \
    probe-cat --basis cube plain.probe
probes plain.probe >was
probes asked.probe >asked
check "irradiance of a surface is what it was" cmp was asked and test -s was
probe-cat --text --columns position,normal,irradiance plain.probe | numbers |
    awk '{ print $3, $1, $2, $6, $4, $5, $7, $8, $9 }' >want
probe-cat --text --rotate $turn plain.probe | probe-cat --text --columns \
    position,normal,irradiance | numbers >got
check "turned, its place and normal turn, and its irradiance stays" near 1e-6 want got
refused 1 "irradiance is of one normal: expected --rotate" \
    probe-cat --rotate-light 0,1,0,90 plain.probe
tap_done
