#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Light that surfaces scatter, by links to senders: what a path-traced capture finds of the same
# lamps; the same bytes for any threads and slices; what is wrong is said.
. "${SRC:?}/tests/support/setup.sh"
scene=$SRC/scenes/two-rooms.obj
lamp='-q --point 1,2,1,10,9,8'

probe-place -q poisson --count 400 --areas 64 "$scene" >senders.probe
printf '%s\n' 1 2 3 | sed 's/.*/& 1 1.5/' >points.txt
probe-place -q points points.txt "$scene" >placed.probe 2>said ||
    probe-place -q grid --count 8 "$scene" >placed.probe
transfer="--bounces 0 --rays 256 --links 64 --transfer surfaces:senders.probe"
probe-capture -q -j 1 $transfer "$scene" placed.probe >transfer.probe
probe-capture -q -j 2 $transfer "$scene" placed.probe >again.probe
check "the same bytes for any number of threads" cmp transfer.probe again.probe
for i in 1 2; do probe-capture -q --slice $i/2 $transfer "$scene" placed.probe >slice$i.probe; done
probe-cat --fill slice2.probe slice1.probe | probe-cat --text | sed '/^#/d' >filled
probe-cat --text transfer.probe | sed '/^#/d' >whole
check "and slices" cmp filled whole
check "table sender comes first" says whole '^transfer-surfaces 64$' \
    '^transfer-senders ................$' \
    '^table sender position:f64:3 .* link:i32:64$' \
    '^table probe .* transfer_surfaces:f32:576 transfer_senders:i32:64$'

probe-capture $lamp --bounces 0 --rays 64 "$scene" senders.probe >lit.probe
probe-capture $lamp --bounces 0 --rays 1024 "$scene" placed.probe >direct.probe
probe-capture $lamp --bounces 3 --rays 1024 "$scene" placed.probe >truth.probe
probe-relight --senders lit.probe --direct direct.probe --bounces 3 transfer.probe >out.probe
# mean FILE: the sum of the probes' mean light
mean() { probe-cat --text --columns position,sh "$1" |
    awk '/^table probe/ { on = 1; next } /^end/ { on = 0 } 
        on { s += $4 + $5 + $6 } END { print s }'; }
mean truth.probe >wanted
mean out.probe >got
awk '{ getline got <"got"; print got / $1 }' wanted >ratio
echo 1 >one
check "light is that of paths, within a tenth" near 0.1 one ratio
mean direct.probe >straight
check "of which more than a twentieth is scattered" \
    sh -c '[ "$(cat wanted straight | tr "\n" " " | awk "{ print (\$1 > 1.05 * \$2) }")" = 1 ]'
probe-cat --text out.probe >out
check "the header is that of the capture" says out '^capture-light all$' '^capture-bounces 3$' \
    '^point-1 1,2,1,10,9,8$' and lacks out '^transfer' '^table sender'
probe-relight --senders lit.probe --direct direct.probe --bounces 0 transfer.probe |
    probe-cat --text --columns position,sh | sed -n '/^table/,$p' >none
probe-cat --text --columns position,sh direct.probe | sed -n '/^table/,$p' >straight
check "without bounces it is what comes straight" cmp straight none
probe-relight --keep --senders lit.probe transfer.probe | probe-cat --text >out
check "without --direct it is indirect, and --keep keeps links" says out \
    '^capture-light indirect$' '^table sender' ' transfer_surfaces:'
probe-cat --order 2 transfer.probe >low.probe
probe-relight --senders lit.probe low.probe | probe-cat --text >out
check "an order is cut in links, too" says out '^table probe .* sh:f32:12 '

probe-capture --dry-run $transfer "$scene" placed.probe >out
check "--dry-run says what senders take" says out 'senders take 0.2[0-9]* MB'

# -- what is wrong ---------------------------------------------------------------------------------
refused 1 'no links to senders' probe-relight --senders lit.probe direct.probe
refused 1 'got --bounces 64' sh -c "probe-capture $lamp --rays 4 '$scene' senders.probe >full.probe;
    probe-relight --senders full.probe transfer.probe"
refused 1 'expected light that was captured' probe-relight --senders senders.probe transfer.probe
probe-cat --rows 0:99 lit.probe >few.probe
refused 1 'senders that the probes have links to, got' \
    probe-relight --senders few.probe transfer.probe
probe-capture -q --bounces 0 --rays 4 --point 1,2,1,9,9,9 "$scene" placed.probe >other.probe
refused 1 'its light is not that of the senders' \
    probe-relight --senders lit.probe --direct other.probe transfer.probe
probe-cat -q --rows 1:3 direct.probe >few3.probe
refused 1 'expected the same probes' \
    probe-relight --senders lit.probe --direct few3.probe transfer.probe
refused 2 'expected no --weights' probe-relight --senders lit.probe -w a=1 transfer.probe
refused 2 '--bounces needs --senders' probe-relight --bounces 1 transfer.probe
probe-cat --drop area senders.probe >few2.probe
refused 1 'there is no column area' \
    probe-capture --transfer surfaces:few2.probe "$scene" placed.probe
refused 1 'no column normal' probe-capture --transfer surfaces:direct.probe "$scene" placed.probe
refused 2 'needs a fixed --order' \
    probe-capture --order auto --transfer surfaces:senders.probe "$scene" placed.probe
tap_done
