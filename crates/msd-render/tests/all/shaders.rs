//! The WGSL sources, checked by naga without any adapter.

use msd_render::Quality;
use msd_render::shaders::{ALL, source};
use naga::back::glsl;
use naga::proc::BoundsCheckPolicies;
use naga::valid::{Capabilities, ValidationFlags, Validator};

#[test]
fn every_shader_parses_and_validates_without_extra_capabilities() {
    for quality in [Quality::Full, Quality::Fast] {
        for (name, text) in ALL {
            let source = &source(text, quality);
            let module = naga::front::wgsl::parse_str(source)
                .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
            // No capabilities: those of a browser's WebGPU without extensions.
            Validator::new(ValidationFlags::all(), Capabilities::empty())
                .validate(&module)
                .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
        }
    }
}

#[test]
fn every_shader_can_be_written_in_the_language_of_webgl2() {
    let options = glsl::Options {
        version: glsl::Version::Embedded { version: 300, is_webgl: true },
        ..glsl::Options::default()
    };
    for (quality, (name, text)) in
        [Quality::Full, Quality::Fast].into_iter().flat_map(|quality| ALL.map(|row| (quality, row)))
    {
        let module = naga::front::wgsl::parse_str(&source(text, quality)).expect("a module");
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .expect("a valid module");
        for entry in &module.entry_points {
            let pipeline = glsl::PipelineOptions {
                shader_stage: entry.stage,
                entry_point: entry.name.clone(),
                multiview: None,
            };
            let (mut written, policies) = (String::new(), BoundsCheckPolicies::default());
            glsl::Writer::new(&mut written, &module, &info, &options, &pipeline, policies)
                .and_then(|mut writer| writer.write())
                .unwrap_or_else(|error| panic!("{name}, {}: {error}", entry.name));
            // Depths can only be compared there.
            let reads = written.lines().filter(|line| line.contains("texelFetch"));
            assert_eq!(reads.count(), 0, "{name}, {}: it reads texels", entry.name);
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
