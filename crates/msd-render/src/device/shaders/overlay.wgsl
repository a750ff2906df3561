struct Rect {
    @location(0) area: vec4f,
    @location(1) lower: vec4f,
    @location(2) upper: vec4f,
}

struct Overlay {
    @builtin(position) clip: vec4f,
    @location(0) colour: vec4f,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32, rect: Rect) -> Overlay {
    let corner = quad_corner(index) * 0.5 + 0.5;
    let pixels = rect.area.xy + rect.area.zw * corner;
    let clip = vec4f(pixels / globals.screen.xy * 2.0 - 1.0, 1.0, 1.0);
    return Overlay(clip, mix(rect.lower, rect.upper, corner.y));
}

@fragment
fn fs_main(in: Overlay) -> @location(0) vec4f {
    return shown_srgb(in.colour.rgb, in.colour.a);
}
