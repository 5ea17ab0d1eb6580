#!/bin/sh
# probe-capture as users run it.
. "${SRC:?}/tests/support/setup.sh"
scene=$SRC/scenes/cornell-box.obj
probe-place grid -q --count 40 "$scene" >placed.probe

capture() { probe-capture --rays 32 --bounces 3 "$@"; }

check "probes get light, error, validity, depth and sky" sh -c "probe-capture --rays 32 '$scene' placed.probe >a.probe &&
    probe-cat --info a.probe | grep -cE '^  (sh|sh_error|validity|depth|sky) ' | grep -qx 5"
capture "$scene" placed.probe >a.probe
capture "$scene" <placed.probe >b.probe
check "a file and standard input are the same" cmp a.probe b.probe
for threads in 1 2 4; do capture --threads $threads "$scene" placed.probe >t$threads.probe; done
check "1, 2 and 4 threads give the same bytes" sh -c "cmp t1.probe t2.probe && cmp t1.probe t4.probe"
GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-AVX512F capture --columns sh_error,sh_gradient "$scene" placed.probe >plain.probe
capture --columns sh_error,sh_gradient "$scene" placed.probe >fast.probe
check "libm's faster instructions change nothing" cmp plain.probe fast.probe
capture --seed 1 "$scene" placed.probe >seed.probe
check "another seed gives other light" sh -c "! cmp -s a.probe seed.probe"
capture --order 1 --columns none --text "$scene" placed.probe >small.probe
check "order 1 and no columns leave sh of 3 alone" grep -qx 'table probe position:f64:3 sh:f32:3' small.probe

# Slices give what the whole gives.
probe-cat --rows 0:10 placed.probe | capture "$scene" >s1.probe
probe-cat --rows 10: placed.probe | capture "$scene" >s2.probe
probe-cat --no-provenance s1.probe s2.probe >slices.probe
probe-cat --no-provenance --text slices.probe | grep '^[0-9-]' >slices.txt
probe-cat --no-provenance --text a.probe | grep '^[0-9-]' >whole.txt
check "slices, merged, are the whole" cmp slices.txt whole.txt

# A second pass captures what is missing as the others were.
capture --light indirect --order 2 "$scene" placed.probe | probe-tet --enclose >enclosed.probe
check "a second pass takes the settings over" sh -c "probe-capture -q '$scene' enclosed.probe >second.probe &&
    probe-cat --info second.probe | grep -q 'key capture-light indirect' && ! probe-cat --text second.probe | grep -q nan"
check "and leaves what was captured" sh -c "probe-cat --text --no-provenance --tables probe --columns position,sh enclosed.probe | grep '^[0-9-]' | grep -v nan >before.txt
    probe-cat --text --no-provenance --tables probe --columns position,sh second.probe | grep '^[0-9-]' | head -n \$(wc -l <before.txt) | cmp - before.txt"
refused 1 "captured with capture-rays 32, not 64" probe-capture --rays 64 "$scene" a.probe
refused 1 "another scene" probe-capture "$SRC/scenes/two-rooms.obj" a.probe
refused 1 "another scene" probe-capture --sky 1,1,1 "$scene" a.probe
check "--again captures all anew" sh -c "probe-capture --again --rays 64 '$scene' a.probe | probe-cat --info | grep -q 'key capture-rays 64'"
check "direct and indirect are accepted" capture --light direct "$scene" placed.probe

# A scene of fewer triangles: the header knows it, and the scene by its whole. A tenth of the Cornell box is nothing.
capture --decimate .5 "$scene" placed.probe >half.probe
check "--decimate is kept, with the key of the whole scene" sh -c "probe-cat --info half.probe | grep -qx 'key capture-decimate 0.5' &&
    probe-cat --info half.probe | grep '^key scene-key' >x && probe-cat --info a.probe | grep '^key scene-key' | cmp - x"
check "and gives other light" sh -c "! probe-cat --text half.probe | grep '^[0-9-]' | cmp -s - whole.txt"
capture --decimate 1 "$scene" placed.probe >one.probe
check "--decimate 1 is the whole scene" sh -c "probe-cat --no-provenance a.probe >x && probe-cat --no-provenance one.probe | cmp - x"
check "a second pass decimates alike" sh -c "probe-cat --rows 0:10 half.probe >x && probe-cat --rows 10: placed.probe >y && probe-cat x y |
    probe-capture -q '$scene' | probe-cat --no-provenance --text | grep '^[0-9-]' >z &&
    probe-cat --no-provenance --text half.probe | grep '^[0-9-]' | cmp - z"
refused 1 "captured with capture-decimate 0.5, not none" probe-capture --decimate 1 "$scene" half.probe
refused 1 "captured with capture-decimate none, not 0.5" probe-capture --decimate .5 "$scene" a.probe
check "what cannot go is said" sh -c "probe-capture --rays 32 --decimate .01 '$scene' placed.probe 2>&1 >x | grep -q 'of 32 triangles are left'"
sed 's/^capture-decimate 0.5/capture-decimate 2/' half.probe >bad.probe
refused 1 "header key capture-decimate: expected a share above 0 and at most 1, got '2'" probe-capture "$scene" bad.probe
refused 2 "--decimate" probe-capture --decimate 0 "$scene" placed.probe
refused 2 "--decimate" probe-capture --decimate 1.01 "$scene" placed.probe

# Rays by error, orders by what irradiance needs, columns on request, surfaces.
check "every probe as exactly as is asked" sh -c "probe-capture -e 0.1 --emit front --columns sh_error,rays --text '$scene' placed.probe >error.probe &&
    grep -q '^capture-error 0.1' error.probe && probe-cat --where 'rays[0]>200' error.probe | probe-cat --info | grep -q 'table probe: [1-9]'"
check "such a stream goes on as it began" sh -c "probe-tet --enclose error.probe | probe-capture -q '$scene' | probe-cat --info | grep -q 'key capture-error 0.1'"
refused 1 "captured with capture-error 0.1, not 0.2" probe-capture -e 0.2 "$scene" error.probe
check "--order auto says what it keeps" sh -c "probe-capture --rays 64 --order auto --order-loss 0.05 '$scene' placed.probe 2>err >auto.probe &&
    grep -q 'order [1-5] loses 0.0' err && order=\$(sed -n 's/.*order \([1-5]\) loses.*/\1/p' err) && probe-cat --info auto.probe | grep -q \"key sh-order \$order\""
probe-capture --rays 64 --order "$(probe-cat --info auto.probe | sed -n 's/^key sh-order //p')" "$scene" placed.probe >same.probe
check "and it is what that order gives" sh -c "probe-cat --no-provenance auto.probe >x && probe-cat --no-provenance same.probe | cmp - x"
check "--columns writes what was asked for" sh -c "capture() { probe-capture --rays 32 \"\$@\"; }
    capture --columns sh_gradient,visibility,ao,rays --text '$scene' placed.probe |
    grep -qx 'table probe position:f64:3 sh:f32:27 sh_gradient:f32:81 visibility:f32:9 ao:f32:1 rays:i32:1'"
{ printf '#?probe 1\ntable probe position:f64:3 normal:f32:3\n'; printf '%s\n' "2.7 0.001 2.7 0 1 0" "2.7 5.4 2.7 0 -1 0"; echo end; } >surface.probe
check "surfaces get irradiance" sh -c "probe-capture --columns irradiance_error,ao,bent_normal --text '$scene' surface.probe |
    grep -qx 'table probe position:f64:3 normal:f32:3 irradiance:f32:3 irradiance_error:f32:3 ao:f32:1 bent_normal:f32:3'"
refused 1 "bent_normal is known of probes with a normal alone" probe-capture --columns bent_normal "$scene" placed.probe
refused 1 "sh_gradient is known of probes without a normal alone" probe-capture --columns sh_gradient "$scene" surface.probe
sed 's/0 1 0$/0 0 0/' surface.probe >flat.probe
refused 1 "probe 0: expected a normal, got (0, 0, 0)" probe-capture "$scene" flat.probe
refused 1 "beyond what 32 bits can hold" probe-capture --point 250,250,250,1e100,1,1 "$scene" placed.probe
refused 2 "--error" probe-capture --error 0 "$scene" placed.probe
refused 2 "--ao-distance" probe-capture --ao-distance -1 "$scene" placed.probe
refused 2 "auto" probe-capture --order most "$scene" placed.probe

# Work starts before the input ends: the end comes when there is light.
mkfifo pipe
probe-place grid -q --text --count 2500 --inside keep "$scene" >many.probe
capture --text --rays 4 "$scene" pipe >streamed.probe &
{ sed '/^end/d' many.probe; wait_for grep -q '^[0-9-]' streamed.probe && echo end; } >pipe
wait
check "a stream passes while it comes" grep -q '^end' streamed.probe

printf 'v 0 -1 0\nv 1 -1 0\nv 0 -1 1\nf 1 2 3\n' >dark.obj
capture dark.obj placed.probe 2>err >dark.probe
check "no light at all is legal, and said" grep -q 'warning: .*no light' err
: >nothing.obj
capture --sky 1,1,1 nothing.obj placed.probe 2>err >sky.probe
check "no scene at all is legal, and said" grep -q 'warning: .*empty' err
refused 1 "stdin: expected a probe stream, got nothing" sh -c "probe-capture '$scene' </dev/null"
head -c 300 placed.probe >cut.probe
refused 1 "cut.probe" probe-capture "$scene" cut.probe
refused 1 "No such file" probe-capture none.obj placed.probe
refused 1 "No space left" sh -c "probe-capture --rays 4 '$scene' placed.probe >/dev/full"
refused 2 "--order: expected a whole number from 1 to 6, or auto, got '7'" probe-capture --order 7 "$scene"
refused 2 "--rays" probe-capture --rays 0 "$scene"
refused 2 "--sky" probe-capture --sky 1,2 "$scene"
refused 2 "--sun" probe-capture --sun 0,0,0,1,1,1 "$scene"
refused 2 "expected some of sh_error" probe-capture --columns sh,foo "$scene"
refused 2 "SCENE" probe-capture
# -- the light of the first run --------------------------------------------------------------------
lights='--sky .5,.6,.8 --sun .2,-1,.3,10,9,8 --point 1,2,1,5,5,5 --emit front --albedo-scale .5'
probe-place grid -q --count 12 "$scene" | probe-capture -q --rays 16 $lights "$scene" >lit.probe
light_of() { # light_of FILE: keys of its light
    probe-cat --text "$1" | grep -E '^(sky|sky-file|sun-|point-|spot-|emit|albedo-scale|max-albedo|light-scale|scene-key)' | sort
}
light_of lit.probe >lights
check "the header has it" sh -c "grep -q '^sun-1 ' lights && grep -q '^point-2 ' lights && grep -q '^sky .5,.6,.8\|^sky 0.5,0.6,0.8' lights"
probe-capture -q --again --rays 32 "$scene" lit.probe >again.probe
light_of again.probe >got
check "--again has the light of the first run" diff lights got
probe-place grid -q --count 12 "$scene" | probe-capture -q --rays 32 $lights "$scene" | probe-cat --text --no-provenance | sort >fresh.text
check "and captures as a first run with it does" sh -c "probe-cat --text --no-provenance again.probe | sort | cmp - fresh.text"
check "the same lights on the command line are the same light" sh -c "probe-capture -q $lights '$scene' lit.probe >same.probe"
refused 1 "other light in it" probe-capture -q --sun 0,-1,0,1,1,1 "$scene" lit.probe
probe-capture -q --again --sun 0,-1,0,1,1,1 "$scene" lit.probe >other.probe
light_of other.probe >got
check "another sun takes the place of sun and point, the sky stays" sh -c "grep -qx 'sun-1 0,-1,0,1,1,1' got && ! grep -q '^point' got && grep '^sky ' lights | grep -qxf - got"
probe-capture -q --again --sky 0,0,0 "$scene" lit.probe >other.probe
light_of other.probe >got
check "no sky leaves the other lights" sh -c "grep -qx 'sky 0,0,0' got && grep '^sun-1 \|^point-2 ' lights >wanted && grep '^sun-1 \|^point-2 ' got | cmp - wanted"
tap_done
