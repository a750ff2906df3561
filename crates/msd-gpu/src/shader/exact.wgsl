// Roots and quotients, rounded correctly, in three variants of which a device needs one.

// Numbers that the compiler does not know. `zero` is 0, and `unit` four ones.
struct Exact {
    unit: vec4<f32>,
    one: f32,
    minus_zero: f32,
    nothing: f32,
    zero: u32,
    tiny: f32,
    up: f32,
    down: f32,
    unused: f32,
}
@group(0) @binding(0) var<uniform> exact: Exact;

fn hidden(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) ^ exact.zero);
}

fn product(a: f32, b: f32) -> f32 {
    return fma(a, b, exact.minus_zero);
}

// As the device has them.
fn root_native(q: f32) -> f32 {
    return hidden(sqrt(hidden(q)));
}
fn inverse_native(x: f32) -> f32 {
    return hidden(1f / hidden(x));
}
fn quotient_native(a: f32, b: f32) -> f32 {
    return hidden(hidden(a) / hidden(b));
}

// By Newton steps, which round correctly where `fma` is fused (Markstein, 1990).
fn root_fused(number: f32) -> f32 {
    let is_small = number < exact.tiny;
    let q = select(number, product(number, exact.up), is_small);
    let y = hidden(inverseSqrt(q));
    var g = product(q, y);
    var h = product(y, 0.5f);
    let e = fma(-h, g, 0.5f);
    g = fma(g, e, g);
    h = fma(h, e, h);
    let d = fma(-g, g, q);
    g = fma(d, h, g);
    g = select(g, product(g, exact.down), is_small);
    return select(g, number, number == 0f);
}
fn inverse_fused(x: f32) -> f32 {
    var y = hidden(1f / x);
    y = fma(fma(-x, y, exact.one), y, y);
    return fma(fma(-x, y, exact.one), y, y);
}
fn quotient_fused(a: f32, b: f32) -> f32 {
    let y = inverse_fused(b);
    let q = product(a, y);
    let better = fma(fma(-q, b, a), y, q);
    return fma(fma(-better, b, a), y, better);
}

// By integers, whatever the device does with floats: the last places of the result are moved until
// the remainder is within half of one.
fn root_whole(q: f32) -> f32 {
    if (q == 0f) {
        return q;
    }
    var bits = bitcast<u32>(sqrt(q));
    let whole = bitcast<u32>(q);
    let n = (whole & 0x7fffffu) | 0x800000u;
    for (var i = 0; i < 3; i++) {
        let s = (bits & 0x7fffffu) | 0x800000u;
        let shift = ((whole >> 23u) + 150u - 2u * (bits >> 23u)) & 31u;
        // s² − q in units of the last place of s².
        let r = i32(s * s - (n << shift));
        let most = i32(select(s, s >> 1u, s == 0x800000u));
        bits = bits - u32(r >= most) + u32(r < -i32(s));
    }
    return bitcast<f32>(bits);
}
fn inverse_whole(x: f32) -> f32 {
    var bits = bitcast<u32>(1f / x);
    let m = (bitcast<u32>(x) & 0x7fffffu) | 0x800000u;
    for (var i = 0; i < 3; i++) {
        let y = (bits & 0x7fffffu) | 0x800000u;
        // y m is about 2^46 or 2^47, of which the lower 32 bits are zeros.
        let r = 2 * i32(y * m);
        bits = bits - u32(r > i32(m)) + u32(r < -i32(m));
    }
    return bitcast<f32>(bits);
}
fn quotient_whole(a: f32, b: f32) -> f32 {
    let whole = bitcast<u32>(a / b);
    if (a == 0f || (whole & 0x7f800000u) == 0x7f800000u) {
        return bitcast<f32>(whole);
    }
    let sign = whole & 0x80000000u;
    var bits = whole ^ sign;
    let n = (bitcast<u32>(a) & 0x7fffffu) | 0x800000u;
    let m = (bitcast<u32>(b) & 0x7fffffu) | 0x800000u;
    let places = ((bitcast<u32>(a) >> 23u) & 255u) + 150u - ((bitcast<u32>(b) >> 23u) & 255u);
    for (var i = 0; i < 3; i++) {
        let q = (bits & 0x7fffffu) | 0x800000u;
        let r = 2 * i32(q * m - (n << ((places - (bits >> 23u)) & 31u)));
        let most = i32(select(m, m >> 1u, q == 0x800000u));
        bits = bits - u32(r > most) + u32(r < -i32(m));
    }
    return bitcast<f32>(bits ^ sign);
}
