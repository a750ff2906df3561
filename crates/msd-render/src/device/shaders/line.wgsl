struct Line {
    @location(0) a: vec3f,
    @location(1) width: f32,
    @location(2) b: vec3f,
    @location(3) bias: f32,
    @location(4) colour: vec4f,
}

struct Ribbon {
    @builtin(position) clip: vec4f,
    @location(0) colour: vec4f,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32, line: Line) -> Ribbon {
    var a = globals.view_projection * vec4f(line.a, 1.0);
    var b = globals.view_projection * vec4f(line.b, 1.0);
    // Cut at the near plane, where the division below would turn an end around. If both ends are
    // behind it the ribbon lies behind it too and is clipped.
    let near = globals.screen.w * 1.01;
    let uncut = a;
    if a.w < near && b.w > near {
        a = mix(b, a, (b.w - near) / (b.w - a.w));
    }
    if b.w < near && uncut.w > near {
        b = mix(uncut, b, (uncut.w - near) / (uncut.w - b.w));
    }
    let size = 0.5 * globals.screen.xy;
    let along = (b.xy / b.w - a.xy / a.w) * size;
    let length = length(along);
    let direction = select(vec2f(1.0, 0.0), along / max(length, 1e-6), length > 1e-6);
    let corner = quad_corner(index);
    var clip = select(a, b, corner.x > 0.0);
    // Half a width longer than the line, so that lines that meet leave no notch.
    let across = vec2f(-direction.y, direction.x) * corner.y;
    let shift = (across + direction * corner.x * 0.5) * (0.5 * line.width);
    clip = vec4f(clip.xy + shift / size * clip.w, clip.zw);
    return Ribbon(pulled(clip, line.bias), line.colour);
}

@fragment
fn fs_main(in: Ribbon) -> @location(0) vec4f {
    return shown_srgb(in.colour.rgb, in.colour.a);
}
