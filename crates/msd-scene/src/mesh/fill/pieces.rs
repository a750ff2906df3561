//! The separate bodies of a solid, if a file holds several.

use crate::mesh::clean::interior::Interior;
use crate::mesh::clean::topology::{Sets, components};
use glam::DVec3;

/// The body of each surface point and then of each lattice point.
///
/// Components of the mesh are one body if one has its first vertex in the other, as a void has, or
/// if a lattice point lies in both.
pub(crate) fn pieces(
    (positions, triangles): (&[DVec3], &[[u32; 3]]),
    lattice: &[DVec3],
    is_closed: bool,
) -> Vec<usize> {
    let (numbers, count) = components(positions.len(), triangles);
    if count == 1 {
        return vec![0; positions.len() + lattice.len()];
    }
    let mut faces = vec![Vec::new(); count];
    for &triangle in triangles {
        faces[numbers[triangle[0] as usize] as usize].push(triangle);
    }
    let mut sets = Sets::new(count);
    let mut homes = vec![count; lattice.len()];
    for (component, faces) in faces.iter().enumerate() {
        let inside = Interior::new(positions, faces, is_closed);
        let mut firsts = vec![true; count];
        for (&number, &position) in numbers.iter().zip(positions) {
            let first = std::mem::take(&mut firsts[number as usize]);
            if first && number as usize != component && inside.contains(position) {
                sets.join(component, number as usize);
            }
        }
        for (home, &point) in homes.iter_mut().zip(lattice) {
            if inside.contains(point) {
                if *home < count {
                    sets.join(component, *home);
                }
                *home = component;
            }
        }
    }
    let surface = numbers.iter().map(|&number| number as usize);
    // A point that is inside by the sum of all components is inside at least one of them, if they
    // are closed. Else a few between two of them belong to the last.
    let all = surface.chain(homes.into_iter().map(|home| home.min(count - 1)));
    all.map(|component| sets.find(component)).collect()
}
