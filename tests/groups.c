/* SPDX-License-Identifier: Apache-2.0 */
/* Groups of lights: which light is in which, by a file, by a header and one of each; and a scene
 * that is lit by weights of them. */
#include "scene/groups.h"
#include "base/warning.h"
#include "scene/scene_build.h"
#include "scene/scene_settings.h"
#include "stream/stream.h"
#include "support/files.h"
#include "support/tap.h"

static struct scene *scene;
static size_t lamp_mesh;

static int32_t push_material(const char *name, float emission)
{
    struct scene_material m = scene_material_default();
    int32_t number;
    m.name = strdup(name);
    m.emission = (struct vec3f){emission, 2 * emission, 3 * emission};
    must(scene_push_material(scene, m, &number));
    return number;
}

static uint32_t push_part(enum scene_part_kind kind, const char *name, uint32_t above)
{
    uint32_t part;
    must(scene_push_part(scene, kind, name, above, &part));
    return part;
}

static size_t push_mesh(int32_t a, int32_t b)
{
    const double corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    const uint32_t index[] = {0, 1, 2, 1, 3, 2};
    struct scene_mesh mesh = {.vertex_count = 4, .triangle_count = 2};
    size_t place;
    mesh.position = malloc(sizeof corners);
    mesh.index = malloc(sizeof index);
    mesh.material = malloc(2 * sizeof *mesh.material);
    memcpy(mesh.position, corners, sizeof corners);
    memcpy(mesh.index, index, sizeof index);
    mesh.material[0] = a, mesh.material[1] = b;
    must(scene_push_mesh(scene, mesh, &place));
    return place;
}

static void place_at(size_t mesh, uint32_t part)
{
    must(scene_push_instance(scene, mesh, scene_identity));
    scene->instances[scene->instance_count - 1].part = part;
}

static void push_light(enum scene_light_kind kind, uint32_t part)
{
    must(scene_push_light(scene, (struct scene_light){.kind = kind,
                                                      .direction = {0, -1, 0},
                                                      .intensity = {1, 2, 3},
                                                      .cos_inner = 1,
                                                      .part = part}));
}

/* Two lamps that are one mesh (a bulb and its shade), each with a point light in its node; a
 * screen; the file's sun; of the options a spot and a sun; a sky. */
static void make_scene(void)
{
    struct warnings warnings = {0};
    struct scene_light added[2] = {
        {.kind = SCENE_SPOT, .direction = {0, -1, 0}, .intensity = {4, 4, 4}, .cos_inner = 1},
        {.kind = SCENE_SUN, .direction = {0, -1, 0}, .intensity = {5, 5, 5}}};
    struct scene_settings settings = scene_settings_default();
    must(scene_create(&scene));
    const int32_t bulb = push_material("Bulb", 1), shade = push_material("shade", 0),
                  screen = push_material("My \"screen\" [1]", 4);
    const uint32_t hall = push_part(SCENE_NODE, "Hall", 0),
                   lamp1 = push_part(SCENE_NODE, "Lamp 1", hall),
                   lamp2 = push_part(SCENE_NODE, "Lamp 2", hall),
                   sun = push_part(SCENE_LIGHT, "Sun", 0);
    lamp_mesh = push_mesh(bulb, shade);
    place_at(lamp_mesh, lamp1);
    place_at(lamp_mesh, lamp2);
    place_at(push_mesh(screen, screen), hall);
    push_light(SCENE_POINT, lamp1);
    push_light(SCENE_POINT, lamp2);
    push_light(SCENE_SUN, sun);
    settings.lights = added;
    settings.light_count = 2;
    settings.sky[1] = 0.5;
    must(scene_finish(scene, &settings, &warnings));
    warnings_clear(&warnings);
}

static const struct groups_way way = {.added = 2};

/* The groups of a text, resolved; NULL: "each". */
static struct error *groups_of(const char *text, struct light_groups *groups, struct group_map *map)
{
    if (text)
        files_write("g", text);
    struct error *err = groups_read(groups, text ? files_path("g") : "each");
    *map = (struct group_map){0};
    return err ? err : groups_resolve(groups, scene, &way, map);
}

/* Whether a text is refused with a message that holds all of `words`, NULL behind them. */
static bool refused(const char *text, const char *const *words)
{
    struct light_groups groups = {0};
    struct group_map map;
    struct error *err = groups_of(text, &groups, &map);
    bool right = err;
    for (; err && *words; words++)
        right = right && strstr(error_message(err), *words);
    if (!right)
        printf("# got: %s\n", err ? error_message(err) : "no error");
    error_destroy(err);
    group_map_clear(&map);
    groups_clear(&groups);
    return right;
}

#define REFUSED(text, ...) refused(text, (const char *const[]){__VA_ARGS__, NULL})

static size_t of_surface(const struct group_map *map, size_t instance, size_t triangle)
{
    const struct scene_mesh *mesh = &scene->meshes[scene->instances[instance].mesh];
    return group_of_surface(map, scene, instance, triangle,
                            &scene->materials[mesh->material[triangle]]);
}

static bool same_map(const struct group_map *a, const struct group_map *b)
{
    bool same = a->count == b->count && a->of_sky == b->of_sky;
    for (size_t i = 0; i < scene->light_count; i++)
        same = same && a->of_light[i] == b->of_light[i];
    for (size_t i = 0; i < 3; i++)
        same = same && of_surface(a, i, 0) == of_surface(b, i, 0);
    return same;
}

static void test_file(void)
{
    struct light_groups groups = {0}, again = {0}, third = {0};
    struct group_map map, map_again, map_third;
    struct stream_header header = {0};
    must(groups_of("# lamps\r\n\n one: light=\"Lamp 1\" # the first\n"
                   "two:light=Hall/Lamp\\ 2\nscreens: material=\"My \\\"screen\\\" [1]\"\n"
                   "day-2: sky sun=S?n sun-2",
                   &groups, &map));
    ok(map.count == 5 && !strcmp(groups.list[4].name, "rest") && !groups.list[4].term_count,
       "what no line names is the rest: %zu groups", map.count);
    ok(of_surface(&map, 0, 0) == 0 && of_surface(&map, 1, 0) == 1 && of_surface(&map, 2, 0) == 2,
       "surfaces of one mesh are told apart by their nodes, others by their material");
    ok(map.of_light[0] == 0 && map.of_light[1] == 1 && map.of_light[2] == 3 &&
           map.of_light[3] == 4 && map.of_light[4] == 3 && map.of_sky == 3,
       "lights go by their node, their name, their kind and their number");
    must(groups_to_header(&groups, &header));
    ok(!strcmp(header_key(&header, "group-3"), "screens material=\"My \\\"screen\\\" [1]\"") &&
           !strcmp(header_key(&header, "group-4"), "day-2 sky sun=S?n sun-2") &&
           !strcmp(header_key(&header, "group-5"), "rest"),
       "the header says what each is");
    must(groups_from_header(&again, &header));
    must(groups_resolve(&again, scene, &way, &map_again));
    ok(same_map(&map, &map_again), "the header's groups are those of the file");
    must(groups_of("a: emissive=*1* point\nb: emissive=*2* sun spot sky\n", &third, &map_third));
    ok(map_third.count == 3 && of_surface(&map_third, 0, 0) == 0 &&
           of_surface(&map_third, 1, 0) == 1 && of_surface(&map_third, 2, 0) == 2 &&
           map_third.of_light[1] == 0 && map_third.of_light[2] == 1 && map_third.of_sky == 1,
       "kinds take all of theirs, or those of a name");
    must(groups_to_header(&third, &header));
    ok(!header_key(&header, "group-4") && header_key(&header, "group-3"),
       "other groups leave none of those before");
    group_map_clear(&map), group_map_clear(&map_again), group_map_clear(&map_third);
    groups_clear(&groups), groups_clear(&again), groups_clear(&third);
    header_clear(&header);
}

static void test_each(void)
{
    struct light_groups groups = {0}, again = {0};
    struct group_map map, map_again;
    struct stream_header header = {0};
    static const char *const names[] = {"bulb", "my__screen___1_", "lamp_1", "lamp_2",
                                        "sun",  "spot-1",          "sun-2",  "sky"};
    must(groups_of(NULL, &groups, &map));
    bool named = map.count == 8;
    for (size_t g = 0; g < map.count && named; g++)
        named = !strcmp(groups.list[g].name, names[g]);
    ok(named, "each light, material and the sky are a group, and there is no rest");
    ok(of_surface(&map, 0, 0) == 0 && of_surface(&map, 1, 0) == 0 && of_surface(&map, 2, 0) == 1 &&
           map.of_light[1] == 3 && map.of_light[3] == 5 && map.of_sky == 7,
       "each holds its own, though a node holds a bulb and a light");
    must(groups_to_header(&groups, &header));
    must(groups_from_header(&again, &header));
    must(groups_resolve(&again, scene, &way, &map_again));
    ok(same_map(&map, &map_again), "and the header says so");
    group_map_clear(&map), group_map_clear(&map_again);
    groups_clear(&groups), groups_clear(&again);
    header_clear(&header);
}

static void test_refused(void)
{
    ok(REFUSED("a: material=Blub", "g:1: ", "material=Blub", "material=Bulb",
               "material=\"My \\\"screen\\\" [1]\"", "point=\"Hall/Lamp 1\"", "spot-1", "sky"),
       "a name of nothing that shines, with what there is");
    ok(REFUSED("a: material=shade", "nothing that shines") &&
           REFUSED("a: sun-1", "sun-1: nothing", "sun-2") &&
           REFUSED("a: spot-9", "spot-9: nothing"),
       "nor is a dark material, or a light of another number or kind");
    ok(REFUSED("a: sky\nb: sky", "g:2: ", "the sky is in two groups, 'a' and 'b'") &&
           REFUSED("a: point\nb: light=Lamp*", "point=Hall/Lamp 1 is in two groups") &&
           REFUSED("a: material=Bulb\nb: emissive=Lamp*",
                   "material=Bulb is in two groups, 'a' and 'b'"),
       "a light is in one group");
    ok(REFUSED("", "expected groups", "got none") && REFUSED("# a: sky\n\n", "got none"),
       "a file without groups is none");
    ok(REFUSED("sky\n", "g:1: expected NAME: TERM") && REFUSED("a:\n", "expected what is in it") &&
           REFUSED("a: sku", "got 'sku'") && REFUSED("a: light=", "behind light=") &&
           REFUSED("a: light=\"x", "a quote that does not end") && REFUSED("a: sky=x", "'sky=x'") &&
           REFUSED("a: light", "got 'light'"),
       "lines of another kind");
    ok(REFUSED("A: sky", "a-z") && REFUSED("a b: sky", "NAME: TERM") && REFUSED(": sky", "''") &&
           REFUSED("error: sky", "sh_error") && REFUSED("gradient_x: sky", "another") &&
           REFUSED("rest: sky", "no line names") && REFUSED("a: sky\na: point", "there already") &&
           REFUSED("a234567890123456789012345678901234567890123456x: sky", "at most 46"),
       "names that no column may have, or two groups");
}

static void test_rest_alone(void)
{
    struct scene *lit = scene;
    must(scene_create(&scene));
    must(scene_finish(scene, NULL, NULL));
    const struct groups_way none = {0};
    struct light_groups groups = {0};
    struct group_map map;
    must(groups_read(&groups, "each"));
    struct error *err = groups_resolve(&groups, scene, &none, &map);
    ok(err && strstr(error_message(err), "no light in the scene"), "no light, no group");
    error_destroy(err);
    group_map_clear(&map);
    files_write("g", "a: sky\n");
    must(groups_read(&groups, files_path("g")));
    err = groups_resolve(&groups, scene, &none, &map);
    ok(err && strstr(error_message(err), "no light in the scene"), "nor by a file");
    error_destroy(err);
    group_map_clear(&map);
    const struct groups_way lenient = {.lenient = true};
    must(groups_resolve(&groups, scene, &lenient, &map));
    ok(map.count == 1 && map.of_sky == GROUP_NONE, "but where names may match nothing");
    group_map_clear(&map);
    groups_clear(&groups);
    scene_destroy(scene);
    scene = lit;
}

static float emission_of(size_t instance)
{
    const struct scene_mesh *mesh = &scene->meshes[scene->instances[instance].mesh];
    return scene->materials[mesh->material[0]].emission.z;
}

static void test_scale(void)
{
    struct light_groups groups = {0};
    struct group_map map;
    must(groups_of("one: light=Lamp*1\ntwo: light=Lamp*2\nday: sun-2 sky", &groups, &map));
    const double weight[] = {2, 2, 2, 0, 0, 0, 1, -2, 1, -1, 3, -3};
    const uint64_t key = scene_key(scene);
    must(groups_scale(scene, &map, weight, GROUPS_ADDED));
    ok(emission_of(0) == 6 && emission_of(1) == 0 && emission_of(2) == 0,
       "surfaces of one mesh are scaled by themselves: %g %g %g", (double)emission_of(0),
       (double)emission_of(1), (double)emission_of(2));
    ok(scene->lights[0].intensity[1] == 4 && scene->lights[1].intensity[1] == 0 &&
           scene->lights[2].intensity[1] == 6 && scene->lights[2].intensity[0] == 0 &&
           scene->lights[4].intensity[0] == 5 && scene->sky.radiance[1] == 0,
       "so are lights and the sky; what is taken away is not there");
    ok(scene_key(scene) == key, "the scene keeps its key");
    group_map_clear(&map);
    scene_destroy(scene);
    make_scene();
    must(groups_resolve(&groups, scene, &way, &map));
    must(groups_scale(scene, &map, weight, GROUPS_TAKEN));
    ok(scene->sky.radiance[1] == 1 && emission_of(0) == 0 && emission_of(2) == 36 &&
           scene->lights[2].intensity[1] == 0 && scene->lights[2].intensity[2] == 9,
       "what is taken away is a light of its own");
    group_map_clear(&map);
    groups_clear(&groups);
}

int main(void)
{
    files_begin();
    make_scene();
    test_file();
    test_each();
    test_refused();
    test_rest_alone();
    test_scale();
    scene_destroy(scene);
    files_end();
    return tap_done();
}
