// glTF 2.0 and GLB through tinygltf, which parses; accessors, transforms and textures are read here, with every bound checked.
//
// Nodes become instances, so a mesh that is placed many times stays one mesh. What a diffuse bake does not use (metalness, normal
// maps, cameras, animations) is left alone; skins and morph targets are left alone with a warning.

#include "scene_private.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <tiny_gltf.h>
#pragma GCC diagnostic pop

namespace {

using tinygltf::Value;

// Extensions that are honoured, or that change nothing that a diffuse bake sees.
const char *const known_extensions[] = {"KHR_lights_punctual", "KHR_texture_transform", "EXT_texture_webp",
                                        "KHR_materials_emissive_strength", "KHR_materials_unlit", "KHR_mesh_quantization",
                                        "KHR_materials_pbrSpecularGlossiness", "KHR_materials_ior", "KHR_materials_specular",
                                        "KHR_materials_clearcoat", "KHR_materials_sheen", "KHR_materials_anisotropy",
                                        "KHR_materials_iridescence", "KHR_materials_dispersion", "KHR_materials_variants",
                                        "KHR_animation_pointer", "KHR_node_visibility", "KHR_xmp_json_ld"};

struct gltf_error { // carries one of our errors through C++
    struct error *err;
};

[[noreturn]] void fail(struct error *err)
{
    throw gltf_error{err};
}

void check(struct error *err)
{
    if (err)
        fail(err);
}

// -- values of extensions ----------------------------------------------------------------------

const Value *extension(const tinygltf::ExtensionMap &extensions, const char *name)
{
    const auto found = extensions.find(name);
    return found != extensions.end() && found->second.IsObject() ? &found->second : nullptr;
}

const Value *member(const Value *object, const char *name)
{
    return object && object->IsObject() && object->Has(name) ? &object->Get(name) : nullptr;
}

double number(const Value *object, const char *name, double otherwise)
{
    const Value *value = member(object, name);
    return value && value->IsNumber() ? value->GetNumberAsDouble() : otherwise;
}

// Component i of an array member.
double component(const Value *object, const char *name, int i, double otherwise)
{
    const Value *value = member(object, name);
    if (!value || !value->IsArray() || value->ArrayLen() <= static_cast<size_t>(i) || !value->Get(i).IsNumber())
        return otherwise;
    return value->Get(i).GetNumberAsDouble();
}

double at(const std::vector<double> &values, size_t i, double otherwise)
{
    return i < values.size() ? values[i] : otherwise;
}

int index_of(const Value *object, const char *name)
{
    const double value = number(object, name, -1);
    return value >= 0 && value < 1e9 ? static_cast<int>(value) : -1;
}

// -- accessors ---------------------------------------------------------------------------------

// `size` bytes at an offset of a buffer view, `count` times with a stride; throws when they are not there.
const unsigned char *bytes_of(const tinygltf::Model &model, int view_index, size_t offset, size_t stride, size_t size, size_t count,
                              const char *what)
{
    if (view_index < 0 || static_cast<size_t>(view_index) >= model.bufferViews.size())
        fail(error_new("%s: buffer view %d does not exist", what, view_index));
    const tinygltf::BufferView &view = model.bufferViews[static_cast<size_t>(view_index)];
    if (view.buffer < 0 || static_cast<size_t>(view.buffer) >= model.buffers.size())
        fail(error_new("%s: buffer %d does not exist", what, view.buffer));
    const std::vector<unsigned char> &data = model.buffers[static_cast<size_t>(view.buffer)].data;
    if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
        fail(error_new("%s: buffer view %d reaches beyond its buffer of %zu bytes", what, view_index, data.size()));
    const size_t room = view.byteLength;
    const bool fits = count == 0 || (offset <= room && size <= room - offset &&
                                     (count - 1 == 0 || stride <= (room - offset - size) / (count - 1)));
    if (!fits)
        fail(error_new("%s: %zu elements do not fit into buffer view %d of %zu bytes", what, count, view_index, room));
    return data.data() + view.byteOffset + offset;
}

double read_component(const unsigned char *from, int type, bool normalized)
{
    const auto get = [from](auto value) {
        std::memcpy(&value, from, sizeof value);
        return static_cast<double>(value);
    };
    switch (type) { // normalized: glTF 2.0, 3.11
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return normalized ? std::max(get(int8_t{}) / 127, -1.0) : get(int8_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return normalized ? get(uint8_t{}) / 255 : get(uint8_t{});
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return normalized ? std::max(get(int16_t{}) / 32767, -1.0) : get(int16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return normalized ? get(uint16_t{}) / 65535 : get(uint16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return get(uint32_t{});
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return get(float{});
    case TINYGLTF_COMPONENT_TYPE_DOUBLE:
        return get(double{});
    default:
        return 0;
    }
}

size_t component_size(int type, const char *what)
{
    const int size = tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(type));
    if (size <= 0 || type == TINYGLTF_COMPONENT_TYPE_INT)
        fail(error_new("%s: component type %d is not known", what, type));
    return static_cast<size_t>(size);
}

// The elements that a sparse accessor replaces.
void read_sparse(const tinygltf::Model &model, const tinygltf::Accessor &accessor, size_t components, const char *what,
                 std::vector<double> &values)
{
    const auto &sparse = accessor.sparse;
    if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
        fail(error_new("%s: a sparse accessor with negative numbers", what));
    const size_t count = static_cast<size_t>(sparse.count), size = component_size(accessor.componentType, what),
                 index_size = component_size(sparse.indices.componentType, what);
    const unsigned char *index = bytes_of(model, sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset),
                                          index_size, index_size, count, what);
    const unsigned char *value = bytes_of(model, sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset),
                                          size * components, size * components, count, what);
    for (size_t i = 0; i < count; i++) {
        const double element = read_component(index + i * index_size, sparse.indices.componentType, false);
        if (!(element >= 0 && element < static_cast<double>(accessor.count)))
            fail(error_new("%s: sparse index %.0f is out of range", what, element));
        for (size_t k = 0; k < components; k++)
            values[static_cast<size_t>(element) * components + k] =
                read_component(value + (i * components + k) * size, accessor.componentType, accessor.normalized);
    }
}

// All numbers of an accessor, `components` an element.
std::vector<double> read_accessor(const tinygltf::Model &model, int index, size_t components, const char *what)
{
    if (index < 0 || static_cast<size_t>(index) >= model.accessors.size())
        fail(error_new("%s: accessor %d does not exist", what, index));
    const tinygltf::Accessor &accessor = model.accessors[static_cast<size_t>(index)];
    const int has = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
    if (has != static_cast<int>(components))
        fail(error_new("%s: expected %zu numbers an element, accessor %d has %d", what, components, index, has));
    const size_t size = component_size(accessor.componentType, what);
    // What an accessor without data claims is bounded by nothing else.
    if (accessor.count > (size_t{1} << 31))
        fail(error_new("%s: accessor %d has too many elements: %zu", what, index, accessor.count));
    std::vector<double> values;
    if (accessor.bufferView >= 0) {
        const size_t view = static_cast<size_t>(accessor.bufferView);
        size_t stride = view < model.bufferViews.size() ? model.bufferViews[view].byteStride : 0;
        stride = stride ? stride : size * components;
        const unsigned char *from = bytes_of(model, accessor.bufferView, accessor.byteOffset, stride, size * components,
                                             accessor.count, what);
        values.resize(accessor.count * components);
        for (size_t i = 0; i < accessor.count; i++)
            for (size_t k = 0; k < components; k++)
                values[i * components + k] = read_component(from + i * stride + k * size, accessor.componentType, accessor.normalized);
    } else {
        if (accessor.count > (size_t{1} << 26))
            fail(error_new("%s: accessor %d has %zu elements and no data", what, index, accessor.count));
        values.resize(accessor.count * components);
    }
    if (accessor.sparse.isSparse)
        read_sparse(model, accessor, components, what, values);
    return values;
}

// -- textures and materials --------------------------------------------------------------------

struct importer {
    struct scene_import *import;
    tinygltf::Model model;
    std::vector<std::vector<unsigned char>> pictures; // by image: what was embedded
    std::vector<int> uv_set;                          // by material: the texture coordinates that it reads
    int32_t default_material = SCENE_NONE;            // for primitives without one
    std::vector<long> mesh_index;                     // by glTF mesh: the scene's, or -1 without triangles
};

std::string url_decode(const std::string &text)
{
    std::string out;
    for (size_t i = 0; i < text.size(); i++) {
        const auto hex = [&](size_t at) { return std::string("0123456789abcdef").find(static_cast<char>(std::tolower(text[at]))); };
        if (text[i] == '%' && i + 2 < text.size() && hex(i + 1) < 16 && hex(i + 2) < 16) {
            out += static_cast<char>(16 * hex(i + 1) + hex(i + 2));
            i += 2;
        } else {
            out += text[i];
        }
    }
    return out;
}

enum scene_wrap wrap_of(int wrap)
{
    return wrap == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? SCENE_CLAMP
           : wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? SCENE_MIRROR
                                                           : SCENE_REPEAT;
}

int32_t read_texture(importer &g, int index)
{
    if (index < 0 || static_cast<size_t>(index) >= g.model.textures.size()) {
        warnings_add(g.import->warnings, "texture missing", "texture %d does not exist: the material's factor alone is used", index);
        return SCENE_NONE;
    }
    const tinygltf::Texture &texture = g.model.textures[static_cast<size_t>(index)];
    const Value *webp = extension(texture.extensions, "EXT_texture_webp");
    const int source = webp ? index_of(webp, "source") : texture.source;
    if (source < 0 || static_cast<size_t>(source) >= g.model.images.size()) {
        warnings_add(g.import->warnings, "texture missing", "texture %d has no picture that is understood: the material's factor alone is used", index);
        return SCENE_NONE;
    }
    struct scene_sampler sampler = {SCENE_REPEAT, SCENE_REPEAT, false};
    if (texture.sampler >= 0 && static_cast<size_t>(texture.sampler) < g.model.samplers.size()) {
        const tinygltf::Sampler &s = g.model.samplers[static_cast<size_t>(texture.sampler)];
        sampler = {wrap_of(s.wrapS), wrap_of(s.wrapT), s.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST};
    }
    const tinygltf::Image &image = g.model.images[static_cast<size_t>(source)];
    const std::vector<unsigned char> &picture = g.pictures[static_cast<size_t>(source)];
    const std::string name = "image " + std::to_string(source);
    int32_t result = SCENE_NONE;
    if (image.uri.empty())
        check(scene_import_picture(g.import, name.c_str(), picture.data(), picture.size(), IMAGE_COLOUR, sampler, &result));
    else
        check(scene_import_texture(g.import, url_decode(image.uri).c_str(), IMAGE_COLOUR, sampler, &result));
    return result;
}

// A texture with its KHR_texture_transform. That maps (u, v) with v down, ours with v up: F T F, where F turns v over.
struct scene_map make_map(importer &g, int texture, const Value *transform)
{
    struct scene_map map = scene_map_of(texture < 0 ? SCENE_NONE : read_texture(g, texture));
    if (map.texture == SCENE_NONE || !transform)
        return map;
    const double rotation = number(transform, "rotation", 0);
    if (!(std::fabs(rotation) < 1e4)) {
        warnings_add(g.import->warnings, "texture transform", "a texture is rotated by %g radians: left as it is", rotation);
        return map;
    }
    const double c = angle_cos(rotation), s = angle_sin(rotation), su = component(transform, "scale", 0, 1),
                 sv = component(transform, "scale", 1, 1);
    const double a = c * su, b = s * sv, x = component(transform, "offset", 0, 0);
    const double d = -s * su, e = c * sv, y = component(transform, "offset", 1, 0);
    const double turned[6] = {a, -b, b + x, -d, e, 1 - e - y};
    for (int i = 0; i < 6; i++)
        map.transform[i] = static_cast<float>(turned[i]);
    return map;
}

// What a texture slot of a material says, from whichever place the file keeps it.
struct slot {
    int texture = -1, uv_set = 0;
    const Value *transform = nullptr;
};

slot slot_of(int texture, int uv_set, const Value *transform)
{
    slot s{texture, uv_set, transform};
    const int other = index_of(transform, "texCoord");
    if (other >= 0)
        s.uv_set = other;
    return s;
}

slot slot_of(const tinygltf::TextureInfo &info)
{
    return slot_of(info.index, info.texCoord, extension(info.extensions, "KHR_texture_transform"));
}

slot slot_of(const Value *info)
{
    return slot_of(index_of(info, "index"), static_cast<int>(number(info, "texCoord", 0)),
                   member(member(info, "extensions"), "KHR_texture_transform"));
}

void read_material(importer &g, const tinygltf::Material &from)
{
    struct scene_material m = scene_material_default();
    const auto &pbr = from.pbrMetallicRoughness;
    double factor[4];
    for (size_t k = 0; k < 4; k++)
        factor[k] = at(pbr.baseColorFactor, k, 1);
    slot base = slot_of(pbr.baseColorTexture);
    if (const Value *glossy = extension(from.extensions, "KHR_materials_pbrSpecularGlossiness")) {
        for (int k = 0; k < 4; k++)
            factor[k] = component(glossy, "diffuseFactor", k, 1);
        base = slot_of(member(glossy, "diffuseTexture"));
    }
    const double strength = number(extension(from.extensions, "KHR_materials_emissive_strength"), "emissiveStrength", 1);
    const slot glow = slot_of(from.emissiveTexture);
    m.albedo = {static_cast<float>(factor[0]), static_cast<float>(factor[1]), static_cast<float>(factor[2])};
    m.albedo_map = make_map(g, base.texture, base.transform);
    m.emission = {static_cast<float>(at(from.emissiveFactor, 0, 0) * strength), static_cast<float>(at(from.emissiveFactor, 1, 0) * strength),
                  static_cast<float>(at(from.emissiveFactor, 2, 0) * strength)};
    if (m.emission.x > 0 || m.emission.y > 0 || m.emission.z > 0)
        m.emission_map = make_map(g, glow.texture, glow.transform);
    if (from.alphaMode == "MASK" || from.alphaMode == "BLEND") {
        m.alpha = from.alphaMode == "MASK" ? SCENE_CUTOUT : SCENE_BLEND;
        m.opacity = static_cast<float>(factor[3]);
        m.cutoff = static_cast<float>(from.alphaCutoff);
        m.alpha_map = m.albedo_map;
    }
    m.name = strdup(from.name.c_str());
    if (!m.name)
        fail(error_memory());
    check(scene_push_material(g.import->scene, m, nullptr));
    const bool reads_base = m.albedo_map.texture != SCENE_NONE, reads_glow = m.emission_map.texture != SCENE_NONE;
    if (reads_base && reads_glow && base.uv_set != glow.uv_set)
        warnings_add(g.import->warnings, "texture coordinates", "material '%s' reads its textures with different texture coordinates: those of its "
                     "colour are used for both", from.name.c_str());
    g.uv_set.push_back(reads_base ? base.uv_set : reads_glow ? glow.uv_set : -1);
}

int32_t material_of(importer &g, int index)
{
    if (index >= 0 && static_cast<size_t>(index) < g.model.materials.size())
        return index;
    if (index >= 0)
        warnings_add(g.import->warnings, "material missing", "material %d does not exist: white is used", index);
    if (g.default_material == SCENE_NONE) {
        check(scene_push_material(g.import->scene, scene_material_default(), &g.default_material));
        g.uv_set.push_back(-1);
    }
    return g.default_material;
}

// -- meshes ------------------------------------------------------------------------------------

struct triangles {
    std::vector<double> position;
    std::vector<uint32_t> index;
    std::vector<float> uv; // two a corner, where any material reads a texture
    std::vector<int32_t> material;
    bool textured = false;
};

// Corners of the triangles of a list, a strip or a fan (glTF 2.0, 3.7.2.1).
std::vector<uint32_t> corners_of(const std::vector<uint32_t> &index, int mode)
{
    std::vector<uint32_t> corner;
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        corner.assign(index.begin(), index.begin() + static_cast<std::ptrdiff_t>(index.size() / 3 * 3));
        return corner;
    }
    for (size_t i = 0; i + 2 < index.size(); i++) {
        const bool strip = mode == TINYGLTF_MODE_TRIANGLE_STRIP;
        corner.push_back(index[strip ? i : i + 1]);
        corner.push_back(index[strip ? i + 1 + i % 2 : i + 2]);
        corner.push_back(index[strip ? i + 2 - i % 2 : 0]);
    }
    return corner;
}

std::vector<uint32_t> indices_of(const importer &g, const tinygltf::Primitive &primitive, size_t vertices, const char *what)
{
    std::vector<uint32_t> index;
    if (primitive.indices < 0) {
        for (size_t i = 0; i < vertices; i++)
            index.push_back(static_cast<uint32_t>(i));
        return index;
    }
    for (const double value : read_accessor(g.model, primitive.indices, 1, what)) {
        if (!(value >= 0 && value < static_cast<double>(vertices)))
            fail(error_new("%s: index %.0f is out of range: there are %zu vertices", what, value, vertices));
        index.push_back(static_cast<uint32_t>(value));
    }
    return index;
}

// Texture coordinates of each corner, v up; zeros where the primitive has none.
void add_uv(const importer &g, const tinygltf::Primitive &primitive, int set, const std::vector<uint32_t> &corner, size_t vertices,
            const char *what, triangles &to)
{
    const size_t first = to.uv.size();
    to.uv.resize(first + 2 * corner.size());
    const auto attribute = primitive.attributes.find("TEXCOORD_" + std::to_string(set));
    if (set < 0 || attribute == primitive.attributes.end())
        return;
    const std::vector<double> uv = read_accessor(g.model, attribute->second, 2, what);
    if (uv.size() < 2 * vertices)
        fail(error_new("%s: %zu texture coordinates for %zu vertices", what, uv.size() / 2, vertices));
    for (size_t i = 0; i < corner.size(); i++) {
        to.uv[first + 2 * i] = static_cast<float>(uv[2 * static_cast<size_t>(corner[i])]);
        to.uv[first + 2 * i + 1] = static_cast<float>(1 - uv[2 * static_cast<size_t>(corner[i]) + 1]);
    }
    to.textured = true;
}

void add_primitive(importer &g, const tinygltf::Primitive &primitive, const char *what, triangles &to)
{
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP && mode != TINYGLTF_MODE_TRIANGLE_FAN) {
        warnings_add(g.import->warnings, "points and lines", "%s: points and lines are left out", what);
        return;
    }
    if (!primitive.targets.empty())
        warnings_add(g.import->warnings, "morph targets", "%s: morph targets are left out", what);
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end())
        return; // nothing to be drawn: glTF 2.0, 3.7.2.1
    const std::vector<double> vertex = read_accessor(g.model, position->second, 3, what);
    const size_t vertices = vertex.size() / 3, first = to.position.size() / 3;
    if (first + vertices > std::numeric_limits<uint32_t>::max())
        fail(error_new("%s: too many vertices", what));
    const std::vector<uint32_t> corner = corners_of(indices_of(g, primitive, vertices, what), mode);
    const int32_t material = material_of(g, primitive.material);
    to.position.insert(to.position.end(), vertex.begin(), vertex.end());
    for (const uint32_t c : corner)
        to.index.push_back(static_cast<uint32_t>(first) + c);
    to.material.insert(to.material.end(), corner.size() / 3, material);
    add_uv(g, primitive, g.uv_set[static_cast<size_t>(material)], corner, vertices, what, to);
}

template <typename T> T *copy_array(const std::vector<T> &from)
{
    T *to = nullptr;
    check(array_create(&to, from.size(), sizeof(T)));
    if (!from.empty())
        std::memcpy(to, from.data(), from.size() * sizeof(T));
    return to;
}

// Pushes a glTF mesh when it is placed for the first time.
long mesh_of(importer &g, int index)
{
    const size_t i = static_cast<size_t>(index);
    if (index < 0 || i >= g.model.meshes.size())
        fail(error_new("mesh %d does not exist", index));
    if (g.mesh_index[i] != -2)
        return g.mesh_index[i];
    triangles t;
    for (size_t p = 0; p < g.model.meshes[i].primitives.size(); p++) {
        const std::string what = "mesh " + std::to_string(index) + ", primitive " + std::to_string(p);
        add_primitive(g, g.model.meshes[i].primitives[p], what.c_str(), t);
    }
    g.mesh_index[i] = -1;
    if (t.index.empty())
        return -1;
    struct scene_mesh mesh = {};
    try {
        mesh.position = copy_array(t.position);
        mesh.index = copy_array(t.index);
        mesh.material = copy_array(t.material);
        mesh.uv = t.textured ? copy_array(t.uv) : nullptr;
    } catch (...) {
        scene_mesh_clear(&mesh);
        throw;
    }
    mesh.vertex_count = t.position.size() / 3;
    mesh.triangle_count = t.index.size() / 3;
    size_t pushed = 0;
    check(scene_push_mesh(g.import->scene, mesh, &pushed));
    return g.mesh_index[i] = static_cast<long>(pushed);
}

// -- nodes -------------------------------------------------------------------------------------

using matrix = std::array<double, 12>; // rows of a 3x4 matrix

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

matrix matrix_of(const tinygltf::Node &node)
{
    matrix m;
    if (node.matrix.size() == 16) { // column-major
        for (size_t row = 0; row < 3; row++)
            for (size_t k = 0; k < 4; k++)
                m[4 * row + k] = node.matrix[4 * k + row];
        return m;
    }
    double q[4];
    for (size_t k = 0; k < 4; k++)
        q[k] = at(node.rotation, k, k == 3 ? 1 : 0);
    const double norm = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], s = norm > 0 ? 2 / norm : 0;
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double rotation[9] = {1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w),
                                s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w),
                                s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)};
    for (size_t row = 0; row < 3; row++) {
        for (size_t k = 0; k < 3; k++)
            m[4 * row + k] = rotation[3 * row + k] * at(node.scale, k, 1);
        m[4 * row + 3] = at(node.translation, row, 0);
    }
    return m;
}

// KHR_lights_punctual: the light shines along the node's -Z; its intensity is not scaled by the node.
void add_light(importer &g, int index, const matrix &m)
{
    if (index < 0 || static_cast<size_t>(index) >= g.model.lights.size())
        fail(error_new("light %d does not exist", index));
    const tinygltf::Light &from = g.model.lights[static_cast<size_t>(index)];
    struct scene_light light = {};
    if (from.type == "point") {
        light.kind = SCENE_POINT;
    } else if (from.type == "spot") {
        light.kind = SCENE_SPOT;
    } else if (from.type == "directional") {
        light.kind = SCENE_SUN;
    } else {
        fail(error_new("light %d: expected point, spot or directional, got '%.40s'", index, from.type.c_str()));
    }
    light.position = {m[3], m[7], m[11]};
    light.direction = vec3_normalize({-m[2], -m[6], -m[10]});
    for (size_t k = 0; k < 3; k++)
        light.intensity[k] = at(from.color, k, 1) * from.intensity;
    light.range = from.range;
    light.cos_inner = angle_cos(std::min(std::max(from.spot.innerConeAngle, 0.0), ANGLE_PI));
    light.cos_outer = angle_cos(std::min(std::max(from.spot.outerConeAngle, 0.0), ANGLE_PI));
    if (light.cos_outer > light.cos_inner)
        light.cos_outer = light.cos_inner;
    check(scene_push_light(g.import->scene, light));
}

void add_node(importer &g, const tinygltf::Node &node, const matrix &m)
{
    if (node.skin >= 0)
        warnings_add(g.import->warnings, "skins", "skins are left out: skinned meshes stand in their bind pose");
    const long mesh = node.mesh >= 0 ? mesh_of(g, node.mesh) : -1;
    if (mesh >= 0)
        check(scene_push_instance(g.import->scene, static_cast<size_t>(mesh), m.data()));
    const int light = index_of(extension(node.extensions, "KHR_lights_punctual"), "light");
    if (light >= 0)
        add_light(g, light, m);
}

std::vector<int> roots_of(const tinygltf::Model &model)
{
    if (!model.scenes.empty()) {
        const size_t scene = model.defaultScene >= 0 ? static_cast<size_t>(model.defaultScene) : 0;
        if (scene >= model.scenes.size())
            fail(error_new("scene %zu does not exist", scene));
        return model.scenes[scene].nodes;
    }
    std::vector<bool> is_child(model.nodes.size());
    for (const tinygltf::Node &node : model.nodes)
        for (const int child : node.children)
            if (child >= 0 && static_cast<size_t>(child) < is_child.size())
                is_child[static_cast<size_t>(child)] = true;
    std::vector<int> roots;
    for (size_t i = 0; i < is_child.size(); i++)
        if (!is_child[i])
            roots.push_back(static_cast<int>(i));
    return roots;
}

// Walks the nodes without recursion, so that no depth is too deep. Each node has one place, as glTF demands: a second is an error,
// which ends cycles too.
void add_nodes(importer &g)
{
    struct placed {
        int node;
        matrix m;
    };
    matrix identity;
    std::copy(scene_identity, scene_identity + 12, identity.begin());
    std::vector<placed> left;
    std::vector<bool> seen(g.model.nodes.size());
    const std::vector<int> roots = roots_of(g.model);
    for (size_t i = roots.size(); i-- > 0;)
        left.push_back({roots[i], identity});
    while (!left.empty()) {
        const placed next = left.back();
        left.pop_back();
        const size_t i = static_cast<size_t>(next.node);
        if (next.node < 0 || i >= g.model.nodes.size())
            fail(error_new("node %d does not exist", next.node));
        if (seen[i])
            fail(error_new("node %d has two parents, or is its own ancestor", next.node));
        seen[i] = true;
        const tinygltf::Node &node = g.model.nodes[i];
        const matrix m = multiply(next.m, matrix_of(node));
        add_node(g, node, m);
        for (size_t c = node.children.size(); c-- > 0;)
            left.push_back({node.children[c], m});
    }
}

// -- the file ----------------------------------------------------------------------------------

// Keeps an embedded picture as it is: image.c decodes those that a material uses.
bool keep_picture(tinygltf::Image *, const int index, std::string *, std::string *, int, int, const unsigned char *bytes, int size, void *user)
{
    auto &pictures = *static_cast<std::vector<std::vector<unsigned char>> *>(user);
    if (index < 0 || size < 0)
        return false;
    if (pictures.size() <= static_cast<size_t>(index))
        pictures.resize(static_cast<size_t>(index) + 1);
    pictures[static_cast<size_t>(index)].assign(bytes, bytes + size);
    return true;
}

bool is_picture(const std::string &path)
{
    const size_t dot = path.rfind('.');
    std::string ending = dot == std::string::npos ? "" : path.substr(dot + 1);
    std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    static const char *const endings[] = {"png", "jpg", "jpeg", "webp", "ktx2", "dds", "basis", "gif", "bmp", "tga", "hdr"};
    return std::any_of(std::begin(endings), std::end(endings), [&](const char *e) { return ending == e; });
}

// tinygltf looks for every picture beside the file; they are read later, by their use, so here there are none.
bool file_exists(const std::string &path, void *)
{
    return !is_picture(path) && tinygltf::FileExists(path, nullptr);
}

std::string same_path(const std::string &path, void *)
{
    return path; // tinygltf's own would expand ~ and $
}

// The first line of a message, without its newline.
std::string first_line(const std::string &text)
{
    return text.substr(0, text.find('\n'));
}

void parse(importer &g)
{
    char *data = nullptr;
    size_t size = 0;
    check(scene_file_read(g.import->path, &data, &size));
    std::string error, warning, directory = g.import->directory;
    bool good = false;
    try {
        if (size > std::numeric_limits<unsigned>::max())
            fail(error_new("the file is larger than 4 GB"));
        tinygltf::TinyGLTF loader;
        loader.SetImageLoader(keep_picture, &g.pictures);
        loader.SetFsCallbacks({file_exists, same_path, tinygltf::ReadWholeFile, tinygltf::WriteWholeFile, nullptr});
        const unsigned length = static_cast<unsigned>(size);
        if (size >= 4 && !std::memcmp(data, "glTF", 4))
            good = loader.LoadBinaryFromMemory(&g.model, &error, &warning, reinterpret_cast<unsigned char *>(data), length, directory);
        else
            good = loader.LoadASCIIFromString(&g.model, &error, &warning, data, length, directory);
    } catch (...) {
        std::free(data);
        throw;
    }
    std::free(data);
    if (!good)
        fail(error_new("%s", error.empty() ? "not a glTF file that can be read" : first_line(error).c_str()));
    g.pictures.resize(g.model.images.size());
    g.mesh_index.assign(g.model.meshes.size(), -2);
    for (const std::string &name : g.model.extensionsRequired)
        if (std::none_of(std::begin(known_extensions), std::end(known_extensions), [&](const char *known) { return name == known; }))
            fail(error_new("the file requires the extension %.60s, which is not supported", name.c_str()));
}

struct error *read(struct scene_import *import)
{
    try {
        importer g;
        g.import = import;
        parse(g);
        for (const tinygltf::Material &material : g.model.materials)
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
    return scene_guard([import] { return read(import); });
}
