#!/bin/sh
# probe-tet as users run it.
. "${SRC:?}/tests/support/setup.sh"
probe-place grid --spacing 1 --bounds 0,0,0,4,4,4 --text >grid.probe
cat >stream <<'END'
#!/bin/sh
printf '#?probe 1\ntable probe position:f64:3\n'; cat; echo end
END
chmod +x stream
PATH=$PWD:$PATH

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

printf '0 0 0\n2 0 0\n1 0 0\n3 0 0\n' | stream >line.probe
check "probes on a line become segments, in order" sh -c "probe-tet line.probe | sed -n '/^table segment/,/^end/p' | tr '\n' ' ' | grep -qx 'table segment vertex:i32:2 neighbour:i32:2 0 2 1 -1 2 1 2 0 1 3 -1 1 end '"
printf '0 0 0\n1 0 0\n0 1 0\n1 1 0\n5 5 0\n' | stream >plane.probe
probe-tet plane.probe >triangles.probe
check "probes in a plane become triangles" sh -c "grep -q '^table tri vertex:i32:3 neighbour:i32:3' triangles.probe && probe-tet --verify triangles.probe"
check "probes at one place become a point" sh -c "printf '1 2 3\n1 2 3\n' | stream | probe-tet -q | probe-cat --text | sed -n '/^table point/,/^end/p' | tr '\n' ' ' | grep -qx 'table point vertex:i32:1 neighbour:i32:1 [01] -1 end '" 
printf '0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0\n' | stream >twice.probe
probe-tet twice.probe >twice.out 2>err
check "a duplicate stays, in no cell, with a warning" sh -c "grep -q '1 of 5 probes are merged' err && [ \$(grep -c '^[0-9]' twice.out) -eq 6 ] && grep -q 'merged:i32:1' twice.out && probe-tet --verify twice.out"
check "and goes when it is one no more" sh -c "probe-cat --rows 0:4 twice.out | probe-tet | grep -q 'merged' && exit 1 || exit 0"
check "--merge merges what is near" sh -c "printf '0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0.001 0\n' | stream | probe-tet --merge 0.01 2>&1 >/dev/null | grep -q '1 of 5 probes are merged'"
check "and what is nearly flat is flat" sh -c "printf '0 0 0\n1 0 0\n0 1 0\n1 1 0.001\n' | stream | probe-tet --merge 0.01 | grep -q '^table tri'"
check "no cells of two kinds" sh -c "probe-tet triangles.probe | grep -c '^table tri' | grep -qx 1"
check "--report counts slivers" sh -c "probe-tet --report grid.probe 2>&1 >/dev/null | grep -q 'slivers *0 cells'"
check "shuffled probes get the same cells" sh -c "
    { sed '/^[0-9-]/,\$d' grid.probe; sed -n '/^[0-9-]/p' grid.probe | sort -r; echo end; } >shuffled.probe
    places() { probe-tet \$1 | awk '/^table tet/ { t = 1; next } /^end/ { exit } !t && /^[0-9-]/ { p[n++] = \$1 \" \" \$2 \" \" \$3 } t { print p[\$1], p[\$2], p[\$3], p[\$4], \$5, \$6, \$7, \$8 }'; }
    places grid.probe >a && places shuffled.probe >b && [ -s a ] && cmp a b"
# 1000 probes are where the result's room is made ahead, and a grid has fewer cells than that foresees.
awk 'BEGIN { print "#?probe 1\ntable probe position:f64:3"; for (i = 0; i < 1000; i++) print i % 10, int(i / 10) % 10, int(i / 100); print "end" }' >ten.probe
check "whoever is first, the child or the one who makes room for it" sh -c "probe-tet ten.probe >first && for i in 1 2 3 4 5 6 7 8 9 10 11 12; do
    probe-tet ten.probe | cmp first - || exit 1; done"
check "the same bytes for any number of threads" sh -c "probe-tet --threads 1 grid.probe >one && probe-tet --threads 5 grid.probe | cmp one -"
refused 1 "cells in table tet already" sh -c "{ sed '/^end/d' cells.probe; sed -n '/^table tri/,\$p' triangles.probe; } | probe-cat"
refused 1 "column merged: expected an index below" sh -c "sed 's/^0 1 0 .*/0 1 0 0 0 0 77/' twice.out | probe-cat"
refused 1 "no table probe" sh -c "printf '#?probe 1\nend\n' | probe-tet"
refused 1 "run probe-tet" probe-tet --verify grid.probe
refused 1 "expected a probe stream, got nothing" sh -c "probe-tet </dev/null"
refused 1 "finite" sh -c "sed 's/^0.5 0.5 0.5/0.5 nan 0.5/' grid.probe | probe-tet"
refused 1 "not whole" sh -c "sed '/^end/d' grid.probe | probe-tet"
refused 1 "No space left" sh -c "probe-tet grid.probe >/dev/full"
refused 2 "--bounds needs --enclose" probe-tet --bounds 0,0,0,1,1,1 grid.probe
probe-tet -o out.probe grid.probe
check "-o writes a file" cmp out.probe cells.probe
for closed in '<&-' '>&-' '2>&-' '<&- >&- 2>&-'; do
    check "with $closed as well" sh -c "probe-tet -o closed.probe grid.probe $closed; cmp closed.probe cells.probe"
    rm -f closed.probe
done
check "in place as well" sh -c "cp grid.probe self.probe && probe-tet -o self.probe self.probe && cmp self.probe cells.probe"
tap_done
