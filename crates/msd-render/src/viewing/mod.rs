//! Cameras and views: the viewpoint, the parts that are shown, the quantity of the colours, and the
//! object under the pointer.

pub mod camera;
pub mod quantity;
pub mod view;
pub mod pick;
