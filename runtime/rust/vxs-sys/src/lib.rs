//! Declarations of libvxs, as vxs_file.h, vxs.h and vxs_query.h have them. The crate `vxs` is safe.
// SPDX-License-Identifier: MIT
#![no_std]
#![allow(non_camel_case_types)]
use core::ffi::{c_char, c_int, c_void};

pub type vxs_result = c_int;
pub const VXS_OK: vxs_result = 0;
pub const VXS_F64: u32 = 0;
pub const VXS_F32: u32 = 1;

#[repr(C)]
pub struct vxs_asset {
    _opaque: [u8; 0],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct vxs_light {
    pub name: [c_char; 64],
    pub kind: u32,
    pub flags: u32,
    pub levels: u32,
    pub coding: u32,
    pub ls_from_ws: [f64; 12],
    pub texel_metres: f64,
    pub voxel_metres: f64,
    pub direction_ws: [f64; 3],
    pub near_metres: f64,
    pub cos_outer: f64,
    pub range_metres: f64,
}

#[repr(C)]
pub struct vxs_part {
    pub kind: *const c_char,
    pub side_voxels: u32,
    pub count: u32,
    pub memory_bytes: u64,
    pub section: u32,
}

#[repr(C)]
pub struct vxs_baked_light {
    pub light: vxs_light,
    pub words: *const u32,
    pub word_count: u32,
    pub packing: u32,
    pub part_count: u32,
    pub parts: [vxs_part; 18],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct vxs_filter {
    pub width_px: i32,
    pub is_smooth: i32,
}

#[repr(C)]
pub struct vxs_read_desc {
    pub struct_size: usize,
    pub allocator: *const c_void,
    pub memory_limit_bytes: u64,
    pub finding: Option<unsafe extern "C" fn(user: *mut c_void, number: c_int, text: *const c_char, section: c_int, offset_bytes: u64)>,
    pub finding_user: *mut c_void,
    pub find_all: c_int,
    pub metadata: c_int,
    pub parallel: *const c_void,
}

#[repr(C)]
pub struct vxs_vectors {
    pub data: *const c_void,
    pub stride_bytes: usize,
    pub kind: u32,
}

#[repr(C)]
pub struct vxs_batch {
    pub struct_size: usize,
    pub points_ws: vxs_vectors,
    pub normals_ws: vxs_vectors,
    pub count: usize,
    pub filter: vxs_filter,
    pub lit: *mut f32,
    pub lit_stride_bytes: usize,
    pub light_stride_bytes: usize,
}

#[repr(C)]
pub struct vxs_depth_map_desc {
    pub struct_size: usize,
    pub map: i32,
    pub i: i32,
    pub j: i32,
    pub wide_px: u32,
    pub high_px: u32,
    pub shift: u32,
    pub which: u32,
    pub voxels: *mut u32,
    pub depths: *mut f32,
    pub row_stride_bytes: usize,
}

#[repr(C)]
pub struct vxs_ray {
    pub origin_ws: [f64; 3],
    pub direction_ws: [f64; 3],
    pub t_begin: f64,
    pub t_end: f64,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct vxs_interval {
    pub t_begin: f64,
    pub t_end: f64,
    pub state: i32,
    pub coarse: i32,
}

#[repr(C)]
pub struct vxs_lit_walk {
    pub baked: *const vxs_baked_light,
    pub room: [u64; 127],
}

/// 96 bytes for shaders.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct vxs_light_constants {
    pub ls_from_ws: [f32; 12],
    pub texel_metres: f32,
    pub voxel_metres: f32,
    pub near_metres: f32,
    pub range_metres: f32,
    pub cos_outer: f32,
    pub kind: u32,
    pub flags: u32,
    pub levels: u32,
    pub first_word: u32,
    pub coding: u32,
    pub origin_fraction_ij: u32,
    pub origin_fraction_k: u32,
}

extern "C" {
    pub fn vxs_asset_open(asset: *mut *mut vxs_asset, bytes: *const c_void, size_bytes: usize, desc: *const vxs_read_desc) -> vxs_result;
    pub fn vxs_asset_close(asset: *mut vxs_asset);
    pub fn vxs_asset_light_count(asset: *const vxs_asset) -> u32;
    pub fn vxs_asset_light(asset: *const vxs_asset, index: u32) -> *const vxs_baked_light;
    pub fn vxs_lookup(baked: *const vxs_baked_light, point_ws: *const f64, normal_ws: *const f64, filter: vxs_filter) -> f32;
    pub fn vxs_lookup_batch(lights: *const vxs_baked_light, light_count: u32, batch: *const vxs_batch) -> vxs_result;
    pub fn vxs_depth_map(baked: *const vxs_baked_light, desc: *const vxs_depth_map_desc, coarse: *mut c_int) -> vxs_result;
    pub fn vxs_lit_begin(walk: *mut vxs_lit_walk, baked: *const vxs_baked_light, ray: *const vxs_ray) -> vxs_result;
    pub fn vxs_lit_next(walk: *mut vxs_lit_walk, intervals: *mut vxs_interval, capacity: usize) -> usize;
    pub fn vxs_light_constants_of(light: *const vxs_light, origin_ws: *const f64, first_word: u32) -> vxs_light_constants;
    pub fn vxs_result_text(result: vxs_result) -> *const c_char;
}
