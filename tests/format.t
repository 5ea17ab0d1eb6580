#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Sources are in the one form of .clang-format, nothing is wider than 100 columns, and every source
# says its licence. Then faults are planted in a copy, and each must be found.
. "${SRC:?}/tests/support/setup.sh"

if ! command -v clang-format >/dev/null; then
    skip "clang-format is not installed"
    tap_done
fi

check "scripts/format --check finds nothing" "$SRC/scripts/format" --check

mkdir copy
cp -R "$SRC/src" "$SRC/tests" "$SRC/doc" "$SRC/scripts" "$SRC/.clang-format" "$SRC/Makefile.am" \
    "$SRC/configure.ac" copy

# found FILE LINE: with this line at its end, the file is named.
found() {
    cp "copy/$1" kept
    printf '%s\n' "$2" >>"copy/$1"
    copy/scripts/format --check >named 2>&1
    cp kept "copy/$1"
    check "found in $1: $(printf %.24s "$2")" grep -q "$1" named
}
found src/base/array.c 'static  int   badly_set;'
found src/base/array.c "/* $(printf '%0110d' 0) */"
found tests/pipeline.t "# $(printf '%0110d' 0)"
found scripts/demo "# $(printf '%0110d' 0)"
printf 'int unlicensed;\n' >copy/src/base/unlicensed.c
copy/scripts/format --check >named 2>&1
check "found: a source that does not say its licence" grep -q src/base/unlicensed.c named

tap_done
