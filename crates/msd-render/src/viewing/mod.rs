//! Cameras and views: from where a scene is seen, what of it is shown, what colours stand for, and
//! what is pointed at.

pub mod camera;
pub mod quantity;
pub mod view;
pub mod pick;
