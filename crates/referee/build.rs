//! Links IPOPT when its feature is on.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_IPOPT").is_some() {
        println!("cargo:rustc-link-lib=ipopt");
    }
}
