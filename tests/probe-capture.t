#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-capture as users run it.
. "${SRC:?}/tests/support/setup.sh"
scene=$SRC/scenes/cornell-box.obj
probe-place grid -q --count 40 "$scene" >placed.probe

capture() { probe-capture --rays 32 --bounces 3 "$@"; }
# describe STREAM: its --info, in info
describe() { probe-cat --info "$1" >info; }
# all_lit STREAM: no probe is without light
all_lit() {
    probe-cat --text "$1" >all_lit.text || return
    says all_lit.text '^[0-9-]' && lacks all_lit.text nan
}

# -- what is captured ------------------------------------------------------------------------------
check "probes get light, error, validity, depth and sky" \
    into a.probe probe-capture --rays 32 "$scene" placed.probe and describe a.probe \
    and says info '^  sh ' '^  sh_error ' '^  validity ' '^  depth ' '^  sky '
capture "$scene" placed.probe >a.probe
capture "$scene" <placed.probe >b.probe
check "a file and standard input are the same" cmp a.probe b.probe and test -s a.probe
for threads in 1 2 4; do
    capture --threads $threads "$scene" placed.probe >threads$threads.probe
done
check "1, 2 and 4 threads give the same bytes" test -s threads1.probe \
    and cmp threads1.probe threads2.probe and cmp threads1.probe threads4.probe
plain_libm probe-capture --rays 32 --bounces 3 --columns sh_error,sh_gradient \
    "$scene" placed.probe >plain.probe
capture --columns sh_error,sh_gradient "$scene" placed.probe >fast.probe
check "libm's faster instructions change nothing" cmp plain.probe fast.probe and test -s fast.probe
capture --seed 1 "$scene" placed.probe >seed.probe
check "another seed gives other light" differ a.probe seed.probe
capture --order 1 --columns none --text "$scene" placed.probe >small.probe
check "order 1 and no columns leave sh of 3 alone" \
    says small.probe '^table probe position:f64:3 sh:f32:3$'

# Slices give what the whole gives.
probe-cat --rows 0:10 placed.probe | capture "$scene" >slice1.probe
probe-cat --rows 10: placed.probe | capture "$scene" >slice2.probe
probe-cat --no-provenance slice1.probe slice2.probe >merged.probe
probe-cat --no-provenance --text merged.probe | numbers >merged.rows
probe-cat --no-provenance --text a.probe | numbers >whole.rows
check "slices, merged, are the whole" cmp merged.rows whole.rows and test -s whole.rows

# -- a second pass captures what is missing as the others were -------------------------------------
capture --light indirect --order 2 "$scene" placed.probe | probe-tet --enclose >enclosed.probe
check "a second pass takes the settings over" \
    into second.probe probe-capture -q "$scene" enclosed.probe and describe second.probe \
    and says info 'key capture-light indirect' and all_lit second.probe
rows_of position,sh enclosed.probe | grep -v nan >before.rows
rows_of position,sh second.probe | head -n "$(wc -l <before.rows)" >after.rows
check "and leaves what was captured" cmp after.rows before.rows and test -s before.rows
refused 1 "captured with capture-rays 32, not 64" probe-capture --rays 64 "$scene" a.probe
refused 1 "another scene" probe-capture "$SRC/scenes/two-rooms.obj" a.probe
refused 1 "another scene" probe-capture --sky 1,1,1 "$scene" a.probe
probe-capture --again --rays 64 "$scene" a.probe >again.probe
check "--again captures all anew" describe again.probe and says info 'key capture-rays 64'
check "direct and indirect are accepted" capture --light direct "$scene" placed.probe

# -- a scene of fewer triangles --------------------------------------------------------------------
# The header knows it, and the scene by its whole. A tenth of the Cornell box is nothing.
capture --decimate .5 "$scene" placed.probe >half.probe
scene_key() { probe-cat --info "$1" | grep '^key scene-key'; }
scene_key a.probe >wanted
scene_key half.probe >got
check "--decimate is kept, with the key of the whole scene" describe half.probe \
    and says info '^key capture-decimate 0.5$' and cmp got wanted and test -s wanted
probe-cat --no-provenance --text half.probe | numbers >half.rows
check "and gives other light" differ half.rows whole.rows
capture --decimate 1 "$scene" placed.probe >one.probe
check "--decimate 1 is the whole scene" same_stream a.probe one.probe
probe-cat --rows 0:10 half.probe >slice1.probe
probe-cat --rows 10: placed.probe >slice2.probe
probe-cat slice1.probe slice2.probe | probe-capture -q "$scene" |
    probe-cat --no-provenance --text | numbers >second.rows
check "a second pass decimates alike" cmp second.rows half.rows and test -s half.rows
refused 1 "captured with capture-decimate 0.5, not none" \
    probe-capture --decimate 1 "$scene" half.probe
refused 1 "captured with capture-decimate none, not 0.5" \
    probe-capture --decimate .5 "$scene" a.probe
probe-capture --rays 32 --decimate .01 "$scene" placed.probe 2>err >few.probe
check "what cannot go is said" says err 'of 32 triangles are left'
sed 's/^capture-decimate 0.5/capture-decimate 2/' half.probe >bad.probe
share="expected a share above 0 and at most 1, got '2'"
refused 1 "header key capture-decimate: $share" probe-capture "$scene" bad.probe
refused 2 "--decimate" probe-capture --decimate 0 "$scene" placed.probe
refused 2 "--decimate" probe-capture --decimate 1.01 "$scene" placed.probe

# -- rays by error, orders by what irradiance needs, columns on request, surfaces ------------------
probe-capture -e 0.1 --emit front --columns sh_error,rays --text "$scene" placed.probe >error.probe
probe-cat --where 'rays[0]>200' error.probe >many_rays.probe
check "every probe as exactly as is asked" says error.probe '^capture-error 0.1' \
    and describe many_rays.probe and says info 'table probe: [1-9]'
probe-tet --enclose error.probe | probe-capture -q "$scene" >second.probe
check "such a stream goes on as it began" \
    describe second.probe and says info 'key capture-error 0.1'
refused 1 "captured with capture-error 0.1, not 0.2" probe-capture -e 0.2 "$scene" error.probe
probe-capture -q --again "$scene" error.probe >second.probe
rows_of position,sh error.probe >before.rows
rows_of position,sh second.probe >after.rows
check "--again has the error, and what else the header says, and the same comes out" \
    cmp before.rows after.rows and test -s after.rows
check "but where it is told how many rays" into second.probe probe-capture -q --again \
    --rays 16 "$scene" error.probe and describe second.probe \
    and says info 'key capture-rays 16' and lacks info capture-error
probe-capture --rays 64 --order auto --order-loss 0.05 "$scene" placed.probe 2>err >auto.probe
order=$(sed -n 's/.*order \([1-5]\) loses.*/\1/p' err)
check "--order auto says what it keeps" says err 'order [1-5] loses 0.0' \
    and describe auto.probe and says info "key sh-order $order"
kept=$(sed -n 's/^key sh-order //p' info)
probe-capture --rays 64 --order "$kept" "$scene" placed.probe >same.probe
check "and it is what that order gives" same_stream auto.probe same.probe
capture --columns sh_gradient,visibility,ao,rays --text "$scene" placed.probe >columns.probe
light="sh:f32:27 sh_gradient:f32:81 visibility:f32:9 ao:f32:1 rays:i32:1"
check "--columns writes what was asked for" \
    says columns.probe "^table probe position:f64:3 $light$"
stream_of 'table probe position:f64:3 normal:f32:3' >surface.probe <<'END'
2.7 0.001 2.7 0 1 0
2.7 5.4 2.7 0 -1 0
END
probe-capture --columns irradiance_error,ao,bent_normal --text "$scene" surface.probe >lit.probe
light="irradiance:f32:3 irradiance_error:f32:3 ao:f32:1 bent_normal:f32:3"
check "surfaces get irradiance" \
    says lit.probe "^table probe position:f64:3 normal:f32:3 $light$"
refused 1 "sh_gradient is known of probes without a normal alone" \
    probe-capture --columns sh_gradient "$scene" surface.probe
refused 1 "ao_bounced is known of probes with a normal alone" \
    probe-capture --columns ao_bounced "$scene" placed.probe
stream_of 'table probe position:f64:3 normal:f32:3 albedo:f32:3' >painted.probe <<'END'
1 0.001 5 0 1 0 0 0.5 1
1 0.001 5 0 1 0 nan nan nan
END
probe-capture -q --light none --columns ao,ao_bounced --text "$scene" painted.probe >bounced.probe
numbers <bounced.probe >bounced.rows
check "light that occluders scatter goes by column albedo, or the surface's own" awk '
    function near(a, b) { return a - b < 1e-6 && b - a < 1e-6 }
    { k = $10; ok[NR] = k > 0.1 && k < 0.9 && $11 >= k }
    NR == 1 { ok[1] = ok[1] && $11 == k && near($12, k / (1 - 0.5 * (1 - k))) && near($13, 1) }
    END { exit !(NR == 2 && ok[1] && ok[2]) }' bounced.rows
probe-capture -q --light none --columns horizon --azimuths 4 --text "$scene" surface.probe \
    >horizon.probe
check "the horizon of each azimuth" into seen.probe capture --text "$scene" horizon.probe \
    and says seen.probe '^capture-azimuths 4$' ' horizon:f32:4 ' and lacks seen.probe nan
check "is dropped where probes are turned" into err probe-cat --rotate 0,1,0,30 --text \
    horizon.probe and says err 'normal:f32:3$'
refused 2 "--azimuths" probe-capture --azimuths 65 "$scene" surface.probe
sed 's/0 1 0$/0 0 0/' surface.probe >flat.probe
refused 1 "probe 0: expected a normal, got (0, 0, 0)" probe-capture "$scene" flat.probe
refused 1 "beyond what 32 bits can hold" \
    probe-capture --point 250,250,250,1e100,1,1 "$scene" placed.probe
refused 2 "--error" probe-capture --error 0 "$scene" placed.probe
refused 2 "--ao-distance" probe-capture --ao-distance -1 "$scene" placed.probe
refused 2 "auto" probe-capture --order most "$scene" placed.probe

# -- occlusion without light -----------------------------------------------------------------------
near="--ao-distance 8 --ao-falloff linear"
probe-capture -q --light none $near --text "$scene" surface.probe >open.probe
check "--light none captures occlusion alone" \
    says open.probe "^table probe position:f64:3 normal:f32:3 ao:f32:1$" \
    and says open.probe '^capture-ao-falloff linear$' and lacks open.probe '^capture-rays'
capture --columns irradiance_error "$scene" open.probe >later.probe
capture -q $near --columns irradiance_error,ao "$scene" surface.probe >together.probe
rows_of position,ao,irradiance later.probe >later.rows
rows_of position,ao,irradiance together.probe >together.rows
check "light that comes later keeps how far occlusion goes" cmp later.rows together.rows \
    and test -s later.rows
probe-capture -q --light none --columns bent_normal,bent_length,cone --rays 32 --text "$scene" \
    placed.probe >cones.probe
check "points have bent normals and cones, too" says cones.probe \
    '^table probe position:f64:3 bent_normal:f32:3 bent_length:f32:1 cone:f32:4$'
probe-capture -q --light none --columns ao,bent_normal,bent_length,cone,visibility --rays 32 \
    "$scene" placed.probe >seen.probe
rows_of position,ao,bent_normal,bent_length,cone seen.probe >rays.rows
probe-cat --drop ao,bent_normal,bent_length,cone seen.probe | probe-cat --occlusion >derived.probe
rows_of position,ao,bent_normal,bent_length,cone derived.probe >derived.rows
check "probe-cat --occlusion makes them of visibility" awk '
    NR == FNR { for (i = 4; i <= NF; i++) ray[FNR, i] = $i; rows = FNR; next }
    { for (i = 4; i <= NF; i++) { d = $i - ray[FNR, i]; if (d > 1e-5 || d < -1e-5) bad++ } }
    END { exit !(rows > 30 && rows == FNR && !bad) }' rays.rows derived.rows
refused 1 "expected a column visibility" probe-cat --occlusion placed.probe
probe-capture -q --light none --columns visibility --order 1 --rays 16 \
    "$scene" placed.probe >mean.probe
refused 1 "column visibility: expected order 2 or more" probe-cat --occlusion mean.probe
probe-capture -q --light none --columns ao,sky --ao-distance 2 "$scene" later.probe >other.probe
rows_of position,irradiance later.probe >later.rows
rows_of position,irradiance other.probe >other.rows
check "and other occlusion leaves the light as it was" cmp later.rows other.rows \
    and describe other.probe and says info 'key capture-ao-distance 2' \
    and says info 'key capture-light all' and says info '^  sky '
probe-capture -q --light none --slice 1/2 "$scene" open.probe >half.probe
probe-capture -q --light none --slice 2/2 "$scene" open.probe >other.probe
probe-cat --fill other.probe half.probe >filled.probe
probe-capture -q --light none "$scene" open.probe >whole.probe
rows_of position,ao filled.probe >filled.rows
rows_of position,ao whole.probe >whole.rows
check "in slices, too" cmp filled.rows whole.rows and test -s filled.rows
refused 1 "captured in another scene" probe-capture --light none "$SRC/scenes/two-rooms.obj" \
    later.probe
refused 2 "--links needs --transfer surfaces:STREAM" \
    probe-capture --links 8 "$scene" placed.probe
refused 2 "--ao-falloff sqrt needs --ao-distance" \
    probe-capture --ao-falloff sqrt "$scene" placed.probe
refused 2 "expected --columns without sh_error" \
    probe-capture --light none --columns sh_error "$scene" placed.probe
refused 2 "is of light" probe-capture --light none --error .1 "$scene" placed.probe
refused 2 "--ao-distance" probe-capture --ao-distance 0 "$scene" placed.probe

# -- what comes in ---------------------------------------------------------------------------------
# Work starts before the input ends: the end comes when there is light.
mkfifo pipe
probe-place grid -q --text --count 2500 --inside keep "$scene" >many.probe
capture --text --rays 4 "$scene" pipe >streamed.probe &
{ sed '/^end/d' many.probe; wait_for grep -q '^[0-9-]' streamed.probe && echo end; } >pipe
wait
check "a stream passes while it comes" says streamed.probe '^end'
printf '%s\n' 'v 0 -1 0' 'v 1 -1 0' 'v 0 -1 1' 'f 1 2 3' >dark.obj
capture dark.obj placed.probe 2>err >dark.probe
check "no light at all is legal, and said" says err 'warning: .*no light' and all_lit dark.probe
cat >house.mtl <<'END'
newmtl Wall
newmtl Window_Glass
END
{
    printf 'mtllib house.mtl\nusemtl Wall\n'
    awk 'BEGIN { for (i = 0; i < 8; i++) print "v", i % 2 * 8 - 4, int(i / 2) % 2 * 8 - 4,
            int(i / 4) * 8 - 4 }'
    printf 'f %s\n' '1 2 4 3' '5 7 8 6' '1 5 6 2' '3 4 8 7' '1 3 7 5'
    printf 'usemtl Window_Glass\nf 2 6 8 4\n'
} >house.obj
printf '%s\n' '#?probe 1' 'table probe position:f64:3' '0 0 0' '1 1 1' end >inside.probe
capture --sky 1,1,1 house.obj inside.probe 2>err >black.probe
check "all black although there is light is said, with what may be in the way" \
    says err "probes are black though there is light" "'Window_Glass' may be glass" \
    and all_lit black.probe
echo 'd .5' >>house.mtl
capture --sky 1,1,1 house.obj inside.probe 2>err >dim.probe
check "and not where some light gets in" lacks err "black"
: >nothing.obj
refused 1 "nothing.obj: the file is empty" probe-capture --sky 1,1,1 nothing.obj placed.probe
refused 2 "cannot both come from standard input" \
    into /dev/null probe-capture /dev/stdin <placed.probe
capture --lenient --sky 1,1,1 nothing.obj placed.probe 2>err >sky.probe
check "no scene at all is legal, and said" says err 'warning: .*empty' and all_lit sky.probe

# -- what is refused -------------------------------------------------------------------------------
refused 1 "stdin: expected a probe stream, got nothing" probe-capture "$scene" </dev/null
head -c 300 placed.probe >cut.probe
refused 1 "cut.probe" probe-capture "$scene" cut.probe
refused 1 "No such file" probe-capture none.obj placed.probe
refused 1 "No space left" into /dev/full probe-capture --rays 4 "$scene" placed.probe
refused 2 "--order: expected a whole number from 1 to 6, or auto, got '7'" \
    probe-capture --order 7 "$scene"
refused 2 "--rays" probe-capture --rays 0 "$scene"
refused 2 "--sky" probe-capture --sky 1,2 "$scene"
refused 2 "--sun" probe-capture --sun 0,0,0,1,1,1 "$scene"
refused 2 "expected some of sh_error" probe-capture --columns sh,foo "$scene"
refused 2 "SCENE" probe-capture

# -- the light of the first run --------------------------------------------------------------------
lights='--sky .5,.6,.8 --sun .2,-1,.3,10,9,8 --point 1,2,1,5,5,5 --emit front --albedo-scale .5'
probe-place grid -q --count 12 "$scene" >dozen.probe
probe-capture -q --rays 16 $lights "$scene" dozen.probe >lit.probe
light_of() { # light_of FILE: keys of its light
    keys='sky|sky-file|sun-|point-|spot-|emit|albedo-scale|max-albedo|light-scale|scene-key'
    probe-cat --text "$1" | grep -E "^($keys)" | sort
}
light_of lit.probe >lights
check "the header has it" says lights '^sun-1 ' '^point-2 ' '^sky 0\{0,1\}.5,0\{0,1\}.6,0\{0,1\}.8'
probe-capture -q --again --rays 32 "$scene" lit.probe >again.probe
light_of again.probe >got
check "--again has the light of the first run" diff lights got
probe-capture -q --rays 32 $lights "$scene" dozen.probe >fresh.probe
for run in fresh again; do
    probe-cat --text --no-provenance $run.probe | sort >$run.sorted
done
check "and captures as a first run with it does" \
    cmp again.sorted fresh.sorted and test -s fresh.sorted
check "the same lights on the command line are the same light" \
    into same.probe probe-capture -q $lights "$scene" lit.probe
refused 1 "other light in it" probe-capture -q --sun 0,-1,0,1,1,1 "$scene" lit.probe
probe-capture -q --again --sun 0,-1,0,1,1,1 "$scene" lit.probe >other.probe
light_of other.probe >got
check "another sun takes the place of sun and point, the sky stays" \
    says got '^sun-1 0,-1,0,1,1,1$' "^$(grep '^sky ' lights)$" and lacks got '^point'
probe-capture -q --again --sky 0,0,0 "$scene" lit.probe >other.probe
light_of other.probe >got
grep '^sun-1 \|^point-2 ' lights >wanted
grep '^sun-1 \|^point-2 ' got >kept
check "no sky leaves the other lights" \
    says got '^sky 0,0,0$' and cmp kept wanted and has_lines 2 wanted

# -- a point light beside what emits ---------------------------------------------------------------
# A surface has I cos / d^2 of a point light, and a small lamp next to nothing.
printf '%s\n' 'newmtl black' 'Kd 0 0 0' 'newmtl lamp' 'Kd 0 0 0' 'Ke .001 .001 .001' >two.mtl
printf '%s\n' 'mtllib two.mtl' 'usemtl black' 'v -9 0 -9' 'v -9 0 9' 'v 9 0 9' 'v 9 0 -9' \
    'f 1 2 3 4' 'v 5 5 0' 'v 5.1 5 0' 'v 5 5 .1' 'usemtl lamp' 'f 5 6 7' >two.obj
probe-place vertices -q two.obj | probe-cat -q --rows 0 |
    probe-capture -q --point 0,3,0,10,10,10 --rays 256 two.obj >two.probe
rows_of position,irradiance two.probe >two.rows
check "a surface has a point light once, though something emits" every 'NF == 6 &&
    near($4, 10 * (3 - $2) / (162 + (3 - $2) ^ 2) ^ 1.5, 1e-6)' two.rows
tap_done
