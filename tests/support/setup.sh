# setup: what every test script sources. Results are TAP, as in tests/support/tap.h.
#
#   . "${SRC:?}/tests/support/setup.sh"
#   check "adjacency survives a round trip" cmp a b
#   refused 1 "stdin:3: expected 3 numbers, got 2" probe-cat <bad.probe     # status and a part of the message
#   wait_for test -s out
#   tap_done
#
# A script runs in a directory of its own that is removed at the end.

set -u
LC_ALL=C
export LC_ALL
tap_count=0
tap_failed=0
tap_directory=$(mktemp -d "${TMPDIR:-/tmp}/probe-test.XXXXXX") || exit 99
trap 'rm -rf "$tap_directory"' EXIT
trap 'exit 1' HUP INT TERM
cd "$tap_directory" || exit 99

pass() {
    tap_count=$((tap_count + 1))
    printf 'ok %d - %s\n' "$tap_count" "$1"
}

# fail NAME [WHAT WAS SEEN]
fail() {
    tap_count=$((tap_count + 1))
    tap_failed=$((tap_failed + 1))
    printf 'not ok %d - %s\n' "$tap_count" "$1"
    if [ $# -gt 1 ]; then printf '%s\n' "$2" | sed 's/^/# /'; fi
}

skip() {
    tap_count=$((tap_count + 1))
    printf 'ok %d # SKIP %s\n' "$tap_count" "$1"
}

# check NAME COMMAND...: the command succeeds.
check() {
    check_name=$1
    shift
    if "$@" >check.out 2>&1; then pass "$check_name"; else fail "$check_name" "status $?: $* 
$(head -n 20 check.out)"; fi
}

# refused STATUS TEXT COMMAND...: the command exits with STATUS, says TEXT on standard error, and
# what it left on standard output does not pass for a whole stream.
refused() {
    refused_status=$1
    refused_text=$2
    shift 2
    "$@" >refused.out 2>refused.err
    refused_got=$?
    refused_name="refused: $refused_text"
    if [ "$refused_got" -ne "$refused_status" ]; then
        fail "$refused_name" "status $refused_got instead of $refused_status: $*
$(head -n 5 refused.err)"
    elif ! grep -qF -- "$refused_text" refused.err; then
        fail "$refused_name" "message: $(head -n 5 refused.err)"
    elif [ -s refused.out ] && tail -n 1 refused.out | grep -aq '^end'; then
        fail "$refused_name" "a whole stream was written all the same"
    else
        pass "$refused_name"
    fi
}

# wait_for COMMAND...: until it succeeds, a minute at most
wait_for() {
    wait_left=600
    until "$@"; do
        wait_left=$((wait_left - 1))
        [ $wait_left -gt 0 ] || return 1
        sleep .1
    done
}

tap_done() {
    printf '1..%d\n' "$tap_count"
    [ "$tap_failed" -eq 0 ]
    exit
}
