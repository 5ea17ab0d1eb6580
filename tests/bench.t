#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Every part of scripts/bench still works: each prints its tables when it runs on next to nothing.
. "${SRC:?}/tests/support/setup.sh"
command -v python3 >/dev/null || { skip "python3 is not installed: no bench"; tap_done; }
bench="$SRC/scripts/bench --build $BUILD"

refused 2 "unknown part nonsense: expected stream, " $bench --short nonsense
parts=$($bench nonsense 2>&1 | sed -n 's/.*unknown part nonsense: expected //p' | tr -d ,)
$bench --help >help
are_told() { # PART...
    [ $# -gt 0 ] || return
    for part; do
        [ -e "$SRC/scripts/benches/$part.py" ] && says help "^  $part  *[a-z0-9]" || return
    done
}
check "no part lacks its file, and none its words in --help" are_told $parts

# are_tables: a title, a line of names indented, lines of figures likewise; at least one such table
are_tables() {
    awk '/^[^ ]/ { if (titles && lines < 2) bad = 1; titles++; lines = 0 }
        /^  [^ ]/ { lines++; if (lines > 1 && /[0-9]/) figures++ }
        END { exit bad || !titles || lines < 2 || figures < titles }' "$1"
}

# what a part's tables begin with
title() {
    case $1 in
    stream) echo 'stream, text: ' ;;
    threads) echo 'capture on threads: ' ;;
    rays | render) echo 'rays of all kinds, one thread: ' ;;
    tet) echo 'probe-tet beside TetGen alone' ;;
    query) echo 'query, cold: ' ;;
    scene) echo 'pipeline: ' ;;
    *) echo "$1: " ;;
    esac
}

for part in $parts; do
    if ! $bench --short "$part" >"$part.out" 2>"$part.err"; then
        fail "bench $part" "$(cat "$part.out" "$part.err")"
    elif grep "^bench: $part: skipped: " "$part.err" >skipped; then
        skip "$(cat skipped)"
    elif grep -qF "$(title "$part")" "$part.out" && are_tables "$part.out"; then
        pass "bench $part"
    else
        fail "bench $part: expected its tables" "$(cat "$part.out" "$part.err")"
    fi
done

# -- figures ---------------------------------------------------------------------------------------
cat >time_to.py <<'PY'
import sys
sys.path.insert(0, sys.argv[1])
from benches.error import time_to
for curve in (((.1, 1), (.01, 100)), ((.1, -.2), (.01, .5)), ((.1, .2), (.01, -.5)),
              ((.03, 2), (.03, 3)), ((.02, 4), (.01, 5)), ((.2, 4), (.1, 5))):
    print(time_to(curve, .03))
PY
printf '%s\n' 11.111 'below 0.500' 'below 0.200' 2.000 'below 4.000' 'above 5.000' >expected
check "bench error: seconds to an error, if few are lost in those without rays" \
    into got env PYTHONDONTWRITEBYTECODE=1 python3 time_to.py "$SRC/scripts" and diff expected got
cat >seconds_to.py <<'PY'
import sys
sys.path.insert(0, sys.argv[1])
from benches.cache import Curve, error_of
def curve(*points):
    c = Curve("way", "rays")
    for i, (error, seconds) in enumerate(points):
        c.add(i, seconds, [[[1 + error] + 26 * [0]], [[1 - error] + 26 * [0]]], [[1] + 26 * [0]])
    return c
for c in (curve((.1, 1), (.01, 100)), curve((.02, 2), (.01, 4)), curve((.1, 1), (.05, 2)),
          curve((.1, 1), (.02, 2), (.04, 3), (.01, 4))):
    seconds = c.seconds_to(.03)
    print("never" if seconds is None else f"{seconds:.3f}")
print(f"{error_of([3, 4], [3, 0]):.3f}")
PY
printf '%s\n' 11.111 2.000 never 3.185 1.333 >expected
check "bench cache: seconds until an error stays below a goal" \
    into got env PYTHONDONTWRITEBYTECODE=1 python3 seconds_to.py "$SRC/scripts" \
    and diff expected got
$bench --short --light '--point 1,1,1,1,1,1' cycles 2>skipped
check "bench cycles: what Cycles cannot be told is not compared" \
    says skipped '^bench: cycles: skipped: .*[a-z]'
case "${LDFLAGS-} " in
*-fsanitize*) skip "sanitizers have memory of their own" ;;
*) check "bench scene: the peak is the program's, not Python's" \
    every '$1 != "probe-tet" || $3 > 0 && $3 < 8' scene.out ;;
esac

# -- what fails ------------------------------------------------------------------------------------
mkdir -p broken/src
for program in "$BUILD"/src/probe-*; do
    if [ -x "$program" ]; then ln -s "$program" broken/src/; fi
done
rm -f broken/src/probe-capture
printf '#!/bin/sh\nexit 3\n' >broken/src/probe-capture
chmod +x broken/src/probe-capture
refused 1 "exit status 3" "$SRC/scripts/bench" --build broken --short columns
tap_done
