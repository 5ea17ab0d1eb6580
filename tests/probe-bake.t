#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-bake as users run it: what it writes is what its pipe writes, its report is what the
# programs say that it names, and nothing is left of a run that fails or is stopped.
. "${SRC:?}/tests/support/setup.sh"
box=$SRC/scenes/cornell-box.obj
mkdir temporary
TMPDIR=$PWD/temporary
export TMPDIR

nothing_left() { [ -z "$(ls -A temporary)" ]; }
# figure NAME: of the report, as it stands
figure() { sed -n "s/^  $1  *\([0-9.]*\)\( .*\)*$/\1/p" report | head -n 1; }
# percent MEASURE OF: probe-error's figure
percent() { awk -v m="$1" -v of="$2" '$1 == m && $2 == of { printf "%.1f\n", 100 * $3 }' figures; }

# -- a bake ----------------------------------------------------------------------------------------
# the whole way, of a box; and of a scene without light and volume, which is a grid's, and cheap
printf '%s\n' 'v 0 0 0' 'v 1 0 0' 'v 0 0 1' 'v 1 0 1' 'f 1 3 2' 'f 2 3 4' >floor.obj
scene=$box
sanitized && scene=floor.obj
usual="--quality draft --probes 20 --rays 16"
probe-bake -q --report none $usual -j3 --pack packed "$scene" >whole.probe 2>said
check "it bakes to standard output, without a word" test -s whole.probe and nothing_left \
    and empty said
probe-bake --dry-run $usual --pack packed.again "$scene" -o baked.probe >pipe
check "--dry-run prints the pipe alone" has_lines 5 pipe and test ! -e baked.probe \
    and says pipe '^probe-place .* |$' '^    probe-leakfix --output baked.probe ' \
    '^probe-query .*--output packed.again baked.probe$'
sh pipe 2>/dev/null
check "pasted it gives the same bytes, on any number of threads, packed too" \
    cmp whole.probe baked.probe and cmp packed packed.again
probe-bake --dry-run --pack packed.again floor.obj >pipe 2>said
check "where the stream goes elsewhere, packing is a comment" has_lines 5 pipe and sh -n pipe \
    and says pipe '^# probe-query .*--output packed.again BAKED'
probe-bake --dry-run --max-error 5% floor.obj >pipe 2>said
check "a grid takes no --max-error, which is said" says said 'a grid, which --max-error says noth' \
    and lacks pipe 'max-error'
probe-bake --dry-run --cache auto --cache-error 5% floor.obj >pipe 2>said
check "a cache is capture's; the header tells leakfix" \
    says pipe 'probe-capture.*--cache auto --cache-error 5%' and lacks pipe 'leakfix.*--cache'
probe-bake --dry-run --cache old.cache --cache-renew floor.obj >pipe 2>said
check "but not whether it is renewed" says pipe 'leakfix.*--cache-renew'
refused 2 "--cache-renew needs --cache FILE" probe-bake --dry-run --cache-renew floor.obj
refused 2 "--cache: expected no --groups beside it" \
    probe-bake --dry-run --cache auto --groups each floor.obj
cp floor.obj old.cache
refused 2 "old.cache" probe-bake --dry-run --cache old.cache floor.obj -o old.cache
rm old.cache

probe-bake --quality draft --probes 60 -j1 floor.obj -o floor.probe >report 2>said
check "a report, the same in a file, and two pictures" says report '^probe-bake: floor.probe$' \
    and cmp report floor.report/report.txt and test -s floor.report/light.png \
    and test -s floor.report/probes.png and nothing_left
check "a scene without light is baked by day, and says so" \
    says said 'no light.*by day.*--sky.*--sun' 'probe-capture.*--sky.*--sun' \
    and says report '^  - the scene has no light'
sed -n '/^the pipe/,/^$/s/^  //p' report >shown
probe-bake -q --dry-run --quality draft --probes 60 floor.obj -o floor.probe >pipe
check "the pipe is in the report" diff pipe shown
grep '^  probe-error' report >commands
sh commands >figures 2>/dev/null
check "the report's error is what its command says" [ "$(figure error)" = "$(percent error all)" ] \
    and [ "$(figure bad)" = "$(percent bad all)" ] \
    and [ "$(figure leaks)" = "$(percent leak_light all)" ] \
    and [ "$(figure 'not mended')" = "$(percent leak_light all-probes)" ] and test -s figures
check "its counts are the stream's" [ "$(figure probes)" = "$(row_count probe floor.probe)" ] \
    and [ "$(figure cells)" = "$(row_count tet floor.probe)" ] \
    and [ "$(figure bytes)" = "$(wc -c <floor.probe)" ]
check "of the scene" says report '^  triangles  *2$' '^  lights  *1 sun, a sky$'

# -- options go where they belong, and are quoted --------------------------------------------------
cp "$box" "it's a box.obj"
probe-bake --dry-run --quality draft --text --sun 0,-1,0,1,1,1 --exclude 'short*' --bounces 3 \
    --light indirect "it's a box.obj" -o 'a b' >dry
check "quoting" says dry "'it'.''s a box.obj'" "--output 'a b'" "--exclude 'short\*'" \
    and sh -n dry
check "light goes to who looks at it, the choice to who reads first" \
    [ "$(grep -c -- '--sun' dry)" = 2 ] and [ "$(grep -c -- '--exclude' dry)" = 1 ] \
    and says dry 'probe-capture.*--light indirect' 'probe-leakfix.*--text'
probe-bake --dry-run --max-error 10% --sun 0,-1,0,1,1,1 "$box" >dry
check "--max-error takes the place of the number of probes" \
    says dry 'probe-place adaptive .*--max-error 10%.*--sun' and lacks dry '--probes'

probe-bake --dry-run --reach start.txt --fly --radius .2 "$box" >dry
check "--reach and its body are of placing" \
    says dry "probe-place .*--reach start.txt --fly --radius .2" \
    and [ "$(grep -c -- '--reach' dry)" = 1 ]
echo .5 .5 .5 >start.txt
probe-bake -q --dry-run --reach start.txt --radius .1 "$box" -o x.probe >pipe
check "a body goes to placing" says pipe '--reach start.txt --radius .1'
refused 2 "--fly goes with --reach" probe-bake --fly "$box"

# under other names it runs programs of such names
mkdir named
cp "$BUILD/src/probe-bake" named/my-probe-bake-2
for name in place capture tet leakfix; do printf '#!/bin/sh\n' >named/my-probe-$name-2; done
chmod +x named/*
named/my-probe-bake-2 --dry-run "$box" >dry
check "under other names it runs others so named" \
    says dry '^my-probe-place-2 ' ' my-probe-capture-2 ' ' my-probe-tet-2 ' ' my-probe-leakfix-2 '

# a report speaks of its own bake alone
cat >named/writes <<'END'
#!/bin/sh
while [ $# -gt 1 ]; do
    [ "$1" != --output ] || cp floor.probe "$2"
    shift
done
END
chmod +x named/writes
for name in leakfix query render; do cp named/writes named/my-probe-$name-2; done
cat >named/my-probe-error-2 <<'END'
#!/bin/sh
printf 'error\tall\t0.253\t0.236\t0.27\n'
END
chmod +x named/*
named/my-probe-bake-2 -q --max-error 10% "$box" -o named.probe >report
check "what --max-error asks for and is not reached is said, with the best that was" \
    says report 'max-error 10 % was not reached, the best is 25.3 %' 'did not lower it' \
    and cmp report named.report/report.txt and lacks report '^  leaks' '^  flip'
refused 1 "stdout: No space left" sh -c 'named/my-probe-bake-2 -q "$1" -o named.probe >/dev/full' \
    - "$box"
check "a report that nobody hears is in its file" test -s named.report/report.txt
printf '#!/bin/sh\nexit 1\n' >named/my-probe-error-2
refused 1 "named.probe is whole, its report is not: probe-error failed" \
    named/my-probe-bake-2 -q "$box" -o named.probe
check "an old report goes with its bake" cmp named.probe floor.probe \
    and [ -z "$(ls -A named.report)" ]

# -- bad input -------------------------------------------------------------------------------------
refused 1 "none of --sky" probe-bake --sky 0,0,0 floor.obj -o dark.probe
check "nothing is written" test ! -e dark.probe -a ! -e dark.report
refused 2 "got 0 operands" probe-bake -o x.probe
refused 2 "report: expected a folder's name" probe-bake --report '' "$box" -o x.probe
refused 2 "output: expected a file's name" probe-bake "$box" -o ''
refused 2 "unexpected operand" probe-bake "$box" "$box" -o x.probe
refused 2 "SCENE cannot be standard input" probe-bake - -o x.probe
refused 2 "reach cannot be standard input" probe-bake --reach /dev/stdin "$box" -o x.probe
mkfifo fifo
refused 2 "SCENE: fifo: expected a file" probe-bake fifo -o x.probe
refused 2 "reach: fifo: expected a file" probe-bake --reach fifo "$box" -o x.probe
refused 2 "fifo: expected a file" probe-bake --sky fifo "$box" -o x.probe
refused 1 "nowhere.obj" probe-bake nowhere.obj -o x.probe
refused 2 "--quality: expected one of draft, good, best" probe-bake --quality fast "$box"
refused 2 "--max-error: expected" probe-bake --max-error 0 "$box"
refused 2 "are the same file" probe-bake --pack x.probe "$box" -o x.probe
refused 1 "no/such: No such file" probe-bake "$box" -o no/such
refused 1 "no/such: No such file" probe-bake --pack no/such "$box" -o x.probe
refused 2 "same file" probe-bake --report x.probe "$box" -o x.probe
refused 1 "no/such: No such file" probe-bake --report no/such "$box" -o x.probe
printf '%s\n' 'v 0 0 0' 'v 1 0 0' 'v 1 1 0' 'v 0 1 0' 'v 0 0 1' 'v 1 0 1' 'v 1 1 1' 'v 0 1 1' \
    'f 4 3 2 1' 'f 5 6 7 8' 'f 1 2 6 5' 'f 8 7 3 4' 'f 5 8 4 1' 'f 2 3 7 6' >solid.obj
refused 1 "points of the box are in free space" probe-bake -q --quality draft solid.obj -o x.probe
sed 's/f \(.\) \(.\) \(.\) \(.\)/f \4 \3 \2 \1/' solid.obj >closed.obj
refused 1 "no light reaches the free space" probe-bake -q --quality draft closed.obj -o x.probe
check "who fails is named, and no other program complains" has_lines 2 refused.err \
    and says refused.err '^probe-bake: probe-place failed with status 1$'
check "of these nothing is left" test ! -e x.probe -a ! -e x.report and nothing_left
refused 1 "No space left" probe-bake -q --quality draft --probes 40 floor.obj -o /dev/full
{
    probe-bake -q --quality draft --probes 40 floor.obj 2>said
    echo $? >status
} | true
check "a closed pipe ends it quietly" empty said and [ "$(cat status)" -ne 0 ] and nothing_left
mkfifo unheard
exec 3<>unheard 4>unheard 3<&-
timeout 60 probe-bake --sky 1,1,1 $usual --report none floor.obj -o x.probe 2>&4
status=$?
exec 4>&-
check "whose standard error has nobody to read it dies, and all others with it" [ $status -eq 1 ] \
    and test ! -e x.probe and nothing_left

probe-bake --quality draft --probes 40 --rays 16 floor.obj >heard.probe 2>said
status=$?
probe-bake --quality draft --probes 40 --rays 16 floor.obj <&- 2>&- >unheard.probe
check "nor does it need standard input or error" [ $? -eq 0 ] and [ $status -eq 0 ] \
    and cmp heard.probe unheard.probe and says said '^  error '

# -- stopped ---------------------------------------------------------------------------------------
children_of() { cat "/proc/$1/task/$1/children"; }
begun() { [ -e "$(echo temporary/probe-bake-*/figures)" ] && [ -n "$(children_of $pid)" ]; }
probe-bake -q --quality best --rays 1000000 "$box" -o x.probe &
pid=$!
wait_for begun
children=$(children_of $pid)
kill -TERM $pid
wait $pid 2>said
status=$?
gone() { for child in $children; do ! kill -0 "$child" 2>/dev/null || return; done; }
check "a signal ends it and its programs" [ $status -eq 143 ] and test -n "$children" and gone
check "and nothing is left" test ! -e x.probe -a ! -e x.report and nothing_left
# cut SIGNAL...: a bake that goes on until it is cut short, after the first probes, nohup or not
cut() {
    rm -f x.probe
    env --default-signal=HUP probe-bake --quality draft --max-error .1% "$box" -o x.probe 2>said &
    pid=$!
    wait_for grep -q 'held out' said
    for signal; do kill -"$signal" $pid; done
    wait $pid 2>died
    status=$?
}
cut TERM TERM
check "while probes are placed, those until then are baked, as timeout(1) sends it" \
    [ $status -eq 1 ] and \
    says said 'interrupted: x.probe is whole, with the probes until then; it is not measured' \
    and [ "$(row_count tet x.probe)" -gt 0 ] and nothing_left and test ! -e x.report
check "which the stream says" says x.probe '^place-interrupted yes$'
cut TERM HUP
check "and another signal ends it at once" [ $status -gt 128 ] and test ! -e x.probe \
    and nothing_left and says said 'nothing is written: interrupted'

tap_done
