#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The manual keeps its promises: pages are lint-clean, every option of --help is in its page and the
# other way round, and every program names itself and its version.
. "${SRC:?}/tests/support/setup.sh"

if sanitized; then
    skip "pages are read once, with the plain build"
elif command -v mandoc >/dev/null; then
    for page in "$SRC"/man/*.[1357]; do
        check "${page##*/} is lint-clean" mandoc -T lint -W warning "$page"
    done
else
    skip "mandoc is not installed: pages are not linted"
fi

# letters COMMAND...: letters and digits of a page's text, without its first and last line, which
# say "BSD" in some; words may be cut in others' places
letters() {
    "$@" 2>said | sed '1d; $d; s/\x1b\[[0-9;]*m//g; s/.\x08//g' | tr -cd 'A-Za-z0-9' | fold -w 60
}

# What `man` shows, on most systems groff's, is what mandoc does: a title that begins with the name
# of a macro (An, It) ends the page there if it is not escaped.
if sanitized; then
    skip "and compared once"
elif command -v groff >/dev/null && command -v mandoc >/dev/null; then
    for page in "$SRC"/man/*.[1357]; do
        letters mandoc -T utf8 "$page" >by-mandoc
        letters groff -K utf8 -mdoc -Tutf8 -ww -rcR=1 "$page" >by-groff
        check "groff has no warning about ${page##*/}" empty said
        check "it shows all of ${page##*/}" test -s by-groff and diff by-mandoc by-groff
    done
else
    skip "groff or mandoc is not installed: pages are not compared"
fi

for page in "$SRC"/man/probe-*.1; do
    program=${page##*/}
    program=${program%.1}
    [ -x "$BUILD/src/$program" ] || { skip "$program is not built"; continue; }
    "$program" --version >version
    check "$program --version names program and package" \
        says version "^$program (probe-tools) [0-9]"
    "$program" --help | grep -oE '^ +(-[a-z], )?--[a-z-]+' | grep -oE -- '--[a-z-]+' |
        grep -vxE -- '--(help|version)' | sort -u >in-help
    # mdoc writes --name as `Fl -name`, in text also `\-\-name`.
    grep -oE '(Fl|,) -[a-z][a-z-]+' "$page" | sed 's/.* /-/' |
        grep -vxE -- '--(help|version)' | sort -u >in-page
    check "$program: --help and the page list the same options" \
        diff in-help in-page and test -s in-page
    refused 2 "--no-such-option" "$program" --no-such-option
done

tap_done
