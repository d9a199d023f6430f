/* alphaMode MASK (3.9.4): where a material has holes. The alpha of the base colour's texture, times the base colour's own, is held
 * against alphaCutoff; KHR_texture_transform moves the texture. What is met everywhere is no mask, what is met nowhere no surface.
 *
 * The JSON of materials, textures and samplers is looked at here, and only when triangles are placed that need it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace gltf
{

static const json nothing = json::object();

static const json &member(const json &object, const char *name)
{
    auto found = object.find(name);
    return found == object.end() ? nothing : *found;
}

static std::string name_of(const loader &l, size_t material)
{
    return label("material", material, l.materials[material].name);
}

/* Item `index` of a list of the file, or NULL after an error. */
static const json *item(loader &l, const std::string &where, const char *list, const char *kind, size_t index)
{
    const json &all = items(*l.rest, list);
    if (all.is_array() && index < all.size() && all[index].is_object()) return &all[index];
    l.error(VXS_E_SCENE, "%s: %s %zu does not exist", where.c_str(), kind, index);
    return nullptr;
}

/* The image that a texture shows. */
static vxs_result texture_image(loader &l, const std::string &where, const json &texture, size_t &image)
{
    const json *source = &texture;
    const json *webp   = extension(texture, "EXT_texture_webp");
    if (webp && webp->contains("source")) source = webp;
    for (const char *name : {"KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_avif"})
        if (!source->contains("source") && extension(texture, name))
            return l.error(VXS_E_UNSUPPORTED, "%s: its mask is an image of %s", where.c_str(), name);
    vxs_result r = check_shape(l, where + " texture", *source, {{"source", is::index, true}});
    if (r != VXS_OK) return r;
    image = (*source)["source"].get<size_t>();
    return item(l, where, "images", "image", image) ? VXS_OK : VXS_E_SCENE;
}

static vxs_result wrap_mode(loader &l, const std::string &where, const json &sampler, const char *name, texture_wrap &wrap)
{
    json mode = sampler.value(name, json(10497));
    if (mode != 10497 && mode != 33071 && mode != 33648)
        return l.error(VXS_E_SCENE, "%s sampler: '%s' is not 10497, 33071 or 33648", where.c_str(), name);
    wrap = mode == 10497 ? WRAP_REPEAT : mode == 33071 ? WRAP_CLAMP : WRAP_MIRROR;
    return VXS_OK;
}

static vxs_result read_sampler(loader &l, const std::string &where, const json &texture, alpha_mask &mask)
{
    const json *sampler = &nothing;
    vxs_result  r       = check_shape(l, where + " texture", texture, {{"sampler", is::index}});
    if (r != VXS_OK) return r;
    if (texture.contains("sampler") && !(sampler = item(l, where, "samplers", "sampler", texture["sampler"].get<size_t>())))
        return VXS_E_SCENE;
    mask.nearest = sampler->value("magFilter", json()) == 9728;
    if ((r = wrap_mode(l, where, *sampler, "wrapS", mask.wrap_u)) != VXS_OK) return r;
    return wrap_mode(l, where, *sampler, "wrapT", mask.wrap_v);
}

/* Scaled, then turned counter-clockwise as seen in the image, whose v goes down, then moved. */
static vxs_result read_texture_transform(loader &l, const std::string &where, const json &info, material_mask &m)
{
    m.uv_set          = info.value("texCoord", json(0)).get<size_t>();
    const json *moved = extension(info, "KHR_texture_transform");
    if (!moved) return VXS_OK;
    static const std::vector<property> shape = {
        {"offset", is::numbers, false, 2}, {"scale", is::numbers, false, 2}, {"texCoord", is::index}};
    vxs_result r = check_shape(l, where + " KHR_texture_transform", *moved, shape);
    if (r != VXS_OK) return r;
    json angle = moved->value("rotation", json(0));
    if (!angle.is_number()) return l.error(VXS_E_SCENE, "%s KHR_texture_transform: 'rotation' is not a number", where.c_str());

    std::vector<double> offset = moved->value("offset", std::vector<double>{0, 0}),
                        scale  = moved->value("scale", std::vector<double>{1, 1});
    double       c = std::cos(angle.get<double>()), s = std::sin(angle.get<double>());
    const double matrix[6] = {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
    memcpy(m.uv_transform, matrix, sizeof matrix);
    m.uv_set = moved->value("texCoord", m.uv_set);
    return VXS_OK;
}

/* The scene's number of a mask, and of its image. */
static void add_mask(loader &l, image_alpha &image, alpha_mask mask, material_mask &m)
{
    if (image.in_scene == SIZE_MAX) {
        image.in_scene = l.mask_images.size();
        l.mask_images.push_back(&image);
    }
    mask.image = (uint32_t)image.in_scene;
    m.mask     = (uint32_t)l.masks.size();
    l.masks.push_back(mask);
}

static vxs_result read_texture(loader &l, const std::string &where, const json &info, material_mask &m)
{
    size_t       image_index = 0;
    image_alpha *image;
    alpha_mask   mask = {};
    vxs_result   r;
    if ((r = check_shape(l, where, info, {{"index", is::index, true}, {"texCoord", is::index}, {"extensions", is::extensions}})) !=
        VXS_OK)
        return r;
    const json *texture = item(l, where, "textures", "texture", info["index"].get<size_t>());
    if (!texture) return VXS_E_SCENE;
    if ((r = check_shape(l, where + " texture", *texture, {{"extensions", is::extensions}})) != VXS_OK) return r;
    if ((r = texture_image(l, where, *texture, image_index)) != VXS_OK) return r;
    if ((r = use_image(l, image_index, image)) != VXS_OK) return r;
    mask.threshold = (float)m.threshold;
    if ((float)image->least / 255.0f >= mask.threshold) return m.kind = material_mask::PLAIN, VXS_OK;
    if ((float)image->most / 255.0f < mask.threshold) return m.kind = material_mask::NOWHERE, VXS_OK;

    m.kind = material_mask::HOLES;
    if ((r = read_sampler(l, where, *texture, mask)) != VXS_OK) return r;
    if ((r = read_texture_transform(l, where, info, m)) != VXS_OK) return r;
    add_mask(l, *image, mask, m);
    return VXS_OK;
}

static vxs_result read_mask(loader &l, size_t index, material_mask &m)
{
    const json &object = items(*l.rest, "materials")[index];
    std::string where  = name_of(l, index);
    vxs_result  r;
    if ((r = check_shape(l, where, object, {{"pbrMetallicRoughness", is::object}, {"extensions", is::extensions}})) != VXS_OK)
        return r;
    const json *older  = extension(object, "KHR_materials_pbrSpecularGlossiness");
    const json &base   = older ? *older : member(object, "pbrMetallicRoughness");
    const char *factor = older ? "diffuseFactor" : "baseColorFactor", *texture = older ? "diffuseTexture" : "baseColorTexture";
    if ((r = check_shape(l, where, base, {{factor, is::numbers, false, 4}, {texture, is::object}})) != VXS_OK) return r;
    json cutoff = object.value("alphaCutoff", json(0.5));
    if (!cutoff.is_number() || !(cutoff.get<double>() >= 0))
        return l.error(VXS_E_SCENE, "%s: 'alphaCutoff' is not a number, 0 or more", where.c_str());

    double alpha = base.contains(factor) ? base[factor][3].get<double>() : 1;
    m.threshold  = alpha > 0 ? cutoff.get<double>() / alpha : INFINITY;
    if (cutoff.get<double>() <= 0)
        m.kind = material_mask::PLAIN;
    else if (!(m.threshold <= 1))
        m.kind = material_mask::NOWHERE;
    else if (!base.contains(texture))
        m.kind = material_mask::PLAIN;
    else
        return read_texture(l, where, base[texture], m);
    return VXS_OK;
}

vxs_result use_material(loader &l, int index, const material_mask *&out)
{
    material &m = l.materials[(size_t)index];
    out         = &m.holes;
    if (m.holes.kind != material_mask::UNKNOWN) return VXS_OK;
    if (m.mask) return read_mask(l, (size_t)index, m.holes);
    m.holes.kind = material_mask::PLAIN;
    return VXS_OK;
}

/* The elements of a further attribute of a primitive. */
static vxs_result further_attribute(loader &l, const std::string &where, const placement &p, const std::string &name,
                                    const elements *&e)
{
    int accessor = attribute(p.primitive->attributes, name.c_str());
    if (accessor < 0 || (size_t)accessor >= l.accessors.size())
        return l.error(VXS_E_SCENE, "%s has no %s, which the mask of %s needs", where.c_str(), name.c_str(),
                       name_of(l, (size_t)p.primitive->material).c_str());
    vxs_result r = VXS_OK;
    if (p.draco && p.draco->attributes.count(name))
        e = &p.draco->attributes.at(name);
    else
        r = use_accessor(l, accessor, e);
    if (r == VXS_OK && e->count != p.positions->count)
        return l.error(VXS_E_SCENE, "%s: %zu elements of %s, expected %zu", where.c_str(), e->count, name.c_str(),
                       p.positions->count);
    return r;
}

vxs_result open_mask(loader &l, const std::string &where, placement &p)
{
    std::string name = "TEXCOORD_" + std::to_string(p.mask->uv_set);
    int         accessor;
    vxs_result  r;
    if ((r = further_attribute(l, where, p, name, p.uvs)) != VXS_OK) return r;
    accessor                        = attribute(p.primitive->attributes, name.c_str());
    const tinygltf::Accessor &a     = l.model.accessors[(size_t)accessor];
    bool                      plain = a.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT ||
                 (a.normalized && (a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                                   a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT));
    if (a.type != TINYGLTF_TYPE_VEC2 || a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT || (!plain && !l.quantization))
        return l.error(VXS_E_SCENE, "%s, %s: %s is not a VEC2 of floats or normalised unsigned integers", where.c_str(),
                       label("accessor", (size_t)accessor, a.name).c_str(), name.c_str());
    return VXS_OK;
}

void warn_about_colors(loader &l, const std::string &where, const placement &p)
{
    const elements *e;
    int             accessor = attribute(p.primitive->attributes, "COLOR_0");
    if (accessor < 0 || (size_t)accessor >= l.accessors.size() || l.model.accessors[(size_t)accessor].type != TINYGLTF_TYPE_VEC4)
        return;
    message quiet = {};
    quiet.quiet   = 1;
    std::swap(quiet, *l.m); /* a broken colour is not this baker's business */
    vxs_result r = further_attribute(l, where, p, "COLOR_0", e);
    std::swap(quiet, *l.m);
    message_free(&quiet);
    if (r != VXS_OK) return;
    for (size_t i = 0; i < e->count; i++)
        if (component_at(e->data + i * e->stride + 3 * component_bytes(e->component), e->component, e->normalized) != 1) {
            warn(l.m, "%s: the alpha of COLOR_0 is ignored", where.c_str());
            return;
        }
}

/* u and v of an accessor's element, moved; false when they are not finite. */
static bool read_uv(const placement &p, uint32_t element, float uv[2])
{
    const elements      &e  = *p.uvs;
    const unsigned char *at = e.data + element * e.stride;
    const double        *t  = p.mask->uv_transform;
    double               u  = component_at(at, e.component, e.normalized),
           v                = component_at(at + component_bytes(e.component), e.component, e.normalized);
    uv[0]                   = (float)(t[0] * u + t[1] * v + t[2]);
    uv[1]                   = (float)(t[3] * u + t[4] * v + t[5]);
    return std::isfinite(uv[0]) && std::isfinite(uv[1]);
}

vxs_result append_mask_triangles(loader &l, const placement &p, size_t first)
{
    for (size_t t = 0; t < p.triangles; t++) {
        mask_triangle out = {(uint32_t)(first + t), p.mask->mask, {}};
        uint32_t      element[3];
        triangle_elements(p, t, element);
        for (int i = 0; i < 3; i++)
            if (!read_uv(p, element[i], out.uv[i])) {
                size_t accessor =
                    (size_t)attribute(p.primitive->attributes, ("TEXCOORD_" + std::to_string(p.mask->uv_set)).c_str());
                return l.error(VXS_E_SCENE, "%s: texture coordinate %u is not finite",
                               label("accessor", accessor, l.model.accessors[accessor].name).c_str(), element[i]);
            }
        l.mask_triangles.push_back(out);
    }
    return VXS_OK;
}

template <typename T> static T *copied(const std::vector<T> &from)
{
    T *to = (T *)malloc(std::max(from.size(), (size_t)1) * sizeof(T));
    if (!to) throw std::bad_alloc();
    if (!from.empty()) memcpy(to, from.data(), from.size() * sizeof(T));
    return to;
}

vxs_result place_masks(loader &l)
{
    scene *s = l.s;
    for (size_t i = 0; i < l.materials.size(); i++)
        if (l.materials[i].holes.left_out)
            warn(l.m, "%s: its alpha is below the cutoff everywhere: %zu triangles left out", name_of(l, i).c_str(),
                 l.materials[i].holes.left_out);
    if (l.mask_triangles.empty()) return VXS_OK;

    s->images = (alpha_image *)calloc(l.mask_images.size(), sizeof *s->images);
    if (!s->images) throw std::bad_alloc();
    for (const image_alpha *image : l.mask_images) {
        s->images[s->image_count] = {image->width_px, image->height_px, copied(image->alpha)};
        s->image_count++;
    }
    s->masks               = copied(l.masks);
    s->mask_count          = l.masks.size();
    s->mask_triangles      = copied(l.mask_triangles);
    s->mask_triangle_count = l.mask_triangles.size();
    return VXS_OK;
}

} // namespace gltf
