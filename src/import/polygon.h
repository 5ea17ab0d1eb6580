/* SPDX-License-Identifier: Apache-2.0 */
/* polygon: polygons with any number of corners, concave or not quite plane, split into triangles.
 *
 * Based on: ear clipping (G. H. Meisters 1975, "Polygons have ears"), in the plane across the axis
 * that the polygon's area vector is nearest to. A polygon of n corners always gives n - 2 triangles
 * that use every corner; those of a plane polygon that does not cross itself cover it once, so
 * their areas sum to its area. Corners that lie on a straight line between their neighbours get
 * triangles with an area where the polygon allows it: leaving them out would tear the surface from
 * its neighbours.
 */
#ifndef POLYGON_H
#define POLYGON_H

#include <stddef.h>
#include <stdint.h>

struct error;

/* Room that is kept from one polygon to the next: start with {0}, free with polygon_room_clear. */
struct polygon_room {
    /* 3 * capacity: for callers to put the corners' positions in, after polygon_room_for */
    double *corner;
    uint32_t *triangle; /* 3 * capacity: the result */
    double *plane;
    uint32_t *next, *previous;
    unsigned char *bent;
    size_t capacity;
};

/* Makes room for a polygon of n corners. */
struct error *polygon_room_for(struct polygon_room *room, size_t n);

/* Splits the polygon room->corner[0 .. 3n), n >= 3: n - 2 triangles in room->triangle, as corners 0
 * .. n-1, turning the way that the polygon does. */
void polygon_split(struct polygon_room *room, size_t n);

void polygon_room_clear(struct polygon_room *room);

#endif
