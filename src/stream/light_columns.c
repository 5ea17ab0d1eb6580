/* SPDX-License-Identifier: Apache-2.0 */
#include "stream/light_columns.h"

#include <string.h>

/* What stands behind `word` in a name: "" or "_...", without the _; NULL: another name. */
static const char *behind(const char *name, const char *word)
{
    const size_t length = strlen(word);
    if (strncmp(name, word, length))
        return NULL;
    return !name[length]                             ? name + length
           : name[length] == '_' && name[length + 1] ? name + length + 1
                                                     : NULL;
}

/* What a name says of its column; false: it is no light's. */
static bool by_name(const char *name, struct light_column *what)
{
    *what = (struct light_column){.blocks = 1, .channels = 3};
    const char *rest = behind(name, "transfer_sky");
    if (!rest)
        rest = behind(name, "transfer_suns");
    if (!rest)
        rest = behind(name, "transfer_points");
    if (rest) {
        what->transfer = true;
        what->role = *rest ? LIGHT_ERROR : LIGHT_VALUE;
        return !*rest || !strcmp(rest, "error");
    }
    if (!strcmp(name, "transfer_surfaces")) {
        what->transfer = true;
        what->channels = 1;
        return true;
    }
    rest = behind(name, "irradiance");
    what->surface = rest;
    if (!rest)
        rest = behind(name, "sh");
    if (!rest || behind(rest, "window"))
        return false;
    const char *error = behind(rest, "error"), *gradient = behind(rest, "gradient");
    what->role = error ? LIGHT_ERROR : gradient ? LIGHT_GRADIENT : LIGHT_VALUE;
    what->group = *(error ? error : gradient ? gradient : rest);
    return !gradient || (!what->group && !what->surface);
}

bool light_column_of(const struct column *column, size_t sh_width, struct light_column *what)
{
    if (column->type != COLUMN_F32 || !by_name(column->name, what))
        return false;
    if (what->transfer)
        what->surface = !sh_width;
    what->block = (size_t)what->channels * (what->surface ? 1 : sh_width / 3);
    if (what->role == LIGHT_GRADIENT)
        what->blocks = 3;
    else if (what->transfer && what->block)
        what->blocks = column->width / what->block;
    return what->block && what->blocks && column->width == what->block * what->blocks;
}

bool light_column_is_compressed(const char *name)
{
    return !strcmp(name, "pca") || !strcmp(name, "pca_cluster");
}

bool light_column_is_split(const char *name)
{
    struct light_column what;
    return light_column_is_compressed(name) || !strcmp(name, "transfer_senders") ||
           (by_name(name, &what) && (what.group || what.transfer));
}

bool light_table_is(const char *name)
{
    return !strcmp(name, LIGHT_BASIS_TABLE) || !strcmp(name, LIGHT_SENDERS_TABLE);
}

bool light_key_is_split(const char *key)
{
    return !strncmp(key, "group-", 6) || !strncmp(key, "transfer-", 9) || !strncmp(key, "pca-", 4);
}

bool light_key_changes(const char *key)
{
    static const char *const families[] = {"sun-",   "point-",  "spot-",
                                           "relit-", "weight-", "rotated"};
    for (size_t i = 0; i < sizeof families / sizeof *families; i++)
        if (!strncmp(key, families[i], strlen(families[i])))
            return true;
    return false;
}
