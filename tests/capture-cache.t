#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# probe-capture --cache: light through the cache against closed forms; what it is made of and when
# it is off; the stream of a cache, and what is no cache.
. "${SRC:?}/tests/support/setup.sh"

# box MATERIAL...: a box of side 2 about the origin, open to all sides of its own, in faces of one
# material each: -x +x -y +y -z +z; "none" leaves one out.
box() {
    printf 'mtllib m.mtl\n'
    for z in -1 1; do for y in -1 1; do for x in -1 1; do echo "v $x $y $z"; done; done; done
    for face in '1 3 7 5' '2 6 8 4' '1 5 6 2' '3 4 8 7' '1 2 4 3' '5 7 8 6'; do
        [ "$1" = none ] || printf 'usemtl %s\nf %s\n' "$1" "$face"
        shift
    done
}
cat >m.mtl <<'END'
newmtl glow
Kd .6 .6 .6
Ke 1 2 3
newmtl grey
Kd .5 .5 .5
newmtl white
Kd .8 .8 .8
newmtl black
Kd 0 0 0
END
box glow glow glow glow glow glow >furnace.obj
box white white white none white white >court.obj
# 64 probes in the box
awk 'BEGIN { for (i = 0; i < 64; i++)
    print (i % 4 - 1.5) * .45, (int(i / 4) % 4 - 1.5) * .45, (int(i / 16) - 1.5) * .45 }' >in.txt
probe-place points -q in.txt furnace.obj >in.probe

# -- closed forms ----------------------------------------------------------------------------------
# In a furnace radiance is L = Le / (1 - albedo) everywhere: 2.5, 5, 7.5, times sqrt(4 pi) in SH.
probe-capture --rays 512 --cache auto --cache-out furnace.cache --text furnace.obj in.probe \
    >furnace.probe 2>said
check "a furnace's light comes through the cache" says said 'cache: .* points of .* rays change' \
    and every 'NF == 0 || ($4 / 8.8623 > .97 && $4 / 8.8623 < 1.03 &&
        $6 / 26.587 > .97 && $6 / 26.587 < 1.03)' "$(rows_of position,sh furnace.probe >f.rows
    echo f.rows)"
# Le (1 + .6 + .6^2 + .6^3 + .6^4) where light scatters four times
probe-capture --rays 512 --bounces 4 --cache auto --cache-after 2 --cache-error 20% furnace.obj \
    in.probe >four.probe 2>said
check "no light scatters oftener than --bounces" says said 'cache: .* points of .* rays change' \
    and awk '{ n++; s += $4 / 8.1733 } END { exit !(n == 64 && s / n > .98 && s / n < 1.02) }' \
    "$(rows_of position,sh four.probe >four.rows; echo four.rows)"
# The irradiance of what scattered at least once is pi albedo L, at each point of the cache
rows_of position,irradiance furnace.cache >e.rows
check "the cache holds the irradiance of what scattered: pi albedo L" test -s e.rows and \
    awk '{ n++; s += $4 / (3.14159265 * 1.5); q += ($4 / (3.14159265 * 1.5)) ^ 2 }
        END { m = s / n; e = sqrt((q / n - m * m) / n); z = (m - 1) / (e + 1e-4)
            exit !(n > 50 && z < 4 && z > -4 && e < .01) }' e.rows

# Over a square of half side 8, lit by a sun, at height 1: radiance albedo E / pi in the solid angle
# 4 asin(64 / 65), and nothing else. The sunlit points bring most of it.
cat >ground.obj <<'END'
mtllib m.mtl
v -8 0 -8
v -8 0 8
v 8 0 8
v 8 0 -8
usemtl grey
f 1 2 3 4
END
awk 'BEGIN { for (i = 0; i < 32; i++) printf "0 %.6f 0\n", 1 + i * 1e-6 }' >over.txt
probe-place points -q over.txt ground.obj |
    probe-capture --rays 1024 --sun 0,-1,0,2,2,2 --light indirect --cache auto --text ground.obj \
    >ground.probe 2>said
check "sunlit ground, by its points and by rays" says said '-capture: cache: ' and \
    awk '/^[0-9-]/ { n++; s += $4; q += $4 * $4 }
        END { m = s / n; e = sqrt((q / n - m * m) / n)
            t = .282094792 * (1 / 3.14159265) * 4 * atan2(64, sqrt(65 * 65 - 64 * 64))
            z = (m - t) / e; exit !(n == 32 && z < 4 && z > -4 && e / t < .01) }' ground.probe
# So it is beside a sun that is a million times as bright and lights the side which no probe sees.
probe-place points -q over.txt ground.obj |
    probe-capture --rays 1024 --sun 0,-1,0,2,2,2 --sun 0,1,0,2e6,2e6,2e6 --light indirect \
    --cache auto --text ground.obj >dim.probe 2>said
check "ground in the light of a sun that is dim beside another" says said '-capture: cache: ' and \
    awk '/^[0-9-]/ { n++; s += $4; q += $4 * $4 }
        END { m = s / n; e = sqrt((q / n - m * m) / n)
            t = .282094792 * (1 / 3.14159265) * 4 * atan2(64, sqrt(65 * 65 - 64 * 64))
            z = (m - t) / e; exit !(n == 32 && z < 4 && z > -4 && e / t < .01) }' dim.probe

# Where most of what probes see is sunlit, rays find it better than the points do.
awk 'BEGIN { for (i = 0; i < 64; i++) print (i % 8 - 3.5) * 1.7, 2, (int(i / 8) - 3.5) * 1.7 }' \
    >open.txt
cat >open.obj <<'END'
mtllib m.mtl
v -8 0 -8
v -8 0 8
v 8 0 8
v 8 0 -8
v -2 0 -2
v -2 3 -2
v -2 3 2
v -2 0 2
usemtl grey
f 1 2 3 4
f 5 6 7 8
f 8 7 6 5
END
probe-place points -q open.txt open.obj >open.probe
open_air() { probe-capture --rays 512 --sun .3,-1,.2,5,5,5 "$@" open.obj open.probe; }
noise_of() {
    rows_of position,sh,sh_error "$1" | awk '{ n++; s += ($31 / $4) ^ 2 } END { print n, s }'
}
open_air -q >open.plain
open_air --cache auto >open.cached 2>said
check "sunlit points stay off where they bring noise" says said 'cache: .* points of' and \
    awk '{ n[NR] = $1; s[NR] = $2 } END { exit !(n[1] == 64 && n[2] == 64 && s[2] < 1.1 * s[1]) }' \
    "$({ noise_of open.plain; noise_of open.cached; } >noise.rows; echo noise.rows)"

# A court under sun and sky: with and without a cache the same, within the errors.
court() {
    probe-capture -q --rays 1024 --sky 1,1,1 --sun .3,-1,.2,5,5,5 --text "$@" court.obj in.probe
}
court >court.plain
court --cache auto >court.cached
rows_of position,sh,sh_error court.plain >p.rows
rows_of position,sh,sh_error court.cached >c.rows
check "in a court sun and sky are what they are without a cache" test -s c.rows and \
    sh -c 'paste -d " " p.rows c.rows | awk "{ for (i = 4; i <= 30; i++) {
        d = \$(i + 57) - \$i; v = \$(i + 27) ^ 2 + \$(i + 84) ^ 2; n++; q += d * d / v
        if (i <= 6) { m += d; b += \$i } } }
        END { exit !(n == 1728 && sqrt(q / n) < 1.35 && m / b < .01 && m / b > -.01) }"'

# A black box with a hole of side .2 in its ceiling, under a sky of radiance 1: the solid angle of
# the hole. 512 rays alone are 30 % off; the openings that are looked for bring that down.
{
    box black black black none black black
    for x in -1 -.1 .1 1; do for z in -1 -.1 .1 1; do echo "v $x 1 $z"; done; done
    printf 'usemtl black\nf 9 13 16 12\nf 17 21 24 20\nf 13 17 18 14\nf 15 19 20 16\n'
} >hole.obj
hole() { probe-capture --rays 512 --sky 1,1,1 --text "$@" hole.obj in.probe; }
hole -q >hole.plain
hole --cache auto >hole.cached 2>said
for way in plain cached; do # mean share of it, its error, mean error of a probe
    rows_of position,sh hole.$way | awk '
        function f(x, z, h) { return atan2(x * z, h * sqrt(x * x + z * z + h * h)) }
        { x = $1 + .1; X = $1 - .1; z = $3 + .1; Z = $3 - .1; h = 1 - $2
            t = .282094792 * (f(x, z, h) - f(X, z, h) - f(x, Z, h) + f(X, Z, h))
            r = $4 / t; s += r; q += r * r; e += r > 1 ? r - 1 : 1 - r; n++ }
        END { m = s / n; print n, m, sqrt((q / n - m * m) / n), e / n }'
done >hole.rows
check "the sky through a hole ($(tr '\n' ';' <hole.rows))" says said '-capture: cache: ' and awk '
    { n[NR] = $1; m[NR] = $2; s[NR] = $3; e[NR] = $4 }
    END { z = (m[2] - 1) / s[2]
        exit !(n[1] == 64 && n[2] == 64 && z < 4 && z > -4 && e[2] < .1 && e[2] < e[1] / 4) }' \
    hole.rows

# Two rooms with one floor and one ceiling, a sheet between them and a lamp in one: the other, which
# is sealed, stays black, though discs of the same plane are on both sides of the sheet.
cat >rooms.obj <<'END'
mtllib m.mtl
v -1 -1 -1
v -1 -1 1
v -1 1 -1
v -1 1 1
v 3 -1 -1
v 3 -1 1
v 3 1 -1
v 3 1 1
v 1 -1 -1
v 1 -1 1
v 1 1 -1
v 1 1 1
v -.5 .9 -.5
v -.5 .9 .5
v .5 .9 .5
v .5 .9 -.5
usemtl grey
f 1 2 6 5
f 3 7 8 4
f 1 5 7 3
f 2 4 8 6
f 1 3 4 2
f 5 6 8 7
f 9 11 12 10
usemtl glow
f 13 14 15 16
END
awk 'BEGIN { for (i = 0; i < 64; i++)
    print (i % 8) * .45 - .7, (int(i / 8) % 4 - 1.5) * .45, int(i / 32) - .5 }' >rooms.txt
probe-place points -q rooms.txt rooms.obj |
    probe-capture --rays 4096 --bounces 8 --cache auto --text rooms.obj >rooms.probe 2>said
check "no light comes through a sheet along a floor" says said '-capture: cache: ' and \
    awk '/^[0-9-]/ { if ($1 < 1) { lit += $4; n++ } else if ($4 > most) most = $4; k++ }
        END { exit !(k == 64 && n && lit / n > .1 && most < 1e-3 * lit / n) }' rooms.probe

# The lamp is seen through the cache alone at most bounces: light of two seeds differs by what their
# caches do, which sh_error knows of (1.9 standard errors without).
for seed in 1 2; do
    probe-place points -q rooms.txt rooms.obj |
        probe-capture -q --rays 16384 --bounces 8 --seed $seed --cache auto rooms.obj |
        rows_of position,sh,sh_error - | awk '$1 < 1' >seed$seed.rows
done
paste -d ' ' seed1.rows seed2.rows | awk '{
    for (i = 4; i <= 30; i++) {
        n++
        q += ($(i + 57) - $i) ^ 2 / ($(i + 27) ^ 2 + $(i + 84) ^ 2)
    } } END { print n, sqrt(q / n) }' >z
check "sh_error has the noise of the cache in it ($(cat z))" \
    every '$1 == 864 && $2 > .5 && $2 < 1.4' z

# rows_are COLUMN STREAM FILE: its rows are those of the file
rows_are() {
    rows_of position,"$1" "$2" >rows_are.rows
    cmp rows_are.rows "$3"
}

# -- one cache for all -----------------------------------------------------------------------------
auto() { court --cache auto "$@"; }
auto -j1 >one.probe
auto -j3 >three.probe
check "any number of threads" cmp one.probe three.probe and test -s one.probe
probe-cat --rows 32: in.probe >tail.probe
probe-cat --rows :32 in.probe >head.probe
probe-cat --no-provenance tail.probe head.probe >turned.probe
probe-capture -q --rays 1024 --sky 1,1,1 --sun .3,-1,.2,5,5,5 --cache auto court.obj turned.probe \
    >turned.out
rows_of position,sh turned.out | sort >turned.rows
rows_of position,sh one.probe | sort >one.rows
probe-cat --rows 1: in.probe >rest.probe
probe-cat --rows :1 in.probe | probe-cat --no-provenance rest.probe - >shifted.probe
for order in in shifted; do
    probe-capture --rays 1024 --sky 1,1,1 --sun .3,-1,.2,5,5,5 --cache auto court.obj \
        $order.probe 2>&1 >shifted.out | grep 'cache: ' >$order.said
done
check "what it changes, too, in any order" cmp in.said shifted.said and test -s in.said
check "any order of the probes" cmp turned.rows one.rows and test -s one.rows
for i in 1 2; do auto --slice $i/2 >slice$i.probe; done
probe-cat --fill slice2.probe slice1.probe >filled.probe
rows_of position,sh one.probe >one.rows
check "slices are what the whole is" rows_are sh filled.probe one.rows
auto --cache-out court.cache >out.probe
court --cache court.cache >in.out
rows_of position,sh out.probe >a.rows
rows_of position,sh in.out >b.rows
check "a cache that is written is read as it was" cmp a.rows one.rows and test -s b.rows and \
    awk 'NR == FNR { a[FNR] = $4; next } { d += (a[FNR] - $4) ^ 2; s += $4 ^ 2 }
        END { exit !(FNR == 64 && sqrt(d / s) < .02) }' a.rows b.rows
probe-cat --info one.probe >info
check "its light is told to hold the sky, and no other stream's is" \
    sh -c 'probe-cat --info court.cache | grep -q "key capture-cache-holds sky" &&
        ! probe-cat --info one.probe | grep -q capture-cache-holds'
check "the header tells it" says info 'key capture-cache auto' 'key capture-cache-after 1'
check "a second pass takes it over" into again.probe probe-capture -q --again court.obj one.probe \
    and rows_are sh again.probe one.rows

# -- of other light --------------------------------------------------------------------------------
# A cache of another sun, gathered anew at its points, is to the bit the one that is made, whose
# points are the same; so is the light of the probes.
lit() { probe-capture -q --rays 1024 --sky 1,1,1 --sun "$@" court.obj in.probe; }
lit .3,-1,.2,5,5,5 --cache auto --cache-out sun1.cache >sun1.probe
lit .1,-1,.4,2,5,9 --cache auto --cache-out sun2.cache >sun2.probe
lit .1,-1,.4,2,5,9 --cache sun1.cache --cache-renew --cache-out renewed.cache >renewed.probe
for file in sun1.cache sun2.cache renewed.cache; do
    rows_of position,normal,radius,irradiance $file >$file.rows
done
rows_of position,sh,sh_error sun2.probe >sun2.rows
check "a cache that is renewed is the one that is made" test -s sun2.cache.rows and \
    cmp renewed.cache.rows sun2.cache.rows and rows_are sh,sh_error renewed.probe sun2.rows
check "and not the one that it was" sh -c '! cmp -s renewed.cache.rows sun1.cache.rows'
lit .1,-1,.4,2,5,9 --cache renewed.cache --cache-out copy.cache >copy.probe
lit .3,-1,.2,5,5,5 --cache copy.cache --cache-renew --cache-out back.cache >back.probe
rows_of position,normal,radius,irradiance back.cache >back.rows
check "renewed twice, and read between, it is what it was" cmp back.rows sun1.cache.rows
lit .3,-1,.2,5,5,5 --cache sun1.cache --cache-renew >unchanged.probe
lit .3,-1,.2,5,5,5 --cache sun1.cache >read.probe
rows_of position,sh read.probe >read.rows
check "a cache of the scene's light stays as it is" rows_are sh unchanged.probe read.rows
box grey grey none none grey grey >other.obj
refused 1 "sun1.cache: the cache is of other surfaces" \
    probe-capture --sky 1,1,1 --cache sun1.cache --cache-renew other.obj in.probe
refused 1 "sun1.cache: the cache was captured with --decimate 1, not 0.5" \
    probe-capture --sky 1,1,1 --decimate .5 --cache sun1.cache --cache-renew court.obj in.probe
refused 1 "of other light in it (--cache-renew" lit .1,-1,.4,2,5,9 --cache sun1.cache
refused 2 "cache-renew needs --cache FILE" lit .1,-1,.4,2,5,9 --cache auto --cache-renew
refused 2 "cache-renew needs --cache FILE" lit .1,-1,.4,2,5,9 --cache-renew

# -- an order that is found ------------------------------------------------------------------------
auto --order auto --cache-out order.cache >order.probe
order=$(sed -n 's/^sh-order //p' order.probe)
auto --order 6 >six.probe
rows_of position,sh six.probe | cut -d ' ' -f "1-$((3 + 3 * order * order))" >six.rows
check "--order auto: the bands of one capture of all with a cache" test "${order:-9}" -lt 6 and \
    rows_are sh order.probe six.rows and test -s order.cache

# -- where it does not pay -------------------------------------------------------------------------
off() { probe-capture --rays 64 --text "$@" furnace.obj in.probe >off.probe 2>said; }
plain() {
    probe-capture -q --rays 64 --text "$@" furnace.obj in.probe | rows_of position,sh - >plain.rows
}
for way in "--light direct" "--bounces 1" "--rays 4" "--light-scale 0"; do
    off $way --cache auto
    plain $way
    rows_of position,sh off.probe >off.rows
    check "off, and plain light, with $way" says said 'no cache: ' and cmp off.rows plain.rows
done

# A grey slope under an even sky, whose noise is that of its first scatter: a pilot says so before a
# cache is made.
sky_alone() {
    probe-capture --rays 512 --sky 1,1,1 --text "$@" open.obj open.probe
}
sky_alone -q >sky.plain
sky_alone --cache auto >sky.cached 2>said
rows_of position,sh sky.plain >p.rows
rows_of position,sh sky.cached >c.rows
check "off, and plain light, where a pilot finds that it would not pay" \
    says said 'no cache: at its best it would spare [.0-9]* times the rays' and \
    cmp p.rows c.rows and test -s p.rows

# -- no cache --------------------------------------------------------------------------------------
probe-place vertices -q court.obj >v.probe
sunny() { probe-capture -q --rays 64 --sky 1,1,1 --sun .3,-1,.2,5,5,5 "$@"; }
sunny --light indirect court.obj v.probe >v.cache
check "surface probes with indirect light are a cache" court --cache v.cache
sunny court.obj v.probe >all.cache
sunny --light indirect court.obj in.probe >points.cache
sunny --light indirect --bounces 3 court.obj v.probe >few.cache
refused 1 "all.cache: expected --light indirect, got all light" court --cache all.cache
refused 1 "points.cache: expected surface probes, got points without a normal" \
    court --cache points.cache
refused 1 "few.cache: expected a cache of --bounces 63, got 3" court --cache few.cache
refused 1 "v.probe: expected surface probes with light" court --cache v.probe
refused 1 "v.cache: the cache is of another scene, or of other light in it" \
    probe-capture --sky 1,1,1 --cache v.cache court.obj in.probe
refused 1 "its header has no key capture-cache-surfaces" \
    probe-capture --sky 1,1,1 --cache v.cache --cache-renew court.obj in.probe
check "points without light get some" court --cache v.probe --cache-renew
refused 1 "missing.cache" court --cache missing.cache
refused 1 "there is no cache to write" \
    probe-capture --cache auto --cache-out x.cache --bounces 1 furnace.obj in.probe
refused 2 "cache-out needs --cache" probe-capture --cache-out x.cache furnace.obj in.probe
refused 2 "expected a file's name" probe-capture --cache auto --cache-out - furnace.obj in.probe
probe-cat --rows 0:0 in.probe >none.probe
refused 1 "no cache to write: no cache: there are no probes" \
    probe-capture --cache auto --cache-out x.cache furnace.obj none.probe
refused 2 "above 0" probe-capture --cache auto --cache-error 0 furnace.obj in.probe
tap_done
