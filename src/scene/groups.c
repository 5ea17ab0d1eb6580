/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/groups.h"
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "scene/scene_build.h"
#include "scene/scene_choice.h"
#include "stream/stream.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* of a name: irradiance_error_NAME is a column */
enum { NAME_MOST = 63 - 17, LISTED_MOST = 24, TEXT_MOST = 1100 };

static const char rest[] = "rest",
                  no_light[] = "there is no light in the scene: nothing can be in a group";

/* by group_term_kind */
static const struct kind {
    const char *name;
    bool bare, named; /* may stand alone, may have a pattern */
    bool light;       /* point, spot and sun: */
    enum scene_light_kind of;
} kinds[] = {[GROUP_MATERIAL] = {"material", .named = true},
             [GROUP_LIGHT] = {"light", .named = true},
             [GROUP_EMISSIVE] = {"emissive", .bare = true, .named = true},
             [GROUP_POINT] = {"point", true, true, true, SCENE_POINT},
             [GROUP_SPOT] = {"spot", true, true, true, SCENE_SPOT},
             [GROUP_SUN] = {"sun", true, true, true, SCENE_SUN},
             [GROUP_SKY] = {"sky", .bare = true}};

enum { KINDS = sizeof kinds / sizeof *kinds };

void groups_clear(struct light_groups *groups)
{
    for (size_t g = 0; g < groups->count; g++) {
        struct light_group *group = &groups->list[g];
        for (size_t t = 0; t < group->term_count; t++)
            free(group->term[t].pattern);
        free(group->term);
        free(group->name);
    }
    free(groups->list);
    free(groups->source);
    *groups = (struct light_groups){0};
}

/* -- groups and terms -------------------------------------------------------------------------- */

static bool is_taken(const struct light_groups *groups, const char *name)
{
    for (size_t g = 0; g < groups->count; g++)
        if (!strcmp(groups->list[g].name, name))
            return true;
    return false;
}

/* Whether name is `word`, or goes on with _: sh_error_x is the error of group x. */
static bool begins_as(const char *name, const char *word)
{
    const size_t length = strlen(word);
    return !strncmp(name, word, length) && (!name[length] || name[length] == '_');
}

static bool means_another_column(const char *name)
{
    return begins_as(name, "error") || begins_as(name, "gradient") || begins_as(name, "window");
}

static struct error *check_name(const struct light_groups *groups, const char *name)
{
    if (!*name || name[strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789_-")] ||
        strlen(name) > NAME_MOST)
        return error_new("expected a group's name of at most %d of a-z, 0-9, _ and -, got '%.60s'",
                         (int)NAME_MOST, name);
    if (means_another_column(name))
        return error_new("a group cannot be called '%s': column sh_%s is another", name, name);
    return is_taken(groups, name) ? error_new("group '%s' is there already", name) : NULL;
}

static struct error *add_group(struct light_groups *groups, const char *name, size_t line)
{
    if (groups->count == GROUPS_MOST)
        return error_new("more than %d groups", (int)GROUPS_MOST);
    char *copy = strdup(name);
    struct error *err = copy ? array_reserve(&groups->list, &groups->capacity, groups->count + 1,
                                             sizeof *groups->list)
                             : error_memory();
    if (!err)
        groups->list[groups->count++] = (struct light_group){.name = copy, .line = line};
    else
        free(copy);
    return err;
}

static bool is_number(const char *text)
{
    return *text >= '1' && *text <= '9' && !text[strspn(text, "0123456789")] && strlen(text) <= 9;
}

/* What a term is; its pattern points into the text. False: it is none. */
static bool understand(const char *text, struct group_term *term, const char **pattern)
{
    for (size_t k = 0; k < KINDS; k++) {
        const size_t length = strlen(kinds[k].name);
        if (strncmp(text, kinds[k].name, length))
            continue;
        const char *end = text + length;
        *term = (struct group_term){.kind = (enum group_term_kind)k};
        *pattern = *end == '=' ? end + 1 : NULL;
        if (*end == '=' ? kinds[k].named : !*end && kinds[k].bare)
            return true;
        if (kinds[k].light && *end == '-' && is_number(end + 1)) {
            *term = (struct group_term){
                .kind = GROUP_NUMBER, .light = kinds[k].of, .number = strtoul(end + 1, NULL, 10)};
            return true;
        }
    }
    return false;
}

static struct error *add_term(struct light_group *group, const char *text)
{
    struct group_term term;
    const char *pattern;
    if (!understand(text, &term, &pattern))
        return error_new("group '%s': expected material=NAME, light=NAME, emissive, point, spot, "
                         "sun (with =NAME or without), sky, or a light of the options as sun-1, "
                         "point-2, spot-3, got '%.200s'",
                         group->name, text);
    if (pattern && (!*pattern || pattern[strlen(pattern) - 1] == '\\'))
        return error_new("group '%s': expected a name or a pattern behind %.*s, got '%s'",
                         group->name, (int)(pattern - text), text, pattern);
    struct error *err =
        array_reserve(&group->term, &group->term_capacity, group->term_count + 1, sizeof term);
    if (!err && pattern && !(term.pattern = strdup(pattern)))
        err = error_memory();
    if (!err)
        group->term[group->term_count++] = term;
    return err;
}

/* -- text -------------------------------------------------------------------------------------- */

/* Takes the next word off a line into word[TEXT_MOST], quotes and their backslashes undone; *at
 * ends behind it. "": there is none. */
static struct error *next_word(const char **at, char *word)
{
    const char *c = *at + strspn(*at, " \t");
    size_t length = 0;
    bool quoted = false;
    if (*c == '#')
        c += strlen(c);
    for (; *c && (quoted || (*c != ' ' && *c != '\t')); c++) {
        const bool escaped = *c == '\\' && (c[1] == '"' || (!quoted && c[1] == ' '));
        if (*c == '"') {
            quoted = !quoted;
            continue;
        }
        if (escaped)
            c++;
        if (length + 1 == TEXT_MOST)
            return error_new("a word of more than %d bytes", (int)TEXT_MOST - 1);
        word[length++] = *c;
    }
    word[length] = 0;
    *at = c;
    return quoted ? error_new("a quote that does not end") : NULL;
}

static struct error *add_terms(struct light_group *group, const char *at)
{
    char word[TEXT_MOST];
    struct error *err = next_word(&at, word);
    while (!err && *word) {
        err = add_term(group, word);
        if (!err)
            err = next_word(&at, word);
    }
    return err;
}

/* NAME: TERM TERM ... */
static struct error *take_line(struct light_groups *groups, const char *line, size_t number)
{
    char name[TEXT_MOST];
    const char *at = line;
    for (const char *c = line; *c; c++)
        if (iscntrl((unsigned char)*c) && *c != '\t')
            return error_new("expected text without control characters");
    struct error *err = next_word(&at, name);
    if (err || !*name)
        return err;
    char *colon = strchr(name, ':');
    if (!colon)
        return error_new("expected NAME: TERM TERM ..., got '%.200s'", line);
    *colon = 0;
    if (!strcmp(name, rest))
        return error_new("group '%s' is what no line names: expected another name", rest);
    err = check_name(groups, name);
    if (!err)
        err = add_group(groups, name, number);
    /* the colon may stand against the first term */
    if (!err)
        err = add_terms(&groups->list[groups->count - 1], strchr(line, ':') + 1);
    if (!err && !groups->list[groups->count - 1].term_count)
        err = error_new("group '%s': expected what is in it, got nothing", name);
    return err;
}

static struct error *read_lines(struct light_groups *groups, struct file_input *in)
{
    struct error *err = NULL;
    for (bool more = true; more && !err;) {
        const char *line;
        size_t length, bytes;
        err = file_input_line(in, &line, &length, &bytes);
        more = !err && line;
        if (!more)
            break;
        in->line++;
        if (length && line[length - 1] == '\r')
            length--;
        const size_t mark = in->line == 1 && length > 2 && !memcmp(line, "\xEF\xBB\xBF", 3) ? 3 : 0;
        char *text = strndup(line + mark, length - mark);
        if (!text)
            err = error_memory();
        else if (strlen(text) < length - mark)
            err = error_new("expected text, got a byte 0");
        file_input_consume(in, bytes);
        if (!err)
            err = take_line(groups, text, in->line);
        free(text);
        err = error_wrap(err, "%s:%zu", groups->source, in->line);
    }
    return err;
}

struct error *groups_read(struct light_groups *groups, const char *path)
{
    groups_clear(groups);
    groups->each = !strcmp(path, "each");
    if (groups->each)
        return NULL;
    struct file_input in;
    if (!(groups->source = strdup(file_input_name(path))))
        return error_memory();
    struct error *err = file_input_open(&in, path);
    if (err)
        return err;
    err = read_lines(groups, &in);
    file_input_close(&in);
    if (!err && !groups->count)
        err = error_new("%s: expected groups of lights, NAME: TERM TERM ... a line, got none",
                        groups->source);
    return err;
}

/* -- header ------------------------------------------------------------------------------------ */

static bool is_key(const char *name)
{
    return !strncmp(name, "group-", 6) && name[6] >= '1' && name[6] <= '9' &&
           !name[6 + strspn(name + 6, "0123456789")];
}

static const char *kind_name(enum scene_light_kind light)
{
    return light == SCENE_POINT ? "point" : light == SCENE_SPOT ? "spot" : "sun";
}

/* As a line of the file has it. */
static void write_term(const struct group_term *term, FILE *out)
{
    const char *text = term->pattern;
    if (term->kind == GROUP_NUMBER)
        fprintf(out, "%s-%zu", kind_name(term->light), term->number);
    else
        fprintf(out, "%s%s", kinds[term->kind].name, text ? "=" : "");
    const char *quote = text && strpbrk(text, " \t\"") ? "\"" : "";
    fputs(quote, out);
    for (; text && *text; text++)
        fprintf(out, *text == '"' ? "\\%c" : "%c", *text);
    fputs(quote, out);
}

struct error *groups_to_header(const struct light_groups *groups, struct stream_header *header)
{
    struct error *err = NULL;
    for (size_t k = header->key_count; k-- > 0;)
        if (is_key(header->keys[k].name))
            header_remove_key(header, header->keys[k].name);
    for (size_t g = 0; g < groups->count && !err; g++) {
        const struct light_group *group = &groups->list[g];
        char *value = NULL, key[32];
        size_t size = 0;
        FILE *out = open_memstream(&value, &size);
        if (!out)
            return error_memory();
        fputs(group->name, out);
        for (size_t t = 0; t < group->term_count; t++) {
            fputc(' ', out);
            write_term(&group->term[t], out);
        }
        snprintf(key, sizeof key, "group-%zu", g + 1);
        err = fclose(out) ? error_memory() : header_set_key(header, key, value);
        free(value);
    }
    return err;
}

static struct error *take_key(struct light_groups *groups, const char *value)
{
    char name[TEXT_MOST];
    const char *at = value;
    struct error *err = next_word(&at, name);
    if (!err)
        err = check_name(groups, name);
    if (!err)
        err = add_group(groups, name, 0);
    if (!err)
        err = add_terms(&groups->list[groups->count - 1], at);
    if (!err && !groups->list[groups->count - 1].term_count && strcmp(name, rest))
        err = error_new("group '%s': expected what is in it, got nothing", name);
    return err;
}

struct error *groups_from_header(struct light_groups *groups, const struct stream_header *header)
{
    struct error *err = NULL;
    groups_clear(groups);
    for (size_t g = 1; !err; g++) {
        char key[32];
        snprintf(key, sizeof key, "group-%zu", g);
        const char *value = header_key(header, key);
        if (!value)
            break;
        err = error_wrap(take_key(groups, value), "header key %s", key);
    }
    return err;
}

/* -- what shines ------------------------------------------------------------------------------- */

struct search {
    struct light_groups *groups;
    const struct scene *scene;
    const struct groups_way *way;
    struct group_map *map;
    size_t *of_part, *of_material;  /* scene_count_names */
    unsigned char *part, *material; /* what a pattern names; part_count + 1, material_count */
};

static bool shines(const double rgb[3])
{
    return rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0;
}

static bool sky_shines(const struct scene *scene)
{
    return shines(scene->sky.radiance);
}

/* Whether some surface emits by this material. */
static bool is_emitter(const struct search *s, size_t material)
{
    return s->of_material[material] && scene_emits(&s->scene->materials[material]);
}

static size_t first_added(const struct search *s)
{
    return s->scene->light_count - s->way->added;
}

/* The term that names a light or a material alone, as far as names can. */
static void term_of_light(const struct search *s, size_t light, char text[TEXT_MOST])
{
    const struct scene_light *l = &s->scene->lights[light];
    char path[TEXT_MOST - 100];
    if (light >= first_added(s)) {
        snprintf(text, TEXT_MOST, "%s-%zu", kind_name(l->kind), light - first_added(s) + 1);
        return;
    }
    scene_part_path(s->scene, l->part, path, sizeof path);
    snprintf(text, TEXT_MOST, *path ? "%s=%s" : "%s", kind_name(l->kind), path);
}

static void term_of_material(const struct search *s, size_t material, char text[TEXT_MOST])
{
    char name[TEXT_MOST - 100];
    scene_material_name(s->scene, (int32_t)material, name, sizeof name);
    snprintf(text, TEXT_MOST, "material=%s", name);
}

/* All that shines, by number: materials, then lights, then the sky. False: this one does not. */
static size_t count_items(const struct search *s)
{
    return s->scene->material_count + s->scene->light_count + 1;
}

static bool item_term(const struct search *s, size_t item, char text[TEXT_MOST])
{
    const size_t materials = s->scene->material_count, lights = s->scene->light_count;
    const bool on = item < materials ? is_emitter(s, item)
                    : item < materials + lights
                        ? shines(s->scene->lights[item - materials].intensity)
                        : sky_shines(s->scene);
    if (!on)
        return false;
    if (item < materials)
        term_of_material(s, item, text);
    else if (item < materials + lights)
        term_of_light(s, item - materials, text);
    else
        snprintf(text, TEXT_MOST, "sky");
    return true;
}

/* An error that lists what there is. */
static struct error *nothing(const struct search *s, const struct group_term *term)
{
    char *list = NULL, text[TEXT_MOST];
    size_t size = 0, listed = 0, more = 0;
    FILE *out = open_memstream(&list, &size);
    if (!out)
        return error_memory();
    write_term(term, out);
    fputs(": nothing that shines is called so; there is ", out);
    for (size_t i = 0; i < count_items(s); i++) {
        struct group_term shown;
        const char *pattern;
        if (!item_term(s, i, text) || !understand(text, &shown, &pattern))
            continue;
        if (listed == LISTED_MOST) {
            more++;
            continue;
        }
        shown.pattern = (char *)(uintptr_t)pattern;
        fputs(listed++ ? ", " : "", out);
        write_term(&shown, out);
    }
    if (more)
        fprintf(out, " and %zu more", more);
    struct error *err = fclose(out) ? error_memory()
                        : !listed   ? error_new("%s", no_light)
                                    : error_new("%s", list);
    free(list);
    return err;
}

/* -- into groups ------------------------------------------------------------------------------- */

static struct error *in_two(const struct search *s, const char *what, size_t a, size_t b)
{
    return error_new("%s is in two groups, '%s' and '%s'", what, s->groups->list[a].name,
                     s->groups->list[b].name);
}

static struct error *put_light(struct search *s, size_t light, size_t group)
{
    uint16_t *of = &s->map->of_light[light];
    char text[TEXT_MOST];
    if (*of != GROUP_NONE && *of != group) {
        term_of_light(s, light, text);
        return in_two(s, text, *of, group);
    }
    *of = (uint16_t)group;
    return NULL;
}

static struct error *put_material(struct search *s, size_t material, size_t group)
{
    uint16_t *of = &s->map->of_material[material];
    char text[TEXT_MOST];
    if (*of != GROUP_NONE && *of != group) {
        term_of_material(s, material, text);
        return in_two(s, text, *of, group);
    }
    *of = (uint16_t)group;
    return NULL;
}

static struct error *put_sky(struct search *s, size_t group)
{
    uint16_t *of = &s->map->of_sky;
    if (*of != GROUP_NONE && *of != group)
        return in_two(s, "the sky", *of, group);
    *of = (uint16_t)group;
    return NULL;
}

static struct error *put_kind(struct search *s, enum scene_light_kind kind, size_t group,
                              size_t *found)
{
    struct error *err = NULL;
    for (size_t i = 0; i < s->scene->light_count && !err; i++)
        if (s->scene->lights[i].kind == kind) {
            err = put_light(s, i, group);
            ++*found;
        }
    return err;
}

static struct error *put_numbered(struct search *s, const struct group_term *term, size_t group,
                                  size_t *found)
{
    if (term->number > s->way->added)
        return NULL;
    const size_t light = first_added(s) + term->number - 1;
    if (s->scene->lights[light].kind != term->light)
        return NULL;
    ++*found;
    return put_light(s, light, group);
}

static struct error *put_emissive(struct search *s, size_t group, size_t *found)
{
    struct error *err = NULL;
    for (size_t m = 0; m < s->scene->material_count && !err; m++)
        if (is_emitter(s, m)) {
            err = put_material(s, m, group);
            ++*found;
        }
    return err;
}

static struct error *put_by_material(struct search *s, const char *pattern, size_t group,
                                     size_t *found)
{
    struct error *err = NULL;
    memset(s->material, 0, s->scene->material_count);
    scene_match_names(s->scene, pattern, NULL, s->material);
    for (size_t m = 0; m < s->scene->material_count && !err; m++)
        if (s->material[m] && is_emitter(s, m)) {
            err = put_material(s, m, group);
            ++*found;
        }
    return err;
}

/* Puts emissive triangles of an instance that the names are of into a group. */
static struct error *put_surfaces(struct search *s, size_t number, size_t group, size_t *found)
{
    const struct scene_instance *instance = &s->scene->instances[number];
    const struct scene_mesh *mesh = &s->scene->meshes[instance->mesh];
    const bool whole = s->part[instance->part] || s->part[mesh->part];
    uint16_t **of = &s->map->of_instance[number];
    struct error *err = NULL;
    for (size_t t = 0, run = 0; t < mesh->triangle_count && !err; t++) {
        while (run < mesh->run_count && mesh->runs[run].first <= t)
            run++;
        if (!(whole || (run && s->part[mesh->runs[run - 1].part])) ||
            !scene_emits(&s->scene->materials[mesh->material[t]]))
            continue;
        if (!*of) {
            err = array_create(of, mesh->triangle_count, sizeof **of);
            for (size_t k = 0; k < mesh->triangle_count && !err; k++)
                (*of)[k] = GROUP_NONE;
        }
        if (!err && (*of)[t] != GROUP_NONE && (*of)[t] != group) {
            char path[TEXT_MOST - 100], text[TEXT_MOST];
            scene_part_path(s->scene,
                            run              ? mesh->runs[run - 1].part
                            : instance->part ? instance->part
                                             : mesh->part,
                            path, sizeof path);
            snprintf(text, sizeof text, "what emits in '%s'", path);
            return in_two(s, text, (*of)[t], group);
        }
        if (!err)
            (*of)[t] = (uint16_t)group;
        ++*found;
    }
    return err;
}

static struct error *put_by_name(struct search *s, const struct group_term *term, size_t group,
                                 size_t *found)
{
    const struct kind *kind = &kinds[term->kind];
    struct error *err = NULL;
    memset(s->part, 0, s->scene->part_count + 1);
    scene_match_names(s->scene, term->pattern, s->part, NULL);
    for (size_t k = 1; k <= s->scene->part_count; k++)
        s->part[k] |= s->part[s->scene->parts[k - 1].above];
    for (size_t i = 0; i < first_added(s) && term->kind != GROUP_EMISSIVE && !err; i++)
        if (s->part[s->scene->lights[i].part] &&
            (!kind->light || s->scene->lights[i].kind == kind->of)) {
            err = put_light(s, i, group);
            ++*found;
        }
    for (size_t i = 0; i < s->scene->instance_count && !kind->light && !err; i++)
        err = put_surfaces(s, i, group, found);
    return err;
}

static struct error *put_term(struct search *s, const struct group_term *term, size_t group)
{
    size_t found = 0;
    struct error *err = NULL;
    if (term->kind == GROUP_MATERIAL) {
        err = put_by_material(s, term->pattern, group, &found);
    } else if (term->pattern) {
        err = put_by_name(s, term, group, &found);
    } else if (term->kind == GROUP_NUMBER) {
        err = put_numbered(s, term, group, &found);
    } else if (term->kind == GROUP_EMISSIVE) {
        err = put_emissive(s, group, &found);
    } else if (term->kind == GROUP_SKY) {
        found = sky_shines(s->scene);
        err = found ? put_sky(s, group) : NULL;
    } else {
        err = put_kind(s, kinds[term->kind].of, group, &found);
    }
    return !err && !found && !s->way->lenient ? nothing(s, term) : err;
}

static struct error *put_all(struct search *s)
{
    struct error *err = NULL;
    for (size_t g = 0; g < s->groups->count && !err; g++) {
        const struct light_group *group = &s->groups->list[g];
        for (size_t t = 0; t < group->term_count && !err; t++)
            err = put_term(s, &group->term[t], g);
        if (err && group->line)
            err = error_wrap(err, "%s:%zu", s->groups->source, group->line);
        else if (!s->groups->each)
            err = error_wrap(err, "header key group-%zu (--groups takes others)", g + 1);
    }
    return err;
}

/* Looks for surfaces that a name and a material put into two groups, and for those in none. */
static struct error *look_at_surfaces(const struct search *s, bool *left)
{
    const struct scene *scene = s->scene;
    struct error *err = NULL;
    for (size_t i = 0; i < scene->instance_count && !err; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        const uint16_t *of = s->map->of_instance[i];
        for (size_t t = 0; t < mesh->triangle_count && !err; t++) {
            const size_t m = (size_t)mesh->material[t];
            if (!scene_emits(&scene->materials[m]))
                continue;
            const size_t by_name = of ? of[t] : GROUP_NONE, by_material = s->map->of_material[m];
            *left = *left || (by_name == GROUP_NONE && by_material == GROUP_NONE);
            if (by_name == GROUP_NONE || by_material == GROUP_NONE || by_name == by_material)
                continue;
            char text[TEXT_MOST];
            term_of_material(s, m, text);
            err = in_two(s, text, by_material, by_name);
        }
    }
    return err;
}

/* What no line names is the rest. */
static struct error *put_rest(struct search *s)
{
    const struct scene *scene = s->scene;
    const bool sky = sky_shines(scene) && s->map->of_sky == GROUP_NONE;
    bool left = sky;
    for (size_t i = 0; i < scene->light_count; i++)
        left = left || (s->map->of_light[i] == GROUP_NONE && shines(scene->lights[i].intensity));
    struct error *err = look_at_surfaces(s, &left);
    if (err)
        return err;
    size_t place = 0;
    while (place < s->groups->count && strcmp(s->groups->list[place].name, rest))
        place++;
    if (left && place == s->groups->count)
        err = add_group(s->groups, rest, 0);
    const uint16_t none = (uint16_t)(left ? place : 0);
    for (size_t i = 0; i < scene->light_count; i++)
        if (s->map->of_light[i] == GROUP_NONE)
            s->map->of_light[i] = none;
    for (size_t m = 0; m < scene->material_count; m++)
        if (s->map->of_material[m] == GROUP_NONE)
            s->map->of_material[m] = none;
    if (sky)
        s->map->of_sky = none;
    return err;
}

/* -- one of each ------------------------------------------------------------------------------- */

/* A name that a column may have, and no other group has, for what a term names. */
static void make_name(const struct light_groups *groups, const char *term, char *name)
{
    const char *equal = strchr(term, '='), *slash = strrchr(term, '/');
    const char *own = slash && slash[1] ? slash + 1 : equal ? equal + 1 : term;
    enum { OWN_MOST = NAME_MOST - 8 };
    size_t length = 0;
    for (; *own && length < OWN_MOST; own++) {
        const int c = tolower((unsigned char)*own);
        const bool fits = strchr("abcdefghijklmnopqrstuvwxyz0123456789_-", c);
        if (((unsigned char)*own & 0xC0) != 0x80) /* one _ a letter, not a byte */
            name[length++] = fits ? (char)c : '_';
    }
    name[length] = 0;
    if (means_another_column(name) || !strcmp(name, rest))
        strcpy(name + length, "-light");
    length = strlen(name);
    for (size_t k = 2; is_taken(groups, name); k++)
        snprintf(name + length, NAME_MOST + 1 - length, "-%zu", k);
}

/* Whether a group holds just that already: of several materials of one name, the first. */
static bool is_made(const struct light_groups *groups, const struct group_term *term,
                    const char *pattern)
{
    for (size_t g = 0; g < groups->count; g++) {
        const struct group_term *other = &groups->list[g].term[0];
        if (other->kind == term->kind && other->number == term->number &&
            !strcmp(other->pattern ? other->pattern : "", pattern ? pattern : ""))
            return true;
    }
    return false;
}

static struct error *make_each(struct search *s)
{
    char text[TEXT_MOST], name[NAME_MOST + 1];
    struct error *err = NULL;
    for (size_t i = 0; i < count_items(s) && !err; i++) {
        struct group_term term;
        const char *pattern;
        if (!item_term(s, i, text) || !understand(text, &term, &pattern) ||
            is_made(s->groups, &term, pattern))
            continue;
        make_name(s->groups, text, name);
        err = add_group(s->groups, name, 0);
        if (!err)
            err = add_term(&s->groups->list[s->groups->count - 1], text);
    }
    if (!err && !s->groups->count)
        err = error_new("%s", no_light);
    return err;
}

struct error *groups_resolve(struct light_groups *groups, const struct scene *scene,
                             const struct groups_way *way, struct group_map *map)
{
    struct search s = {.groups = groups, .scene = scene, .way = way, .map = map};
    *map = (struct group_map){.of_sky = GROUP_NONE};
    struct error *err = scene_count_names(scene, &s.of_part, &s.of_material);
    if (!err)
        err = array_create(&map->of_light, scene->light_count, sizeof *map->of_light);
    if (!err)
        err = array_create(&map->of_material, scene->material_count, sizeof *map->of_material);
    if (!err)
        err = array_create(&map->of_instance, scene->instance_count, sizeof *map->of_instance);
    if (!err)
        err = array_create(&s.part, scene->part_count + 1, 1);
    if (!err)
        err = array_create(&s.material, scene->material_count, 1);
    if (!err) {
        map->instance_count = scene->instance_count;
        for (size_t i = 0; i < scene->light_count; i++)
            map->of_light[i] = GROUP_NONE;
        for (size_t m = 0; m < scene->material_count; m++)
            map->of_material[m] = GROUP_NONE;
    }
    if (!err && groups->each && !groups->count)
        err = make_each(&s);
    if (!err)
        err = put_all(&s);
    if (!err)
        err = error_wrap(put_rest(&s), "%s", groups->source ? groups->source : "groups of lights");
    map->count = groups->count;
    free(s.of_part);
    free(s.of_material);
    free(s.part);
    free(s.material);
    return err;
}

void group_map_clear(struct group_map *map)
{
    for (size_t i = 0; i < map->instance_count; i++)
        free(map->of_instance[i]);
    free(map->of_instance);
    free(map->of_light);
    free(map->of_material);
    *map = (struct group_map){0};
}

/* -- weights ----------------------------------------------------------------------------------- */

/* The factors of a group, not below 0. */
static void factors_of(const double *weight, size_t group, enum groups_part part, double factor[3])
{
    for (int c = 0; c < 3; c++)
        factor[c] = group == GROUP_NONE ? 0
                                        : fmax(part == GROUPS_TAKEN ? -weight[3 * group + (size_t)c]
                                                                    : weight[3 * group + (size_t)c],
                                               0);
}

static void scale(double rgb[3], const double factor[3])
{
    for (int c = 0; c < 3; c++)
        rgb[c] *= factor[c];
}

/* Copies of materials, by material and group of surfaces that are in it by name. */
struct copies {
    struct {
        int32_t material, copy;
        uint16_t group;
    } * list;
    size_t count, capacity;
};

static struct error *copy_material(struct scene *scene, struct copies *copies, int32_t material,
                                   uint16_t group, int32_t *copy)
{
    for (size_t i = 0; i < copies->count; i++)
        if (copies->list[i].material == material && copies->list[i].group == group) {
            *copy = copies->list[i].copy;
            return NULL;
        }
    struct scene_material m = scene->materials[material];
    if (!(m.name = strdup(m.name)))
        return error_memory();
    struct error *err = scene_push_material(scene, m, copy);
    if (!err)
        err = array_reserve(&copies->list, &copies->capacity, copies->count + 1,
                            sizeof *copies->list);
    if (!err) {
        copies->list[copies->count].material = material;
        copies->list[copies->count].copy = *copy;
        copies->list[copies->count++].group = group;
    }
    return err;
}

/* Gives the surfaces of an instance that are in groups by name materials of their own. */
static struct error *part_surfaces(struct scene *scene, const uint16_t *of, size_t number,
                                   struct copies *copies)
{
    const size_t was = scene->instances[number].mesh, triangles = scene->meshes[was].triangle_count;
    bool shared = false;
    for (size_t i = 0; i < scene->instance_count; i++)
        shared = shared || (i != number && scene->instances[i].mesh == was);
    struct error *err = shared ? scene_copy_mesh(scene, was, &scene->instances[number].mesh) : NULL;
    for (size_t t = 0; t < triangles && !err; t++) {
        int32_t *material = &scene->meshes[scene->instances[number].mesh].material[t];
        if (of[t] != GROUP_NONE)
            err = copy_material(scene, copies, *material, of[t], material);
    }
    return err;
}

static void scale_material(struct scene_material *m, const double *weight, size_t group,
                           enum groups_part part)
{
    double factor[3];
    factors_of(weight, group, part, factor);
    m->emission.x *= (float)factor[0];
    m->emission.y *= (float)factor[1];
    m->emission.z *= (float)factor[2];
}

struct error *groups_scale(struct scene *scene, const struct group_map *map, const double *weight,
                           enum groups_part part)
{
    struct copies copies = {0};
    struct error *err = NULL;
    double factor[3];
    const size_t materials = scene->material_count;
    scene_keep_keys(scene);
    for (size_t i = 0; i < map->instance_count && !err; i++)
        if (map->of_instance[i])
            err = part_surfaces(scene, map->of_instance[i], i, &copies);
    for (size_t m = 0; m < materials && !err; m++)
        scale_material(&scene->materials[m], weight, map->of_material[m], part);
    for (size_t i = 0; i < copies.count && !err; i++)
        scale_material(&scene->materials[copies.list[i].copy], weight, copies.list[i].group, part);
    for (size_t i = 0; i < scene->light_count && !err; i++) {
        factors_of(weight, map->of_light[i], part, factor);
        scale(scene->lights[i].intensity, factor);
    }
    factors_of(weight, map->of_sky, part, factor);
    scale(scene->sky.radiance, factor);
    free(copies.list);
    return err;
}
