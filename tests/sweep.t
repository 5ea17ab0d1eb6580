#!/bin/sh
# scripts/sweep as users run it: a table that a killed sweep completes, failures that are rows, files that are refused.
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
    awk -F '\t' -v name="$1" 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == name) at = i; next } { print $at }' "$2"
}

# lasting FILE: what does not depend on how long things took
lasting() {
    awk -F '\t' 'NR == 1 { for (i = 1; i <= NF; i++) keep[i] = $i !~ /(_cpu_s|_peak_mb)$|^cpu_s$|^peak_mb$/ }
        { for (i = 1; i <= NF; i++) if (keep[i]) printf "%s\t", $i; print "" }' "$1"
}

check "--dry-run runs nothing" sh -c "$sweep --dry-run -o dry four >dry.out && [ ! -e dry/sweep.tsv ] && grep -q '^to do capture: probe-capture --threads 1 --rays 64' dry.out"
check "four runs" $sweep --no-plots -o whole four
check "a row for each, all well" sh -c "[ \"\$(tail -n +2 whole/sweep.tsv | grep -c '	ok	')\" = 4 ]"
streams() { find "$1/work" -name '*.probe' | wc -l; }
# 1 placement, 3 captures, 4 passed the gate (open and shut are two commands), 4 sets of cells
check "what runs share is made once" [ "$(streams whole)" = 12 ]
stream=whole/$(column stream whole/sweep.tsv | head -n 1)
check "counts and bytes are those of the stream" sh -c "[ \"\$(probe-cat --binary --no-provenance $stream | wc -c)\" = $(column bytes whole/sweep.tsv | head -n 1) ] &&
    [ \"\$(probe-cat --text --no-provenance $stream | wc -c)\" = $(column text_bytes whole/sweep.tsv | head -n 1) ] &&
    probe-cat --info $stream | grep -q 'table probe: $(column probes whole/sweep.tsv | head -n 1) rows' &&
    probe-cat --info $stream | grep -q 'table tet: $(column tetrahedra whole/sweep.tsv | head -n 1) rows'"
probe-error -q --tsv --points 60 --paths 2 --truth-rays 32 --leak-samples 2 "$SRC/scenes/two-rooms.obj" "$stream" >alone
check "the figures are probe-error's" [ "$(awk -F '\t' '$1 == "rms_relative" && $2 == "lit" { print $3 }' alone)" = "$(column rms_relative:lit whole/sweep.tsv | head -n 1)" ]
for stage in place capture tet; do
    column ${stage}_cpu_s whole/sweep.tsv >seconds
    column ${stage}_peak_mb whole/sweep.tsv >peaks
    check "$stage: seconds and memory of all runs" sh -c "[ \"\$(paste seconds peaks | awk '\$1 > 0 && \$2 > 1 && \$1 \$2 !~ /nan|inf/' | wc -l)\" = 4 ]"
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
    check "$signal: no placement and no capture is made again" sh -c "grep -q 'place: 0 to do, 1 done before' killed.err && grep -q 'capture: 0 to do, 3 done before' killed.err"
    lasting whole/sweep.tsv >a
    lasting killed/sweep.tsv >b
    check "$signal: resumed, it says what the other says" cmp a b
    rm -rf killed
done

# -- content, not names ----------------------------------------------------------------------------
$sweep --no-plots -o whole four >first.out 2>again.err
check "a second time there is nothing to do" sh -c "grep -c ': 0 to do' again.err | grep -qx 6 && ! grep -q ': [1-9][0-9]* to do' again.err"
cp "$SRC/scenes/two-rooms.obj" moved.obj
cp "$SRC/scenes/two-rooms.mtl" .
$sweep --no-plots --scene moved.obj -o whole four >moved.out 2>moved.err
check "nor with the same scene elsewhere" sh -c "grep -q 'capture: 0 to do' moved.err && cmp first.out moved.out"
sed 's/^Ke .*/Ke 5 5 5/' "$SRC/scenes/two-rooms.mtl" >two-rooms.mtl
$sweep --no-plots --scene moved.obj -o whole four >moved.out 2>moved.err
check "another material is another scene" grep -q 'capture: 3 to do' moved.err

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
check "the cheapest under an error is the cheapest of all, if all are" sh -c "
    grep -A1 'the cheapest under 100000.00% by time' says | grep -qF ' $least CPU s'" \
    and [ "$least" -ge 4 ]
best=$(column rms_relative whole/sweep.tsv | sort -g | head -n 1 | awk '{ printf "%.2f%%", 100 * $1 }')
check "the best within any time and size is the best of all" sh -c "[ \"\$(grep -A1 'the best within' says | grep -c \": $best\")\" = 2 ]"
$sweep --no-plots --error 0.01% --size 10 -o whole four >says 2>/dev/null
check "where nothing will do, it says so and names the nearest" sh -c "grep -A1 'no setting is under 0.01%' says | grep -q \": $best\" && grep -q 'no setting is within 10 B' says"
check "a table of the dial that varies" grep -q '^rays (base: 32)' says
if command -v gnuplot >/dev/null; then
    check "pictures" $sweep --error 50% -o whole four
    for picture in time bytes probes; do
        check "$picture.png and $picture.svg" sh -c "head -c 4 whole/$picture.png | grep -q PNG && grep -q 'Pareto front' whole/$picture.svg && grep -q '</svg>' whole/$picture.svg"
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
check "the rows say which stage said what" sh -c "[ \"\$(grep -cx ok status)\" = 2 ] && grep -q '^place: probe-place: .*--count' status && grep -q '^capture: probe-capture: .*--bounces' status && grep -qx 'fix: exit status 1' status"
check "a failed row has no figures" sh -c "[ \"\$(grep '	fix: exit' failed/sweep.tsv | tr '\t' '\n' | tail -n 1)\" = nan ]"
$sweep --no-plots -o failed fails >fails.out 2>fails.err
check "what failed is tried again, what did not is not" sh -c "grep -q 'place: 1 to do, 1 done' fails.err && grep -q 'tet: 0 to do, 1 done' fails.err"

# -- what is refused -------------------------------------------------------------------------------
# bad LINE MESSAGE: `four` with a line added at its end
bad() {
    { grep -v '^measure' four; echo "$1"; echo 'measure probe-error {scene}'; } >bad
    refused 2 "$2" $sweep -o none bad
}
bad "vray rays 1" "bad:13: expected scene, light, base, vary, cross, run, stage, size, measure, got vray"
bad "vary colour 1" "bad:13: vary colour: expected a base colour before it"
bad "base rays 3" "bad:13: base rays: there is one already"
bad "base Rays 3" "bad:13: base: expected a name of small letters"
bad "run colour=1" "bad:13: run: expected DIAL=VALUE of dials before it (count, rays, gate), got colour=1"
bad "vary rays" "bad:13: vary: expected 2 or more words, got 1"
bad "stage show cat {file}" "bad:13: show: expected {scene}, {light} or a dial (count, rays, gate), got {file}"
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
check "--help tells the format" sh -c "$sweep --help | grep -q 'cross DIAL VALUE'"
for file in "$SRC"/scripts/sweeps/*; do
    check "${file##*/} is a sweep" $sweep --dry-run --scene "$SRC/scenes/two-rooms.obj" -o none "$file"
done
tap_done
