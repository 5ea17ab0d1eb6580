#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A bake in pieces is the bake in one: slices, a capture that was killed, a capture that was asked
# to end.
. "${SRC:?}/tests/support/setup.sh"
scene=$SRC/scenes/two-rooms.obj
options="--quiet --threads 2 --bounces 2"
capture() { probe-capture $options "$@"; }
# rows STREAM: the tables alone, as text
rows() { probe-cat --text "$1" | grep -v '^#'; }
# same_rows A B
same_rows() { rows "$1" >same.a && rows "$2" >same.b && cmp same.a same.b && test -s same.a; }
# lit STREAM: how many probes have light
lit() {
    probe-cat --text --tables probe --columns position,sh --captured "$1" 2>/dev/null |
        grep -c '^[0-9-]'
}

# -- slices ----------------------------------------------------------------------------------------
probe-place grid -q --count 60 "$scene" | probe-tet >placed.probe
probes=$(row_count probe placed.probe)
third=$(((probes + 2) / 3)) # of them, in the first slice
capture --rays 32 "$scene" placed.probe >whole.probe
for i in 1 2 3; do capture --rays 32 --slice $i/3 "$scene" placed.probe >slice$i.probe; done
rows_of position,validity slice2.probe >slice2.rows
check "slice 2/3 captures every third probe, from the second" has_lines "$probes" slice2.rows \
    and every '(FNR % 3 == 2) == ($4 != "nan")' slice2.rows
check "and leaves the others as they are" [ "$(lit slice2.probe)" -eq $(((probes + 1) / 3)) ]
for order in "1 2 3" "3 1 2" "2 3 1"; do
    set -- $order
    probe-cat --fill slice$2.probe --fill slice$3.probe slice$1.probe >filled.probe
    check "slices $order fill up to the whole, byte for byte, cells as well" \
        same_rows filled.probe whole.probe
done
probe-cat --fill slice1.probe --fill slice2.probe --fill slice3.probe placed.probe >filled.probe
check "and so they fill what was placed" same_rows filled.probe whole.probe
capture --slice 2/3 "$scene" slice1.probe | capture --slice 3/3 "$scene" >chained.probe
check "slices one after the other are the whole, too" same_rows chained.probe whole.probe
probe-cat --text placed.probe | capture --rays 32 --slice 1/1 "$scene" >text.probe
check "1/1 is all, in text as in binary" same_rows text.probe whole.probe
capture --rays 32 --slice 999/1000 "$scene" placed.probe >none.probe
check "a slice may have no probes" [ "$(lit none.probe)" -eq 0 ]
probe-capture --slice 1/3 "$scene" slice1.probe 2>err >again.probe
check "a slice that is done is said to be" \
    says err "all $third probes of the slice have light already"
capture --again --rays 16 --slice 1/3 "$scene" whole.probe >again.probe
check "captured again, the others lose their light: other settings made it" \
    [ "$(lit again.probe)" -eq $third ]
capture --rays 16 "$scene" placed.probe >other.probe
refused 1 "capture-rays is 16, and theirs is 32" probe-cat --fill other.probe slice1.probe
for slice in 0/3 4/3 1/0 -1/3 x 1 1/ /3 1/3x 1/3/3 1.5/3 ''; do
    refused 2 "--slice: expected I/N" probe-capture --slice "$slice" "$scene" placed.probe
done
refused 2 "--slice needs a fixed --order" \
    probe-capture --slice 1/2 --order auto "$scene" placed.probe

# -- killed ----------------------------------------------------------------------------------------
# Whoever reads a pipe slowly holds up who writes it: after a part of the rows, others are still to
# come. The pipe holds 64 KiB, and there are five blocks of rows, each larger.
mkfifo pipe
probe-place grid -q --count 4500 --inside keep "$scene" >placed.binary
probe-cat --text placed.binary >placed.text
probes=$(grep -c '^[0-9-]' placed.text)
capture --rays 64 "$scene" placed.binary >whole.binary
part=$(($(wc -c <whole.binary) / 4)) # so much is left that none ends before a signal comes
for encoding in text binary; do
    probe-capture $options --rays 64 "$scene" placed.$encoding >pipe &
    program=$!
    exec 3<pipe
    head -c $part <&3 >killed
    kill -9 $program
    wait $program 2>/dev/null
    cat <&3 >>killed
    exec 3<&-
    check "$encoding: a killed capture is in its middle" test -s killed and not probe-cat killed
    probe-cat --salvage killed >salvaged 2>salvaged.err
    kept=$(lit salvaged)
    check "$encoding: some rows are salvaged" [ "$kept" -gt 0 -a "$kept" -lt "$probes" ]
    check "$encoding: and it is said how many" \
        says salvaged.err ": $kept rows of table probe are kept"
    probe-cat --quiet --salvage --fill killed placed.$encoding >resumed
    check "$encoding: they fill what was placed" [ "$(lit resumed)" -eq "$kept" ]
    capture "$scene" resumed >finished
    check "$encoding: the rest is captured, and all is as in one go" \
        same_rows finished whole.binary
done

# -- asked to end ----------------------------------------------------------------------------------
# ends FILE: after a signal it holds a whole stream with some light, and status and message say so
ends() {
    ends_lit=$(lit "$1")
    ends_text="probe-capture: interrupted: $ends_lit of $probes probes captured; given back to"
    [ "$status" -eq 1 ] && [ "$ends_lit" -gt 0 ] && [ "$ends_lit" -lt "$probes" ] &&
        says err "^$ends_text probe-capture, the rest is captured$"
}
for signal in TERM INT; do
    env --default-signal=INT probe-capture $options --rays 64 "$scene" placed.binary >pipe 2>err &
    program=$!
    exec 3<pipe
    head -c $part <&3 >ended
    kill -$signal $program
    cat <&3 >>ended
    exec 3<&-
    wait $program
    status=$?
    check "SIG$signal: what was captured is written, status 1" ends ended
    capture "$scene" ended >finished
    check "SIG$signal: given back, the rest is captured, and all is as in one go" \
        same_rows finished whole.binary
done

# What /proc knows of a process. ready: it is the program by now, no more the shell that starts it,
# and has a handler of SIGTERM, which it gets when the scene is read. took: no signal waits for it.
# works: it has computed for ten milliseconds since "ticks" was written, and so, behind the reading
# of the scene, is in its probes.
ready() {
    grep -qx probe-capture "/proc/$1/comm" && says "/proc/$1/status" '^SigCgt:.*[4-7c-f]...$'
}
took() { says "/proc/$1/status" '^ShdPnd:[[:space:]]*0*$'; }
ticks() { awk '{ print $14 }' "/proc/$1/stat"; }
works() { [ "$(ticks "$1")" -ge $(($(cat ticks) + 2)) ]; }
# in_work PID: it has begun its first probes, and will not end by itself
in_work() {
    wait_for ready "$1" >waits && ticks "$1" >ticks && wait_for works "$1"
}
# goes_on PID: it took the signal, and went on
goes_on() {
    wait_for took "$1" && ticks "$1" >ticks && wait_for works "$1"
}
if [ -r /proc/self/status ]; then
    echo old >kept
    probe-capture $options --rays 100000 --output kept "$scene" placed.binary 2>err &
    program=$!
    in_work $program
    kill -TERM $program
    wait $program
    status=$?
    check "SIGTERM: a file named by --output appears, whole" probe-cat kept \
        and [ $status -eq 1 ] and says err "interrupted: [0-9]* of $probes probes captured"
    check "no probe beyond those in work was captured" [ "$(lit kept)" -lt "$probes" ]

    echo old >kept
    probe-cat --rows 0:20 placed.binary >few.probe
    probe-capture $options --rays 16777216 --output kept "$scene" few.probe 2>err &
    program=$!
    in_work $program
    kill -TERM $program
    check "a probe that takes long is waited for" goes_on $program
    kill -TERM $program
    wait $program 2>/dev/null
    check "a second signal ends at once" [ $? -eq 143 ]
    ls -A >names
    check "and leaves the old file" [ "$(cat kept)" = old ] and lacks names '^\.probe'

    env --ignore-signal=INT probe-capture $options --rays 16777216 "$scene" few.probe >ended 2>err &
    program=$!
    in_work $program
    kill -INT $program
    kill -INT $program
    check "a signal that is ignored stays ignored" goes_on $program
    kill -9 $program
    wait $program 2>/dev/null
else
    skip "there is no /proc to see a signal's handler in"
fi
tap_done
