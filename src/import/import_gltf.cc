/* SPDX-License-Identifier: Apache-2.0 */
/* glTF 2.0 and GLB: from the structures that tinygltf made of the file (import_gltf_file.cc) to the
 * scene, with every bound checked.
 *
 * Nodes become instances, so a mesh that is placed many times stays one mesh. What a diffuse bake
 * does not use (metalness, normal maps, cameras, animations) is left alone. Skins and morph targets
 * stand in their default pose.
 */
#include "import/import_gltf.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace
{

using std::string;
using std::vector;
using tinygltf::Value;

/* The texture coordinates that a material's colour and its emission read; -1: none. */
struct uv_sets {
    int base, glow;
};

struct importer {
    struct scene_import *import;
    gltf_file file;
    vector<uv_sets> uv_set;                /* by material */
    int32_t default_material = SCENE_NONE; /* for primitives without one */
    vector<long> mesh_index;               /* by glTF mesh: the scene's, no_triangles or not_read */
    vector<uint32_t> mesh_part;            /* by glTF mesh: its name */
    vector<int> parent;                    /* by node; -1: none */
};

using matrix = std::array<double, 12>; /* rows of a 3x4 matrix */

const long no_triangles = -1, not_read = -2;

/* -- values of extensions --------------------------------------------------------------------- */

const Value *extension(const tinygltf::ExtensionMap &extensions, const char *name)
{
    const auto found = extensions.find(name);
    return found != extensions.end() && found->second.IsObject() ? &found->second : nullptr;
}

const Value *member(const Value *object, const char *name)
{
    return object && object->IsObject() && object->Has(name) ? &object->Get(name) : nullptr;
}

double number_of(const Value *object, const char *name, double otherwise)
{
    const Value *const value = member(object, name);
    return value && value->IsNumber() ? value->GetNumberAsDouble() : otherwise;
}

/* Number i of a list. */
double number_of(const Value *object, const char *name, size_t i, double otherwise)
{
    const Value *const value = member(object, name);
    const bool there = value && value->IsArray() && i < value->ArrayLen();
    const Value *const element = there ? &value->Get(static_cast<int>(i)) : nullptr;
    return element && element->IsNumber() ? element->GetNumberAsDouble() : otherwise;
}

int index_of(const Value *object, const char *name, int otherwise = -1)
{
    const double value = number_of(object, name, -1);
    return value >= 0 && value < 1e9 ? static_cast<int>(value) : otherwise;
}

double at(const vector<double> &values, size_t i, double otherwise)
{
    return i < values.size() ? values[i] : otherwise;
}

/* -- accessors -------------------------------------------------------------------------------- */

/* The bytes of a buffer view. */
gltf_bytes view_of(const gltf_file &file, int index)
{
    if (index < 0 || static_cast<size_t>(index) >= file.model.bufferViews.size())
        gltf_fail(error_new("buffer view %d does not exist", index));
    const tinygltf::BufferView &view = file.model.bufferViews[static_cast<size_t>(index)];
    if (view.buffer < 0 || static_cast<size_t>(view.buffer) >= file.buffers.size())
        gltf_fail(error_new("buffer view %d: buffer %d does not exist", index, view.buffer));
    const gltf_bytes &buffer = file.buffers[static_cast<size_t>(view.buffer)];
    if (view.byteOffset > buffer.size || view.byteLength > buffer.size - view.byteOffset)
        gltf_fail(
            error_new("buffer view %d reaches beyond its buffer of %zu bytes", index, buffer.size));
    return {buffer.owner, buffer.data + view.byteOffset, view.byteLength};
}

/* The first of `count` elements of `size` bytes, each `stride` bytes behind the one before. */
const unsigned char *elements_of(const gltf_file &file, int view, size_t offset, size_t stride,
                                 size_t size, size_t count)
{
    const gltf_bytes bytes = view_of(file, view);
    const bool fits = count == 0 ||
                      (offset <= bytes.size && size <= bytes.size - offset &&
                       (count == 1 || stride <= (bytes.size - offset - size) / (count - 1)));
    if (!fits)
        gltf_fail(error_new("%zu elements do not fit into buffer view %d of %zu bytes", count, view,
                            bytes.size));
    return count == 0 ? bytes.data : bytes.data + offset;
}

double read_component(const unsigned char *from, int type, bool normalized)
{
    const auto get = [from](auto value) {
        std::memcpy(&value, from, sizeof value);
        return static_cast<double>(value);
    };
    switch (type) { /* normalized: glTF 2.0, 3.11 */
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return normalized ? std::max(get(int8_t{}) / 127, -1.0) : get(int8_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return normalized ? get(uint8_t{}) / 255 : get(uint8_t{});
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return normalized ? std::max(get(int16_t{}) / 32767, -1.0) : get(int16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return normalized ? get(uint16_t{}) / 65535 : get(uint16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return get(uint32_t{});
    default: return get(float{});
    }
}

size_t component_size(int type)
{
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT: return 4;
    default: gltf_fail(error_new("component type %d is not known", type));
    }
}

/* Puts in the elements that a sparse accessor replaces. */
void read_sparse(const gltf_file &file, const tinygltf::Accessor &accessor, size_t components,
                 vector<double> &values)
{
    const auto &sparse = accessor.sparse;
    if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
        gltf_fail(error_new("a sparse accessor with negative numbers"));
    const int index_type = sparse.indices.componentType;
    const size_t count = static_cast<size_t>(sparse.count);
    const size_t size = component_size(accessor.componentType),
                 index_size = component_size(index_type);
    const unsigned char *const index = elements_of(file, sparse.indices.bufferView,
                                                   static_cast<size_t>(sparse.indices.byteOffset),
                                                   index_size, index_size, count);
    const unsigned char *const value = elements_of(file, sparse.values.bufferView,
                                                   static_cast<size_t>(sparse.values.byteOffset),
                                                   size * components, size * components, count);
    for (size_t i = 0; i < count; i++) {
        const double element = read_component(index + i * index_size, index_type, false);
        if (!(element >= 0 && element < static_cast<double>(accessor.count)))
            gltf_fail(error_new("sparse index %.0f is out of range", element));
        for (size_t k = 0; k < components; k++)
            values[static_cast<size_t>(element) * components + k] = read_component(
                value + (i * components + k) * size, accessor.componentType, accessor.normalized);
    }
}

vector<double> read_accessor(const gltf_file &file, const tinygltf::Accessor &accessor,
                             size_t components)
{
    /* What an accessor without data claims is bounded by nothing else. */
    const size_t most_zeros = size_t{1} << 22;
    const int has = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
    if (has != static_cast<int>(components))
        gltf_fail(error_new("expected %zu numbers an element, got %d", components, has));
    const size_t size = component_size(accessor.componentType), whole = size * components;
    vector<double> values;
    if (accessor.bufferView >= 0) {
        const size_t view = static_cast<size_t>(accessor.bufferView);
        const size_t stated =
            view < file.model.bufferViews.size() ? file.model.bufferViews[view].byteStride : 0;
        const size_t stride = stated ? stated : whole;
        const unsigned char *from = elements_of(file, accessor.bufferView, accessor.byteOffset,
                                                stride, whole, accessor.count);
        values.reserve(accessor.count * components);
        for (size_t i = 0; i < accessor.count; i++)
            for (size_t k = 0; k < components; k++)
                values.push_back(read_component(from + i * stride + k * size,
                                                accessor.componentType, accessor.normalized));
    } else if (accessor.count > most_zeros) {
        gltf_fail(error_new("%zu elements without data", accessor.count));
    } else {
        values.resize(accessor.count * components);
    }
    if (accessor.sparse.isSparse)
        read_sparse(file, accessor, components, values);
    return values;
}

/* All numbers of an accessor, `components` an element. */
vector<double> read_accessor(const gltf_file &file, int index, size_t components)
{
    if (index < 0 || static_cast<size_t>(index) >= file.model.accessors.size())
        gltf_fail(error_new("accessor %d does not exist", index));
    try {
        return read_accessor(file, file.model.accessors[static_cast<size_t>(index)], components);
    } catch (const gltf_error &e) {
        gltf_fail(error_wrap(e.err, "accessor %d", index));
    }
}

/* -- textures --------------------------------------------------------------------------------- */

enum scene_wrap wrap_of(int wrap)
{
    return wrap == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? SCENE_CLAMP
           : wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? SCENE_MIRROR
                                                           : SCENE_REPEAT;
}

int32_t read_picture(const importer &g, size_t index, struct scene_sampler sampler)
{
    const gltf_picture &picture = g.file.pictures[index];
    int32_t result = SCENE_NONE;
    if (!picture.uri.empty() && !gltf_is_data(picture.uri)) {
        const string name = gltf_file_name(g.import, picture.uri);
        gltf_check(scene_import_texture(g.import, name.c_str(), IMAGE_COLOUR, sampler, &result));
        return result;
    }
    const string name = "image " + std::to_string(index);
    try {
        const gltf_bytes bytes = picture.uri.empty() ? view_of(g.file, picture.view)
                                                     : gltf_data(picture.uri);
        gltf_check(scene_import_picture(g.import, name.c_str(), bytes.data, bytes.size,
                                        IMAGE_COLOUR, sampler, &result));
        return result;
    } catch (const gltf_error &e) {
        gltf_fail(error_wrap(e.err, "%s", name.c_str()));
    }
}

int32_t read_texture(const importer &g, int index)
{
    const bool there = index >= 0 && static_cast<size_t>(index) < g.file.model.textures.size();
    const tinygltf::Texture texture = there ? g.file.model.textures[static_cast<size_t>(index)]
                                            : tinygltf::Texture();
    const int source =
        index_of(extension(texture.extensions, "EXT_texture_webp"), "source", texture.source);
    if (source < 0 || static_cast<size_t>(source) >= g.file.pictures.size()) {
        warnings_add(
            g.import->warnings, "texture missing",
            "%s: texture %d has no picture that is understood: the material's factor alone is used",
            g.import->path, index);
        return SCENE_NONE;
    }
    struct scene_sampler sampler = {SCENE_REPEAT, SCENE_REPEAT, false};
    if (texture.sampler >= 0 &&
        static_cast<size_t>(texture.sampler) < g.file.model.samplers.size()) {
        const tinygltf::Sampler &s = g.file.model.samplers[static_cast<size_t>(texture.sampler)];
        sampler = {wrap_of(s.wrapS), wrap_of(s.wrapT),
                   s.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST};
    }
    return read_picture(g, static_cast<size_t>(source), sampler);
}

/* A texture as a material names it. */
struct slot {
    int texture, uv_set;
    const Value *transform; /* KHR_texture_transform, or nullptr */
};

slot slot_of(int texture, int uv_set, const Value *transform)
{
    return {texture, index_of(transform, "texCoord", uv_set), transform};
}

slot slot_of(const tinygltf::TextureInfo &info)
{
    return slot_of(info.index, info.texCoord, extension(info.extensions, "KHR_texture_transform"));
}

slot slot_of(const Value *info) /* of an extension */
{
    return slot_of(index_of(info, "index"), index_of(info, "texCoord", 0),
                   member(member(info, "extensions"), "KHR_texture_transform"));
}

/* KHR_texture_transform maps (u, v) with v down, by T; a scene's map has v up: F T F, where F turns
 * v over. */
struct scene_map read_map(const importer &g, const slot &from)
{
    struct scene_map map =
        scene_map_of(from.texture < 0 ? SCENE_NONE : read_texture(g, from.texture));
    const double rotation = number_of(from.transform, "rotation", 0);
    if (map.texture == SCENE_NONE || !from.transform)
        return map;
    if (!(std::fabs(rotation) < 1e4)) { /* as far as angle_sin goes */
        warnings_add(g.import->warnings, "texture transform",
                     "%s: a texture is rotated by %g radians: left as it is", g.import->path,
                     rotation);
        return map;
    }
    const double c = angle_cos(rotation), s = angle_sin(rotation);
    const double scale_u = number_of(from.transform, "scale", 0, 1),
                 scale_v = number_of(from.transform, "scale", 1, 1);
    const double u_u = c * scale_u, u_v = s * scale_v,
                 u_1 = number_of(from.transform, "offset", 0, 0);
    const double v_u = -s * scale_u, v_v = c * scale_v,
                 v_1 = number_of(from.transform, "offset", 1, 0);
    const double turned[6] = {u_u, -u_v, u_1 + u_v, -v_u, v_v, 1 - v_1 - v_v};
    std::transform(turned, turned + 6, map.transform,
                   [](double x) { return static_cast<float>(x); });
    return map;
}

/* -- materials -------------------------------------------------------------------------------- */

/* The mean of a map's colour, its factor apart. */
struct vec3f mean_of(const importer &g, const struct scene_map &map)
{
    if (map.texture == SCENE_NONE)
        return {1, 1, 1};
    const struct scene_texture &t = g.import->scene->textures[map.texture];
    const struct scene_map plain = scene_map_of(map.texture);
    const uint32_t most = 256; /* samples along a side */
    const uint32_t columns = std::min(t.width, most), rows = std::min(t.height, most);
    struct vec3 sum = {};
    for (uint32_t y = 0; y < rows; y++) {
        for (uint32_t x = 0; x < columns; x++) {
            float rgba[4];
            scene_map_sample(g.import->scene, &plain,
                             (static_cast<float>(x) + 0.5f) / static_cast<float>(columns),
                             (static_cast<float>(y) + 0.5f) / static_cast<float>(rows), rgba);
            sum = {sum.x + static_cast<double>(rgba[0]), sum.y + static_cast<double>(rgba[1]),
                   sum.z + static_cast<double>(rgba[2])};
        }
    }
    const double count = static_cast<double>(columns) * rows;
    return {static_cast<float>(sum.x / count), static_cast<float>(sum.y / count),
            static_cast<float>(sum.z / count)};
}

/* KHR_materials_transmission of a thin pane: its base colour times the factor passes, the rest is
 * scattered as its base colour says. What lets light through here has no colour of its own, so the
 * share is the mean over the colours, and over the picture. */
void let_through(const importer &g, const tinygltf::Material &from, struct scene_material &m)
{
    const Value *const transmission = extension(from.extensions, "KHR_materials_transmission");
    const float factor =
        static_cast<float>(std::clamp(number_of(transmission, "transmissionFactor", 0), 0.0, 1.0));
    if (!(factor > 0))
        return;
    const struct vec3f mean = mean_of(g, m.albedo_map),
                       base = {m.albedo.x * mean.x, m.albedo.y * mean.y, m.albedo.z * mean.z};
    const float through = factor * std::clamp((base.x + base.y + base.z) / 3, 0.0f, 1.0f);
    if (m.alpha == SCENE_CUTOUT || !std::isfinite(through)) {
        warnings_add(g.import->warnings, "transmission",
                     "%s: material '%.60s' is a cut-out that lets light through: the rest of it is "
                     "opaque here",
                     g.import->path, from.name.c_str());
        return;
    }
    const bool coloured = vec3f_most(base) - std::min({base.x, base.y, base.z}) > 0.1f;
    if (coloured || member(transmission, "transmissionTexture"))
        warnings_add(g.import->warnings, "transmission",
                     "%s: material '%.60s' lets coloured or patterned light through: the mean, "
                     "%.3g of it, passes without colour",
                     g.import->path, from.name.c_str(), static_cast<double>(through));
    m.opacity = (m.alpha == SCENE_BLEND ? m.opacity : 1) * (1 - through);
    m.alpha = SCENE_BLEND;
    if (through < 1) {
        const float rest = (1 - factor) / (1 - through);
        m.albedo = {m.albedo.x * rest, m.albedo.y * rest, m.albedo.z * rest};
    }
}

double most_of(const double c[3])
{
    return std::max({c[0], c[1], c[2]});
}

/* Where both models of a material state its colour or how much of the light passes, and differ. */
void warn_contradiction(const importer &g, const tinygltf::Material &from, const double used[4])
{
    const tinygltf::PbrMetallicRoughness &other = from.pbrMetallicRoughness;
    const double opacity = at(other.baseColorFactor, 3, 1);
    if (from.alphaMode != "OPAQUE" && opacity < 1 && std::fabs(opacity - used[3]) > 0.01)
        warnings_add(g.import->warnings, "two opacities",
                     "%s: material '%.60s' has opacity %.3g in pbrMetallicRoughness and %.3g in "
                     "KHR_materials_pbrSpecularGlossiness: the latter is used%s",
                     g.import->path, from.name.c_str(), opacity, used[3],
                     used[3] > 0.9 ? ", which shuts light out" : "");
    const double base[3] = {at(other.baseColorFactor, 0, 1), at(other.baseColorFactor, 1, 1),
                            at(other.baseColorFactor, 2, 1)};
    const bool stated = from.values.count("baseColorFactor") || other.baseColorTexture.index >= 0;
    if (stated && most_of(used) < 0.01 && most_of(base) > 0.1)
        warnings_add(g.import->warnings, "two colours",
                     "%s: material '%.60s' is black in KHR_materials_pbrSpecularGlossiness, which "
                     "is used, and up to %.3g in pbrMetallicRoughness",
                     g.import->path, from.name.c_str(), most_of(base));
}

/* What exporters write without meaning it, and what makes things black or shuts light out. */
void warn_material(const importer &g, const tinygltf::Material &from,
                   const struct scene_material &m, double opacity, const slot &glow)
{
    const char *const path = g.import->path, *const name = from.name.c_str();
    if (m.albedo_map.texture != SCENE_NONE && !(vec3f_most(m.albedo) > 0))
        warnings_add(g.import->warnings, "baseColorFactor 0 with a picture",
                     "%s: material '%.60s': baseColorFactor 0 times its picture is black", path,
                     name);
    if (glow.texture >= 0 && !scene_emits(&m))
        warnings_add(
            g.import->warnings, "emissiveFactor 0 with a picture",
            "%s: material '%.60s': its emissiveTexture does not shine, for emissiveFactor, "
            "or its strength, is 0, as it is where it is not stated",
            path, name);
    if (m.alpha == SCENE_OPAQUE && opacity < 0.99)
        warnings_add(g.import->warnings, "opaque by its mode",
                     "%s: material '%.60s' has opacity %.3g, and alphaMode OPAQUE, which is used "
                     "and shuts light out: BLEND would let %.3g of it pass",
                     path, name, opacity, 1 - opacity);
}

/* Where one of its maps reads nothing, the other's. */
uv_sets uv_sets_of(const struct scene_material &m, const slot &base, const slot &glow)
{
    const bool reads_base = m.albedo_map.texture != SCENE_NONE,
               reads_glow = m.emission_map.texture != SCENE_NONE;
    const int first = reads_base ? base.uv_set : reads_glow ? glow.uv_set : -1;
    return {first, reads_glow ? glow.uv_set : first};
}

void read_material(importer &g, const tinygltf::Material &from)
{
    struct scene_material m = scene_material_default();
    double factor[4], glow_factor[3];
    for (size_t k = 0; k < 4; k++)
        factor[k] = at(from.pbrMetallicRoughness.baseColorFactor, k, 1);
    slot base = slot_of(from.pbrMetallicRoughness.baseColorTexture);
    const slot glow = slot_of(from.emissiveTexture);
    if (const Value *const glossy =
            extension(from.extensions, "KHR_materials_pbrSpecularGlossiness")) {
        for (size_t k = 0; k < 4; k++)
            factor[k] = number_of(glossy, "diffuseFactor", k, 1);
        base = slot_of(member(glossy, "diffuseTexture"));
        warn_contradiction(g, from, factor);
    }
    const Value *const strong = extension(from.extensions, "KHR_materials_emissive_strength");
    for (size_t k = 0; k < 3; k++)
        glow_factor[k] = at(from.emissiveFactor, k, 0) * number_of(strong, "emissiveStrength", 1);
    m.albedo = {static_cast<float>(factor[0]), static_cast<float>(factor[1]),
                static_cast<float>(factor[2])};
    m.albedo_map = read_map(g, base);
    m.emission = {static_cast<float>(glow_factor[0]), static_cast<float>(glow_factor[1]),
                  static_cast<float>(glow_factor[2])};
    if (scene_emits(&m))
        m.emission_map = read_map(g, glow);
    m.two_sided = from.doubleSided;
    m.unlit = extension(from.extensions, "KHR_materials_unlit") != nullptr;
    if (from.alphaMode != "OPAQUE" && from.alphaMode != "MASK" && from.alphaMode != "BLEND")
        gltf_check(scene_import_broken(g.import, "alpha mode", 0,
                                       "material '%.60s': alphaMode '%.40s', expected OPAQUE, MASK "
                                       "or BLEND",
                                       from.name.c_str(), from.alphaMode.c_str()));
    if (from.alphaMode == "MASK" || from.alphaMode == "BLEND") {
        m.alpha = from.alphaMode == "MASK" ? SCENE_CUTOUT : SCENE_BLEND;
        m.opacity = static_cast<float>(factor[3]);
        m.cutoff = static_cast<float>(from.alphaCutoff);
        m.alpha_map = m.albedo_map;
    }
    scene_import_warn_hidden(g.import, &m, from.name.c_str());
    let_through(g, from, m);
    warn_material(g, from, m, factor[3], glow);
    g.uv_set.push_back(uv_sets_of(m, base, glow));
    m.name = strdup(from.name.c_str());
    gltf_check(m.name ? scene_push_material(g.import->scene, m, nullptr) : error_memory());
}

int32_t material_of(importer &g, int index)
{
    if (index >= 0 && static_cast<size_t>(index) < g.file.model.materials.size())
        return index;
    if (index >= 0)
        gltf_check(scene_import_broken(g.import, "material missing", 0,
                                       "material %d does not exist: without it, white", index));
    if (g.default_material == SCENE_NONE) {
        g.uv_set.push_back({-1, -1});
        gltf_check(
            scene_push_material(g.import->scene, scene_material_default(), &g.default_material));
    }
    return g.default_material;
}

/* -- meshes ----------------------------------------------------------------------------------- */

struct triangles {
    vector<double> position;
    vector<uint32_t> index;
    vector<float> uv; /* two a corner, v up; those of the last corners may lack */
    /* of emission maps; those of the last corners may lack: they are uv */
    vector<float> emission_uv;
    vector<uint16_t> colour; /* four a vertex; those of the last vertices may lack: white */
    vector<int32_t> material;
};

const uint32_t no_vertex = std::numeric_limits<uint32_t>::max();

/* The vertices that a primitive names one after the other; without indices, all. */
vector<uint32_t> indices_of(const gltf_file &file, const tinygltf::Primitive &primitive,
                            uint32_t vertices)
{
    vector<uint32_t> index;
    if (primitive.indices < 0) {
        for (uint32_t i = 0; i < vertices; i++)
            index.push_back(i);
        return index;
    }
    const vector<double> numbers = read_accessor(file, primitive.indices, 1);
    index.reserve(numbers.size());
    for (const double i : numbers)
        index.push_back(i >= 0 && i < vertices ? static_cast<uint32_t>(i) : no_vertex);
    return index;
}

/* The corners of the triangles of a list, a strip or a fan (glTF 2.0, 3.7.2.1), without the
 * triangles of which a corner is no vertex. */
vector<uint32_t> corners_of(const importer &g, const vector<uint32_t> &index, int mode)
{
    const bool list = mode == TINYGLTF_MODE_TRIANGLES, strip = mode == TINYGLTF_MODE_TRIANGLE_STRIP;
    vector<uint32_t> corner;
    if (list && index.size() % 3)
        warnings_add(g.import->warnings, "part of a triangle",
                     "%s: a list of triangles has %zu corners, which is no multiple of 3: what is "
                     "over is left out",
                     g.import->path, index.size());
    corner.reserve(list ? index.size() : 3 * index.size());
    for (size_t i = 0; i + 2 < index.size(); i += list ? 3 : 1) {
        const uint32_t fan[3] = {index[i + 1], index[i + 2], index[0]};
        const uint32_t turned[3] = {index[i], index[i + 2], index[i + 1]};
        const uint32_t *const three = list ? &index[i] : !strip ? fan : i % 2 ? turned : &index[i];
        if (three[0] != no_vertex && three[1] != no_vertex && three[2] != no_vertex)
            corner.insert(corner.end(), three, three + 3);
        else
            gltf_check(scene_import_broken(
                g.import, "index out of range", 0,
                "a triangle has a corner that is not among its primitive's vertices"));
    }
    return corner;
}

/* Adds the triangles and, in order, the vertices that are their corners, with their colours if
 * there are any: primitives may share one long list. */
void add_corners(const vector<double> &vertex, const vector<uint16_t> &colour,
                 const vector<uint32_t> &corner, triangles &to)
{
    vector<uint32_t> place(vertex.size() / 3, no_vertex); /* in to.position */
    for (const uint32_t c : corner)
        place[c] = 0;
    if (!colour.empty())
        to.colour.resize(to.position.size() / 3 * 4, UINT16_MAX);
    for (size_t v = 0; v < place.size(); v++) {
        if (place[v] == no_vertex)
            continue;
        if (to.position.size() / 3 >= no_vertex)
            gltf_fail(error_new("its mesh has 2^32 vertices or more"));
        place[v] = static_cast<uint32_t>(to.position.size() / 3);
        to.position.insert(to.position.end(), &vertex[3 * v], &vertex[3 * v] + 3);
        if (!colour.empty())
            to.colour.insert(to.colour.end(), &colour[4 * v], &colour[4 * v] + 4);
    }
    for (const uint32_t c : corner)
        to.index.push_back(place[c]);
}

/* COLOR_0 of a primitive's vertices, as a mesh has it; empty where there is none. Alpha counts
 * where its material's does. */
vector<uint16_t> colours_of(const importer &g, const tinygltf::Primitive &primitive,
                            size_t vertices)
{
    const auto attribute = primitive.attributes.find("COLOR_0");
    if (attribute == primitive.attributes.end())
        return {};
    const vector<tinygltf::Accessor> &accessors = g.file.model.accessors;
    const size_t index = static_cast<size_t>(attribute->second);
    if (attribute->second < 0 || index >= accessors.size())
        gltf_fail(error_new("COLOR_0: accessor %d does not exist", attribute->second));
    tinygltf::Accessor accessor = accessors[index];
    const size_t components = accessor.type == TINYGLTF_TYPE_VEC3 ? 3 : 4;
    if (!accessor.normalized && accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) {
        warnings_add(g.import->warnings, "colours not normalized",
                     "%s: colours of vertices are whole numbers that are not said to be "
                     "normalized, as they have to be: taken as if they were",
                     g.import->path);
        accessor.normalized = true;
    }
    const vector<double> value = read_accessor(g.file, accessor, components);
    if (value.size() < components * vertices)
        gltf_fail(error_new("%zu colours for %zu vertices", value.size() / components, vertices));
    const size_t material = static_cast<size_t>(primitive.material);
    const bool opaque = primitive.material < 0 || material >= g.file.model.materials.size() ||
                        g.file.model.materials[material].alphaMode == "OPAQUE";
    vector<uint16_t> colour(4 * vertices, UINT16_MAX);
    for (size_t v = 0; v < vertices; v++) {
        for (size_t k = 0; k < (opaque ? 3 : components); k++) {
            const double share = value[components * v + k];
            colour[4 * v + k] =
                static_cast<uint16_t>(share > 0 ? 65535 * std::min(share, 1.0) + 0.5 : 0);
        }
    }
    bool hidden = !opaque && components == 4;
    for (size_t v = 0; v < vertices && hidden; v++)
        hidden = colour[4 * v + 3] == 0;
    if (hidden)
        warnings_add(g.import->warnings, "alpha 0 everywhere",
                     "%s: the colours of a mesh's vertices have alpha 0, which hides all of it",
                     g.import->path);
    return colour;
}

/* Adds texture coordinates of the newest corners, if any; zeros for those before that have
 * none. */
void add_uv(const importer &g, const tinygltf::Primitive &primitive, int set,
            const vector<uint32_t> &corner, size_t vertices, size_t corners, vector<float> &to)
{
    const string name = "TEXCOORD_" + std::to_string(set);
    const auto attribute = primitive.attributes.find(name);
    if (set >= 0 && attribute == primitive.attributes.end())
        warnings_add(g.import->warnings, "texture coordinates missing",
                     "%s: a material reads its picture by %s, which its mesh has not: one texel of "
                     "it is used",
                     g.import->path, name.c_str());
    if (attribute == primitive.attributes.end())
        return;
    const vector<double> uv = read_accessor(g.file, attribute->second, 2);
    if (uv.size() < 2 * vertices)
        gltf_fail(error_new("%zu texture coordinates for %zu vertices", uv.size() / 2, vertices));
    to.resize(2 * (corners - corner.size()));
    for (const size_t c : corner)
        to.insert(to.end(), {static_cast<float>(uv[2 * c]), static_cast<float>(1 - uv[2 * c + 1])});
}

/* Fills up the coordinates of emission maps by the others, which they are where nothing else is
 * said. */
void fill_emission_uv(triangles &to, size_t corners)
{
    const size_t from = to.emission_uv.size();
    to.emission_uv.resize(2 * corners);
    for (size_t k = from; k < std::min(to.emission_uv.size(), to.uv.size()); k++)
        to.emission_uv[k] = to.uv[k];
}

/* How the vertices of a mesh stand: glTF 2.0, 3.7.2.2 and 3.7.3. */
struct pose {
    const vector<double> *weights; /* of the morph targets */
    const vector<matrix> *joints;  /* of the skin: mesh to scene; nullptr without one */
};

/* Adds the morph targets by their weights to the positions. */
void morph(const gltf_file &file, const tinygltf::Primitive &primitive,
           const vector<double> &weights, vector<double> &vertex)
{
    for (size_t t = 0; t < primitive.targets.size() && t < weights.size(); t++) {
        const auto moved = primitive.targets[t].find("POSITION");
        if (weights[t] == 0 || moved == primitive.targets[t].end())
            continue;
        const vector<double> by = read_accessor(file, moved->second, 3);
        if (by.size() < vertex.size())
            gltf_fail(error_new("morph target %zu moves %zu of %zu vertices", t, by.size() / 3,
                                vertex.size() / 3));
        for (size_t i = 0; i < vertex.size(); i++)
            vertex[i] += weights[t] * by[i];
    }
}

/* Moves each vertex by the sum of its joints' matrices, by weight. */
void apply_skin(const gltf_file &file, const tinygltf::Primitive &primitive,
                const vector<matrix> &joints, vector<double> &vertex)
{
    const size_t vertices = vertex.size() / 3;
    vector<matrix> sum(vertices, matrix{});
    vector<double> whole(vertices);
    for (int set = 0;; set++) {
        const auto which = primitive.attributes.find("JOINTS_" + std::to_string(set)),
                   much = primitive.attributes.find("WEIGHTS_" + std::to_string(set));
        if (which == primitive.attributes.end() || much == primitive.attributes.end())
            break;
        const vector<double> joint = read_accessor(file, which->second, 4),
                             weight = read_accessor(file, much->second, 4);
        if (joint.size() < 4 * vertices || weight.size() < 4 * vertices)
            gltf_fail(error_new("fewer joints than its %zu vertices", vertices));
        for (size_t i = 0; i < 4 * vertices; i++) {
            if (weight[i] == 0)
                continue;
            if (!(joint[i] >= 0 && joint[i] < static_cast<double>(joints.size())))
                gltf_fail(
                    error_new("a vertex hangs on joint %.0f of %zu", joint[i], joints.size()));
            const matrix &m = joints[static_cast<size_t>(joint[i])];
            for (size_t k = 0; k < m.size(); k++)
                sum[i / 4][k] += weight[i] * m[k];
            whole[i / 4] += weight[i];
        }
    }
    for (size_t v = 0; v < vertices; v++) {
        const bool hangs = whole[v] > 0;
        const matrix &m = hangs ? sum[v] : joints[0];
        const double scale = hangs ? 1 / whole[v] : 1, x = vertex[3 * v], y = vertex[3 * v + 1],
                     z = vertex[3 * v + 2];
        for (size_t row = 0; row < 3; row++)
            vertex[3 * v + row] =
                scale * (m[4 * row] * x + m[4 * row + 1] * y + m[4 * row + 2] * z + m[4 * row + 3]);
    }
}

void add_primitive(importer &g, const tinygltf::Primitive &primitive, const pose &stands,
                   triangles &to)
{
    const int mode = primitive.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
        mode != TINYGLTF_MODE_TRIANGLE_FAN) {
        if (mode < 0 || mode > TINYGLTF_MODE_TRIANGLE_FAN)
            return gltf_check(scene_import_broken(g.import, "mode of primitives", 0,
                                                  "a primitive of mode %d, expected 0 to 6", mode));
        warnings_add(g.import->warnings, "points and lines", "%s: points and lines are left out",
                     g.import->path);
        return;
    }
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end())
        return; /* nothing to be drawn: glTF 2.0, 3.7.2.1 */
    vector<double> vertex = read_accessor(g.file, position->second, 3);
    morph(g.file, primitive, *stands.weights, vertex);
    if (stands.joints)
        apply_skin(g.file, primitive, *stands.joints, vertex);
    const size_t vertices = vertex.size() / 3;
    if (vertices >= no_vertex)
        gltf_fail(error_new("%zu vertices, expected fewer than 2^32", vertices));
    const vector<uint32_t> index = indices_of(g.file, primitive, static_cast<uint32_t>(vertices));
    const vector<uint32_t> corner = corners_of(g, index, mode);
    const int32_t material = material_of(g, primitive.material);
    add_corners(vertex, colours_of(g, primitive, vertices), corner, to);
    const uv_sets sets = g.uv_set[static_cast<size_t>(material)];
    add_uv(g, primitive, sets.base, corner, vertices, to.index.size(), to.uv);
    if (sets.glow != sets.base) {
        fill_emission_uv(to, to.index.size() - corner.size());
        add_uv(g, primitive, sets.glow, corner, vertices, to.index.size(), to.emission_uv);
    }
    to.material.insert(to.material.end(), corner.size() / 3, material);
}

template <typename T> T *copy_array(const vector<T> &from)
{
    T *to = nullptr;
    gltf_check(array_create(&to, from.size(), sizeof(T)));
    std::copy(from.begin(), from.end(), to);
    return to;
}

/* A part of the scene; what has no name is known by its number. */
uint32_t push_part(const importer &g, enum scene_part_kind kind, const char *what, size_t number,
                   const string &name, uint32_t above)
{
    uint32_t part = 0;
    const string known = name.empty() ? what + (" " + std::to_string(number)) : name;
    gltf_check(scene_push_part(g.import->scene, kind, known.c_str(), above, &part));
    return part;
}

long push_mesh(const importer &g, triangles &t, uint32_t part)
{
    struct scene_mesh mesh = {};
    mesh.part = part;
    size_t pushed = 0;
    try {
        mesh.position = copy_array(t.position);
        mesh.index = copy_array(t.index);
        mesh.material = copy_array(t.material);
        if (!t.uv.empty()) {
            t.uv.resize(2 * t.index.size());
            mesh.uv = copy_array(t.uv);
        }
        if (!t.emission_uv.empty()) {
            fill_emission_uv(t, t.index.size());
            mesh.emission_uv = copy_array(t.emission_uv);
        }
        if (!t.colour.empty()) {
            t.colour.resize(t.position.size() / 3 * 4, UINT16_MAX);
            mesh.colour = copy_array(t.colour);
        }
    } catch (...) {
        scene_mesh_clear(&mesh);
        throw;
    }
    mesh.vertex_count = t.position.size() / 3;
    mesh.triangle_count = t.index.size() / 3;
    gltf_check(scene_push_mesh(g.import->scene, mesh, &pushed));
    return static_cast<long>(pushed);
}

long read_mesh(importer &g, int index, const pose &stands)
{
    const vector<tinygltf::Primitive> &primitives =
        g.file.model.meshes[static_cast<size_t>(index)].primitives;
    triangles t;
    for (size_t p = 0; p < primitives.size(); p++) {
        try {
            add_primitive(g, primitives[p], stands, t);
        } catch (const gltf_error &e) {
            gltf_fail(error_wrap(e.err, "mesh %d, primitive %zu", index, p));
        }
    }
    if (t.index.empty())
        return no_triangles;
    uint32_t &part = g.mesh_part[static_cast<size_t>(index)];
    if (!part)
        part = push_part(g, SCENE_MESH, "mesh", static_cast<size_t>(index),
                         g.file.model.meshes[static_cast<size_t>(index)].name, 0);
    return push_mesh(g, t, part);
}

/* The scene's mesh for a glTF mesh, which is read when it is placed for the first time; where its
 * node or a skin has a say in its shape, for each node. */
long mesh_of(importer &g, int index, const vector<double> &weights, const vector<matrix> *joints)
{
    const size_t i = static_cast<size_t>(index);
    if (index < 0 || i >= g.mesh_index.size())
        gltf_fail(error_new("mesh %d does not exist", index));
    if (joints || !weights.empty())
        return read_mesh(g, index,
                         {weights.empty() ? &g.file.model.meshes[i].weights : &weights, joints});
    if (g.mesh_index[i] == not_read)
        g.mesh_index[i] = read_mesh(g, index, {&g.file.model.meshes[i].weights, nullptr});
    return g.mesh_index[i];
}

/* -- nodes ------------------------------------------------------------------------------------ */

matrix multiply(const matrix &a, const matrix &b)
{
    matrix c;
    for (size_t row = 0; row < 3; row++) {
        for (size_t k = 0; k < 4; k++) {
            c[4 * row + k] = k == 3 ? a[4 * row + 3] : 0;
            for (size_t j = 0; j < 3; j++)
                c[4 * row + k] += a[4 * row + j] * b[4 * j + k];
        }
    }
    return c;
}

/* Translation times rotation (a quaternion x, y, z, w of any length) times scale; glTF 2.0,
 * 3.5.3. */
matrix place(const double t[3], const double q[4], const double scale[3])
{
    const double norm = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3],
                 s = norm > 0 ? 2 / norm : 0;
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double rotation[9] = {
        1 - s * (y * y + z * z), s * (x * y - z * w),     s * (x * z + y * w),
        s * (x * y + z * w),     1 - s * (x * x + z * z), s * (y * z - x * w),
        s * (x * z - y * w),     s * (y * z + x * w),     1 - s * (x * x + y * y)};
    matrix m;
    for (size_t row = 0; row < 3; row++) {
        for (size_t k = 0; k < 3; k++)
            m[4 * row + k] = rotation[3 * row + k] * scale[k];
        m[4 * row + 3] = t[row];
    }
    return m;
}

matrix matrix_of(const tinygltf::Node &node)
{
    if (node.matrix.size() == 16) { /* column-major */
        matrix m;
        for (size_t row = 0; row < 3; row++)
            for (size_t k = 0; k < 4; k++)
                m[4 * row + k] = node.matrix[4 * k + row];
        return m;
    }
    if (!node.matrix.empty())
        gltf_fail(error_new("expected a matrix of 16 numbers, got %zu", node.matrix.size()));
    double t[3], q[4], s[3];
    for (size_t k = 0; k < 4; k++)
        q[k] = at(node.rotation, k, k == 3 ? 1 : 0);
    for (size_t k = 0; k < 3; k++) {
        t[k] = at(node.translation, k, 0);
        s[k] = at(node.scale, k, 1);
    }
    return place(t, q, s);
}

/* KHR_lights_punctual: the light shines along the node's -Z; its intensity is not scaled by the
 * node. */
void add_light(const importer &g, int index, const matrix &m, uint32_t node)
{
    if (static_cast<size_t>(index) >= g.file.model.lights.size())
        gltf_fail(error_new("light %d does not exist", index));
    const tinygltf::Light &from = g.file.model.lights[static_cast<size_t>(index)];
    struct scene_light light = {};
    if (from.type == "point")
        light.kind = SCENE_POINT;
    else if (from.type == "spot")
        light.kind = SCENE_SPOT;
    else if (from.type == "directional")
        light.kind = SCENE_SUN;
    else
        gltf_fail(error_new("light %d: expected point, spot or directional, got '%.40s'", index,
                            from.type.c_str()));
    light.position = {m[3], m[7], m[11]};
    light.direction = vec3_normalize({-m[2], -m[6], -m[10]});
    for (size_t k = 0; k < 3; k++)
        light.intensity[k] = at(from.color, k, 1) * from.intensity;
    light.range = from.range;
    light.cos_inner = angle_cos(std::clamp(from.spot.innerConeAngle, 0.0, ANGLE_PI));
    light.cos_outer =
        std::min(angle_cos(std::clamp(from.spot.outerConeAngle, 0.0, ANGLE_PI)), light.cos_inner);
    light.part = from.name.empty() ? node : push_part(g, SCENE_LIGHT, "", 0, from.name, node);
    gltf_check(scene_push_light(g.import->scene, light));
}

/* Places a mesh by a node. */
void place_mesh(const importer &g, size_t mesh, const double *m, uint32_t node)
{
    struct scene *const scene = g.import->scene;
    gltf_check(scene_push_instance(scene, mesh, m));
    scene->instances[scene->instance_count - 1].part = node;
}

/* The numbers of an attribute of EXT_mesh_gpu_instancing, `components` an instance; none where it
 * is not stated. */
vector<double> instance_numbers(const importer &g, const Value *attributes, const char *name,
                                size_t components)
{
    const int accessor = index_of(attributes, name);
    return accessor < 0 ? vector<double>() : read_accessor(g.file, accessor, components);
}

/* EXT_mesh_gpu_instancing: the mesh once for each of the attributes' elements, instead of once. */
void add_instances(const importer &g, size_t mesh, const Value *attributes, const matrix &m,
                   uint32_t node)
{
    const vector<double> t = instance_numbers(g, attributes, "TRANSLATION", 3);
    const vector<double> q = instance_numbers(g, attributes, "ROTATION", 4);
    const vector<double> s = instance_numbers(g, attributes, "SCALE", 3);
    const size_t count = std::max({t.size() / 3, q.size() / 4, s.size() / 3});
    if ((!t.empty() && t.size() < 3 * count) || (!q.empty() && q.size() < 4 * count) ||
        (!s.empty() && s.size() < 3 * count))
        gltf_fail(error_new("the attributes of its instances differ in number"));
    for (const char *const colour : {"_COLOR_0", "COLOR_0"})
        if (index_of(attributes, colour) >= 0)
            warnings_add(g.import->warnings, "colours of instances",
                         "%s: %s of the instances of a mesh is left out: all have the mesh's own "
                         "colours",
                         g.import->path, colour);
    const double no_t[3] = {0, 0, 0}, no_q[4] = {0, 0, 0, 1}, no_s[3] = {1, 1, 1};
    for (size_t i = 0; i < count; i++) {
        const matrix here =
            multiply(m, place(t.empty() ? no_t : &t[3 * i], q.empty() ? no_q : &q[4 * i],
                              s.empty() ? no_s : &s[3 * i]));
        place_mesh(g, mesh, here.data(), node);
    }
}

/* The place of a node in the scene. */
matrix world_of(const importer &g, int node)
{
    const vector<tinygltf::Node> &nodes = g.file.model.nodes;
    if (node < 0 || static_cast<size_t>(node) >= nodes.size())
        gltf_fail(error_new("node %d does not exist", node));
    matrix m = matrix_of(nodes[static_cast<size_t>(node)]);
    size_t depth = 0;
    for (int up = g.parent[static_cast<size_t>(node)]; up >= 0;
         up = g.parent[static_cast<size_t>(up)]) {
        if (++depth > nodes.size())
            gltf_fail(error_new("node %d is its own ancestor", node));
        m = multiply(matrix_of(nodes[static_cast<size_t>(up)]), m);
    }
    return m;
}

/* The matrices that take a skinned mesh's vertices to the scene: each joint's times its inverse
 * bind matrix. */
vector<matrix> joints_of(const importer &g, int index)
{
    if (static_cast<size_t>(index) >= g.file.skins.size())
        gltf_fail(error_new("skin %d does not exist", index));
    const gltf_skin &skin = g.file.skins[static_cast<size_t>(index)];
    vector<double> bind;
    if (skin.joints.empty())
        gltf_fail(error_new("skin %d has no joints", index));
    if (skin.bind >= 0)
        bind = read_accessor(g.file, skin.bind, 16);
    if (!bind.empty() && bind.size() < 16 * skin.joints.size())
        gltf_fail(error_new("skin %d has %zu joints and %zu inverse bind matrices", index,
                            skin.joints.size(), bind.size() / 16));
    vector<matrix> joints;
    for (size_t j = 0; j < skin.joints.size(); j++) {
        matrix inverse;
        std::copy(scene_identity, scene_identity + 12, inverse.begin());
        for (size_t k = 0; k < inverse.size() && !bind.empty(); k++) /* column-major */
            inverse[k] = bind[16 * j + 4 * (k % 4) + k / 4];
        joints.push_back(multiply(world_of(g, skin.joints[j]), inverse));
    }
    return joints;
}

/* A skinned mesh stands where its joints are; its own node has no say (glTF 2.0, 3.7.3.1). */
void add_skinned(importer &g, size_t number, uint32_t part)
{
    const tinygltf::Node &node = g.file.model.nodes[number];
    const vector<matrix> joints = joints_of(g, node.skin);
    const long mesh = mesh_of(g, node.mesh, g.file.weights[number], &joints);
    if (mesh >= 0)
        place_mesh(g, static_cast<size_t>(mesh), scene_identity, part);
}

bool is_skinned(const importer &g, const tinygltf::Node &node)
{
    if (node.skin < 0 || node.mesh < 0 ||
        static_cast<size_t>(node.mesh) >= g.file.model.meshes.size())
        return false;
    for (const tinygltf::Primitive &p :
         g.file.model.meshes[static_cast<size_t>(node.mesh)].primitives)
        if (p.attributes.count("JOINTS_0") && p.attributes.count("WEIGHTS_0"))
            return true;
    return false;
}

void add_node(importer &g, size_t number, const matrix &m, uint32_t part)
{
    const tinygltf::Node &node = g.file.model.nodes[number];
    const bool skinned = is_skinned(g, node);
    if (skinned)
        add_skinned(g, number, part);
    const long mesh = node.mesh >= 0 && !skinned
                          ? mesh_of(g, node.mesh, g.file.weights[number], nullptr)
                          : no_triangles;
    const Value *const many =
        member(extension(node.extensions, "EXT_mesh_gpu_instancing"), "attributes");
    if (mesh >= 0 && many)
        add_instances(g, static_cast<size_t>(mesh), many, m, part);
    else if (mesh >= 0)
        place_mesh(g, static_cast<size_t>(mesh), m.data(), part);
    const int light = index_of(extension(node.extensions, "KHR_lights_punctual"), "light");
    if (light >= 0)
        add_light(g, light, m, part);
}

/* KHR_node_visibility: what is not visible is not there, nor what hangs below it. */
bool is_visible(const tinygltf::Node &node)
{
    const Value *const visible =
        member(extension(node.extensions, "KHR_node_visibility"), "visible");
    return !visible || !visible->IsBool() || visible->Get<bool>();
}

/* The nodes of the default scene, or of the first; where there is no scene, the nodes that nobody
 * has as a child. */
vector<int> roots_of(const tinygltf::Model &model)
{
    if (!model.scenes.empty()) {
        const size_t scene = model.defaultScene >= 0 ? static_cast<size_t>(model.defaultScene) : 0;
        if (scene >= model.scenes.size())
            gltf_fail(error_new("scene %zu does not exist", scene));
        return model.scenes[scene].nodes;
    }
    vector<bool> is_child(model.nodes.size());
    for (const tinygltf::Node &node : model.nodes)
        for (const int child : node.children)
            if (child >= 0 && static_cast<size_t>(child) < is_child.size())
                is_child[static_cast<size_t>(child)] = true;
    vector<int> roots;
    for (size_t i = 0; i < is_child.size(); i++)
        if (!is_child[i])
            roots.push_back(static_cast<int>(i));
    return roots;
}

/* Walks the nodes without recursion, so that no depth is too deep. Each node has one place, as glTF
 * demands: a second is an error, which ends cycles too. */
void add_nodes(importer &g)
{
    struct placed {
        int node;
        matrix m;      /* of the parent */
        uint32_t part; /* the parent */
    };
    const vector<tinygltf::Node> &nodes = g.file.model.nodes;
    const vector<int> roots = roots_of(g.file.model);
    matrix identity;
    std::copy(scene_identity, scene_identity + 12, identity.begin());
    vector<placed> left;
    vector<bool> seen(nodes.size());
    for (auto root = roots.rbegin(); root != roots.rend(); ++root)
        left.push_back({*root, identity, 0});
    while (!left.empty()) {
        const placed next = left.back();
        left.pop_back();
        const size_t i = static_cast<size_t>(next.node);
        if (next.node < 0 || i >= nodes.size())
            gltf_fail(error_new("node %d does not exist", next.node));
        if (seen[i])
            gltf_fail(error_new("node %d has two parents, or is its own ancestor", next.node));
        seen[i] = true;
        if (!is_visible(nodes[i]))
            continue;
        try {
            const matrix m = multiply(next.m, matrix_of(nodes[i]));
            const uint32_t part = push_part(g, SCENE_NODE, "node", i, nodes[i].name, next.part);
            add_node(g, i, m, part);
            for (auto child = nodes[i].children.rbegin(); child != nodes[i].children.rend();
                 ++child)
                left.push_back({*child, m, part});
        } catch (const gltf_error &e) {
            gltf_fail(error_wrap(e.err, "node %zu", i));
        }
    }
}

struct error *read(struct scene_import *import)
{
    try {
        importer g = {};
        g.import = import;
        g.file = gltf_open(import);
        g.file.weights.resize(g.file.model.nodes.size());
        g.parent.assign(g.file.model.nodes.size(), -1);
        for (size_t i = 0; i < g.parent.size(); i++)
            for (const int child : g.file.model.nodes[i].children)
                if (child >= 0 && static_cast<size_t>(child) < g.parent.size())
                    g.parent[static_cast<size_t>(child)] = static_cast<int>(i);
        g.mesh_index.assign(g.file.model.meshes.size(), not_read);
        g.mesh_part.assign(g.file.model.meshes.size(), 0);
        for (const tinygltf::Material &material : g.file.model.materials)
            read_material(g, material);
        add_nodes(g);
        return nullptr;
    } catch (const gltf_error &e) {
        return e.err;
    }
}

} // namespace

extern "C" struct error *scene_read_gltf(struct scene_import *import)
{
    return error_guard([import] { return read(import); });
}
