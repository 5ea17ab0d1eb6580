/* SPDX-License-Identifier: Apache-2.0 */
/* reach: the play space: where a body gets from start points.
 *
 * A body that walks is a cylinder with round ends on columns of a lattice: it stands on floors not
 * steeper than 60 degrees, goes from a column to the eight around it where nothing is in the way
 * but what is lower than it climbs, and falls as far as it may. One that flies is a ball on the
 * nodes of a lattice. The flood goes breadth first from each start in turn: the same region for
 * any number of threads, in time and memory that grow as the region does. What a ray passes, holes
 * of cut-outs, is no obstacle to feet, but within a body's radius all surfaces are.
 *
 * The region is what some part of a body can occupy: of each column the spans of height where one
 * stood or fell, with the headroom, as wide as the body and half a cell more, so that the lattice
 * takes nothing off at walls.
 */
#ifndef REACH_H
#define REACH_H

#include <stdbool.h>
#include <stddef.h>

struct error;
struct option_row;
struct place;
struct reach;
struct tracer;
struct warnings;

/* Lengths in units of the scene. */
struct reach_settings {
    double radius, height;
    double climb, drop; /* how far up and down a step may go */
    double headroom;    /* air above a body that counts, where it is free */
    double cell;        /* of the lattice; 0: half the radius */
    bool fly;
    int most; /* cells that are tried */
    int threads;
    const char *program; /* in whose name the flood's progress is shown; NULL: it is not */
    bool most_given, radius_given, height_given, climb_given, drop_given, headroom_given,
        cell_given, fly_given;
};

/* A grown person in metres: .3, 1.8, .4, 3, .3; and 4000000 cells. */
struct reach_settings reach_default(void);

enum { REACH_OPTION_ROWS = 9 };

/* Writes the options of a body, and returns what follows them. */
struct option_row *reach_option_rows(struct reach_settings *settings, struct option_row *row);
/* The first of them that was given; NULL: none. */
const char *reach_option_given(const struct reach_settings *settings);
/* A usage error where one of a body that walks was given, and --fly. */
struct error *reach_check_given(const struct reach_settings *settings);

/* Floods from the points of a file (points.h). The tracer is not needed any more afterwards.
 * Errors name the line of a start that is in no air or out of the scene, has no floor below, or
 * where the body does not fit; and the region has too many cells. Warns where it is cut. */
struct error *reach_create(struct reach **reach, const char *file, const struct tracer *tracer,
                           const struct reach_settings *settings, struct warnings *warnings);
void reach_destroy(struct reach *reach); /* NULL is legal */

/* Whether p is in the region, and whether any of it is in the box p - margin .. p + margin. Any
 * thread. */
bool reach_holds(const struct reach *reach, const double p[3]);
bool reach_near(const struct reach *reach, const double p[3], const double margin[3]);

/* What a region is told by: its starts and its body, in hexadecimal. The file cannot be standard
 * input: it is read once more. */
enum { REACH_KEY = 17 };
struct error *reach_key(const char *file, const struct reach_settings *settings,
                        char key[REACH_KEY]);

/* What holds the region. */
void reach_box(const struct reach *reach, double low[3], double high[3]);

/* Where bodies stood or flew: their middles, in the order of the flood. */
size_t reach_count(const struct reach *reach);
void reach_place(const struct reach *reach, size_t i, double p[3]);

#endif
