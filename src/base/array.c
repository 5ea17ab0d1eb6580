/* SPDX-License-Identifier: Apache-2.0 */
#include "base/array.h"
#include "base/error.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/mman.h>
#endif

/* Asks for large pages: a gigabyte is 512 times fewer faults, each of which takes a microsecond, on
 * virtual machines 16. The whole of a block's own mapping, so that realloc still moves it as one.
 */
static void ask_for_large_pages(void *memory, size_t bytes)
{
#ifdef MADV_HUGEPAGE
    const uintptr_t page = 4096, from = (uintptr_t)memory & -page,
                    end = ((uintptr_t)memory + bytes + page - 1) & -page;
    if (memory && bytes >= (size_t)1 << 22) /* refused, it is slower, no more */
        madvise((char *)memory - ((uintptr_t)memory - from), end - from, MADV_HUGEPAGE);
#else
    (void)memory;
    (void)bytes;
#endif
}

struct error *array_create(void *array, size_t count, size_t size)
{
    void *memory = count > SIZE_MAX / size ? NULL : calloc(count ? count : 1, size);
    ask_for_large_pages(memory, count * size);
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
    ask_for_large_pages(memory, room * size);
    memcpy(array, &memory, sizeof memory);
    *capacity = room;
    return NULL;
}
