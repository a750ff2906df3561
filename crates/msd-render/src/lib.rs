//! Draws a snapshot with wgpu.
