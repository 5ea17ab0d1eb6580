#!/bin/sh
# probe-tet as users run it.
. "${SRC:?}/tests/setup.sh"
probe-place grid --spacing 1 --bounds 0,0,0,4,4,4 --text >grid.probe
stream() { printf '#?probe 1\ntable probe position:f64:3\n'; cat; echo end; }

check "cells and hull normals are added" sh -c "probe-tet grid.probe >cells.probe && grep -q '^table tet vertex:i32:4 neighbour:i32:4' cells.probe &&
    grep -q 'hull_normal:f32:3' cells.probe"
check "--verify finds them sound" probe-tet --verify cells.probe
check "--report counts them" sh -c "probe-tet --report cells.probe 2>&1 >/dev/null | grep -q 'volume *27, of the hull 27'"
check "binary stays binary" sh -c "probe-cat --binary grid.probe | probe-tet | head -n 1 | grep -qa binary"
sed 's/^table probe.*/& thing:i32:1/; s/^[0-9].*/& 7/' grid.probe | sed '2i somebodys-key stays' >unknown.probe
check "unknown columns and keys pass through" sh -c "probe-tet unknown.probe | grep -q 'thing:i32:1' && probe-tet unknown.probe | grep -q 'somebodys-key stays'"
probe-tet --enclose --text grid.probe >enclosed.probe
check "--enclose adds eight corners" sh -c "probe-cat --info enclosed.probe | grep -q 'table probe: 72 rows'"
check "once" sh -c "probe-tet --enclose --bounds 0,0,0,4,4,4 grid.probe | probe-tet --enclose --bounds 0,0,0,4,4,4 | probe-cat --info | grep -q '72 rows'"

# One number of the cells changed: the check says so.
awk '/^table tet/ { tet = NR } tet && NR == tet + 5 { $1 = ($1 + 1) % 64; if ($1 == $2 || $1 == $3 || $1 == $4) $1 = ($1 + 1) % 64 } { print }' cells.probe >broken.probe
probe-tet --verify broken.probe >out 2>err
if [ $? -eq 1 ] && grep -q 'cell' err; then pass "a broken cell is found"; else fail "a broken cell is found" "$(cat err)"; fi

refused 1 "at least 4 probes at different places, got 3" sh -c "printf '0 0 0\n1 0 0\n0 1 0\n' | { printf '#?probe 1\ntable probe position:f64:3\n'; cat; echo end; } | probe-tet"
printf '0 0 0\n1 0 0\n2 0 0\n3 0 0\n' | stream >line.probe
refused 1 "4 on a line" probe-tet line.probe
printf '0 0 0\n1 0 0\n0 1 0\n1 1 0\n5 5 0\n' | stream >plane.probe
refused 1 "5 in a plane" probe-tet plane.probe
printf '0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0\n' | stream >twice.probe
probe-tet twice.probe >twice.out 2>err
check "a duplicate stays, in no cell, with a warning" sh -c "grep -q 'probe 4 is where probe 1 is' err && [ \$(grep -c '^[0-9]' twice.out) -eq 6 ]"
refused 1 "no table probe" sh -c "printf '#?probe 1\nend\n' | probe-tet"
refused 1 "run probe-tet" probe-tet --verify grid.probe
refused 1 "expected a probe stream, got nothing" sh -c "probe-tet </dev/null"
refused 1 "finite" sh -c "sed 's/^0.5 0.5 0.5/0.5 nan 0.5/' grid.probe | probe-tet"
refused 1 "not whole" sh -c "sed '/^end/d' grid.probe | probe-tet"
refused 1 "No space left" sh -c "probe-tet grid.probe >/dev/full"
refused 2 "--bounds needs --enclose" probe-tet --bounds 0,0,0,1,1,1 grid.probe
probe-tet -o out.probe grid.probe
check "-o writes a file" cmp out.probe cells.probe
check "in place as well" sh -c "cp grid.probe self.probe && probe-tet -o self.probe self.probe && cmp self.probe cells.probe"
tap_done
