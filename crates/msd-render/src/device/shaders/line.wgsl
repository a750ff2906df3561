struct Line {
    @location(0) a: vec3f,
    @location(1) width: f32,
    @location(2) b: vec3f,
    @location(3) bias: f32,
    @location(4) colour: vec4f,
    // Of a round rod, m; 0 of a line that has no thickness.
    @location(5) radius: f32,
}

struct Ribbon {
    @builtin(position) clip: vec4f,
    @location(0) colour: vec4f,
    @location(1) world: vec3f,
    @location(2) side: vec3f,
    // -1 to 1 across.
    @location(3) across: f32,
    @location(4) @interpolate(flat) radius: f32,
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
    // Pixels per metre at this depth; a rod never gets thinner than a line.
    let scale = globals.screen.y / (2.0 * globals.up.w * max(clip.w, 1e-6));
    let width = max(line.width, 2.0 * line.radius * scale);
    // Half a width longer than the line, so that lines that meet leave no notch.
    let across = vec2f(-direction.y, direction.x) * corner.y;
    let extra = select(0.5, 0.0, line.radius > 0.0);
    let shift = (across + direction * corner.x * extra) * (0.5 * width);
    clip = vec4f(clip.xy + shift / size * clip.w, clip.zw);
    let world = select(line.a, line.b, corner.x > 0.0);
    let side = cross(line.b - line.a, globals.eye.xyz - world);
    // A rod is at its front, else a surface that ends in its middle would hide half of it.
    let nearer = line.bias + line.radius / max(clip.w - line.radius, 1e-3 * clip.w);
    return Ribbon(pulled(clip, nearer), line.colour, world, side, corner.y, line.radius);
}

@fragment
fn fs_main(in: Ribbon) -> @location(0) vec4f {
    return shown_srgb(in.colour.rgb, in.colour.a);
}

// A rod is round.
@fragment
fn fs_rod(in: Ribbon) -> @location(0) vec4f {
    let side = in.side / max(length(in.side), 1e-9);
    let to_eye = normalize(globals.eye.xyz - in.world);
    let height = sqrt(max(1.0 - in.across * in.across, 0.0));
    let normal = normalize(to_eye * height - side * in.across + vec3f(1e-6));
    let world = in.world + normal * in.radius;
    let finish = Finish(srgb_to_linear(in.colour.rgb), 0.7, 0.0, 0.0, 0.0);
    let sun = sunlight(world, normal, in.clip.xy);
    return shown(lit(finish, normal, world, sun, in.clip.xy), in.colour.a);
}
