/* SPDX-License-Identifier: Apache-2.0 */
/* What a program that was compiled against probe-query.h has in it: sizes and places of its
 * structs, and its numbers. As lines for tests/libprobe-query.t, which compares them with
 * tests/libprobe-query.abi.
 */
#include "libprobe-query/probe-query.h"

#include <stdio.h>

#define SIZE(type)                                                                                 \
    printf("struct %s: %zu bytes, aligned to %zu\n", #type, sizeof(struct type),                   \
           _Alignof(struct type))
#define PLACE(type, member)                                                                        \
    printf("struct %s: %s at %zu, %zu bytes\n", #type, #member, offsetof(struct type, member),     \
           sizeof((struct type){0}.member))
#define NUMBER(name) printf("%s = %d\n", #name, (int)name)

int main(void)
{
    SIZE(probe_mesh);
    PLACE(probe_mesh, probes);
    PLACE(probe_mesh, position);
    PLACE(probe_mesh, corners);
    PLACE(probe_mesh, cells);
    PLACE(probe_mesh, vertex);
    PLACE(probe_mesh, neighbour);
    SIZE(probe_place);
    PLACE(probe_place, cell);
    PLACE(probe_place, probe);
    PLACE(probe_place, weight);
    PLACE(probe_place, inside);
    PLACE(probe_place, distance);
    SIZE(probe_image_facts);
    PLACE(probe_image_facts, order);
    PLACE(probe_image_facts, convolved);
    PLACE(probe_image_facts, packing);
    PLACE(probe_image_facts, vertex_bytes);
    PLACE(probe_image_facts, neighbour_bytes);
    PLACE(probe_image_facts, bytes_per_probe);
    PLACE(probe_image_facts, bytes_per_cell);
    PLACE(probe_image_facts, bytes);
    SIZE(probe_discs);
    PLACE(probe_discs, probes);
    PLACE(probe_discs, position);
    PLACE(probe_discs, normal);
    PLACE(probe_discs, radius);
    PLACE(probe_discs, irradiance);
    SIZE(probe_groups);
    PLACE(probe_groups, count);
    PLACE(probe_groups, name);
    PLACE(probe_groups, sh);
    NUMBER(PROBE_OK);
    NUMBER(PROBE_NO_MEMORY);
    NUMBER(PROBE_BAD_ARGUMENT);
    NUMBER(PROBE_NO_CELLS);
    NUMBER(PROBE_BAD_POSITION);
    NUMBER(PROBE_BAD_VERTEX);
    NUMBER(PROBE_BAD_NEIGHBOUR);
    NUMBER(PROBE_BAD_SHAPE);
    NUMBER(PROBE_BAD_POINT);
    NUMBER(PROBE_NOT_AN_IMAGE);
    NUMBER(PROBE_BAD_IMAGE);
    NUMBER(PROBE_BAD_SIGHT);
    NUMBER(PROBE_NO_DISCS);
    NUMBER(PROBE_BAD_DISC);
    NUMBER(PROBE_DISCS_APART);
    NUMBER(PROBE_DISCS_LARGE);
    NUMBER(PROBE_NO_GROUPS);
    NUMBER(PROBE_LEAN);
    NUMBER(PROBE_NEAREST);
    NUMBER(PROBE_EXTEND);
    NUMBER(PROBE_SEE_ALL);
    NUMBER(PROBE_LAZY);
    NUMBER(PROBE_COLD);
    NUMBER(PROBE_PACK_FLOAT);
    NUMBER(PROBE_PACK_HALF);
    return 0;
}
