#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-relight as people run it: light is the weighted sum of its parts, whichever way they are
# asked for; errors are those of the sum; the header names the light, so that what sees the scene
# traces it; what is wrong is said.
. "${SRC:?}/tests/support/setup.sh"

# Three groups, a sky of order 2, three suns; one probe of order 1 with light, one without.
cat >parts.probe <<END
#?probe 1
# made by hand
sh-order 1
sh-content radiance
sky 0,0,0
group-1 lamps light=lamp*
group-2 windows material=glass
group-3 rest
transfer-sky 2
transfer-sun-1 0,1,0
transfer-sun-2 1,0,0
transfer-sun-3 0,0,1
table probe position:f64:3 sh:f32:3 sh_error:f32:3 depth:f32:1 \
sh_lamps:f32:3 sh_windows:f32:3 sh_rest:f32:3 \
sh_error_lamps:f32:3 sh_error_windows:f32:3 sh_error_rest:f32:3 \
transfer_sky:f32:12 transfer_sky_error:f32:12 transfer_suns:f32:9 transfer_suns_error:f32:9
1 2 3 7 7 7 .5 .5 .5 9 1 1 1 2 2 2 4 4 4 .3 .3 .3 .4 .4 .4 0 0 0 \
1 1 1 0 0 0 .5 .5 .5 0 0 0 .1 .1 .1 .2 .2 .2 .1 .1 .1 .1 .1 .1 \
1 2 3 4 5 6 7 8 9 .1 .1 .1 .1 .1 .1 .1 .1 .1
END
{
    printf '2 2 2'
    for i in 1 2 3 4 5 6 7; do printf ' nan nan nan nan nan nan nan nan nan nan'; done |
        cut -d ' ' -f 1-68
    printf '%s\n' 'table other thing:i32:1' 5 end
} >>parts.probe

# relit OPTION...: the light of the first probe and its error
relit() { probe-relight -q "$@" parts.probe | sed -n 's/^1 2 3 //p'; }
# is NUMBERS OPTION...
is() {
    echo "$1" >wanted.light
    shift
    relit "$@" >got.light
    near 1e-6 wanted.light got.light
}

# -- weights ---------------------------------------------------------------------------------------
check "without weights all are 1: the plain sum and its error" is '7 7 7 0.5 0.5 0.5 9'
check "a weight multiplies a group" is '4.5 4.5 4.5 0.4272 0.4272 0.4272 9' -w lamps=.5 -w rest=.5
check "channel by channel" is '6 7 8 0.4 0.5 0.72111026 9' -w lamps=0,1,2
check "light is taken away" is '5 5 5 0.5 0.5 0.5 9' --weights lamps=-1
probe-relight parts.probe -w lamps=-1 2>said >out
check "which is said" says said 'group lamps has a weight below 0' \
    'transfer of a sky adds nothing' 'transfer of suns adds nothing'
check "a probe without light stays so" says out '^2 2 2 nan nan nan nan nan nan nan$'
check "other tables pass, parts go" says out '^table other thing:i32:1$' \
    '^table probe position:f64:3 sh:f32:3 sh_error:f32:3 depth:f32:1$'
check "the header names the light" says out '^relit-group-2 windows material=glass$' \
    '^weight-1 -1,-1,-1$' '^weight-3 1,1,1$' '^# made by hand$' '^# probe-relight '
check "and no transfer that is no more" lacks out '^transfer' '^group'
probe-relight -q --keep -w lamps=0 parts.probe | probe-relight -q -w rest=2 - >out
check "--keep keeps the parts, to be weighed anew" says out '^1 2 3 11 11 11 ' '^weight-1 1,1,1$'
refused 1 "(the stream was relit without --keep)" probe-relight -q out

# -- a sky and suns --------------------------------------------------------------------------------
# of the sky 1,2,3 the SH are 1,2,3 / 0.28209479 in function 0, whose answer is 1 and error 0.1
check "a sky of one colour" is '3.5449077 7.0898154 10.634723 0.35449077 0.70898154 1.0634723 9' \
    -w lamps=0 -w windows=0 -w rest=0 --sky 1,2,3
check "--sky-scale" is '7.0898154 7.0898154 7.0898154 0.70898154 0.70898154 0.70898154 9' \
    -w lamps=0 -w windows=0 -w rest=0 --sky 1,1,1 --sky-scale 2
dark="-w lamps=0 -w windows=0 -w rest=0"
check "a sun of the list" is '4 10 18 0.1 0.2 0.3 9' $dark --sun -1,0,0,1,2,3
check "one between two, along their way" is '2.5 3.5 4.5 .1 .1 .1 9' $dark --sun -1,-1,0,1,1,1
check "a third of the way, by the angle" is '2 3 4 .1 .1 .1 9' \
    $dark --sun -.5,-.8660254037844386,0,1,1,1
check "two suns" is '5 7 9 .2 .2 .2 9' $dark --sun -1,0,0,1,1,1 --sun 0,-1,0,1,1,1
check "anywhere on the sphere" is '4 5 6 .1 .1 .1 9' \
    $dark --sun -1,-1,-1,1,1,1 --sun-between sphere
probe-relight $dark --sun -1,-1,-1,1,1,1 parts.probe 2>said >out
check "a sun that is off the way is said" says said 'a sun is 35.3 degrees off'
check "the header has the sun" says out '^relit-sun-1 -0.577350269'
printf '%s\n' '# a day' '' '6 0 0 0 0 0' '12 0 90 2 2 2 # noon' '18 180 0 0 0 0' >day.txt
check "--time: at noon" is '2 4 6 .2 .2 .2 9' $dark --time 12 --sun-path day.txt
printf '%s\n' '0 -90 0 1 1 1' '1 270 0 1 1 1' >azimuth.txt
for i in 0 1; do
    check "an azimuth of -90 is +Z: counter-clockwise from above" \
        is '7 8 9 .1 .1 .1 9' $dark --time $i --sun-path azimuth.txt
done
echo '0 90 0 1 1 1' >azimuth.txt
check "about --sky-up" is '1 2 3 .1 .1 .1 9' \
    $dark --sky-up 0,0,1 --time 0 --sun-path azimuth.txt
check "half of the morning" is '2.5 3.5 4.5 .1 .1 .1 9' $dark --time 9 --sun-path day.txt
refused 2 "expected a time from 6 to 18, which day.txt has, got 5" \
    probe-relight -q --time 5 --sun-path day.txt parts.probe
refused 2 "--time needs --sun-path" probe-relight --time 5 parts.probe
refused 2 "--sun-path needs --time" probe-relight --sun-path day.txt parts.probe
for bad in '1 2 3 4 5' 'noon 0 0 1 1 1' '1 0 91 1 1 1' '1 0 0 1 1 -1'; do
    printf '%s\n' '0 0 0 1 1 1' "$bad" >bad.txt
    refused 1 "bad.txt:2: expected" probe-relight -q --time 0 --sun-path bad.txt parts.probe
done
printf '%s\n' '1 0 0 1 1 1' '1 0 0 1 1 1' >bad.txt
refused 1 "bad.txt:2: expected a time after 1, got 1" \
    probe-relight -q --time 1 --sun-path bad.txt parts.probe

# -- lamps -----------------------------------------------------------------------------------------
printf '%s\n' '1 2 3 9 9 9 1 2 3 4 5 6 7 8 9 .1 .1 .1 .2 .2 .2 .3 .3 .3' |
    stream_of 'sh-order 1' 'sky 0,0,0' 'transfer-point-1 0,0,0' 'transfer-point-2 4,0,0' \
        'transfer-point-3 0,4,0' \
        'table probe position:f64:3 sh:f32:3 transfer_points:f32:9 transfer_points_error:f32:9' \
        >lamps.probe
# lamp POINT LIGHT OPTION...
lamp() {
    echo "$2" >wanted.light
    probe-relight -q -w rest=0 --point "$1" lamps.probe | sed -n 's/^1 2 3 //p' >got.light
    near 1e-6 wanted.light got.light
}
check "a lamp of the stream" lamp 4,0,0,1,2,3 '4 10 18'
check "one between two, by the way between them" lamp 1,0,0,1,1,1 '1.75 2.75 3.75'
check "one between three" lamp 1,1,0,1,1,1 '3.25 4.25 5.25'
probe-relight -w rest=0 --point 4,4,3,1,1,1 lamps.probe 2>said >out
check "one outside is where they end, which is said" says said \
    'point at 4,4,3 is 4.12 outside of those of the transfer' && says out '^1 2 3 5.5 6.5 7.5' \
    '^relit-point-1 4,4,3,1,1,1$'
printf '%s\t%s\n' name --point a 4,0,0,1,1,1 b '' >lamps.tsv
probe-relight -q -w lamps.tsv -w rest=0 --point 0,4,0,1,1,1 -o 'lamp-%s.probe' lamps.probe
check "a row has its lamp, or the command line's" says lamp-a.probe '^1 2 3 4 5 6' and \
    says lamp-b.probe '^1 2 3 7 8 9'
probe-relight lamps.probe 2>said >out
check "no lamp is said" says said 'transfer of points adds nothing: no --point'
refused 1 'there is no transfer of points: expected' \
    probe-relight -q --point 1,2,3,1,1,1 parts.probe
sed 's/^sky 0,0,0$/&\nscene-key 0123456789abcdef/' lamps.probe | probe-cat --rotate 0,0,1,90 \
    >turned.probe
check "points turn with the probes" says turned.probe '^transfer-point-2 [^ ]*,4,0$'

# -- a sky that a probe sees -----------------------------------------------------------------------
echo '0 0 0 1 2 3 4 5 6 0 0 0 0 0 0' |
    stream_of 'sh-order 2' 'table probe position:f64:3 sh:f32:12' >sees.probe
check "the light of a probe is the sky" is '1 2 3 .80622577 1.0198039 1.2369317 9' \
    $dark --sky-probe sees.probe
probe-relight -q --sky-probe sees.probe parts.probe >out
check "the header has its SH" says out '^relit-sky-sh 1,2,3,4,5,6,0,0,0,0,0,0$'
refused 2 "one of --sky and --sky-probe" \
    probe-relight --sky 1,1,1 --sky-probe sees.probe parts.probe
probe-cat --order 1 sees.probe >low.probe
refused 1 "low.probe: expected light of order 2, that of the transfer, or more, got 1" \
    probe-relight -q --sky-probe low.probe parts.probe
probe-cat -q sees.probe sees.probe >two.probe
refused 1 "two.probe: expected one probe, got 2" probe-relight -q --sky-probe two.probe parts.probe
probe-cat --content irradiance sees.probe >convolved.probe
refused 1 "expected radiance, got irradiance" \
    probe-relight -q --sky-probe convolved.probe parts.probe

# -- a table ---------------------------------------------------------------------------------------
printf 'name\tlamps\trest\r\n# comment\n\nevening\t.5\t0\n%s\n' 'night	1,2,3	.1' >rows.tsv
check "a row by its name" is '2.5 2.5 2.5 .4272002 .4272002 .4272002 9' \
    --weights rows.tsv --row evening
check "or its number" is '3.4 4.4 5.4 .5 .72111026 .98488577 9' --weights rows.tsv --row 1
check "a weight of the command line is of all rows" is '5.4 6.4 7.4 .854400 1 1.204159 9' \
    --weights rows.tsv --row night -w windows=2
probe-relight -q -w rows.tsv -o 'at %s.probe' parts.probe
for i in evening night; do
    probe-relight -q -w rows.tsv --row $i parts.probe >one
    check "all rows at once: $i" same_stream one "at $i.probe"
done
printf 'lamps\n1\n2\n' >bare.tsv
probe-relight -q -w bare.tsv -o '%s.probe' parts.probe
check "rows without names have numbers" says 1.probe '^weight-1 2,2,2$' and says 0.probe \
    '^weight-1 1,1,1$'
printf '\357\273\277lamps\n\t\n3\n' >marked.tsv
check "a byte order mark and a line of blanks are let be" \
    is '9 9 9 .98488577 .98488577 .98488577 9' \
    -w marked.tsv
# light of a row: at noon a sky and the sun of the time, at nine none of the first; a sun of its own
printf '%s\n' 'name	--sky	--time	lamps	--sun' 'noon	1,2,3	12	0	' 'nine		9	0	' \
    'own		9	0	-1,0,0,1,1,1' >day.tsv
probe-relight -q -w day.tsv -w windows=0 -w rest=0 --sun-path day.txt -o 'day-%s.probe' parts.probe
light_at() { sed -n 's/^1 2 3 \([^ ]* [^ ]* [^ ]*\) .*/\1/p' "day-$1.probe" >got.light; }
at() {
    light_at "$1"
    echo "$2" >wanted.light
    near 1e-5 wanted.light got.light
}
check "a row has its sky and its time" at noon '5.5449077 11.089815 16.634724' and \
    says day-noon.probe '^relit-sky 1,2,3$' '^relit-sun-1 '
check "an empty cell is the command line's: no sky" at nine '2.5 3.5 4.5' and \
    lacks day-nine.probe '^relit-sky'
check "a sun of its own" at own '6.5 8.5 10.5' and says day-own.probe '^relit-sun-2 '
probe-relight -q -w day.tsv --row own -w windows=0 -w rest=0 --sun-path day.txt \
    --sun 0,-1,0,9,9,9 parts.probe >day-one.probe
check "which takes the place of the command line's" at one '6.5 8.5 10.5'
refused 1 "row 'noon': --time: expected --sun-path beside it" \
    probe-relight -q -w day.tsv -o 'day-%s.probe' parts.probe
printf '%s\n' '--sky' '1,2' 0 >bad.tsv
refused 1 "row '0': --sky: expected 3 finite numbers" \
    probe-relight -q -w bad.tsv -o 'bad-%s.probe' parts.probe
printf 'lamps\tname\n1\t\n2\t\n' >bare.tsv
probe-relight -q -w bare.tsv -o 'bare-%s.probe' parts.probe
check "an empty name is none" says bare-1.probe '^weight-1 2,2,2$'
printf 'name\tlamps\n1\t1\n\t1\n' >both.tsv
refused 1 "rows 0 and 1 are both called '1'" \
    probe-relight -q -w both.tsv -o 'bare-%s.probe' parts.probe
refused 2 "rows.tsv: it is read, and --output would overwrite it" \
    probe-relight -q -w rows.tsv --row 0 -o rows.tsv parts.probe
refused 2 "rows.tsv has 2 rows: expected --row, or --output with %s" \
    probe-relight -q -w rows.tsv parts.probe
printf 'name\tlamps\nparts\t1\n' >own.tsv
refused 2 "parts.probe: it is read" probe-relight -q -w own.tsv -o '%s.probe' parts.probe
awk 'BEGIN { print "name\tlamps"; for (i = 0; i < 40000; i++) print "row " i "\t" i }' >long.tsv
check "a table may have many rows" timeout 20 probe-relight -q -w long.tsv --row 'row 39999' \
    -o long.probe parts.probe
awk 'BEGIN { print "lamps"; for (i = 0; i < 100; i++) print i }' >long.tsv
mkdir many
(ulimit -S -n 64 && probe-relight -q -w long.tsv -o 'many/%s.probe' parts.probe)
check "with a file each, beyond the limit of open files" says many/99.probe '^weight-1 99,99,99$'
(ulimit -n 64 && ! probe-relight -q -w long.tsv -o 'none/%s.probe' parts.probe 2>said)
check "or it is said how many may be" says said \
    'long.tsv: 100 files at once are more than may be open: expected at most 32'
refused 2 "expected one %s" probe-relight -q -w rows.tsv -o '%s%s' parts.probe
refused 2 "expected the name of a row, or a number below 2, got 'noon'" \
    probe-relight -q -w rows.tsv --row noon parts.probe
refused 2 "--row needs a table" probe-relight --row 1 parts.probe
# bad TEXT MESSAGE: a table of these lines
bad() {
    printf "$1" >bad.tsv
    refused 1 "$2" probe-relight -q -w bad.tsv -o '%s.probe' parts.probe
}
bad 'name\tlamps\na\t1\t2\n' "bad.tsv:2: expected 2 cells, as the first line has, got 3"
bad 'name\tlamps\trest\na\t1\n' "bad.tsv:2: expected 3 cells, as the first line has, got 2"
bad 'lamp\n1\n' "bad.tsv:1: there is no group 'lamp': expected one of lamps, windows, rest"
bad 'lamps\nbright\n' "bad.tsv:2: group lamps: expected a finite number, or three as R,G,B"
bad 'lamps\nnan\n' "got 'nan'"
bad 'lamps\n1,2\n' "got '1,2'"
bad 'lamps\n' "bad.tsv: expected a line of groups and one a row of weights, got no row"
bad 'lamps\tlamps\n1\t1\n' "bad.tsv:1: column 'lamps' stands twice"
bad 'name\tlamps\na\t1\na\t2\n' "bad.tsv:3: there is a row 'a' already"
bad 'name\tlamps\na/b\t1\n' "expected a name that a file can have"
refused 2 "there is no group 'lamp': expected one of lamps, windows, rest" \
    probe-relight -w lamp=1 parts.probe
refused 2 "expected a finite number" probe-relight -w lamps=inf parts.probe
refused 2 "expected one table" probe-relight -w rows.tsv -w bad.tsv parts.probe

# -- what cannot be relit --------------------------------------------------------------------------
sed -e '/^group/d' -e '/^transfer/d' parts.probe >plain.probe
refused 1 "there is nothing to relight" probe-relight plain.probe
sed -e '/^transfer/d' parts.probe >groups.probe
refused 1 "no transfer of a sky" probe-relight -q --sky 1,1,1 groups.probe
refused 1 "no transfer of suns" probe-relight -q --sun 1,0,0,1,1,1 groups.probe
sed -e 's/^sh-order 1/&\nsh-dering radiance 0/' parts.probe >derung.probe
refused 1 "was de-rung" probe-relight -q derung.probe
sed -e 's/ sh_rest:f32:3/ sh_other:f32:3/' parts.probe >missing.probe
refused 1 "column sh_rest: the header names it, there is none" probe-relight -q missing.probe
sed -e 's/^sky 0,0,0/sky 1,1,1/' parts.probe >sky.probe
refused 1 "group rest has the sky of the capture, which --sky replaces" \
    probe-relight -q --sky 2,2,2 sky.probe
check "with weight 0 it may" probe-relight -q --sky 2,2,2 -w rest=0 -o out sky.probe
sed -e 's/^group-2.*/group-2 windows sky/' sky.probe >own.probe
probe-relight --sky 0,0,0 own.probe >out 2>said
check "a sky that is a group gives way" says out '^weight-2 0,0,0$' '^relit-sky 0,0,0$' \
    '^1 2 3 5 5 5 ' and says said 'group windows, the sky of the capture, gives way to --sky'

# -- without groups, the light is one --------------------------------------------------------------
sed -e '/^group/d' parts.probe >whole.probe
probe-relight -q -w rest=2 --sun 0,-1,0,1,1,1 whole.probe >out
check "a transfer beside plain light" says out '^1 2 3 15 16 17 ' '^relit-group-1 rest$' \
    '^weight-1 2,2,2$'
refused 1 "--keep needs groups" probe-relight -q --keep whole.probe

# -- many probes, in blocks and on threads ---------------------------------------------------------
awk 'BEGIN {
    print "#?probe 1\ngroup-1 a emissive\ngroup-2 rest"
    print "table probe position:f64:3 sh_a:f32:3 sh_rest:f32:3"
    for (i = 0; i < 9000; i++) print i, 0, 0, i % 7, i % 11, 1, i % 5, 2, i % 3
    print "end"
}' | probe-cat --binary >many.probe
probe-relight -q -j 1 -w a=2 -w rest=1,10,100 many.probe >one.probe
probe-relight -q -j 3 -w a=2 -w rest=1,10,100 many.probe >three.probe
check "the same bytes with one thread and with three" cmp one.probe three.probe
probe-cat --text --columns position,sh one.probe | numbers >sums
check "every probe has its sum" every '$4 == 2 * ($1 % 7) + $1 % 5 && $5 == 2 * ($1 % 11) + 20 &&
    $6 == 2 + 100 * ($1 % 3)' sums and has_lines 9000 sums

# -- surfaces --------------------------------------------------------------------------------------
sed -e 's/ sh\([:_]\)/ irradiance\1/g' -e '/^sh-order/d' -e 's/depth:f32:1/& normal:f32:3/' \
    -e 's/^\(1 2 3 7 7 7 .5 .5 .5 9\)/\1 0 1 0/' -e 's/^2 2 2/& nan nan nan/' parts.probe \
    >surface.probe
probe-relight -q -w lamps=0 --sky 1,2,3 surface.probe >out
check "irradiance of surfaces" says out 'irradiance:f32:3 irradiance_error:f32:3' \
    '^1 2 3 9.544908 13.089815 16.634724 '

# An object that is turned, and a sky that is turned the other way round, are one.
echo '0 0 0 3 3 3 1 .2 .3 -.4 .5 .6 .7 -.8 .9' |
    stream_of 'sh-order 2' 'table probe position:f64:3 sh:f32:12' >sees.probe
probe-cat --rotate 1,2,3,50 surface.probe >turned.probe
probe-relight -q --sky-probe sees.probe turned.probe | probe-cat --text --columns \
    position,irradiance | numbers | cut -d ' ' -f 4- >turned.light
probe-cat --rotate-light 1,2,3,-50 sees.probe >other.probe
probe-relight -q --sky-probe other.probe surface.probe | probe-cat --text --columns \
    position,irradiance | numbers | cut -d ' ' -f 4- >other.light
probe-relight -q --sky-probe sees.probe surface.probe | probe-cat --text --columns \
    position,irradiance | numbers | cut -d ' ' -f 4- >plain.light
head -n 1 turned.light >a
head -n 1 other.light >b
head -n 1 plain.light >c
check "an object that is turned has the light that is turned back" near 1e-5 a b and \
    not near 1e-2 a c
sed -e 's/^#?probe 1/&\nscene-key 0123456789abcdef/' surface.probe | probe-cat --rotate 1,0,0,9 \
    >turned.probe
refused 1 "the probes were turned (key rotated or rotated-light)" \
    probe-relight -q --sky 1,1,1 turned.probe
check "weights do not mind" probe-relight -q -w lamps=0 --sky-probe sees.probe -o out turned.probe

# -- compression -----------------------------------------------------------------------------------
# Two groups, a sky of order 2 and two suns, of four unlike sorts of probes; one without light.
awk 'BEGIN {
    print "#?probe 1\nsh-order 1\nsky 0,0,0\ngroup-1 a emissive\ngroup-2 rest\ntransfer-sky 2"
    print "transfer-sun-1 0,1,0\ntransfer-sun-2 1,0,0"
    print "table probe position:f64:3 sh:f32:3 sh_error:f32:3 sh_a:f32:3 sh_error_a:f32:3" \
        " sh_rest:f32:3 sh_error_rest:f32:3 transfer_sky:f32:12 transfer_suns:f32:6"
    for (i = 0; i < 200; i++) {
        printf "%d %d %d 5 5 5 .1 .1 .1", i % 6, int(i / 6) % 6, int(i / 36)
        for (k = 0; k < 30; k++)
            printf " %s", (i == 17 ? "nan" : int(k / 3) % 2 && k < 12 ? .1 : \
                k * k * (1 + i % 4) % 11 + sin(i * .1) * (k * (2 + i % 4) % 7) + \
                .1 * cos(i * k * k))
        print ""
    }
    print "end"
}' >alike.probe
light() { # OPTION... STREAM: what there is at each probe
    probe-relight -q --text --sky 1,2,3 --sun -1,-1,0,2,1,1 -w a=.5,1,2 "$@" |
        awk '/^table/ { on = $2 == "probe" } on && /^[0-9]/ { print $1, $2, $3, $4, $5, $6 }'
}
light alike.probe >plain.light
probe-relight --compress 24 alike.probe >small.probe
light small.probe >small.light
check "as many vectors as numbers lose nothing" every 'NF == 6' small.light and \
    near 2e-4 plain.light small.light
probe-relight -j 3 --compress 8 --clusters 4 alike.probe >small.probe
light small.probe >small.light
check "few lose little" near 3 plain.light small.light and not near 1e-4 plain.light small.light
# share A B: the RMS of what differs, as a share of A
share() { paste -d ' ' "$1" "$2" | awk '$4 != "nan" { for (i = 4; i < 7; i++) {
        d += ($i - $(6 + i)) ^ 2; s += $i ^ 2 } } END { print sqrt(d / s) }'; }
lost=$(sed -n 's/^pca-error //p' small.probe)
check "the header says how much: $lost, and here $(share plain.light small.light)" \
    given "$lost $(share plain.light small.light)" every '$1 > 1e-5 && $1 < .05 && $2 < 4 * $1'
check "parts and their errors go, light stays" says small.probe \
    '^table basis sh_a:f32:3 sh_rest:f32:3 transfer_sky:f32:12 transfer_suns:f32:6$' \
    '^table probe position:f64:3 sh:f32:3 sh_error:f32:3 pca:f32:8 pca_cluster:i32:1$' \
    '^5 2 0 5 5 5 .* nan nan nan nan nan nan nan nan -1$'
probe-relight -q --sky 1,2,3 small.probe >out
check "what was lost stays in the header, the basis does not" says out "^relit-pca-error $lost\$" \
    '^5 2 0 nan nan nan$' and lacks out '^pca' '^table basis' '^transfer' '^group'
probe-relight -j 1 --compress 8 --clusters 4 alike.probe >one.probe
check "the same bytes with one thread and with three" cmp one.probe small.probe
probe-relight --compress table alike.probe >table
probe-relight --compress table --clusters 4 alike.probe >clusters
check "a table: the more vectors, the less is lost" says table \
    '^# 199 probes of 24 numbers, 19104 bytes$' \
    '^vectors	clusters	bytes	all	sh_a	sh_rest	transfer_sky	transfer_suns$' and \
    awk 'NR > 3 && $4 >= last { exit 1 } { last = $4 }' table and has_lines 7 table
paste table clusters | sed 1,2d | cut -f 4,12 >both
check "and with clusters less" every '$2 < $1' both and says clusters "	$(printf %.6g "$lost")	"
probe-tet -q small.probe | probe-relight -q --keep -w a=0 - | light - >again.light
check "--keep keeps them, cells come beside" cmp small.light again.light
probe-cat --rows 100: small.probe | light - >some.light
tail -n +101 small.light >tail.light
check "some probes" cmp tail.light some.light
probe-cat --rows :100 small.probe | probe-cat - one.probe --output twice.probe
light twice.probe >twice.light
check "streams of one basis are merged" has_lines 300 twice.light
probe-relight --compress 8 alike.probe >other.probe
refused 1 "pca-basis is" probe-cat small.probe other.probe
refused 1 "the first has none" probe-cat alike.probe small.probe
probe-cat --content irradiance small.probe >changed.probe
refused 1 "or their light was changed after it was compressed" probe-relight -q changed.probe
refused 1 "groups and transfers are compressed" probe-cat --rotate 0,1,0,30 small.probe
sed '/^table basis/,/^table probe/{/^table probe/!d;}' small.probe >bare.probe
refused 1 "expected a table basis before table probe, there is none" probe-relight -q bare.probe
sed 's/ 3$/ 4/' small.probe >wrong.probe
refused 1 "column pca_cluster: expected 0 to 3 where pca is known, got 4" \
    probe-relight -q wrong.probe
refused 1 "the stream is compressed (key pca-basis)" probe-relight --compress 2 small.probe
refused 1 "expected at most 24 vectors in each of 1 clusters of 199 probes with light" \
    probe-relight --compress 25 alike.probe
refused 1 "there is nothing to relight" probe-relight --compress 2 plain.probe
for i in 0 2x; do
    refused 2 "expected 1 to 128 vectors, or table, got '$i'" \
        probe-relight --compress "$i" alike.probe
done
refused 2 "--clusters needs --compress" probe-relight --clusters 2 alike.probe
refused 2 "--compress does not relight: expected no --sky" \
    probe-relight --compress 2 --sky 1,1,1 alike.probe
refused 2 "expected no --output" probe-relight --compress table -o out alike.probe
sed -e '/^group/d' alike.probe | probe-relight --compress 8 >one.probe
check "without groups, transfers alone" says one.probe \
    '^table basis transfer_sky:f32:12 transfer_suns:f32:6$' and \
    probe-relight -q -w rest=2 one.probe
sed -e 's/ sh\([:_]\)/ irradiance\1/g' -e '/^sh-order/d' alike.probe | probe-relight --compress 24 |
    light - >surface.light
check "irradiance of surfaces" near 2e-4 plain.light surface.light

# -- the truth of relit light ----------------------------------------------------------------------
# Points without bounces are exact: what is traced for the header of relit light is that light.
printf 'v %s\n' '-9 0 -9' '9 0 -9' '0 0 9' '9 9 9' >floor.obj
echo 'f 1 3 2' >>floor.obj
printf '%s\n' '1 1 1' '2 .5 .3' '.5 2 3' '0 1 0' '1 2 3' | stream_of 'table probe position:f64:3' |
    probe-tet -q >placed.probe
lamps="--point 3,2,1,1,2,3 --point -2,3,1,5,5,2"
direct() { probe-capture -q --rays 16 --light direct --text "$@" floor.obj placed.probe; }
direct $lamps >both.probe
echo 'key: point-1' >groups.txt
direct $lamps --groups groups.txt >parts.probe
probe-relight -q --text -w key=2,1,.5 -w rest=.25 parts.probe >dim.probe
probe-capture -q --text --again floor.obj dim.probe >again.probe
probe-cat --columns position,sh dim.probe | numbers >relit
probe-cat --columns position,sh again.probe | numbers >traced
sed -e 's/^sh-order 3/&\nrelit-sky-sh 1,1,1/' dim.probe >sky.probe
refused 1 "relit with the SH of a sky (key relit-sky-sh), which no scene has" \
    probe-error -q --points 3 --paths 0 floor.obj sky.probe
check "captured anew in the light of its header, it is the same" near 2e-5 relit traced
check "which stays there" says again.probe '^weight-1 2,1,0.5$'
probe-cat --columns position,sh both.probe | numbers >was
check "and is other light" not near .1 relit was
probe-error -q --points 30 --paths 0 --truth dim.truth floor.obj dim.probe >dim.report
probe-error -q --points 30 --paths 0 floor.obj both.probe >both.report
probe-error -q --points 30 --paths 0 --truth dim.truth floor.obj dim.probe >again.report
check "probe-error measures against the light of the header" not cmp -s dim.report both.report
probe-relight -q -w key=0 parts.probe >other.probe
refused 1 "this truth is of other light than the stream was relit with" \
    probe-error -q --points 30 --paths 0 --truth dim.truth floor.obj other.probe
probe-render -q --size 8x8 --samples 4 --mode truth --eye 0,5,0.1 --look-at 0,0,0 -o dim.pfm \
    floor.obj dim.probe
probe-render -q --size 8x8 --samples 4 --mode truth --eye 0,5,0.1 --look-at 0,0,0 -o both.pfm \
    floor.obj both.probe
check "probe-render, too" not cmp -s dim.pfm both.pfm
refused 1 "the stream was relit, and its header names that light" \
    probe-capture -q --again --sky 1,1,1 floor.obj dim.probe
probe-relight -q -w key=-1 parts.probe >dim.probe
refused 1 "light below 0 (key weight-1), which cannot be traced" \
    probe-capture -q --again floor.obj dim.probe
echo '1 1.2 1' >at.txt
check "probe-query looks by rays all the same" \
    probe-query -q --visible rays --scene floor.obj dim.probe at.txt
probe-relight -q --keep -w key=2 parts.probe >kept.probe
refused 1 "groups and transfers are of light as it is captured" \
    probe-capture -q --again floor.obj kept.probe
probe-relight -q --compress 2 parts.probe >kept.small
refused 1 "groups and transfers are compressed (key pca-basis)" \
    probe-capture -q --again floor.obj kept.small
probe-leakfix --probes 10 floor.obj kept.probe 2>said >/dev/null
check "probe-leakfix says that new probes have no parts" says said 'and keeps the parts'

# -- against a capture -----------------------------------------------------------------------------
# z A B: the RMS of differences over their standard error, of all coefficients; and how many
cat >z.awk <<'AWK'
{
    n = (NF - 6) / 4 # of each stream: a place, light, its error
    for (i = 1; i <= n; i++) {
        s = $(3 + n + i) ^ 2 + $(6 + 3 * n + i) ^ 2
        if (s > 1e-20) {
            sum += ($(3 + i) - $(6 + 2 * n + i)) ^ 2 / s
            count++
        }
    }
}
END { printf "%.3f %d\n", sqrt(sum / count), count }
AWK
light_of() { probe-cat --text --tables probe --columns position,sh,sh_error "$1" | numbers; }
z() {
    light_of "$1" >z.a
    light_of "$2" >z.b
    paste -d ' ' z.a z.b | awk -f z.awk
}
if plain_build "relit light is that of a capture"; then
    box=$SRC/scenes/cornell-box.obj
    printf '%s\n' '0 0.5 1' '0.4 0.3 1' >suns.txt
    probe-place grid -q --count 60 "$box" | probe-capture -q --rays 512 --columns sh_error \
        --point 150,400,100,90000,30000,30000 --groups each --transfer sky:2 \
        --transfer suns:suns.txt "$box" >parts.probe
    while read -r how; do
        probe-relight -q $how parts.probe >relit.probe
        probe-capture -q --again --seed 7 "$box" relit.probe >full.probe
        z relit.probe full.probe >rms
        check "as a capture, within its error: ${how:-as it was} ($(cat rms))" \
            every '$1 > .75 && $1 < 1.05 && $2 > 900' rms
    done <<'END'

-w lamp=.2 -w point-1=3,0,1
-w lamp=0 -w point-1=0 --sky .3,.5,1
-w lamp=.1 --sky 1,1,1 --sun -.4,-.3,-1,9,5,1
END
fi
tap_done
