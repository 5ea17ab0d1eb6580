#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The picture of a sky is found by the stages that follow capture: from another folder, after the
# whole has moved, without its first place; and a picture that is another is told apart.
. "${SRC:?}/tests/support/setup.sh"

# sky FILE BRIGHT: an even panorama of 8 x 4, its light a power of 2 (201: 1, 202: 2)
sky() {
    {
        printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n'
        for sky_texel in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 \
            28 29 30 31 32; do
            printf '\200\200\200\'"$2"
        done
    } >"$1"
}

mkdir -p work/scenes 'work/skies/of  may' elsewhere
printf '%s\n' 'v 0 0 0' 'v 2 0 0' 'v 2 0 2' 'v 0 0 2' 'v 1 .5 .5' 'v 1 .5 1.5' 'v 1 1.5 1' \
    'f 1 4 3 2' 'f 5 6 7' >work/scenes/yard.obj
sky 'work/skies/of  may/noon.hdr' 201
(cd work && probe-place grid -q --count 12 scenes/yard.obj |
    probe-capture -q --rays 32 --bounces 1 --text --sky 'skies/of  may/noon.hdr' scenes/yard.obj |
    probe-tet -q >baked.probe)
here=$(pwd -P)
check "the header has the picture's absolute name, that from the scene, and its key" \
    says work/baked.probe "^sky-file $here/work/skies/of  may/noon.hdr\$" \
    '^sky-from-scene \.\./skies/of  may/noon.hdr$' '^sky-key [0-9a-f]\{16\}$'

# stages SCENE BAKED OUTPUT: everything that sees the scene after capture
stages() {
    probe-capture -q --again --text "$1" "$2" >"$3.again" &&
        probe-leakfix -q "$1" "$2" >"$3.fixed" &&
        probe-error -q --points 20 --paths 16 "$1" "$2" >"$3.error" &&
        probe-render -q --size 16x8 --samples 1 --eye 3,2,3 -o "$3.pfm" "$1" "$2"
}
# probe_render_says SCENE BAKED: its warnings
probe_render_says() {
    probe-render --size 16x8 --samples 1 --eye 3,2,3 -o said.pfm "$1" "$2" 2>&1 >/dev/null
}
# none_dark STREAM: every probe has light
none_dark() { probe-cat -q --text --columns position,sh "$1" | numbers >lit && every '$4 > 0' lit; }

(cd work && stages scenes/yard.obj baked.probe "$here/near") 2>err
check "in the folder of the capture all stages see it" empty err and test -s near.error \
    and none_dark near.again
(cd elsewhere && stages ../work/scenes/yard.obj ../work/baked.probe "$here/far") 2>err
check "from another folder they do the same" empty err and same_stream near.again far.again \
    and same_stream near.fixed far.fixed and cmp near.error far.error and cmp near.pfm far.pfm
mv work moved
stages moved/scenes/yard.obj moved/baked.probe gone 2>err
check "and after the whole has moved" empty err and same_stream near.fixed gone.fixed \
    and cmp near.error gone.error and cmp near.pfm gone.pfm
check "a new header has its new name" \
    says gone.again "^sky-file $here/moved/skies/of  may/noon.hdr\$"
check "with the light of before" into got rows_of position,sh gone.again \
    and into wanted rows_of position,sh near.again and cmp got wanted
mv 'moved/skies/of  may/noon.hdr' moved/scenes/
stages moved/scenes/yard.obj moved/baked.probe beside 2>err
check "and where it stands beside the scene" empty err and cmp near.pfm beside.pfm
mkdir work 'work/skies'
mkdir 'work/skies/of  may'
sky 'work/skies/of  may/noon.hdr' 202
stages moved/scenes/yard.obj moved/baked.probe beside 2>err
check "another picture under its name is passed over for the right one" empty err \
    and cmp near.error beside.error

# -- another picture, and none ---------------------------------------------------------------------
rm moved/scenes/noon.hdr
probe-leakfix moved/scenes/yard.obj moved/baked.probe 2>err >changed.fixed
check "another picture alone is a warning that says so" \
    says err "warning: $here/work/skies/of  may/noon.hdr: this is not the sky that the probes"
check "and not that the scene is another" lacks err 'not the scene' and \
    [ "$(grep -c warning err)" = 1 ]
check "nor does probe-render" \
    into err probe_render_says moved/scenes/yard.obj moved/baked.probe and \
    says err 'this is not the sky' and lacks err 'another scene'
refused 1 "noon.hdr: this is not the sky that the probes were captured under" \
    probe-error moved/scenes/yard.obj moved/baked.probe
rm -r work
refused 1 "noon.hdr: No such file or directory, and from the scene's folder $here/moved/scenes/" \
    probe-leakfix moved/scenes/yard.obj moved/baked.probe
refused 1 "neither ../skies/of  may/noon.hdr nor noon.hdr" \
    probe-error moved/scenes/yard.obj moved/baked.probe
refused 1 "scenes/none.hdr: No such file or directory" \
    probe-capture --sky moved/scenes/none.hdr moved/scenes/yard.obj moved/baked.probe

# -- through a pipe --------------------------------------------------------------------------------
sky ' sky.hdr' 201
sky moved/other.hdr 202
probe-place grid -q --count 12 moved/scenes/yard.obj >placed.probe
probe-capture -q --rays 8 --text --sky ' sky.hdr' - placed.probe \
    <moved/scenes/yard.obj >piped.probe
check "of a scene that is no file there is no folder, and a name may begin with a blank" \
    says piped.probe "^sky-file $here/ sky.hdr\$" and lacks piped.probe '^sky-from-scene'
probe-tet -q piped.probe >piped.tet
(cd elsewhere && probe-leakfix -q - ../piped.tet <../moved/scenes/yard.obj >piped.fixed 2>err)
check "and its sky is found all the same" empty elsewhere/err
rm ' sky.hdr'
refused 1 "directory: the sky of the stream's header (sky-file) is missing" \
    probe-leakfix - piped.tet <moved/scenes/yard.obj

# -- pipes -----------------------------------------------------------------------------------------
from_pipe() { cat piped.hdr | probe-capture --rays 8 --sky /dev/stdin "$@"; }
sky piped.hdr 201
refused 1 'stdin: expected a file that later programs find again' \
    from_pipe moved/scenes/yard.obj placed.probe
mkfifo fifo
refused 1 'fifo: expected a file that later programs find again' \
    probe-capture --rays 8 --sky fifo moved/scenes/yard.obj placed.probe

# -- slices of several machines --------------------------------------------------------------------
mkdir one two
for machine in one two; do
    cp moved/scenes/yard.obj $machine
    sky $machine/sky.hdr 201
done
probe-capture -q --rays 8 --slice 1/2 --sky one/sky.hdr one/yard.obj placed.probe >one/s.probe
probe-capture -q --rays 8 --slice 2/2 --sky two/sky.hdr two/yard.obj placed.probe >two/s.probe
check "slices that found the same sky in other places fill up" \
    into filled.probe probe-cat -q --fill two/s.probe one/s.probe and none_dark filled.probe
sky two/sky.hdr 202
probe-capture -q --rays 8 --slice 2/2 --sky two/sky.hdr two/yard.obj placed.probe >two/s.probe
refused 1 "sky-key is" probe-cat --fill two/s.probe one/s.probe
tap_done
