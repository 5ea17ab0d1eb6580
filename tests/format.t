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

# planted FILE LINE: at its end; one run finds them all.
: >planted
planted() {
    printf '%s\n' "$2" >>"copy/$1"
    echo "$1" >>planted
}
planted src/base/array.c 'static  int   badly_set;'
planted src/base/error.c "/* $(printf '%0110d' 0) */"
planted tests/pipeline.t "# $(printf '%0110d' 0)"
planted scripts/demo "# $(printf '%0110d' 0)"
planted src/base/unlicensed.c 'int unlicensed;'
copy/scripts/format --check >named 2>&1
check "faults are: it fails" [ $? -ne 0 ]
while read -r file; do
    check "found: what is wrong with $file" says named "$file"
done <planted
check "and nothing else" [ "$(grep -oE '^[a-z]+/[a-z/._-]+' named | sort -u | wc -l)" = 5 ]

tap_done
