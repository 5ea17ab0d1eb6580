#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Light at vertices by least squares, from probe-place to a file that others read, as people run it.
. "${SRC:?}/tests/support/setup.sh"

# A cube of 2, in two instances, in glTF: probe-export reads what it is to write.
cat >cube.obj <<'OBJ'
v 1 1 1
v 3 1 1
v 3 3 1
v 1 3 1
v 1 1 3
v 3 1 3
v 3 3 3
v 1 3 3
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
OBJ

# -- faces -----------------------------------------------------------------------------------------
probe-place vertices --faces --text cube.obj >vertices.probe
check "a cube has 24 vertices and 12 faces, each vertex on its face's plane" \
    [ "$(row_count probe vertices.probe)" -eq 24 ] and [ "$(row_count face vertices.probe)" -eq 12 ]
# rows of table face, by awk: corner, triangle, instance; fronts are counter-clockwise
awk '/^table probe/ { t = 1; n = 0; next } /^table face/ { t = 2; next } /^end/ { exit }
t == 1 && /^[0-9-]/ { for (k = 0; k < 3; k++) { N[n, k] = $(4 + k); S[n, k] = $(7 + k) } n++ }
t == 2 && /^[0-9-]/ {
    for (k = 0; k < 3; k++) { a[k] = S[$2, k] - S[$1, k]; b[k] = S[$3, k] - S[$1, k] }
    x = (a[1] * b[2] - a[2] * b[1]) * N[$1, 0]
    y = (a[2] * b[0] - a[0] * b[2]) * N[$1, 1]
    z = (a[0] * b[1] - a[1] * b[0]) * N[$1, 2]
    print x + y + z, $4 - f++
}' vertices.probe >turns
check "faces look where their vertices do, in the scene's order" \
    has_lines 12 turns and every '$1 == 4 && $2 == 0' turns
probe-place vertices --faces --sides both --text cube.obj >both.probe
check "--sides both: as many again for backs" \
    [ "$(row_count probe both.probe)" -eq 48 ] and [ "$(row_count face both.probe)" -eq 24 ]
refused 2 "--sides needs --faces" probe-place vertices --sides both cube.obj
refused 2 "got both" probe-place vertices --faces --volume cube.obj
refused 2 "expected no --inside drop" probe-place vertices --faces --inside drop cube.obj

# -- samples ---------------------------------------------------------------------------------------
probe-place samples --text --count 600 vertices.probe >samples.probe
rows_of position,normal,face,weight,area samples.probe >rows
check "samples of a cube: off its faces, whose area they stand for" every \
    '$4 ^ 2 + $5 ^ 2 + $6 ^ 2 == 1 && $7 >= 0 && $7 < 12 &&
    near($8 + $9 + $10, 1, 1e-6) && (sum += $11)' rows and test "$(wc -l <rows)" -ge 590
awk '{ s += $11 } END { print s }' rows >sum
check "which sum to all of it" every 'near($1, 24, 1e-3)' sum
for j in 1 3; do probe-place samples --count 600 -j $j vertices.probe >by$j.probe; done
check "the same for any threads, others by seed" cmp by1.probe by3.probe and eval \
    'probe-place samples --seed 2 --count 600 vertices.probe >other.probe' \
    and differ by1.probe other.probe
refused 1 "expected a table face, there is none" probe-place samples samples.probe
refused 2 "expected no SCENE" probe-place samples vertices.probe cube.obj

# -- the pipe --------------------------------------------------------------------------------------
light='--sky .2,.3,.4 --point 2,5,2.5,30,20,10'
probe-capture -q --rays 64 --columns sky,ao $light cube.obj vertices.probe >sampled.probe
probe-capture -q --rays 16 --columns sky,ao $light cube.obj samples.probe >lit.probe
check "probe-fit fits" into fitted.probe probe-fit sampled.probe lit.probe
probe-fit sampled.probe lit.probe 2>said >/dev/null
check "and says by how much" says said '^probe-fit: irradiance: rms .* was ' '^probe-fit: sky: '
check "errors of light go, faces stay" eval 'probe-cat --info fitted.probe >info' \
    and lacks info irradiance_error and says info '^table face: 12 rows'
probe-fit -q --smooth 0 sampled.probe lit.probe >exact.probe
for s in sampled exact fitted; do
    probe-fit --measure $s.probe lit.probe | awk '$1 == "irradiance" { print $2 }' >$s.rms
done
check "nearer to the samples than what was sampled, nearest without --smooth" eval \
    'paste sampled.rms fitted.rms exact.rms >rms' and every '$1 > $2 && $2 >= $3 && $3 > 0' rms
for j in 1 3; do probe-fit -q -j $j sampled.probe lit.probe >j$j.probe; done
check "the same bytes for any threads" cmp j1.probe j3.probe
probe-fit -q --columns irradiance vertices.probe lit.probe >plain.probe
check "vertices need no light of their own; the samples' is told" says plain.probe \
    '^sky 0.2,0.3,0.4$' '^table probe .*irradiance:f32:3'
rows_of position,irradiance fitted.probe | cut -d ' ' -f 4- >rows
check "no light is below 0" has_lines 24 rows and every '$1 >= 0 && $2 >= 0 && $3 >= 0' rows

# -- what is wrong ---------------------------------------------------------------------------------
refused 1 "the samples have no light" probe-fit vertices.probe samples.probe
refused 1 "the samples have no column nothing" probe-fit --columns nothing vertices.probe lit.probe
refused 1 "expected a table face, there is none" probe-fit lit.probe lit.probe
sed 's/^v 3 3 3/v 3 3 4/' cube.obj >moved.obj
probe-place vertices --faces moved.obj >moved.probe
refused 1 "they are of other vertices" probe-fit moved.probe lit.probe
refused 1 "captured in different scenes" eval \
    'probe-capture -q --rays 8 moved.obj vertices.probe | probe-fit /dev/stdin lit.probe'
refused 1 "expected a probe stream, which begins with" given "" probe-fit vertices.probe
probe-capture -q --rays 8 cube.obj samples.probe | probe-fit vertices.probe 2>said >dark.probe
check "where no light is, it says so" \
    says said 'all samples are black: no light reaches the surface'

# -- export ----------------------------------------------------------------------------------------
check "as GLB" into mesh.glb probe-export glb -q fitted.probe
check "as PLY" into mesh.ply probe-export ply -q fitted.probe
for format in glb ply; do
    probe-place vertices --faces --offset .1 --text mesh.$format >back.probe
    rows_of position,surface back.probe | cut -d ' ' -f 4- | sort >back.$format
done
rows_of position,surface fitted.probe | cut -d ' ' -f 4- | sort >surface
check "whose vertices come back" cmp surface back.glb and cmp surface back.ply and test -s surface
python3 - >colours 2>&1 <<'PY'
import json, math, struct
data = open("mesh.glb", "rb").read()
magic, version, size = struct.unpack("<III", data[:12])
length, kind = struct.unpack("<II", data[12:20])
j = json.loads(data[20:20 + length])
bin_length, bin_kind = struct.unpack("<II", data[20 + length:28 + length])
start = 28 + length
assert magic == 0x46546C67 and version == 2 and size == len(data) and length % 4 == 0
assert kind == 0x4E4F534A and bin_kind == 0x004E4942 and bin_length == j["buffers"][0]["byteLength"]
assert start + bin_length == len(data)
def read(number):
    a = j["accessors"][number]
    v = j["bufferViews"][a["bufferView"]]
    width = {"SCALAR": 1, "VEC3": 3}[a["type"]]
    count = a["count"] * width
    at = start + v["byteOffset"] + a["byteOffset"]
    assert a["byteOffset"] + 4 * count <= v["byteLength"] and at % 4 == 0
    form = "<%d%s" % (count, "fI"[a["componentType"] == 5125])
    values = struct.unpack(form, data[at:at + 4 * count])
    rows = [values[i:i + width] for i in range(0, count, width)]
    if "min" in a:
        assert [min(r[k] for r in rows) for k in range(3)] == a["min"]
        assert [max(r[k] for r in rows) for k in range(3)] == a["max"]
    return rows
for mesh in j["meshes"]:
    p = mesh["primitives"][0]
    index = read(p["indices"])
    for name in p["attributes"]:
        rows = read(p["attributes"][name])
        assert max(i[0] for i in index) < len(rows)
    for row in read(p["attributes"]["COLOR_0"]):
        print("%.6g %.6g %.6g" % tuple(v / j["asset"]["extras"]["scale"] for v in row))
PY
rows_of position,irradiance fitted.probe | cut -d ' ' -f 4- >rows
check "its arrays are whole, and COLOR_0 is the light, linear, where not clipped" eval \
    'sort -g -k 1,1 -k 2,2 colours >a; sort -g -k 1,1 -k 2,2 rows >b; paste a b >c' \
    and has_lines 24 c and every \
    '(near($1, $4, 1e-4 * $4) || $4 > $1) && (near($3, $6, 1e-4 * $6) || $6 > $3)' c
refused 2 "expected a format glb or ply, got 'obj'" probe-export obj fitted.probe
refused 1 "there is no column nothing" probe-export glb --colour nothing fitted.probe
refused 1 "there is neither irradiance nor ao" probe-export glb vertices.probe
refused 1 "expected a table face, there is none" probe-export ply lit.probe

tap_done
