#!/bin/sh
# probe-cat as people run it: converting keeps every bit, selections and merges do what they say, output
# appears whole or not at all, and whatever goes wrong is said and makes the status non-zero.
. "${SRC:?}/tests/support/setup.sh"

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

# -- filling -----------------------------------------------------------------------------------------
# full.probe: small.probe with light everywhere; part0, part1, part2: a third of that light each.
sed 's/^1 0 0 nan nan nan nan/1 0 0 4 5 6 0.25/' small.probe >full.probe
grep -v '^# ' full.probe >full.rows
for part in 0 1 2; do
    awk -v part=$part '/^[a-z]/ { probes = $2 == "probe"; row = 0 }
        probes && /^[0-9-]/ && row++ % 3 != part { $4 = $5 = $6 = $7 = "nan" }
        { print }' full.probe >part$part
    probe-cat --binary part$part >binary$part
done
for order in "0 1 2" "0 2 1" "2 1 0"; do
    set -- $order
    check "parts $order fill up to the whole, cells and keys included" same full.rows rows --fill part$2 --fill part$3 part$1
    check "and so they do in binary" same full.rows rows --fill binary$2 --fill binary$3 binary$1
done
probe-cat --text --fill binary1 --fill part2 --fill part1 part0 >filled 2>filled.err
check "without a warning" test ! -s filled.err
check "the history is kept of all, each line once" sh -c "sed -n 's/^# //p' filled | tr '\n' / |
    grep -qx 'probe-place points some.txt/probe-cat/probe-cat --fill binary1 --fill part2 --fill part1/'"
probe-cat --text --tables probe --columns position small.probe | grep -v '^sh-' >placed
check "columns and keys that the input lacks are added" sh -c "probe-cat --text --fill full.probe placed >filled &&
    grep -qx 'sh-order 1' filled && grep -qx 'table probe position:f64:3 sh:f32:3 validity:f32:1 their_column:i32:2' filled"
table probe full.probe >wanted
table probe filled >got
check "with their values" cmp wanted got
{ sed '/^table probe/q' full.probe; sort -r wanted; echo end; } >turned
check "the order of the other stream does not matter" sh -c "
    probe-cat --text --fill turned placed | sed -n '/^table probe/,\$p' | grep '^[0-9-]' | cmp - wanted"
sed 's/0\.1 0\.2 0\.3/9 9 9/' full.probe >other
check "what is there stays" same full.rows rows --fill other part0 --fill part1 --fill part2
probe-cat --quiet --text --rows 1:3 part1 >few
probe-cat --text --fill full.probe few >filled 2>filled.err
check "probes that are not in the input are left out, with a warning" sh -c "[ \$(grep -c '^[0-9-].* ' filled) = 2 ] &&
    grep -q 'warning: full.probe: 3 of its 5 probes are not among those to be filled' filled.err"
sed 's/^5e-324 -0 0.1/5e-324 0 0.1/' full.probe >other
check "0 and -0 are two places" sh -c "probe-cat --quiet --text --fill other placed | grep -qx '5e-324 -0 0.1 nan nan nan nan -1 -1'"

printf '%s\n' '#?probe 1' 'table probe position:f64:3 id:i32:1 sh:f32:3' '1 1 1 7 nan nan nan' '0 0 0 5 nan nan nan' \
    '1 1 1 8 nan nan nan' end >twins
sed 's/7 nan nan nan/7 1 2 3/; s/8 nan nan nan/8 4 5 6/; /^0 0 0/d' twins >twins.lit
check "of probes at one place the first is the first" sh -c "
    probe-cat --text --fill twins.lit twins | grep '^[0-9]' | tr '\n' / | grep -qx '1 1 1 7 1 2 3/0 0 0 5 nan nan nan/1 1 1 8 4 5 6/'"
printf '%s\n' '#?probe 1' 'table probe position:f64:3 normal:f32:3' '1 1 1 0 0 1' '1 1 1 1 0 0' end >sides
printf '%s\n' '#?probe 1' 'table probe normal:f32:3 position:f64:3 irradiance:f32:3' '1 0 0 1 1 1 4 5 6' '0 0 1 1 1 1 1 2 3' end >sides.lit
check "normals tell probes at one place apart" sh -c "
    probe-cat --text --fill sides.lit sides | grep '^[0-9]' | tr '\n' / | grep -qx '1 1 1 0 0 1 1 2 3/1 1 1 1 0 0 4 5 6/'"
printf '%s\n' '#?probe 1' 'table probe position:f64:3 hull_normal:f32:3' '1 1 1 0 0 1' end >hull
check "hull_normal is not taken from another stream's cells" sh -c "! probe-cat --text --fill hull twins | grep -q '^table.*hull_normal'"

sed 's/^sh-order/capture-rays 32\nsh-order/' part0 >rays32
sed 's/^sh-order/capture-rays 64\nsh-order/' part1 >rays64
refused 1 "rays64: its light is not that of the probes to be filled: capture-rays is 64, and theirs is 32" probe-cat --fill rays64 rays32
sed 's/^sh-content.*/sh-content irradiance/' part1 >other
refused 1 "sh-content is irradiance, and theirs is radiance" probe-cat --fill other part0
sed 's/^sh-order/sun-1 0,0,1,1,1,1\nsh-order/' part0 >sun
sed 's/^sun-1.*/sun-1 0,0,1,1,1,2/' sun >other
refused 1 "sun-1 is 0,0,1,1,1,2, and theirs is 0,0,1,1,1,1" probe-cat --fill other sun
sed 's/^somebody-else.*/somebody-else no/' part1 >other
probe-cat --text --fill other part0 >filled 2>filled.err
check "another key stays, with a warning" sh -c "grep -q '^somebody-else any value' filled && grep -q 'other: key somebody-else is .no' filled.err"
sed 's/validity:f32/validity:i32/; s/nan -*[0-9]* \(-*[0-9]*\)$/0 0 \1/; s/ 1 1 -1$/ 0 1 -1/' part1 | grep -v '^table validity' >other
refused 1 "column validity: expected f32:1, got i32:1" probe-cat --fill other part0
sed 's/their_column:i32:2/their_column:f32:2/' part1 >other
refused 1 "other: column their_column is f32:2, and i32:2 in the stream to be filled" probe-cat --fill other part0
printf '%s\n' '#?probe 1' 'table thing number:f32:1' 1 end >thing
refused 1 "thing: nothing can be filled: it has no table probe" probe-cat --fill thing part0
refused 1 "the input has no table probe" probe-cat --fill part0 thing
refused 1 "nowhere: No such file or directory" probe-cat --fill nowhere part0
refused 2 "without --fill and --salvage" probe-cat --info --fill part1 part0

# -- salvaging ---------------------------------------------------------------------------------------
# Cut anywhere, a text keeps its whole lines, and a binary its whole blocks (here one a table), or it is refused.
salvages() { # FILE STEP ROWS: awk that tells from what is left how many rows are to be kept; -1: refused
    salvages_size=$(wc -c <"$1") salvages_at=1 salvages_bad=
    while [ $salvages_at -lt $((salvages_size - 1)) ]; do
        head -c $salvages_at "$1" >cut
        expected=$($3 cut)
        if probe-cat --text --salvage cut >kept 2>kept.err; then got=$(table probe kept | wc -l); else got=-1; fi
        table probe kept | head -n "$got" | cmp -s - wanted -n "$(table probe kept | wc -c)" &&
            [ "$got" = "$expected" ] && [ -s kept.err ] || salvages_bad="$salvages_bad $salvages_at:$got:$expected"
        salvages_at=$((salvages_at + $2))
    done
    echo "$salvages_bad"
    [ -z "$salvages_bad" ]
}
lines_left() { # in text; the last line does not count without its newline
    { cat "$1"; echo x; } | awk 'BEGIN { rows = -1 } { if (NR > 1) take(last); last = $0 }
        function take(line) { if (line ~ /^[a-z]/) inside = line ~ /^table probe /; if (inside) rows++ }
        END { print rows }'
}
check "a text, cut anywhere" salvages full.probe 1 lines_left
probe-cat --binary full.probe >full.binary
probe_line=$(grep -abo '^table probe.*' full.binary | head -n 1 | awk -F: '{ print $1 + length($0) - length($1) }')
blocks_left() { # the block's end: 16 bytes of head, and 5 rows of 3 * 8 + 3 * 4 + 4 + 2 * 4 bytes
    blocks_size=$(wc -c <"$1")
    if [ "$blocks_size" -lt "$probe_line" ]; then echo -1
    elif [ "$blocks_size" -lt $((probe_line + 16 + 5 * 48)) ]; then echo 0
    else echo 5; fi
}
check "a binary, cut anywhere" salvages full.binary 3 blocks_left
head -c -30 full.probe | sed '$d' >cut
head -c -56 full.probe >cut
check "a cut table tet is dropped, and that is said" sh -c "probe-cat --text --salvage cut >kept 2>kept.err && [ \$(grep -c '^table' kept) = 1 ] &&
    grep -q 'cut:13: .*not whole: 5 rows of table probe are kept, table tet is dropped' kept.err"
head -c -5 full.probe >cut
check "a cut table behind it leaves it" sh -c "probe-cat --text --salvage cut >kept 2>kept.err && [ \$(grep -c '^table' kept) = 2 ] &&
    [ \$(grep -c '^[01] .* -1$' kept) = 2 ] && grep -q '5 rows of table probe are kept, table their_table is dropped' kept.err"
sed 's/^0 1 0 .*/0 1 0 rubbish/' full.probe >cut
check "rubbish in a row ends what is kept, and cells go with the probes" sh -c "probe-cat --text --salvage cut >kept 2>kept.err &&
    [ \$(grep -c '^[0-9]' kept) = 2 ] && ! grep -q '^table tet' kept && grep -q 'warning: cut:9: .*got .rubbish.*: 2 rows of table probe are kept' kept.err"
check "a whole stream passes unchanged, without a word" sh -c "probe-cat --salvage --no-provenance full.binary >kept 2>kept.err &&
    [ ! -s kept.err ] && probe-cat --no-provenance full.binary | cmp - kept"
head -n 8 part1 >cut
check "files to fill from are salvaged as well" sh -c "
    probe-cat --text --salvage --fill cut part0 2>kept.err | grep -qx '1 0 0 4 5 6 0.25 2 -2' && grep -q 'cut:8: .*: 2 rows' kept.err"
refused 1 "cut:8" probe-cat --fill cut part0
for bytes in 0 5 20 60; do
    head -c $bytes full.probe >cut
    refused 1 "cut" probe-cat --salvage cut
done
head -c 3000 /dev/urandom | tr '\n' x >garbage
refused 1 "expected a probe stream" probe-cat --salvage garbage
{ head -n 3 full.probe; cat garbage; } >cut
refused 1 "cut" probe-cat --salvage cut

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

# Blocks of 10922 rows of 24 bytes, and 16 bytes of head.
probe-cat --binary --no-provenance big.probe >big.binary
head -c 1000000 big.binary | probe-cat --text --salvage >kept 2>kept.err
check "a binary keeps its whole blocks" sh -c "[ \$(grep -c '^[0-9]' kept) = 32766 ] && grep -q ': 32766 rows of table probe are kept' kept.err"
grep '^[0-9]' big.probe | head -n 32766 >wanted
check "to the bit" sh -c "grep '^[0-9]' kept | cmp - wanted"
{ head -c 600000 big.binary; printf x; tail -c +600002 big.binary; } >flipped
probe-cat --salvage --text flipped >kept 2>kept.err
check "a wrong byte ends what is kept" sh -c "[ \$(grep -c '^[0-9]' kept) = 21844 ] && grep -q 'flipped: byte .*checksum does not match: 21844 rows' kept.err"

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
library=$BUILD/tests/support/failing_io.so
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

# -- cells of fewer corners --------------------------------------------------------------------------
head='#?probe 1\nsh-order 1\nsh-content radiance\ntable probe position:f64:3 sh:f32:3\n'
printf "$head"'0 0 0 1 0 0\n1 0 0 2 0 0\n0 0 1 1 1 0\n1 0 1 2 1 0\ntable tri vertex:i32:3 neighbour:i32:3\n0 1 2 1 -1 -1\n1 3 2 -1 0 -1\nend\n' >tri.flat
printf "$head"'0 0 0 1 0 0\n2 0 0 3 0 0\n4 0 0 1 0 0\ntable segment vertex:i32:2 neighbour:i32:2\n0 1 1 -1\n1 2 -1 0\nend\n' >segment.flat
printf "$head"'1 2 3 4 5 6\ntable point vertex:i32:1 neighbour:i32:1\n0 -1\nend\n' >point.flat
for table in tri segment point; do
    check "$table: text, binary, text: the same" sh -c "probe-cat --binary $table.flat | probe-cat --text --no-provenance | cmp - $table.flat"
    check "$table: described" sh -c "probe-cat --info $table.flat | grep -q 'table $table'"
    check "$table: with other light, cells stay" sh -c "probe-cat --text --content irradiance $table.flat | grep -q '^table $table'"
    probe-cat --text $table.flat $table.flat >twice.flat 2>twice.err
    check "$table: merged, cells are those of one stream alone: dropped" sh -c "! grep -q '^table $table' twice.flat && grep -q 'run probe-tet again' twice.err"
    probe-cat --text --rows 0:1 $table.flat >fewer.flat 2>fewer.err
    if [ $table = point ]; then
        check "point: where its probe stays, so does it" grep -q '^table point' fewer.flat
    else
        check "$table: without all of their probes, cells go" sh -c "! grep -q '^table $table' fewer.flat && grep -q 'table $table' fewer.err"
    fi
    sed '/^table .*vertex/,/^end/s/^0 /9 /' $table.flat >beyond.flat
    refused 1 "table $table" probe-cat beyond.flat
done
tap_done
