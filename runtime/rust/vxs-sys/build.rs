//! Compiles libvxs. Its sources are those of `make amalgamation`: in sources/ of a packed crate, in build/amalgamation of a checkout, or where
//! VXS_SOURCES says. Without zstddeclib.c beside them, zstd of the system is linked.
use std::path::{Path, PathBuf};
use std::{env, process};

fn sources() -> PathBuf {
    let here = PathBuf::from(env::var("CARGO_MANIFEST_DIR").unwrap());
    let named = env::var("VXS_SOURCES").ok().map(PathBuf::from);
    let places = named.into_iter().chain([here.join("sources"), here.join("../../../build/amalgamation")]);
    let found = places.filter(|folder| folder.join("vxs.c").exists()).next();
    found.unwrap_or_else(|| {
        eprintln!("vxs-sys: no vxs.c: run `make amalgamation` in the repository of vxs, or let VXS_SOURCES name the folder that it made");
        process::exit(1);
    })
}

fn main() {
    let folder = sources();
    let has_zstd = Path::exists(&folder.join("zstddeclib.c"));
    let mut build = cc::Build::new();
    build.file(folder.join("vxs.c")).include(&folder).std("c11").opt_level(2).define("VXS_NO_STREAM", None);
    build.flag_if_supported("-ffp-contract=off").warnings(false);
    if !has_zstd {
        build.define("VXS_SYSTEM_ZSTD", None);
        println!("cargo:rustc-link-lib=zstd");
    }
    build.compile("vxs");
    if cfg!(unix) {
        println!("cargo:rustc-link-lib=m");
    }
    println!("cargo:rerun-if-env-changed=VXS_SOURCES");
    println!("cargo:rerun-if-changed={}", folder.display());
}
