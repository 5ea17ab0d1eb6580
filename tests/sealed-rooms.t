#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A sealed dark room beside a lit one stays dark to its very corners: outside of the hull of the
# probes, too, where the wall leans and stands between a point and the probes that its light comes
# from.
. "${SRC:?}/tests/support/setup.sh"
cat >sealed.mtl <<'END'
newmtl white
Kd .7 .7 .7
newmtl lamp
Kd 0 0 0
Ke 10 10 10
END

# sealed LEAN TURN: a room of 4 x 2 x 2.5 with a wall through x = 2.1 + LEAN (y - 1) + TURN (z -
# 1.25), and a lamp below the ceiling of the left half
sealed() {
    awk -v lean="$1" -v turn="$2" '
        function at(y, z) { return 2.1 + lean * (y - 1) + turn * (z - 1.25) }
        BEGIN {
            print "mtllib sealed.mtl\nusemtl white"
            for (i = 0; i < 8; i++)
                print "v", i % 2 * 4, int(i / 2) % 2 * 2, int(i / 4) * 2.5
            for (i = 0; i < 4; i++)
                print "v", at(i % 2 * 2, int(i / 2) * 2.5), i % 2 * 2, int(i / 2) * 2.5
            print "v .4 1.99 .6\nv 1 1.99 .6\nv 1 1.99 1.6\nv .4 1.99 1.6"
            print "f 1 3 7 5\nf 2 6 8 4\nf 1 5 6 2\nf 3 4 8 7\nf 1 2 4 3\nf 5 7 8 6"
            print "f 9 10 12 11\nusemtl lamp\nf 13 14 15 16"
        }'
}
# points_of LEAN TURN: on both sides of the wall, to the corners: dark.txt and lit.txt
points_of() {
    awk -v lean="$1" -v turn="$2" 'BEGIN {
        for (i = 0; i < 41; i++)
            for (j = 0; j < 11; j++)
                for (k = 0; k < 13; k++) {
                    x = .005 + i * 3.99 / 40; y = .005 + j * 1.98 / 10; z = .005 + k * 2.49 / 12
                    beyond = x - (2.1 + lean * (y - 1) + turn * (z - 1.25))
                    if (beyond > .01) print x, y, z, 0, 1, 0 >"dark.txt"
                    if (beyond < -.01) print x, y, z, 0, 1, 0 >"lit.txt"
                }
    }'
}
# count_lit BAKED OPTION...: points of the dark room above a thousandth of the lit one's mean
count_lit() {
    probe-query -q "$@" lit.txt >lit.light
    probe-query -q "$@" dark.txt >dark.light
    lit=$(awk 'FNR == NR { sum += $1; next } $1 > 1e-3 * sum / (NR - FNR) { n++ }
        END { print n + 0 }' lit.light dark.light)
}

for lean in ".3 .1 150" "-.6 .3 300" ".2 -.5 200"; do
    set -- $lean
    sealed "$1" "$2" >sealed.obj
    points_of "$1" "$2"
    probe-place grid --clearance 50% -q --count "$3" sealed.obj |
        probe-capture -q --rays 32 --bounces 4 sealed.obj | probe-tet -q >cells.probe
    probe-leakfix sealed.obj cells.probe >baked.probe 2>said
    for how in nearest extend; do
        count_lit --outside $how baked.probe
        check "leaning by $1 and $2, $how: no point of the dark room is lit ($lit)" [ "$lit" = 0 ]
    done
    check "what leaks outside is said" says said 'outside: unseen .* %.* %' and \
        says said 'outside: leaks .* %.* %'
done
probe-cat --drop sight_outside,stand_in_outside baked.probe >inside.probe
count_lit inside.probe
check "without what cells keep of the outside $lit points were" [ "$lit" -gt 5 ]
probe-query --pack half -q -o packed baked.probe
count_lit packed
check "and with it, none of a packed file" [ "$lit" = 0 ]
probe-error -q --points 20 --paths 0 --truth-rays 16 --tsv sealed.obj baked.probe >with.tsv
probe-error -q --points 20 --paths 0 --truth-rays 16 --tsv sealed.obj inside.probe >without.tsv
# by light: weight of black probes beyond the wall brings none
leak() { awk -F '\t' '$1 == "leak_light" && $2 == "outside" { print $3 }' "$1"; }
{ leak with.tsv; leak without.tsv; } | paste -s -d ' ' - >leaks
check "probe-error measures it ($(cat leaks))" every 'NF == 2 && $1 < 1e-6 && $2 > 2e-3' leaks
for threads in 1 3; do
    probe-leakfix -q --points 0 --threads $threads sealed.obj cells.probe >threads$threads.probe
done
check "1 and 3 threads give the same bytes" cmp threads1.probe threads3.probe \
    and test -s threads1.probe

# A dark room between two others, whose probes stand in its middle alone: none of them is of the
# hull, whose faces go on from the one room to the other.
awk 'function box(ax, ay, az, bx, by, bz,  i) {
        for (i = 0; i < 8; i++)
            print "v", i % 2 ? bx : ax, int(i / 2) % 2 ? by : ay, int(i / 4) ? bz : az
    }
    BEGIN {
        print "mtllib sealed.mtl\nusemtl white"
        box(0, 0, 0, 9, 3, 3)
        print "f 1 3 7 5\nf 2 6 8 4\nf 1 5 6 2\nf 3 4 8 7\nf 1 2 4 3\nf 5 7 8 6"
        box(3, -.01, -.01, 3.1, 3.01, 3.01)
        box(6, -.01, -.01, 6.1, 3.01, 3.01)
        for (i = 8; i <= 16; i += 8)
            print "f", i + 5, i + 7, i + 3, i + 1 "\nf", i + 4, i + 8, i + 6, i + 2 "\nf", \
                i + 2, i + 6, i + 5, i + 1 "\nf", i + 7, i + 8, i + 4, i + 3 "\nf", \
                i + 3, i + 4, i + 2, i + 1 "\nf", i + 6, i + 8, i + 7, i + 5
    }' >three.obj
awk 'BEGIN {
    for (x = .2; x < 9; x += 1.2)
        for (y = .2; y < 3; y += 1.3)
            for (z = .2; z < 3; z += 1.3)
                if (x < 3 || x > 6.1) print x, y, z
    print "3.5 1.5 1.5\n4.5 1.5 1.5\n5.6 1.5 1.5\n4.5 .6 .6\n4.5 2.4 2.4"
}' >three.txt
awk 'BEGIN {
    for (x = 3.15; x < 5.96; x += .2)
        for (y = .02; y < 3; y += .0987)
            print x, y, .03 "\n" x, y, 2.97 "\n" x, .03, y "\n" x, 2.97, y
}' >dark.txt
echo "1.5 1 1" >lit.txt
probe-place points three.txt |
    probe-capture -q --rays 32 --bounces 4 --point 1,1.5,1.5,5,5,5 three.obj | probe-tet -q |
    probe-leakfix -q --points 0 three.obj >three.probe
count_lit three.probe
check "a room with probes in its middle alone is dark before its walls, too ($lit lit)" \
    [ "$lit" = 0 ]

# A closet in a lit room, with four probes. Its edges cut cells in which points on both sides see no
# corner by what is kept, some of them few; one probe stands in for all, and it is the right one for
# most.
awk 'function box(ax, ay, az, bx, by, bz, inward,  face, i, k) {
        split("1 5 7 3 2 4 8 6 1 2 6 5 3 7 8 4 1 3 4 2 5 6 8 7", face)
        for (i = 0; i < 8; i++)
            print "v", i % 2 ? bx : ax, int(i / 2) % 2 ? by : ay, int(i / 4) ? bz : az
        for (i = 0; i < 24; i += 4) {
            printf "f"
            for (k = 1; k <= 4; k++) printf " %d", face[i + (inward ? 5 - k : k)] - 9
            print ""
        }
    }
    BEGIN {
        print "mtllib sealed.mtl\nusemtl white"
        box(0, 0, 0, 6, 2.6, 5, 1)
        box(1.1, .4, 1.2, 2, 1.3, 2.28, 1)
        box(1.08, .38, 1.18, 2.02, 1.32, 2.3, 0)
    }' >closet.obj
awk 'BEGIN {
    for (i = 0; i < 15; i++)
        for (j = 0; j < 15; j++)
            for (k = 0; k < 15; k++)
                print 1.111 + i * .0627, .411 + j * .0627, 1.211 + k * .0755
}' >dark.txt
probe-place grid -q --count 500 closet.obj |
    probe-capture -q --rays 16 --bounces 2 --point 4,1.5,3,5,5,5 closet.obj | probe-tet -q |
    probe-leakfix -q --points 0 closet.obj >closet.probe
count_lit closet.probe
check "of 3375 points in a closet, most before its walls, not one in 20 is lit ($lit)" \
    [ "$lit" -lt 168 ]

# A path along the wall in the dark room: light changes there that is from beyond, and none that
# is seen.
awk 'BEGIN {
    for (i = 0; i <= 40; i++) print 2.1 + .2 * (i / 40 - .5) + .1, .5 + i / 40, 1.25
}' >path.txt
change() {
    probe-error -q --points 20 --path path.txt --truth-rays 16 --leak-samples 0 --tsv \
        --visible "$1" sealed.obj baked.probe | awk -F '\t' '/^change_most\tprobes/ { print $3 }'
}
{ change all; change kept; change rays; } | paste -s -d ' ' - >changes
check "change along a path is of the light that is asked for ($(cat changes))" \
    every 'NF == 3 && $1 > .1 && $2 < 1e-3 * $1 && $3 < 1e-3 * $1' changes

# Where nothing stands outside of the hull, nothing is kept of it.
sed '/^f 9 /d' sealed.obj >open.obj
probe-leakfix -q --points 0 open.obj cells.probe | probe-cat --text >open.text
check "in a room without a wall nothing is kept of the outside" says open.text 'sight:f32' \
    and lacks open.text 'sight_outside'
probe-capture --again -q open.obj baked.probe 2>said | probe-cat --text >again.text
check "and of other surfaces it is left out" lacks again.text 'sight_outside' \
    and says again.text '^table tet'

(ulimit -v 3000000 && probe-error -q --points 10000000 sealed.obj baked.probe) >out 2>said
check "more points than there is memory for are refused at once, with what they ask for" \
    says said 'out of memory: 8 GB for the truth at [0-9]* points'
tap_done
