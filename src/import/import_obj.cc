/* SPDX-License-Identifier: Apache-2.0 */
/* OBJ and MTL, read by tinyobjloader.
 *
 * tinyobjloader takes a clean file. What real files hold and it stumbles over is set right line by
 * line before it sees the text (obj_clean, mtl_clean); each case says what the library (2.0.0rc9)
 * would make of it.
 */
extern "C" {
#include "base/number.h"
}
#include "import/import.h"

#define TINYOBJLOADER_USE_DOUBLE
#include <tiny_obj_loader.h>

#include <algorithm>
#include <cstdlib>
#include <istream>
#include <map>
#include <memory>
#include <set>
#include <streambuf>
#include <string>
#include <string_view>
#include <strings.h>
#include <vector>

namespace
{

using std::string;
using std::string_view;

const char blanks[] = " \t\f\v\r";
const double unstated = -1; /* what no file means by Kd or Ke */
const float default_albedo = 0.8f;

/* A string as a stream, without a copy. */
struct string_stream : private std::streambuf, public std::istream {
    explicit string_stream(string &text) : std::istream(this)
    {
        setg(&text[0], &text[0], &text[0] + text.size());
    }
};

/* -- lines and words -------------------------------------------------------------------------- */

string_view trimmed(string_view s)
{
    const size_t first = s.find_first_not_of(blanks);
    return first == s.npos ? string_view()
                           : s.substr(first, s.find_last_not_of(blanks) - first + 1);
}

/* Takes the first word off a line. */
string_view take_word(string_view &line)
{
    line = trimmed(line);
    const string_view word = line.substr(0, line.find_first_of(blanks));
    line = trimmed(line.substr(word.size()));
    return word;
}

bool equal_but_case(string_view a, const char *b)
{
    return a.size() == strlen(b) && !strncasecmp(a.data(), b, a.size());
}

/* The part of a line of names before a comment: # at its start, or after a blank. */
string_view without_comment(string_view line)
{
    for (size_t at = line.find('#'); at != line.npos; at = line.find('#', at + 1))
        if (at == 0 || strchr(blanks, line[at - 1]))
            return trimmed(line.substr(0, at));
    return line;
}

/* The same of a line of numbers, where the comment may follow a digit (but 1.#INF is no
 * comment). */
string_view numbers_without_comment(string_view line)
{
    const size_t at = line.find('#');
    return at == line.npos || (at > 0 && line[at - 1] == '.') ? line : trimmed(line.substr(0, at));
}

bool is_number(string_view s)
{
    size_t i = !s.empty() && (s[0] == '+' || s[0] == '-'), digits = 0;
    for (; i < s.size() && isdigit((unsigned char)s[i]); i++)
        digits++;
    if (i < s.size() && s[i] == '.')
        for (i++; i < s.size() && isdigit((unsigned char)s[i]); i++)
            digits++;
    if (digits && i < s.size() && (s[i] == 'e' || s[i] == 'E')) {
        i += i + 1 < s.size() && (s[i + 1] == '+' || s[i + 1] == '-') ? 2 : 1;
        digits = 0;
        for (; i < s.size() && isdigit((unsigned char)s[i]); i++)
            digits++;
    }
    return digits && i == s.size();
}

/* Whether one of the first words of a line, at most `most`, is nan, inf or one of their kind. */
bool has_not_finite(string_view line, size_t most)
{
    for (; most > 0; most--) {
        const string_view word = take_word(line);
        double value = 0;
        if (!word.empty() && !is_number(word) &&
            scene_import_number(word.data(), word.data() + word.size(), &value) ==
                word.data() + word.size() &&
            !std::isfinite(value))
            return true;
    }
    return false;
}

size_t count_words(string_view line)
{
    size_t count = 0;
    while (!take_word(line).empty())
        count++;
    return count;
}

/* Takes the numbers that a line begins with, at most `most`. */
std::vector<string_view> take_numbers(string_view &line, size_t most)
{
    std::vector<string_view> numbers;
    while (numbers.size() < most) {
        string_view rest = line;
        const string_view word = take_word(rest);
        if (!is_number(word))
            break;
        numbers.push_back(word);
        line = rest;
    }
    return numbers;
}

/* What programs of Windows may make of a text. */
struct error *check_encoding(const char *text, size_t size)
{
    const string_view mark = string_view(text, size).substr(0, 2);
    return mark == "\xff\xfe" || mark == "\xfe\xff"
               ? error_new("a text in UTF-16, expected ASCII or UTF-8")
               : nullptr;
}

/* A text line by line. Lines end with \n, \r or both; a backslash at the end, with blanks behind it
 * or without, joins the next line, which tinyobjloader takes for a new statement; but not that of
 * a comment, which may be the name of a folder. A byte order mark, which hides the first statement
 * from it, is skipped. */
class lines
{
  public:
    lines(const char *text, size_t size)
    {
        scene_import_bare(&text, &size);
        rest = string_view(text, size);
    }

    bool next(string_view &line)
    {
        if (rest.empty())
            return false;
        first = taken + 1;
        line = take();
        if (!goes_on(line) || trimmed(line)[0] == '#')
            return true;
        joined.clear();
        for (; goes_on(line); line = rest.empty() ? string_view() : take())
            joined.append(line.substr(0, line.rfind('\\'))).push_back(' ');
        line = joined.append(line);
        return true;
    }

    /* of the newest line, from 1 */
    size_t number() const { return first; }

    /* whether the newest line is the last, and nothing ends it */
    bool is_cut() const { return rest.empty() && !ended; }

  private:
    static bool goes_on(string_view line)
    {
        line = trimmed(line);
        return !line.empty() && line.back() == '\\';
    }

    string_view take()
    {
        taken++;
        const size_t end = std::min(rest.find_first_of("\r\n"), rest.size());
        const string_view line = rest.substr(0, end);
        const size_t newline = rest.substr(end, 2) == "\r\n" ? 2 : 1;
        ended = end < rest.size();
        rest.remove_prefix(std::min(end + newline, rest.size()));
        return line;
    }

    string_view rest;
    string joined;
    size_t first = 0, taken = 0;
    bool ended = false;
};

/* -- MTL -------------------------------------------------------------------------------------- */

struct materials {
    std::vector<tinyobj::material_t> list;
    std::vector<string> directory; /* of the MTL file of each, as its OBJ names it */
    std::map<string, int> by_name; /* the first of each name */
    std::set<string> files;        /* read so far */
    string missing;                /* the names of those that are not there */
};

/* The options before a texture's name and the name. -s, -o and -t may have one to three numbers:
 * tinyobjloader always takes three words, and the name with them. Quotes around the name are none
 * of it. */
void clean_map(string &out, string_view line)
{
    static const char *const plain[] = {"-blendu",  "-blendv", "-boost",      "-bm",   "-clamp",
                                        "-imfchan", "-texres", "-colorspace", "-type", "-mm"};
    for (;;) {
        string_view rest = line;
        const string_view option = take_word(rest);
        const bool scale = option == "-s";
        size_t arguments = 0;
        for (const char *name : plain)
            if (option == name)
                arguments = option == "-mm" ? 2 : 1;
        if (!arguments && !scale && option != "-o" && option != "-t")
            break;
        out.append(option).push_back(' ');
        if (arguments) {
            for (; arguments > 0; arguments--)
                out.append(take_word(rest)).push_back(' ');
        } else {
            const std::vector<string_view> numbers = take_numbers(rest, 3);
            for (size_t i = 0; i < 3; i++)
                out.append(i < numbers.size() ? numbers[i] : scale ? "1" : "0").push_back(' ');
        }
        line = rest;
    }
    if (line.size() >= 2 && line.front() == '"' && line.back() == '"')
        line = line.substr(1, line.size() - 2);
    out.append(line).push_back('\n');
}

/* An MTL file that is read. */
struct mtl {
    struct scene_import *import;
    const char *path;
    size_t line;
    string material; /* the newest */
};

/* A colour: tinyobjloader reads one number as red alone, and words (spectral, nan) as 0. */
struct error *clean_colour(string &out, string_view key, string_view line, const mtl &m)
{
    string_view rest = line;
    const std::vector<string_view> n = take_numbers(rest, 3);
    const string_view word = take_word(rest);
    if (n.empty() && (word == "spectral" || word == "xyz")) {
        warnings_add(m.import->warnings, "colour not understood",
                     "%s: material '%s': %.*s %.*s is no RGB: ignored", m.import->path,
                     m.material.c_str(), (int)key.size(), key.data(), (int)word.size(),
                     word.data());
        return nullptr;
    }
    if (n.size() != 1 && n.size() != 3)
        return scene_import_broken(m.import, "colour not understood", 0,
                                   "%s:%zu: material '%.60s': %.*s: expected one or three numbers, "
                                   "got '%.*s'",
                                   m.path, m.line, m.material.c_str(), (int)key.size(), key.data(),
                                   (int)std::min<size_t>(line.size(), 60), line.data());
    out.append(key).push_back(' ');
    out.append(n[0]).push_back(' ');
    out.append(n[n.size() / 2]).push_back(' ');
    out.append(n[n.size() - 1]).push_back('\n');
    return nullptr;
}

/* What the newest material of an MTL file says of how opaque it is; NaN: nothing. */
struct opacity {
    double d = NAN, tr = NAN;
};

/* Keeps d or Tr, and says where both are there and contradict each other: tinyobjloader takes d. */
void clean_opacity(string &out, const string &key, string_view number, opacity &stated,
                   const mtl &m)
{
    double value = 0;
    out += key + " " + string(number) + "\n";
    if (number_read_f64(number.data(), number.data() + number.size(), &value))
        (key == "d" ? stated.d : stated.tr) = value;
    if (std::fabs(stated.d + stated.tr - 1) > 0.01)
        warnings_add(m.import->warnings, "d against Tr",
                     "%s: material '%.60s' has d %g and Tr %g, of which the sum should be 1: d is "
                     "used, by Tr it would be %g opaque",
                     m.import->path, m.material.c_str(), stated.d, stated.tr, 1 - stated.tr);
}

/* Keeps the statements that we use, in one spelling. Each material begins with colours that no file
 * means, so that what is not stated can be told apart: tinyobjloader gives 0, or 0.6 with a
 * texture, or neither after a material that had Kd. */
struct error *mtl_clean(const char *text, size_t size, mtl &m, string &out)
{
    static const char *const keys[] = {"newmtl", "Kd",     "Ke",     "d",
                                       "Tr",     "map_Kd", "map_Ke", "map_d"};
    struct error *err = nullptr;
    opacity stated;
    lines reader(text, size);
    for (string_view line; !err && reader.next(line);) {
        const string_view word = take_word(line);
        string key;
        m.line = reader.number();
        for (const char *name : keys)
            if (equal_but_case(word, name))
                key = name;
        if (key == "newmtl") {
            m.material = line.empty() ? "(nameless)" : string(line);
            stated = opacity();
            out += "newmtl " + m.material + "\nKd -1 -1 -1\nKe -1 -1 -1\n";
        } else if (key == "Kd" || key == "Ke") {
            err = clean_colour(out, key, line, m);
        } else if (key == "d" || key == "Tr") {
            string_view rest = line;
            if (take_word(rest) == "-halo") /* tinyobjloader reads it as 0 */
                line = rest;
            const std::vector<string_view> numbers = take_numbers(line, 1);
            if (!numbers.empty())
                clean_opacity(out, key, numbers[0], stated, m);
            else
                err = scene_import_broken(m.import, "opacity not understood", 0,
                                          "%s:%zu: material '%.60s': %s: expected a number, got "
                                          "'%.*s'",
                                          m.path, m.line, m.material.c_str(), key.c_str(),
                                          (int)std::min<size_t>(line.size(), 60), line.data());
        } else if (!key.empty() && !line.empty()) {
            out += key + " ";
            clean_map(out, line);
        }
    }
    return err;
}

/* Reads one MTL file; *found says whether there is one of this name. */
struct error *mtl_read(struct scene_import *import, const string &name, materials &all, bool *found)
{
    *found = all.files.count(name) > 0;
    if (*found)
        return nullptr;
    char *path = nullptr, *text = nullptr;
    size_t size = 0;
    struct error *err = scene_import_find(import, name.c_str(), &path);
    const std::unique_ptr<char, decltype(&free)> path_owner(path, free);
    if (err || !path)
        return err;
    struct error *unread = file_read(path, &text, &size);
    const std::unique_ptr<char, decltype(&free)> text_owner(text, free);
    if (unread && !error_is_of_data(unread))
        return error_wrap(unread, "material file %s", path);
    if (unread) {
        all.files.insert(name);
        *found = true;
        err = scene_import_broken(import, "material file unreadable", 0, "material file %s: %s",
                                  path, error_message(unread));
        error_destroy(unread);
        return err;
    }
    err = error_wrap(check_encoding(text, size), "%s", path);
    if (err)
        return err;
    scene_import_warn_end(import, path, text, size);
    mtl cleaned = {import, path, 0, {}};
    string clean, warning, error;
    err = mtl_clean(text, size, cleaned, clean);
    if (err)
        return err;
    string_stream stream(clean);
    const size_t known = all.list.size();
    tinyobj::LoadMtl(&all.by_name, &all.list, &stream, &warning, &error);
    const size_t slash = name.find_last_of("/\\");
    all.directory.resize(all.list.size(),
                         slash == name.npos ? string() : name.substr(0, slash + 1));
    for (size_t i = known; i < all.list.size(); i++) {
        const string &material = all.list[i].name;
        if (all.by_name[material] != (int)i)
            warnings_add(import->warnings, "material defined twice",
                         "%s: material '%s' is defined twice: the first is used", import->path,
                         material.c_str());
        all.by_name.insert({string(without_comment(material)), (int)i});
    }
    if (cleaned.material.empty())
        all.missing += (all.missing.empty() ? "" : ", ") + name + " (it holds none)";
    all.files.insert(name);
    *found = true;
    return nullptr;
}

/* Reads what one mtllib statement names: one file whose name may hold blanks and backslashes, or
 * several (tinyobjloader splits at blanks, drops backslashes, and takes the first file alone). */
struct error *mtl_read_all(struct scene_import *import, string_view names, materials &all)
{
    string_view line = without_comment(names);
    if (line.size() > 1 && line.front() == '"' && line.back() == '"')
        line = line.substr(1, line.size() - 2);
    bool found = false;
    struct error *err = mtl_read(import, string(names), all, &found);
    if (!err && !found)
        err = mtl_read(import, string(line), all, &found);
    while (!err && !found && !line.empty()) {
        const string name(take_word(line));
        bool there = false;
        err = mtl_read(import, name, all, &there);
        if (!err && !there)
            all.missing += (all.missing.empty() ? "" : ", ") + name;
    }
    return err;
}

/* -- materials -------------------------------------------------------------------------------- */

bool is_stated(const double colour[3])
{
    return !(colour[0] == unstated && colour[1] == unstated && colour[2] == unstated);
}

struct vec3f to_colour(const double c[3])
{
    return {(float)c[0], (float)c[1], (float)c[2]};
}

/* The name under which a texture is found: beside its MTL file, beside the OBJ file, or either
 * without a comment behind it. */
struct error *find_texture(struct scene_import *import, const string &directory, const string &name,
                           string *found)
{
    const string bare(without_comment(name));
    const string tries[] = {directory + name, name, directory + bare, bare};
    *found = name;
    for (const string &attempt : tries) {
        char *path = nullptr;
        struct error *err = scene_import_find(import, attempt.c_str(), &path);
        const bool there = path != nullptr;
        free(path);
        if (err)
            return err;
        if (there) {
            *found = attempt;
            break;
        }
    }
    return nullptr;
}

struct error *to_map(struct scene_import *import, const string &directory, const string &name,
                     const tinyobj::texture_option_t &options, enum image_use use,
                     struct scene_map *map)
{
    *map = scene_map_of(SCENE_NONE);
    if (name.empty())
        return nullptr;
    if (options.brightness != 0 || options.contrast != 1 || options.turbulence[0] != 0 ||
        options.turbulence[1] != 0)
        warnings_add(import->warnings, "texture option",
                     "%s: texture %s: options -mm and -t are ignored", import->path, name.c_str());
    const enum scene_wrap wrap = options.clamp ? SCENE_CLAMP : SCENE_REPEAT;
    const struct scene_sampler sampler = {wrap, wrap, false};
    string found;
    struct error *err = find_texture(import, directory, name, &found);
    if (!err)
        err = scene_import_texture(import, found.c_str(), use, sampler, &map->texture);
    map->transform[0] = (float)options.scale[0];
    map->transform[2] = (float)options.origin_offset[0];
    map->transform[4] = (float)options.scale[1];
    map->transform[5] = (float)options.origin_offset[1];
    return err;
}

/* What exporters write without meaning it, and what makes things black. */
void warn_material(struct scene_import *import, const struct scene_material &m, const string &name)
{
    if (m.albedo_map.texture != SCENE_NONE && !(vec3f_most(m.albedo) > 0))
        warnings_add(import->warnings, "Kd 0 with a picture",
                     "%s: material '%.60s': Kd 0 times its picture map_Kd is black: without the "
                     "line, or as Kd 1 1 1, the picture is seen",
                     import->path, name.c_str());
    if (m.emission_map.texture != SCENE_NONE && !scene_emits(&m))
        warnings_add(import->warnings, "Ke 0 with a picture",
                     "%s: material '%.60s': Ke 0 times its picture map_Ke is dark: without the "
                     "line, or as Ke 1 1 1, it shines",
                     import->path, name.c_str());
}

struct error *push_material(struct scene_import *import, const tinyobj::material_t &from,
                            const string &directory, int32_t *index)
{
    struct scene_material m = scene_material_default();
    struct error *err = to_map(import, directory, from.diffuse_texname, from.diffuse_texopt,
                               IMAGE_COLOUR, &m.albedo_map);
    if (!err)
        err = to_map(import, directory, from.emissive_texname, from.emissive_texopt, IMAGE_COLOUR,
                     &m.emission_map);
    if (!err)
        err = to_map(import, directory, from.alpha_texname, from.alpha_texopt, IMAGE_MASK,
                     &m.alpha_map);
    if (err)
        return err;
    const float albedo = m.albedo_map.texture == SCENE_NONE ? default_albedo : 1;
    const float emission = m.emission_map.texture == SCENE_NONE ? 0 : 1;
    m.albedo = is_stated(from.diffuse) ? to_colour(from.diffuse) : vec3f{albedo, albedo, albedo};
    m.emission = is_stated(from.emission) ? to_colour(from.emission)
                                          : vec3f{emission, emission, emission};
    m.opacity = (float)from.dissolve;
    if (m.opacity < 1)
        m.alpha = SCENE_BLEND;
    else if (m.alpha_map.texture != SCENE_NONE)
        m.alpha = SCENE_CUTOUT;
    warn_material(import, m, from.name);
    scene_import_warn_hidden(import, &m, from.name.c_str());
    m.name = strdup(from.name.c_str());
    return m.name ? scene_push_material(import->scene, m, index) : error_memory();
}

/* -- OBJ -------------------------------------------------------------------------------------- */

const uint32_t nowhere = UINT32_MAX; /* an index that no array has */

/* What tinyobjloader's callbacks gather. */
struct geometry {
    struct scene_import *import;
    const materials *all;
    std::vector<double> position;
    std::vector<float> texture; /* (u, v) */
    std::vector<uint32_t> size, corner, corner_texture;
    std::vector<int32_t> material;      /* of each face: index into materials::list, or -1 */
    std::vector<uint32_t> line;         /* of the file, of each face */
    std::vector<struct scene_run> runs; /* objects and groups, by face */
    std::map<std::pair<uint32_t, string>, uint32_t> parts; /* by what they hang from, and name */
    uint32_t object = 0;
    int32_t current = -1;
    struct scene_colours colour = {};           /* of vertices; owned */
    bool points_or_lines = false, ended = true; /* there are some; the last line has an end */
    string idle;                                /* of the last usemtl, where no face follows it */
    std::map<string, size_t> unknown;           /* statements, and how often they are there */
    std::set<string> undefined;                 /* materials that faces are to have */
    ~geometry() { scene_colours_clear(&colour); }
};

/* The faces that follow belong to an object or to a group (one or several: "g wall north"). */
struct error *begin_part(geometry &g, enum scene_part_kind kind, string_view name)
{
    if (kind == SCENE_OBJECT)
        g.object = 0;
    uint32_t part = g.object;
    if (!name.empty()) {
        uint32_t &known = g.parts[{g.object, (kind == SCENE_OBJECT ? "o " : "g ") + string(name)}];
        if (!known)
            if (struct error *err =
                    scene_push_part(g.import->scene, kind, string(name).c_str(), g.object, &known))
                return err;
        part = known;
    }
    if (kind == SCENE_OBJECT)
        g.object = part;
    g.runs.push_back({g.line.size(), part});
    return nullptr;
}

void add_position(void *data, double x, double y, double z, double)
{
    std::vector<double> &to = static_cast<geometry *>(data)->position;
    to.insert(to.end(), {x, y, z});
}

void add_texture(void *data, double u, double v, double)
{
    std::vector<float> &to = static_cast<geometry *>(data)->texture;
    to.insert(to.end(), {(float)u, (float)v});
}

/* From 1 up, or from -1 down counting back from what was read so far; 0 is none. */
uint32_t absolute(int index, size_t count)
{
    if (index > 0)
        return (uint32_t)index - 1;
    return index < 0 && (size_t) - (long)index <= count ? (uint32_t)(count - (size_t) - (long)index)
                                                        : nowhere;
}

void add_face(void *data, tinyobj::index_t *indices, int count)
{
    geometry &g = *static_cast<geometry *>(data);
    for (int i = 0; i < count; i++) {
        g.corner.push_back(absolute(indices[i].vertex_index, g.position.size() / 3));
        g.corner_texture.push_back(absolute(indices[i].texcoord_index, g.texture.size() / 2));
    }
    g.size.push_back((uint32_t)count);
    g.material.push_back(g.current);
}

void use_material(void *data, const char *name, int)
{
    geometry &g = *static_cast<geometry *>(data);
    std::map<string, int>::const_iterator at = g.all->by_name.find(name);
    if (at == g.all->by_name.end())
        at = g.all->by_name.find(string(without_comment(name)));
    g.current = at == g.all->by_name.end() ? -1 : at->second;
    if (g.current < 0 && g.all->missing.empty())
        warnings_add(g.import->warnings, "material missing",
                     "%s: material '%s' is not defined: an albedo of 0.8 is used", g.import->path,
                     name);
    if (g.current < 0)
        g.undefined.insert(name);
}

/* What is wrong with the face of a last line that nothing ends: too few corners, or a last one that
 * has not what the others have. */
bool is_cut_face(string_view line)
{
    const size_t corners = count_words(line);
    const string_view first = take_word(line), last = line.substr(line.find_last_of(blanks) + 1);
    return corners < 3 ||
           std::count(first.begin(), first.end(), '/') !=
               std::count(last.begin(), last.end(), '/') ||
           (last.back() == '/') != (first.back() == '/');
}

/* Statements that say nothing of triangles and their materials, and those of free forms, whose
 * surfaces and curves are warned of. */
bool is_known(string_view word)
{
    static const char *const known[] = {
        "vn",       "vp",       "s",          "mg",        "lod",   "usemap", "maplib", "bevel",
        "c_interp", "d_interp", "shadow_obj", "trace_obj", "ctech", "stech",  "cstype", "deg",
        "bmat",     "step",     "parm",       "trim",      "hole",  "scrv",   "sp",     "end",
        "con",      "csh",      "bsp",        "bzp",       "cdc",   "cdp",    "res"};
    for (const char *name : known)
        if (word == name)
            return true;
    return word.empty() || word[0] == '#';
}

/* Some words are enough to show what a file is that is no OBJ. */
void count_unknown(geometry &g, string_view word)
{
    string name(word.substr(0, 40));
    for (char &c : name)
        c = iscntrl((unsigned char)c) ? '?' : c;
    if (g.unknown.size() < 100 || g.unknown.count(name))
        g.unknown[name]++;
}

/* v, v/t, v//n or v/t/n of whole numbers; v/, v/t/ as some write them. */
bool is_corner(string_view word)
{
    size_t slashes = 0, digits = 0;
    for (size_t i = 0; i < word.size(); i++) {
        const bool sign = (word[i] == '-' || word[i] == '+') && (i == 0 || word[i - 1] == '/');
        slashes += word[i] == '/';
        digits += isdigit((unsigned char)word[i]) != 0;
        if (!sign && word[i] != '/' && !isdigit((unsigned char)word[i]))
            return false;
    }
    return slashes <= 2 && digits > 0;
}

/* A face's line. What is no corner, which tinyobjloader reads as far as it goes, and indices of
 * more than nine digits, which it wraps round, become 0: no vertex. A slash at the end of a corner
 * goes: tinyobjloader takes the next corner for what should follow it. */
void clean_face(string &out, string_view line)
{
    out += "f";
    for (string_view word; !(word = take_word(line)).empty();) {
        out.push_back(' ');
        if (!is_corner(word))
            word = "0";
        for (size_t i = 0, digits = 0; i < word.size(); i++) {
            digits = isdigit((unsigned char)word[i]) ? digits + 1 : 0;
            out.push_back(word[i]);
            if (digits > 9)
                out.replace(out.size() - digits, digits, digits, '0');
        }
        while (out.back() == '/')
            out.pop_back();
    }
    out.push_back('\n');
}

/* Keeps the colour that stands behind the coordinates of vertex i; of seven numbers, the last is a
 * weight or an alpha that no two programs agree on. */
struct error *keep_colour(geometry &g, size_t i, const std::vector<string_view> &numbers)
{
    double rgba[4] = {0, 0, 0, -1};
    for (size_t k = 0; k < 3; k++)
        if (!number_read_f64(numbers[3 + k].data(), numbers[3 + k].data() + numbers[3 + k].size(),
                             &rgba[k]))
            return nullptr;
    return scene_colours_set(&g.colour, i, rgba);
}

/* ZBrush's polypaint, in a comment: mask, red, green and blue of one vertex after the other, two
 * hexadecimal digits each. */
struct error *keep_paint(geometry &g, size_t &painted, string_view digits)
{
    struct error *err = nullptr;
    for (size_t at = 0; at + 8 <= digits.size() && !err; at += 8) {
        double rgba[4] = {0, 0, 0, -1};
        for (size_t k = 0; k < 3; k++)
            rgba[k] =
                (double)strtoul(string(digits.substr(at + 2 + 2 * k, 2)).c_str(), nullptr, 16) /
                255;
        err = scene_colours_set(&g.colour, painted++, rgba);
    }
    return err;
}

/* Keeps the statements that we use, without comments, which tinyobjloader takes for corners; reads
 * the material files. A vertex that is not three numbers, which it would put at 0, goes to
 * infinity: its triangles are left out and counted. */
struct error *obj_clean(const char *text, size_t size, geometry &g, materials &all, string &out)
{
    struct scene_import *const import = g.import;
    struct error *err = nullptr;
    size_t vertices = 0, painted = 0;
    out.reserve(size);
    lines reader(text, size);
    for (string_view line; !err && reader.next(line);) {
        const string_view whole = numbers_without_comment(trimmed(line)), word = take_word(line);
        if (word == "v") {
            string_view rest = whole.substr(1);
            const std::vector<string_view> numbers = take_numbers(rest, 7);
            vertices++;
            if (numbers.size() >= 3) {
                out.append(whole).push_back('\n');
                if (numbers.size() >= 6)
                    err = keep_colour(g, vertices - 1, numbers);
                else if (numbers.size() == 5)
                    err = scene_import_broken(
                        import, "colour not understood", reader.number(),
                        "expected a vertex of 3 numbers, 4, or 6 with a colour, got '%.*s'",
                        (int)std::min<size_t>(whole.size(), 60), whole.data());
            } else if (has_not_finite(rest, 3)) { /* lost where a face has it, which is told then */
                out += "v 9e999 0 0\n";
            } else {
                out += "v 9e999 0 0\n";
                err = scene_import_broken(
                    import, "vertex not understood", reader.number(),
                    "expected a vertex of three numbers, got '%.*s': its faces are lost",
                    (int)std::min<size_t>(whole.size(), 60), whole.data());
            }
        } else if (word == "vt") {
            string_view rest = whole.substr(2);
            const bool finite = !has_not_finite(rest, 2);
            out.append(finite ? whole : "vt 0 0").push_back('\n');
            if (!finite)
                warnings_add(import->warnings, "texture coordinate not finite",
                             "%s:%zu: a texture coordinate is '%.*s': 0 0 is used", import->path,
                             reader.number(), (int)std::min<size_t>(rest.size(), 60), rest.data());
            else if (take_numbers(rest, 1).empty())
                err = scene_import_broken(import, "texture coordinate not understood",
                                          reader.number(),
                                          "expected a texture coordinate, got '%.*s'",
                                          (int)std::min<size_t>(whole.size(), 60), whole.data());
        } else if (word == "f" || word == "fo") {
            line = numbers_without_comment(line);
            clean_face(out, line);
            g.idle.clear();
            if (!line.empty()) /* tinyobjloader hands on no face without corners */
                g.line.push_back((uint32_t)reader.number());
            if (reader.is_cut() && is_cut_face(line))
                err = scene_import_broken(import, "file cut off", reader.number(),
                                          "the file is cut off in the face 'f %.*s'",
                                          (int)std::min<size_t>(line.size(), 60), line.data());
        } else if (word == "#MRGB") {
            err = keep_paint(g, painted, line);
        } else if (word == "usemtl") {
            out.append("usemtl ").append(line).push_back('\n');
            g.idle = line;
        } else if (word == "o" || word == "g") {
            err = begin_part(g, word == "o" ? SCENE_OBJECT : SCENE_GROUP, without_comment(line));
        } else if (word == "mtllib") {
            err = mtl_read_all(import, line, all);
        } else if (word == "p" || word == "l") {
            g.points_or_lines = true;
        } else if (word == "surf" || word == "curv" || word == "curv2") {
            warnings_add(import->warnings, "free-form geometry",
                         "%s: free-form curves and surfaces are left out", import->path);
            g.points_or_lines = true;
        } else if (word == "call") {
            err = scene_import_broken(import, "file called", reader.number(),
                                      "what is in the file %.*s is not read",
                                      (int)std::min<size_t>(line.size(), 60), line.data());
        } else if (!is_known(word)) {
            if (reader.is_cut())
                err = scene_import_broken(import, "file cut off", reader.number(),
                                          "the file is cut off in '%.*s'",
                                          (int)std::min<size_t>(whole.size(), 60), whole.data());
            else
                count_unknown(g, word);
        }
        g.ended = !reader.is_cut();
    }
    return err;
}

/* A file that is cut off at the end of a line is a good one. What its faces were for, is left. */
struct error *check_cut_off(const geometry &g)
{
    struct scene_import *const import = g.import;
    const size_t count = g.position.size() / 3;
    size_t used = 0;
    for (const uint32_t vertex : g.corner)
        used = vertex < count ? std::max<size_t>(used, vertex + size_t{1}) : used;
    const bool vertices = count - used >= 3 && !g.points_or_lines;
    if (!g.ended && (vertices || !g.idle.empty()))
        return scene_import_broken(
            import, "file cut off", 0, "the file is cut off: %s in the last line, which has no end",
            vertices ? "the last vertices belong to no face, and there is none"
                     : "no face follows the last usemtl, and there is none");
    if (vertices)
        warnings_add(import->warnings, "vertices without faces",
                     "%s: the last %zu of %zu vertices belong to no face: is the file cut off?",
                     import->path, count - used, count);
    if (!g.idle.empty())
        warnings_add(import->warnings, "material without faces",
                     "%s: no face follows the last 'usemtl %.60s': is the file cut off?",
                     import->path, g.idle.c_str());
    return nullptr;
}

/* A file of materials that is not there is borne, for many an OBJ comes without; but it says all of
 * colour and of light. */
void warn_missing(const geometry &g)
{
    if (!g.all->missing.empty())
        warnings_add(
            g.import->warnings, "material file missing",
            "%s: the materials of %s are missing: the colours, pictures and lamps of %zu of "
            "them are lost, an albedo of 0.8 is used",
            g.import->path, g.all->missing.c_str(), g.undefined.size());
}

/* Names the statements that OBJ has not. */
void warn_unknown(const geometry &g)
{
    string names;
    size_t count = 0;
    for (const std::pair<const string, size_t> &word : g.unknown) {
        count += word.second;
        if (names.size() < 100)
            names += (names.empty() ? "'" : ", '") + word.first + "'";
    }
    if (count)
        warnings_add(g.import->warnings, "statement unknown",
                     "%s: %zu lines that begin with %s are no statements of OBJ: left out",
                     g.import->path, count, names.c_str());
}

/* Materials that faces use become the scene's; face materials become its indices. */
struct error *push_materials(geometry &g)
{
    struct scene_import *import = g.import;
    std::map<int32_t, int32_t> pushed;
    for (int32_t &material : g.material) {
        const std::map<int32_t, int32_t>::const_iterator known = pushed.find(material);
        if (known != pushed.end()) {
            material = known->second;
            continue;
        }
        int32_t index = 0;
        struct error *err;
        if (material < 0) {
            struct scene_material none = scene_material_default();
            if (!g.colour.count)
                none.albedo = {default_albedo, default_albedo, default_albedo};
            err = scene_push_material(import->scene, none, &index);
        } else {
            err = push_material(import, g.all->list[(size_t)material],
                                g.all->directory[(size_t)material], &index);
        }
        if (err)
            return err;
        pushed[material] = index;
        material = index;
    }
    for (size_t i = 0; i < g.all->list.size(); i++) {
        const tinyobj::material_t &m = g.all->list[i];
        if (!pushed.count((int32_t)i) && is_stated(m.emission) &&
            std::max({m.emission[0], m.emission[1], m.emission[2]}) > 0)
            warnings_add(import->warnings, "light that nothing has",
                         "%s: material '%.60s' emits light, and no face has it", import->path,
                         m.name.c_str());
    }
    return nullptr;
}

/* Texture coordinates corner by corner; 0 where a corner has none. Empty when none has. */
struct error *corner_uv(const geometry &g, std::vector<float> &uv)
{
    struct error *err = nullptr;
    const size_t count = g.texture.size() / 2;
    if (count)
        uv.resize(2 * g.corner.size());
    for (size_t f = 0, i = 0; f < g.size.size() && count; f++) {
        const uint32_t *const first = g.corner_texture.data() + i;
        const auto without = std::count(first, first + g.size[f], nowhere);
        if (without && without < static_cast<ptrdiff_t>(g.size[f]))
            warnings_add(g.import->warnings, "texture coordinate left out",
                         "%s: a face has texture coordinates at some of its corners: at the others "
                         "they are 0",
                         g.import->path);
        for (const size_t end = i + g.size[f]; i < end && !err; i++) {
            const uint32_t from = g.corner_texture[i];
            if (from < count) {
                uv[2 * i] = g.texture[2 * (size_t)from];
                uv[2 * i + 1] = g.texture[2 * (size_t)from + 1];
            } else if (from != nowhere) {
                err = scene_import_broken(
                    g.import, "texture coordinate missing", f < g.line.size() ? g.line[f] : 0,
                    "a corner names texture coordinate %u of %zu", from + 1, count);
            }
        }
    }
    return err;
}

struct error *read(struct scene_import *import)
{
    materials all;
    geometry g;
    g.import = import;
    g.all = &all;
    {
        string clean;
        char *text = nullptr;
        size_t size = 0;
        scene_import_content(import, &text, &size);
        const std::unique_ptr<char, decltype(&free)> text_owner(text, free);
        struct error *err = check_encoding(text, size);
        scene_import_warn_end(import, import->path, text, size);
        if (!err)
            err = obj_clean(text, size, g, all, clean);
        if (err)
            return err;
        tinyobj::callback_t callbacks;
        callbacks.vertex_cb = add_position;
        callbacks.texcoord_cb = add_texture;
        callbacks.index_cb = add_face;
        callbacks.usemtl_cb = use_material;
        string_stream stream(clean);
        string warning, error;
        if (!tinyobj::LoadObjWithCallback(stream, callbacks, &g, nullptr, &warning, &error))
            return error_new("%s", error.c_str());
    }
    warn_missing(g);
    warn_unknown(g);
    struct error *err = check_cut_off(g);
    if (!err)
        err = push_materials(g);
    if (err)
        return err;
    std::vector<float> uv;
    err = corner_uv(g, uv);
    if (err)
        return err;
    struct scene_polygons polygons = {};
    polygons.position = g.position.data();
    polygons.vertex_count = g.position.size() / 3;
    polygons.size = g.size.data();
    polygons.count = g.size.size();
    polygons.corner = g.corner.data();
    polygons.uv = uv.empty() ? nullptr : uv.data();
    polygons.material = g.material.data();
    polygons.edges = true; /* of old Blenders */
    g.colour.unstated = 1;
    polygons.colour = &g.colour;
    if (g.line.size() == g.size.size()) {
        polygons.line = g.line.data();
        polygons.runs = g.runs.data();
        polygons.run_count = g.runs.size();
    }
    return scene_import_polygons(import, &polygons);
}

} /* namespace */

struct error *scene_read_obj(struct scene_import *import)
{
    return error_guard([import] { return read(import); });
}
