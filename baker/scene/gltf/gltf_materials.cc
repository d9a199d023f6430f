/* Materials, and holes of materials with alphaMode MASK (3.9.4): the alpha of the base colour texture times the alpha of the base
 * colour is compared with alphaCutoff. KHR_texture_transform is applied. If all of a material reaches the cutoff, it has no alpha
 * mask; if nothing does, it has no surface.
 *
 * A bake distinguishes only lit and shadowed. So BLEND is also a mask, with a cutoff of 0.5: where alpha is a, a share 1 - a of the
 * light passes, and choosing the nearer of lit and shadowed has the error min(a, 1 - a). This is never more than the error of
 * always shadowed, 1 - a, or of always lit, a.
 *
 * The JSON of textures, samplers and masked materials is read only for materials of placed triangles. A mask that cannot be read is
 * opaque.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/portable_math.h"
#include "baker/scene/gltf/gltf_loader.h"

#include <cmath>

namespace gltf
{

double number_or(const json &object, const char *name, double otherwise, double most)
{
    auto value = object.find(name);
    if (value == object.end() || !value->is_number()) return otherwise;
    double number = value->get<double>();
    return number >= 0 && number <= most && std::isfinite(number) ? number : otherwise;
}

void numbers_or(const json &object, const char *name, double otherwise, double out[3])
{
    auto values = object.find(name);
    bool good   = values != object.end() && values->is_array() && values->size() >= 3;
    for (size_t n = 0; good && n < 3; n++) good = (*values)[n].is_number() && (*values)[n] >= 0 && (*values)[n] <= 1;
    for (size_t n = 0; n < 3; n++) out[n] = good ? (*values)[n].get<double>() : otherwise;
}

void place_materials(loader &l)
{
    size_t count          = l.materials.size();
    l.s->material_colours = zeroed<float[3]>(count);
    l.s->material_count   = count;
    for (size_t n = 0; n < count; n++) {
        const float *radiance = l.materials[n].radiance;
        memcpy(l.s->material_colours[n], l.materials[n].colour, sizeof l.materials[n].colour);
        l.s->emissive_count += radiance[0] > 0 || radiance[1] > 0 || radiance[2] > 0;
    }
}

static const char *const TRANSMISSION = "KHR_materials_transmission", *const DIFFUSE_TRANSMISSION =
                                                                          "KHR_materials_diffuse_transmission";

/* The extension with which a material lets light through, in addition to alpha; NULL: none. */
static const char *transmission_of(const json &object)
{
    static const struct {
        const char *name, *factor;
    } ways[] = {{TRANSMISSION, "transmissionFactor"}, {DIFFUSE_TRANSMISSION, "diffuseTransmissionFactor"}};
    if (!items(object, "extensions").is_object()) return nullptr;
    for (const auto &way : ways) {
        const json *e = extension(object, way.name);
        if (e && e->is_object() && number_or(*e, way.factor, 0, 1) > 0) return way.name;
    }
    return nullptr;
}

void read_materials(loader &l, const json &root)
{
    static const double grey = 0.45;
    for (const json &object : items(root, "materials")) {
        material    m    = {};
        auto        two  = object.find("doubleSided");
        std::string mode = object.contains("alphaMode") ? text_of(object, "alphaMode") : "OPAQUE";
        m.name           = object.value("name", "");
        m.mode           = mode == "MASK" ? alpha_mode::MASK : mode == "BLEND" ? alpha_mode::BLEND : alpha_mode::SOLID;
        if (m.mode == alpha_mode::SOLID && mode != "OPAQUE")
            m.odd = "unknown alphaMode '" + mode.substr(0, 40) + "': taken as OPAQUE";
        if (two != object.end() && !two->is_boolean()) m.odd = "'doubleSided' is not true or false: taken as false";
        m.double_sided = two != object.end() && *two == true;
        m.transmits    = transmission_of(object);

        /* for pictures only: a missing or invalid colour is white; a textured surface is grey times its colour */
        const json *older     = extension(object, "KHR_materials_pbrSpecularGlossiness");
        auto        newer     = object.find("pbrMetallicRoughness");
        double      colour[3] = {1, 1, 1}, emitted[3];
        if (older || (newer != object.end() && newer->is_object())) {
            const json &base = older ? *older : *newer;
            numbers_or(base, older ? "diffuseFactor" : "baseColorFactor", 1, colour);
            if (base.contains(older ? "diffuseTexture" : "baseColorTexture"))
                for (double &c : colour) c *= grey;
        }
        const json *stronger = extension(object, "KHR_materials_emissive_strength");
        double      strength = stronger ? number_or(*stronger, "emissiveStrength", 1, 1e30) : 1;
        numbers_or(object, "emissiveFactor", 0, emitted);
        for (size_t n = 0; n < 3; n++) {
            m.colour[n]   = (float)colour[n];
            m.radiance[n] = (float)(strength * emitted[n]);
        }
        l.materials.push_back(m);
    }
}

/* Item `index` of a list of the file. Throws if there is none. */
static const json &item(loader &l, const std::string &where, const char *list, const char *kind, size_t index)
{
    const json &all = items(l.rest, list);
    if (!all.is_array() || index >= all.size() || !all[index].is_object()) l.broken(where, "%s %zu does not exist", kind, index);
    return all[index];
}

/* The image number of a texture. */
size_t texture_image(loader &l, const std::string &where, const json &texture)
{
    const json *source = &texture;
    const json *webp   = extension(texture, "EXT_texture_webp");
    if (webp && webp->contains("source")) source = webp;
    for (const char *name : {"KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_avif"})
        if (!source->contains("source") && extension(texture, name))
            l.unsupported(where, "its image is one of %s alone, which is not read: expected PNG, JPEG or WebP beside it", name);
    check_shape(l, where + " texture", *source, {{"source", is::index, true}});
    item(l, where, "images", "image", (*source)["source"]);
    return (*source)["source"];
}

static texture_wrap wrap_mode(loader &l, const std::string &where, const json &sampler, const char *name)
{
    json mode = sampler.value(name, json(10497));
    if (mode != 10497 && mode != 33071 && mode != 33648) l.broken(where + " sampler", "'%s' is not 10497, 33071 or 33648", name);
    return mode == 10497 ? WRAP_REPEAT : mode == 33071 ? WRAP_CLAMP : WRAP_MIRROR;
}

void read_sampler(loader &l, const std::string &where, const json &texture, alpha_mask &out)
{
    json sampler = json::object();
    check_shape(l, where + " texture", texture, {{"sampler", is::index}});
    if (texture.contains("sampler")) sampler = item(l, where, "samplers", "sampler", texture["sampler"]);
    out.nearest = sampler.value("magFilter", json()) == 9728;
    out.wrap_u  = wrap_mode(l, where, sampler, "wrapS");
    out.wrap_v  = wrap_mode(l, where, sampler, "wrapT");
}

/* Order: scale, then rotation, counter-clockwise as seen in the image (where v goes down), then translation. */
texture_place read_texture_place(loader &l, const std::string &where, const json &info)
{
    static constexpr shape members = {
        {"offset", is::numbers, false, 2}, {"scale", is::numbers, false, 2}, {"texCoord", is::index}, {"rotation", is::number}};
    const json   *moved = check_extension(l, where, info, "KHR_texture_transform", members);
    texture_place place;
    place.uv_set = info.value("texCoord", (size_t)0);
    if (!moved) return place;

    std::vector<double> offset = moved->value("offset", std::vector<double>{0, 0}),
                        scale  = moved->value("scale", std::vector<double>{1, 1});
    double       angle = moved->value("rotation", 0.0), c = portable_cos(angle), s = portable_sin(angle);
    const double matrix[6] = {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
    memcpy(place.transform, matrix, sizeof matrix);
    place.uv_set = moved->value("texCoord", place.uv_set);
    return place;
}

const json &texture_of(loader &l, const std::string &where, const json &info)
{
    check_shape(l, where, info, {{"index", is::index, true}, {"texCoord", is::index}, {"extensions", is::extensions}});
    const json &texture = item(l, where, "textures", "texture", info["index"]);
    check_shape(l, where + " texture", texture, {{"extensions", is::extensions}});
    return texture;
}

/* Set the holes of a material: where the texture's alpha is below the threshold. */
static void read_texture(loader &l, const std::string &where, const json &info, material &m)
{
    const json  &texture = texture_of(l, where, info);
    size_t       index   = texture_image(l, where, texture);
    image_alpha &image   = use_image(l, index);

    alpha_mask added = {};
    added.threshold  = (float)m.threshold;
    m.is_clear |= image.least < 255;
    m.is_nothing |= image.most == 0;
    m.surface = (float)image.least / 255.0f >= added.threshold ? material::EVERYWHERE
                : (float)image.most / 255.0f < added.threshold ? material::NOWHERE
                                                               : material::WITH_HOLES;
    if (m.surface == material::EVERYWHERE && !image.has_alpha && m.mode == alpha_mode::MASK)
        m.trap = "is a mask, but " + label("image", index) + " has no alpha: there are no holes";
    if (m.surface != material::WITH_HOLES) return;
    read_sampler(l, where, texture, added);
    m.holes      = read_texture_place(l, where, info);
    m.alpha_mask = (uint32_t)l.alpha_masks.size();
    if (image.in_scene == SIZE_MAX) {
        image.in_scene = l.hole_images.size();
        l.hole_images.push_back(&image);
    }
    added.image = (uint32_t)image.in_scene;
    l.alpha_masks.push_back(added);
}

/* The factors of a material's alpha. */
struct alpha_source {
    double      factor;
    const json *texture; /* NULL: none */
};

static alpha_source alpha_of(loader &l, const std::string &where, const json &object)
{
    static const json nothing = json::object();
    check_shape(l, where, object, {{"pbrMetallicRoughness", is::object}, {"extensions", is::extensions}});
    const json *older  = extension(object, "KHR_materials_pbrSpecularGlossiness");
    auto        newer  = object.find("pbrMetallicRoughness");
    const json &base   = older ? *older : newer != object.end() ? *newer : nothing;
    const char *factor = older ? "diffuseFactor" : "baseColorFactor", *texture = older ? "diffuseTexture" : "baseColorTexture";
    check_shape(l, where, base, {{factor, is::numbers, false, 4}, {texture, is::object}});
    return {base.contains(factor) ? base[factor][3].get<double>() : 1, base.contains(texture) ? &base[texture] : nullptr};
}

static void read_mask(loader &l, const std::string &where, const json &object, material &m)
{
    alpha_source alpha = alpha_of(l, where, object);
    json         given = m.mode == alpha_mode::BLEND ? json(0.5) : object.value("alphaCutoff", json(0.5));
    if (!given.is_number() || !(given.get<double>() >= 0)) l.broken(where, "'alphaCutoff' is not a number, 0 or more");
    double cutoff = given.get<double>(); /* of BLEND 0.5: half of the light passes */
    m.threshold   = alpha.factor > 0 ? cutoff / alpha.factor : INFINITY;
    m.is_clear    = alpha.factor < 1;
    m.is_nothing  = !(alpha.factor > 0);
    if (cutoff <= 0 && alpha.texture) m.trap = "alphaCutoff is 0, which any alpha reaches: there are no holes";
    if (cutoff > 0 && !(m.threshold <= 1)) m.surface = material::NOWHERE;
    if (cutoff > 0 && m.threshold <= 1 && alpha.texture) read_texture(l, where, *alpha.texture, m);
}

/* BLEND with --blend opaque or exclude: alpha 0 everywhere has no surface, alpha 1 everywhere is opaque, in both modes. */
static void read_whole(loader &l, const std::string &where, const json &object, material &m)
{
    alpha_source alpha = alpha_of(l, where, object);
    m.is_clear         = alpha.factor < 1;
    m.is_nothing       = !(alpha.factor > 0);
    if (alpha.texture && !m.is_nothing) {
        const image_alpha &image = use_image(l, texture_image(l, where, texture_of(l, where, *alpha.texture)));
        m.is_clear |= image.least < 255;
        m.is_nothing = image.most == 0;
    }
    if (m.is_nothing || (m.is_clear && l.choice->blend == BLEND_EXCLUDE)) m.surface = material::NOWHERE;
}

material &use_material(loader &l, size_t index)
{
    material &m = l.materials[index];
    if (m.surface != material::UNKNOWN) return m;
    const json &object = items(l.rest, "materials")[index];
    std::string where  = label("material", l.materials, index);
    bool        whole  = m.mode == alpha_mode::BLEND && l.choice->blend != BLEND_MASK;
    m.surface          = material::EVERYWHERE;
    if (m.mode != alpha_mode::SOLID)
        m.fault = caught([&] { whole ? read_whole(l, where, object, m) : read_mask(l, where, object, m); }).text;
    if (!m.fault.empty()) m.surface = material::EVERYWHERE;
    if (m.transmits == TRANSMISSION && l.choice->blend == BLEND_EXCLUDE) m.surface = material::NOWHERE;
    return m;
}

/* ---- notes about materials, after their triangles are counted ---- */

/* Warn of a material that lets light through, with the reason and how it is baked. */
static void warn_about_light(loader &l, size_t index, const material &m, const std::string &where)
{
    std::string exclude = exclude_remedy("material:", index, m.name);
    bool        blends  = m.mode == alpha_mode::BLEND && m.fault.empty() && m.is_clear && !m.is_nothing;
    if (l.choice->blend_given) return;
    if (blends && m.surface == material::NOWHERE)
        take_note(l, cost::PRIMITIVE, (uint64_t)1 << 62 | index, where,
                  "alphaMode BLEND, with an alpha below 0.5 everywhere, casts nothing",
                  "set alphaMode to OPAQUE, or give --blend: mask says that this is meant, opaque bakes walls", m.left_out);
    else if (blends)
        take_note(
            l, cost::BLEND, index, where,
            "alphaMode BLEND is baked as a mask, a wall where alpha is 0.5 or more and nothing elsewhere",
            "set alphaMode to MASK or OPAQUE, or give --blend: mask says that this is meant, opaque bakes walls, exclude nothing",
            m.triangles);
    else if (m.transmits)
        take_note(l, cost::BLEND, index, where, std::string(m.transmits) + " lets light through, and is baked as a wall",
                  (m.transmits == TRANSMISSION
                       ? "--blend exclude leaves such materials out, --blend opaque says that walls are meant, "
                       : "") +
                      exclude,
                  m.triangles);
}

static void warn_about_material(loader &l, size_t index, const material &m)
{
    std::string where = label("material", l.materials, index) + m.used_by, image = "store its image as PNG or WebP, or ";
    if (m.surface == material::NOWHERE && m.mode == alpha_mode::MASK && m.left_out)
        take_note(l, cost::PRIMITIVE, (uint64_t)1 << 62 | index, label("material", l.materials, index),
                  "its alpha is below the cutoff everywhere", "lower alphaCutoff, or set alphaMode to OPAQUE", m.left_out);
    if (!m.odd.empty() && m.triangles) take_note(l, cost::MATERIAL, (uint64_t)1 << 62 | index, where, m.odd, "export it again");
    if (!m.trap.empty() && m.triangles)
        take_note(l, cost::TRAP, index, where, m.trap,
                  m.trap[0] == 'i' ? "store it with its alpha as PNG or WebP, or set alphaMode to OPAQUE"
                                   : "raise alphaCutoff, or set alphaMode to OPAQUE",
                  m.triangles);
    if (!m.fault.empty() && m.triangles)
        take_note(l, cost::MASK, index, where, why_of({VXS_E_SCENE, m.fault, false}, label("material", l.materials, index)),
                  (m.fault.find("image") < std::string::npos ? image : "mend it, or ") + exclude_remedy("material:", index, m.name),
                  m.triangles);
    if (m.triangles || m.left_out) warn_about_light(l, index, m, where);
}

/* ---- materials of primitives ---- */

const elements &attribute_of(loader &l, const std::string &where, const placement &p, const std::string &name)
{
    if (p.draco && p.draco->attributes.count(name)) return p.draco->attributes.at(name);
    int             accessor = attribute(p.primitive->attributes, name);
    const elements &e        = sound_accessor(l, where, name.c_str(), accessor);
    if (e.count != p.positions->count)
        l.broken(where, "%zu elements of %s, expected %zu", e.count, name.c_str(), p.positions->count);
    return use_accessor(l, (size_t)accessor);
}

/* Find the texture coordinates. Some exporters write a third component, 0: components after the second are ignored. */
void find_uvs(loader &l, const std::string &where, placement &p)
{
    std::string name = "TEXCOORD_" + std::to_string(p.material->holes.uv_set);
    if (attribute(p.primitive->attributes, name) < 0)
        l.broken(where, "no %s, which the mask of %s needs", name.c_str(),
                 label("material", l.materials, (size_t)p.primitive->material).c_str());
    const elements &e     = attribute_of(l, where, p, name);
    bool            plain = e.component == TINYGLTF_COMPONENT_TYPE_FLOAT || e.normalized;
    bool            many  = e.type == TINYGLTF_TYPE_VEC2 || e.type == TINYGLTF_TYPE_VEC3 || e.type == TINYGLTF_TYPE_VEC4;
    if (!many || e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT || (!plain && !l.quantization))
        l.broken(where + ", " + e.label, "%s is not a VEC2 of floats or normalised unsigned integers", name.c_str());
    p.uvs     = &e;
    bool same = e.count > 0;
    for (size_t i = 1; i < e.count && same; i++) same = e.value(i, 0) == e.value(0, 0) && e.value(i, 1) == e.value(0, 1);
    if (same)
        take_note(l, cost::TRAP, (uint64_t)3 << 32 | (uint64_t)p.primitive->material, where,
                  "its texture coordinates are all one: its mask is one pixel of the image",
                  "give it texture coordinates, or a material without a mask", p.triangles);
}

/* Invalid colours are ignored: a bake does not need them. */
void warn_about_colors(loader &l, const std::string &where, size_t node, const placement &p)
{
    int accessor = attribute(p.primitive->attributes, "COLOR_0");
    if (accessor < 0 || (size_t)accessor >= l.accessors.size() || l.accessors[accessor].type != TINYGLTF_TYPE_VEC4) return;
    const elements *e    = nullptr;
    bool            seen = false;
    failure         f    = caught([&] { e = &attribute_of(l, where, p, "COLOR_0"); });
    for (size_t i = 0; e && i < e->count && !seen; i++) seen = e->value(i, 3) != 1;
    if (seen)
        take_note(l, cost::COLOUR, (uint64_t)l.model.nodes[node].mesh << 32 | p.index, where, "the alpha of COLOR_0 is ignored",
                  "where it makes holes, put it into the texture of the base colour");
}

bool append_mask_triangle(loader &l, const placement &p, const uint32_t element[3])
{
    const double  *t   = p.material->holes.transform;
    holed_triangle out = {(uint32_t)l.s->triangle_count, p.material->alpha_mask, {}};
    for (int k = 0; k < 3; k++) {
        double u = p.uvs->value(element[k], 0), v = p.uvs->value(element[k], 1);
        out.uv[k][0] = (float)(t[0] * u + t[1] * v + t[2]);
        out.uv[k][1] = (float)(t[3] * u + t[4] * v + t[5]);
        if (!std::isfinite(out.uv[k][0]) || !std::isfinite(out.uv[k][1])) return false;
    }
    l.holed_triangles.push_back(out);
    return true;
}

void place_masks(loader &l)
{
    scene *s = l.s;
    for (size_t i = 0; i < l.materials.size(); i++) {
        const material &m = l.materials[i];
        warn_about_material(l, i, m);
        if (m.surface == material::NOWHERE && m.mode != alpha_mode::MASK) l.exclusions.back().triangles += m.left_out;
    }
    if (l.holed_triangles.empty()) return;

    s->images = zeroed<alpha_image>(l.hole_images.size());
    for (const image_alpha *image : l.hole_images)
        s->images[s->image_count++] = {image->width_px, image->height_px, copied(image->alpha)};
    s->alpha_masks          = copied(l.alpha_masks);
    s->alpha_mask_count     = l.alpha_masks.size();
    s->holed_triangles      = copied(l.holed_triangles);
    s->holed_triangle_count = l.holed_triangles.size();
}

} // namespace gltf
