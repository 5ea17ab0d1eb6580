#!/bin/sh
# probe-cat as people run it: converting keeps every bit, selections and merges do what they say, output
# appears whole or not at all, and whatever goes wrong is said and makes the status non-zero.
. "${SRC:?}/tests/setup.sh"

cat >small.probe <<'END'
#?probe 1
# probe-place points some.txt
sh-order 1
sh-content radiance
somebody-else any value: "yes"
table probe position:f64:3 sh:f32:3 validity:f32:1 their_column:i32:2
0 0 0 0.1 0.2 0.3 1 1 -1
1 0 0 nan nan nan nan 2 -2
0 1 0 -0 1e-40 3e+38 0.5 3 -3
0 0 1.7976931348623157e+308 7 8 9 0.1 4 -4
5e-324 -0 0.1 0.1 0.1 0.1 1 5 2147483647
table tet vertex:i32:4 neighbour:i32:4
0 1 2 3 -1 -1 -1 1
1 2 3 4 0 -1 -1 -1
table their_table thing:f64:1
42
end
END

# rows FILE: a stream as text without its history
rows() { probe-cat --text "$@" | grep -v '^# '; }
# same EXPECTED COMMAND...: the command prints the same text as file EXPECTED holds
same() { expected=$1; shift; "$@" | cmp - "$expected"; }
# table NAME FILE: the rows of one table
table() { sed -n "/^table $1 /,/^[te]/p" "$2" | grep -v '^[te]'; }
# wait_for COMMAND...: until it succeeds, ten seconds at most
wait_for() {
    wait_left=100
    until "$@"; do
        wait_left=$((wait_left - 1))
        [ $wait_left -gt 0 ] || return 1
        sleep .1
    done
}

# -- converting --------------------------------------------------------------------------------------
grep -v '^# ' small.probe >small.rows
probe-cat --binary small.probe >small.binary
check "binary is binary" sh -c "head -n 1 small.binary | grep -qx '#?probe 1 binary'"
check "text, binary, text: the same rows, keys and tables" same small.rows rows small.binary
check "the encoding stays unless told otherwise" sh -c "probe-cat <small.binary | head -n 1 | grep -q binary"
check "each run adds its command line, the oldest first" sh -c "
    probe-cat --binary <small.probe | probe-cat --text --rows 0:5 | sed -n 2,4p | tr '\n' / |
    grep -qx '# probe-place points some.txt/# probe-cat/# probe-cat --rows 0:5/'"
check "--no-provenance writes none" sh -c "probe-cat --no-provenance small.probe | cmp - small.rows"
sed 's/$/\r/' small.probe >small.crlf
check "lines may end in CRLF" same small.rows rows small.crlf
probe-cat -o out.probe small.probe
check "-o writes the file" same small.rows rows out.probe
check "and leaves nothing else" sh -c "! ls -A | grep '^\.probe'"

# -- selecting ---------------------------------------------------------------------------------------
probe-cat --tables probe --columns position,validity --text small.probe >picked
check "--tables, --columns: only these are left" sh -c "
    grep -q '^table probe position:f64:3 validity:f32:1$' picked && ! grep -q tet picked"
probe-cat --drop sh,their_column --text small.probe >dropped
check "--drop: all but these are left" sh -c "
    grep -q '^table probe position:f64:3 validity:f32:1$' dropped && grep -q '^table tet' dropped"
refused 1 "the stream has no column validty" probe-cat --columns position,validty small.probe
refused 1 "the stream has no table tets" probe-cat --tables probe,tets small.probe
refused 1 "the stream has no column validty" probe-cat --columns position,validty --rows 0 small.probe
refused 1 "expected a column position:f64:3, there is none" probe-cat --drop position small.probe
refused 1 "table tet has 2 rows, but there are no probes" probe-cat --tables tet small.probe

# picks OPTIONS NUMBERS: the probes whose their_column[0] is in NUMBERS are left
picks() {
    eval "probe-cat --quiet --text $1 small.probe" >picks.out
    picks_got=$(table probe picks.out | cut -d ' ' -f 8 | paste -s -d ' ' -)
    if [ "$picks_got" = "$2" ]; then pass "$1 keeps probes '$2'"; else fail "$1 keeps probes '$2'" "$picks_got"; fi
}
picks "--rows 1:3" "2 3"
picks "--rows :2" "1 2"
picks "--rows 3:" "4 5"
picks "--rows ::2" "1 3 5"
picks "--rows 1:5:3" "2 5"
picks "--rows 4" "5"
picks "--rows 7:9" ""
picks "--captured" "1 3 4 5"
picks "--uncaptured" "2"
picks "--where 'validity < 0.9'" "3 4"
picks "--where 'validity = 0.1'" "4"
picks "--where 'validity != 1'" "3 4"
picks "--where 'position[2]>=0.1'" "4 5"
picks "--where 'their_column[1] == 2147483647'" "5"
picks "--where 'their_column[0] > 1' --where 'their_column[0] <= 4' --captured" "3 4"
picks "--rows 1: --where 'validity > 0.2'" "3 5"
probe-cat --text --rows 0:4 small.probe >four 2>four.err
check "where probes go, cells go, with a warning" sh -c "
    ! grep -q '^table tet' four && grep -q 'probe-cat: warning: table tet' four.err"
check "where none go, cells stay" sh -c "probe-cat --text --rows 0:5 small.probe | grep -q '^table tet'"
for rows in a 1:2:3:4 1:2:0 -1:2 99999999999: '' 1::x; do
    refused 2 "--rows: expected FIRST:END or FIRST:END:STEP" probe-cat --rows "$rows" small.probe
done
for where in '' validity 'validity <' 'validity ~ 3' 'validity < 3x' 'position[-1] < 2' 'position[0 < 2' '< 3' \
    'validity < nan'; do
    refused 2 "--where: expected COLUMN OP NUMBER" probe-cat --where "$where" small.probe
done
refused 1 "there is no column foo to compare" probe-cat --where 'foo < 1' small.probe
refused 1 "column position has 3 numbers: say which, as in position[0]" probe-cat --where 'position < 1' small.probe
refused 1 "there is no position[3]" probe-cat --where 'position[3] < 1' small.probe

# -- merging -----------------------------------------------------------------------------------------
probe-cat --quiet --rows 0:2 small.probe >first
probe-cat --quiet --rows 2:5 small.probe >second
probe-cat --text first second >merged 2>merged.err
table probe small.probe >wanted
table probe merged >got
check "halves merged are the whole" cmp wanted got
check "the history of both is kept" sh -c "[ \$(grep -c '^# probe-place' merged) = 2 ]"
probe-cat small.probe small.probe >twice 2>twice.err
check "merged probes lose their cells, with a warning" sh -c "
    ! grep -q '^table tet' twice && grep -q 'run probe-tet again' twice.err"
probe-cat --drop validity --quiet second | sed 's/^somebody-else.*/somebody-else no/' >third
probe-cat --text first third >merged 2>merged.err
check "a column that one lacks holds missing values" sh -c "
    [ \"\$(grep '^0 1 0 ' merged)\" = '0 1 0 -0 1e-40 3e+38 nan 3 -3' ]"
check "with a warning" grep -q "warning: a stream has no column validity" merged.err
check "the first stream's key stays, with a warning" sh -c "
    grep -q '^somebody-else any value' merged && grep -q \"warning: key somebody-else is 'any value\" merged.err"
sed 's/^sh-content.*/sh-content irradiance/' second >other
refused 1 "cannot be merged: sh-content is radiance in the first and irradiance in another" probe-cat first other
sed 's/^sh-order.*/sh-order 2/; s/sh:f32:3/sh:f32:12/; s/ 7 8 9 / 1 2 3 4 5 6 7 8 9 1 2 3 /; /^0 1 0/d; /^5e-324/d' \
    second >other
refused 1 "cannot be merged: sh-order is 1 in the first and 2 in another" probe-cat first other

# -- describing --------------------------------------------------------------------------------------
probe-cat --info small.binary >info
check "--info says encoding, history and keys" sh -c "
    grep -qx 'encoding binary' info && grep -q '^made by probe-place points' info && grep -qx 'key sh-order 1' info"
check "and for each column its type, range, mean and missing values" sh -c "
    grep -qE '^table probe: 5 rows' info && grep -qE '^  validity +f32:1 +0\.1 +1 +0\.65 +1$' info &&
    grep -qE '^  sh\[2\] +f32:3 +0\.1 +3e\+38 .* 1$' info &&
    grep -qE '^  their_column\[1\] +i32:2 +-4 +2147483647 ' info"
refused 1 "nowhere.probe: No such file or directory" probe-cat --info nowhere.probe

# -- bad input ---------------------------------------------------------------------------------------
refused 1 "probe-cat: stdin: expected a probe stream, got nothing" probe-cat </dev/null
refused 1 "probe-cat: /: Is a directory" probe-cat /
refused 1 "expected a probe stream, which begins with '#?probe 1', got 'root" probe-cat /etc/passwd
refused 1 "probe-cat: stdin is closed" sh -c 'probe-cat <&-'
head -c 300 small.binary >cut
refused 1 "cut: byte " probe-cat cut
refused 1 "it is not whole" probe-cat cut
refused 1 "it is not whole" probe-cat -o cut.out cut
check "a refused stream leaves no output" sh -c "! ls -A | grep -E '^cut.out|^\.probe'"
sed 's/^1 0 0 nan.*/1 0 0 5/' small.probe >bad
refused 1 "bad:8: table probe: expected 9 numbers, got 4" probe-cat bad
refused 2 "--text" probe-cat --text=yes small.probe

# -- bad output --------------------------------------------------------------------------------------
refused 1 "stdout: No space left on device" sh -c 'probe-cat small.probe >/dev/full'
refused 1 "stdout: No space left on device" sh -c 'probe-cat --info small.probe >/dev/full'
refused 1 "/dev/full: No space left on device" probe-cat -o /dev/full small.probe
refused 1 "stdout is closed" sh -c 'probe-cat small.probe >&-'
refused 1 "nowhere/out: No such file or directory" probe-cat -o nowhere/out small.probe
refused 1 "Is a directory" probe-cat -o . small.probe
mkfifo pipe
cat pipe >through &
probe-cat -o pipe small.binary
wait
check "a named pipe is written to, not replaced" test -p pipe
check "and holds the stream" same small.rows rows through
cp small.probe link.target
ln -s link.target link
probe-cat -o link small.binary
check "a link stays a link" sh -c "[ -L link ] && head -n 1 link.target | grep -q binary"

# A stream of some megabytes.
awk 'BEGIN { print "#?probe 1\ntable probe position:f64:3"
    for (i = 0; i < 400000; i++) printf "%d.5 %d.25 -%d.125\n", i, i, i
    print "end" }' >big.probe

{ probe-cat big.probe 2>pipe.err; echo $? >pipe.status; } | head -c 100 >/dev/null
check "a closed pipe ends it quietly, status not 0" sh -c "[ \$(cat pipe.status) != 0 ] && [ ! -s pipe.err ]"
{ trap '' PIPE; probe-cat big.probe 2>pipe.err; echo $? >pipe.status; } | head -c 100 >/dev/null
check "so it does where SIGPIPE is ignored" sh -c "[ \$(cat pipe.status) = 1 ] && [ ! -s pipe.err ]"

# -- while the input is still coming -----------------------------------------------------------------
echo old >kept
mkfifo feed
probe-cat -o kept feed &
writer=$!
exec 7>feed
head -n 300000 big.probe >&7
kill -9 $writer
wait $writer 2>/dev/null
exec 7>&-
check "a killed program leaves the old file" sh -c "[ \"\$(cat kept)\" = old ]"
check "and nothing beside it" sh -c "! ls -A | grep '^\.probe'"

probe-cat <feed >early &
reader=$!
exec 7>feed
head -n 300000 big.probe >&7
check "output begins before the input ends" wait_for test -s early
if ldd "$BUILD/src/probe-cat" | grep -q libasan || ! [ -r /proc/$reader/status ]; then
    skip "peak memory is not told, or not the program's own"
else
    peak=$(awk '/^VmHWM/ { print $2 }' /proc/$reader/status)
    check "in little memory: $peak KiB" [ "$peak" -lt 16384 ]
fi
tail -n +300001 big.probe >&7
exec 7>&-
wait $reader
check "and is whole at the end" sh -c "grep -v '^# ' early | cmp - big.probe"

# -- failing system calls ----------------------------------------------------------------------------
library=$BUILD/tests/failing_io.so
# failing CALL AFTER HOW COMMAND...
failing() {
    failing_call=$1 failing_after=$2 failing_how=$3
    shift 3
    env FAIL_CALL="$failing_call" FAIL_AFTER="$failing_after" FAIL_HOW="$failing_how" \
        ASAN_OPTIONS=verify_asan_link_order=0 LD_PRELOAD="$library" "$@"
}
for after in 0 3; do
    refused 1 "big.probe: Input/output error" failing read $after errno probe-cat big.probe
    refused 1 "stdout: Input/output error" failing write $after errno probe-cat big.probe
done
failing close 0 errno probe-cat small.probe >closed.out 2>closed.err
check "standard output is checked on closing" sh -c "
    [ $? = 1 ] && grep -qx 'probe-cat: stdout: Input/output error' closed.err"
for call in write close linkat rename; do
    echo old >kept
    refused 1 "kept: Input/output error" failing $call 0 errno probe-cat -o kept small.probe
    check "$call fails: the old file stays, alone" sh -c "[ \"\$(cat kept)\" = old ] && ! ls -A | grep '^\.probe'"
done
rm kept
check "a file system without nameless files serves as well" failing tmpfile 0 unsupported probe-cat -o kept small.probe
check "the file is whole" same small.rows rows kept
check "and has the mode that the umask says" sh -c "
    [ \$(stat -c %a kept) = \$(printf %o \$((0666 & ~\$(umask)))) ] && ! ls -A | grep '^\.probe'"
echo old >kept
refused 1 "it is not whole" failing tmpfile 0 unsupported probe-cat -o kept cut
check "a refused stream leaves the old file, alone" sh -c "[ \"\$(cat kept)\" = old ] && ! ls -A | grep '^\.probe'"
for call in read write; do
    for how in short interrupt; do
        failing $call 0 $how probe-cat small.binary >"$call.$how"
        check "$call: $how: nothing is lost" same small.rows rows "$call.$how"
    done
done

tap_done
