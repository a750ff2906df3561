//! Cameras and views: from where a scene is seen, what of it is shown, and what is pointed at.

pub mod camera;
pub mod view;
pub mod pick;
