struct Sky {
    @builtin(position) clip: vec4f,
    @location(0) direction: vec3f,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> Sky {
    // One triangle that covers the picture.
    let at = vec2f(select(-1.0, 3.0, index == 1u), select(-1.0, 3.0, index == 2u));
    let across = globals.right.xyz * at.x + globals.up.xyz * at.y;
    return Sky(vec4f(at, 0.0, 1.0), globals.forward.xyz + across);
}

@fragment
fn fs_main(in: Sky) -> @location(0) vec4f {
    let colour = shown(sky_colour(normalize(in.direction)), 1.0);
    return colour + vec4f(vec3f(dither(in.clip.xy) / 255.0), 0.0);
}
