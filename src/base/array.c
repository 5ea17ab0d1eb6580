/* SPDX-License-Identifier: Apache-2.0 */
#include "base/array.h"
#include "base/error.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

struct error *array_create(void *array, size_t count, size_t size)
{
    void *memory = count > SIZE_MAX / size ? NULL : calloc(count ? count : 1, size);
    memcpy(array, &memory, sizeof memory);
    return memory ? NULL : error_memory();
}

struct error *array_reserve(void *array, size_t *capacity, size_t count, size_t size)
{
    if (count <= *capacity)
        return NULL;
    size_t room = *capacity + *capacity / 2;
    if (room < count)
        room = count;
    if (room < 16)
        room = 16;
    if (room > SIZE_MAX / size)
        return error_memory();
    void *memory;
    memcpy(&memory, array, sizeof memory);
    memory = realloc(memory, room * size);
    if (!memory)
        return error_memory();
    memcpy(array, &memory, sizeof memory);
    *capacity = room;
    return NULL;
}
