#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The house keeps its order: a folder of src/ includes itself and those that Makefile.am lists
# before it; modules do not include each other in circles; a dependency is included in one folder
# alone.
# Then faults are planted in a copy, and each must be found: a check that cannot fail is none.
SRC=$(cd "${SRC:?}" && pwd) || exit 99 # by hand it may be relative
. "$SRC/tests/support/setup.sh"

# Which folder hides which header: a regular expression of what is between the brackets. Two have
# more than one home: libprobe-query, which stands alone, checks packed files with an xxHash of its
# own; query.c answers blocks in turn as a pipe gives them, which threads_for, a loop, cannot.
cat >homes <<'END'
trace           embree3/
tetra           tetgen
topology        OpenMesh/
import          tiny_gltf|tiny_obj|nlohmann/
image           stb_image|webp/|openexr
math            Random123/
vtk             vtk
base            pthread
src/interpolate/query.c pthread
math            xxhash
libprobe-query  xxhash
END

# layers TREE: writes a line `file: what is wrong` for each fault, and the lists that follow from
# it: `arrows` (folder, folder, how many includes).
layers() {
    sed -n 's,^include src/\(.*\)/sources.mk$,\1,p' "$1/Makefile.am" >order
    (cd "$1" && find src -name '*.c' -o -name '*.cc' -o -name '*.h') | sort >files
    (cd "$1" && xargs grep -H '^ *# *include *["<]') <files |
        sed 's,^\([^:]*\): *# *include *\(["<][^">]*\)[">].*,\1 \2,' >includes
    awk '
        FILENAME == "order" { rank[$1] = ++folders; name[folders] = $1; next }
        FILENAME == "homes" { homes[$2] = homes[$2] " " $1 " "; next }
        FILENAME == "files" {
            known[$1] = 1
            if (split($1, part, "/") == 3 && !(part[2] in rank))
                print $1 ": its folder is not in Makefile.am"
            else if (split($1, part, "/") > 3)
                print $1 ": folders of src have no folders"
            next
        }
        {
            split($1, part, "/")
            folder = part[3] ? part[2] : ""     # of a program: none, above all
            kind = substr($2, 1, 1)
            header = substr($2, 2)
        }
        kind == "<" {
            for (what in homes)
                if (header ~ "^(" what ")" && !index(homes[what], " " folder " ") &&
                    !index(homes[what], " " $1 " "))
                    print $1 ": <" header "> has its home elsewhere:" homes[what]
            if (folder == "libprobe-query" && header ~ "/" && header != "sys/mman.h")
                print $1 ": <" header "> is neither of libc nor of libm"
            next
        }
        folder == "libprobe-query" {
            if (!(("src/libprobe-query/" header) in known))
                print $1 ": \"" header "\" is not in src/libprobe-query, which stands alone"
            next
        }
        {
            split(header, of, "/")
            if (header == "config.h")
                next
            if (!(("src/" header) in known) || !of[2]) {
                print $1 ": \"" header "\" is no FOLDER/FILE of src"
                next
            }
            count[folder, of[1]]++
            if (folder && rank[of[1]] > rank[folder])
                print $1 ": \"" header "\" is above src/" folder
            if (header ~ /_private.h$/ && of[1] != folder)
                print $1 ": \"" header "\" is private to src/" of[1]
            if (of[1] == "tetra" && folder != "tetra" && $1 != "src/probe-tet.c")
                print $1 ": \"" header "\": the AGPL part is for probe-tet alone"
            if (of[1] == "vtk" && folder != "vtk" && $1 != "src/probe-vtk.c")
                print $1 ": \"" header "\": VTK is for probe-vtk alone"
        }
        END {
            for (pair in count) {
                split(pair, ends, SUBSEP)
                print ends[1] ? ends[1] : "programs", ends[2], count[pair] > "arrows"
            }
        }' order homes files includes
    circles
}

# circles: modules (a .c or .cc, its .h, and what its parts share, _private.h and _local.h, are one)
# that include each other, straight or by others.
circles() {
    awk '{
        from = $1; to = substr($2, 2)
        sub(/(_private|_local)?\.[a-z]+$/, "", from)
        sub(/(_private|_local)?\.[a-z]+$/, "", to)
        if (substr($2, 1, 1) == "<")
            next
        to = (from ~ /^src\/libprobe-query\// ? "src/libprobe-query/" : "src/") to
        if (from != to)
            print from, to
    }' includes | sort -u | tsort 2>&1 >/dev/null |
        sed -n 's,^tsort: \(src/.*\),\1: is in a circle of includes,p'
}

layers "$SRC" >faults
check "no include upward, in a circle, or of a dependency outside of its home" diff /dev/null faults
[ "$(wc -l <order)" -ge 18 ] || fail "the folders are in Makefile.am" "$(cat order)"
[ -s arrows ] || fail "there are includes to be looked at"
sed 's/^/# /' arrows | sort

# found NAME FILE LINE: with this line added to the file, layers names the file.
mkdir planted
cp -R "$SRC/src" "$SRC/Makefile.am" planted
found() {
    mkdir -p "planted/${2%/*}"
    [ ! -e "planted/$2" ] || cp "planted/$2" kept
    printf '%s\n' "$3" >>"planted/$2"
    layers planted >found
    rm "planted/$2"
    [ ! -e "$SRC/$2" ] || mv kept "planted/$2"
    check "found: $1" grep -q "^${2%.*}.*: " found
}
found "a folder that includes one above it" src/base/array.c '#include "stream/stream.h"'
found "a lower folder that includes far up" src/image/flip.c '#include "scene/scene.h"'
found "two modules that include each other" src/base/error.h '#include "base/array.h"'
found "a dependency outside of its home" src/capture/capture.c '#include <embree3/rtcore.h>'
found "a dependency of one file in another" src/interpolate/baked.c '#include <pthread.h>'
found "TetGen outside of src/tetra" src/leak/leak.c '#include <tetgen.h>'
found "the AGPL part in another program" src/probe-cat.c '#include "tetra/tetra.h"'
found "VTK's part in another program" src/probe-cat.c '#include "vtk/vtk_export.h"'
found "something of ours in libprobe-query" src/libprobe-query/sh.c '#include "base/error.h"'
found "something of others in libprobe-query" src/libprobe-query/sh.c '#include <webp/decode.h>'
found "an include without its folder" src/base/array.c '#include "error.h"'
found "a private header elsewhere" src/capture/capture.c '#include "stream/stream_private.h"'
found "a folder that is not listed" src/misc/misc.c '#include "base/error.h"'

tap_done
