#!/bin/sh
# probe-query as users run it.
. "${SRC:?}/tests/setup.sh"

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
echo "9 2 2" | probe-query --explain baked.probe >light 2>err
check "outside: the nearest point of the hull, and it says so" sh -c "grep -q ' outside 5.5\$' light && tail -n 1 light | awk '{ exit !(\$1 == 3.5) }' && grep -q '1 points are outside' err"
check "inside is said too" sh -c "echo 2 2 2 | probe-query --explain baked.probe | grep -q ' inside 0\$'"
awk 'BEGIN { srand(1); for (i = 0; i < 20000; i++) print 4 * rand(), 4 * rand(), 4 * rand() }' >points.txt
check "20000 points, in order" sh -c "probe-query -q baked.probe points.txt >light && [ \$(wc -l <light) -eq 20000 ]"
check "each is what it is alone" sh -c "tail -n 1 points.txt | probe-query -q baked.probe | cmp - \$(tail -n 1 light >last; echo last)"
check "binary out is text's numbers" sh -c "probe-query -q --to binary baked.probe points.txt | od -An -v -w48 -tf4 | awk '{ print \$1 + 0 }' >b; awk '{ printf \"%.6g\n\", \$1 }' light >t; paste b t | awk '{ d = \$1 - \$2; if (d * d > 1e-9) exit 1 }'"
perl -ne 'print pack("d<3", split)' points.txt >points.bin 2>/dev/null && check "binary in is text's points" sh -c "probe-query -q --from binary baked.probe points.bin | cmp - light"
check "a stream of points" sh -c "probe-query -q --to stream baked.probe points.txt | probe-cat --info | grep -q 'table probe: 20000 rows'"
check "another column" sh -c "echo 2 2 2 | probe-query --column hull_normal baked.probe | awk '{ exit NF != 3 }'"
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
check "1e300 is answered" sh -c "echo 1e300 -1e300 1 | probe-query -q baked.probe | awk '{ exit NF != 12 }'"
tap_done
