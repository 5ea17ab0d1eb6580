#!/bin/sh
# probe-error as users run it: its figures where they are known, the truth that is kept, what is refused.
. "${SRC:?}/tests/support/setup.sh"
rooms=$SRC/scenes/two-rooms.obj

# figure MEASURE OF FILE: a figure of a --tsv report.
figure() {
    awk -F '\t' -v measure="$1" -v of="$2" '$1 == measure && $2 == of { print $3 }' "$3"
}

# holds NAME AWK-CONDITION A B ...: a condition on numbers $1, $2, ...
holds() {
    holds_name=$1
    holds_condition=$2
    shift 2
    if echo "$@" | awk "{ exit !($holds_condition) }"; then pass "$holds_name"; else fail "$holds_name" "$holds_condition: $*"; fi
}

# -- a sky alone: linear, so what the probes blend is right everywhere; what is left is their noise --------------------
printf 'v 0 0 0\nv 0.001 0 0\nv 0 0.001 0\nf 1 2 3\n' >speck.obj
probe-place grid --spacing 1 --bounds -2,-2,-2,2,2,2 | probe-capture -q --sky 1,2,3 --rays 4096 speck.obj | probe-tet >sky.probe
probe-error -q --tsv --points 200 --truth-rays 1024 --bounds -2,-2,-2,2,2,2 --truth sky.truth speck.obj sky.probe >sky
holds "under a sky alone there is no error but noise" '$1 < 0.002 && $2 > 3.14159 * 1.85 * 0.99 && $2 < 3.14159 * 1.93 * 1.01' \
    "$(figure rms_relative all sky)" "$(figure irradiance all sky)"
holds "no probe is unseen, inside of the hull or out of it" '$1 == 0 && $2 == 0 && $3 > 0 && $4 > 0' "$(figure leak_volume all sky)" \
    "$(figure unseen all sky)" "$(figure points inside-hull sky)" "$(figure points outside-hull sky)"
holds "and light does not change along paths, but for the truth's noise" '$1 < 0.01 && $2 < $3' "$(figure change_rms_relative probes sky)" \
    "$(figure change_rms truth sky)" "$(figure change_noise truth sky)"

# -- an offset that is put in comes out --------------------------------------------------------------------------------
probe-place grid -q --count 300 "$rooms" | probe-capture -q --rays 64 --bounces 8 "$rooms" | probe-tet >cells.probe
run="probe-error -q --tsv --points 150 --paths 2 --truth-rays 128"
$run --truth rooms.truth "$rooms" cells.probe >cells
probe-cat --text cells.probe | awk '/^table probe/ { n = split($0, name, " "); at = 1
        for (i = 3; i <= n; i++) { split(name[i], part, ":"); if (part[1] == "sh") sh = at; at += part[3] } in_probe = 1; print; next }
    /^table|^end/ { in_probe = 0 }
    in_probe { for (k = 0; k < 3; k++) $(sh + k) += 0.5 } { print }' >offset.probe
$run --truth rooms.truth "$rooms" offset.probe >offset
holds "half a unit more L00 is 0.5 pi Y00 more bias" '($2 - $1 - 0.5 * 3.14159265 * 0.28209479) ^ 2 < 1e-9' \
    "$(figure bias all cells)" "$(figure bias all offset)"
holds "its square and what goes with it, more mean square" '($2 ^ 2 - $1 ^ 2 - $4 ^ 2 - 2 * $4 * $3) ^ 2 < 1e-9 * $1 ^ 4' \
    "$(figure rms all cells)" "$(figure rms all offset)" "$(figure bias all cells)" 0.44311346
holds "and leaks neither more weight nor other light" '$1 == $2 && $1 > 0 && ($3 - $4) ^ 2 < 1e-10' "$(figure leak_volume all cells)" \
    "$(figure leak_volume all offset)" "$(figure leaked_rms all cells)" "$(figure leaked_rms all offset)"

probe-cat --content irradiance cells.probe >convolved.probe
$run --truth rooms.truth "$rooms" convolved.probe >convolved
holds "a stream of irradiance is what its radiance is" '($1 - $2) ^ 2 < 1e-10 && ($3 - $4) ^ 2 < 1e-10 && ($5 - $6) ^ 2 < 1e-10' "$(figure rms all cells)" \
    "$(figure rms all convolved)" "$(figure leaked_rms all cells)" "$(figure leaked_rms all convolved)" "$(figure capture_noise all cells)" \
    "$(figure capture_noise all convolved)"

# -- the truth's noise: less with more rays, and the rms error stays -----------------------------------------------------
probe-cat --text --no-provenance --tables probe --columns position rooms.truth | grep '^[0-9-]' | head -n 150 >points.txt
many="probe-error -q --tsv --at points.txt --paths 0 --leak-samples 0 $rooms cells.probe"
$many --seed 7 --truth-rays 64 >few
$many --seed 8 --truth-rays 2048 >lots
holds "32 times the rays: noise falls by more than 4" '$1 > 4 * $2 && $2 > 0' "$(figure noise all few)" "$(figure noise all lots)"
for part in all inside-hull lit; do
    holds "and the rms error ($part) stays within what its noise leaves" '($1 - $2) ^ 2 < 3.3 ^ 2 * ($3 ^ 2 + $4 ^ 2)' "$(figure rms $part few)" \
        "$(figure rms $part lots)" "$(figure rms_noise $part few)" "$(figure rms_noise $part lots)"
done

# -- leakfix is seen ---------------------------------------------------------------------------------------------------
probe-leakfix -q "$rooms" cells.probe >fixed.probe
$run --truth rooms.truth "$rooms" fixed.probe >fixed
holds "leakfix leaves less unseen weight, and less light leaks" '$2 < $1 / 3 && $4 < $3 / 2' "$(figure leak_volume all cells)" \
    "$(figure leak_volume all fixed)" "$(figure leaked_rms all cells)" "$(figure leaked_rms all fixed)"
$run --truth rooms.truth --leak-samples 64 "$rooms" cells.probe >finely
holds "more points of each cell say the same, more exactly" '($1 - $2) ^ 2 < 4 * ($3 - $1) ^ 2 && $4 - $2 < ($3 - $1) / 2' "$(figure leak_volume all cells)" \
    "$(figure leak_volume all finely)" "$(awk -F '\t' '$1 == "leak_volume" { print $5 }' cells)" "$(awk -F '\t' '$1 == "leak_volume" { print $5 }' finely)"

# -- the stream that comes out -------------------------------------------------------------------------------------------
$run --truth rooms.truth -o marked.probe "$rooms" cells.probe >again
check "with -o the report is the same" cmp cells again
check "the stream is as it was, but for its cells' columns" sh -c "probe-cat --drop leak,leak_light,leak_free --text --no-provenance marked.probe >a &&
    probe-cat --text --no-provenance cells.probe | cmp - a"
volumes=$(probe-cat --text --no-provenance --columns position,leak,leak_free marked.probe | sed '1,/^table tet/d; /^end/d' | awk '{ n++; most = $1 > most ? $1 : most; free += $2 } END { print n, most, free / n }')
holds "they hold each cell's share" '$1 == $4 && ($2 - $5) ^ 2 < 1e-10 && $3 > 0.9 && $3 <= 1' "$volumes" "$(figure cells all cells)" "$(figure leak_worst all cells)"
if command -v probe-vtk >/dev/null; then
    check "and probe-vtk writes them" sh -c "probe-vtk -q -o marked.vtu marked.probe && grep -aq 'leak_light' marked.vtu"
else
    skip "probe-vtk is not built"
fi
probe-error -q --points 20 --truth-rays 16 --tsv -o - --text "$rooms" cells.probe >marked.txt 2>report
check "-o - puts the stream on standard output and the report on standard error" sh -c "probe-cat --info marked.txt | grep -q leak_light && grep -q '^rms	all' report"

$run --truth rooms.truth --map map.probe --text "$rooms" cells.probe >mapped
sed '1,/^table probe/d; /^end/d' map.probe | awk '{ n++; s += $4 ^ 2; b += $5; t += $6; u += $7; o += $9 } END { print n, sqrt(s / n), b / n, t / n, u / n, o }' >map
# Noise leaves some squares below 0, which a root cannot show: the map's rms is a little larger.
holds "--map has the error at each point" '$1 == 150 && $2 >= $7 && $2 < 1.1 * $7 && ($3 - $8) ^ 2 < 1e-10 && ($4 - $9) ^ 2 < 1e-10 && ($5 - $10) ^ 2 < 1e-10 && $6 == $11' \
    "$(cat map)" "$(figure rms all cells)" "$(figure bias all cells)" "$(figure irradiance all cells)" "$(figure unseen all cells)" "$(figure points outside-hull cells)"
check "and does not change the report" cmp mapped cells

# -- determinism -----------------------------------------------------------------------------------------------------------
for threads in 1 2 4; do
    $run --threads $threads --truth t$threads.truth -o t$threads.probe "$rooms" cells.probe >t$threads
done
check "1, 2 and 4 threads: the same report, truth and stream" sh -c "for f in 2 4; do cmp t1 t\$f && cmp t1.truth t\$f.truth && cmp t1.probe t\$f.probe || exit 1; done"
GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-AVX512F $run --truth plain.truth -o plain.probe "$rooms" cells.probe >plain
check "the same bytes without AVX2 and FMA in libc" sh -c "cmp t1 plain && cmp t1.truth plain.truth && cmp t1.probe plain.probe"
check "a kept truth says what a new one says" cmp t1 cells
check "the truth is a probe stream like others" sh -c "probe-cat --info rooms.truth | grep -q 'table probe' && probe-cat --text rooms.truth | grep -q '^# probe-error .*two-rooms.obj'"
probe-cat --text --no-provenance --tables probe --columns position cells.probe | grep '^[0-9-]' >places.txt
probe-error -q --tsv --at places.txt --paths 0 --truth-rays 512 "$rooms" cells.probe >there
probe-place points places.txt | probe-capture -q --rays 2048 --bounces 8 "$rooms" | probe-tet >quiet.probe
probe-error -q --tsv --at places.txt --paths 0 --truth-rays 512 "$rooms" quiet.probe >quiet
holds "at the probes' own places there is the capture's noise alone: less with more rays" '$2 < $1 / 2 && $3 == 0' "$(figure rms all there)" \
    "$(figure rms all quiet)" "$(figure unseen all quiet)"
printf '1 1 1\n1 1 3\n7 1 3\n' >way.txt
probe-error -q --tsv --points 10 --truth-rays 16 --path way.txt --step 0.25 "$rooms" cells.probe >way
holds "change along a given path, in steps no longer than asked for" '$1 == 1 && $2 == 8 + 24 && $3 == 0.25' "$(figure paths all way)" \
    "$(figure change_steps all way)" "$(figure step all way)"

# -- what is measured is what probe-query answers -----------------------------------------------------------------------
probe-place grid -q --spacing 1.2 "$rooms" | probe-capture -q --rays 64 --bounces 8 --columns sh_gradient "$rooms" | probe-tet >sloped.probe
probe-error -q --tsv --paths 0 --points 60 --truth-rays 16 --leak-samples 0 --truth way.truth "$rooms" sloped.probe >barycentric
for how in "barycentric" "barycentric --outside extend" gradient cubic "nearest" "shepard --radius 2 --falloff cubic"; do
    # shellcheck disable=SC2086 # $how is options
    probe-error -q --paths 0 --leak-samples 0 --truth way.truth --map how.probe --text --interpolate $how "$rooms" sloped.probe >/dev/null
    sed '1,/^table probe/d; /^end/d' how.probe >how.map
    # shellcheck disable=SC2086
    cut -d ' ' -f 1-3 how.map | probe-query -q --interpolate $how sloped.probe - | paste -d ' ' how.map - |
        awk '{ e = 3.14159265358979 * 0.28209479177388 * (0.2126 * $10 + 0.7152 * $11 + 0.0722 * $12) - $5 - $6; off = e * e > off ? e * e : off; n++ } END { print n, off }' >how.off
    holds "$how: the light that is measured is probe-query's" '$1 == 60 && $2 < 1e-10' "$(cat how.off)"
    cksum <how.map >>how.sums
done
check "each way is another" sh -c "[ \$(sort -u how.sums | wc -l) -eq 6 ]"
probe-cat --tables probe sloped.probe >loose.probe
check "nearest needs no cells, and says what it cannot know" sh -c "probe-error --tsv --truth way.truth --interpolate nearest '$rooms' loose.probe >loose 2>err &&
    grep -q '^rms	all' loose && ! grep -q '^unseen\|^leak' loose && grep -q 'tetrahedra alone, and there are no cells' err"
refused 1 "run probe-tet" probe-error -q --truth way.truth "$rooms" loose.probe
refused 1 "--columns sh_gradient" probe-error -q --interpolate cubic --truth rooms.truth "$rooms" cells.probe
refused 2 "need --interpolate shepard" probe-error -q --radius 1 "$rooms" cells.probe

# -- probes in a plane, on a line, in one place --------------------------------------------------------------------------
awk 'BEGIN { for (x = 0.5; x < 5; x++) for (z = 0.5; z < 4; z++) print x, 1.5, z }' >plane.txt
grep ' 0.5$' plane.txt >line.txt
head -n 1 line.txt >one.txt
for flat in "plane triangles" "line segments" "one point"; do
    file=${flat% *}
    probe-place points $file.txt | probe-capture -q --rays 64 --bounces 8 "$rooms" | probe-tet -q >$file.probe
    probe-error --tsv --truth way.truth "$rooms" $file.probe >$file 2>err
    holds "$file: its error is measured" '$1 > 0 && $1 < 10 && $2 >= 0 && $2 <= 1' "$(figure rms_relative all $file)" "$(figure unseen all $file)"
    check "$file: leaks of tetrahedra alone, and that is said" sh -c "! grep -q '^leak' $file && grep -q 'leaks are measured of tetrahedra alone.*${flat#* }' err"
    refused 1 "--output marks where tetrahedra leak" probe-error -q --truth way.truth -o x.probe "$rooms" $file.probe
done

# -- forms of the report ------------------------------------------------------------------------------------------------
probe-error -q --points 150 --paths 2 --truth rooms.truth "$rooms" cells.probe >table
check "the table names each part and each measure" sh -c "for w in inside-hull outside-hull 'surface .* \.\. ' lit dark unseen 'share of weight' 'change of light' 'worst at'; do grep -q -- \"\$w\" table || exit 1; done"
probe-error -q --json --points 150 --paths 2 --truth rooms.truth "$rooms" cells.probe >json
if command -v python3 >/dev/null; then
    check "JSON has what TSV has" python3 -c "
import json
lines = [l.rstrip('\n').split('\t') for l in open('cells')][1:]
rows = json.load(open('json'))
same = lambda text, value: value is None if text == 'nan' else float(text) == value
assert len(lines) == len(rows)
assert all(l[0] == r['measure'] and l[1] == r['of'] and same(l[2], r['value']) and same(l[3], r['low']) and same(l[4], r['high']) for l, r in zip(lines, rows))"
else
    skip "no python3 to read JSON with"
fi
check "--quiet says nothing, else it says where the time went" sh -c "[ -z \"\$($run --truth rooms.truth '$rooms' cells.probe 2>&1 >/dev/null)\" ] &&
    probe-error --truth rooms.truth --points 150 --paths 2 '$rooms' cells.probe 2>&1 >/dev/null | grep -q 'truth .* s, error .* s, leaks'"
check "it reads a pipe" sh -c "$run --truth rooms.truth '$rooms' <cells.probe | cmp - cells"

# -- what is refused -------------------------------------------------------------------------------------------------------
refused 1 "this is not the scene that the probes were captured in" $run "$SRC/scenes/cornell-box.obj" cells.probe
check "--any-scene measures against another scene" sh -c "$run --any-scene '$SRC/scenes/cornell-box.obj' cells.probe | grep -q '^rms'"
refused 1 "this truth is of another scene" $run --bounds -2,-2,-2,2,2,2 --truth rooms.truth speck.obj sky.probe
refused 1 "truth-points 150, not 151" probe-error -q --points 151 --truth rooms.truth "$rooms" cells.probe
refused 1 "truth-seed 0, not 1" probe-error -q --seed 1 --truth rooms.truth "$rooms" cells.probe
refused 1 "truth-rays 128, not 256" probe-error -q --truth-rays 256 --truth rooms.truth "$rooms" cells.probe
refused 1 "truth-bounces 8, not 3" probe-error -q --bounces 3 --truth rooms.truth "$rooms" cells.probe
head -n 3 points.txt >three.txt
probe-error -q --at three.txt --paths 0 --truth-rays 16 --truth three.truth "$rooms" cells.probe >/dev/null
check "a truth of given points serves those points" probe-error -q --at three.txt --truth three.truth "$rooms" cells.probe
head -n 2 points.txt >two.txt
refused 1 "not at the points of two.txt" probe-error -q --at two.txt --truth three.truth "$rooms" cells.probe
refused 1 "not a truth that probe-error made" probe-error -q --truth cells.probe "$rooms" cells.probe
head -c 2000 rooms.truth >cut.truth
refused 1 "cut.truth" $run --truth cut.truth "$rooms" cells.probe
refused 1 "run probe-tet" sh -c "probe-place grid -q --count 20 '$rooms' | probe-capture -q --rays 4 '$rooms' | probe-error -q '$rooms'"
refused 1 "run probe-capture" sh -c "probe-place grid -q --count 20 '$rooms' | probe-tet | probe-error -q '$rooms'"
probe-tet --enclose cells.probe >corners.probe
refused 1 "has no light: run probe-capture" $run --truth rooms.truth "$rooms" corners.probe
: >none.txt
refused 1 "expected at least one point, got none" probe-error -q --at none.txt "$rooms" cells.probe
refused 1 "x y z" sh -c "echo 1 2 3 4 5 6 >six.txt; probe-error -q --at six.txt '$rooms' cells.probe"
refused 1 "in free space" probe-error -q --bounds 4.005,0.5,0.5,4.015,2,0.9 "$rooms" cells.probe
refused 1 "too far out" sh -c "echo 1e300 0 0 >far.txt; probe-error -q --paths 0 --at far.txt '$rooms' cells.probe"
refused 1 "No space left" sh -c "$run --truth rooms.truth '$rooms' cells.probe >/dev/full"
check "no truth is left behind by what failed" sh -c "! probe-error -q --truth far.truth --at far.txt --paths 0 '$rooms' cells.probe 2>/dev/null && [ ! -e far.truth ]"
refused 2 "only one of the stream, --at and --path" probe-error --at - "$rooms"
refused 2 "--points and --at" probe-error --points 3 --at points.txt "$rooms" cells.probe
refused 2 "--paths and --path" probe-error --paths 3 --path points.txt "$rooms" cells.probe
refused 2 "--leak-samples" probe-error --leak-samples 1 "$rooms" cells.probe
refused 2 "--output needs" probe-error --leak-samples 0 -o x "$rooms" cells.probe
refused 2 "--bounds" probe-error --bounds 1,1,1,0,0,0 "$rooms" cells.probe
refused 2 "SCENE" probe-error
tap_done
