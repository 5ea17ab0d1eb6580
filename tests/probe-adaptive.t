#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-place adaptive: as few probes as the light needs, where it needs them; each rule ends it and
# says so; nothing depends on threads, on the order of triangles, or on noise.
. "${SRC:?}/tests/support/setup.sh"

# room X0 X1 MATERIAL: a closed room, seen from within, of which v0 vertices came before
room() {
    printf 'v %s 0 0\nv %s 0 0\nv %s 2 0\nv %s 2 0\nv %s 0 2\nv %s 0 2\nv %s 2 2\nv %s 2 2\n' \
        "$1" "$2" "$2" "$1" "$1" "$2" "$2" "$1"
    printf 'usemtl %s\n' "$3"
    for face in '-8 -7 -6' '-8 -6 -5' '-4 -1 -2' '-4 -2 -3' '-8 -4 -3' '-8 -3 -7' '-5 -6 -2' \
        '-5 -2 -1' '-8 -5 -1' '-8 -1 -4' '-7 -3 -2' '-7 -2 -6'; do
        echo "f $face"
    done
}
cat >light.mtl <<'MTL'
newmtl one
Kd 0 0 0
Ke 1 1 1
newmtl four
Kd 0 0 0
Ke 4 4 4
newmtl wall
Kd .6 .5 .4
newmtl lamp
Kd 0 0 0
Ke 40 40 40
MTL
{ echo 'mtllib light.mtl' && room 0 2 one; } >even.obj
{ echo 'mtllib light.mtl' && room 0 1.99 one && room 2.01 4 four; } >halves.obj
{
    echo 'mtllib light.mtl' && room 0 3 wall
    printf '%s\n' 'v .1 .2 1.9' 'v .4 .2 1.9' 'v .1 .5 1.9' 'usemtl lamp' 'f -3 -1 -2'
} >lamp.obj

# probes OBJ OPTION...: places adaptive probes of it, into placed.probe and said; with rays that are
# fixed, as most tests want them, unless noise says otherwise
noise=0
rays=32
probes() {
    probes_of=$1
    shift
    probe-place adaptive --text --noise $noise "$@" "$probes_of" >placed.probe 2>said
}
# told FILE: the error held out that the last line of FILE with one tells, and its standard error
told() {
    sed -n 's/.*(held out \([-0-9.]*\), \([-0-9.]*\) to \([-0-9.]*\)).*/\1 \2 \3/p' "$1" |
        awk '{ error = $1; doubt = ($3 - $2) / 3.92 } END { print error / 100, doubt / 100 }'
}
# measured REPORT: the same of probe-error --tsv
measured() { awk '$1 == "error" && $2 == "all" { print $3, ($5 - $4) / 3.92 }' "$1"; }
placed() { row_count probe placed.probe; }

# -- as few as the light needs ---------------------------------------------------------------------
if sanitized; then
    skip "how few is seen in the plain build"
else
    noise=50%
    check "light that is the same everywhere needs 4 probes" \
        probes even.obj --max-error 1% --rays 64 \
        and says said ': 4 probes of .*: the error is as asked for'
    check "and no more where more are asked for" probes even.obj --probes 50 --rays 64 \
        and says said ': 4 probes of .*: the error is flat'
    told said >figures
    check "since it is that of noise, by its standard error ($(cat figures))" \
        every '$1 <= .01 + 4 * $2 && $2 < .005' figures
    check "they are a stream of positions and of what placed them" says placed.probe \
        '^table probe position:f64:3 origin:i32:1 sh:f32:27 ' ' 5 ' and [ "$(placed)" -eq 4 ]
    probes halves.obj --max-error 1% --rays 64
    check "two rooms of constant light need few ($(placed))" [ "$(placed)" -le 24 ]
    probe-cat --text placed.probe | numbers |
        awk '{ side[$1 < 2]++ } END { exit !(side[0] && side[1]) }'
    check "on both sides of the wall" [ $? -eq 0 ]
    probe-capture -q --rays 256 halves.obj placed.probe | probe-tet -q |
        probe-leakfix -q halves.obj |
        probe-error -q --tsv --points 400 --paths 0 --truth-rays 64 --leak-samples 0 halves.obj \
            >report
    measured report >figures
    check "and probe-error finds that error, by its standard error ($(cat figures))" \
        every '$1 <= .01 + 4 * $2 && $2 < .005' figures and has_lines 1 figures
    noise=0
fi

# -- what ends it ----------------------------------------------------------------------------------
probes lamp.obj --probes 37 --rays $rays --curve curve.tsv
check "--probes" [ "$(placed)" -eq 37 ] \
    and says said ': 37 probes of .*: there are as many as --probes allows'
check "--curve has a line a round" says curve.tsv '^4	' '^37	' \
    '^probes.bytes.error.held_out.held_out_low.held_out_high.seconds$'
tail -n +2 curve.tsv >rows
check "numbers grow, and the interval holds the error" \
    every 'NF == 7 && $5 <= $4 && $4 <= $6 && $1 >= last * .9 && (last = $1)' rows
cp placed.probe of-37
if plain_build "seeds, orders of triangles and numbers of threads"; then
    check "is the same with one thread" probes lamp.obj --probes 37 --rays $rays --threads 1 \
        and same_stream placed.probe of-37
    check "and another with another seed" probes lamp.obj --probes 37 --rays $rays --seed 1 \
        and not same_stream placed.probe of-37
    {
        grep -v '^f\|^usemtl' lamp.obj
        echo usemtl lamp
        echo f 9 11 10
        echo usemtl wall
        grep '^f' lamp.obj | head -n 12 | tac | awk '{ print "f", $3 + 9, $4 + 9, $2 + 9 }'
    } >turned.obj
    check "whatever the order of triangles" probes turned.obj --probes 37 --rays $rays
    probe-cat --text --columns position of-37 | numbers >a
    probe-cat --text --columns position placed.probe | numbers >b
    check "it is the same to rounding" near 1e-6 a b
fi
few=3000
if plain_build "--bytes and --gain"; then
    few='3000 5000'
    check "--bytes" probes lamp.obj --bytes 20000 --rays $rays and says said 'as --bytes allows'
    probe-capture -q --rays 16 lamp.obj placed.probe | probe-tet -q | probe-leakfix -q lamp.obj |
        probe-query --pack float - >packed
    bytes=$(wc -c <packed)
    check "is that of the packed file" [ "$bytes" -le 20000 ] and [ "$bytes" -ge 16000 ]
    check "--gain" probes lamp.obj --gain 60% --rays $rays and says said 'gained less than --gain'
fi
for most in $few; do
    probes lamp.obj --bytes $most --rays 16
    probe-tet -q placed.probe | probe-leakfix -q --points 0 lamp.obj |
        probe-query --pack float - >packed
    check "and of $most bytes ($(wc -c <packed)), fewer than it would begin with" \
        [ "$(wc -c <packed)" -le $most ] and [ "$(wc -c <packed)" -gt 1000 ]
done
refused 1 'expected room for 4 more probes, which take' \
    probe-place adaptive --bytes 500 --rays 16 --noise 0 lamp.obj
probes lamp.obj --max-error .1% --max-probes 12 --rays $rays
check "--max-probes" [ "$(placed)" -eq 12 ] \
    and says said 'warning: the error is .* %.*, not 0.10 % or less: the best'
check "and that SH leave more than is asked for, at once" sh -c 'head -n 2 said |
    grep -q "SH of order 3 leave .* wherever probes are, more than the 0.10 % asked for"'

# -- a signal --------------------------------------------------------------------------------------
env --default-signal=INT probe-place adaptive --text --max-error .01% --noise 0 --rays $rays \
    lamp.obj >ended 2>said &
program=$!
wait_for grep -q '20 probes: error' said
kill -INT $program
wait $program
check "a signal ends it, with status 1" [ $? -eq 1 ] and says said 'interrupted: the [0-9]* probes'
count=$(row_count probe ended)
check "and what there is then is written whole" [ "$count" -ge 20 ] \
    and says said ": $count probes of .*: interrupted" "the $count probes until then are written"

env --default-signal=INT probe-place adaptive --text --probes 40 --rays 4096 --progress lamp.obj \
    >ended 2>said &
program=$!
wait_for grep -q '[1-9][0-9]* / [0-9]* candidates' said
kill -INT $program
wait $program
check "while the first points are traced, with the first 4" [ $? -eq 1 ] \
    and says said ': 4 probes of .*: interrupted' and [ "$(row_count probe ended)" -eq 4 ]
check "and the stream says so" says ended '^place-interrupted yes$'
probe-place adaptive --probes 8 --rays 16 --noise 0 --progress -o placed.probe lamp.obj 2>said
check "--progress shows what is looked at between the lines of errors" \
    says said '[0-9] points looked at,' '[0-9] / [0-9]* candidates (100 %)'

# -- noise is not chased ---------------------------------------------------------------------------
if plain_build "noise"; then
    probes lamp.obj --max-error 20% --rays 512
    many=$(placed)
    probes lamp.obj --max-error 20% --rays 32
    check "with 32 rays no more probes than half again what 512 rays need ($(placed), $many)" \
        [ "$(placed)" -le $((many * 3 / 2 + 4)) ]
    noise=50%
    probes lamp.obj --max-error 25% --rays 64
    told said >figures
    probe-tet -q placed.probe | probe-leakfix -q lamp.obj |
        probe-error -q --tsv --points 500 --paths 0 --truth-rays 4096 --leak-samples 0 \
            lamp.obj >report
    measured report >>figures
    tr '\n' ' ' <figures >both
    check "the error held out is probe-error's, by their standard errors ($(cat both))" \
        every 'NF == 4 && near($1, $3, 4 * sqrt($2 ^ 2 + $4 ^ 2))' both
    noise=0
fi

# -- what stays ------------------------------------------------------------------------------------
printf '%s\n' '.5 .5 .5' '2.5 1.5 1' | probe-place points - >kept.probe
probes lamp.obj --probes 20 --rays 64 --keep kept.probe
check "--keep" [ "$(placed)" -eq 20 ]
probe-cat --text --columns position,origin placed.probe | numbers | head -n 2 >rows
check "has them first, and does not say what placed them" \
    says rows '^0.5 0.5 0.5 -1$' '^2.5 1.5 1 -1$'
cp placed.probe kept.probe
check "and of streams that do, what they say" \
    probes lamp.obj --probes 30 --rays 64 --keep kept.probe
probe-cat --text placed.probe | numbers | awk '$4 == 5' >rows
check "of all but two" has_lines 28 rows

# -- light that is kept ----------------------------------------------------------------------------
# light STREAM: position and light of each probe, into the file of that name
light() { rows_of position,sh,sh_error,validity,depth,sky "$1.probe" >"$1"; }
# a sun alone, with nothing near: at each point max(c, 0), c the cosine of the angle to it, of which
# SH of order 3 hold 1/4 + c/2 + 5/32 (3 c^2 - 1); held against that along the ruler's
# directions, with its floor of a tenth of 1/4 / 0.7, they are 56.21 % off
printf '%s\n' 'v 500 500 500' 'v 501 500 500' 'v 500 501 500' 'f 1 2 3' >far.obj
probes far.obj --probes 8 --bounds 0,0,0,1,1,1 --sun 0,0,-1,1,1,1
check "the error held out is that of light as it is, not of what SH of a higher order hold" \
    says said ' (held out 56.21, 56.21 to 56.21)'
if plain_build "that what was placed has its light"; then
    noise=100%
    probes lamp.obj --probes 12 --rays 64
    noise=0
    rows_of position placed.probe | probe-place points - >bare.probe
    probe-capture -q --rays 64 --error "$(sed -n 's/^capture-error //p' placed.probe)" \
        --error-floor "$(sed -n 's/^capture-error-floor //p' placed.probe)" lamp.obj bare.probe \
        >fresh.probe
    light placed && light fresh
    check "light of as many rays as noise asks for is what probe-capture finds, and they are told" \
        has_lines 12 placed and cmp placed fresh \
        and says said ': 12 probes of .* points, [0-9]* rays each; SH of order 3 leave [0-9.]* %'
    for rays in 100 20; do
        probes lamp.obj --probes 12 --rays $rays --seed 3
        rows_of position placed.probe | probe-place points - >bare.probe
        probe-capture -q --rays $rays --seed 3 lamp.obj bare.probe >fresh.probe
        light placed && light fresh
        check "light of $rays rays is what probe-capture finds, to the bit" \
            has_lines 12 placed and cmp placed fresh
    done
    check "it goes through that as it is, and nothing is said" \
        eval 'probe-capture lamp.obj placed.probe 2>said >through.probe' \
        and light through and cmp placed through and has_lines 0 said
    check "as captured light" not says through.probe '^capture-by' \
        and says through.probe '^capture-rays 20$'
    probe-capture -q --rays 30 lamp.obj bare.probe >fresh.probe
    probe-capture -q --rays 30 --seed 0 lamp.obj placed.probe >again.probe
    light fresh && light again
    check "other settings trace it anew, without --again" cmp again fresh
    probe-capture -q --columns ao lamp.obj placed.probe >again.probe && light again
    check "and so do more columns" says again.probe ' ao:f32:1' and has_lines 12 again
    probe-cat --columns position,origin placed.probe | probe-capture -q lamp.obj - >again.probe
    light again
    check "what is missing is traced as the others were" cmp again placed
fi

# -- what cannot be --------------------------------------------------------------------------------
refused 2 'expected --max-error, --probes, --bytes or --gain' probe-place adaptive lamp.obj
refused 2 '--probes: expected a number at least 4' probe-place adaptive --probes 3 lamp.obj
refused 2 "--curve: expected the name of a file, got '-'" \
    probe-place adaptive --probes 9 --curve - lamp.obj
refused 1 'no/such: No such file' \
    timeout 1 probe-place adaptive --probes 100000 --curve no/such lamp.obj
refused 2 "expected a share between 0 and 1, got '0'" \
    probe-place adaptive --max-error 0 lamp.obj
refused 2 'does not look at light' probe-place grid --count 9 --sky 1,1,1 lamp.obj
refused 2 'places no probes where there is no air' \
    probe-place adaptive --probes 9 --inside keep lamp.obj
refused 1 '5 probes at most, with 20 given ones: expected room for 4 more' \
    probe-place adaptive --probes 5 --keep kept.probe lamp.obj
refused 1 '2000000000 probes are chosen of points that take ' \
    probe-place adaptive --probes 2000000000 --max-probes 2e9 lamp.obj
grep -v usemtl lamp.obj >dark.obj
refused 1 '--sky, --sun, --point and --spot add light' \
    probe-place adaptive --probes 9 --rays 16 dark.obj
check "a sky is one" probes dark.obj --probes 9 --rays 16 --point 1,1,1,1,1,1
refused 1 'are in free space: --bounds' \
    probe-place adaptive --probes 9 --noise 0 --bounds 8,8,8,9,9,9 lamp.obj
printf 'v -4 2 -4\nv -4 2 4\nv 4 2 4\nv 4 2 -4\nf 1 2 3 4\n' >quad.obj
probes quad.obj --probes 9 --rays 16 --sky 1,1,1
rows_of position placed.probe >rows
check "a floor has air above it" every '$2 > 2 && $2 < 3' rows \
    and says said 'flat along Y: probes go into what is up to 1 above it'
probe-place octree -q --sky 1,1,1 --levels 0 quad.obj >octree.probe
rows_of position octree.probe >rows
check "for an octree as well" every '$2 > 2 && $2 < 3' rows
refused 1 'flat' probe-place adaptive --probes 9 --noise 0 --bounds 0,1,0,3,1,2 lamp.obj
probe-place vertices lamp.obj >surface.probe
refused 1 'probes with normals' probe-place adaptive --probes 90 --keep surface.probe lamp.obj

tap_done
