#!/bin/sh
# probe-query as users run it.
. "${SRC:?}/tests/support/setup.sh"

# Probes whose light is linear in their place: L00 = (x, y, 2), order 2 with a gradient along y in L1-1.
probe-place grid --spacing 1 --bounds 0,0,0,4,4,4 --text | grep '^[0-9]' |
    awk 'BEGIN { print "#?probe 1\nsh-order 2\nsh-content radiance\ntable probe position:f64:3 sh:f32:12" }
         { print $1, $2, $3, $1, $2, 2, $3, 0, 0, 0, 0, 0, 0, 0, 0 } END { print "end" }' | probe-tet >baked.probe

echo "1.25 2.5 3.25" | probe-query baked.probe >light
check "coefficients are interpolated linearly" awk 'function near(a, b) { return (a - b) ^ 2 < 1e-9 }
    { exit !(NF == 12 && near($1, 1.25) && near($2, 2.5) && $3 == 2 && near($4, 3.25)) }' light
echo "1.25 2.5 3.25 0 2 0" | probe-query baked.probe >light
check "irradiance for a normal of any length: pi Y00 L00 + 2 pi / 3 Y1-1 L1-1" awk 'function near(a, b) { return (a - b) ^ 2 < 1e-6 }
    { exit !(NF == 3 && near($1, 3.14159265 * 0.282095 * 1.25 + 2.0943951 * 0.488603 * 3.25) && near($2, 3.14159265 * 0.282095 * 2.5)) }' light
sed 's/^sh-content.*/sh-content irradiance/' baked.probe >convolved.probe
echo "1.25 2.5 3.25 0 2 0" | probe-query convolved.probe >light
check "convolved coefficients are used as they are" awk '{ exit !(($2 - 0.282095 * 2.5) ^ 2 < 1e-9) }' light
echo "9 2 2" | probe-query --outside nearest --explain baked.probe >light 2>err
check "outside: the nearest point of the hull, and it says so" sh -c "grep -q ' outside 5.5\$' light && tail -n 1 light | awk '{ exit !(\$1 == 3.5) }' && grep -q '1 points are outside' err"
check "inside is said too" sh -c "echo 2 2 2 | probe-query --explain baked.probe | grep -q ' inside 0\$'"
awk 'BEGIN { srand(1); for (i = 0; i < 20000; i++) print 4 * rand(), 4 * rand(), 4 * rand() }' >points.txt
check "20000 points, in order" sh -c "probe-query -q baked.probe points.txt >light && [ \$(wc -l <light) -eq 20000 ]"
check "each is what it is alone" sh -c "tail -n 1 points.txt | probe-query -q baked.probe | cmp - \$(tail -n 1 light >last; echo last)"
check "binary out is text's numbers" sh -c "probe-query -q --to binary baked.probe points.txt | od -An -v -w48 -tf4 | awk '{ print \$1 + 0 }' >b; awk '{ printf \"%.6g\n\", \$1 }' light >t; paste b t | awk '{ d = \$1 - \$2; if (d * d > 1e-9) exit 1 }'"
perl -ne 'print pack("d<3", split)' points.txt >points.bin 2>/dev/null && check "binary in is text's points" sh -c "probe-query -q --from binary baked.probe points.bin | cmp - light"
check "a stream of points" sh -c "probe-query -q --to stream baked.probe points.txt | probe-cat --info | grep -q 'table probe: 20000 rows'"
check "another column" sh -c "echo 2 2 2 | probe-query --column hull_normal baked.probe | awk '{ exit NF != 3 }'"
for outside in extend nearest; do
    check "outside $outside: on the hull, it is the hull's" sh -c "echo 3.5000001 2 2 | probe-query -q --outside $outside baked.probe | awk '{ exit !((\$1 - 3.5) ^ 2 < 1e-10) }'"
done
echo "9 2 2" | probe-query -q --outside zero baked.probe >light
check "outside zero: no light" awk '{ for (i = 1; i <= NF; i++) if ($i != 0) exit 1; exit NF != 12 }' light
refused 1 "stdin:2: the point is outside of the hull of the probes, 5.5 away" sh -c "printf '1 1 1\n9 2 2\n' | probe-query --outside error baked.probe"
awk 'BEGIN { srand(2); for (i = 0; i < 30000; i++) print 9 * rand() - 2, 9 * rand() - 2, 9 * rand() - 2, rand() - .5, rand() - .5, rand() + .1 }' >around.txt
for threads in 1 2 5; do probe-query -q --threads $threads baked.probe around.txt | cksum; done >sums
check "the same bytes for any number of threads" sh -c "[ \$(uniq sums | wc -l) -eq 1 ]"
check "and for any order of the points" sh -c "awk '{ print NR, \$0 }' around.txt | sort -k 2,2g >shuffled; cut -d ' ' -f 2- shuffled | probe-query -q baked.probe - | paste -d ' ' shuffled - | sort -n | cut -d ' ' -f 8- >again; probe-query -q baked.probe around.txt | cmp - again"

# The same probes in another order: the same light, to the bit, inside and outside the hull.
lit() { awk 'BEGIN { srand('$1'); print "#?probe 1\nsh-order 2\nsh-content radiance\ntable probe position:f64:3 sh:f32:12" }
    { printf "%s", $0; for (i = 0; i < 12; i++) printf " %.7g", rand() - .3; print "" } END { print "end" }'; }
awk 'BEGIN { srand(3); for (i = 0; i < 3000; i++) print 9 * rand() - 2, 9 * rand() - 2, 9 * rand() - 2 }' | lit 4 >random.probe
awk 'BEGIN { for (i = 0; i < 1728; i++) print .5 * (i % 12), .5 * (int(i / 12) % 12), .5 * int(i / 144) }' | lit 5 >grid.probe
awk 'function noise() { return 1e-6 * rand() } BEGIN { srand(6); for (i = 0; i < 1728; i++) { x = i % 12 + noise(); y = int(i / 12) % 12 + noise(); z = int(i / 144) + noise()
    a = .8 * x - .6 * y; b = .6 * x + .8 * y; printf "%.17g %.17g %.17g\n", .5 * a, .5 * (.96 * b - .28 * z), .5 * (.28 * b + .96 * z) } }' | lit 7 >turned.probe
awk '{ print $1, $2, $3 } NR % 10 == 0 { print int($1), int($2), int($3); print int($1) + .5, int($2), int($3 * 2) / 2 }' around.txt >places.txt
for set in random grid turned; do
    { sed '/^table/q' $set.probe; sed '1,/^table/d; /^end/d' $set.probe | awk 'BEGIN { srand(8) } { print rand(), $0 }' | sort -k 1,1g | cut -d ' ' -f 2-; echo end; } >other.probe
    check "$set probes, shuffled: the same light, to the bit" sh -c "! cmp -s $set.probe other.probe && probe-tet $set.probe | probe-query -q --to binary - places.txt >a &&
        probe-tet other.probe | probe-query -q --to binary - places.txt >b && [ \$(wc -c <a) -eq \$((48 * \$(wc -l <places.txt))) ] && cmp a b"
done

# Unasked, light outside is that of the nearest point; before dents it goes on along rays, unless their core is small, as of this hull which leakfix mended.
probe-tet turned.probe >dented.probe
probe-place grid -q --count 400 "$SRC/scenes/coloured-walls.gltf" | probe-capture -q --order 1 --columns none --rays 16 "$SRC/scenes/coloured-walls.gltf" |
    probe-tet -q | probe-leakfix -q "$SRC/scenes/coloured-walls.gltf" >mended.probe
outside() { # outside WHAT STREAM HOW: what is said of a point outside
    check "outside of $2, $1: $3" sh -c "echo 99 0 0 | probe-query --outside $1 $2 2>&1 >light | grep -q '$3\$' && [ -s light ]"
}
check "these hulls have dents" sh -c "probe-tet --verify dented.probe 2>&1 | grep -q '[1-9][0-9]* dents' && probe-tet --verify mended.probe 2>&1 | grep -q '[1-9][0-9]* dents'"
outside auto baked.probe "nearest point"
outside auto dented.probe "along rays"
outside auto mended.probe "nearest point"
outside extend mended.probe "along rays"

# an octree: a box of two cells, of which the second is cut, and one part of that again; light as above, then with a bend
awk 'function nodes(x, y, z, s, n, i) {
         for (i = 0; i < (n + 1) ^ 3; i++)
             print x + s * (i % (n + 1)) / n, y + s * (int(i / (n + 1)) % (n + 1)) / n, z + s * int(i / (n + 1) ^ 2) / n
     }
     BEGIN { nodes(0, 0, 0, 4, 1); nodes(4, 0, 0, 4, 2); nodes(4, 2, 0, 2, 2) }' | sort -u >tree.txt
tree() { # LIGHT: an octree with this L00 of red
    probe-place points -q --text tree.txt | grep '^[0-9]' |
        awk "BEGIN { print \"#?probe 1\\nsh-order 1\\nsh-content radiance\\ntable probe position:f64:3 sh:f32:3\" }
             { x = \$1; y = \$2; z = \$3; print x, y, z, $1, x + y, 2 } END { print \"end\" }"
}
tree z >tree.probe
tree 'x * x + (y - 3) * z' >bent.probe
awk 'BEGIN { srand(3); for (i = 0; i < 3000; i++) print 8 * rand(), 4 * rand(), 4 * rand() }' >in_tree.txt
for how in trilinear tricubic; do
    check "$how of an octree: linear fields" sh -c "probe-query -q --interpolate $how tree.probe in_tree.txt | paste -d ' ' in_tree.txt - |
        awk '{ if ((\$4 - \$3) ^ 2 + (\$5 - \$1 - \$2) ^ 2 + (\$6 - 2) ^ 2 > 1e-9) exit 1 }'"
    check "$how of an octree: at probes, their light" sh -c "probe-query -q --interpolate $how bent.probe tree.txt | paste -d ' ' tree.txt - |
        awk '{ if ((\$4 - \$1 * \$1 - (\$2 - 3) * \$3) ^ 2 > 1e-8) exit 1 }'"
    check "$how of an octree: the same on both sides of where sizes meet" sh -c "awk 'BEGIN { srand(4); for (i = 0; i < 2000; i++) { y = 4 * rand(); z = 4 * rand(); print 3.999999999, y, z; print 4.000000001, y, z } }' |
        probe-query -q --interpolate $how bent.probe - | awk 'NR % 2 { was = \$1 } NR % 2 == 0 && (\$1 - was) ^ 2 > 1e-9 { exit 1 }'"
    check "$how of an octree: the same bytes in any order of its probes" sh -c "probe-query -q --interpolate $how bent.probe in_tree.txt >a
        (grep -v '^[0-9e]' bent.probe; grep '^[0-9]' bent.probe | sort -r; echo end) | probe-query -q --interpolate $how - in_tree.txt | cmp - a"
done
check "outside of an octree is said, and gets the light of its border" sh -c "echo 9 1 2 | probe-query --interpolate trilinear tree.probe 2>err | grep -qx '2 9 2' && grep -q '1 points are outside' err"
grep -v '^6 2 0 ' tree.probe >holed.probe
refused 1 "nor: the probes are not the corners of an octree's cells: there is no probe at 6 2 0, a node of the cell (with a probe in its middle) from 4 0 0 to 8 4 4" \
    sh -c "echo 1 1 1 | probe-query --interpolate trilinear holed.probe"
sed 's/^6 2 0 .*/6 2 0 nan nan nan/' tree.probe >dark.probe
refused 1 "has no light: run probe-capture" sh -c "echo 1 1 1 | probe-query --interpolate tricubic dark.probe"

# packed files
probe-query --pack float -o baked.pack baked.probe
probe-query --pack half -o half.pack baked.probe
check "a packed file gives the light of its stream" sh -c "probe-query -q baked.probe around.txt >a; probe-query -q baked.pack around.txt >b
    paste -d ' ' a b | awk '{ for (i = 1; i <= 3; i++) if ((\$i - \$(i + 3)) ^ 2 > 1e-10) exit 1 }'"
check "with halves, to their rounding" sh -c "probe-query -q half.pack around.txt | paste -d ' ' a - | awk '{ for (i = 1; i <= 3; i++) if ((\$i - \$(i + 3)) ^ 2 > 1e-5) exit 1 }'"
check "halves take fewer bytes" sh -c "[ \$(wc -c <half.pack) -lt \$(wc -c <baked.pack) ]"
check "the example opens it" sh -c "$BUILD/doc/example half.pack 0 0 0 4 4 4 | grep -c side | grep -qx 11"
head -c 5000 half.pack >short.pack
refused 1 "short.pack: the packed file is damaged" sh -c "echo 1 1 1 | probe-query short.pack"
refused 1 "holds the column sh, and not ao" sh -c "echo 1 1 1 | probe-query --column ao half.pack"
refused 2 "--pack takes no points" probe-query --pack half baked.probe around.txt

# probes in a plane, on a line, in one place
head='#?probe 1\nsh-order 1\nsh-content radiance\ntable probe position:f64:3 sh:f32:3\n'
printf "$head"'0 0 0 1 0 0\n1 0 0 2 0 0\n0 0 1 1 1 0\n1 0 1 2 1 0\ntable tri vertex:i32:3 neighbour:i32:3\n0 1 2 1 -1 -1\n1 3 2 -1 0 -1\nend\n' >plane.probe
printf "$head"'0 0 0 1 0 0\n2 0 0 3 0 0\n4 0 0 1 0 0\ntable segment vertex:i32:2 neighbour:i32:2\n0 1 1 -1\n1 2 -1 0\nend\n' >line.probe
printf "$head"'1 2 3 4 5 6\ntable point vertex:i32:1 neighbour:i32:1\n0 -1\nend\n' >one.probe
check "a plane of probes: the point below" sh -c "[ \"\$(echo .25 7 .5 | probe-query plane.probe)\" = '1.25 0.5 0' ]"
check "beyond its border: the nearest point" sh -c "[ \"\$(echo .25 7 5 | probe-query -q plane.probe)\" = '1.25 1 0' ]"
check "a line of probes" sh -c "[ \"\$(printf '3 1 1\n-9 0 0\n' | probe-query -q line.probe | tr '\n' ' ')\" = '2 0 0 1 0 0 ' ]"
check "one probe" sh -c "[ \"\$(echo 7 8 9 | probe-query -q one.probe)\" = '4 5 6' ]"
sed 's/^table tri/table segment vertex:i32:2 neighbour:i32:2\n0 1 -1 -1\ntable tri/' plane.probe >both.probe
refused 1 "there are cells in table segment already" sh -c "echo 0 0 0 | probe-query both.probe"
sed 's/^1 3 2 -1 0 -1/1 3 2 -1 0 0/' plane.probe >torn.probe
refused 1 "cell 1: a cell names a neighbour that does not exist or does not share the face" sh -c "echo 0 0 0 | probe-query torn.probe"
printf "$head"'table tri vertex:i32:3 neighbour:i32:3\nend\n' >empty.probe
refused 1 "there are no cells" sh -c "echo 0 0 0 | probe-query empty.probe"
# A thread that waits for more points does not keep a failed program alive.
mkfifo held
(printf '1 1 1\n1 1\n'; sleep 20) >held &
holder=$!
check "bad input ends it, though the pipe stays open" sh -c "timeout 10 probe-query --threads 3 baked.probe <held 2>err; [ \$? -eq 1 ] && grep -q 'stdin:2' err"
kill $holder 2>/dev/null
check "no points, no light" sh -c "[ -z \"\$(probe-query baked.probe </dev/null)\" ]"
# An answer comes before the next question.
mkfifo ask answer
probe-query -q baked.probe <ask >answer &
exec 3>ask 4<answer
echo "1 1 1" >&3
read -r first <&4
exec 3>&-
wait
exec 4<&-
if [ -n "$first" ]; then pass "a pipe is answered point by point"; else fail "a pipe is answered point by point"; fi

probe-place grid --spacing 1 --bounds 0,0,0,4,4,4 >placed.probe
refused 1 "run probe-tet" sh -c "echo 1 1 1 | probe-query placed.probe"
probe-tet placed.probe >dark.probe
refused 1 "run probe-capture" sh -c "echo 1 1 1 | probe-query dark.probe"
probe-tet --enclose baked.probe >corners.probe
refused 1 "has no light: run probe-capture" sh -c "echo -0.1 -0.1 -0.1 | probe-query corners.probe"
refused 1 "stdin:2: expected 3 numbers, as in the lines before, got 2" sh -c "printf '1 1 1\n2 2\n' | probe-query baked.probe"
refused 1 "stdin:1: expected x y z or x y z nx ny nz, got 4 numbers" sh -c "echo 1 2 3 4 | probe-query baked.probe"
refused 1 "stdin:1: expected a number, got 'x'" sh -c "echo 1 x 3 | probe-query baked.probe"
refused 1 "stdin:1: expected finite numbers, got nan" sh -c "echo 1 nan 3 | probe-query baked.probe"
refused 1 "stdin:1: expected finite numbers, got inf" sh -c "echo 1 inf 3 | probe-query baked.probe"
refused 1 "stdin:1: expected a normal with a length" sh -c "echo 1 1 1 0 0 0 | probe-query baked.probe"
refused 1 "stdin: point 0: expected 24 bytes, got 5" sh -c "printf 12345 | probe-query --from binary baked.probe"
refused 1 "No space left" sh -c "probe-query -q baked.probe points.txt >/dev/full"
refused 2 "cannot both" probe-query -
refused 2 "BAKED" probe-query
check "and the distance of a point at 1e300 is told" sh -c "echo 1e300 0 0 | probe-query -q --explain baked.probe | tail -1 | grep -q ' outside 1e+300\$'"
check "1e300 is answered" sh -c "echo 1e300 -1e300 1 | probe-query -q baked.probe | awk '{ exit NF != 12 }'"
tap_done
