#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-query as users run it.
. "${SRC:?}/tests/support/setup.sh"

# -- light that is linear in place -----------------------------------------------------------------
# L00 = (x, y, 2), order 2 with a gradient along y in L1-1.
probe-place grid --spacing 1 --clearance 50% --bounds 0,0,0,4,4,4 --text | numbers |
    awk '{ print $1, $2, $3, $1, $2, 2, $3, 0, 0, 0, 0, 0, 0, 0, 0 }' |
    stream_of "sh-order 2" "sh-content radiance" "table probe position:f64:3 sh:f32:12" |
    probe-tet >baked.probe

echo "1.25 2.5 3.25" | probe-query baked.probe >light
check "coefficients are interpolated linearly" every 'NF == 12 && $3 == 2 &&
    near($1, 1.25, 3e-5) && near($2, 2.5, 3e-5) && near($4, 3.25, 3e-5)' light
echo "1.25 2.5 3.25 0 2 0" | probe-query baked.probe >light
check "irradiance for a normal of any length: pi Y00 L00 + 2 pi / 3 Y1-1 L1-1" every 'NF == 3 &&
    near($1, 3.14159265 * 0.282095 * 1.25 + 2.0943951 * 0.488603 * 3.25, 1e-3) &&
    near($2, 3.14159265 * 0.282095 * 2.5, 1e-3)' light
sed 's/^sh-content.*/sh-content irradiance/' baked.probe >convolved.probe
echo "1.25 2.5 3.25 0 2 0" | probe-query convolved.probe >light
check "convolved coefficients are used as they are" every 'near($2, 0.282095 * 2.5, 3e-5)' light
echo "9 2 2" | probe-query --outside nearest --explain baked.probe >light 2>err
tail -n 1 light >last
check "outside: the nearest point of the hull, and it says so" \
    says light ' outside 5.5$' and every '$1 == 3.5' last and says err '1 points are outside'
echo "2 2 2" | probe-query --explain baked.probe >light
check "inside is said too" says light ' inside 0$'

# -- a wall between probes -------------------------------------------------------------------------
printf 'v 1.7 -9 -9\nv 1.7 9 -9\nv 1.7 9 9\nv 1.7 -9 9\nf 1 2 3 4\n' >wall.obj
behind() { echo "1.6 1.9 1.9" | probe-query --visible rays --scene wall.obj "$@"; }
behind baked.probe >light
check "--visible rays: light of the side that the point is on" every '$1 == 1.5 && $2 > 1.4' light
behind --explain baked.probe | tail -n 1 >light
check "and that is what --explain explains" every 'NF == 23 && $1 == 1.5 &&
    near($18 + $19 + $20 + $21, 1, 1e-6) && $18 * $19 * $20 * $21 == 0' light
awk 'BEGIN { srand(2); for (i = 0; i < 3000; i++) print 4 * rand(), 4 * rand(), 4 * rand() }' >many
for threads in 1 2; do
    probe-query -q --visible rays --scene wall.obj -j $threads baked.probe many >rays$threads
done
paste -d ' ' many rays1 >sides
check "each of many points, by any number of threads" cmp rays1 rays2 and has_lines 3000 sides \
    and every '$1 < 1.7 ? $4 < 1.51 : $4 > 2.49' sides
printf 'v 2 -9 -9\nv 2 9 -9\nv 2 9 9\nv 2 -9 9\nf 1 2 3 4\n' >other.obj
probe-capture -q --rays 4 --bounces 0 other.obj baked.probe | probe-tet >other.probe
refused 1 "not the scene that the probes were captured in" \
    probe-query --visible rays --scene wall.obj other.probe many
refused 1 "--interpolate barycentric" behind --interpolate nearest baked.probe
probe-query --pack float -o baked.pack baked.probe
refused 1 "a packed file does not say how its scene is read" behind baked.pack
refused 2 "need each other" probe-query --visible rays baked.probe
# sight that is missing
probe-cat --text baked.probe | awk '/^table/ { cells = 0 }
    cells && /^[0-9]/ { $0 = $0 (++row == 3 ? " nan nan nan nan nan nan nan nan nan nan nan nan" : \
                                 " 0 0 0 0 0 0 0 0 0 0 0 0") }
    /^table tet/ { cells = 1; $0 = $0 " sight:f32:12" } { print }' >unsighted.probe
refused 1 "cell 2: sight is not finite" probe-query unsighted.probe many
refused 2 "need each other" probe-query --scene wall.obj baked.probe
refused 2 "no --visible rays" \
    probe-query --pack float --visible rays --scene wall.obj -o x baked.probe

# -- many points, in each form ---------------------------------------------------------------------
awk 'BEGIN { srand(1); for (i = 0; i < 20000; i++) print 4 * rand(), 4 * rand(), 4 * rand() }' \
    >points.txt
check "20000 points, in order" \
    into light probe-query -q baked.probe points.txt and has_lines 20000 light
tail -n 1 light >last
tail -n 1 points.txt | probe-query -q baked.probe >alone
check "each is what it is alone" cmp alone last and test -s alone
probe-query -q --to binary baked.probe points.txt | as_text f4 12 >binary
check "binary out is text's numbers" near 3e-5 binary light and has_lines 20000 binary
perl -ne 'print pack("d<3", split)' points.txt >points.bin 2>/dev/null &&
    check "binary in is text's points" \
        into again probe-query -q --from binary baked.probe points.bin and test -s again \
        and cmp again light
probe-query -q --to stream baked.probe points.txt | probe-cat --info >info
check "a stream of points" says info 'table probe: 20000 rows'
echo "2 2 2" | probe-query --column hull_normal baked.probe >normal
check "another column" every 'NF == 3' normal

# -- outside of the hull ---------------------------------------------------------------------------
for outside in extend nearest; do
    echo "3.5000001 2 2" | probe-query -q --outside $outside baked.probe >light
    check "outside $outside: on the hull, it is the hull's" every 'near($1, 3.5, 1e-5)' light
done
echo "9 2 2" | probe-query -q --outside zero baked.probe >light
awk '{ for (i = 1; i <= NF; i++) print $i }' light >each
check "outside zero: no light" every '$1 == 0' each and has_lines 12 each
refused 1 "stdin:2: the point is outside of the hull of the probes, 5.5 away" \
    given "1 1 1
9 2 2" probe-query --outside error baked.probe
awk 'function around() { return 9 * rand() - 2 }
    BEGIN {
        srand(2)
        for (i = 0; i < 12000; i++)
            print around(), around(), around(), rand() - .5, rand() - .5, rand() + .1
    }' >around.txt
for threads in 1 3; do
    probe-query -q --threads $threads baked.probe around.txt | cksum
done >sums
uniq sums >different
check "the same bytes for any number of threads" \
    has_lines 1 different and has_lines 2 sums and lacks sums ' 0$'
probe-query -q baked.probe around.txt >in_order
awk '{ print NR, $0 }' around.txt | sort -k 2,2g >shuffled
cut -d ' ' -f 2- shuffled | probe-query -q baked.probe - | paste -d ' ' shuffled - | sort -n |
    cut -d ' ' -f 8- >sorted
check "and for any order of the points" cmp sorted in_order and has_lines 12000 in_order

# -- the same probes in another order: the same light, to the bit, inside and outside the hull -----
lit() { # SEED: random light for positions
    awk -v seed="$1" 'BEGIN { srand(seed) }
        { printf "%s", $0; for (i = 0; i < 12; i++) printf " %.7g", rand() - .3; print "" }' |
        stream_of "sh-order 2" "sh-content radiance" "table probe position:f64:3 sh:f32:12"
}
awk 'function around() { return 9 * rand() - 2 }
    BEGIN { srand(3); for (i = 0; i < 3000; i++) print around(), around(), around() }' |
    lit 4 >random.probe
awk 'BEGIN {
        for (i = 0; i < 1728; i++) print .5 * (i % 12), .5 * (int(i / 12) % 12), .5 * int(i / 144)
    }' | lit 5 >grid.probe
awk 'function noise() { return 1e-6 * rand() }
    BEGIN {
        srand(6)
        for (i = 0; i < 1728; i++) {
            x = i % 12 + noise()
            y = int(i / 12) % 12 + noise()
            z = int(i / 144) + noise()
            a = .8 * x - .6 * y
            b = .6 * x + .8 * y
            printf "%.17g %.17g %.17g\n", .5 * a, .5 * (.96 * b - .28 * z), .5 * (.28 * b + .96 * z)
        }
    }' | lit 7 >turned.probe
awk '{ print $1, $2, $3 }
    NR % 10 == 0 {
        print int($1), int($2), int($3)
        print int($1) + .5, int($2), int($3 * 2) / 2
    }' around.txt >places.txt
bytes=$((48 * $(wc -l <places.txt)))
for set in random grid turned; do
    sed '1,/^table/d; /^end/d' $set.probe | awk 'BEGIN { srand(8) } { print rand(), $0 }' |
        sort -k 1,1g | cut -d ' ' -f 2- >rows
    { sed '/^table/q' $set.probe; cat rows; echo end; } >other.probe
    probe-tet $set.probe | probe-query -q --to binary - places.txt >a
    probe-tet other.probe | probe-query -q --to binary - places.txt >b
    check "$set probes, shuffled: the same light, to the bit" \
        not cmp -s $set.probe other.probe and [ "$(wc -c <a)" -eq $bytes ] and cmp a b
done

# -- unasked, light outside is that of the nearest point -------------------------------------------
# Before dents it goes on along rays, unless their core is small, as of this hull which leakfix
# mended.
walls=$SRC/scenes/coloured-walls.gltf
probe-tet turned.probe >dented.probe
probe-place grid -q --count 300 --ground 4 --clearance 30% "$walls" |
    probe-capture -q --order 1 --columns none --rays 16 "$walls" |
    probe-tet -q | probe-leakfix -q --rounds 4 "$walls" >mended.probe
outside() { # outside WHAT STREAM HOW: what is said of a point outside
    echo "99 0 0" | probe-query --outside "$1" "$2" >light 2>err
    check "outside of $2, $1: $3" says err "$3\$" and test -s light
}
for hull in dented mended; do probe-tet --verify $hull.probe 2>$hull.dents >/dev/null; done
check "these hulls have dents" \
    says dented.dents '[1-9][0-9]* dents' and says mended.dents '[1-9][0-9]* dents'
outside auto baked.probe "nearest point"
outside auto dented.probe "along rays"
outside auto mended.probe "nearest point"
outside extend mended.probe "along rays"

# -- gradients near surfaces -----------------------------------------------------------------------
# A roof and a box on open ground; a plane of the grid lies in the top of the roof, 1 mm or 5 cm
# above it, where gradients are steep. De-rung, so that no probe is darker than dark. The mean is
# 14.
box() { # box X0 Y0 Z0 X1 Y1 Z1: its faces, outward
    awk -v "b=$*" 'BEGIN { split(b, v)
        for (i = 0; i < 8; i++)
            print "v", v[1 + 3 * (i % 2)], v[2 + 3 * (int(i / 2) % 2)], v[3 + 3 * int(i / 4)]
        n = split("-8 -6 -5 -7,-4 -2 -1 -3,-8 -7 -3 -4,-6 -2 -1 -5,-8 -4 -2 -6,-7 -5 -1 -3", f, ",")
        for (i = 1; i <= n; i++) print "f", f[i] }'
}
for roof in 2.6 2.599 2.55; do
    {
        printf '%s\n' 'v -10 0 -10' 'v -10 0 10' 'v 10 0 10' 'v 10 0 -10' 'f 1 2 3 4'
        box 3 2.5 -1 7 "$roof" 1
        box -2 0 -2 2 4 2
    } >shade.obj
    probe-place grid -q --spacing 1.5,2,1.5 --clearance .75 --bounds -9,0.2,-9,9,5,9 --inside keep \
        shade.obj |
        probe-capture -q --rays 64 --sky .1,.1,.15 --sun .5,-1,.3,30,30,30 \
            --columns sh_gradient --dering irradiance shade.obj | probe-tet -q >shade.probe
    rows_of position,sh_gradient,sh shade.probe | cut -d ' ' -f 4-84 | tr ' ' '\n' |
        sed 's/^-//' | sort -g | tail -n 1 >steepest
    check "roof at $roof: gradients are not those of a surface that a probe lies in" \
        every '$1 > 1 && $1 < 200' steepest
    awk 'BEGIN { srand(3); for (i = 0; i < 2000; i++) print 16 * rand() - 8, .3 + 4 * rand(),
        16 * rand() - 8, rand() - .5, rand() - .5, rand() - .5 }' >shaded.txt
    for how in barycentric gradient cubic; do
        probe-query -q --interpolate $how shade.probe shaded.txt >$how
    done
    most=$(sort -g barycentric | tail -n 1 | cut -d ' ' -f 1)
    for how in gradient cubic; do
        check "roof at $roof, $how: no light 3 % below 0, or twice the brightest of barycentric" \
            every "\$1 > -.42 && \$2 > -.42 && \$3 > -.42 && \$1 < 2 * $most" $how
    done
done

# -- an octree -------------------------------------------------------------------------------------
# A box of two cells, of which the second is cut, and one part of that again; light as above, then
# with a bend.
awk 'function nodes(x, y, z, s, n, i) {
        for (i = 0; i < (n + 1) ^ 3; i++)
            print x + s * (i % (n + 1)) / n, y + s * (int(i / (n + 1)) % (n + 1)) / n, \
                z + s * int(i / (n + 1) ^ 2) / n
    }
    BEGIN { nodes(0, 0, 0, 4, 1); nodes(4, 0, 0, 4, 2); nodes(4, 2, 0, 2, 2) }' | sort -u >tree.txt
tree() { # LIGHT: an octree with this L00 of red
    probe-place points -q --text tree.txt | numbers |
        awk '{ x = $1; y = $2; z = $3; print x, y, z, '"$1"', x + y, 2 }' |
        stream_of "sh-order 1" "sh-content radiance" "table probe position:f64:3 sh:f32:3"
}
tree z >tree.probe
tree 'x * x + (y - 3) * z' >bent.probe
awk 'BEGIN { srand(3); for (i = 0; i < 3000; i++) print 8 * rand(), 4 * rand(), 4 * rand() }' \
    >in_tree.txt
awk 'BEGIN {
        srand(4)
        for (i = 0; i < 2000; i++) {
            y = 4 * rand()
            z = 4 * rand()
            print 3.999999999, y, z
            print 4.000000001, y, z
        }
    }' >border.txt
{ grep -v '^[0-9e]' bent.probe; grep '^[0-9]' bent.probe | sort -r; echo end; } >reversed.probe
for how in trilinear tricubic; do
    at() { probe-query -q --interpolate $how "$@"; }
    at tree.probe in_tree.txt | paste -d ' ' in_tree.txt - >both
    check "$how of an octree: linear fields" \
        every '($4 - $3) ^ 2 + ($5 - $1 - $2) ^ 2 + ($6 - 2) ^ 2 <= 1e-9' both
    at bent.probe tree.txt | paste -d ' ' tree.txt - >both
    check "$how of an octree: at probes, their light" \
        every 'near($4, $1 * $1 + ($2 - 3) * $3, 1e-4)' both
    at bent.probe border.txt | paste -d ' ' - - >both
    check "$how of an octree: the same on both sides of where sizes meet" \
        every 'NF == 6 && near($1, $4, 3e-5)' both
    at bent.probe in_tree.txt >a
    at reversed.probe in_tree.txt >b
    check "$how of an octree: the same bytes in any order of its probes" cmp a b and test -s a
done
probe-query -q --interpolate inverse bent.probe tree.txt | paste -d ' ' tree.txt - >both
check "inverse, of an octree: at probes, their light" \
    every 'near($4, $1 * $1 + ($2 - 3) * $3, 1e-4)' both
echo "9 1 2" | probe-query --interpolate trilinear tree.probe >light 2>err
check "outside of an octree is said, and gets the light of its border" \
    says light '^2 9 2$' and says err '1 points are outside'
grep -v '^6 2 0 ' tree.probe >holed.probe
hole="there is no probe at 6 2 0, a node of the cell (with a probe in its middle)"
hole="$hole from 4 0 0 to 8 4 4"
refused 1 "nor: the probes are not the corners of an octree's cells: $hole" \
    given "1 1 1" probe-query --interpolate trilinear holed.probe
sed 's/^6 2 0 .*/6 2 0 nan nan nan/' tree.probe >dark.probe
refused 1 "has no light: run probe-capture" \
    given "1 1 1" probe-query --interpolate tricubic dark.probe

# -- packed files ----------------------------------------------------------------------------------
probe-query --pack float -o baked.pack baked.probe
probe-query --pack half -o half.pack baked.probe
probe-query -q baked.probe around.txt >light
probe-query -q baked.pack around.txt >packed
probe-query -q half.pack around.txt >halves
check "a packed file gives the light of its stream" near 1e-5 light packed and test -s light
check "with halves, to their rounding" near 3.16e-3 light halves
check "halves take fewer bytes" [ "$(wc -c <half.pack)" -lt "$(wc -c <baked.pack)" ]
"$BUILD/doc/example" half.pack 0 0 0 4 4 4 | grep side >sides
check "the example opens it" has_lines 11 sides
head -c 5000 half.pack >short.pack
refused 1 "short.pack: the packed file is damaged" given "1 1 1" probe-query short.pack
refused 1 "holds the column sh, and not ao" given "1 1 1" probe-query --column ao half.pack
refused 2 "--groups is of packed files: it needs --pack" probe-query --groups baked.probe around.txt
refused 2 "--groups packs column sh and those of all groups: no --column" \
    probe-query --pack half --groups --column sh_lamp baked.probe
refused 1 "the probes have no groups of lights (no column sh_NAME): run probe-capture --groups" \
    probe-query --pack half --groups -o x baked.probe
refused 1 "a packed file with groups of lights is made of a stream" \
    probe-query --pack half --groups -o x half.pack
echo 1 1 1 0 1 0 2 3 4 5 |
    stream_of "table probe position:f64:3 normal:f32:3 radius:f32:1 irradiance:f32:3" >light.probe
probe-query --interpolate discs --pack half -o light.pack light.probe
check "a packed file of discs answers" into got given "1 1 1.5 0 1 0" \
    probe-query --interpolate discs light.pack and says got '^3 4 5$'
refused 1 "discs are packed without groups of lights" \
    probe-query --interpolate discs --pack half --groups -o x light.probe
refused 2 "--pack packs cells or discs" probe-query --pack half --interpolate nearest baked.probe
refused 1 "light.pack: a packed file of discs is asked as such" \
    given "1 1 1 0 1 0" probe-query light.pack
for dial in "--radius 1" "--column ao"; do
    refused 1 "light.pack: a packed file of discs h" \
        given "1 1 1 0 1 0" probe-query --interpolate discs $dial light.pack
done
refused 1 "--interpolate discs expects points with a normal" \
    given "1 1 1" probe-query --interpolate discs light.pack
refused 1 "a packed file of discs is made of a stream" \
    probe-query --interpolate discs --pack half -o x light.pack
refused 2 "--pack takes no points" probe-query --pack half baked.probe around.txt

# -- probes in a plane, on a line, in one place ----------------------------------------------------
flat() { # LINE...: a stream of order 1 with these lines
    printf '%s\n' '#?probe 1' 'sh-order 1' 'sh-content radiance' \
        'table probe position:f64:3 sh:f32:3' "$@"
}
flat '0 0 0 1 0 0' '1 0 0 2 0 0' '0 0 1 1 1 0' '1 0 1 2 1 0' \
    'table tri vertex:i32:3 neighbour:i32:3' '0 1 2 1 -1 -1' '1 3 2 -1 0 -1' end >plane.probe
flat '0 0 0 1 0 0' '2 0 0 3 0 0' '4 0 0 1 0 0' \
    'table segment vertex:i32:2 neighbour:i32:2' '0 1 1 -1' '1 2 -1 0' end >line.probe
flat '1 2 3 4 5 6' 'table point vertex:i32:1 neighbour:i32:1' '0 -1' end >one.probe
answers() { # LIGHT POINT...: what is asked after gets this light
    echo "$1" >expected
    shift
    "$@" | cmp - expected
}
check "a plane of probes: the point below" \
    answers "1.25 0.5 0" given ".25 7 .5" probe-query plane.probe
check "beyond its border: the nearest point" \
    answers "1.25 1 0" given ".25 7 5" probe-query -q plane.probe
check "a line of probes" answers "2 0 0
1 0 0" given "3 1 1
-9 0 0" probe-query -q line.probe
check "one probe" answers "4 5 6" given "7 8 9" probe-query -q one.probe
sed 's/^table tri/table segment vertex:i32:2 neighbour:i32:2\n0 1 -1 -1\ntable tri/' plane.probe \
    >both.probe
refused 1 "there are cells in table segment already" given "0 0 0" probe-query both.probe
sed 's/^1 3 2 -1 0 -1/1 3 2 -1 0 0/' plane.probe >torn.probe
refused 1 "cell 1: a cell names a neighbour that does not exist or does not share the face" \
    given "0 0 0" probe-query torn.probe
flat 'table tri vertex:i32:3 neighbour:i32:3' end >empty.probe
refused 1 "there are no cells" given "0 0 0" probe-query empty.probe

# -- pipes -----------------------------------------------------------------------------------------
# A thread that waits for more points does not keep a failed program alive.
mkfifo held
exec 3<>held
printf '1 1 1\n1 1\n' >&3
timeout 60 probe-query --threads 3 baked.probe <held 2>err
status=$?
exec 3>&-
check "bad input ends it, though the pipe stays open" [ $status -eq 1 ] and says err 'stdin:2'
probe-query baked.probe </dev/null >light
check "no points, no light" empty light
# An answer comes before the next question.
mkfifo ask answer
probe-query -q baked.probe <ask >answer &
exec 3>ask 4<answer
echo "1 1 1" >&3
read -r first <&4
exec 3>&-
wait
exec 4<&-
check "a pipe is answered point by point" [ -n "$first" ]

# -- surface probes --------------------------------------------------------------------------------
awk 'BEGIN { for (i = 0; i < 125; i++)
    print i % 5, int(i / 5) % 5, int(i / 25), 0, 1, 0, i % 5, 2, 3 }' |
    stream_of "table probe position:f64:3 normal:f32:3 irradiance:f32:3" |
    probe-tet >surfaces.probe
echo "1.25 2 3" | probe-query --column irradiance surfaces.probe >light
check "surface probes are asked without a normal" every 'near($1, 1.25, 1e-5) && $2 == 2' light
# A floor and a wall that meet in an edge: light 1 and 3 on the floor, 8 on the wall.
probe-tet -q >corner.probe <<'END'
#?probe 1
table probe position:f64:3 normal:f32:3 irradiance:f32:3
0 0 0  0 1 0  1 1 1
2 0 0  0 1 0  3 3 3
0 2 0  1 0 0  8 8 8
end
END
for ask in "1 0 0 0 7 0=2" "1 0 0 .1 0 0=fails" ".5 .5 0 0 1 0=1.666667" ".5 .5 0 2 0 0=8" \
    ".5 .5 0 1 1 0=3.25" "0 0 0 0 1 0=1" "0 1 0 0 -1 0=fails"; do
    echo "${ask%=*}" | probe-query --column irradiance corner.probe >light 2>err
    if [ "${ask#*=}" = fails ]; then
        check "surface probes asked at and towards ${ask%=*}: none faces so" \
            says err 'stdin:1: none of the surface probes around the point faces'
    else
        check "surface probes asked at and towards ${ask%=*}: those that face so, by the cosine" \
            every "NF == 3 && near(\$2, ${ask#*=}, 1e-5)" light
    fi
done
echo "1 0 0 0 7 0" | probe-query --to stream --column irradiance corner.probe >asked.probe
check "as a stream of surface probes" says asked.probe \
    '^table probe position:f64:3 normal:f32:3 irradiance:f32:3$'
refused 1 "surface probes are asked with a normal by --interpolate discs or barycentric alone" \
    given "1 0 0 0 1 0" probe-query --interpolate nearest --column irradiance corner.probe
printf '%s\n' '#?probe 1' 'table probe position:f64:3 irradiance:f32:3' '0 0 0 1 1 1' end \
    >bare.probe
# A sheet: light 1 above, 0 below, at the same places.
{
    printf '%s\n' '#?probe 1' \
        'table probe position:f64:3 normal:f32:3 radius:f32:1 irradiance:f32:3'
    for x in 0 1 2 3; do
        echo "$x 0 0  0 1 0  .6  1 1 1"
        echo "$x 0 0  0 -1 0  .6  0 0 0"
    done
    echo end
} >sheet.probe
for falloff in linear quadratic cubic; do
    printf '%s\n' '.7 0 .1 0 2 0' '.7 0 .1 0 -1 0' '9 0 0 0 1 0' |
        probe-query --interpolate discs --falloff $falloff sheet.probe >light 2>err
    check "discs, $falloff: a sheet has its own light on each side" \
        every 'near($1, NR != 2, 1e-6)' light and says err '1 points are covered by no disc'
done
echo '9 0 0 0 1 0' | probe-query -q --interpolate discs --outside zero sheet.probe >light
check "discs: --outside zero is of what none covers" says light '^0 0 0$'
sed 's/ 0 1 0 / 0 9 0 /; s/ 0 -1 0 / 0 -.3 0 /' sheet.probe >long.probe
printf '%s\n' '.7 .1 .1 0 2 0' '.7 -.1 .1 0 -1 0' |
    probe-query --interpolate discs long.probe >light 2>err
check "discs: probes' normals may have any length" \
    every 'near($1, NR == 1, 1e-6)' light and [ ! -s err ]
sed 's/^3 0 0 .*/3 0 0 nan nan nan nan nan nan nan/' sheet.probe >mixed.probe
echo '.7 0 .1 0 1 0' | probe-query --interpolate discs mixed.probe >light
check "discs: probes in space, without a radius, may stand between" says light '^1 1 1$'
cat >unsized.probe <<'EOF'
#?probe 1
table probe position:f64:3 normal:f32:3 radius:f32:1 irradiance:f32:3
0 0 0 0 1 0 .5 1 1 1
.1 0 0 0 1 0 nan 5 5 5
9 0 0 0 1 0 .5 3 3 3
end
EOF
printf '%s\n' '.1 0 0 0 1 0' '1e300 0 0 0 1 0' |
    probe-query -q --interpolate discs unsized.probe >light
check "discs: nan as a radius is none, and a place that is far out is answered" \
    says light '^1 1 1$' '^[13] [13] [13]$'
sed 's/ \.5 / nan /' unsized.probe >none.probe
refused 1 "no surface probe has both irradiance and a radius" \
    given '0 0 0 0 1 0' probe-query --interpolate discs none.probe
sed 's/ nan / 0 /' unsized.probe >zero.probe
refused 1 "probe 1: expected a radius from" \
    given '0 0 0 0 1 0' probe-query --interpolate discs zero.probe
refused 1 "expected discs with a radius from 1.17549e-38 to 3.40282e+38, got 1e+300" \
    given '0 0 0 0 1 0' probe-query --interpolate discs --radius 1e300 sheet.probe
sed 's/ \.6 / 3e38 /' sheet.probe >large.probe
refused 1 "probe 0: expected a radius from 5.87747e-39 to 1.70141e+38, got 3e+38" \
    given '0 0 0 0 1 0' probe-query --interpolate discs large.probe
sed 's/^3 /1e308 /; s/^0 /-1e308 /' sheet.probe >far.probe
refused 1 "too far from one another for discs" \
    given '0 0 0 0 1 0' probe-query --interpolate discs far.probe
refused 1 "no disc of a surface probe covers the point" \
    given '9 0 0 0 1 0' probe-query --interpolate discs --outside error sheet.probe
refused 1 "stdin:1: none of the surface probes faces" \
    given '0 0 0 1 0 0' probe-query --interpolate discs sheet.probe
refused 1 "discs expects points with a normal" \
    given '0 0 0' probe-query --interpolate discs sheet.probe
refused 1 "have no column normal" \
    given '0 0 0 0 1 0' probe-query --interpolate discs --column irradiance bare.probe
for points in "1 2 3" "1 2 3 0 1 0"; do
    refused 1 "each has the irradiance of its own normal (--column irradiance)" \
        given "$points" probe-query surfaces.probe
done

# -- what is refused -------------------------------------------------------------------------------
probe-place grid --spacing 1 --clearance 50% --bounds 0,0,0,4,4,4 >placed.probe
refused 1 "run probe-tet" given "1 1 1" probe-query placed.probe
probe-tet placed.probe >dark.probe
refused 1 "run probe-capture" given "1 1 1" probe-query dark.probe
probe-tet --enclose baked.probe >corners.probe
refused 1 "has no light: run probe-capture" given "-0.1 -0.1 -0.1" probe-query corners.probe
refused 1 "stdin:2: expected 3 numbers, as in the lines before, got 2" \
    given "1 1 1
2 2" probe-query baked.probe
refused 1 "stdin:1: expected x y z or x y z nx ny nz, got 4 numbers" \
    given "1 2 3 4" probe-query baked.probe
refused 1 "stdin:1: expected a number, got 'x'" given "1 x 3" probe-query baked.probe
refused 1 "stdin:1: expected finite numbers, got nan" given "1 nan 3" probe-query baked.probe
refused 1 "stdin:1: expected finite numbers, got inf" given "1 inf 3" probe-query baked.probe
refused 1 "stdin:1: expected a normal with a length" given "1 1 1 0 0 0" probe-query baked.probe
printf 12345 >five.bin
refused 1 "stdin: point 0: expected 24 bytes, got 5" \
    probe-query --from binary baked.probe <five.bin
refused 1 "No space left" into /dev/full probe-query -q baked.probe points.txt
refused 2 "cannot both" probe-query -
refused 2 "BAKED" probe-query
echo "1e300 0 0" | probe-query -q --explain baked.probe >light
check "and the distance of a point at 1e300 is told" says light ' outside 1e+300$'
echo "1e300 -1e300 1" | probe-query -q baked.probe >light
check "1e300 is answered" every 'NF == 12' light

# beside one lit node a cubic would swing to a seventh of it below 0
awk 'BEGIN {
    print "#?probe 1\nsh-order 1\nsh-content radiance\ntable probe position:f64:3 sh:f32:3"
    for (i = 0; i < 216; i++)
        print i % 6, int(i / 6) % 6, int(i / 36), (i == 86 ? "10 10 10" : "0 0 0")
    print "end"
}' >lit.probe
awk 'BEGIN { for (i = 0; i < 400; i++) print i % 20 / 4, 2 + int(i / 20) / 10, 2.1 }' >beside
probe-query -q --interpolate tricubic lit.probe beside >light
check "a tricubic blend goes no farther below 0 than its nodes" every '$1 > -0.01' light
awk '$1 > 5' light >bright
check "and is there all the same" test -s bright
# the same in an octree: a box of cells of 1, of which the one that begins at 2 2 2 is cut
awk 'BEGIN {
    print "#?probe 1\nsh-order 1\nsh-content radiance\ntable probe position:f64:3 sh:f32:3"
    for (i = 0; i < 216; i++)
        print i % 6, int(i / 6) % 6, int(i / 36), (i == 86 ? "10 10 10" : "0 0 0")
    for (i = 0; i < 27; i++)
        if (i % 3 == 1 || int(i / 3) % 3 == 1 || int(i / 9) == 1)
            print 2 + i % 3 / 2, 2 + int(i / 3) % 3 / 2, 2 + int(i / 9) / 2, "0 0 0"
    print "end"
}' >lit.probe
probe-query -q --interpolate tricubic lit.probe beside >light
check "nor does one of an octree" every '$1 > -0.01' light
awk '$1 > 5' light >bright
check "and that is there as well" test -s bright
# -- along a way -----------------------------------------------------------------------------------
# x = 2 t, v = x^2, whose gradient along x is 2 x; rows in no order
printf '%s\n' '4 0 0 2 16 8 0 0' '0 0 0 0 0 0 0 0' '6 0 0 3 36 12 0 0' '2 0 0 1 4 4 0 0' |
    stream_of "table probe position:f64:3 time:f64:1 v:f32:1 v_gradient:f32:3" >way.probe
# numbers_are FILE NUMBER...: a line each
numbers_are() { file=$1; shift; printf '%s\n' "$@" | cmp - "$file"; }
along() { probe-query -q --column v --along time "$@" way.probe times; }
printf '%s\n' 0 .5 1.25 3 >times
along >light
check "--along time: between the probes before and behind" numbers_are light 0 2 7 36
along --interpolate cubic >light
check "cubic: by their gradients along the way's velocity" numbers_are light 0 1 6.25 36
along --interpolate cubic --to stream | probe-cat --text >stream
check "a stream says where that is" says stream \
    '^table probe position:f64:3 time:f64:1 v:f32:1$' '^2.5 0 0 1.25 6.25$'
printf '%s\n' -1 4.5 >times
probe-query --column v --along time way.probe times >light 2>err
check "before the first and behind the last: theirs, and it says so" numbers_are light 0 36 \
    and says err '2 points are before the first probe or behind the last'
refused 1 "times:1: expected a number from the first probe's to the last one's" \
    along --outside error
refused 1 "linear, or cubic where there are gradients" along --interpolate nearest
refused 1 "no column when: probe-place path writes time" \
    probe-query --column v --along when way.probe times
refused 1 "stdin:1: expected t or t nx ny nz, got 2 numbers" \
    given '1 2' probe-query --column v --along time way.probe
refused 2 "--along needs neither cells nor a hull" along --outside extend
refused 1 "a packed file has no column time" probe-query --along time baked.pack times
# a circle, lit by a field that is linear in place: the cubic is nearly it, the line is not
awk 'BEGIN {
        for (i = 0; i <= 12; i++) print cos(i * .5), sin(i * .5), 0, i, cos(i * .5), 1, 0, 0
    }' |
    stream_of "table probe position:f64:3 time:f64:1 v:f32:1 v_gradient:f32:3" >way.probe
awk 'BEGIN { for (i = 0; i < 12; i += .25) print i }' >times
along | paste -d ' ' times - >straight
along --interpolate cubic | paste -d ' ' times - >smooth
check "a way that bends: cubic is that of the bend" every 'near($2, cos($1 * .5), .006)' smooth
check "and linear that of the chord" sh -c "! awk '{ d = \$2 - cos(\$1 * .5) }
    d * d > 9e-4 { exit 1 }' straight"
printf '%s\n' '0 0 0 0 1 1 2' '1 0 0 1 3 1 2' |
    stream_of "sh-order 1" "sh-content radiance" "table probe position:f64:3 time:f64:1 sh:f32:3" \
        >lit.probe
echo '.5 0 3 0' | probe-query --along time lit.probe >light
check "t and a normal: irradiance" every 'near($1, 3.14159265 * 0.282095 * 2, 1e-5)' light

# beside a surface, where the gradient is as steep as 1 / distance
printf '%s\n' '0 .001 0 0 5 5 5 0 0 0 975 -975 975 0 0 0' '0 1 0 1 6 6 6 0 0 0 .5 .5 .5 0 0 0' \
    '0 3 0 3 6 6 6 0 0 0 0 0 0 0 0 0' |
    stream_of "sh-order 1" "sh-content radiance" \
        "table probe position:f64:3 time:f64:1 sh:f32:3 sh_gradient:f32:9" >steep.probe
for column in sh thing; do
    probe-cat --text steep.probe | sed "s/ sh:/ $column:/; s/ sh_/ ${column}_/" >of.probe
    probe-query -q --column $column --along time --interpolate cubic of.probe times |
        awk '{ for (i = 1; i <= NF; i++) print $i }' >light
    check "$column: a steep gradient makes no more than the light beside it bears" \
        every '$1 > 3 && $1 < 8' light and every 'near(NF, 1, 0)' light
done

# -- gradients at nodes: a parabola on an octree of which one cell is cut, far from the origin -----
awk 'BEGIN {
        for (z = 0; z <= 4; z++) for (y = 0; y <= 4; y++) for (x = 0; x <= 4; x++)
            if ((x % 2 == 0 && y % 2 == 0 && z % 2 == 0) || (x < 3 && y < 3 && z < 3))
                print x + 1e4, y, z, x * x + y * z, 2 * x, z, y
    }' | stream_of "table probe position:f64:3 v:f32:1 v_gradient:f32:3" >slopes.probe
awk 'BEGIN { srand(4); for (i = 0; i < 300; i++) print 1e4 + 2 * rand(), 2 * rand(), 2 * rand() }' \
    >many
probe-query --interpolate trilinear-gradient --column v slopes.probe many |
    paste -d ' ' many - >light
awk '$1 < 10001 && $2 < 1 && $3 < 1' light >fine
check "trilinear-gradient: parabolas come out" every \
    'near($4, ($1 - 10000) ^ 2 + $2 * $3, 1e-4)' fine
refused 1 "expected a column v_gradient" sh -c 'sed s/v_gradient/w/ slopes.probe |
    probe-query --interpolate trilinear-gradient --column v - many'

# -- nodes in no air -------------------------------------------------------------------------------
# 5 in the air, 100 elsewhere: on a grid, and on an octree of which one cell is cut
nodes() {
    awk -v side="$1" 'BEGIN {
            for (z = 0; z <= 4; z++) for (y = 0; y <= 4; y++) for (x = 0; x <= 4; x++)
                if ((x % 2 == 0 && y % 2 == 0 && z % 2 == 0) || side == "all" ||
                    (x < 3 && y < 3 && z < 3)) {
                    none = x + y + z > 5
                    print x, y, z, none, none ? 100 : 5, none ? 100 : x, none ? 100 : 5
                }
        }' | stream_of "sh-order 1" "sh-content radiance" \
            "table probe position:f64:3 inside:i32:1 sh:f32:3"
}
awk 'BEGIN { srand(4); for (i = 0; i < 300; i++) print 4 * rand(), 4 * rand(), 4 * rand() }' >many
for of in all octree; do
    nodes $of >$of.probe
    for how in trilinear tricubic; do
        probe-query --interpolate $how $of.probe many >$of.$how
        check "$of, $how: those in no air have no say" every \
            'near($1, 5, 1e-4) && near($3, 5, 1e-4) && $2 >= -.01 && $2 <= 4.01' $of.$how \
            and has_lines 300 $of.$how
    done
    awk 'BEGIN { for (i = 0; i <= 4000; i++) print 2.98 + i / 1e5, 1.37, 2.6 }' |
        probe-query --interpolate trilinear $of.probe | awk 'NR > 1 && ($2 - x) ^ 2 > .01 { exit 1 }
            { x = $2 }' && steady=yes || steady=no
    check "$of: and where a face is in none, light does not jump" [ $steady = yes ]
    probe-cat --text $of.probe | sed 's/inside:i32/unheard:i32/' >other.probe
    probe-cat --text $of.probe | awk '/^[0-9]/ { $4 = 0 } { print }' >none.probe
    for how in trilinear tricubic; do
        for as in other none; do
            probe-query --interpolate $how $as.probe many >$as.$how
        done
    done
    check "$of: where all are in the air, nothing changes" \
        cmp other.trilinear none.trilinear and cmp other.tricubic none.tricubic
done

# -- spheres that move -----------------------------------------------------------------------------
probe-place grid -q --count 30 "$SRC/scenes/cornell-box.obj" |
    probe-capture -q --rays 64 "$SRC/scenes/cornell-box.obj" | probe-tet -q >room.probe
printf '%s\n' '2 3 2 0 1 0' '3 2.5 3 0 1 0' >places
echo '1e6 0 0 1' >far.txt
printf '%s\n' '# a lamp shade' '2.7 5 2.7, 1.5' '2 3 2 .2 # about the first point' >near.txt
probe-query room.probe places >plain
probe-query --occluders far.txt room.probe places >with_far
probe-query --occluders near.txt room.probe places >shaded
check "a sphere far away changes nothing" cmp plain with_far and test -s plain
check "others take light, all inside of one" awk '
    NR == FNR { was[FNR] = $1; next }
    FNR == 1 { dark = $1 == 0 } FNR == 2 { less = $1 < was[2] && $1 > 0 }
    END { exit !(dark && less) }' plain shaded
check "the same on more threads" into three probe-query -j3 --occluders near.txt room.probe places \
    and cmp shaded three
echo '1 2 3 0' >flat.txt
refused 1 "flat.txt:1: expected X Y Z RADIUS" probe-query --occluders flat.txt room.probe places
echo '# none' >none.txt
refused 1 "expected spheres, there are none" probe-query --occluders none.txt room.probe places
refused 1 "takes radiance as SH" probe-query --occluders far.txt --column depth room.probe places
refused 2 "no --pack" probe-query --occluders far.txt --pack half room.probe
tap_done
