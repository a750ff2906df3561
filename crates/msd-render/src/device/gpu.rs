//! The graphics device: an adapter and a device, with or without a window.

use crate::error::RenderError;
use wgpu::{Adapter, Device, Instance, InstanceDescriptor, Limits, Queue, Surface};

/// A graphics device with its instance and adapter; clones share the device.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The entry to the drivers; a lost surface is made anew from it.
    pub instance: Instance,
    /// The driver in use.
    pub adapter: Adapter,
    /// The device that makes buffers, textures and pipelines.
    pub device: Device,
    /// The queue to which finished commands are submitted.
    pub queue: Queue,
}

impl Gpu {
    /// Opens a device without a window.
    ///
    /// The environment variable `WGPU_BACKEND` limits the choice, for example to `vulkan` or `gl`.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`] without any driver, [`RenderError::NoDevice`] if it refuses.
    pub async fn headless() -> Result<Gpu, RenderError> {
        let descriptor = InstanceDescriptor::new_without_display_handle_from_env();
        let instance = wgpu::util::new_instance_with_webgpu_detection(descriptor).await;
        Self::open(instance, None).await
    }

    /// Opens a device that can draw on a window, and the surface of that window.
    ///
    /// `display` is needed by OpenGL; with winit it is the owned display handle of the event loop,
    /// and `window` an `Arc<Window>`. The caller configures the surface.
    ///
    /// # Errors
    /// [`RenderError::NoSurface`], [`RenderError::NoAdapter`] or [`RenderError::NoDevice`].
    pub async fn for_surface(
        display: Box<dyn wgpu::wgt::WgpuHasDisplayHandle>,
        window: impl Into<wgpu::SurfaceTarget<'static>>,
    ) -> Result<(Gpu, Surface<'static>), RenderError> {
        let descriptor = InstanceDescriptor::new_with_display_handle_from_env(display);
        let instance = wgpu::util::new_instance_with_webgpu_detection(descriptor).await;
        let surface = instance.create_surface(window)?;
        let gpu = Self::open(instance, Some(&surface)).await?;
        Ok((gpu, surface))
    }

    /// Opens the preferred adapter, and where that fails at any stage the one in software.
    async fn open(instance: Instance, surface: Option<&Surface<'_>>) -> Result<Gpu, RenderError> {
        let preferred = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::from_env().unwrap_or_default(),
            compatible_surface: surface,
            ..Default::default()
        };
        if let Ok(gpu) = Self::open_as(&instance, &preferred).await {
            return Ok(gpu);
        }
        let software = wgpu::RequestAdapterOptions { force_fallback_adapter: true, ..preferred };
        Self::open_as(&instance, &software).await
    }

    async fn open_as(
        instance: &Instance,
        options: &wgpu::RequestAdapterOptions<'_, '_>,
    ) -> Result<Gpu, RenderError> {
        let adapter = instance.request_adapter(options).await.map_err(RenderError::NoAdapter)?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("msd"),
            required_limits: needed_limits(&adapter),
            ..Default::default()
        };
        let opened = adapter.request_device(&descriptor).await;
        let (device, queue) = opened
            .map_err(|source| RenderError::NoDevice { adapter: adapter.get_info().name, source })?;
        Ok(Gpu { instance: instance.clone(), adapter, device, queue })
    }
}

/// The limits to ask for: WebGPU's defaults, or those of OpenGL, and never more than the adapter
/// has.
fn needed_limits(adapter: &Adapter) -> Limits {
    let available = adapter.limits();
    let base = match adapter.get_info().backend {
        wgpu::Backend::Gl if cfg!(target_arch = "wasm32") => Limits::downlevel_webgl2_defaults(),
        wgpu::Backend::Gl => Limits::downlevel_defaults(),
        _ => Limits::default(),
    };
    base.using_resolution(available.clone()).or_worse_values_from(&available)
}
