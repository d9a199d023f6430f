/* Materials, and where those of alphaMode MASK have holes (3.9.4). The alpha of the base colour's texture, times the base colour's own,
 * is held against alphaCutoff; KHR_texture_transform moves the texture. A material that reaches the cutoff everywhere has no alpha
 * mask, one that reaches it nowhere no surface.
 *
 * The JSON of textures, samplers and masked materials is looked at only when triangles are placed that need it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

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

/* Only pictures ask: what is no colour is white, as when nothing is said, and what is textured is grey times its colour. */
static void read_colour(const json &object, material &m)
{
    static const double grey      = 0.45;
    const json         *older     = extension(object, "KHR_materials_pbrSpecularGlossiness");
    auto                newer     = object.find("pbrMetallicRoughness");
    double              colour[3] = {1, 1, 1};
    if (older || (newer != object.end() && newer->is_object())) {
        const json &base = older ? *older : *newer;
        numbers_or(base, older ? "diffuseFactor" : "baseColorFactor", 1, colour);
        if (base.contains(older ? "diffuseTexture" : "baseColorTexture"))
            for (double &c : colour) c *= grey;
    }
    for (size_t n = 0; n < 3; n++) m.colour[n] = (float)colour[n];
}

void place_materials(loader &l)
{
    size_t count          = l.materials.size();
    l.s->material_colours = (float(*)[3])calloc(count + 1, sizeof *l.s->material_colours);
    if (!l.s->material_colours) throw std::bad_alloc();
    l.s->material_count = count;
    for (size_t n = 0; n < count; n++) memcpy(l.s->material_colours[n], l.materials[n].colour, sizeof l.materials[n].colour);
}

void read_materials(loader &l, const json &root)
{
    for (const json &object : items(root, "materials")) {
        std::string name = object.value("name", ""), mode = object.value("alphaMode", "OPAQUE");
        if (mode != "OPAQUE" && mode != "MASK" && mode != "BLEND")
            l.broken(label("material", l.materials.size(), name), "unknown alphaMode '%s'", mode.c_str());
        material m     = {};
        m.name         = name;
        m.double_sided = object.value("doubleSided", false);
        m.masked       = mode == "MASK";
        read_colour(object, m);
        read_radiance(object, m);
        l.materials.push_back(m);
    }
}

/* Item `index` of a list of the file. */
static const json &item(loader &l, const std::string &where, const char *list, const char *kind, size_t index)
{
    const json &all = items(l.rest, list);
    if (!all.is_array() || index >= all.size() || !all[index].is_object()) l.broken(where, "%s %zu does not exist", kind, index);
    return all[index];
}

/* The image that a texture shows. */
size_t texture_image(loader &l, const std::string &where, const json &texture)
{
    const json *source = &texture;
    const json *webp   = extension(texture, "EXT_texture_webp");
    if (webp && webp->contains("source")) source = webp;
    for (const char *name : {"KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_avif"})
        if (!source->contains("source") && extension(texture, name)) l.unsupported(where, "an image of %s", name);
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

/* Scaled, then turned counter-clockwise as seen in the image, whose v goes down, then moved. */
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
    double       angle = moved->value("rotation", 0.0), c = std::cos(angle), s = std::sin(angle);
    const double matrix[6] = {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
    memcpy(place.transform, matrix, sizeof matrix);
    place.uv_set = moved->value("texCoord", place.uv_set);
    return place;
}

/* Give the scene an alpha mask and its image. Returns the mask's number there. */
static uint32_t add_mask(loader &l, image_alpha &image, alpha_mask added)
{
    if (image.in_scene == SIZE_MAX) {
        image.in_scene = l.hole_images.size();
        l.hole_images.push_back(&image);
    }
    added.image = (uint32_t)image.in_scene;
    l.alpha_masks.push_back(added);
    return (uint32_t)l.alpha_masks.size() - 1;
}

const json &texture_of(loader &l, const std::string &where, const json &info)
{
    check_shape(l, where, info, {{"index", is::index, true}, {"texCoord", is::index}, {"extensions", is::extensions}});
    const json &texture = item(l, where, "textures", "texture", info["index"]);
    check_shape(l, where + " texture", texture, {{"extensions", is::extensions}});
    return texture;
}

static void read_texture(loader &l, const std::string &where, const json &info, material &m)
{
    const json  &texture = texture_of(l, where, info);
    image_alpha &image   = use_image(l, texture_image(l, where, texture));

    alpha_mask added = {};
    added.threshold  = (float)m.threshold;
    m.surface        = (float)image.least / 255.0f >= added.threshold ? material::EVERYWHERE
                       : (float)image.most / 255.0f < added.threshold ? material::NOWHERE
                                                                      : material::WITH_HOLES;
    if (m.surface != material::WITH_HOLES) return;
    read_sampler(l, where, texture, added);
    m.holes      = read_texture_place(l, where, info);
    m.alpha_mask = add_mask(l, image, added);
}

static void read_masked_material(loader &l, size_t index, material &m)
{
    static const json nothing = json::object();
    const json       &object  = items(l.rest, "materials")[index];
    std::string       where   = label("material", l.materials, index);
    check_shape(l, where, object, {{"pbrMetallicRoughness", is::object}, {"extensions", is::extensions}});
    const json *older  = extension(object, "KHR_materials_pbrSpecularGlossiness");
    auto        newer  = object.find("pbrMetallicRoughness");
    const json &base   = older ? *older : newer != object.end() ? *newer : nothing;
    const char *factor = older ? "diffuseFactor" : "baseColorFactor", *texture = older ? "diffuseTexture" : "baseColorTexture";
    check_shape(l, where, base, {{factor, is::numbers, false, 4}, {texture, is::object}});
    json cutoff = object.value("alphaCutoff", json(0.5));
    if (!cutoff.is_number() || !(cutoff.get<double>() >= 0)) l.broken(where, "'alphaCutoff' is not a number, 0 or more");

    double alpha = base.contains(factor) ? base[factor][3].get<double>() : 1;
    m.threshold  = alpha > 0 ? cutoff.get<double>() / alpha : INFINITY;
    if (cutoff.get<double>() <= 0)
        m.surface = material::EVERYWHERE;
    else if (!(m.threshold <= 1))
        m.surface = material::NOWHERE;
    else if (base.contains(texture))
        read_texture(l, where, base[texture], m);
    else
        m.surface = material::EVERYWHERE;
}

material &use_material(loader &l, size_t index)
{
    material &m = l.materials[index];
    if (m.surface == material::UNKNOWN && m.masked) read_masked_material(l, index, m);
    if (!m.masked) m.surface = material::EVERYWHERE;
    return m;
}

/* The elements of a further attribute of a primitive. */
static const elements &further_attribute(loader &l, const std::string &where, const placement &p, const std::string &name)
{
    int accessor = attribute(p.primitive->attributes, name);
    if (accessor < 0)
        l.error(VXS_E_SCENE, "%s has no %s, which the mask of %s needs", where.c_str(), name.c_str(),
                label("material", l.materials, p.primitive->material).c_str());
    bool            in_draco = p.draco && p.draco->attributes.count(name);
    const elements &e        = in_draco ? p.draco->attributes.at(name) : use_accessor(l, accessor);
    if (e.count != p.positions->count)
        l.broken(where, "%zu elements of %s, expected %zu", e.count, name.c_str(), p.positions->count);
    return e;
}

void find_uvs(loader &l, const std::string &where, placement &p)
{
    std::string     name  = "TEXCOORD_" + std::to_string(p.material->holes.uv_set);
    const elements &e     = further_attribute(l, where, p, name);
    bool            plain = e.component == TINYGLTF_COMPONENT_TYPE_FLOAT || (e.normalized && is_unsigned(e.component));
    if (e.type != TINYGLTF_TYPE_VEC2 || e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT || (!plain && !l.quantization))
        l.broken(where + ", " + e.label, "%s is not a VEC2 of floats or normalised unsigned integers", name.c_str());
    p.uvs = &e;
}

void warn_about_colors(loader &l, const std::string &where, const placement &p)
{
    int accessor = attribute(p.primitive->attributes, "COLOR_0");
    if (accessor < 0 || l.accessors[accessor].type != TINYGLTF_TYPE_VEC4) return;
    message kept      = {}; /* a broken colour is not this baker's business */
    kept.memory_bytes = l.m->memory_bytes;
    std::swap(kept, *l.m);
    const elements *e = nullptr;
    try {
        e = &further_attribute(l, where, p, "COLOR_0");
    } catch (const failure &) {
    }
    std::swap(kept, *l.m);
    message_free(&kept);
    for (size_t i = 0; e && i < e->count; i++)
        if (e->value(i, 3) != 1) {
            warn(l.m, "%s: the alpha of COLOR_0 is ignored; where it makes holes, put it into the texture of the base colour",
                 where.c_str());
            return;
        }
}

void append_mask_triangles(loader &l, const placement &p, size_t first)
{
    const double *t = p.material->holes.transform;
    for (size_t i = 0; i < p.triangles; i++) {
        holed_triangle out = {(uint32_t)(first + i), p.material->alpha_mask, {}};
        uint32_t       element[3];
        triangle_elements(p, i, element);
        for (int k = 0; k < 3; k++) {
            double u = p.uvs->value(element[k], 0), v = p.uvs->value(element[k], 1);
            out.uv[k][0] = (float)(t[0] * u + t[1] * v + t[2]);
            out.uv[k][1] = (float)(t[3] * u + t[4] * v + t[5]);
            if (!std::isfinite(out.uv[k][0]) || !std::isfinite(out.uv[k][1]))
                l.broken(p.uvs->label, "texture coordinate %u is not finite", element[k]);
        }
        l.holed_triangles.push_back(out);
    }
}

void place_masks(loader &l)
{
    scene *s = l.s;
    for (size_t i = 0; i < l.materials.size(); i++)
        if (l.materials[i].left_out)
            warn(l.m,
                 "%s: its alpha is below the cutoff everywhere: %zu triangles left out; lower alphaCutoff, or set alphaMode to "
                 "OPAQUE",
                 label("material", l.materials, i).c_str(), l.materials[i].left_out);
    if (l.holed_triangles.empty()) return;

    s->images = (alpha_image *)calloc(l.hole_images.size(), sizeof *s->images);
    if (!s->images) throw std::bad_alloc();
    for (const image_alpha *image : l.hole_images)
        s->images[s->image_count++] = {image->width_px, image->height_px, copied(image->alpha)};
    s->alpha_masks          = copied(l.alpha_masks);
    s->alpha_mask_count     = l.alpha_masks.size();
    s->holed_triangles      = copied(l.holed_triangles);
    s->holed_triangle_count = l.holed_triangles.size();
}

} // namespace gltf
