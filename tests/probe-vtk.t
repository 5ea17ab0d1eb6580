#!/bin/sh
# probe-vtk as users run it; its files are read back with VTK's own readers through Debian's python3-vtk9.
. "${SRC:?}/tests/setup.sh"
if ! [ -x "$BUILD/src/probe-vtk" ]; then
    skip "probe-vtk is not built"
    tap_done
fi
probe-place grid --spacing 1 --bounds 0,0,0,4,4,4 --text | grep '^[0-9]' |
    awk 'BEGIN { print "#?probe 1\n# made by hand\nsh-order 2\ntable probe position:f64:3 sh:f32:12 thing:i32:1" }
         { print $1, $2, $3, $1 + 1, $1 + 1, $1 + 1, 0, 0, 0, 0, 0, 0, 3, 3, 3, NR } END { print "end" }' | probe-tet >baked.probe
check "a mesh is written" probe-vtk -o baked.vtu baked.probe
check "as text as well" probe-vtk --text -o text.vtu baked.probe
check "on standard output as well" sh -c "probe-vtk -o - baked.probe | cmp - baked.vtu"
printf 'v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nf 1 2 3 4\n' >quad.obj
check "the scene goes beside it" sh -c "probe-vtk -o s.vtu --scene quad.obj baked.probe && [ -s s.scene.vtp ]"

python=/usr/bin/python3
if $python -c 'import vtk' 2>/dev/null; then
    $python "$SRC/tests/vtk_read.py" baked.vtu >read
    check "64 probes in tetrahedra that fill the box, none inverted" sh -c "grep -qx 'points 64' read && grep -q '^cells [0-9]* 10\$' read && grep -q '^volume 27 ' read && ! grep -q inverted read"
    check "every column is an array" sh -c "for a in 'point position 3' 'point sh 12 L00.r' 'point thing 1' 'point hull_normal 3' 'cell vertex 4' 'cell neighbour 4'; do grep -q \"^\$a\" read || exit 1; done"
    check "irradiance, colour, luminance and gradients are added" sh -c "for a in irradiance colour luminance luminance_gradient brightest captured; do grep -q \"^point \$a \" read || exit 1; done; grep -q '^cell luminance_gradient 3' read"
    check "quality and hull of cells are added" sh -c "for a in min_dihedral aspect_ratio volume hull_faces; do grep -q \"^cell \$a 1\" read || exit 1; done"
    check "keys and history are field data" sh -c "grep -qx 'field sh-order 2' read && grep -qx 'field Provenance made by hand' read"
    $python "$SRC/tests/vtk_read.py" baked.vtu thing | awk '{ print $1 + 0 }' >things
    seq 64 >numbers
    check "values arrive as they are" cmp things numbers
    # L00 = x + 1 in all colours: luminance pi Y00 (x + 1), its gradient pi Y00 along x, in every cell.
    $python "$SRC/tests/vtk_read.py" text.vtu luminance_gradient >gradient
    check "the gradient of a linear field is exact" awk '{ g = 3.14159265 * 0.28209479; if (($1 - g) ^ 2 > 1e-10 || $2 ^ 2 > 1e-10 || $3 ^ 2 > 1e-10) exit 1 }' gradient
    $python "$SRC/tests/vtk_read.py" s.scene.vtp >scene
    check "the scene has its area and colour" sh -c "grep -q ' area 6\$' scene && grep -q '^cell albedo 3' scene && grep -q '^cell colour 3' scene"
    printf '#?probe 1\ntable probe position:f64:3\n1 0 -0.7071067811865476\n-1 0 -0.7071067811865476\n0 1 0.7071067811865476\n0 -1 0.7071067811865476\nend\n' |
        probe-tet | probe-vtk -q -o regular.vtu
    $python "$SRC/tests/vtk_read.py" regular.vtu min_dihedral >angle
    check "a regular tetrahedron has 70.5288 degrees" awk '{ exit !(($1 - 70.5287794) ^ 2 < 1e-6) }' angle
    probe-tet --enclose baked.probe | probe-vtk -o missing.vtu 2>err
    check "missing light is 0, marked and said" sh -c "grep -q '8 of 72 values are missing' err && $python $SRC/tests/vtk_read.py missing.vtu captured | grep -c '^0.0' | grep -qx 8"
    probe-cat --tables probe --drop hull_normal baked.probe | probe-vtk -q -o points.vtu
    check "without cells each probe is a vertex" sh -c "$python $SRC/tests/vtk_read.py points.vtu | grep -qx 'cells 64 1'"
    if $python -c 'import numpy' 2>/dev/null && { [ -n "${DISPLAY-}" ] || command -v xvfb-run >/dev/null; }; then
        for what in probes cells slice; do
            check "a picture of $what" sh -c "'$SRC/scripts/picture' --size 200x150 --scene s.scene.vtp --what $what $what.png s.vtu && [ \$(wc -c <$what.png) -gt 1500 ]"
        done
    else
        skip "there is no display and no xvfb-run, or no numpy: no pictures"
    fi
else
    skip "python3-vtk9 is not installed: the files are not read back"
fi

refused 2 "expected --output" probe-vtk baked.probe
refused 1 "expected a probe stream, got nothing" sh -c "probe-vtk -o x.vtu </dev/null"
refused 1 "No space left" probe-vtk -o /dev/full baked.probe
refused 1 "No such file" probe-vtk -o nowhere/x.vtu baked.probe
refused 2 "--scene-output needs --scene" probe-vtk -o x.vtu --scene-output y.vtp baked.probe
echo old >kept.vtu
head -n 20 baked.probe >cut.probe
refused 1 "not whole" probe-vtk -o kept.vtu cut.probe
check "what was there stays when it fails" grep -qx old kept.vtu
tap_done
