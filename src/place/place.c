/* SPDX-License-Identifier: Apache-2.0 */
#include "place/place.h"
#include "base/array.h"
#include "base/error.h"
#include "stream/stream.h"

#include <stdlib.h>
#include <string.h>

void place_clear(struct place *place)
{
    free(place->position);
    free(place->normal);
    free(place->origin);
    table_clear(&place->columns);
    table_clear(&place->faces);
    stream_destroy(place->from);
    header_clear(&place->header);
    *place = (struct place){0};
}

struct error *place_add_column(struct place *place, const char *name, enum column_type type,
                               size_t width, struct column **column)
{
    struct table *columns = &place->columns;
    struct error *err = columns->name ? NULL : table_init(columns, "probe");
    if (!err)
        err = table_resize(columns, place->count);
    return err ? err : table_add_column(columns, name, type, width, column);
}

struct error *place_check_count(double count, double most)
{
    if (count > most)
        return error_new("this makes %.15g probes, more than --max-probes %.15g", count, most);
    return NULL;
}

struct error *place_append(struct place *place, const double p[3])
{
    size_t room = place->capacity;
    struct error *err =
        array_reserve(&place->position, &room, place->count + 1, 3 * sizeof *place->position);
    if (err)
        return err;
    place->capacity = room;
    memcpy(place->position + 3 * place->count++, p, 3 * sizeof *p);
    return NULL;
}
