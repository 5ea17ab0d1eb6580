#!/bin/sh
# The manual keeps its promises: pages are lint-clean, every option of --help is in its page and the
# other way round, and every program names itself and its version.
. "${SRC:?}/tests/support/setup.sh"

if command -v mandoc >/dev/null; then
    for page in "$SRC"/man/*.[1357]; do
        check "${page##*/} is lint-clean" mandoc -T lint -W warning "$page"
    done
else
    skip "mandoc is not installed: pages are not linted"
fi

for page in "$SRC"/man/probe-*.1; do
    program=${page##*/}
    program=${program%.1}
    [ -x "$BUILD/src/$program" ] || { skip "$program is not built"; continue; }
    check "$program --version names program and package" sh -c "$program --version | grep -q '^$program (probe-tools) [0-9]'"
    "$program" --help | grep -oE '^ +(-[a-z], )?--[a-z-]+' | grep -oE -- '--[a-z-]+' |
        grep -vxE -- '--(help|version)' | sort -u >in-help
    # mdoc writes --name as `Fl -name`, in text also `\-\-name`.
    grep -oE '(Fl|,) -[a-z][a-z-]+' "$page" | sed 's/.* /-/' | grep -vxE -- '--(help|version)' | sort -u >in-page
    check "$program: --help and the page list the same options" diff in-help in-page
    refused 2 "--no-such-option" "$program" --no-such-option
done

tap_done
