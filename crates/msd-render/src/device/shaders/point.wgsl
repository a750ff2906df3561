struct Point {
    @location(0) centre: vec3f,
    @location(1) radius: f32,
    @location(2) colour: vec4f,
    @location(3) shape: f32,
}

struct Disc {
    @builtin(position) clip: vec4f,
    @location(0) at: vec2f,
    @location(1) centre: vec3f,
    @location(2) colour: vec3f,
    @location(3) @interpolate(flat) shape: f32,
    @location(4) @interpolate(flat) radius: f32,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32, point: Point) -> Disc {
    let corner = quad_corner(index);
    var clip = globals.view_projection * vec4f(point.centre, 1.0);
    // Pixels per metre at this depth; a point never gets smaller than it can be seen.
    let scale = globals.screen.y / (2.0 * length(globals.up.xyz) * max(clip.w, 1e-6));
    let least = select(select(2.0, 5.0, point.shape > 0.5), 8.0, point.shape > 1.5);
    let radius = max(point.radius, least * globals.look.z / scale);
    let shift = corner * (radius * scale * 2.0) / globals.screen.xy * clip.w;
    clip = vec4f(clip.xy + shift, clip.zw);
    // The quad is at the front of the ball, else a surface through its centre would cut it.
    let nearer = select(radius / max(clip.w - radius, 1e-3 * clip.w), 1e9, point.shape > 1.5);
    let colour = srgb_to_linear(point.colour.rgb);
    return Disc(pulled(clip, nearer), corner, point.centre, colour, point.shape, radius);
}

// The part of a pixel inside a distance, for smooth edges.
fn covered(distance: f32, pixel: f32) -> f32 {
    return clamp(0.5 - distance / max(pixel, 1e-5), 0.0, 1.0);
}

@fragment
fn fs_main(in: Disc) -> @location(0) vec4f {
    let from_centre = length(in.at);
    let pixel = fwidth(from_centre);
    // A ball fills the quad but for the rim of a pin, or the ring around a grab.
    let ringed = in.shape > 0.5;
    let size = select(select(1.0, 0.74, ringed), 0.5, in.shape > 1.5);
    let at = in.at / size;
    let height = sqrt(max(1.0 - dot(at, at), 0.0));
    let right = normalize(globals.right.xyz);
    let up = normalize(globals.up.xyz);
    let normal = normalize(right * at.x + up * at.y - globals.forward.xyz * height + vec3f(1e-6));
    let world = in.centre + normal * in.radius;
    let ball = covered(from_centre - size, pixel);
    let ring = select(0.0, covered(abs(from_centre - 0.84) - 0.12, pixel), ringed);
    let opacity = max(ball, ring);
    if opacity < 0.02 {
        discard;
    }
    let sun = sunlight(world, normal, in.clip.xy);
    let finish = Finish(in.colour, 0.3, 0.0, 0.0, 0.0);
    let ball_colour = lit(finish, normal, world, sun, in.clip.xy);
    // The rim of a pin is dark, the ring of a grab has its own colour.
    let ring_colour = select(vec3f(0.012, 0.018, 0.035), in.colour, in.shape > 1.5);
    let colour = select(ball_colour, ring_colour, ringed && from_centre > size + 0.02);
    return shown(colour, opacity);
}
