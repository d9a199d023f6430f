# Every malformed file has a pinned end: refused with one line that names the fault, or accepted because the fault is none to a
# baker, or costs a part of the scene alone. Where nothing is left to bake, the fault is the error.
# The files are other people's (see their README) and not part of this repository.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import resource
import subprocess

import pytest

MEMORY_BYTES = 2 << 30  # of addresses, the libraries' included
SECONDS = 5

# file: what its line says. All end with status 3.
REFUSED = {
    "assimp__IndexOutOfRange_gltf/IndexOutOfRange.gltf": "accessor 0: index 0 is 255",
    "assimp__NoScene.gltf": "its default scene 0 does not exist",
    "assimp__RecursiveNodes.gltf": "node 0 is in a loop of nodes",
    "assimp__badArray_gltf/badArray.gltf": "mesh 0 'Mesh': 'primitives' is not an array of objects",
    "cgltf__BadBasisU.gltf": "parse error at line 1, column 53",
    "gltf1__BoxTextured.glb": "GLB version 1",
    "gltf1__BoxTextured.gltf": "asset.version is 1.0",
    "gltf1__BoxTextured_30af3b.gltf": "asset.version is 1.0",
    "gltf1__BoxTextured_4ebefa.gltf": "asset.version is 1.0",
    "gltf1__Cesium_Air.glb": "GLB version 1",
    "gltf1__Cube_v1.gltf": "asset.version is 1.0",
    "magnum_gltf__animation-invalid-buffer-notfound.gltf": "buffer 1: '/nonexistent1.bin' is not in the scene's folder: --allow-outside reads it",
    "magnum_gltf__animation_missing_target_node_gltf/animation-missing-target-node.gltf": "bufferView 0: byteLength is 0",
    "magnum_gltf__buffer-invalid-short-size-embedded.glb": "buffer 0: the GLB chunk ends after 12 bytes",
    "magnum_gltf__buffer-invalid-short-size-embedded.gltf": "buffer 0: its data URI ends after 12 bytes",
    "magnum_gltf__buffer_invalid_short_size_gltf/buffer-invalid-short-size.gltf": "buffer 0: 'external-data.bin' ends after 12 bytes",
    "magnum_gltf__external-data-order.glb": "cannot read buffer 0, ",
    "magnum_gltf__external-data-order.gltf": "cannot read buffer 0, ",
    "magnum_gltf__image-basis-embedded.glb": "requires the extension GOOGLE_texture_basis",
    "magnum_gltf__image-basis-embedded.gltf": "requires the extension GOOGLE_texture_basis",
    "magnum_gltf__image_invalid_gltf/image-invalid.gltf": "bufferView 0: byteLength is 0",
    "magnum_gltf__material-invalid-ktx.gltf": "requires the extension KHR_texture_ktx",
    "magnum_gltf__mesh-invalid-empty-primitives.gltf": "mesh 0 primitive 0: 'attributes' is missing",
    "magnum_gltf__mesh-invalid-morph-target.gltf": "mesh 0 primitive 0: 'attributes' is missing",
    "magnum_gltf__mesh-invalid-primitive-targets-property.gltf": "mesh 0 primitive 0: 'attributes' is missing",
    "magnum_gltf__mesh-invalid-primitives-property.gltf": "mesh 1: 'primitives' is not an array of objects",
    "magnum_gltf__mesh-invalid-texcoord-flip-attribute-accessor-invalid-component-type.gltf": "accessor 0: 'componentType' is missing",
    "magnum_gltf__mesh-invalid-texcoord-flip-attribute-accessor-missing-component-type.gltf": "accessor 0: 'componentType' is missing",
    "magnum_gltf__mesh-invalid-texcoord-flip-attribute.gltf": "mesh 0 primitive 0: 'attributes' is missing",
    "magnum_gltf__mesh-invalid.gltf": "accessor 16: unknown type 'EEE'",
    "magnum_gltf__mesh-multiple-primitives.gltf": "bufferView 0: byteLength is 0",
    "magnum_gltf__mesh_buffers_gltf/mesh-buffers.gltf": "mesh 16 'Index accessor with no buffer view' primitive 0: 'attributes' is missing",
    "magnum_gltf__mesh_custom_attributes_gltf/mesh-custom-attributes.gltf": "accessor 5: unknown componentType 5124",
    "magnum_gltf__scene-invalid-children-property.gltf": "node 1: 'children' is not an array of indices",
    "magnum_gltf__scene-invalid-cycle.gltf": "node 0 'child is self' is in a loop of nodes",
    "magnum_gltf__scene-invalid-multiple-parents.gltf": "node 2 has two parents, node 0 and node 1",
    "magnum_gltf__scene-invalid-node-oob.gltf": "scene 0: node 7 does not exist",
    "magnum_gltf__scene-invalid.gltf": "node 10 '10': 'mesh' is not an integer from 0 to 2147483647",
    "magnum_gltf__skin-invalid.gltf": "skin 9: 'joints' is missing",
    "magnum_gltf__texture-invalid-ktx-extension-source-property.gltf": "requires the extension KHR_texture_ktx",
    "magnum_gltf__texture-invalid-ktx-layer-then-no-layer.gltf": "requires the extension KHR_texture_ktx",
    "magnum_gltf__texture-invalid-ktx-missing-source-property.gltf": "requires the extension KHR_texture_ktx",
    "magnum_gltf__texture-invalid-ktx-no-layer-then-layer.gltf": "requires the extension KHR_texture_ktx",
    "magnum_gltf__texture-invalid-ktx-source-property.gltf": "requires the extension KHR_texture_ktx",
    "magnum_gltf__texture_ktx_gltf/texture-ktx.gltf": "requires the extension KHR_texture_ktx",
    "magnum_gltf__version-unsupported.gltf": "asset.version is 3.0",
    "magnum_tinygltf__buffer_invalid_no_uri_glb/buffer-invalid-no-uri.glb": "buffer 1 has neither a uri nor a GLB chunk",
    "magnum_tinygltf__buffer_invalid_no_uri_gltf/buffer-invalid-no-uri.gltf": "buffer 1 has neither a uri nor a GLB chunk",
    "magnum_tinygltf__mesh-invalid.gltf": "accessor 12: unknown componentType 5130",
    "magnum_tinygltf__scene-invalid.gltf": "node 10: child 11 does not exist",
    "magnum_tinygltf__skin-invalid-no-joints.gltf": "skin 0: 'joints' is missing",
    "magnum_tinygltf__skin-invalid.gltf": "3: 2 elements at byte 68 do not fit in bufferView 0 of 192 bytes",
    "missing__Sponza.gltf": "cannot read buffer 0, ",
    "tinygltf__invalid-primitive-indices.gltf": "accessor 0: bufferView 1 does not exist",
    "tinygltf__invalid_buffer_index_gltf/invalid-buffer-index.gltf": "bufferView 1: buffer 1 does not exist",
    "tinygltf__issue-416.gltf": "asset.version: expected a text like \"2.0\"",
    "val_accessor__byteoffset_no_bufferview.gltf": "accessor 0: a byteOffset without a bufferView",
    "val_accessor__empty_object.gltf": "accessor 0: 'componentType' is missing",
    "val_accessor__invalid_sparse_count_and_stride.gltf": "accessor 0: sparse count 2 exceeds its 1 elements",
    "val_accessor__small_stride.gltf": "accessor 0: byteStride 4 is less than its elements of 16 bytes",
    "val_animation__sampler_bufferview_bytestride.gltf": "buffer 0 has neither a uri nor a GLB chunk",
    "val_asset__empty_array.gltf": "asset.version: expected a text like \"2.0\"",
    "val_asset__min_version_invalid.gltf": "asset.minVersion is 2.1",
    "val_buffer__empty_object.gltf": "buffer 0: 'byteLength' is missing",
    "val_buffer__invalid_uri_data.glb": "buffer 0: 'data:,...' is not a data URI",
    "val_buffer__no_bin_chunk.glb": "buffer 0 has neither a uri nor a GLB chunk",
    "val_buffer__not_found.gltf": "cannot read buffer 0, ",
    "val_buffer__zero_bytelength.gltf": "buffer 0: byteLength is 0",
    "val_buffer_view__empty_object.gltf": "bufferView 0: 'buffer' is missing",
    "val_buffer_view__zero_bytelength.gltf": "bufferView 0: byteLength is 0",
    "val_glb__empty_file.glb": "the file is empty",
    "val_glb__empty_json_object.glb": "not glTF 2.0: 'asset' is missing",
    "val_glb__invalid_magic.glb": "parse error at line 1, column 1",
    "val_glb__json_and_two_buffers.glb": "GLB chunk 2 is a second one of its type",
    "val_glb__misplaced_bin_chunk.glb": "the second GLB chunk is not BIN",
    "val_glb__only_bin_chunk.glb": "the first GLB chunk is not JSON",
    "val_glb__truncated_chunk_data.glb": "GLB header promises 48 bytes",
    "val_glb__two_bin_chunks.glb": "the first GLB chunk is not JSON",
    "val_glb__two_empty_json_chunks.glb": "chunk of 0 bytes in a file of 28: it must be there, and fit",
    "val_glb__zero_chunk_header.glb": "the first GLB chunk is not JSON",
    "val_image__buffer_view_bytestride.gltf": "buffer 0 has neither a uri nor a GLB chunk",
    "val_image__missing_mime_type_buffer_view.gltf": "buffer 0 has neither a uri nor a GLB chunk",
    "val_json__invalid_syntax.gltf": "parse error at line 1, column 2",
    "val_mesh__accessor_unaligned.gltf": "buffer 0 has neither a uri nor a GLB chunk",
    "val_mesh__accessor_without_bytestride.gltf": "buffer 0 has neither a uri nor a GLB chunk",
    "val_mesh__indices_bytestride.gltf": "buffer 0 has neither a uri nor a GLB chunk",
    "val_mesh__unresolved_indices.gltf": "mesh 0 primitive 0: indices accessor 1 does not exist",
    "val_mesh_data__index_buffer_oob_gltf/index_buffer_oob.gltf": "accessor 0: index 5 is 5",
    "val_mesh_data__joints_no_weights.gltf": "bufferView 0: 32 bytes at byte 0 do not fit in buffer 0 of 16 bytes",
    "val_node__matrix_indecomposable.gltf": "node 0: the last row of its matrix is not 0, 0, 0, 1",
    "val_node__node_loop.gltf": "node 0 is in a loop of nodes",
    "val_node__node_parent_override.gltf": "node 2 has two parents, node 0 and node 1",
    "val_node__unresolved_child_node.gltf": "node 0: child 1 does not exist",
    "val_node__unresolved_skin.gltf": "node 0: skin 0 does not exist",
    "val_root__extensions_non_objects.gltf": "glTF: 'extensions' is not an object of objects",
    "val_root__invalid_array_elements.gltf": "glTF: 'materials' is not an array of objects",
    "val_root__undefined_used_extensions.gltf": "requires the extension KHR_extension",
    "val_scene__unresolved_default_scene.gltf": "its default scene 0 does not exist",
    "val_skin__buffer_view_bytestride.gltf": "buffer 0 has neither a uri nor a GLB chunk",
}

# Why a fault does not matter, and the files that have it. No node of theirs places a triangle, so that there is nothing to bake and
# the status is 5; of those with a status of their own, something is left to bake.
ACCEPTED = {
    "lights are judged when they are baked, and cost themselves alone": [
        "magnum_gltf__light-invalid.gltf",
        "magnum_tinygltf__light-invalid-missing-spot.gltf",
        "magnum_tinygltf__light-invalid.gltf",
        "val_KHR_lights_punctual__empty_light_object.gltf",
        "val_KHR_lights_punctual__empty_object.gltf",
        "val_KHR_lights_punctual__empty_object_2638cb.gltf",
        "val_KHR_lights_punctual__spot_light_without_spot_object.gltf",
        "val_KHR_lights_punctual__unresolved_light_empty_root_array.gltf",
        "val_KHR_lights_punctual__unresolved_light_no_root_ext.gltf",
    ],
    "what has one reading is read so, with a warning: a child that is listed as a root, a matrix beside what it is made of, weights of no target": [
        "magnum_gltf__scene-invalid-child-not-root.gltf",
        "magnum_gltf__scene-transformation.gltf",
        "val_mesh__morph_weights_wrong_count.gltf",
        "val_node__node_weights_invalid.gltf",
        "val_scene__non_root_node.gltf",
    ],
    "types, strides and alignments are what they say, whatever is allowed": [
        "val_glb__unaligned_chunk.glb",
        "magnum_gltf__mesh_primitives_types_gltf/mesh-primitives-types.gltf",
        "magnum_gltf__mesh_unsupported_vertex_formats_gltf/mesh-unsupported-vertex-formats.gltf",
        "val_buffer_view__invalid_stride_multiple.gltf",
        "val_buffer_view__invalid_stride_wrong_target.gltf",
    ],
    "a name that is no text is none": [
        "assimp__badString_gltf/badString.gltf",
    ],
    "data URIs hold what they hold, by any media type": [
        "val_buffer__invalid_uri_data.gltf",
        "val_buffer__invalid_uri_data_mime.gltf",
    ],
    "a number that JSON has not costs what needs it": [
        "val_camera__infinite_znear.gltf",
    ],
    "min and max are not read: what positions are decides": [
        "assimp__BoxBadNormals.glb",
        "magnum_tinygltf__mesh_skin_attributes_gltf/mesh-skin-attributes.gltf",
        "val_accessor_data__out_of_range_elements_sint16_gltf/out_of_range_elements_sint16.gltf",
        "val_accessor_data__out_of_range_elements_uint16_gltf/out_of_range_elements_uint16.gltf",
        "val_accessor_data__out_of_range_elements_uint8_gltf/out_of_range_elements_uint8.gltf",
        "val_mesh__morph_position_accessor_no_bounds.gltf",
        "val_mesh__position_accessor_no_bounds.gltf",
    ],
    "only positions that a triangle uses are looked at, and no node places these": [
        "val_accessor_data__invalid_elements_float_gltf/invalid_elements_float.gltf",
    ],
    "normals, tangents, joints, colours and texture coordinates are not read, nor are attributes of other names": [
        "assimp__Cube_gltf/Cube.gltf",
        "magnum_tinygltf__mesh-invalid-accessor-oob.gltf",
        "magnum_gltf__mesh-embedded.glb",
        "magnum_gltf__mesh-embedded.gltf",
        "magnum_gltf__mesh_gltf/mesh.gltf",
        "magnum_gltf__mesh_skin_attributes_gltf/mesh-skin-attributes.gltf",
        "magnum_gltf__mesh_unordered_attributes_gltf/mesh-unordered-attributes.gltf",
        "magnum_gltf__texcoord_flip_unnormalized_gltf/texcoord-flip-unnormalized.gltf",
        "val_mesh__invalid_attribute.gltf",
        "val_mesh__invalid_indexed_attribute.gltf",
        "val_mesh__morph_attribute_no_base.gltf",
        "val_mesh__uv.gltf",
        "val_mesh_data__normals_tangents_non_unit_invalid_sign_gltf/normals_tangents_non_unit_invalid_sign.gltf",
    ],
    "cameras have no shape that matters, only a place": [
        "magnum_gltf__camera-invalid.gltf",
        "val_camera__empty_objects.gltf",
        "val_camera__orthographic_z.gltf",
    ],
    "morph targets of weight 0 are not read": [
        "val_mesh__unresolved_morph_positions.gltf",
    ],
    "animations are not played": [
        "magnum_gltf__animation_splines_sharing_gltf/animation-splines-sharing.gltf",
        "val_KHR_animation_pointer__invalid_channel_target_path.gltf",
        "val_KHR_animation_pointer__missing_pointer.gltf",
        "val_animation__channel_node_matrix.gltf",
        "val_animation__empty_array.gltf",
        "val_animation__sampler_input_no_bounds.gltf",
        "val_animation__sampler_output_format_invalid.gltf",
        "val_animation__unresolved_channel_sampler.gltf",
        "val_animation__unresolved_sampler_input.gltf",
        "val_animation_data__invalid_input_values_gltf/invalid_input_values.gltf",
        "val_animation_data__quaternion_non_unit_values_gltf/quaternion_non_unit_values.gltf",
    ],
    "skinned meshes are left out: their skins do not matter": [
        "magnum_gltf__skin-embedded.glb",
        "magnum_gltf__skin-embedded.gltf",
        "magnum_gltf__skin_gltf/skin.gltf",
        "val_node__skin_with_no_mesh.gltf",
        "val_skin__empty_joints_array.gltf",
        "val_skin__ibm_invalid_count.gltf",
        "val_skin__no_common_root.gltf",
        "val_skin__skeleton_invalid.gltf",
        "val_skin__unresolved_joint.gltf",
        "val_skin_data__invalid_ibm_gltf/invalid_ibm.gltf",
    ],
    "materials, textures and images matter to masks alone": [
        "assimp__badNumber_gltf/badNumber.gltf",
        "magnum_gltf__image_invalid_ktx_gltf/image-invalid-ktx.gltf",
        "magnum_gltf__material-metallicroughness.gltf",
        "magnum_gltf__material-phong-fallback.gltf",
        "magnum_gltf__material-specularglossiness.gltf",
        "magnum_gltf__texture-extensions.gltf",
        "magnum_gltf__texture-invalid-ktx-extensions-property.gltf",
        "magnum_tinygltf__material-metallicroughness.gltf",
        "magnum_tinygltf__material-specularglossiness.gltf",
        "magnum_tinygltf__texture-extensions.gltf",
        "val_image__empty_object.gltf",
        "val_image__invalid_data_uri_mime_type.gltf",
        "val_image__invalid_object.gltf",
        "val_image__png_eos_gltf/png_eos.gltf",
        "val_material__unresolved_basecolor.gltf",
        "val_material__unresolved_mr.gltf",
        "val_material__unresolved_occlusion.gltf",
        "val_texture__unresolved_sampler.gltf",
    ],
    "an empty list is no fault: nothing is there": [
        "magnum_gltf__scene-default-none.gltf",
        "val_mesh__empty_array.gltf",
        "val_node__empty_children_array.gltf",
        "val_scene__empty_array.gltf",
    ],
    "a byte order mark changes nothing": [
        "val_glb__bom.glb",
        "val_json__bom.gltf",
    ],
    "said twice is said, and an extension in a wrong place is not looked at": [
        "val_KHR_mesh_quantization__unexpected_extension.gltf",
        "val_root__duplicate_extension_entry.gltf",
    ],
}
BAKED = {"assimp__BoxBadNormals.glb", "assimp__Cube_gltf/Cube.gltf", "assimp__badNumber_gltf/badNumber.gltf", "assimp__badString_gltf/badString.gltf"}
FLAT = {"val_node__node_weights_invalid.gltf"}  # what is left has no area


@pytest.fixture(scope="module")
def malformed(scenes):
    return scenes / "malformed"


@pytest.fixture
def bake(vxs_path, malformed, tmp_path):
    """bake(name): status and error lines of a bake within limits of time and memory, which leaves a file only if it succeeds."""
    def limit():
        if "sanitize" not in os.environ.get("VXS_FLAGS", ""):  # whose shadow memory is terabytes of addresses
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))

    def run(name):
        out = tmp_path / "out.vxs"
        done = subprocess.run([vxs_path, "bake", malformed / name, "-o", out, "--sun", "-0.3,-1,-0.2", "--resolution", "64"],
                              capture_output=True, text=True, timeout=SECONDS, preexec_fn=limit)
        assert out.exists() == (done.returncode == 0) and len(list(tmp_path.iterdir())) == out.exists()
        return done.returncode, [line for line in done.stderr.splitlines() if line.startswith("vxs: error: ")]

    return run


def test_every_file_is_listed(malformed):
    found = {str(p.relative_to(malformed)) for p in malformed.rglob("*") if p.suffix in (".gltf", ".glb")}
    listed = [*REFUSED, *(name for names in ACCEPTED.values() for name in names)]
    assert found == set(listed) and len(listed) == len(found)


@pytest.mark.parametrize("name", REFUSED)
def test_refused(bake, malformed, name):
    status, lines = bake(name)
    assert status == 3 and len(lines) == 1
    assert str(malformed / name) in lines[0] and REFUSED[name] in lines[0]


@pytest.mark.parametrize("name", [name for names in ACCEPTED.values() for name in names])
def test_accepted(bake, name):
    status, lines = bake(name)
    if name in BAKED:
        assert status == 0 and not lines
    else:
        left = "each of the scene's 1 triangles collapses to a line or a point" if name in FLAT else "the scene has no triangles"
        assert status == 5 and lines == [f"vxs: error: nothing casts a shadow: {left}"]
