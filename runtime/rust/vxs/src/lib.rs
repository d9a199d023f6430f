//! Lookups in baked voxelized shadows: how lit a point is, where shadow begins, which parts of a ray are lit; words for shaders.
//!
//! ```no_run
//! let level = vxs::Level::open("level.vxs")?;
//! let sun = level.light("sun").expect("a light of this name");
//! let lit = sun.lookup([0.5, 0.0, 0.5], Some([0.0, 1.0, 0.0]), vxs::Filter::smooth(9)).unwrap_or(1.0);
//! # Ok::<(), vxs::Error>(())
//! ```
//!
//! World space is that of the scene file: metres, +Y up in glTF. An open level is read-only: any number of threads may use it.
// SPDX-License-Identifier: MIT
use std::ffi::{c_char, c_int, c_void, CStr};
use std::marker::PhantomData;
use std::path::Path;
use std::{fmt, mem, ptr};

use vxs_sys as c;

pub use vxs_sys::vxs_light_constants as LightConstants;

/// Why a file cannot be opened, or an argument is refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Error {
    /// of vxs_result
    pub result: i32,
    /// the first one's number in vxs_findings.h
    pub finding: Option<i32>,
    text: String,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl std::error::Error for Error {}

fn check(result: c::vxs_result, finding: Option<(i32, String)>) -> Result<(), Error> {
    if result == c::VXS_OK {
        return Ok(());
    }
    let mut text = unsafe { CStr::from_ptr(c::vxs_result_text(result)) }.to_string_lossy().into_owned();
    if let Some((number, why)) = &finding {
        text = format!("{text}: finding {number}: {why}");
    }
    Err(Error { result, finding: finding.map(|f| f.0), text })
}

/// Over which texels of a map shadow is averaged.
#[derive(Clone, Copy)]
pub struct Filter(c::vxs_filter);

impl Filter {
    /// A box of K x K whole texels, K odd, 1 to 17.
    pub const fn box_of(width_px: i32) -> Filter {
        Filter(c::vxs_filter { width_px, is_smooth: 0 })
    }
    /// A smooth filter of K x K texels, K 1 to 17: its edges do not move in steps of a texel.
    pub const fn smooth(width_px: i32) -> Filter {
        Filter(c::vxs_filter { width_px, is_smooth: 1 })
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Directional,
    Spot,
    Point,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    Lit,
    Shadow,
    /// outside of the light's volume
    Outside,
}

/// A part of a ray: t_begin to t_end, all in one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    pub t_begin: f64,
    pub t_end: f64,
    pub state: State,
}

/// An open .vxs file.
pub struct Level {
    asset: ptr::NonNull<c::vxs_asset>,
}

// an open asset is only read (vxs.h)
unsafe impl Send for Level {}
unsafe impl Sync for Level {}

impl Drop for Level {
    fn drop(&mut self) {
        unsafe { c::vxs_asset_close(self.asset.as_ptr()) }
    }
}

unsafe extern "C" fn keep_first(user: *mut c_void, number: c_int, text: *const c_char, _section: c_int, _offset: u64) {
    let kept = &mut *(user as *mut Option<(i32, String)>);
    kept.get_or_insert_with(|| (number, CStr::from_ptr(text).to_string_lossy().into_owned()));
}

impl Level {
    /// Reads a file, and checks every byte of it.
    pub fn open(path: impl AsRef<Path>) -> Result<Level, Error> {
        let path = path.as_ref();
        let bytes = std::fs::read(path).map_err(|e| Error { result: 3, finding: None, text: format!("{}: {e}", path.display()) })?;
        Level::from_bytes(&bytes)
    }

    /// The same for a file in memory, which is not kept.
    pub fn from_bytes(bytes: &[u8]) -> Result<Level, Error> {
        let mut finding: Option<(i32, String)> = None;
        let mut asset = ptr::null_mut();
        let desc = c::vxs_read_desc {
            struct_size: mem::size_of::<c::vxs_read_desc>(),
            allocator: ptr::null(),
            memory_limit_bytes: 0,
            finding: Some(keep_first),
            finding_user: &mut finding as *mut _ as *mut c_void,
            find_all: 0,
            metadata: 0,
            parallel: ptr::null(),
        };
        let result = unsafe { c::vxs_asset_open(&mut asset, bytes.as_ptr().cast(), bytes.len(), &desc) };
        check(result, finding)?;
        Ok(Level { asset: ptr::NonNull::new(asset).expect("an asset") })
    }

    /// In the order of the file; at least one.
    pub fn lights(&self) -> impl ExactSizeIterator<Item = Light<'_>> {
        let count = unsafe { c::vxs_asset_light_count(self.asset.as_ptr()) };
        (0..count as usize).map(|n| Light { baked: unsafe { &*c::vxs_asset_light(self.asset.as_ptr(), n as u32) }, level: PhantomData })
    }

    pub fn light(&self, name: &str) -> Option<Light<'_>> {
        self.lights().find(|light| light.name() == name)
    }
}

/// A light of an open level.
#[derive(Clone, Copy)]
pub struct Light<'a> {
    baked: &'a c::vxs_baked_light,
    level: PhantomData<&'a Level>,
}

unsafe impl Send for Light<'_> {}
unsafe impl Sync for Light<'_> {}

impl<'a> Light<'a> {
    pub fn name(&self) -> &'a str {
        unsafe { CStr::from_ptr(self.baked.light.name.as_ptr()) }.to_str().unwrap_or("")
    }

    pub fn kind(&self) -> Kind {
        [Kind::Directional, Kind::Spot, Kind::Point][self.baked.light.kind as usize - 1]
    }

    /// Texels a side of a map, and voxels in depth.
    pub fn resolution(&self) -> u32 {
        1 << self.baked.light.levels
    }

    /// 1, or 6 for the faces of a cube.
    pub fn map_count(&self) -> u32 {
        if self.baked.light.flags & 2 != 0 { 6 } else { 1 }
    }

    /// Unit vector, the way the light travels.
    pub fn direction(&self) -> [f64; 3] {
        self.baked.light.direction_ws
    }

    /// The words that shaders read. Four zeros must follow the last light's.
    pub fn words(&self) -> &'a [u32] {
        unsafe { std::slice::from_raw_parts(self.baked.words, self.baked.word_count as usize) }
    }

    /// 96 bytes for shaders. origin: positions in the shader are relative to it; first_word: where the light's words begin in the buffer.
    pub fn constants(&self, origin: [f64; 3], first_word: u32) -> LightConstants {
        unsafe { c::vxs_light_constants_of(&self.baked.light, origin.as_ptr(), first_word) }
    }

    /// Share of the light that reaches a point, 0 to 1; None outside of the light's volume. normal: of the surface, of any length, which then does
    /// not shade itself; None in the air.
    pub fn lookup(&self, point: [f64; 3], normal: Option<[f64; 3]>, filter: Filter) -> Option<f32> {
        let facing = normal.as_ref().map_or(ptr::null(), |n| n.as_ptr());
        let lit = unsafe { c::vxs_lookup(self.baked, point.as_ptr(), facing, filter.0) };
        (lit >= 0.0).then_some(lit)
    }

    /// The same for many points, which is quicker where they lie close together; -1 outside of the light's volume.
    /// Panics when lit or normals have another length than points.
    pub fn lookup_many(&self, points: &[[f64; 3]], normals: Option<&[[f64; 3]]>, filter: Filter, lit: &mut [f32]) {
        assert!(lit.len() == points.len() && normals.map_or(true, |n| n.len() == points.len()), "as many results and normals as points");
        let vectors = |data: *const [f64; 3]| c::vxs_vectors { data: data.cast(), stride_bytes: 0, kind: c::VXS_F64 };
        let batch = c::vxs_batch {
            struct_size: mem::size_of::<c::vxs_batch>(),
            points_ws: vectors(points.as_ptr()),
            normals_ws: vectors(normals.map_or(ptr::null(), |n| n.as_ptr())),
            count: points.len(),
            filter: filter.0,
            lit: lit.as_mut_ptr(),
            lit_stride_bytes: 0,
            light_stride_bytes: 0,
        };
        let result = unsafe { c::vxs_lookup_batch(self.baked, 1, &batch) };
        debug_assert_eq!(result, c::VXS_OK);
    }

    /// Where shadow begins in each texel, row by row: 0 near to 1, nowhere. Err for a resolution that is no power of two up to the light's, or no map.
    pub fn depth_map(&self, map: u32, resolution: u32) -> Result<Vec<f32>, Error> {
        if !resolution.is_power_of_two() || resolution > self.resolution() || map >= self.map_count() {
            let text = format!("map {map} of {resolution} texels: expected a power of two up to {}, and a map below {}", self.resolution(), self.map_count());
            return Err(Error { result: 1, finding: None, text });
        }
        let mut depths = vec![0.0; resolution as usize * resolution as usize];
        let desc = c::vxs_depth_map_desc {
            struct_size: mem::size_of::<c::vxs_depth_map_desc>(),
            map: map as i32,
            i: 0,
            j: 0,
            wide_px: resolution,
            high_px: resolution,
            shift: self.baked.light.levels - resolution.trailing_zeros(),
            which: 0,
            voxels: ptr::null_mut(),
            depths: depths.as_mut_ptr(),
            row_stride_bytes: 0,
        };
        check(unsafe { c::vxs_depth_map(self.baked, &desc, ptr::null_mut()) }, None)?;
        Ok(depths)
    }

    /// Parts of the ray origin + t * direction that are lit, in shadow or outside, in order and without gaps. Err for NaN, or numbers beyond 1e50.
    pub fn lit_intervals(&self, origin: [f64; 3], direction: [f64; 3], t_begin: f64, t_end: f64) -> Result<Vec<Interval>, Error> {
        let ray = c::vxs_ray { origin_ws: origin, direction_ws: direction, t_begin, t_end };
        let mut walk = c::vxs_lit_walk { baked: ptr::null(), room: [0; 127] };
        check(unsafe { c::vxs_lit_begin(&mut walk, self.baked, &ray) }, None)?;
        let mut found = Vec::new();
        loop {
            let mut some = [c::vxs_interval { t_begin: 0.0, t_end: 0.0, state: 0, coarse: 0 }; 64];
            let count = unsafe { c::vxs_lit_next(&mut walk, some.as_mut_ptr(), some.len()) };
            let states = [State::Lit, State::Shadow, State::Outside];
            found.extend(some[..count].iter().map(|i| Interval { t_begin: i.t_begin, t_end: i.t_end, state: states[i.state as usize] }));
            if count < some.len() {
                return Ok(found);
            }
        }
    }
}
