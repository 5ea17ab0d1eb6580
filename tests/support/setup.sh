# SPDX-License-Identifier: Apache-2.0
# setup: what every test script sources. Results are TAP, as in tests/support/tap.h.
#
#   . "${SRC:?}/tests/support/setup.sh"
#   check "adjacency survives a round trip" cmp a b
#   refused 1 "stdin:3: expected 3 numbers, got 2" probe-cat <bad.probe
#   wait_for test -s out
#   tap_done                      # refused: the status, and a part of what is said
#
# A script runs in a directory of its own that is removed at the end.

set -u
LC_ALL=C
export LC_ALL
# Leaks are looked for in the modules' tests, and here where a script says so before it comes: for
# most runs of a program it takes longer than all else.
# Two frames of who asked for memory are kept: all thirty are a tenth of the time.
if [ -z "${looks_for_leaks-}" ]; then
    ASAN_OPTIONS=${ASAN_OPTIONS-detect_leaks=0:malloc_context_size=2}
    export ASAN_OPTIONS
fi
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

# check NAME COMMAND... [and COMMAND...]: each of the commands succeeds.
check() {
    check_name=$1
    shift
    while [ $# -gt 0 ]; do
        check_words= check_count=0
        for check_word; do
            [ "$check_word" != and ] || break
            check_count=$((check_count + 1))
            check_words="$check_words \"\${$check_count}\""
        done
        eval "$check_words" >check.out 2>&1
        check_status=$?
        if [ $check_status -ne 0 ]; then
            fail "$check_name" "status $check_status: $*
$(head -n 20 check.out)"
            return
        fi
        shift $check_count
        [ $# -eq 0 ] || shift
    done
    pass "$check_name"
}

# What a command of check or refused may be:
#
#   says FILE PATTERN...      each pattern is in the file
#   lacks FILE PATTERN...     none is
#   has_lines COUNT FILE
#   empty FILE                (test -s FILE: it is not)
#   differ A B                both are there, and not the same
#   same_stream A B           but for their history
#   not COMMAND...
#   every CONDITION FILE...   awk's condition holds for each line, and there are lines; it may use
#                             near(A, B, EPS), and N of N=VALUE among the files
#   near EPS A B              two files' numbers, line by line, differ by EPS at most
#   given TEXT COMMAND...     with this as standard input, in lines
#   into FILE COMMAND...      with standard output there
says() {
    says_file=$1
    shift
    for says_pattern; do
        grep -aq -e "$says_pattern" "$says_file" && continue
        echo "$says_file does not say: $says_pattern"
        head -n 10 "$says_file"
        return 1
    done
}

lacks() {
    lacks_file=$1
    shift
    [ -e "$lacks_file" ] || return
    for lacks_pattern; do
        grep -a -e "$lacks_pattern" "$lacks_file" || continue
        echo "$lacks_file says: $lacks_pattern"
        return 1
    done
}

has_lines() {
    has_lines_got=$(wc -l <"$2")
    [ "$has_lines_got" -eq "$1" ] && return
    echo "$2 has $has_lines_got lines"
    return 1
}

empty() {
    [ -e "$1" ] && [ ! -s "$1" ] && return
    head -n 10 "$1"
    return 1
}

not() { ! "$@"; }

every() {
    every_condition=$1
    shift
    awk 'function near(a, b, eps) { return (a - b) ^ 2 <= eps ^ 2 }
        { seen = 1 }
        !('"$every_condition"') { print FILENAME ":" FNR ": " $0; bad = 1; exit }
        END { exit bad || !seen }' "$@"
}

near() {
    paste -d '\n' "$2" "$3" | awk -v eps="$1" '
        NR % 2 { n = split($0, want); next }
        { bad = NF != n || n == 0 }
        { for (i = 1; i <= NF; i++) if (!(($i - want[i]) ^ 2 <= eps ^ 2)) bad = 1 }
        bad { print NR / 2 ": " $0; exit }
        END { exit bad || NR == 0 }'
}

given() {
    given_text=$1
    shift
    printf '%s\n' "$given_text" | "$@"
}

into() {
    into_file=$1
    shift
    "$@" >"$into_file"
}

differ() {
    cmp -s "$1" "$2"
    [ $? -eq 1 ]
}

same_stream() {
    probe-cat --text --no-provenance "$1" >same_stream.a || return
    probe-cat --text --no-provenance "$2" >same_stream.b || return
    test -s same_stream.a && cmp same_stream.a same_stream.b
}

# plain_libm COMMAND...: a program, without the faster instructions that libm takes where it can
plain_libm() {
    env GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-AVX512F "$@"
}

# as_text TYPE COUNT: binary numbers of standard input (f4, f8, d4) as text, COUNT a line
as_text() {
    as_text_size=${1#?}
    od -An -v -w$(($2 * as_text_size)) -t"$1"
}

# numbers: the rows of a stream in text on standard input that begin with a number
numbers() { grep '^[0-9-]'; }

# rows_of COLUMNS STREAM: these of its probes, position among them and first
rows_of() { probe-cat --text --no-provenance --tables probe --columns "$1" "$2" | numbers; }

# row_count TABLE STREAM
row_count() { probe-cat --info "$2" | sed -n "s/^table $1: \([0-9]*\) rows.*/\1/p"; }

# stream_of LINE...: a stream of these lines and of the rows on standard input
stream_of() {
    printf '%s\n' '#?probe 1' "$@"
    cat
    echo end
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

# sanitized: this is a build with sanitizers
# plain_build NAME: whether this is not the sanitizers' build; else NAME is skipped. For what runs
# the code of other checks again and is here for its results.
plain_build() {
    sanitized || return 0
    skip "$1 is seen in the plain build"
    return 1
}
sanitized() {
    case "${CFLAGS-} ${LDFLAGS-}" in *-fsanitize*) return 0 ;; *) return 1 ;; esac
}

tap_done() {
    printf '1..%d\n' "$tap_count"
    [ "$tap_failed" -eq 0 ]
    exit
}
