#!/bin/sh
# probe-render as users run it.
. "${SRC:?}/tests/support/setup.sh"
scene=$SRC/scenes/two-rooms.obj
probe-place grid -q --count 60 "$scene" | probe-capture -q --rays 64 "$scene" | probe-tet >baked.probe
view="--size 48x32 --samples 4 --eye 0.4,1.5,0.4 --look-at 3,1,3 -q"

# render NAME OPTION...: a picture, to NAME
render() {
    name=$1
    shift
    # shellcheck disable=SC2086 # $view is a list of options
    probe-render $view -o "$name" "$@"
}

for mode in truth probes none split pair difference flip; do
    check "mode $mode" render $mode.png -m $mode "$scene" baked.probe
done
check "pictures are PNG of the size asked for" sh -c "head -c 24 truth.png | od -An -v -tu1 | tr -s ' \n' ' ' |
    grep -q '^ 137 80 78 71 13 10 26 10 0 0 0 13 73 72 68 82 0 0 0 48 0 0 0 32'"
check "modes are different pictures" sh -c "cksum truth.png probes.png none.png split.png pair.png difference.png flip.png | cut -d' ' -f1 | sort -u | wc -l | grep -qx 7"
check "the light is the scene's own: a stream by pipe or file" sh -c "probe-render $view -o pipe.png '$scene' <baked.probe && cmp pipe.png probes.png"
check "- is standard output" sh -c "probe-render $view -o - '$scene' baked.probe | cmp - probes.png"
check "the truth needs no stream" sh -c "probe-render $view -m truth -o alone.png '$scene' </dev/null && cmp alone.png truth.png"
for threads in 1 2; do render "t$threads.png" -m truth --error .2 --threads $threads "$scene" baked.probe; done
check "1 and 2 threads give the same bytes" cmp t1.png t2.png
render seed.png -m truth --seed 1 "$scene" baked.probe
check "another seed gives another picture" sh -c "! cmp -s seed.png truth.png"

# PFM
render truth.pfm -m truth "$scene" baked.probe
check "PFM by its name: 12 bytes a pixel behind the header" sh -c "head -n 2 truth.pfm | tr '\n' ' ' | grep -q '^PF 48 32 ' && [ \$(wc -c <truth.pfm) -eq \$((48 * 32 * 12 + 14)) ]"
render both.png -m truth --pfm both.pfm "$scene" baked.probe
check "or besides a PNG" cmp both.pfm truth.pfm
render probes.pfm -m probes "$scene" baked.probe

# Figures
render figures.png -m difference "$scene" baked.probe >figures.txt
check "figures are printed, a name and a number a line" sh -c "cut -d' ' -f1 figures.txt | tr '\n' ' ' | grep -qx 'mean bias rmse relative-rmse truth-noise flip exposure ' &&
    ! awk 'NF != 2 || \$2 + 0 != \$2' figures.txt | grep ."
probe-render --compare truth.pfm probes.pfm >compared.txt
grep -v truth-noise figures.txt >expected.txt
check "two PFM compared give the same" cmp compared.txt expected.txt
render given.png -m difference --truth truth.pfm "$scene" baked.probe >given.txt
check "and so does a truth that is given, and the same picture" sh -c "cmp given.txt expected.txt && cmp given.png figures.png"
probe-render --compare truth.pfm truth.pfm >same.txt
check "a picture and itself: 0" sh -c "grep -qx 'rmse 0' same.txt && grep -qx 'flip 0' same.txt && grep -qx 'bias 0' same.txt"
check "compared, and the difference written" sh -c "probe-render --compare -o c.png truth.pfm probes.pfm >c.txt && cmp c.png figures.png && cmp c.txt compared.txt"
check "PNG can be compared" sh -c "probe-render --compare truth.png probes.png | grep -q '^flip 0\\.'"
check "standard output is for the picture where it goes there" sh -c "probe-render $view -m flip -o - '$scene' baked.probe 2>said | cmp - flip.png && grep -q '^flip ' said"

# Indirect and direct light
probe-place grid -q --count 60 "$scene" | probe-capture -q --light indirect --rays 64 "$scene" | probe-tet >indirect.probe
check "mixed: direct light and probes of indirect" render mixed.pfm -m mixed "$scene" indirect.probe
render indirect.pfm -m probes "$scene" indirect.probe
check "which is more than either" sh -c "probe-render --compare mixed.pfm indirect.pfm | awk '\$1 == \"bias\" { exit !(\$2 < -0.05) }'"
render m.png -m pair "$scene" indirect.probe >mixed.txt
probe-render --compare truth.pfm mixed.pfm >by-hand.txt
check "and what the truth is held against" sh -c "grep -v truth-noise mixed.txt | cmp - by-hand.txt"
refused 1 "the probes hold direct light already" render x.png -m mixed "$scene" baked.probe

probe-capture -q --again --light direct --rays 64 "$scene" baked.probe >direct.probe
render none.pfm -m none "$scene" direct.probe
render direct.pfm -m probes "$scene" direct.probe
render d.png -m pair "$scene" direct.probe >direct.txt
probe-render --compare none.pfm direct.pfm >by-hand.txt
check "probes of direct light are held against direct light" sh -c "grep -v truth-noise direct.txt | cmp - by-hand.txt"
probe-cat --content irradiance baked.probe >convolved.probe
render convolved.pfm -m probes "$scene" convolved.probe
check "irradiance in the stream makes the same picture as radiance" sh -c "probe-render --compare probes.pfm convolved.pfm | awk '\$1 == \"relative-rmse\" { exit !(\$2 < 1e-6) }'"

# Overlays
render drawn.png --draw-probes auto --draw-cells "$scene" baked.probe
check "probes and cells are drawn" sh -c "! cmp -s drawn.png probes.png"
check "probes that are not captured, too" sh -c "probe-place grid -q --count 60 '$scene' | probe-render $view -m none --draw-probes 0.05 -o placed.png '$scene' - && ! cmp -s placed.png none.png"
refused 1 "run probe-tet" sh -c "probe-place grid -q --count 60 '$scene' | probe-render $view -m none --draw-cells -o x.png '$scene' -"

# Ways to interpolate, probes in a plane
render nearest.png --interpolate nearest "$scene" baked.probe
check "another way to interpolate is another picture" sh -c "! cmp -s nearest.png probes.png"
probe-cat --tables probe baked.probe >alone.probe
check "and nearest needs no cells" sh -c "probe-render $view --interpolate nearest --offset 0.2 -o a.png '$scene' alone.probe && probe-render $view --interpolate nearest --offset 0.2 -o b.png '$scene' baked.probe && cmp a.png b.png"
check "outside of the hull, another picture" sh -c "probe-render $view --outside extend -o outside.png '$scene' baked.probe && ! cmp -s outside.png probes.png"
refused 2 "need --interpolate shepard" render x.png --radius 1 "$scene" baked.probe
refused 1 "--columns sh_gradient" render x.png --interpolate cubic "$scene" baked.probe
awk 'BEGIN { for (x = 0.5; x < 5; x++) for (z = 0.5; z < 4; z++) print x, 1.5, z }' >plane.txt
probe-place points plane.txt | probe-capture -q --rays 16 "$scene" | probe-tet -q >plane.probe
check "probes in a plane, with their triangles" render plane.png --draw-cells --draw-probes auto "$scene" plane.probe

# An object's way
printf '# a way\n1 1 1\n\n2 1 2\n3 1 3\n' >path.txt
check "frames side by side" sh -c "probe-render $view --path path.txt --object-radius .3 -o sheet.png '$scene' baked.probe && head -c 24 sheet.png | od -An -v -tu1 | tr -s ' \n' ' ' | grep -q ' 0 0 0 96 0 0 0 64'"
check "or numbered" sh -c "probe-render $view --path path.txt --object-radius .3 -o frame-%02d.png --pfm frame-%d.pfm '$scene' baked.probe && ls frame-00.png frame-01.png frame-02.png frame-0.pfm frame-1.pfm frame-2.pfm && ! cmp -s frame-00.png frame-01.png"
check "a mesh moves as well, and in the truth" sh -c "probe-render $view -m pair --path path.txt --object '$SRC/scenes/cornell-box.obj' --object-radius .3 -o mesh.png '$scene' baked.probe | grep -c '^[012] flip' | grep -qx 3"
check "its light is one lookup, or one a pixel" sh -c "probe-render $view --path path.txt --object-radius .3 --per-pixel -o pixel.png '$scene' baked.probe && ! cmp -s pixel.png sheet.png"
printf '1 1 1\n1 x 1\n' >bad.txt
refused 1 "bad.txt:2: expected a number, got 'x'" render x.png --path bad.txt "$scene" baked.probe
printf '1 1 1\n1e9 0 0\n' >far.txt
refused 1 "far.txt:2: the point is farther out than 1e6 times" render x.png --path far.txt "$scene" baked.probe
: >empty.txt
refused 1 "empty.txt: there is no point" render x.png --path empty.txt "$scene" baked.probe
refused 1 "no-such.txt" render x.png --path no-such.txt "$scene" baked.probe
refused 1 "no-such.obj" render x.png --path path.txt --object no-such.obj "$scene" baked.probe
refused 2 "expected one %d" render 'x%s.png' --path path.txt "$scene" baked.probe
refused 2 "in both --output and --pfm, or in none" render 'x%d.png' --pfm y.pfm --path path.txt "$scene" baked.probe
refused 2 "need --path" render x.png --object sphere "$scene" baked.probe

# Its own view
probe-render --size 48x32 --samples 1 -o auto.png "$scene" baked.probe 2>said
said=$(grep -o -- '--eye .*' said)
# shellcheck disable=SC2086
check "a view is chosen, and said as options" sh -c "[ -n '$said' ] && probe-render -q --size 48x32 --samples 1 $said -o said.png '$scene' baked.probe"

# What cannot be
probe-place grid -q --count 60 "$scene" | probe-tet >dark.probe
refused 1 "dark.probe: the probes have no light (no column sh): run probe-capture" render x.png "$scene" dark.probe
probe-place grid -q --count 60 "$scene" | probe-capture -q --rays 16 "$scene" >loose.probe
refused 1 "loose.probe: there are no cells: run probe-tet" render x.png "$scene" loose.probe
probe-tet --enclose baked.probe >corners.probe
refused 1 "has no light: run probe-capture" render x.png "$scene" corners.probe
refused 2 "expected --look-at other than --eye" render x.png --eye 1,1,1 --look-at 1,1,1 "$scene" baked.probe
refused 2 "expected --up across the view" render x.png --up 1,0,0 --eye 0,1,1 --look-at 1,1,1 "$scene" baked.probe
refused 1 "the eye is farther out" render x.png --eye 1e30,1,1 --look-at 1,1,1 "$scene" baked.probe
for size in 0x10 10x0 10 10x10x10 x -5x5 99999x10; do refused 2 "expected WIDTHxHEIGHT" render x.png --size $size "$scene" baked.probe; done
refused 2 "--fov" render x.png --fov 180 "$scene" baked.probe
refused 2 "--fov" render x.png --fov 0 "$scene" baked.probe
refused 2 "--look-at needs --eye" probe-render -o x.png --look-at 1,1,1 "$scene" baked.probe
refused 2 "expected --output FILE or --pfm FILE" probe-render "$scene" baked.probe
refused 2 "--compare needs two pictures" probe-render --compare truth.pfm
refused 2 "expected a number above 0, or auto" render x.png --exposure 0 "$scene" baked.probe
refused 2 "--truth is for" render x.png -m truth --truth truth.pfm "$scene" baked.probe
refused 1 "differ in size" sh -c "probe-render $view --size 20x20 -m flip --truth truth.pfm -o x.png '$scene' baked.probe"
refused 1 "differ in size" probe-render --compare truth.pfm pair.png
refused 1 "no-such.pfm" probe-render --compare truth.pfm no-such.pfm
refused 1 "No such file or directory" render no/such/x.png -m truth --samples 1000000 "$scene" baked.probe
refused 1 "No space left" sh -c "probe-render $view -o - '$scene' baked.probe >/dev/full"
refused 1 "No space left" sh -c "probe-render --compare truth.pfm probes.pfm >/dev/full"
if [ "$(id -u)" -eq 0 ]; then skip "root may write everywhere"; else
    mkdir closed && chmod 500 closed
    refused 1 "Permission denied" render closed/x.png "$scene" baked.probe
fi
check "what was refused left no picture" sh -c "! ls x*.png"
check "probes of another scene are warned about" sh -c "probe-render --size 8x8 --samples 1 -o w.png '$SRC/scenes/cornell-box.obj' baked.probe 2>&1 | grep -q 'captured in another scene'"
check "a closed pipe ends it" sh -c "(probe-render $view --size 400x400 -o - '$scene' baked.probe; echo \$? >status) | true; [ \$(cat status) -ne 0 ]"
tap_done
