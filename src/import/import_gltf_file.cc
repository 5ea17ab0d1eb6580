/* SPDX-License-Identifier: Apache-2.0 */
/* A glTF or GLB file as it lies on the disk: its container, its JSON, and the buffers and pictures
 * that it names.
 *
 * tinygltf (2.7.0) makes structures of the JSON, and no more is asked of it. Where it reads other
 * data it goes past the end of a buffer for a picture, knows few media types of data: URIs, takes
 * "+" in a file's name for a blank, looks into the working directory, and wants a file to be
 * exactly as long as its buffer; and it recurses as deep as the JSON is nested. So the JSON is
 * looked at first: its depth is limited, the data that it names are fetched here, and what is of no
 * use is taken out.
 */
#include "import/import_gltf.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <set>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <nlohmann/json.hpp>
#pragma GCC diagnostic pop

namespace
{

using nlohmann::json;
using std::string;

const int most_depth = 200; /* of the JSON: files that are meant to be read stay below 20 */

/* Extensions that are honoured, or that change nothing that a diffuse bake sees. */
const char *const known_extensions[] = {"EXT_mesh_gpu_instancing",
                                        "EXT_texture_webp",
                                        "KHR_animation_pointer",
                                        "KHR_lights_punctual",
                                        "KHR_materials_anisotropy",
                                        "KHR_materials_clearcoat",
                                        "KHR_materials_dispersion",
                                        "KHR_materials_emissive_strength",
                                        "KHR_materials_ior",
                                        "KHR_materials_iridescence",
                                        "KHR_materials_pbrSpecularGlossiness",
                                        "KHR_materials_sheen",
                                        "KHR_materials_specular",
                                        "KHR_materials_transmission",
                                        "KHR_materials_unlit",
                                        "KHR_materials_variants",
                                        "KHR_materials_volume",
                                        "KHR_mesh_quantization",
                                        "KHR_node_visibility",
                                        "KHR_texture_transform",
                                        "KHR_xmp_json_ld"};

/* -- files and URIs --------------------------------------------------------------------------- */

/* What a C function gave: bytes to be freed. */
gltf_bytes keep(char *data, size_t size)
{
    return {std::shared_ptr<const void>(data, std::free),
            reinterpret_cast<const unsigned char *>(data), size};
}

int hex_digit(char c)
{
    const char *const digits = "0123456789abcdef", *const found = std::strchr(
                                                       digits, std::tolower((unsigned char)c));
    return c && found ? static_cast<int>(found - digits) : -1;
}

gltf_bytes read_file(const char *path)
{
    char *data = nullptr;
    size_t size = 0;
    gltf_check(file_read(path, &data, &size));
    return keep(data, size);
}

/* Percent-encoding undone; a percent sign that encodes nothing stays. */
string decode(const string &text)
{
    string out;
    for (size_t i = 0; i < text.size(); i++) {
        const bool room = text[i] == '%' && i + 2 < text.size();
        const int high = room ? hex_digit(text[i + 1]) : -1,
                  low = room ? hex_digit(text[i + 2]) : -1;
        out += high < 0 || low < 0 ? text[i] : static_cast<char>(16 * high + low);
        i += high < 0 || low < 0 ? 0 : 2;
    }
    return out;
}

/* The path of the file of that name, or nothing. */
std::shared_ptr<char> find(const struct scene_import *import, const string &name)
{
    char *path = nullptr;
    gltf_check(scene_import_find(import, name.c_str(), &path));
    return std::shared_ptr<char>(path, std::free);
}

/* -- GLB -------------------------------------------------------------------------------------- */

uint32_t word_at(const gltf_bytes &bytes, size_t at)
{
    const unsigned char *b = bytes.data + at;
    return b[0] | uint32_t{b[1]} << 8 | uint32_t{b[2]} << 16 | uint32_t{b[3]} << 24;
}

/* Finds the JSON and the binary chunk (none: without data) of a GLB file; glTF 2.0, 4.4. */
void split_glb(const gltf_bytes &file, gltf_bytes &text, gltf_bytes &chunk)
{
    const uint32_t json_type = 0x4E4F534A, binary_type = 0x004E4942;
    const size_t length = file.size < 12 ? 12 : word_at(file, 8);
    if (length > file.size)
        gltf_fail(error_new("the file is cut off: it has %zu bytes of %zu", file.size, length));
    if (word_at(file, 4) != 2)
        gltf_fail(error_new("GLB of version %u, expected 2", (unsigned)word_at(file, 4)));
    text = {};
    for (size_t at = 12, number = 0; at + 8 <= length; number++) {
        const size_t size = word_at(file, at), type = word_at(file, at + 4);
        if (size > length - at - 8)
            gltf_fail(
                error_new("chunk %zu of %zu bytes reaches beyond the file's end", number, size));
        const gltf_bytes content = {file.owner, file.data + at + 8, size};
        if (number == 0 && type == json_type)
            text = content;
        else if (number == 1 && type == binary_type)
            chunk = content;
        at += 8 + size;
    }
    if (!text.data)
        gltf_fail(error_new("the file's first chunk is not JSON"));
}

/* -- JSON ------------------------------------------------------------------------------------- */

json parse(const gltf_bytes &text)
{
    const auto limit_depth = [](int depth, json::parse_event_t, json &) {
        if (depth > most_depth)
            gltf_fail(error_new("JSON that is nested more than %d deep", most_depth));
        return true;
    };
    try {
        return json::parse(text.data, text.data + text.size, limit_depth);
    } catch (const json::exception
                 &e) { /* "[json.exception.parse_error.101] parse error at line 1 ..." */
        const char *const behind = std::strchr(e.what(), ']');
        gltf_fail(error_new("JSON: %.200s", behind && behind[1] ? behind + 2 : e.what()));
    }
}

/* A member of an object, or nullptr. */
const json *member(const json &object, const char *name)
{
    const auto found = object.find(name);
    return found != object.end() ? &*found : nullptr;
}

/* A member that is text, or "". */
const string &text_of(const json &object, const char *name)
{
    static const string empty;
    const json *const value = member(object, name);
    return value && value->is_string() ? value->get_ref<const string &>() : empty;
}

/* A member that is a list, or an empty list. */
const json &list_of(const json &object, const char *name)
{
    static const json empty = json::array();
    const json *const value = member(object, name);
    return value && value->is_array() ? *value : empty;
}

void check_version(const json &document)
{
    const json *const asset = member(document, "asset");
    const string version = asset ? text_of(*asset, "version") : string();
    const string least = asset ? text_of(*asset, "minVersion") : string();
    if (version.empty())
        gltf_fail(error_new("not glTF: no asset.version"));
    if (version.compare(0, 2, "2.") != 0 || (!least.empty() && least != "2.0"))
        gltf_fail(error_new("glTF of version %.20s, expected 2.0",
                            (least.empty() ? version : least).c_str()));
}

bool is_known(const string &name)
{
    return std::any_of(std::begin(known_extensions), std::end(known_extensions),
                       [&name](const char *known) { return name == known; });
}

/* Names the extensions that a file uses and nobody here understands, those of light above all. */
void warn_extensions(const struct scene_import *import, const json &document)
{
    std::set<string> used;
    for (const json &name : list_of(document, "extensionsUsed"))
        if (name.is_string())
            used.insert(name.get<string>());
    const json *const own = member(document, "extensions");
    for (json::const_iterator at = own && own->is_object() ? own->begin() : json::const_iterator();
         own && own->is_object() && at != own->end(); ++at)
        used.insert(at.key());
    string lights, others;
    for (const string &name : used) {
        const bool light = name.find("light") != name.npos || name.find("environment") != name.npos;
        string &list = light ? lights : others;
        if (!is_known(name))
            list += (list.empty() ? "" : ", ") + name;
    }
    if (!lights.empty())
        warnings_add(import->warnings, "light of an unknown extension",
                     "%s: the light of the extension %.200s is not understood: it is left out "
                     "(--sky, --sun, --point and --spot add light)",
                     import->path, lights.c_str());
    if (!others.empty())
        warnings_add(import->warnings, "unknown extension",
                     "%s: what the extension %.200s says is not understood: it is left out",
                     import->path, others.c_str());
}

void check_extensions(const json &document)
{
    for (const json &required : list_of(document, "extensionsRequired")) {
        const string name = required.is_string() ? required.get<string>() : string();
        if (!is_known(name))
            gltf_fail(error_new("the file requires the extension %.60s, which is not supported",
                                name.c_str()));
    }
}

/* -- buffers and pictures --------------------------------------------------------------------- */

gltf_bytes fetch_buffer(const struct scene_import *import, const string &uri)
{
    if (gltf_is_data(uri))
        return gltf_data(uri);
    const string name = gltf_file_name(import, uri);
    const std::shared_ptr<char> path = find(import, name);
    if (!path)
        gltf_fail(error_new("%.200s is missing%s", name.c_str(),
                            *import->directory ? "" : " from the folder where the program runs"));
    try {
        return read_file(path.get());
    } catch (const gltf_error &e) {
        gltf_fail(error_wrap(e.err, "%.200s", name.c_str()));
    }
}

gltf_bytes read_buffer(const struct scene_import *import, const json &buffer,
                       const gltf_bytes &chunk)
{
    const json *const length = member(buffer, "byteLength");
    if (!length || !length->is_number_unsigned())
        gltf_fail(error_new("no byteLength"));
    const string &uri = text_of(buffer, "uri");
    if (uri.empty() && !chunk.data)
        gltf_fail(error_new("neither a URI nor a GLB file's binary chunk holds its bytes"));
    gltf_bytes bytes = uri.empty() ? chunk : fetch_buffer(import, uri);
    const uint64_t stated = length->get<uint64_t>();
    const string name = uri.empty()         ? "the binary chunk"
                        : gltf_is_data(uri) ? "its data: URI"
                                            : decode(uri);
    if (bytes.size < stated)
        gltf_fail(error_new("%.200s has %zu bytes, expected %llu", name.c_str(), bytes.size,
                            (unsigned long long)stated));
    bytes.size = static_cast<size_t>(stated);
    return bytes;
}

void read_buffers(const struct scene_import *import, const json &document, const gltf_bytes &chunk,
                  gltf_file &file)
{
    for (const json &buffer : list_of(document, "buffers")) {
        const size_t number = file.buffers.size();
        try {
            file.buffers.push_back(read_buffer(import, buffer, number == 0 ? chunk : gltf_bytes()));
        } catch (const gltf_error &e) {
            gltf_fail(error_wrap(e.err, "buffer %zu", number));
        }
    }
}

void list_pictures(const json &document, gltf_file &file)
{
    for (const json &image : list_of(document, "images")) {
        const json *const view = member(image, "bufferView");
        const bool whole = view && view->is_number_unsigned() && view->get<uint64_t>() < 1000000000;
        file.pictures.push_back({text_of(image, "uri"), whole ? view->get<int>() : -1});
    }
}

/* -- types ------------------------------------------------------------------------------------ */

enum type {
    INDEX,
    NUMBER,
    BOOLEAN,
    TEXT,
    OBJECT,
    NUMBERS,
    TWO,
    THREE, /* numbers at least */
    FOUR,
    INDICES,
    TEXTS,
    OBJECTS,
    TYPES
};

const char *const type_names[TYPES] = {"a whole number of 0 or more",
                                       "a number",
                                       "true or false",
                                       "text",
                                       "an object",
                                       "a list of numbers",
                                       "a list of 2 numbers",
                                       "a list of 3 numbers",
                                       "a list of 4 numbers",
                                       "a list of whole numbers of 0 or more",
                                       "a list of texts",
                                       "a list of objects"};

/* What glTF says of the members that a bake depends on; * is each member or element. */
struct rule {
    const char *path;
    enum type type;
};

const struct rule rules[] = {
    {"scene", INDEX},
    {"accessors", OBJECTS},
    {"accessors/*/bufferView", INDEX},
    {"accessors/*/byteOffset", INDEX},
    {"accessors/*/componentType", INDEX},
    {"accessors/*/count", INDEX},
    {"accessors/*/normalized", BOOLEAN},
    {"accessors/*/sparse", OBJECT},
    {"accessors/*/sparse/count", INDEX},
    {"accessors/*/sparse/indices", OBJECT},
    {"accessors/*/sparse/indices/bufferView", INDEX},
    {"accessors/*/sparse/indices/byteOffset", INDEX},
    {"accessors/*/sparse/indices/componentType", INDEX},
    {"accessors/*/sparse/values", OBJECT},
    {"accessors/*/sparse/values/bufferView", INDEX},
    {"accessors/*/sparse/values/byteOffset", INDEX},
    {"accessors/*/type", TEXT},
    {"bufferViews", OBJECTS},
    {"bufferViews/*/buffer", INDEX},
    {"bufferViews/*/byteLength", INDEX},
    {"bufferViews/*/byteOffset", INDEX},
    {"bufferViews/*/byteStride", INDEX},
    {"buffers", OBJECTS},
    {"buffers/*/byteLength", INDEX},
    {"buffers/*/uri", TEXT},
    {"extensions", OBJECT},
    {"extensions/KHR_lights_punctual", OBJECT},
    {"extensions/KHR_lights_punctual/lights", OBJECTS},
    {"extensions/KHR_lights_punctual/lights/*/color", THREE},
    {"extensions/KHR_lights_punctual/lights/*/intensity", NUMBER},
    {"extensions/KHR_lights_punctual/lights/*/name", TEXT},
    {"extensions/KHR_lights_punctual/lights/*/range", NUMBER},
    {"extensions/KHR_lights_punctual/lights/*/spot", OBJECT},
    {"extensions/KHR_lights_punctual/lights/*/spot/innerConeAngle", NUMBER},
    {"extensions/KHR_lights_punctual/lights/*/spot/outerConeAngle", NUMBER},
    {"extensions/KHR_lights_punctual/lights/*/type", TEXT},
    {"extensionsRequired", TEXTS},
    {"extensionsUsed", TEXTS},
    {"images", OBJECTS},
    {"images/*/bufferView", INDEX},
    {"images/*/uri", TEXT},
    {"materials", OBJECTS},
    {"materials/*/alphaCutoff", NUMBER},
    {"materials/*/alphaMode", TEXT},
    {"materials/*/doubleSided", BOOLEAN},
    {"materials/*/emissiveFactor", THREE},
    {"materials/*/extensions", OBJECT},
    {"materials/*/extensions/*", OBJECT},
    {"materials/*/extensions/KHR_materials_emissive_strength/emissiveStrength", NUMBER},
    {"materials/*/extensions/KHR_materials_pbrSpecularGlossiness/diffuseFactor", FOUR},
    {"materials/*/extensions/KHR_materials_transmission/transmissionFactor", NUMBER},
    {"materials/*/extensions/KHR_materials_transmission/transmissionTexture", OBJECT},
    {"materials/*/name", TEXT},
    {"materials/*/pbrMetallicRoughness", OBJECT},
    {"materials/*/pbrMetallicRoughness/baseColorFactor", THREE},
    {"meshes", OBJECTS},
    {"meshes/*/name", TEXT},
    {"meshes/*/primitives", OBJECTS},
    {"meshes/*/primitives/*/attributes", OBJECT},
    {"meshes/*/primitives/*/attributes/*", INDEX},
    {"meshes/*/primitives/*/indices", INDEX},
    {"meshes/*/primitives/*/material", INDEX},
    {"meshes/*/primitives/*/mode", INDEX},
    {"meshes/*/primitives/*/targets", OBJECTS},
    {"meshes/*/primitives/*/targets/*/*", INDEX},
    {"meshes/*/weights", NUMBERS},
    {"nodes", OBJECTS},
    {"nodes/*/children", INDICES},
    {"nodes/*/extensions", OBJECT},
    {"nodes/*/extensions/EXT_mesh_gpu_instancing", OBJECT},
    {"nodes/*/extensions/EXT_mesh_gpu_instancing/attributes", OBJECT},
    {"nodes/*/extensions/EXT_mesh_gpu_instancing/attributes/*", INDEX},
    {"nodes/*/extensions/KHR_lights_punctual", OBJECT},
    {"nodes/*/extensions/KHR_lights_punctual/light", INDEX},
    {"nodes/*/extensions/KHR_node_visibility", OBJECT},
    {"nodes/*/extensions/KHR_node_visibility/visible", BOOLEAN},
    {"nodes/*/matrix", NUMBERS},
    {"nodes/*/mesh", INDEX},
    {"nodes/*/name", TEXT},
    {"nodes/*/rotation", FOUR},
    {"nodes/*/scale", THREE},
    {"nodes/*/skin", INDEX},
    {"nodes/*/translation", THREE},
    {"nodes/*/weights", NUMBERS},
    {"samplers", OBJECTS},
    {"samplers/*/magFilter", INDEX},
    {"samplers/*/wrapS", INDEX},
    {"samplers/*/wrapT", INDEX},
    {"scenes", OBJECTS},
    {"scenes/*/nodes", INDICES},
    {"skins", OBJECTS},
    {"skins/*/inverseBindMatrices", INDEX},
    {"skins/*/joints", INDICES},
    {"textures", OBJECTS},
    {"textures/*/extensions", OBJECT},
    {"textures/*/extensions/EXT_texture_webp", OBJECT},
    {"textures/*/extensions/EXT_texture_webp/source", INDEX},
    {"textures/*/sampler", INDEX},
    {"textures/*/source", INDEX}};

/* What it says of a texture of a material, and where there are some. */
const struct rule texture_rules[] = {{"", OBJECT},
                                     {"/index", INDEX},
                                     {"/texCoord", INDEX},
                                     {"/extensions", OBJECT},
                                     {"/extensions/KHR_texture_transform", OBJECT},
                                     {"/extensions/KHR_texture_transform/offset", TWO},
                                     {"/extensions/KHR_texture_transform/rotation", NUMBER},
                                     {"/extensions/KHR_texture_transform/scale", TWO},
                                     {"/extensions/KHR_texture_transform/texCoord", INDEX}};

const char *const textures[] = {
    "materials/*/emissiveTexture", "materials/*/pbrMetallicRoughness/baseColorTexture",
    "materials/*/extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture"};

bool is_of_type(const json &value, enum type type)
{
    const auto all_are = [&value](enum type one) {
        return value.is_array() && std::all_of(value.begin(), value.end(),
                                               [one](const json &x) { return is_of_type(x, one); });
    };
    switch (type) {
    case INDEX:
        return value.is_number() && value.get<double>() >= 0 &&
               value.get<double>() == std::floor(value.get<double>());
    case NUMBER: return value.is_number();
    case BOOLEAN: return value.is_boolean();
    case TEXT: return value.is_string();
    case OBJECT: return value.is_object();
    case NUMBERS: return all_are(NUMBER);
    case TWO: return all_are(NUMBER) && value.size() >= 2;
    case THREE: return all_are(NUMBER) && value.size() >= 3;
    case FOUR: return all_are(NUMBER) && value.size() >= 4;
    case TEXTS: return all_are(TEXT);
    case INDICES: return all_are(INDEX);
    default: return all_are(OBJECT);
    }
}

/* Where a value of good JSON stands, by the names and numbers that lead to it. */
class walk
{
  public:
    explicit walk(const gltf_bytes &text)
        : first(reinterpret_cast<const char *>(text.data)), at(first), end(first + text.size)
    {
    }

    /* Goes into the object or list here; false: it has none of this name. */
    bool enter(const string &name)
    {
        skip_blanks();
        const bool object = at < end && *at == '{';
        if (at++ == end)
            return false;
        for (size_t i = 0; skip_blanks(), at < end && *at != '}' && *at != ']'; i++) {
            string own = std::to_string(i);
            if (object) {
                const char *const key = at;
                skip_value();
                own.assign(key + 1, std::max(at - 1, key + 1));
                skip_blanks();
                at += at < end; /* : */
            }
            skip_blanks();
            if (own == name)
                return true;
            skip_value();
            skip_blanks();
            at += at < end && *at == ',';
        }
        return false;
    }

    size_t line() const { return 1 + static_cast<size_t>(std::count(first, at, '\n')); }

  private:
    void skip_blanks()
    {
        while (at < end && std::strchr(" \t\r\n", *at))
            at++;
    }

    void skip_text()
    {
        for (at++; at < end && *at != '"'; at++)
            at += *at == '\\' && at + 1 < end;
        at += at < end;
    }

    void skip_value()
    {
        size_t depth = 0;
        do {
            if (at < end && *at == '"') {
                skip_text();
                continue;
            }
            const bool open = at < end && (*at == '{' || *at == '['),
                       close = at < end && (*at == '}' || *at == ']');
            if (close && !depth)
                return;
            depth += open;
            depth -= close;
            at += at < end;
        } while (at < end && (depth || !std::strchr(",]} \t\r\n:", *at)));
    }

    const char *first, *at, *end;
};

/* JSON that is looked at, rule by rule; its text, or none where it has no lines. */
struct checked {
    struct scene_import *import;
    gltf_bytes text;
    std::vector<string> path; /* of what is looked at */
};

/* Takes a member out that is of another type than it should be; an error but for --lenient. Null
 * is what some write for what is not there. */
void check_member(checked &c, json &object, const string &name, enum type type)
{
    const json *const value = member(object, name.c_str());
    if (!value || is_of_type(*value, type))
        return;
    string where;
    walk place(c.text);
    bool found = c.text.data != nullptr;
    for (size_t i = 0; i < c.path.size(); i++) {
        const bool number = isdigit(static_cast<unsigned char>(c.path[i][0]));
        where += (i ? number ? " " : ", " : "") + c.path[i];
        found = found && place.enter(c.path[i]);
    }
    where += where.empty() ? "" : ": ";
    found = found && place.enter(name);
    if (value->is_null())
        warnings_add(c.import->warnings, "glTF null",
                     "%s:%zu: %.200s%.60s: expected %s, got null: taken as not there",
                     c.import->path, found ? place.line() : 1, where.c_str(), name.c_str(),
                     type_names[type]);
    else
        gltf_check(scene_import_broken(c.import, "glTF of the wrong type", found ? place.line() : 0,
                                       "%.200s%.60s: expected %s, got %.60s", where.c_str(),
                                       name.c_str(), type_names[type], value->dump().c_str()));
    object.erase(name);
}

/* What a rule says of the members of this value. */
void check_rule(checked &c, json &value, const char *rule, enum type type)
{
    const char *const slash = std::strchr(rule, '/');
    const string name(rule, slash ? static_cast<size_t>(slash - rule) : std::strlen(rule));
    std::vector<string> names;
    if (name != "*")
        names.push_back(name);
    else if (value.is_object())
        for (json::const_iterator at = value.begin(); at != value.end(); ++at)
            names.push_back(at.key());
    for (const string &own : names) {
        const auto below = value.is_object() ? value.find(own) : value.end();
        if (below == value.end())
            continue;
        if (!slash) {
            check_member(c, value, own, type);
            continue;
        }
        c.path.push_back(own);
        check_rule(c, *below, slash + 1, type);
        c.path.pop_back();
    }
    for (size_t i = 0; name == "*" && slash && value.is_array() && i < value.size(); i++) {
        c.path.push_back(std::to_string(i));
        check_rule(c, value[i], slash + 1, type);
        c.path.pop_back();
    }
}

/* The weights of morph targets that nodes state, which tinygltf leaves out. */
void list_weights(const json &document, gltf_file &file)
{
    for (const json &node : list_of(document, "nodes")) {
        file.weights.emplace_back();
        for (const json &weight : list_of(node, "weights"))
            file.weights.back().push_back(weight.get<double>());
    }
}

/* Skins, which tinygltf wants to have inverse bind matrices. */
void list_skins(const json &document, gltf_file &file)
{
    for (const json &skin : list_of(document, "skins")) {
        file.skins.emplace_back();
        for (const json &joint : list_of(skin, "joints"))
            file.skins.back().joints.push_back(joint.get<int>());
        if (const json *const bind = member(skin, "inverseBindMatrices"))
            file.skins.back().bind = bind->get<int>();
    }
}

} // namespace

bool gltf_is_data(const string &uri)
{
    return uri.compare(0, 5, "data:") == 0;
}

gltf_bytes gltf_data(const string &uri)
{
    const size_t comma = uri.find(',');
    if (comma == string::npos)
        return {};
    const string base64 = ";base64", content = decode(uri.substr(comma + 1));
    auto bytes = std::make_shared<std::vector<unsigned char>>();
    if (comma >= base64.size() && uri.compare(comma - base64.size(), base64.size(), base64) == 0) {
        string type;
        tinygltf::DecodeDataURI(bytes.get(), type,
                                "data:application/octet-stream;base64," + content, 0, false);
    } else {
        bytes->assign(content.begin(), content.end());
    }
    return {bytes, bytes->data(), bytes->size()};
}

string gltf_file_name(const struct scene_import *import, const string &uri)
{
    const string decoded = decode(uri);
    return decoded == uri || find(import, decoded) || !find(import, uri) ? decoded : uri;
}

gltf_file gltf_open(struct scene_import *import)
{
    char *data = nullptr;
    size_t size = 0;
    scene_import_content(import, &data, &size);
    const gltf_bytes whole = keep(data, size);
    gltf_bytes text = whole, chunk;
    if (whole.size >= 4 && !std::memcmp(whole.data, "glTF", 4))
        split_glb(whole, text, chunk);
    json document = parse(text);
    check_version(document);
    check_extensions(document);
    warn_extensions(import, document);
    checked c = {import, text.data == whole.data ? text : gltf_bytes(), {}};
    for (const rule &of : rules)
        check_rule(c, document, of.path, of.type);
    for (const char *const texture : textures)
        for (const rule &of : texture_rules)
            check_rule(c, document, (string(texture) + of.path).c_str(), of.type);
    gltf_file file;
    list_weights(document, file);
    list_skins(document, file);
    read_buffers(import, document, chunk, file);
    list_pictures(document, file);
    for (const char *const name : {"buffers", "images", "animations", "cameras", "skins"})
        document.erase(name);
    const string rest = document.dump();
    if (rest.size() > std::numeric_limits<unsigned>::max())
        gltf_fail(error_new("more than 4 GB of JSON"));
    string wrong, warning;
    tinygltf::TinyGLTF loader;
    const bool good = loader.LoadASCIIFromString(&file.model, &wrong, &warning, rest.c_str(),
                                                 static_cast<unsigned>(rest.size()), "");
    wrong.resize(std::min(wrong.find('\n'), wrong.size()));
    if (!good)
        gltf_fail(error_new("%.200s",
                            wrong.empty() ? "not a glTF file that can be read" : wrong.c_str()));
    if (!wrong.empty())
        gltf_check(scene_import_broken(import, "glTF", 0, "%.200s", wrong.c_str()));
    return file;
}
