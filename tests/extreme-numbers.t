#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The whole pipeline at the ends of its range (scripts/extremes, in its short form), and that its
# table can fail.
. "${SRC:?}/tests/support/setup.sh"
extremes=$SRC/scripts/extremes

# With sanitizers, what scale and place do to all programs; that of radiance and albedo is seen by
# tests/capture_extremes.
rows=
! sanitized || rows="scaled moved grid probe needles triangle query"
# shellcheck disable=SC2086 # a list
"$extremes" --short $rows >table 2>err
status=$?
sed 's/^/# /' table
tail -n 1 table >summary
check "every extreme is as good as comfortable numbers, or refused" [ "$status" -eq 0 ]
check "nothing went wrong in the table itself" empty err
check "it has its rows" says summary '^[2-9][0-9] rows, 0 failed'
sanitized && { skip "that the table can fail is seen in the plain build"; tap_done; }

# broken PROGRAM: what stands in for it among the others, from standard input
broken() {
    rm -rf broken
    mkdir -p broken/src
    for program in "$BUILD"/src/probe-*; do
        if [ -x "$program" ]; then ln -s "$program" broken/src/; fi
    done
    rm -f "broken/src/$1"
    { echo '#!/bin/sh'; cat; } >"broken/src/$1"
    chmod +x "broken/src/$1"
}

# fails VERDICT ROW: the table with what is broken
fails() {
    BUILD=$PWD/broken "$extremes" --short "$2" >table 2>err
    fails_status=$?
    cat err
    says table "$1" && [ $fails_status -eq 1 ]
}

# The comfortable wall ends at 4.718.
broken probe-leakfix <<SH
if grep -q '^v 4.718' scene.obj; then exec "$BUILD/src/probe-leakfix" "\$@"; fi
exec cat
SH
check "a leakfix that mends thick walls alone is seen" fails 'FAILED$' 'between probes'
broken probe-query <<SH
exec "$BUILD/src/probe-query" "\$@" |
    awk '{ for (i = 1; i <= NF; i++) \$i = \$i > 1e20 ? 0 : \$i; print }'
SH
check "light that is lost above 1e20 is seen" fails 'FAILED$' 'lamp times 1e+30'
broken probe-query <<'SH'
kill -SEGV $$
SH
check "a program that dies is no refusal" fails 'FAILED: probe-query .*status -11' 'nan 1 1'
broken probe-query <<'SH'
echo 0 0 0
SH
check "an answer where none can be is a failure" fails 'FAILED$' 'nan 1 1'
broken probe-query <<'SH'
echo 'probe-query: no' >&2
exit 1
SH
check "so is a refusal that does not say why" fails 'FAILED, refused: probe-query: no' 'nan 1 1'
tap_done
