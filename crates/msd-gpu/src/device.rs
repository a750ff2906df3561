//! Graphics devices: adapters, buffers and programs.

use crate::error::GpuError;
use crate::shader::symbol::Spelling;
use crate::shader::{Choice, Manner, Roots, names, programs};
use bytemuck::{Pod, cast_slice};
use std::collections::HashMap;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};
use wgpu::util::DeviceExt;
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages, ComputePipeline};

/// The storage buffers of a program.
const STORAGE_BUFFERS: u32 = 8;
/// Bytes from the numbers of one substep to those of the next.
pub const STRIDE: u64 = 256;

/// Whether a program can wait for a device. A browser answers only after the program has returned
/// to it: there [`crate::GpuSimulation::poll`] takes the place of waits.
pub const CAN_WAIT: bool = !cfg!(target_arch = "wasm32");

/// A graphics device that computes. Its clones share one device.
#[derive(Clone, Debug)]
pub struct Device {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    manner: Manner,
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    loss: Arc<Loss>,
    layouts: [BindGroupLayout; 3],
    exact: Buffer,
    /// The programs of methods that were asked for.
    programs: Mutex<HashMap<(Choice, Manner), Programs>>,
}

/// The reason of the driver, once the device is lost.
#[derive(Debug, Default)]
struct Loss(Mutex<Option<String>>);

impl Loss {
    fn reason(&self) -> Option<String> {
        self.0.lock().expect("no panic while it is held").clone()
    }

    /// Notes why the device is of no more use; the first reason counts.
    fn lose(&self, reason: String) {
        self.0.lock().expect("no panic while it is held").get_or_insert(reason);
    }
}

/// The programs of a method, by name.
pub type Programs = Arc<HashMap<&'static str, ComputePipeline>>;

/// The adapters of this machine, in the order of their drivers. The environment variable
/// `WGPU_BACKEND` limits them, for example to `vulkan` or `gl`. A browser has at most one.
pub async fn adapters() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    if cfg!(target_arch = "wasm32") {
        // WebGL2 has no compute shaders.
        descriptor.backends = wgpu::Backends::BROWSER_WEBGPU;
    }
    let instance = wgpu::util::new_instance_with_webgpu_detection(descriptor).await;
    instance.enumerate_adapters(wgpu::Backends::all()).await
}

impl Device {
    /// Opens the first adapter whose name contains a text, ignoring case. Hardware adapters come
    /// before software ones.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::NoCompute`] or [`GpuError::NoDevice`].
    pub async fn open(name: &str) -> Result<Self, GpuError> {
        let mut all = adapters().await;
        all.sort_by_key(|adapter| adapter.get_info().device_type == wgpu::DeviceType::Cpu);
        let name = name.to_lowercase();
        let named =
            |adapter: &wgpu::Adapter| adapter.get_info().name.to_lowercase().contains(&name);
        let Some(adapter) = all.into_iter().find(named) else {
            let what = format!(" named {name:?}; `msd devices` lists them");
            let with = if name.is_empty() { String::new() } else { what };
            return Err(GpuError::NoAdapter(with));
        };
        Self::of_adapter(&adapter).await
    }

    /// Opens an adapter.
    ///
    /// # Errors
    /// See [`Device::open`].
    pub async fn of_adapter(adapter: &wgpu::Adapter) -> Result<Self, GpuError> {
        let (info, limits) = (adapter.get_info(), adapter.limits());
        let most = limits.max_storage_buffers_per_shader_stage;
        if most < STORAGE_BUFFERS {
            return Err(GpuError::NoCompute { adapter: info.name, most });
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("msd"),
            required_limits: limits,
            ..Default::default()
        };
        let opened = adapter.request_device(&descriptor).await;
        let (device, queue) = opened.map_err(|reason| GpuError::NoDevice {
            adapter: info.name.clone(),
            reason: reason.to_string(),
        })?;
        Ok(Self::of(device, queue, info))
    }

    /// Takes over a device that has just been opened.
    fn of(device: wgpu::Device, queue: wgpu::Queue, info: wgpu::AdapterInfo) -> Self {
        let layouts = layouts(&device);
        let exact = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("exact"),
            contents: cast_slice(&unknown_numbers()),
            usage: BufferUsages::UNIFORM,
        });
        let (loss, programs): (Arc<Loss>, _) = Default::default();
        let of_callback = loss.clone();
        device.set_device_lost_callback(move |_, reason| of_callback.lose(reason));
        let of_callback = loss.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            of_callback.lose(error.to_string());
        }));
        let shared = Arc::new(Shared { loss, layouts, exact, programs });
        let manner = Manner { spelling: Spelling::Exact, roots: Roots::Native };
        Device { device, queue, info, manner, shared }
    }

    /// Name, driver and kind of its adapter.
    pub fn info(&self) -> &wgpu::AdapterInfo {
        &self.info
    }

    /// The name of its adapter. Browsers hide it.
    pub fn name(&self) -> String {
        if self.info.name.is_empty() { "WebGPU".to_owned() } else { self.info.name.clone() }
    }

    /// The manner in which its programs compute. [`crate::probe`] finds the one with the bits of
    /// the processor.
    pub fn manner(&self) -> Manner {
        self.manner
    }

    /// The same device with programs that compute in another manner.
    pub fn with_manner(self, manner: Manner) -> Self {
        Device { manner, ..self }
    }

    /// Destroys the device, as the reset of a driver does. It then computes nothing.
    pub fn lose(&self) {
        self.device.destroy();
        self.shared.loss.lose("it was destroyed".to_owned());
    }

    /// The layouts of constants, of the state and of the numbers of a substep.
    pub(crate) fn layouts(&self) -> &[BindGroupLayout; 3] {
        &self.shared.layouts
    }

    /// The numbers that a compiler does not know.
    pub(crate) fn exact(&self) -> &Buffer {
        &self.shared.exact
    }

    /// The programs of a method, compiled the first time.
    pub(crate) fn programs(&self, choice: Choice) -> Programs {
        let mut known = self.shared.programs.lock().expect("no panic while it is held");
        let make = || {
            let names = names(choice.kind).chain(["clear_flags"]);
            self.compile(&programs(choice, self.manner), names)
        };
        known.entry((choice, self.manner)).or_insert_with(make).clone()
    }

    fn compile(&self, source: &str, names: impl Iterator<Item = &'static str>) -> Programs {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("step"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let layouts = self.layouts().each_ref().map(Some);
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("step"),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let pipeline = |name| {
            let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&layout),
                module: &module,
                entry_point: Some(&format!("run_{name}")),
                compilation_options: Default::default(),
                cache: None,
            });
            (name, pipeline)
        };
        Arc::new(names.map(pipeline).collect())
    }

    /// The program `main` of a source with the layout that follows from it.
    pub(crate) fn pipeline(&self, source: &str) -> ComputePipeline {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("probe"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("probe"),
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        })
    }

    /// A storage buffer with this content.
    pub(crate) fn storage<T: Pod>(
        &self,
        what: &'static str,
        content: &[T],
    ) -> Result<Buffer, GpuError> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        self.filled(what, cast_slice(content), usage)
    }

    /// A uniform buffer with this content.
    pub(crate) fn uniform<T: Pod>(
        &self,
        what: &'static str,
        content: &[T],
    ) -> Result<Buffer, GpuError> {
        self.filled(what, cast_slice(content), BufferUsages::UNIFORM | BufferUsages::COPY_DST)
    }

    /// A buffer that is written by the queue: wgpu panics where one that it maps is refused.
    fn filled(
        &self,
        what: &'static str,
        content: &[u8],
        usage: BufferUsages,
    ) -> Result<Buffer, GpuError> {
        let buffer = self.empty(what, content.len() as u64, usage)?;
        self.queue.write_buffer(&buffer, 0, content);
        Ok(buffer)
    }

    /// A buffer of so many bytes.
    pub(crate) fn empty(
        &self,
        what: &'static str,
        bytes: u64,
        usage: BufferUsages,
    ) -> Result<Buffer, GpuError> {
        self.check_size(what, bytes)?;
        Ok(self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size: bytes,
            usage,
            mapped_at_creation: false,
        }))
    }

    fn check_size(&self, what: &'static str, bytes: u64) -> Result<(), GpuError> {
        let limits = self.device.limits();
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        if bytes <= most {
            return Ok(());
        }
        Err(GpuError::TooLarge { what, bytes, adapter: self.name(), most })
    }

    /// A group of buffers by the numbers of their bindings.
    pub(crate) fn group(&self, layout: &BindGroupLayout, buffers: &[&Buffer]) -> BindGroup {
        let entry = |binding: usize| wgpu::BindGroupEntry {
            binding: binding as u32,
            resource: buffers[binding].as_entire_binding(),
        };
        let entries: Vec<_> = (0..buffers.len()).map(entry).collect();
        let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
        self.device.create_bind_group(&descriptor)
    }

    /// A group of one uniform buffer that is read at offsets.
    pub(crate) fn dynamic_group(&self, layout: &BindGroupLayout, buffer: &Buffer) -> BindGroup {
        let size = wgpu::BufferSize::new(16);
        let binding = wgpu::BufferBinding { buffer, offset: 0, size };
        let resource = wgpu::BindingResource::Buffer(binding);
        let entries = [wgpu::BindGroupEntry { binding: 0, resource }];
        let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
        self.device.create_bind_group(&descriptor)
    }

    /// Does something that the device may refuse.
    pub(crate) async fn checked<T>(
        &self,
        act: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let (done, answer) = self.attempt(act)?;
        answer.await?;
        Ok(done)
    }

    /// Runs `act`; returns its result, and a future that reports whether the device refused it.
    pub(crate) fn attempt<T>(
        &self,
        act: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<(T, Answer), GpuError> {
        self.check_lost()?;
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let use_of = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let done = act();
        let (use_of, memory) = (use_of.pop(), memory.pop());
        let device = self.clone();
        let answer = async move {
            let refused = [use_of.await, memory.await].into_iter().flatten().next();
            device.check_lost()?;
            let Some(reason) = refused else { return Ok(()) };
            // The device may have refused one of the programs: compile them again next time.
            device.shared.programs.lock().expect("no panic while it is held").clear();
            Err(GpuError::Refused { adapter: device.name(), reason: reason.to_string() })
        };
        Ok((done?, Answer(Box::pin(answer))))
    }

    /// Lets the driver work, or waits for it.
    pub(crate) fn poll(&self, how: wgpu::PollType) {
        // wgpu panics where a wait shows that the driver was reset.
        let poll = AssertUnwindSafe(|| drop(self.device.poll(how)));
        if catch_unwind(poll).is_err() {
            self.shared.loss.lose("the driver was reset".to_owned());
        }
    }

    /// Waits until nothing is under way.
    pub(crate) fn wait(&self) -> Result<(), GpuError> {
        if !CAN_WAIT {
            return Err(GpuError::NoWait);
        }
        self.poll(wgpu::PollType::wait_indefinitely());
        self.check_lost()
    }

    /// Whether the device was lost.
    pub fn is_lost(&self) -> bool {
        self.check_lost().is_err()
    }

    /// Refuses a device that was lost.
    pub(crate) fn check_lost(&self) -> Result<(), GpuError> {
        self.shared
            .loss
            .reason()
            .map_or(Ok(()), |reason| Err(GpuError::Lost { adapter: self.name(), reason }))
    }
}

#[cfg(not(target_arch = "wasm32"))]
type Answering = Pin<Box<dyn Future<Output = Result<(), GpuError>> + Send>>;
/// Objects of JavaScript stay in their thread.
#[cfg(target_arch = "wasm32")]
type Answering = Pin<Box<dyn Future<Output = Result<(), GpuError>>>>;

/// Answer of a device, whether it refuses commands. In a browser it arrives between two frames.
pub struct Answer(Answering);

impl Answer {
    /// The answer, once it is there; never blocks.
    pub(crate) fn now(&mut self) -> Option<Result<(), GpuError>> {
        match self.0.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(answer) => Some(answer),
            Poll::Pending => None,
        }
    }
}

impl Future for Answer {
    type Output = Result<(), GpuError>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        self.0.as_mut().poll(context)
    }
}

impl fmt::Debug for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Answer")
    }
}

/// The bits of ones, zeros and powers of two, in the order of `Exact` in `exact.wgsl`.
fn unknown_numbers() -> [u32; 12] {
    let (tiny, up, down) = (2f32.powi(-60), 2f32.powi(64), 2f32.powi(-32));
    [1.0, 1.0, 1.0, 1.0, 1.0, -0.0, 0.0, 0.0, tiny, up, down, 0.0].map(f32::to_bits)
}

fn layouts(device: &wgpu::Device) -> [BindGroupLayout; 3] {
    use wgpu::BufferBindingType::{Storage, Uniform};
    let (read, write) = (Storage { read_only: true }, Storage { read_only: false });
    let layout = |kinds: &[wgpu::BufferBindingType], has_dynamic_offset: bool| {
        let entry =
            |(binding, &ty): (usize, &wgpu::BufferBindingType)| wgpu::BindGroupLayoutEntry {
                binding: binding as u32,
                visibility: wgpu::ShaderStages::COMPUTE,
                count: None,
                ty: wgpu::BindingType::Buffer {
                    ty,
                    has_dynamic_offset,
                    min_binding_size: if has_dynamic_offset {
                        wgpu::BufferSize::new(16)
                    } else {
                        None
                    },
                },
            };
        let entries: Vec<_> = kinds.iter().enumerate().map(entry).collect();
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &entries,
        })
    };
    [
        layout(&[Uniform, read, read, read], false),
        layout(&[read, write, write, write, write], false),
        layout(&[Uniform], true),
    ]
}
