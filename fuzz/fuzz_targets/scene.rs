//! Any text as the source of a scene: read, compiled, and what compiles is loaded.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = vestibule_forge::compile_scene("fuzzed.scene", text);
    }
});
