#!/bin/sh
# Light in other shapes, as users ask for it: irradiance, de-ringing, other bases; from probe-capture and from probe-cat, the same.
. "${SRC:?}/tests/support/setup.sh"
scene=$SRC/scenes/two-rooms.obj
lamp="--point 1,1.5,1,9,6,3"
capture() { probe-capture --quiet --rays 32 --bounces 2 $lamp "$@"; }
# rows STREAM: its tables, as text
rows() { probe-cat --text "$1" | sed -n '/^table/,$p'; }
same_rows() { rows "$1" >same.a && rows "$2" >same.b && cmp same.a same.b; }
key() { probe-cat --info "$2" | sed -n "s/^key $1 //p"; }

probe-place grid -q --count 60 "$scene" | probe-tet -q >placed.probe
all="--columns sh_error,sh_gradient,validity"
capture $all "$scene" placed.probe >radiance.probe

# -- content -----------------------------------------------------------------------------------------
capture $all --content irradiance "$scene" placed.probe >irradiance.probe
check "the key says what was asked for" [ "$(key sh-content irradiance.probe)/$(key sh-content radiance.probe)" = irradiance/radiance ]
probe-cat --content irradiance radiance.probe >turned.probe
check "capture gives irradiance as probe-cat makes it of radiance, byte for byte" same_rows irradiance.probe turned.probe
probe-cat --content irradiance turned.probe >again.probe
check "what is irradiance already stays" same_rows again.probe turned.probe
probe-cat --text --content radiance turned.probe | grep -v '^#' >back.text
check "and becomes radiance again, to 7 digits" sh -c "probe-cat --text radiance.probe | grep -v '^#' | paste -d ' ' - back.text | awk '
    NF > 20 && /^[0-9-]/ { n = NF / 2; for (i = 1; i <= n; i++) { d = \$i - \$(i + n); m = \$i < 0 ? -\$i : \$i; if (d > 3e-7 * m || -d > 3e-7 * m) bad = 1 } seen++ }
    END { exit bad || seen < 20 }'"
awk 'BEGIN { for (i = 0; i < 12; i++) print .3 + i * .2, .4 + i * .1, .5, (i % 3) - 1, i % 2, .5 }' >points.txt
probe-query -q radiance.probe points.txt >light.radiance
probe-query -q irradiance.probe points.txt >light.irradiance
check "probe-query gives the same light of both" sh -c "paste light.radiance light.irradiance | awk '
    { for (i = 1; i <= 3; i++) { d = \$i - \$(i + 3); if (d * d > 1e-10 * \$i * \$i) bad = 1 } } END { exit bad || NR != 12 }'"
for i in 1 2; do capture $all --content irradiance --slice $i/2 "$scene" placed.probe >slice$i.probe; done
probe-capture -q $all "$scene" slice1.probe >resumed.probe
check "a capture is resumed in the kind that it was begun in" same_rows resumed.probe irradiance.probe
probe-cat --fill slice2.probe slice1.probe >filled.probe
check "and filled from its slices" same_rows filled.probe irradiance.probe
refused 1 "the probes were captured with sh-content irradiance, not radiance" probe-capture --content radiance "$scene" slice1.probe
refused 1 "sh-content is radiance, and theirs is irradiance" probe-cat --fill radiance.probe slice1.probe
probe-leakfix -q "$scene" irradiance.probe >fixed.irradiance.probe
probe-leakfix -q "$scene" radiance.probe | probe-cat --content irradiance >fixed.radiance.probe
check "probe-leakfix captures new probes in it" same_rows fixed.irradiance.probe fixed.radiance.probe
check "of which there are some" sh -c "! cmp -s fixed.irradiance.probe irradiance.probe"
capture --order 4 --content irradiance "$scene" placed.probe >four.probe
refused 1 "radiance of order 4 cannot be had from irradiance, in which band 3 leaves no trace" probe-cat --content radiance four.probe
probe-cat --order 3 --content radiance four.probe >three.probe
check "--order cuts what cannot be undone" [ "$(key sh-order three.probe)/$(key sh-content three.probe)" = 3/radiance ]
probe-capture -q --order auto --order-loss .3 --rays 32 --bounces 2 $lamp "$scene" placed.probe >auto.radiance.probe
probe-capture -q --order auto --order-loss .3 --rays 32 --bounces 2 $lamp --content irradiance "$scene" placed.probe >auto.irradiance.probe
probe-cat --content irradiance auto.radiance.probe >turned.probe
check "--order auto chooses the same order" same_rows auto.irradiance.probe turned.probe

# -- order -------------------------------------------------------------------------------------------
capture $all --order 2 "$scene" placed.probe >two.probe
probe-cat --order 2 radiance.probe >cut.probe
check "--order cuts to what a capture of that order is" same_rows cut.probe two.probe
refused 1 "the probes have order 2: it cannot be raised to 3" probe-cat --order 3 two.probe

# -- de-ringing --------------------------------------------------------------------------------------
capture $all --dering irradiance "$scene" placed.probe >derung.probe
probe-cat --dering irradiance radiance.probe >turned.probe 2>said
# column order apart: sh_window stands elsewhere
columns="position,sh,sh_error,sh_gradient,validity,sh_window"
probe-cat --columns $columns --tables probe derung.probe | probe-cat --drop sh_window >a.probe
probe-cat --columns $columns --tables probe turned.probe | probe-cat --drop sh_window >b.probe
check "capture de-rings as probe-cat does, byte for byte" same_rows a.probe b.probe
check "the header says how" [ "$(key sh-dering derung.probe)" = "irradiance 0" ]
changed=$(probe-cat -q --text --tables probe --columns position,sh_window --where 'sh_window < 1' turned.probe | grep -c '^[0-9-]')
check "standard error and sh_window count the same, some of them changed" sh -c "grep -q 'probe-cat: $changed of [0-9]* probes de-rung, the least r is 0\.' said && [ $changed -gt 2 ]"
check "probe-capture says it as well" sh -c "probe-capture --rays 32 --bounces 2 $lamp --dering irradiance '$scene' placed.probe 2>&1 >/dev/null |
    grep -q 'probe-capture: $changed of'"
check "what does not ring keeps its bits" sh -c "
    probe-cat -q --text --tables probe --columns position,sh,sh_window --where 'sh_window = 1' turned.probe | grep '^[0-9-]' | cut -d ' ' -f 1-30 >kept
    probe-cat --text --tables probe --columns position,sh radiance.probe | grep '^[0-9-]' >was
    grep -cxFf was kept >matches; [ \$(cat matches) -eq \$(wc -l <kept) ] && [ \$(cat matches) -gt 2 ]"
probe-cat --dering irradiance turned.probe >again.probe 2>said
check "a second pass changes nothing" sh -c "grep -q 'probe-cat: 0 of' said"
check "not a bit" same_rows again.probe turned.probe
for threads in 1 3; do probe-cat -q --threads $threads --dering radiance --dering-floor .1 --basis dice,ahd radiance.probe >t$threads.probe; done
check "1 and 3 threads give the same bytes" cmp t1.probe t3.probe
for i in 1 2; do capture $all --dering irradiance --slice $i/2 "$scene" placed.probe >slice$i.probe; done
probe-capture -q $all "$scene" slice1.probe >resumed.probe
check "a capture is resumed de-ringing as it began" same_rows resumed.probe derung.probe
check "--quiet says nothing" sh -c "[ -z \"\$(probe-cat -q --dering radiance --basis cube --report radiance.probe 2>&1 >/dev/null)\" ]"
probe-capture -q --again --rays 8 "$scene" derung.probe >anew.probe
check "captured anew, the window is forgotten" sh -c "! probe-cat --info anew.probe | grep -qE 'sh-dering|sh_window'"
GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-AVX512F probe-cat -q --dering radiance --dering-floor .1 --basis dice,ahd radiance.probe >plain.probe
check "libm's faster instructions change nothing" cmp plain.probe t1.probe
printf '%s\n' '#?probe 1' 'table probe position:f64:3 sh:f32:12' '0 0 0 -1 1 1 0 0 0 0 0 0 0 0 0' '1 0 0 nan nan nan nan nan nan nan nan nan nan nan nan' \
    '2 0 0 1 1 1 9 0 0 0 0 0 0 0 0' end >odd.text
probe-cat --text --dering irradiance odd.text >mended.text 2>said
check "a mean below 0 is left and said to be, what is missing stays missing" sh -c "grep -q '1 probes have a mean below 0' said && grep -q ': 1 of 2 probes de-rung' said &&
    grep -qx '0 0 0 -1 1 1 0 0 0 0 0 0 0 0 0 1' mended.text && grep -q '^1 0 0 nan .* nan$' mended.text"
refused 1 "the probes were captured with sh-dering irradiance 0, not none" probe-capture --dering none "$scene" slice1.probe
refused 1 "radiance cannot be known from irradiance of an order above 3" probe-cat --dering radiance four.probe
refused 2 "--dering-floor needs --dering" probe-cat --dering-floor .1 radiance.probe
refused 2 "--dering-floor" probe-cat --dering irradiance --dering-floor 1 radiance.probe
refused 2 "--dering" probe-cat --dering everything radiance.probe
refused 2 "--order N does both" probe-capture --order auto --dering radiance --content irradiance "$scene" placed.probe
sed 's/^sh-content.*/&\nsh-dering much/' >odd.probe <<END
$(probe-cat --text slice1.probe | sed '/^sh-dering/d')
END
refused 1 "header key sh-dering: expected irradiance or radiance and a floor" probe-capture "$scene" odd.probe

capture $all --order 4 --content irradiance --dering radiance --dering-floor .05 "$scene" placed.probe | probe-cat --tables probe --columns $columns | probe-cat --drop sh_window >a.probe
capture $all --order 4 "$scene" placed.probe | probe-cat -q --content irradiance --dering radiance --dering-floor .05 --tables probe --columns $columns | probe-cat --drop sh_window >b.probe
for order in 3 auto; do
    probe-capture -q --order $order --order-loss .1 --rays 32 --bounces 2 $lamp "$scene" placed.probe | probe-cat -q --dering irradiance --tables probe --columns position,sh,sh_error,sh_window |
        probe-cat --drop sh_window >c.probe
    probe-capture -q --order $order --order-loss .1 --rays 32 --bounces 2 $lamp --dering irradiance "$scene" placed.probe | probe-cat --tables probe --columns position,sh,sh_error,sh_window |
        probe-cat --drop sh_window >d.probe
    check "--order $order de-rings as probe-cat does after it" same_rows c.probe d.probe
done
check "both at once, too" same_rows a.probe b.probe

# -- bases -------------------------------------------------------------------------------------------
probe-cat --basis cube,dice,dice-cubic,ahd --report radiance.probe >bases.probe 2>said
check "each basis is a column beside the SH" sh -c "probe-cat --info bases.probe | awk '/ambient_cube +f32:18|ambient_dice +f32:36|ambient_dice_cubic +f32:108|ahd +f32:9|sh +f32:27/ { n++ }
    END { exit n != 5 }'"
check "the report says how good each is" sh -c "[ \$(grep -cE '^probe-cat: (cube|dice|dice-cubic|ahd): RMS [0-9.]+ %, worst [0-9.]+ % .* of mean irradiance' said) -eq 4 ]"
probe-cat --basis cube --drop sh,sh_error,sh_gradient radiance.probe >small.probe
check "--drop leaves the basis alone" sh -c "probe-cat --info small.probe | grep -q '^  ambient_cube' && ! probe-cat --info small.probe | grep -qE '^  sh'"
probe-cat --content irradiance radiance.probe | probe-cat --basis cube --content radiance | probe-cat --columns position,ambient_cube --tables probe >a.probe
check "a basis may be asked of either kind" sh -c "probe-cat --info a.probe | grep -q 'ambient_cube *f32:18'"
probe-cat --dering radiance bases.probe >new.probe 2>err
check "what de-ringing makes untrue goes, with a warning" sh -c "grep -q 'column ambient_cube is of the light as it was: dropped' err && ! probe-cat --info new.probe | grep -qE '^  (ambient|ahd)'"
probe-cat -q --dering radiance --basis cube bases.probe >new.probe
check "unless it is made anew" sh -c "probe-cat --info new.probe | grep -q '^  ambient_cube' && ! probe-cat --info new.probe | grep -q '^  ambient_dice'"
refused 2 "expected some of cube, dice, dice-cubic, ahd, separated by commas, got 'cubes'" probe-cat --basis cubes radiance.probe
refused 2 "expected some of cube" probe-cat --basis cube, radiance.probe
refused 2 "--report is of --basis" probe-cat --report radiance.probe
refused 1 "the probes have no light (no column sh): run probe-capture" probe-cat --basis cube placed.probe
refused 2 "without conversions" probe-cat --info --basis cube radiance.probe
probe-cat --text bases.probe | sed 's/ambient_cube:f32:18/ambient_cube:f32:18x/' >bad.probe
refused 1 "bad.probe" probe-cat bad.probe
printf '%s\n' '#?probe 1' 'table probe position:f64:3 ahd:f32:3' end >bad.probe
refused 1 "column ahd: expected f32:9, got f32:3" probe-cat bad.probe

# -- surfaces have neither ---------------------------------------------------------------------------
printf '%s\n' '#?probe 1' 'table probe position:f64:3 normal:f32:3' '1 0.5 0.5 0 1 0' end >surface.probe
capture "$scene" surface.probe >plain.probe
capture --content irradiance --dering irradiance "$scene" surface.probe >asked.probe
refused 1 "the probes are of surfaces: they have irradiance (one colour), no SH to convert" probe-cat --basis cube plain.probe
check "irradiance of a surface is what it was" sh -c "probe-cat --text --tables probe plain.probe | grep '^[0-9]' >a; probe-cat --text --tables probe asked.probe | grep '^[0-9]' | cmp - a"
tap_done
