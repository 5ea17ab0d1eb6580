/* SPDX-License-Identifier: Apache-2.0 */
#include "vtk/vtk_fields.h"
#include "base/array.h"
#include "base/error.h"

#include <stdlib.h>
#include <string.h>

struct error *vtk_fields_add(struct vtk_fields *fields, struct vtk_array array)
{
    for (size_t i = 0; i < fields->count; i++)
        if (!strcmp(fields->list[i].name, array.name))
            return NULL;
    struct error *err =
        array_reserve(&fields->list, &fields->capacity, fields->count + 1, sizeof *fields->list);
    if (!err)
        fields->list[fields->count++] = array;
    return err;
}

struct error *vtk_fields_own(struct vtk_fields *fields, size_t count, size_t size, void *block)
{
    struct error *err = array_reserve(&fields->blocks, &fields->block_capacity,
                                      fields->block_count + 1, sizeof *fields->blocks);
    if (!err)
        err = array_create(block, count, size);
    if (!err)
        memcpy(&fields->blocks[fields->block_count++], block, sizeof(void *));
    return err;
}

struct error *vtk_fields_add_new(struct vtk_fields *fields, const char *name, enum vtk_type type,
                                 size_t width, size_t count, void *data)
{
    struct error *err = vtk_fields_own(fields, count * width, vtk_type_size(type), data);
    if (err)
        return err;
    struct vtk_array array = {.name = name, .type = type, .width = width};
    memcpy(&array.data, data, sizeof array.data);
    return vtk_fields_add(fields, array);
}

void vtk_fields_clear(struct vtk_fields *fields)
{
    for (size_t i = 0; i < fields->block_count; i++)
        free(fields->blocks[i]);
    free(fields->blocks);
    free(fields->list);
    *fields = (struct vtk_fields){0};
}
