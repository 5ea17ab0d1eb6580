/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/compressed.h"
#include "math/hash.h"
#include "stream/table.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static void add_text(struct hash *hash, const char *text)
{
    hash_add(hash, text ? text : "", (text ? strlen(text) : 0) + 1);
}

void compressed_key(const struct stream_header *header, const struct table *basis,
                    char text[COMPRESSED_KEY_ROOM])
{
    static const char *const keys[] = {"sh-order", "sh-content", "sh-dering", "rotated",
                                       "rotated-light"};
    struct hash hash;
    hash_start(&hash, 0);
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        add_text(&hash, header_key(header, keys[i]));
    for (size_t i = 0; i < basis->column_count; i++) {
        const struct column *c = &basis->columns[i];
        add_text(&hash, c->name);
        hash_add(&hash, c->data, basis->rows * c->width * column_type_size(c->type));
    }
    snprintf(text, COMPRESSED_KEY_ROOM, "%016" PRIx64, hash_value(&hash));
}
