//! Gives the library its name for the loader: without one, a program would look for it at the path
//! where it was linked.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libtrolley_client.so");
}
