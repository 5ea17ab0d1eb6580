#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-error as users run it: its figures where they are known, the truth that is kept, what is
# refused.
. "${SRC:?}/tests/support/setup.sh"
rooms=$SRC/scenes/two-rooms.obj

# figure MEASURE OF FILE [COLUMN]: a figure of a --tsv report, or its low (4) or high (5)
figure() {
    awk -F '\t' -v measure="$1" -v of="$2" -v column="${4-3}" \
        '$1 == measure && $2 == of { print $column }' "$3"
}

# figures OF FILE MEASURE...: figures of one part
figures() {
    figures_of=$1 figures_file=$2
    shift 2
    for measure; do figure "$measure" "$figures_of" "$figures_file"; done
}

# holds NAME AWK-CONDITION A B ...: a condition on numbers $1, $2, ...
holds() {
    holds_name=$1
    holds_condition=$2
    shift 2
    echo "$@" >holds.numbers
    check "$holds_name" every "$holds_condition" holds.numbers
}

# -- a sky alone -----------------------------------------------------------------------------------
# It is linear, so what the probes blend is right everywhere; what is left is their noise.
printf 'v 0 0 0\nv 0.001 0 0\nv 0 0.001 0\nf 1 2 3\n' >speck.obj
around=-2,-2,-2,2,2,2
probe-place grid --spacing 1 --clearance 50% --bounds $around |
    probe-capture -q --sky 1,2,3 --rays 4096 speck.obj | probe-tet >sky.probe
probe-error -q --tsv --points 200 --truth-rays 1024 --bounds $around --truth sky.truth \
    speck.obj sky.probe >sky
holds "under a sky alone there is no error but noise" \
    '$1 < 0.002 && $2 > 3.14159 * 1.85 * 0.99 && $2 < 3.14159 * 1.93 * 1.01' \
    $(figures all sky rms_relative irradiance)
holds "no probe is unseen, inside of the hull or out of it" \
    '$1 == 0 && $2 == 0 && $3 > 0 && $4 > 0' $(figures all sky leak_volume unseen) \
    $(figure points inside-hull sky) $(figure points outside-hull sky)
holds "and light does not change along paths, but for the truth's noise" '$1 < 0.01 && $2 < $3' \
    $(figure change_rms_relative probes sky) $(figures truth sky change_rms change_noise)

# -- an offset that is put in comes out ------------------------------------------------------------
probe-place grid -q --count 300 "$rooms" | probe-capture -q --rays 64 --bounces 8 "$rooms" |
    probe-tet >cells.probe
run="probe-error -q --tsv --points 150 --paths 2 --truth-rays 128"
# measure STREAM [OPTION...]: against the truth of these rooms
measure() {
    measure_stream=$1
    shift
    $run --truth rooms.truth "$@" "$rooms" "$measure_stream"
}
measure cells.probe >cells
cat >offset.awk <<'AWK'
/^table probe/ {
    n = split($0, name, " ")
    at = 1
    for (i = 3; i <= n; i++) {
        split(name[i], part, ":")
        if (part[1] == "sh") sh = at
        at += part[3]
    }
    in_probe = 1
    print
    next
}
/^table|^end/ { in_probe = 0 }
in_probe { for (k = 0; k < 3; k++) $(sh + k) += 0.5 }
{ print }
AWK
probe-cat --text cells.probe | awk -f offset.awk >offset.probe
measure offset.probe >offset
holds "half a unit more L00 is 0.5 pi Y00 more bias" \
    '($2 - $1 - 0.5 * 3.14159265 * 0.28209479) ^ 2 < 1e-9' \
    $(figure bias all cells) $(figure bias all offset)
holds "its square and what goes with it, more mean square" \
    '($2 ^ 2 - $1 ^ 2 - $4 ^ 2 - 2 * $4 * $3) ^ 2 < 1e-9 * $1 ^ 4' \
    $(figure rms all cells) $(figure rms all offset) $(figure bias all cells) 0.44311346
holds "and leaks neither more weight nor other light" \
    '$1 == $3 && $1 > 0 && ($2 - $4) ^ 2 < 1e-10' \
    $(figures all cells leak_volume leaked_rms) $(figures all offset leak_volume leaked_rms)

probe-cat --content irradiance cells.probe >convolved.probe
measure convolved.probe >convolved
holds "a stream of irradiance is what its radiance is" \
    '($1 - $4) ^ 2 < 1e-10 && ($2 - $5) ^ 2 < 1e-10 && ($3 - $6) ^ 2 < 1e-10' \
    $(figures all cells rms leaked_rms capture_noise) \
    $(figures all convolved rms leaked_rms capture_noise)

# -- the truth's noise: less with more rays, and the rms error stays -------------------------------
# positions STREAM: of its probes
positions() {
    probe-cat --text --no-provenance --tables probe --columns position "$1" | numbers
}
positions rooms.truth | head -n 150 >points.txt
many="probe-error -q --tsv --at points.txt --paths 0 --leak-samples 0 $rooms cells.probe"
$many --seed 7 --truth-rays 64 >few
$many --seed 8 --truth-rays 2048 >lots
holds "32 times the rays: noise falls by more than 4" '$1 > 4 * $2 && $2 > 0' \
    $(figure noise all few) $(figure noise all lots)
for part in all inside-hull lit; do
    holds "and the rms error ($part) stays within what its noise leaves" \
        '($1 - $3) ^ 2 < 3.3 ^ 2 * ($2 ^ 2 + $4 ^ 2)' \
        $(figures $part few rms rms_noise) $(figures $part lots rms rms_noise)
done

# -- leakfix is seen -------------------------------------------------------------------------------
if plain_build "what leakfix mends"; then
    probe-leakfix -q --rounds 4 "$rooms" cells.probe >fixed.probe
    measure fixed.probe >fixed
    holds "leakfix leaves less unseen weight, and less light leaks" '$3 < $1 / 3 && $4 < $2 / 2' \
        $(figures all cells leak_volume leaked_rms) $(figures all fixed leak_volume leaked_rms)
fi
measure cells.probe --leak-samples 64 >finely
holds "more points of each cell say the same, more exactly" \
    '($1 - $2) ^ 2 < 4 * ($3 - $1) ^ 2 && $4 - $2 < ($3 - $1) / 2' \
    $(figure leak_volume all cells) $(figure leak_volume all finely) \
    $(figure leak_volume all cells 5) $(figure leak_volume all finely 5)

# -- the error that a player sees, and that of the probes that are seen ----------------------------
holds "error is a share, within its interval; so are bad points, and what is seen is nearer" \
    '$1 > 0 && $1 < 1 && $5 < $1 && $1 < $6 && $2 > 0 && $2 < 1 && $3 < $1 && $4 <= $2' \
    $(figures all cells error bad error_seen bad_seen) \
    $(figure error all cells 4) $(figure error all cells 5)
measure cells.probe --bad 0.1 >strict
holds "--bad says what is bad, and nothing else" '$2 > $1 && $3 == $4' \
    $(figure bad all cells) $(figure bad all strict) $(figures all cells error) \
    $(figures all strict error)
measure cells.probe --visible rays >rays
holds "--visible rays: the error is that of what is seen, and nothing else leaks" \
    '$1 == $2 && $3 == $4 && $5 == 0 && $6 == 0' \
    $(figures all rays error) $(figures all cells error_seen) $(figures all rays blind_points) \
    $(figures all cells blind_points) $(figures all rays unseen leak_volume)
refused 1 "visibility is of the probes of cells" \
    measure cells.probe --visible rays --interpolate nearest
refused 2 "--visible" measure cells.probe --visible some

# -- the stream that comes out ---------------------------------------------------------------------
measure cells.probe -o marked.probe >again
check "with -o the report is the same" cmp cells again
probe-cat --drop leak,leak_light,leak_free --text --no-provenance marked.probe >unmarked
probe-cat --text --no-provenance cells.probe >before
check "the stream is as it was, but for its cells' columns" cmp unmarked before and test -s before
probe-cat --text --no-provenance --columns position,leak,leak_free marked.probe |
    sed '1,/^table tet/d; /^end/d' |
    awk -v worst="$(figures all cells leak_worst_cell)" \
        'NR == worst + 1 { share = $1 } { n++; free += $2 } END { print n, share, free / n }' \
        >volumes
holds "they hold each cell's share" \
    '$1 == $4 && ($2 - $5) ^ 2 < 1e-10 && $3 > 0.9 && $3 <= 1' \
    $(cat volumes) $(figures all cells cells leak_worst)
measure cells.probe --max-leak 0.5 >gated 2>err
check "--max-leak lets through what leaks no more" cmp gated cells and empty err
measure cells.probe --max-leak 0.0001 >gated 2>err
status=$?
check "and has a status of its own, and the whole report, for what leaks more" \
    [ $status = 3 ] and cmp gated cells \
    and says err 'light that leaks .* above --max-leak 0.0001; worst cell'
refused 2 "--max-leak needs --leak-samples" \
    probe-error -q --max-leak 0.1 --leak-samples 0 "$rooms" cells.probe
if command -v probe-vtk >/dev/null; then
    probe-vtk -q -o marked.vtu marked.probe
    check "and probe-vtk writes them" says marked.vtu leak_light
else
    skip "probe-vtk is not built"
fi
probe-error -q --points 20 --truth-rays 16 --tsv -o - --text "$rooms" cells.probe \
    >marked.txt 2>report
probe-cat --info marked.txt >info
check "-o - puts the stream on standard output and the report on standard error" \
    says info leak_light and says report '^rms	all'

measure cells.probe --map map.probe --text >mapped
sed '1,/^table probe/d; /^end/d' map.probe |
    awk '{ n++; e += $4; seen += $5; s += $6 ^ 2; b += $7; t += $8; u += $9; o += $11 }
        END { print n, sqrt(s / n), b / n, t / n, u / n, o, e / n, seen / n }' >map
# Noise leaves some squares below 0, which a root cannot show: the map's rms is a little larger.
holds "--map has the error at each point" '$1 == 150 && $2 >= $9 && $2 < 1.1 * $9 &&
    ($3 - $10) ^ 2 < 1e-10 && ($4 - $11) ^ 2 < 1e-10 && ($5 - $12) ^ 2 < 1e-10 &&
    ($7 - $13) ^ 2 < 1e-10 && ($8 - $14) ^ 2 < 1e-10 && $6 == $15' \
    $(cat map) $(figures all cells rms bias irradiance unseen error error_seen) \
    $(figure points outside-hull cells)
check "and does not change the report" cmp mapped cells

# -- determinism -----------------------------------------------------------------------------------
# marks NAME OPTION...: a report, its truth and its stream, to NAME, NAME.truth, NAME.probe
marks() {
    marks_name=$1
    shift
    $run "$@" --truth "$marks_name.truth" -o "$marks_name.probe" "$rooms" cells.probe >"$marks_name"
}
same_marks() { cmp "$1" "$2" && cmp "$1.truth" "$2.truth" && cmp "$1.probe" "$2.probe"; }
for threads in 1 3; do marks t$threads --threads $threads; done
check "1 and 3 threads: the same report, truth and stream" same_marks t1 t3
plain_libm $run --truth plain.truth -o plain.probe "$rooms" cells.probe >plain
check "the same bytes without AVX2 and FMA in libc" same_marks t1 plain
check "a kept truth says what a new one says" cmp t1 cells
probe-cat --info rooms.truth >info
probe-cat --text rooms.truth >text
check "the truth is a probe stream like others" \
    says info 'table probe' and says text '^# probe-error .*two-rooms.obj'
positions cells.probe >places.txt
if plain_build "the noise of probes at their own places"; then
    there="probe-error -q --tsv --at places.txt --paths 0 --truth-rays 512 $rooms"
    $there cells.probe >there
    probe-place points places.txt | probe-capture -q --rays 2048 --bounces 8 "$rooms" |
        probe-tet >quiet.probe
    $there quiet.probe >quiet
    holds "at the probes' own places there is the capture's noise alone: less with more rays" \
        '$2 < $1 / 2 && $3 == 0' $(figure rms all there) $(figures all quiet rms unseen)
fi
printf '1 1 1\n1 1 3\n7 1 3\n' >way.txt
probe-error -q --tsv --points 10 --truth-rays 16 --path way.txt --step 0.25 "$rooms" cells.probe \
    >way
holds "change along a given path, in steps no longer than asked for" \
    '$1 == 1 && $2 == 8 + 24 && $3 == 0.25' $(figures all way paths change_steps step)

# -- what is measured is what probe-query answers --------------------------------------------------
probe-place grid -q --spacing 1.2 "$rooms" |
    probe-capture -q --rays 64 --bounces 8 --columns sh_gradient "$rooms" | probe-tet >sloped.probe
probe-error -q --tsv --paths 0 --points 60 --truth-rays 16 --leak-samples 0 --truth way.truth \
    "$rooms" sloped.probe >barycentric
cat >off.awk <<'AWK'
{
    luminance = 0.2126 * $12 + 0.7152 * $13 + 0.0722 * $14
    e = 3.14159265358979 * 0.28209479177388 * luminance - $7 - $8
    if (e * e > off) off = e * e
    n++
}
END { print n, off + 0 }
AWK
for how in "barycentric" "barycentric --outside extend" gradient cubic "nearest" \
    "shepard --radius 2 --falloff cubic"; do
    # shellcheck disable=SC2086 # $how is options
    probe-error -q --paths 0 --leak-samples 0 --truth way.truth --map how.probe --text \
        --interpolate $how "$rooms" sloped.probe >/dev/null
    sed '1,/^table probe/d; /^end/d' how.probe >how.map
    # shellcheck disable=SC2086
    cut -d ' ' -f 1-3 how.map | probe-query -q --interpolate $how sloped.probe - |
        paste -d ' ' how.map - | awk -f off.awk >how.off
    holds "$how: the light that is measured is probe-query's" '$1 == 60 && $2 < 1e-10' \
        $(cat how.off)
    cksum <how.map >>how.sums
done
sort -u how.sums >ways
check "each way is another" has_lines 6 ways
probe-cat --tables probe sloped.probe >loose.probe
probe-error --tsv --truth way.truth --interpolate nearest "$rooms" loose.probe >loose 2>err
check "nearest needs no cells, and says what it cannot know" \
    says loose '^rms	all' and lacks loose '^unseen' '^leak' \
    and says err 'leaks are measured of cells, and there are no cells'
refused 1 "run probe-tet" probe-error -q --truth way.truth "$rooms" loose.probe
refused 1 "--columns sh_gradient" measure cells.probe --interpolate cubic
refused 2 "need --interpolate shepard" probe-error -q --radius 1 "$rooms" cells.probe

# -- probes in a plane, on a line, in one place ----------------------------------------------------
awk 'BEGIN { for (x = 0.5; x < 5; x++) for (z = 0.5; z < 4; z++) print x, 1.5, z }' >plane.txt
grep ' 0.5$' plane.txt >line.txt
head -n 1 line.txt >one.txt
for flat in "plane triangles" "line segments" "one point"; do
    file=${flat% *}
    probe-place points $file.txt | probe-capture -q --rays 64 --bounces 8 "$rooms" |
        probe-tet -q >$file.probe
    probe-error --tsv --truth way.truth "$rooms" $file.probe >$file 2>err
    holds "$file: its error is measured" '$1 > 0 && $1 < 10 && $2 >= 0 && $2 <= 1 && NF == 2' \
        $(figures all $file rms_relative unseen)
    if [ "$file" = one ]; then
        check "one: it has no free space, and that is said" \
            lacks one '^leak' and says err "leaks are measured of cells, and the cell is a point"
        refused 1 "--output is of what leaks in cells" \
            probe-error -q --truth way.truth -o x.probe "$rooms" one.probe
    else
        holds "$file: what leaks is measured of its ${flat#* }" '$1 > 0 && $1 < 0.5 && $2 >= $1' \
            $(figures all $file leak_volume leak_worst)
        probe-error -q --truth way.truth -o x.probe "$rooms" $file.probe >report
        probe-cat --info x.probe >info
        check "$file: and marked" says info 'leak_free'
    fi
done

# -- forms of the report ---------------------------------------------------------------------------
form() { probe-error -q --points 150 --paths 2 --truth rooms.truth "$@" "$rooms" cells.probe; }
form >table
head -n 3 table >headline
check "the table begins with error, bad points, what is seen, unseen weight, blind points" \
    says headline '^error: [0-9.]* % (.* \.\. .*); bad points: ' \
    'of the probes that each point sees: ' 'weight from probes .*; blind points: '
check "the table names each part and each measure" \
    says table inside-hull outside-hull 'surface .* \.\. ' lit dark unseen 'unseen weight' \
    'change of light' 'worst at'
form --json >json
if command -v python3 >/dev/null; then
    cat >same.py <<'PYTHON'
import json

lines = [line.rstrip("\n").split("\t") for line in open("cells")][1:]
rows = json.load(open("json"))
assert len(lines) == len(rows)
for line, row in zip(lines, rows):
    assert line[:2] == [row["measure"], row["of"]]
    for text, value in zip(line[2:5], (row["value"], row["low"], row["high"]), strict=True):
        assert value is None if text == "nan" else float(text) == value
PYTHON
    check "JSON has what TSV has" python3 same.py
else
    skip "no python3 to read JSON with"
fi
measure cells.probe 2>quiet.err >/dev/null
probe-error --truth rooms.truth --points 150 --paths 2 "$rooms" cells.probe 2>err >/dev/null
check "--quiet says nothing, else it says where the time went" \
    empty quiet.err and says err 'truth .* s, error .* s, leaks'
$run --truth rooms.truth "$rooms" <cells.probe >piped
check "it reads a pipe" cmp piped cells

# -- what is refused -------------------------------------------------------------------------------
refused 1 "this is not the scene that the probes were captured in" \
    $run "$SRC/scenes/cornell-box.obj" cells.probe
$run --any-scene "$SRC/scenes/cornell-box.obj" cells.probe >any
check "--any-scene measures against another scene" says any '^rms'
refused 1 "this truth is of another scene" \
    $run --bounds $around --truth rooms.truth speck.obj sky.probe
other() { probe-error -q --truth rooms.truth "$@" "$rooms" cells.probe; }
refused 1 "truth-points 150, not 151" other --points 151
refused 1 "truth-seed 0, not 1" other --seed 1
refused 1 "truth-rays 128, not 256" other --truth-rays 256
refused 1 "truth-bounces 8, not 3" other --bounces 3
head -n 3 points.txt >three.txt
probe-error -q --at three.txt --paths 0 --truth-rays 16 --truth three.truth "$rooms" cells.probe \
    >/dev/null
check "a truth of given points serves those points" \
    probe-error -q --at three.txt --truth three.truth "$rooms" cells.probe
head -n 2 points.txt >two.txt
refused 1 "not at the points of two.txt" \
    probe-error -q --at two.txt --truth three.truth "$rooms" cells.probe
refused 1 "not a truth that probe-error made" \
    probe-error -q --truth cells.probe "$rooms" cells.probe
head -c 2000 rooms.truth >cut.truth
refused 1 "cut.truth" $run --truth cut.truth "$rooms" cells.probe
probe-place grid -q --count 20 "$rooms" >placed.probe
probe-capture -q --rays 4 "$rooms" placed.probe >loose.probe
probe-tet placed.probe >dark.probe
refused 1 "run probe-tet" probe-error -q "$rooms" loose.probe
refused 1 "run probe-capture" probe-error -q "$rooms" dark.probe
probe-tet --enclose cells.probe >corners.probe
refused 1 "has no light: run probe-capture" measure corners.probe
: >none.txt
refused 1 "expected at least one position, got none" \
    probe-error -q --at none.txt "$rooms" cells.probe
echo "1 2 3 4 5 6" >six.txt
refused 1 "x y z" probe-error -q --at six.txt "$rooms" cells.probe
refused 1 "in free space" \
    probe-error -q --bounds 4.005,0.5,0.5,4.015,2,0.9 "$rooms" cells.probe
echo "1e300 0 0" >far.txt
refused 1 "too far out" probe-error -q --paths 0 --at far.txt "$rooms" cells.probe
refused 1 "No space left" into /dev/full measure cells.probe
check "no truth is left behind by what failed" \
    not probe-error -q --truth far.truth --at far.txt --paths 0 "$rooms" cells.probe \
    and [ ! -e far.truth ]
refused 2 "only one of the stream, --at and --path" probe-error --at - "$rooms"
refused 2 "--points and --at" probe-error --points 3 --at points.txt "$rooms" cells.probe
refused 2 "--paths and --path" probe-error --paths 3 --path points.txt "$rooms" cells.probe
refused 2 "--leak-samples" probe-error --leak-samples 1 "$rooms" cells.probe
refused 2 "--output needs" probe-error --leak-samples 0 -o x "$rooms" cells.probe
refused 2 "--bounds" probe-error --bounds 1,1,1,0,0,0 "$rooms" cells.probe
refused 2 "SCENE" probe-error
# -- a preview -------------------------------------------------------------------------------------
# Paths of the points end in a cache: the light is nearly the truth, and cannot pass for it.
box=$SRC/scenes/cornell-box.obj
probe-place grid -q --count 100 "$box" | probe-capture -q -r 128 "$box" | probe-tet -q >box.probe
of_box() {
    probe-error --paths 0 --leak-samples 0 --points 200 --truth-rays 2048 "$@" "$box" box.probe
}
of_box --tsv --truth box.truth >plain.tsv 2>err
of_box --tsv --truth-cache auto --truth box.preview >preview.tsv 2>said
row() { awk -v of="$1" '$1 == of && $2 == "all" { print $3 }' "$2"; }
check "a preview: nearly the same error, by less noise ($(row error plain.tsv), \
$(row error preview.tsv); $(row noise_mean_relative plain.tsv), \
$(row noise_mean_relative preview.tsv))" says said 'a preview, and not the truth: cache: ' and \
    awk -v a="$(row error plain.tsv)" -v b="$(row error preview.tsv)" \
    -v n="$(row noise_mean_relative plain.tsv)" -v m="$(row noise_mean_relative preview.tsv)" \
    'BEGIN { exit !(a > .05 && b < 1.1 * a && b > .9 * a && m > 0 && m < .7 * n) }'
check "its report says what it is" [ "$(sed -n 2p preview.tsv | cut -f 1-3)" = \
    "$(printf 'preview\tall\t1')" ] and lacks plain.tsv preview
of_box --truth-cache auto --truth box.preview >table 2>err
check "when it is read again, too" sh -c 'head -n 1 table | grep -q ^PREVIEW'
refused 1 "box.preview: this is no truth but a preview" of_box --truth box.preview
of_box --truth-cache auto --truth box.truth >table 2>err
check "the truth serves for a preview, as the truth" lacks table PREVIEW and says table '^error'
of_box --truth-cache auto --bounces 1 >table 2>said
check "where there is no cache it is the truth" lacks table PREVIEW and says said 'no cache: '
refused 1 "--truth-cache: box.probe: expected --light indirect" of_box --truth-cache box.probe

tap_done
