#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-tet as users run it.
. "${SRC:?}/tests/support/setup.sh"

# positions [LINE...]: a stream of these, or of those on standard input
positions() {
    if [ $# -gt 0 ]; then printf '%s\n' "$@"; else cat; fi |
        stream_of 'table probe position:f64:3'
}
# behind TABLE FILE: the line of the table and all behind it, in one line
behind() { sed -n "/^table $1/,/^end/p" "$2" | paste -s -d ' ' -; }

# -- cells -----------------------------------------------------------------------------------------
probe-place grid --spacing 1 --clearance 50% --bounds 0,0,0,4,4,4 --text >grid.probe
check "cells and hull normals are added" into cells.probe probe-tet grid.probe and \
    says cells.probe '^table tet vertex:i32:4 neighbour:i32:4' 'hull_normal:f32:3'
check "--verify finds them sound" probe-tet --verify cells.probe
probe-tet --report grid.probe >/dev/null 2>report
check "--report counts them" says report 'volume *27, of the hull 27'
probe-cat --binary grid.probe | probe-tet | head -n 1 >first_line
check "binary stays binary" says first_line binary
sed 's/^table probe.*/& thing:i32:1/; s/^[0-9].*/& 7/; 2i somebodys-key stays' grid.probe |
    probe-tet >unknown.probe
check "unknown columns and keys pass through" \
    says unknown.probe 'thing:i32:1' 'somebodys-key stays'
probe-tet --enclose --text grid.probe >enclosed.probe
check "--enclose adds eight corners" [ "$(row_count probe enclosed.probe)" = 72 ]
enclose="probe-tet --enclose --bounds 0,0,0,4,4,4"
$enclose grid.probe | $enclose >enclosed.probe
check "once" [ "$(row_count probe enclosed.probe)" = 72 ]

# One number of the cells changed: the check says so.
awk '/^table tet/ { tet = NR }
    tet && NR == tet + 5 {
        $1 = ($1 + 1) % 64
        if ($1 == $2 || $1 == $3 || $1 == $4) $1 = ($1 + 1) % 64
    }
    { print }' cells.probe >broken.probe
probe-tet --verify broken.probe >out 2>err
status=$?
check "a broken cell is found" [ $status -eq 1 ] and says err 'cell'

# -- probes on a line, in a plane, at one place ----------------------------------------------------
positions '0 0 0' '2 0 0' '1 0 0' '3 0 0' >line.probe
probe-tet line.probe >segments.probe
segments='table segment vertex:i32:2 neighbour:i32:2 0 2 1 -1 2 1 2 0 1 3 -1 1 end'
check "probes on a line become segments, in order" \
    [ "$(behind segment segments.probe)" = "$segments" ]
positions '0 0 0' '1 0 0' '0 1 0' '1 1 0' '5 5 0' >plane.probe
probe-tet plane.probe >triangles.probe
check "probes in a plane become triangles" \
    says triangles.probe '^table tri vertex:i32:3 neighbour:i32:3' \
    and probe-tet --verify triangles.probe
positions '1 2 3' '1 2 3' | probe-tet -q | probe-cat --text >point.probe
behind point point.probe >point
check "probes at one place become a point" \
    says point '^table point vertex:i32:1 neighbour:i32:1 [01] -1 end$'
probe-tet triangles.probe >again.probe
check "no cells of two kinds" [ "$(grep -c '^table tri' again.probe)" -eq 1 ]

# -- probes at the same place, or nearly so --------------------------------------------------------
positions '0 0 0' '1 0 0' '0 1 0' '0 0 1' '1 0 0' >twice.probe
probe-tet twice.probe >merged.probe 2>err
check "a duplicate stays, in no cell, with a warning" says err '1 of 5 probes are merged' \
    and [ "$(grep -c '^[0-9]' merged.probe)" -eq 6 ] and says merged.probe 'merged:i32:1' \
    and probe-tet --verify merged.probe
probe-cat --rows 0:4 merged.probe | probe-tet >once.probe
check "and goes when it is one no more" lacks once.probe merged and says once.probe '^table tet'
positions '0 0 0' '1 0 0' '0 1 0' '0 0 1' '1 0.001 0' | probe-tet --merge 0.01 2>err >/dev/null
check "--merge merges what is near" says err '1 of 5 probes are merged'
positions '0 0 0' '1 0 0' '0 1 0' '1 1 0.001' | probe-tet --merge 0.01 >flat.probe
check "and what is nearly flat is flat" says flat.probe '^table tri'

# -- the same cells, however it is run -------------------------------------------------------------
check "--report counts slivers" says report 'slivers *0 cells'
{ sed '/^[0-9-]/,$d' grid.probe; numbers <grid.probe | sort -r; echo end; } >shuffled.probe
# corners FILE: its cells, with the places of their probes
corners() {
    probe-tet "$1" | awk '
        /^end/ { exit }
        /^table tet/ { cells = 1; next }
        cells { print place[$1], place[$2], place[$3], place[$4], $5, $6, $7, $8; next }
        /^[0-9-]/ { place[count++] = $1 " " $2 " " $3 }'
}
corners grid.probe >wanted
corners shuffled.probe >got
check "shuffled probes get the same cells" cmp wanted got and test -s wanted
# 1000 probes are where the result's room is made ahead, and a grid has fewer cells than that
# foresees.
awk 'BEGIN { for (i = 0; i < 1000; i++) print i % 10, int(i / 10) % 10, int(i / 100) }' |
    positions >ten.probe
probe-tet ten.probe >wanted
same_each_time() {
    for _ in 1 2 3 4 5 6 7 8 9 10 11 12; do
        probe-tet ten.probe | cmp wanted - || return
    done
}
check "whoever is first, the child or the one who makes room for it" \
    same_each_time and test -s wanted
probe-tet --threads 1 grid.probe >threads1.probe
probe-tet --threads 5 grid.probe >threads5.probe
check "the same bytes for any number of threads" \
    cmp threads1.probe threads5.probe and test -s threads1.probe

# -- what is refused -------------------------------------------------------------------------------
{ sed '/^end/d' cells.probe; sed -n '/^table tri/,$p' triangles.probe; } >two_kinds.probe
refused 1 "cells in table tet already" probe-cat two_kinds.probe
sed 's/^0 1 0 .*/0 1 0 0 0 0 77/' merged.probe >beyond.probe
refused 1 "column merged: expected an index below" probe-cat beyond.probe
printf '%s\n' '#?probe 1' end >nothing.probe
refused 1 "no table probe" probe-tet nothing.probe
refused 1 "run probe-tet" probe-tet --verify grid.probe
refused 1 "expected a probe stream, got nothing" probe-tet </dev/null
sed 's/^0.5 0.5 0.5/0.5 nan 0.5/' grid.probe >nan.probe
refused 1 "finite" probe-tet nan.probe
sed '/^end/d' grid.probe >cut.probe
refused 1 "not whole" probe-tet cut.probe
refused 1 "No space left" into /dev/full probe-tet grid.probe
refused 2 "--bounds needs --enclose" probe-tet --bounds 0,0,0,1,1,1 grid.probe

# -- files -----------------------------------------------------------------------------------------
probe-tet -o out.probe grid.probe
check "-o writes a file" cmp out.probe cells.probe
for closed in '<&-' '>&-' '2>&-' '<&- >&- 2>&-'; do
    eval "probe-tet -o closed.probe grid.probe $closed"
    check "with $closed as well" cmp closed.probe cells.probe
    rm -f closed.probe
done
cp grid.probe self.probe
check "in place as well" probe-tet -o self.probe self.probe and cmp self.probe cells.probe

# -- one layer or one row --------------------------------------------------------------------------
# lit [FILE]: a stream of positions, whose red is a known field
lit() {
    awk '{ print $1, $2, $3, 2 + cos(.8 * $1) * cos(.8 * $3), 1, 1 }' "$@" |
        stream_of 'sh-order 1' 'sh-content radiance' 'table probe position:f64:3 sh:f32:3'
}
# off STREAM POINTS KIND: the mean error of this kind of interpolation
off() {
    probe-query -q --interpolate "$3" "$1" "$2" | paste "$2" - | awk '
        { e = $4 - 2 - cos(.8 * $1) * cos(.8 * $3); sum += e < 0 ? -e : e }
        END { if (NR) print sum / NR }'
}
# packs_alike STREAM POINTS: the packed stream gives the same bytes
packs_alike() {
    probe-query -q "$1" "$2" >plain.light && probe-query -q --pack float -o packed "$1" &&
        probe-query -q packed "$2" | cmp plain.light -
}

awk 'BEGIN { srand(1); for (i = 0; i < 900; i++) print 15*rand(), 1.7 + .04*rand(), 15*rand() }' \
    >layer
awk "BEGIN { srand(2); for (i = 0; i < 400; i++) print 1+13*rand(), 1.7+.1*rand(), 1+13*rand() }" \
    >between
lit layer >layer.probe
probe-tet layer.probe >layer.baked 2>err
check "a floor with noise is a sheet, and it is said" says layer.baked '^table tri' and \
    says err 'nearly in a sheet, 95 % of them off it by at most [0-9.]* % of their spacing'
off layer.baked between barycentric >off
off layer.baked between nearest >off_nearest
check "where light is twice as near as that of the nearest probe" \
    every '$1 < .04' off and every '$1 > .08' off_nearest
check "--verify takes it" probe-tet --verify layer.baked
check "packed it is the same" packs_alike layer.baked between
probe-tet --thin 0 layer.probe >full.baked 2>err
check "--thin 0 makes tetrahedra of it, and says nothing" says full.baked '^table tet' and empty err

awk 'BEGIN { for (i = 0; i < 120; i++) print i / 3, 1.7 + .05*sin(i * 1.7), 3 * sin(i / 12) }' >row
awk 'BEGIN {
    srand(3)
    for (i = 0; i < 400; i++) {
        t = 118 * rand()
        print t / 3 + .2*rand() - .1, 1.6 + .2*rand(), 3 * sin(t / 12) + .2*rand() - .1
    }
}' >beside
lit row >row.probe
probe-tet --report row.probe >row.baked 2>err
check "a walk is strung along its steps, and it is said" says row.baked '^table segment' and \
    says err 'strung along a walk: its 119 steps' '^length  *[0-9.]*$'
off row.baked beside barycentric >off
check "light beside it is near" every '$1 < .03' off
check "--verify takes it" probe-tet --verify row.baked
check "packed it is the same" packs_alike row.baked beside
sort row | lit | probe-tet -q | probe-query -q - beside >shuffled.light
check "in any order, too" cmp shuffled.light plain.light

awk 'BEGIN {
    for (i = 0; i < 320; i++) print i % 8, int(i / 8) % 5, int(i / 40)
    for (i = 0; i < 52; i++) print i + 8, 2 + .05*sin(i * i), 4 + .05*cos(i * i)
}' | lit >hall.probe
probe-tet hall.probe >hall.baked 2>err
check "a hall with a corridor one probe wide is told of" says hall.baked '^table tet' and \
    says err 'parts of the probes are one layer or one row'
awk 'BEGIN {
    srand(5)
    for (i = 0; i < 72; i++) print i % 6, 30*int(i / 36) + .04*rand(), int(i / 6) % 6
}' | lit | probe-tet >storeys.baked 2>err
check "storeys far apart are not: their own noise is peeled off" \
    says storeys.baked '^table tet' and empty err
awk 'BEGIN { for (i = 0; i < 200; i++) print i % 10, int(i / 100), int(i / 10) % 10 }' | lit |
    probe-tet >two.baked 2>err
check "two layers are not" says two.baked '^table tet' and empty err
tap_done
