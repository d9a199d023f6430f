/* Extensions that a file uses or requires. An extension that is neither implemented nor known to be irrelevant to shadows may
 * change shapes, places, lights or visibility. A file that requires such an extension is refused; a file that uses it gets a
 * warning.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include <algorithm>
#include <iterator>
#include <set>

namespace gltf
{

/* clang-format off */
/* Implemented, as far as a bake needs them. */
static const char *const known_to_be_read[] = {
    "EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "EXT_texture_webp", "KHR_draco_mesh_compression", "KHR_lights_punctual",
    "KHR_materials_diffuse_transmission", "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness", "KHR_materials_transmission",
    "KHR_materials_variants", "KHR_mesh_quantization", "KHR_meshopt_compression", "KHR_node_visibility", "KHR_texture_transform"};

/* Irrelevant to shadows: appearance of surfaces, storage of images, animation, sound, touch, metadata. */
static const char *const known_to_be_harmless[] = {
    "ADOBE_materials_clearcoat_specular", "ADOBE_materials_clearcoat_tint", "EXT_materials_clearcoat_color", "EXT_textureInfo_constant_lod",
    "KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_common", "KHR_materials_diffuse_roughness", "KHR_materials_dispersion",
    "KHR_materials_ior", "KHR_materials_iridescence", "KHR_materials_sheen", "KHR_materials_specular", "KHR_materials_unlit", "KHR_materials_volume",
    "KHR_materials_volume_scatter", "MOZ_lightmap", "MSFT_packing_normalRoughnessMetallic", "MSFT_packing_occlusionRoughnessMetallic", "NV_materials_mdl",
    "VRMC_materials_hdr_emissiveMultiplier", "VRMC_materials_mtoon",

    "EXT_texture_astc", "EXT_texture_avif", "KHR_texture_basisu", "MOZ_texture_rgbe", "MPEG_texture_video", "MSFT_texture_dds",

    "EXT_lights_ies", "EXT_lights_image_based", "KHR_animation_pointer", "KHR_interactivity", "KHR_node_hoverability", "KHR_node_selectability",
    "VRMC_node_constraint", "VRMC_springBone", "VRMC_springBone_extended_collider", "VRMC_vrm_animation",

    "KHR_audio", "KHR_audio_emitter", "KHR_collision_shapes", "KHR_implicit_shapes", "KHR_physics_rigid_bodies", "KHR_rigid_bodies",
    "MSFT_audio_emitter", "OMI_audio_emitter", "OMI_audio_ogg_vorbis", "OMI_collider", "OMI_link", "OMI_physics_body", "OMI_physics_gravity",
    "OMI_physics_joint", "OMI_physics_shape", "OMI_seat", "OMI_spawn_point",

    "AGI_articulations", "AGI_stk_metadata", "CESIUM_primitive_outline", "EXT_feature_metadata", "EXT_instance_features", "EXT_mesh_features",
    "EXT_mesh_manifold", "EXT_structural_metadata", "FB_geometry_metadata", "FB_ngon_encoding", "GODOT_single_root", "GRIFFEL_bim_data", "KHR_xmp",
    "KHR_xmp_json_ld", "VRM", "VRMC_vrm"};
/* clang-format on */

static bool is_known(const std::string &name)
{
    return std::find(std::begin(known_to_be_read), std::end(known_to_be_read), name) != std::end(known_to_be_read) ||
           std::find(std::begin(known_to_be_harmless), std::end(known_to_be_harmless), name) != std::end(known_to_be_harmless);
}

void check_extensions(loader &l, const json &root)
{
    char shown[NAME_BYTES + 1];
    for (const json &name : items(root, "extensionsRequired"))
        if (!is_known(name))
            l.refused("", "requires the extension %s, which is not read: export it without, or convert it",
                      shorten(shown, NAME_BYTES, name.get_ref<const std::string &>().c_str()));
    std::set<std::string> said;
    for (const json &name : items(root, "extensionsUsed")) {
        if (is_known(name) || !said.insert(name).second) continue;
        take_note(l, cost::EXTENSION, said.size(),
                  std::string("extension ") + shorten(shown, NAME_BYTES, name.get_ref<const std::string &>().c_str()),
                  "used, and not read: what it says of shapes, places, lights or transparency is not baked",
                  "export without it, if it moves a shadow");
    }
}

} // namespace gltf
