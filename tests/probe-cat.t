#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-cat as people run it: converting keeps every bit, selections and merges do what they say,
# output appears whole or not at all, and whatever goes wrong is said and makes the status non-zero.
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
same() {
    expected=$1
    shift
    "$@" | cmp - "$expected"
}
# made FILE COMMAND...: what the command prints and says, in FILE and FILE.err
made() {
    made_file=$1
    shift
    "$@" >"$made_file" 2>"$made_file.err"
}
# nothing_beside: no temporary file is left
nothing_beside() {
    ls -A >names
    lacks names '^\.probe'
}
# table NAME FILE: the rows of one table
table() { sed -n "/^table $1 /,/^[te]/p" "$2" | grep -v '^[te]'; }

# -- converting ------------------------------------------------------------------------------------
grep -v '^# ' small.probe >small.rows
probe-cat --binary small.probe >small.binary
check "binary is binary" [ "$(head -n 1 small.binary)" = '#?probe 1 binary' ]
check "text, binary, text: the same rows, keys and tables" same small.rows rows small.binary
probe-cat <small.binary >again
check "the encoding stays unless told otherwise" [ "$(head -n 1 again)" = '#?probe 1 binary' ]
cat >wanted <<'END'
# probe-place points some.txt
# probe-cat
# probe-cat --rows 0:5
END
probe-cat --binary <small.probe | probe-cat --text --rows 0:5 | sed -n 2,4p >history
check "each run adds its command line, the oldest first" cmp wanted history
check "--no-provenance writes none" same small.rows probe-cat --no-provenance small.probe
sed 's/$/\r/' small.probe >small.crlf
check "lines may end in CRLF" same small.rows rows small.crlf
probe-cat -o out.probe small.probe
check "-o writes the file" same small.rows rows out.probe
check "and leaves nothing else" nothing_beside

# -- selecting -------------------------------------------------------------------------------------
probe-cat --tables probe --columns position,validity --text small.probe >picked
check "--tables, --columns: only these are left" \
    says picked '^table probe position:f64:3 validity:f32:1$' and lacks picked tet
probe-cat --drop sh,their_column --text small.probe >dropped
check "--drop: all but these are left" \
    says dropped '^table probe position:f64:3 validity:f32:1$' '^table tet'
# ordered SCHEMA FIRST OPTION...: the first table's line and its first row
ordered() {
    ordered_wanted="table $1|$2"
    shift 2
    probe-cat --quiet --text "$@" small.probe | grep -A 1 -m 1 '^table' | paste -s -d '|' - >row
    check "$*: the order asked for" [ "$(cat row)" = "$ordered_wanted" ]
}
ordered 'probe validity:f32:1 position:f64:3' '1 0 0 0' --tables probe --columns validity,position
ordered 'probe validity:f32:1 position:f64:3' '1 0 0 0' --columns validity,position
ordered 'probe their_column:i32:2 validity:f32:1 position:f64:3' '3 -3 0.5 0 1 0' \
    --columns their_column,validity,position --where 'validity = .5'
ordered 'probe sh:f32:3 position:f64:3' 'nan nan nan 1 0 0' \
    --columns validity,sh,position --drop validity --rows 1:3
ordered 'probe position:f64:3 their_column:i32:2' '0 0 0 1 -1' --drop sh,validity
ordered 'tet neighbour:i32:4 vertex:i32:4' '-1 -1 -1 1 0 1 2 3' \
    --tables tet,probe --columns neighbour,position,vertex
ordered 'their_table thing:f64:1' 42 --tables their_table,tet,probe
probe-cat -q --binary --columns validity,position --tables tet,probe small.probe >turned.binary
probe-cat -q --text --no-provenance --columns validity,position --tables tet,probe small.probe \
    >wanted
check "binary: the same order" same wanted probe-cat --text --no-provenance turned.binary
refused 1 "no column sh" probe-cat --columns sh,position turned.binary
probe-cat -q --text --columns validity,their_column,position --rows 5:6 turned.binary small.probe \
    >got
check "merged with columns in another order, each number is in its column" \
    says got '^table probe validity:f32:1 their_column:i32:2 position:f64:3$' '^1 1 -1 0 0 0$'
probe-cat --info --tables probe --columns validity,position --where 'validity < .9' small.probe >got
cat >wanted <<'EOT'
table probe: 2 rows
  validity 0.1 0.5
  position[0] 0 0
  position[1] 0 1
  position[2] 0 1.797693e+308
EOT
check "--info describes what is chosen, in its order" \
    [ "$(awk '/^table/ || / f(32|64):/ { print /^table/ ? $0 : "  " $1 " " $3 " " $4 }' got)" = \
    "$(cat wanted)" ]
refused 1 "the stream has no column validty" probe-cat --info --columns validty small.probe
refused 1 "the stream has no column validty" probe-cat --columns position,validty small.probe
refused 2 "columns: expected each name once, got position twice" \
    probe-cat --columns position,sh,position small.probe
refused 2 "columns: expected names separated by commas, got ''" probe-cat --columns '' small.probe
refused 2 "tables: expected each name once, got probe twice" \
    probe-cat --tables probe,probe small.probe
refused 1 "the stream has no table tets" probe-cat --tables probe,tets small.probe
refused 1 "the stream has no column validty" \
    probe-cat --columns position,validty --rows 0 small.probe
refused 1 "expected a column position:f64:3, there is none" probe-cat --drop position small.probe
refused 1 "table tet has 2 rows, but there are no probes" probe-cat --tables tet small.probe

# picks NUMBERS OPTION...: the probes whose their_column[0] is in NUMBERS are left
picks() {
    picks_wanted=$1
    shift
    probe-cat --quiet --text "$@" small.probe >picks.out
    picks_got=$(table probe picks.out | cut -d ' ' -f 8 | paste -s -d ' ' -)
    check "$* keeps probes '$picks_wanted'" [ "$picks_got" = "$picks_wanted" ]
}
picks "2 3" --rows 1:3
picks "1 2" --rows :2
picks "4 5" --rows 3:
picks "1 3 5" --rows ::2
picks "2 5" --rows 1:5:3
picks "5" --rows 4
picks "" --rows 7:9
picks "1 3 4 5" --captured
picks "2" --uncaptured
picks "3 4" --where 'validity < 0.9'
picks "4" --where 'validity = 0.1'
picks "3 4" --where 'validity != 1'
picks "4 5" --where 'position[2]>=0.1'
picks "5" --where 'their_column[1] == 2147483647'
picks "3 4" --where 'their_column[0] > 1' --where 'their_column[0] <= 4' --captured
picks "3 5" --rows 1: --where 'validity > 0.2'
probe-cat --text --rows 0:4 small.probe >four 2>four.err
check "where probes go, cells go, with a warning" \
    lacks four '^table tet' and says four.err 'probe-cat: warning: table tet'
probe-cat --text --rows 0:5 small.probe >five
check "where none go, cells stay" says five '^table tet'
for rows in a 1:2:3:4 1:2:0 -1:2 99999999999: '' 1::x; do
    refused 2 "--rows: expected FIRST:END or FIRST:END:STEP" probe-cat --rows "$rows" small.probe
done
for where in '' validity 'validity <' 'validity ~ 3' 'validity < 3x' 'position[-1] < 2' \
    'position[0 < 2' '< 3' 'validity < nan'; do
    refused 2 "--where: expected COLUMN OP NUMBER" probe-cat --where "$where" small.probe
done
refused 1 "there is no column foo to compare" probe-cat --where 'foo < 1' small.probe
refused 1 "column position has 3 numbers: say which, as in position[0]" \
    probe-cat --where 'position < 1' small.probe
refused 1 "there is no position[3]" probe-cat --where 'position[3] < 1' small.probe

# -- merging ---------------------------------------------------------------------------------------
probe-cat --quiet --rows 0:2 small.probe >first
probe-cat --quiet --rows 2:5 small.probe >second
probe-cat --text first second >merged 2>merged.err
table probe small.probe >wanted
table probe merged >got
check "halves merged are the whole" cmp wanted got
check "the history of both is kept" [ "$(grep -c '^# probe-place' merged)" = 2 ]
probe-cat small.probe small.probe >twice 2>twice.err
check "merged probes lose their cells, with a warning" \
    lacks twice '^table tet' and says twice.err 'run probe-tet again'
probe-cat --drop validity --quiet second | sed 's/^somebody-else.*/somebody-else no/' >third
probe-cat --text first third >merged 2>merged.err
check "a column that one lacks holds missing values" \
    [ "$(grep '^0 1 0 ' merged)" = '0 1 0 -0 1e-40 3e+38 nan 3 -3' ]
check "with a warning" grep -q "warning: a stream has no column validity" merged.err
check "the first stream's key stays, with a warning" says merged '^somebody-else any value' \
    and says merged.err "warning: key somebody-else is 'any value"
sed 's/^sh-content.*/sh-content irradiance/' second >other
refused 1 "cannot be merged: sh-content is radiance in the first and irradiance in another" \
    probe-cat first other
sed 's/^sh-order.*/sh-order 2/; s/sh:f32:3/sh:f32:12/
    s/ 7 8 9 / 1 2 3 4 5 6 7 8 9 1 2 3 /; /^0 1 0/d; /^5e-324/d' second >other
refused 1 "cannot be merged: sh-order is 1 in the first and 2 in another" probe-cat first other

# -- filling ---------------------------------------------------------------------------------------
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
    check "parts $order fill up to the whole, cells and keys included" \
        same full.rows rows --fill part$2 --fill part$3 part$1
    check "and so they do in binary" \
        same full.rows rows --fill binary$2 --fill binary$3 binary$1
done
probe-cat --text --fill binary1 --fill part2 --fill part1 part0 >filled 2>filled.err
check "without a warning" empty filled.err
cat >wanted <<'END'
# probe-place points some.txt
# probe-cat
# probe-cat --fill binary1 --fill part2 --fill part1
END
grep '^# ' filled >history
check "the history is kept of all, each line once" cmp wanted history
probe-cat --text --tables probe --columns position small.probe | grep -v '^sh-' >placed
probe-cat --text --fill full.probe placed >filled
check "columns and keys that the input lacks are added" says filled '^sh-order 1$' \
    '^table probe position:f64:3 sh:f32:3 validity:f32:1 their_column:i32:2$'
table probe full.probe >wanted
table probe filled >got
check "with their values" cmp wanted got
{ sed '/^table probe/q' full.probe; sort -r wanted; echo end; } >turned
probe-cat --text --fill turned placed | sed -n '/^table probe/,$p' | numbers >got
check "the order of the other stream does not matter" cmp wanted got
sed 's/0\.1 0\.2 0\.3/9 9 9/' full.probe >other
check "what is there stays" same full.rows rows --fill other part0 --fill part1 --fill part2
probe-cat --quiet --text --rows 1:3 part1 >few
probe-cat --text --fill full.probe few >filled 2>filled.err
check "probes that are not in the input are left out, with a warning" \
    [ "$(grep -c '^[0-9-].* ' filled)" = 2 ] and says filled.err \
    'warning: full.probe: 3 of its 5 probes are not among those to be filled'
sed 's/^5e-324 -0 0.1/5e-324 0 0.1/' full.probe >other
probe-cat --quiet --text --fill other placed >filled
check "0 and -0 are two places" says filled '^5e-324 -0 0.1 nan nan nan nan -1 -1$'

stream_of 'table probe position:f64:3 id:i32:1 sh:f32:3' >twins <<'END'
1 1 1 7 nan nan nan
0 0 0 5 nan nan nan
1 1 1 8 nan nan nan
END
sed 's/7 nan nan nan/7 1 2 3/; s/8 nan nan nan/8 4 5 6/; /^0 0 0/d' twins >twins.lit
cat >wanted <<'END'
1 1 1 7 1 2 3
0 0 0 5 nan nan nan
1 1 1 8 4 5 6
END
probe-cat --text --fill twins.lit twins | numbers >got
check "of probes at one place the first is the first" cmp wanted got
stream_of 'table probe position:f64:3 normal:f32:3' >sides <<'END'
1 1 1 0 0 1
1 1 1 1 0 0
END
stream_of 'table probe normal:f32:3 position:f64:3 irradiance:f32:3' >sides.lit <<'END'
1 0 0 1 1 1 4 5 6
0 0 1 1 1 1 1 2 3
END
cat >wanted <<'END'
1 1 1 0 0 1 1 2 3
1 1 1 1 0 0 4 5 6
END
probe-cat --text --fill sides.lit sides | numbers >got
check "normals tell probes at one place apart" cmp wanted got
stream_of 'table probe position:f64:3 ao:f32:1 area:f32:1 sh:f32:3' >measured <<'END'
1 0 0 0.5 2 nan nan nan
2 0 0 0.5 2 7 7 7
3 0 0 0.5 2 nan nan nan
END
stream_of 'table probe position:f64:3 ao:f32:1 area:f32:1 sh:f32:3' >measured.lit <<'END'
1 0 0 0.25 3 4 5 6
2 0 0 0.25 3 4 5 6
3 0 0 0.25 3 nan nan nan
END
cat >wanted <<'END'
1 0 0 0.25 2 4 5 6
2 0 0 0.5 2 7 7 7
3 0 0 0.5 2 nan nan nan
END
probe-cat --text --fill measured.lit measured | numbers >got
check "what capture finds comes with the light, in place of what was there" cmp wanted got
echo '1 1 1 0 0 1' | stream_of 'table probe position:f64:3 hull_normal:f32:3' >hull
check "hull_normal is not taken from another stream's cells" \
    made filled probe-cat --text --fill hull twins and lacks filled '^table.*hull_normal'

sed 's/^sh-order/capture-rays 32\nsh-order/' part0 >rays32
sed 's/^sh-order/capture-rays 64\nsh-order/' part1 >rays64
rays="capture-rays is 64, and theirs is 32"
refused 1 "rays64: its light is not that of the probes to be filled: $rays" \
    probe-cat --fill rays64 rays32
sed 's/^sh-content.*/sh-content irradiance/' part1 >other
refused 1 "sh-content is irradiance, and theirs is radiance" probe-cat --fill other part0
sed 's/^sh-order/sun-1 0,0,1,1,1,1\nsh-order/' part0 >sun
sed 's/^sun-1.*/sun-1 0,0,1,1,1,2/' sun >other
refused 1 "sun-1 is 0,0,1,1,1,2, and theirs is 0,0,1,1,1,1" probe-cat --fill other sun
sed 's/^somebody-else.*/somebody-else no/' part1 >other
probe-cat --text --fill other part0 >filled 2>filled.err
check "another key stays, with a warning" says filled '^somebody-else any value' \
    and says filled.err 'other: key somebody-else is .no'
sed 's/validity:f32/validity:i32/; s/nan -*[0-9]* \(-*[0-9]*\)$/0 0 \1/; s/ 1 1 -1$/ 0 1 -1/' \
    part1 | grep -v '^table validity' >other
refused 1 "column validity: expected f32:1, got i32:1" probe-cat --fill other part0
sed 's/their_column:i32:2/their_column:f32:2/' part1 >other
refused 1 "other: column their_column is f32:2, and i32:2 in the stream to be filled" \
    probe-cat --fill other part0
echo 1 | stream_of 'table thing number:f32:1' >thing
refused 1 "thing: nothing can be filled: it has no table probe" probe-cat --fill thing part0
refused 1 "the input has no table probe" probe-cat --fill part0 thing
refused 1 "nowhere: No such file or directory" probe-cat --fill nowhere part0
refused 2 "without --fill and --salvage" probe-cat --info --fill part1 part0

# -- salvaging -------------------------------------------------------------------------------------
# Cut anywhere, a text keeps its whole lines, and a binary its whole blocks (here one a table), or
# it is refused. tests/stream_salvage.c cuts at every byte; here it is where something ends.
table probe full.probe >wanted
kept_as_expected() { # ROWS: what was salvaged are the first rows, so many, or none where it is -1
    got=-1
    if made kept probe-cat --text --salvage cut; then
        table probe kept >kept.rows
        got=$(lines kept.rows)
        head -n "$got" wanted | cmp -s - kept.rows || return
    fi
    [ "$got" = "$1" ] && [ -s kept.err ]
}
lines() { wc -l <"$1"; }
salvages() { # FILE ROWS BYTES...: a command that tells of what is left how many rows are to be kept
    salvages_whole=$1 salvages_rows=$2 salvages_bad=
    shift 2
    for salvages_at; do
        head -c "$salvages_at" "$salvages_whole" >cut
        expected=$($salvages_rows cut)
        kept_as_expected "$expected" || salvages_bad="$salvages_bad $salvages_at:$got:$expected"
    done
    echo "$salvages_bad"
    [ $# -gt 0 ] && [ -z "$salvages_bad" ]
}
lines_left() { # in text; the last line does not count without its newline
    { cat "$1"; echo x; } | awk '
        function take(line) {
            if (line ~ /^[a-z]/) inside = line ~ /^table probe /
            if (inside) rows++
        }
        BEGIN { rows = -1 }
        NR > 1 { take(last) }
        { last = $0 }
        END { print rows }'
}
line_cuts() { # FILE: within each line, before and behind its newline; the end line is not needed
    awk '$0 == "end" { exit }
        { print at + int(length($0) / 2); at += length($0) + 1; print at - 1; print at }' "$1"
}
check "a text, cut in and around each line" salvages full.probe lines_left $(line_cuts full.probe)
probe-cat --binary full.probe >full.binary
probe_line=$(grep -abo '^table probe.*' full.binary | head -n 1 |
    awk -F: '{ print $1 + length($0) - length($1) }')
block_end=$((probe_line + 16 + 5 * 48)) # 16 bytes of head; a row: 3 * 8 + 3 * 4 + 4 + 2 * 4 bytes
blocks_left() {
    blocks_size=$(wc -c <"$1")
    if [ "$blocks_size" -lt "$probe_line" ]; then echo -1
    elif [ "$blocks_size" -lt "$block_end" ]; then echo 0
    else echo 5; fi
}
around() { for around_at; do echo $((around_at - 1)) "$around_at" $((around_at + 1)); done; }
check "a binary, cut around the block's head, first row and end, and anywhere" \
    salvages full.binary blocks_left \
    $(around "$probe_line" $((probe_line + 16)) $((probe_line + 64)) "$block_end") \
    $(seq 1 41 $(($(wc -c <full.binary) - 2)))
# count PATTERN FILE: lines with it
count() { grep -c "$1" "$2"; }
salvage="made kept probe-cat --text --salvage"
head -c -56 full.probe >cut
$salvage cut
check "a cut table tet is dropped, and that is said" [ "$(count '^table' kept)" = 1 ] and says \
    kept.err 'cut:13: .*not whole: 5 rows of table probe are kept, table tet is dropped'
head -c -5 full.probe >cut
$salvage cut
check "a cut table behind it leaves it" \
    [ "$(count '^table' kept)/$(count '^[01] .* -1$' kept)" = 2/2 ] and \
    says kept.err '5 rows of table probe are kept, table their_table is dropped'
sed 's/^0 1 0 .*/0 1 0 rubbish/' full.probe >cut
$salvage cut
check "rubbish in a row ends what is kept, and cells go with the probes" \
    [ "$(count '^[0-9]' kept)" = 2 ] and lacks kept '^table tet' and \
    says kept.err 'warning: cut:9: .*got .rubbish.*: 2 rows of table probe are kept'
probe-cat --no-provenance full.binary >whole
check "a whole stream passes unchanged, without a word" \
    made kept probe-cat --salvage --no-provenance full.binary and empty kept.err and cmp whole kept
head -n 8 part1 >cut
$salvage --fill cut part0
check "files to fill from are salvaged as well" \
    says kept '^1 0 0 4 5 6 0.25 2 -2$' and says kept.err 'cut:8: .*: 2 rows'
refused 1 "cut:8" probe-cat --fill cut part0
for bytes in 0 5 20 60; do
    head -c $bytes full.probe >cut
    refused 1 "cut" probe-cat --salvage cut
done
head -c 3000 /dev/urandom | tr '\n' x >garbage
refused 1 "expected a probe stream" probe-cat --salvage garbage
{ head -n 3 full.probe; cat garbage; } >cut
refused 1 "cut" probe-cat --salvage cut

# -- describing ------------------------------------------------------------------------------------
probe-cat --info small.binary >info
check "--info says encoding, history and keys" \
    says info '^encoding binary$' '^made by probe-place points' '^key sh-order 1$'
check "and for each column its type, range, mean and missing values" says info \
    '^table probe: 5 rows' '^  validity  *f32:1  *0\.1  *1  *0\.65  *1$' \
    '^  sh\[2\]  *f32:3  *0\.1  *3e+38 .* 1$' '^  their_column\[1\]  *i32:2  *-4  *2147483647 '
refused 1 "nowhere.probe: No such file or directory" probe-cat --info nowhere.probe

# -- bad input -------------------------------------------------------------------------------------
refused 1 "probe-cat: stdin: expected a probe stream, got nothing" probe-cat </dev/null
refused 1 "probe-cat: /: Is a directory" probe-cat /
refused 1 "expected a probe stream, which begins with '#?probe 1', got 'root" probe-cat /etc/passwd
from_nothing() { probe-cat <&-; }
refused 1 "probe-cat: stdin is closed" from_nothing
head -c 300 small.binary >cut
refused 1 "cut: byte " probe-cat cut
refused 1 "it is not whole" probe-cat cut
refused 1 "it is not whole" probe-cat -o cut.out cut
check "a refused stream leaves no output" [ ! -e cut.out ] and nothing_beside
sed 's/^1 0 0 nan.*/1 0 0 5/' small.probe >bad
refused 1 "bad:8: table probe: expected 9 numbers, got 4" probe-cat bad
refused 2 "--text" probe-cat --text=yes small.probe

# -- bad output ------------------------------------------------------------------------------------
refused 1 "stdout: No space left on device" into /dev/full probe-cat small.probe
refused 1 "stdout: No space left on device" into /dev/full probe-cat --info small.probe
refused 1 "/dev/full: No space left on device" probe-cat -o /dev/full small.probe
to_nothing() { probe-cat small.probe >&-; }
refused 1 "stdout is closed" to_nothing
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
check "a link stays a link" [ -L link ] and says link.target '^#?probe 1 binary$'

# A stream of some megabytes.
awk 'BEGIN { print "#?probe 1\ntable probe position:f64:3"
    for (i = 0; i < 400000; i++) printf "%d.5 %d.25 -%d.125\n", i, i, i
    print "end" }' >big.probe

# Blocks of 10922 rows of 24 bytes, and 16 bytes of head.
probe-cat --binary --no-provenance big.probe >big.binary
head -c 1000000 big.binary | probe-cat --text --salvage >kept 2>kept.err
numbers <kept >rows
check "a binary keeps its whole blocks" \
    has_lines 32766 rows and says kept.err ': 32766 rows of table probe are kept'
numbers <big.probe | head -n 32766 >wanted
check "to the bit" cmp rows wanted
{ head -c 600000 big.binary; printf x; tail -c +600002 big.binary; } >flipped
probe-cat --salvage --text flipped >kept 2>kept.err
numbers <kept >rows
check "a wrong byte ends what is kept" has_lines 21844 rows \
    and says kept.err 'flipped: byte .*checksum does not match: 21844 rows'

{ probe-cat big.probe 2>pipe.err; echo $? >pipe.status; } | head -c 100 >/dev/null
check "a closed pipe ends it quietly, status not 0" \
    [ "$(cat pipe.status)" -gt 0 ] and empty pipe.err
{ trap '' PIPE; probe-cat big.probe 2>pipe.err; echo $? >pipe.status; } | head -c 100 >/dev/null
check "so it does where SIGPIPE is ignored" [ "$(cat pipe.status)" = 1 ] and empty pipe.err

# -- while the input is still coming ---------------------------------------------------------------
echo old >kept
mkfifo feed
probe-cat -o kept feed &
writer=$!
exec 7>feed
head -n 300000 big.probe >&7
kill -9 $writer
wait $writer 2>/dev/null
exec 7>&-
check "a killed program leaves the old file" [ "$(cat kept)" = old ]
check "and nothing beside it" nothing_beside

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
grep -v '^# ' early >without_history
check "and is whole at the end" cmp without_history big.probe

# -- failing system calls --------------------------------------------------------------------------
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
status=$?
check "standard output is checked on closing" \
    [ $status = 1 ] and says closed.err '^probe-cat: stdout: Input/output error$'
for call in write close linkat rename; do
    echo old >kept
    refused 1 "kept: Input/output error" failing $call 0 errno probe-cat -o kept small.probe
    check "$call fails: the old file stays, alone" [ "$(cat kept)" = old ] and nothing_beside
done
rm kept
check "a file system without nameless files serves as well" \
    failing tmpfile 0 unsupported probe-cat -o kept small.probe
check "the file is whole" same small.rows rows kept
check "and has the mode that the umask says" \
    [ "$(stat -c %a kept)" = "$(printf %o $((0666 & ~$(umask))))" ] and nothing_beside
echo old >kept
refused 1 "it is not whole" failing tmpfile 0 unsupported probe-cat -o kept cut
check "a refused stream leaves the old file, alone" [ "$(cat kept)" = old ] and nothing_beside
for call in read write; do
    for how in short interrupt; do
        failing $call 0 $how probe-cat small.binary >"$call.$how"
        check "$call: $how: nothing is lost" same small.rows rows "$call.$how"
    done
done

# -- cells of fewer corners ------------------------------------------------------------------------
# flat LINE...: a stream of order 1 with these lines
flat() {
    printf '%s\n' '#?probe 1' 'sh-order 1' 'sh-content radiance' \
        'table probe position:f64:3 sh:f32:3' "$@" end
}
flat '0 0 0 1 0 0' '1 0 0 2 0 0' '0 0 1 1 1 0' '1 0 1 2 1 0' \
    'table tri vertex:i32:3 neighbour:i32:3' '0 1 2 1 -1 -1' '1 3 2 -1 0 -1' >tri.flat
flat '0 0 0 1 0 0' '2 0 0 3 0 0' '4 0 0 1 0 0' \
    'table segment vertex:i32:2 neighbour:i32:2' '0 1 1 -1' '1 2 -1 0' >segment.flat
flat '1 2 3 4 5 6' 'table point vertex:i32:1 neighbour:i32:1' '0 -1' >point.flat
for table in tri segment point; do
    probe-cat --binary $table.flat >binary.flat
    check "$table: text, binary, text: the same" \
        same $table.flat probe-cat --text --no-provenance binary.flat
    probe-cat --info $table.flat >info
    check "$table: described" says info "table $table"
    probe-cat --text --content irradiance $table.flat >other.flat
    check "$table: with other light, cells stay" says other.flat "^table $table"
    probe-cat --text $table.flat $table.flat >twice.flat 2>twice.err
    check "$table: merged, cells are those of one stream alone: dropped" \
        lacks twice.flat "^table $table" and says twice.err 'run probe-tet again'
    probe-cat --text --rows 0:1 $table.flat >fewer.flat 2>fewer.err
    if [ $table = point ]; then
        check "point: where its probe stays, so does it" grep -q '^table point' fewer.flat
    else
        check "$table: without all of their probes, cells go" \
            lacks fewer.flat "^table $table" and says fewer.err "table $table"
    fi
    sed '/^table .*vertex/,/^end/s/^0 /9 /' $table.flat >beyond.flat
    refused 1 "table $table" probe-cat beyond.flat
done

# -- products --------------------------------------------------------------------------------------
# light of L_00 alone, and of L_10, times .5 Y_00 + Y_10
printf '%s\n' '0 0 0 1 2 3 0 0 0 0 0 0 0 0 0 .1 .5 0 1 0' \
    '0 0 1 0 0 0 0 0 0 1 1 2 0 0 0 .1 .5 0 1 0' '0 0 2 1 1 1 0 0 0 0 0 0 0 0 0 .1 nan nan nan nan' |
    sed 's/ \.1 / .1 .1 .1 .1 .1 .1 .1 .1 .1 .1 .1 .1 /' |
    stream_of 'sh-order 2' \
        'table probe position:f64:3 sh:f32:12 sh_error:f32:12 visibility:f32:4' >seen.probe
probe-cat --product visibility seen.probe 2>said | numbers | cut -d ' ' -f 4-15 >got
printf '%s\n' '.141047 .282095 .423142 0 0 0 .282095 .56419 .846284 0 0 0' \
    '.282095 .282095 .56419 0 0 0 .141047 .141047 .282095 0 0 0' >wanted
sed -n '1,2p' got >both
check "light times what a probe sees" near 1e-5 wanted both and says said 'errors, gradients'
check "none where that is not known" every 'NR < 3 || $1 == "nan"' got
refused 1 'expected a column of SH, f32 of n^2 numbers, there is no ao' \
    probe-cat --product ao seen.probe
refused 1 'expected a column of SH, f32 of n^2 numbers, not position' \
    probe-cat --product position seen.probe
probe-cat -q --content irradiance seen.probe >irradiance.probe
refused 1 'product is of radiance, got irradiance' \
    probe-cat --product visibility irradiance.probe

# -- blending --------------------------------------------------------------------------------------
two() { # FILE GROUP-LINE LIGHT-OF-THE-FIRST
    printf '%s\n' '#?probe 1' 'sh-order 1' 'sh-content radiance' "$2" 'table probe position:f64:3'\
' sh:f32:3 sh_error:f32:3 sh_a:f32:3 transfer_suns:f32:6 depth:f32:1' \
        "0 0 0 $3" '1 0 0 nan nan nan nan nan nan nan nan nan 1 1 1 2 2 2 7' end >"$1"
}
two open.door 'group-1 a light=x' '1 2 3 .3 0 .4 4 4 4 1 2 3 4 5 6 7'
two closed.door 'group-1 a light=x' '5 2 7 .4 .4 0 0 4 8 1 2 3 8 9 0 9'
probe-cat --blend .25 open.door closed.door >ajar.door
echo '0 0 0 2 2 4 0.24622144 0.1 0.3 3 4 5 1 2 3 5 6 4.5 7' >wanted
numbers <ajar.door | head -n 1 >got
check "light is blended, errors as of independent ones" near 1e-6 wanted got and \
    says ajar.door '^light-blend 0.25$' '^1 0 0 nan nan nan .* 7$'
probe-cat --no-provenance --blend 1 closed.door open.door | numbers >got
sed 's/ 7$/ 9/' open.door | numbers | head -n 1 >wanted
head -n 1 got >first
check "of weight 1 it is the second's" near 1e-6 wanted first
sed 's/^1 0 0/1 0 1/' closed.door >moved.door
refused 1 "probe 1 is at 1,0,0 in the first and at 1,0,1 in the second" \
    probe-cat --blend .5 open.door moved.door
two other.door 'group-1 a light=y' '5 2 7 .4 .4 0 0 4 8 1 2 3 8 9 0 9'
refused 1 "group-1 is a light=x in the first and a light=y in the second" \
    probe-cat --blend .5 open.door other.door
probe-cat --drop sh_error closed.door >bare.door
refused 1 "expected the same columns of light: sh_error is f32:3 in one, and not in the other" \
    probe-cat --blend .5 open.door bare.door
probe-cat --rows 0:1 closed.door >fewer.door
refused 1 "expected the same probes, got 2 and 1" probe-cat --blend .5 open.door fewer.door
sed 's/^sh-content.*/sh-content irradiance/' closed.door >other.door
refused 1 "sh-content is radiance in the first and irradiance in the second" \
    probe-cat --blend .5 open.door other.door
sed 's/^group-1.*/&\npca-basis 0/' open.door >small.door
refused 1 "groups and transfers are compressed" probe-cat --blend .5 small.door small.door
refused 2 "--blend: expected two streams, got 1" probe-cat --blend .5 open.door
refused 2 "--blend" probe-cat --blend 1.5 open.door closed.door
tap_done
