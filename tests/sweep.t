#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# scripts/sweep as users run it: a table that a killed sweep completes, failures that are rows,
# files that are refused.
. "${SRC:?}/tests/support/setup.sh"
for tool in python3 parallel setpriv time; do
    command -v $tool >/dev/null || { skip "$tool is not installed: no sweeps"; tap_done; }
done
sweep="$SRC/scripts/sweep -j 2 --programs $BUILD/src"

# The sweep: 4 runs of two rooms; one stage may hold on until the test lets it go.
cat >gate <<'END'
#!/bin/sh
[ "$1" = open ] || { touch "$SWEEP_AT/held"; while [ -e "$SWEEP_AT/shut" ]; do sleep .05; done; }
exec cat
END
chmod +x gate
cat >four <<END
scene $SRC/scenes/two-rooms.obj
base count 60     # a comment
base rays 32
base gate open
vary rays 16 64
cross gate 'open' shut
run rays=64 gate=open
stage place probe-place grid --count {count} {scene}
stage capture probe-capture --rays {rays} --bounces 4 {light} {scene}
stage hold $PWD/gate {gate}
stage tet probe-tet
size text probe-cat --text --no-provenance
measure probe-error --points 60 --paths 2 --truth-rays 32 --leak-samples 2 {scene}
END
SWEEP_AT=$PWD
export SWEEP_AT

# column NAME FILE: of a table with its names in the first row
column() {
    awk -F '\t' -v name="$1" '
        NR == 1 { for (i = 1; i <= NF; i++) if ($i == name) at = i; next }
        { print $at }' "$2"
}
# first NAME FILE: of the first run
first() { column "$1" "$2" | head -n 1; }
# is TEXT COMMAND...: this is all that the command prints
is() {
    is_text=$1
    shift
    is_got=$("$@")
    [ "$is_got" = "$is_text" ] && return
    echo "$is_got"
    return 1
}

# lasting FILE: what does not depend on how long things took
lasting() {
    awk -F '\t' '
        NR == 1 {
            for (i = 1; i <= NF; i++) keep[i] = $i !~ /(_cpu_s|_peak_mb)$|^cpu_s$|^peak_mb$/
        }
        {
            for (i = 1; i <= NF; i++) if (keep[i]) printf "%s\t", $i
            print ""
        }' "$1"
}

check "--dry-run runs nothing" into dry.out $sweep --dry-run -o dry four \
    and [ ! -e dry/sweep.tsv ] \
    and says dry.out '^to do capture: probe-capture --threads 1 --rays 64'
check "four runs" $sweep --no-plots -o whole four
column status whole/sweep.tsv >status
check "a row for each, all well" every '$0 == "ok"' status and has_lines 4 status
find whole/work -name '*.probe' >streams
# 1 placement, 3 captures, 4 passed the gate (open and shut are two commands), 4 sets of cells
check "what runs share is made once" has_lines 12 streams
stream=whole/$(first stream whole/sweep.tsv)
for encoding in binary text; do
    probe-cat --$encoding --no-provenance "$stream" | wc -c
done >bytes
row_count probe "$stream" >rows
row_count tet "$stream" >>rows
check "counts and bytes are those of the stream" \
    is "$(first bytes whole/sweep.tsv)" sed -n 1p bytes \
    and is "$(first text_bytes whole/sweep.tsv)" sed -n 2p bytes \
    and is "$(first probes whole/sweep.tsv)" sed -n 1p rows \
    and is "$(first tetrahedra whole/sweep.tsv)" sed -n 2p rows and has_lines 2 rows
probe-error -q --tsv --points 60 --paths 2 --truth-rays 32 --leak-samples 2 \
    "$SRC/scenes/two-rooms.obj" "$stream" >alone
error=$(awk -F '\t' '$1 == "error" && $2 == "lit" { print $3 }' alone)
check "the figures are probe-error's" \
    is "$error" first error:lit whole/sweep.tsv and [ -n "$error" ]
for stage in place capture tet; do
    column ${stage}_cpu_s whole/sweep.tsv >seconds
    column ${stage}_peak_mb whole/sweep.tsv | paste seconds - >seconds_and_peaks
    check "$stage: seconds and memory of all runs" has_lines 4 seconds_and_peaks \
        and every '$1 > 0 && $2 > 1 && $1 $2 !~ /nan|inf/' seconds_and_peaks
done

# -- killed in its middle --------------------------------------------------------------------------
for signal in TERM KILL; do
    rm -f held
    touch shut
    $sweep --no-plots -o killed four >/dev/null 2>killed.err &
    killed=$!
    check "$signal: it is in its middle" wait_for test -e held
    check "no table yet" [ ! -e killed/sweep.tsv ]
    kill -$signal $killed
    wait $killed 2>/dev/null
    rm -f shut
    done_before=$(find killed/work -name '*.json' | wc -l)
    check "$signal: finished work is there" [ "$done_before" -ge 4 ]
    $sweep --no-plots -o killed four >killed.out 2>killed.err
    check "$signal: no placement and no capture is made again" says killed.err \
        'place: 0 to do, 1 done before' 'capture: 0 to do, 3 done before'
    lasting whole/sweep.tsv >a
    lasting killed/sweep.tsv >b
    check "$signal: resumed, it says what the other says" cmp a b and has_lines 5 a
    rm -rf killed
done

# -- content, not names ----------------------------------------------------------------------------
$sweep --no-plots -o whole four >first.out 2>again.err
check "a second time there is nothing to do" \
    is 6 grep -c ': 0 to do' again.err and lacks again.err ': [1-9][0-9]* to do'
cp "$SRC/scenes/two-rooms.obj" moved.obj
cp "$SRC/scenes/two-rooms.mtl" .
$sweep --no-plots --scene moved.obj -o whole four >moved.out 2>moved.err
check "nor with the same scene elsewhere" \
    says moved.err 'capture: 0 to do' and cmp first.out moved.out
sed 's/^Ke .*/Ke 5 5 5/' "$SRC/scenes/two-rooms.mtl" >two-rooms.mtl
$sweep --no-plots --scene moved.obj -o whole four >moved.out 2>moved.err
check "another material is another scene" says moved.err 'capture: 3 to do'

# -- what it says ----------------------------------------------------------------------------------
# Times and their order are given: the result of each job, by its name, takes one second more.
seconds=0
for result in whole/work/*.json; do
    seconds=$((seconds + 1))
    sed -i "s/\"cpu_s\": [^,}]*/\"cpu_s\": $seconds/" "$result"
done
$sweep --no-plots --error 100000% --time 1e9 --size 1e9 -o whole \
    --scene "$SRC/scenes/two-rooms.obj" four >says 2>/dev/null
least=$(column cpu_s whole/sweep.tsv | sort -g | head -n 1)
grep -A1 'the cheapest under 100000.00% by time' says >cheapest
check "the cheapest under an error is the cheapest of all, if all are" \
    says cheapest " $least CPU s" and [ "$least" -ge 4 ]
best=$(column error whole/sweep.tsv | sort -g | awk '{ printf "%.2f%%", 100 * $1; exit }')
grep -A1 'the best within' says >within
check "the best within any time and size is the best of all" is 2 grep -c ": $best" within
$sweep --no-plots --error 0.01% --size 10 -o whole four >says 2>/dev/null
grep -A1 'no setting is under 0.01%' says >nearest
check "where nothing will do, it says so and names the nearest" \
    says nearest ": $best" and says says 'no setting is within 10 B'
check "a table of the dial that varies" says says '^rays (base: 32)'
if command -v gnuplot >/dev/null; then
    check "pictures" $sweep --error 50% -o whole four
    for picture in time bytes probes; do
        head -c 4 whole/$picture.png >magic
        check "$picture.png and $picture.svg" \
            says magic PNG and says whole/$picture.svg 'Pareto front' '</svg>'
    done
else
    skip "gnuplot is not installed: no pictures"
fi

# -- a stage that fails is a row that says so ------------------------------------------------------
cat >fails <<END
scene $SRC/scenes/two-rooms.obj
base count 60
base fix ''
base bounces 4
vary count 0
vary bounces 4000000000
vary fix 'probe-leakfix --rounds 0 {scene}' false
stage place probe-place grid --count {count} {scene}
stage capture probe-capture --rays 32 --bounces {bounces} {scene}
stage tet probe-tet
stage fix {fix}
measure probe-error --points 60 --paths 2 --truth-rays 32 --leak-samples 2 --bounces 4 {scene}
END
$sweep --no-plots -o failed fails >fails.out 2>fails.err
check "a sweep with a failure ends with 1, and goes on" [ $? = 1 ]
column status failed/sweep.tsv >status
check "the rows say which stage said what" is 2 grep -cx ok status and says status \
    '^place: probe-place: .*--count' '^capture: probe-capture: .*--bounces' '^fix: exit status 1$'
awk -F '\t' '/\tfix: exit/ { print $NF }' failed/sweep.tsv >figure
check "a failed row has no figures" is nan cat figure
$sweep --no-plots -o failed fails >fails.out 2>fails.err
check "what failed is tried again, what did not is not" \
    says fails.err 'place: 1 to do, 1 done' 'tet: 0 to do, 1 done'

# -- what is refused -------------------------------------------------------------------------------
# bad LINE MESSAGE: `four` with a line added at its end
bad() {
    { grep -v '^measure' four; echo "$1"; echo 'measure probe-error {scene}'; } >bad
    refused 2 "$2" $sweep -o none bad
}
words="scene, light, base, vary, cross, run, stage, size, measure"
bad "vray rays 1" "bad:13: expected $words, got vray"
bad "vary colour 1" "bad:13: vary colour: expected a base colour before it"
bad "base rays 3" "bad:13: base rays: there is one already"
bad "base Rays 3" "bad:13: base: expected a name of small letters"
dials="count, rays, gate"
bad "run colour=1" "bad:13: run: expected DIAL=VALUE of dials before it ($dials), got colour=1"
bad "vary rays" "bad:13: vary: expected 2 or more words, got 1"
bad "stage show cat {file}" \
    "bad:13: show: expected {scene}, {light} or a dial ($dials), got {file}"
bad "stage show no-such-program" "bad:13: no-such-program: no such program"
bad "stage tet cat" "bad:13: stage tet: there is one already"
bad "base unused 3" "bad:13: base unused: no command has {unused}"
bad "light '--sky" "bad:13: No closing quotation"
grep -v '^measure' four >bad
refused 2 "bad:12: expected a measure before the end" $sweep -o none bad
grep -v '^scene' four >bad
refused 2 "expected --scene FILE" $sweep -o none bad
refused 2 "nowhere.obj: no such scene" $sweep -o none --scene nowhere.obj four
refused 2 "no-such-file" $sweep no-such-file
refused 2 "expected a sweep file" $sweep
refused 2 "--error: expected a number above 0" $sweep --error 5x four
refused 2 "--base: expected DIAL=VALUE" $sweep --base colour=3 four
check "nothing was left by these" [ ! -e none ]
check "--help tells the format" into help $sweep --help and says help 'cross DIAL VALUE'
for file in "$SRC"/scripts/sweeps/*; do
    check "${file##*/} is a sweep" \
        $sweep --dry-run --scene "$SRC/scenes/two-rooms.obj" -o none "$file"
done
tap_done
