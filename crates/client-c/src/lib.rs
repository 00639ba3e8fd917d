//! The client for C and C++: `include/trolley.h` documents each function.
//!
//! ```text
//! trolley_connect --> handle --trolley_ask, as often as wanted--> answers --> trolley_disconnect
//! ```
//!
//! # Invariants
//!
//! - No panic leaves this library, which would end the caller's process: it becomes a refusal.
//! - The structs are those of `protocol::public`; the header states the same sizes and offsets, and
//!   `tests/processes/clients.rs` at the top level compiles it with a C++ compiler and compares the
//!   answers.

#![expect(unsafe_code, reason = "C hands over pointers; each is checked for null and used once")]

use client::public::{Ask, Reason, WireAnswer, WireState};
use client::{Client, Waiting};
use core::ffi::{CStr, c_char};
use core::time::Duration;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

/// A client, as C sees it: an address.
#[derive(Debug)]
pub struct Handle(Client);

/// Connects to a service; without a folder (null, or empty), where services lie by default. Returns
/// null on failure, and then writes why into `error`.
///
/// # Safety
///
/// `folder` and `instance` are C strings; `error` points to `error_length` writable bytes, or is
/// null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trolley_connect(
    folder: *const c_char,
    instance: *const c_char,
    nap_ns: u64,
    error: *mut c_char,
    error_length: usize,
) -> *mut Handle {
    let text = |pointer: *const c_char| {
        if pointer.is_null() {
            return Err("a name is a null pointer".to_owned());
        }
        // SAFETY: the caller hands over C strings.
        let text = unsafe { CStr::from_ptr(pointer) };
        text.to_str().map(str::to_owned).map_err(|error| error.to_string())
    };
    let waiting = match nap_ns {
        0 => Waiting::Spin,
        ns => Waiting::Nap(Duration::from_nanos(ns)),
    };
    let connect = || {
        let folder = if folder.is_null() { String::new() } else { text(folder)? };
        let folder = Some(PathBuf::from(folder)).filter(|folder| !folder.as_os_str().is_empty());
        let client = Client::connect(folder.as_deref(), &text(instance)?, waiting);
        client.map_err(|error| error.to_string())
    };
    let done = catch_unwind(AssertUnwindSafe(connect));
    match done.unwrap_or_else(|_| Err("internal error: a panic in this library".to_owned())) {
        Ok(client) => Box::into_raw(Box::new(Handle(client))),
        Err(why) => {
            // SAFETY: the caller vouches for both.
            unsafe { say(&why, error, error_length) };
            core::ptr::null_mut()
        }
    }
}

/// Writes a text, truncated to fit, with a terminating zero.
///
/// # Safety
///
/// `out` points to `length` writable bytes, or is null.
unsafe fn say(text: &str, out: *mut c_char, length: usize) {
    let Some(capacity) = length.checked_sub(1).filter(|_| !out.is_null()) else { return };
    let end = text.floor_char_boundary(capacity);
    // SAFETY: `end` is less than `length`, which the caller vouches for.
    unsafe { core::ptr::copy_nonoverlapping(text.as_ptr().cast(), out, end) };
    // SAFETY: as above.
    let last = unsafe { out.add(end) };
    // SAFETY: as above.
    unsafe { last.write(0) };
}

/// Sends a request, and waits at most `patience_ns` for the answer. There is always one.
///
/// # Safety
///
/// `client` came from [`trolley_connect`] and is used by one thread at a time; `ask` can be read,
/// and nobody writes it meanwhile; `answer` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trolley_ask(
    client: *mut Handle,
    ask: *const Ask,
    patience_ns: u64,
    answer: *mut WireAnswer,
) {
    if answer.is_null() {
        return;
    }
    let refused = |text: &str| {
        WireAnswer::without_ranking(0, WireState::Refused, Reason::Malformed, text).sealed()
    };
    let given = if client.is_null() || ask.is_null() {
        refused("null pointer")
    } else {
        // SAFETY: not null, made by `trolley_connect`, and nobody else uses it now.
        let handle = unsafe { &mut *client };
        // SAFETY: not null, every bit pattern is a request, and nobody writes it meanwhile.
        let ask = unsafe { &*ask };
        let exchange = || handle.0.ask(ask, Duration::from_nanos(patience_ns));
        catch_unwind(AssertUnwindSafe(exchange))
            .unwrap_or_else(|_| refused("internal error: a panic in this library"))
    };
    // SAFETY: not null, and the caller vouches for it.
    unsafe { answer.write(given) };
}

/// Ends a client. Null is ignored.
///
/// # Safety
///
/// `client` came from [`trolley_connect`] and is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trolley_disconnect(client: *mut Handle) {
    if client.is_null() {
        return;
    }
    // SAFETY: it was made by `Box::into_raw`, and is given back once.
    let handle = unsafe { Box::from_raw(client) };
    let _panicked = catch_unwind(AssertUnwindSafe(|| drop(handle)));
}

/// The name of a verdict: a static C string.
#[unsafe(no_mangle)]
pub extern "C" fn trolley_verdict_name(verdict: u32) -> *const c_char {
    let name = match WireState::from_number(verdict) {
        Some(WireState::Complete) => c"complete",
        Some(WireState::Certified) => c"certified",
        Some(WireState::Degraded) => c"degraded",
        Some(WireState::Refused) => c"refused",
        Some(WireState::Busy) => c"busy",
        None => c"unknown",
    };
    name.as_ptr()
}
