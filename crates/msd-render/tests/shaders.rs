//! The WGSL sources, checked by naga without any adapter.

use msd_render::Quality;
use msd_render::shaders::{ALL, source};
use naga::valid::{Capabilities, ValidationFlags, Validator};

#[test]
fn every_shader_parses_and_validates_without_extra_capabilities() {
    for quality in [Quality::Full, Quality::Fast] {
        for (name, text) in ALL {
            let source = &source(text, quality);
            let module = naga::front::wgsl::parse_str(source)
                .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
            // No capabilities: what a browser's WebGPU offers without extensions.
            Validator::new(ValidationFlags::all(), Capabilities::empty())
                .validate(&module)
                .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
        }
    }
}

#[test]
fn no_shader_uses_storage_buffers_or_compute() {
    for (name, source) in ALL {
        assert!(!source.contains("storage"), "{name} uses a storage buffer: WebGL2 has none");
        assert!(!source.contains("@compute"), "{name} computes: WebGL2 cannot");
    }
}
