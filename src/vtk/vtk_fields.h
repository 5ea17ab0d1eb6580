/* SPDX-License-Identifier: Apache-2.0 */
/* vtk_fields: a growing list of named arrays (vtk_export.h), with the memory they own.
 *
 * The first array of a name stays: what a stream holds goes in before what is derived from it, so a
 * column is never replaced by a derived array that happens to have its name.
 */
#ifndef VTK_FIELDS_H
#define VTK_FIELDS_H

#include "vtk/vtk_export.h"

#include <stddef.h>

struct error;

/* Starts as {0}. */
struct vtk_fields {
    struct vtk_array *list; /* owned, as are the blocks */
    size_t count, capacity;
    void **blocks;
    size_t block_count, block_capacity;
};

/* Adds an array as it stands; what it points to is borrowed. Does nothing where the name is
 * taken. */
struct error *vtk_fields_add(struct vtk_fields *fields, struct vtk_array array);

/* Adds an array of `count` zeroed tuples, to be filled by the caller through *data (a T **). Where
 * the name is taken, *data can be filled all the same, and is not written. */
struct error *vtk_fields_add_new(struct vtk_fields *fields, const char *name, enum vtk_type type,
                                 size_t width, size_t count, void *data);

/* Zeroed memory that lives as long as the fields: *block (a T **) gets `count` elements of `size`
 * bytes. */
struct error *vtk_fields_own(struct vtk_fields *fields, size_t count, size_t size, void *block);

void vtk_fields_clear(struct vtk_fields *fields);

#endif
