#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-render as users run it.
. "${SRC:?}/tests/support/setup.sh"
scene=$SRC/scenes/two-rooms.obj
view="--size 48x32 --samples 4 --eye 0.4,1.5,0.4 --look-at 3,1,3 -q"

# placed, captured OPTION..., and with cells
placed() { probe-place grid -q --count 60 "$scene"; }
captured() { placed | probe-capture -q "$@" "$scene"; }
baked() { captured "$@" | probe-tet; }

# render NAME OPTION...: a picture, to NAME
render() {
    name=$1
    shift
    # shellcheck disable=SC2086 # $view is a list of options
    probe-render $view -o "$name" "$@"
}
# begins FILE NUMBERS...: its first 24 bytes hold these, in decimal
begins() {
    head -c 24 "$1" | od -An -v -w24 -tu1 | tr -s ' ' >begins.out
    shift
    says begins.out "$*"
}
# figure NAME CONDITION A B: of two pictures compared; awk's condition holds for it
figure() {
    probe-render --compare "$3" "$4" | grep "^$1 " >figure.out
    every "$2" figure.out
}
# same_figures FILE A B: what was printed is what two pictures compared give
same_figures() {
    grep -v truth-noise "$1" >same_figures.printed
    probe-render --compare "$2" "$3" >same_figures.compared
    test -s same_figures.printed && cmp same_figures.printed same_figures.compared
}

baked --rays 64 >baked.probe
modes="truth probes none split pair difference flip"
for mode in $modes; do
    check "mode $mode" render "$mode.png" -m "$mode" "$scene" baked.probe
done
check "pictures are PNG of the size asked for" \
    begins truth.png '^ 137 80 78 71 13 10 26 10 0 0 0 13 73 72 68 82 0 0 0 48 0 0 0 32$'
for mode in $modes; do cksum <$mode.png; done | sort -u >sums
check "modes are different pictures" has_lines 7 sums
render pipe.png "$scene" <baked.probe
check "the light is the scene's own: a stream by pipe or file" cmp pipe.png probes.png
render - "$scene" baked.probe >stdout.png
check "- is standard output" cmp stdout.png probes.png
render alone.png -m truth "$scene" </dev/null
check "the truth needs no stream" cmp alone.png truth.png
for threads in 1 2; do
    render threads$threads.png -m truth --error .2 --threads $threads "$scene" baked.probe
done
check "1 and 2 threads give the same bytes" cmp threads1.png threads2.png
render seed.png -m truth --seed 1 "$scene" baked.probe
check "another seed gives another picture" differ seed.png truth.png

# What is lit through the wall by all probes of a cell is not by those that a point sees.
probe-leakfix -q "$scene" baked.probe >seen.probe
for visible in kept all rays; do
    probe-render -q --size 48x32 --samples 4 --eye 6.5,1.5,2.2 --look-at 4,1.2,.8 \
        --visible $visible --pfm $visible.pfm "$scene" seen.probe
done
probe-render --compare rays.pfm kept.pfm | sed -n 's/^rmse //p' >kept.rmse
probe-render --compare rays.pfm all.pfm | sed -n 's/^rmse //p' >all.rmse
paste kept.rmse all.rmse >rmse
check "--visible: what was kept is near what rays say, all probes are not" \
    every 'NF == 2 && $1 < 0.3 * $2' rmse
refused 2 "expected one of" render x.png --visible none "$scene" seen.probe

# -- PFM -------------------------------------------------------------------------------------------
render truth.pfm -m truth "$scene" baked.probe
head -n 2 truth.pfm | paste -s -d ' ' - >head
check "PFM by its name: 12 bytes a pixel behind the header" \
    says head '^PF 48 32$' and [ "$(wc -c <truth.pfm)" -eq $((48 * 32 * 12 + 14)) ]
render both.png -m truth --pfm both.pfm "$scene" baked.probe
check "or besides a PNG" cmp both.pfm truth.pfm
render probes.pfm -m probes "$scene" baked.probe

# -- figures ---------------------------------------------------------------------------------------
render figures.png -m difference "$scene" baked.probe >figures.txt
names="mean bias rmse relative-rmse truth-noise flip exposure"
check "figures are printed, a name and a number a line" \
    [ "$(cut -d ' ' -f 1 figures.txt | paste -s -d ' ' -)" = "$names" ] \
    and every 'NF == 2 && $2 + 0 == $2' figures.txt
probe-render --compare truth.pfm probes.pfm >compared.txt
grep -v truth-noise figures.txt >expected.txt
check "two PFM compared give the same" cmp compared.txt expected.txt
render given.png -m difference --truth truth.pfm "$scene" baked.probe >given.txt
check "and so does a truth that is given, and the same picture" \
    cmp given.txt expected.txt and cmp given.png figures.png
probe-render --compare truth.pfm truth.pfm >same.txt
check "a picture and itself: 0" says same.txt '^rmse 0$' '^flip 0$' '^bias 0$'
check "compared, and the difference written" \
    into difference.txt probe-render --compare -o compared.png truth.pfm probes.pfm \
    and cmp compared.png figures.png and cmp difference.txt compared.txt
probe-render --compare truth.png probes.png >compared.txt
check "PNG can be compared" says compared.txt '^flip 0\.'
render - -m flip "$scene" baked.probe >stdout.png 2>said
check "standard output is for the picture where it goes there" \
    cmp stdout.png flip.png and says said '^flip '

# -- indirect and direct light ---------------------------------------------------------------------
baked --light indirect --rays 64 >indirect.probe
check "mixed: direct light and probes of indirect" \
    render mixed.pfm -m mixed "$scene" indirect.probe
render indirect.pfm -m probes "$scene" indirect.probe
check "which is more than either" figure bias '$2 < -0.05' mixed.pfm indirect.pfm
render mixed.png -m pair "$scene" indirect.probe >mixed.txt
check "and what the truth is held against" same_figures mixed.txt truth.pfm mixed.pfm
refused 1 "the probes hold direct light already" render x.png -m mixed "$scene" baked.probe

probe-capture -q --again --light direct --rays 64 "$scene" baked.probe >direct.probe
render none.pfm -m none "$scene" direct.probe
render direct.pfm -m probes "$scene" direct.probe
render direct.png -m pair "$scene" direct.probe >direct.txt
check "probes of direct light are held against direct light" \
    same_figures direct.txt none.pfm direct.pfm
probe-cat --content irradiance baked.probe >convolved.probe
render convolved.pfm -m probes "$scene" convolved.probe
check "irradiance in the stream makes the same picture as radiance" \
    figure relative-rmse '$2 < 1e-6' probes.pfm convolved.pfm

# -- overlays --------------------------------------------------------------------------------------
render drawn.png --draw-probes auto --draw-cells "$scene" baked.probe
check "probes and cells are drawn" differ drawn.png probes.png
placed >placed.probe
render placed.png -m none --draw-probes 0.05 "$scene" - <placed.probe
check "probes that are not captured, too" differ placed.png none.png
refused 1 "run probe-tet" render x.png -m none --draw-cells "$scene" - <placed.probe

# -- ways to interpolate, probes in a plane --------------------------------------------------------
render nearest.png --interpolate nearest "$scene" baked.probe
check "another way to interpolate is another picture" differ nearest.png probes.png
probe-cat --tables probe baked.probe >alone.probe
nearest="--interpolate nearest --offset 0.2"
check "and nearest needs no cells" render alone.png $nearest "$scene" alone.probe \
    and render cells.png $nearest "$scene" baked.probe and cmp alone.png cells.png
check "outside of the hull, another picture" \
    render outside.png --outside extend "$scene" baked.probe and differ outside.png probes.png
refused 2 "need --interpolate shepard" render x.png --radius 1 "$scene" baked.probe
refused 1 "--columns sh_gradient" render x.png --interpolate cubic "$scene" baked.probe
awk 'BEGIN { for (x = 0.5; x < 5; x++) for (z = 0.5; z < 4; z++) print x, 1.5, z }' >plane.txt
probe-place points plane.txt | probe-capture -q --rays 16 "$scene" | probe-tet -q >plane.probe
check "probes in a plane, with their triangles" \
    render plane.png --draw-cells --draw-probes auto "$scene" plane.probe

# -- an object's way -------------------------------------------------------------------------------
printf '%s\n' '# a way' '1 1 1' '' '2 1 2' '3 1 3' >path.txt
way="--path path.txt --object-radius .3"
check "frames side by side" \
    render sheet.png $way "$scene" baked.probe and begins sheet.png ' 0 0 0 96 0 0 0 64$'
check "or numbered" render frame-%02d.png $way --pfm frame-%d.pfm "$scene" baked.probe \
    and ls frame-00.png frame-01.png frame-02.png frame-0.pfm frame-1.pfm frame-2.pfm \
    and differ frame-00.png frame-01.png
render mesh.png -m pair $way --object "$SRC/scenes/cornell-box.obj" "$scene" baked.probe >mesh.txt
check "a mesh moves as well, and in the truth" [ "$(grep -c '^[012] flip' mesh.txt)" -eq 3 ]
check "its light is one lookup, or one a pixel" \
    render pixel.png $way --per-pixel "$scene" baked.probe and differ pixel.png sheet.png
printf '%s\n' '1 1 1' '1 x 1' >bad.txt
refused 1 "bad.txt:2: expected a number, got 'x'" \
    render x.png --path bad.txt "$scene" baked.probe
printf '%s\n' '1 1 1' '1e9 0 0' >far.txt
refused 1 "far.txt:2: the point is farther out than 1e6 times" \
    render x.png --path far.txt "$scene" baked.probe
: >empty.txt
refused 1 "empty.txt: expected at least one position" \
    render x.png --path empty.txt "$scene" baked.probe
refused 1 "no-such.txt" render x.png --path no-such.txt "$scene" baked.probe
refused 1 "no-such.obj" render x.png --path path.txt --object no-such.obj "$scene" baked.probe
refused 2 "expected one %d" render 'x%s.png' --path path.txt "$scene" baked.probe
refused 2 "in both --output and --pfm, or in none" \
    render 'x%d.png' --pfm y.pfm --path path.txt "$scene" baked.probe
refused 2 "need --path" render x.png --object sphere "$scene" baked.probe

# -- its own view ----------------------------------------------------------------------------------
probe-render --size 48x32 --samples 1 -o auto.png "$scene" baked.probe 2>said
said=$(grep -o -- '--eye .*' said)
# shellcheck disable=SC2086 # a list of options
check "a view is chosen, and said as options" [ -n "$said" ] \
    and probe-render -q --size 48x32 --samples 1 $said -o said.png "$scene" baked.probe

# -- what cannot be --------------------------------------------------------------------------------
probe-tet <placed.probe >dark.probe
refused 1 "dark.probe: the probes have no light (no column sh): run probe-capture" \
    render x.png "$scene" dark.probe
captured --rays 16 >loose.probe
refused 1 "loose.probe: there are no cells: run probe-tet" render x.png "$scene" loose.probe
probe-tet --enclose baked.probe >corners.probe
refused 1 "has no light: run probe-capture" render x.png "$scene" corners.probe
refused 2 "expected --look-at other than --eye" \
    render x.png --eye 1,1,1 --look-at 1,1,1 "$scene" baked.probe
refused 2 "expected --up across the view" \
    render x.png --up 1,0,0 --eye 0,1,1 --look-at 1,1,1 "$scene" baked.probe
refused 1 "the eye is farther out" \
    render x.png --eye 1e30,1,1 --look-at 1,1,1 "$scene" baked.probe
for size in 0x10 10x0 10 10x10x10 x -5x5 99999x10; do
    refused 2 "expected WIDTHxHEIGHT" render x.png --size $size "$scene" baked.probe
done
refused 2 "--fov" render x.png --fov 180 "$scene" baked.probe
refused 2 "--fov" render x.png --fov 0 "$scene" baked.probe
refused 2 "--look-at needs --eye" \
    probe-render -o x.png --look-at 1,1,1 "$scene" baked.probe
refused 2 "expected --output FILE or --pfm FILE" probe-render "$scene" baked.probe
refused 2 "--compare needs two pictures" probe-render --compare truth.pfm
refused 2 "expected a number above 0, or auto" \
    render x.png --exposure 0 "$scene" baked.probe
refused 2 "--truth is for" render x.png -m truth --truth truth.pfm "$scene" baked.probe
refused 1 "differ in size" \
    render x.png --size 20x20 -m flip --truth truth.pfm "$scene" baked.probe
refused 1 "differ in size" probe-render --compare truth.pfm pair.png
refused 1 "no-such.pfm" probe-render --compare truth.pfm no-such.pfm
refused 1 "No such file or directory" \
    render no/such/x.png -m truth --samples 1000000 "$scene" baked.probe
refused 1 "No space left" into /dev/full render - "$scene" baked.probe
refused 1 "No space left" into /dev/full probe-render --compare truth.pfm probes.pfm
if [ "$(id -u)" -eq 0 ]; then
    skip "root may write everywhere"
else
    mkdir closed
    chmod 500 closed
    refused 1 "Permission denied" render closed/x.png "$scene" baked.probe
fi
check "what was refused left no picture" not ls x*.png
probe-render --size 8x8 --samples 1 -o other.png "$SRC/scenes/cornell-box.obj" baked.probe 2>said
check "probes of another scene are warned about" says said 'captured in another scene'
{ render - --size 400x400 "$scene" baked.probe; echo $? >status; } | true
check "a closed pipe ends it" [ "$(cat status)" -ne 0 ]
tap_done
