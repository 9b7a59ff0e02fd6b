//! Choosing an adapter and opening it (`rendering.md` 9.2: nothing that a browser with WebGL2 could not do).

use std::sync::{Arc, Mutex, PoisonError};

use crate::error::GpuError;

/// Which adapter to take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The fastest, a software one if there is no other.
    #[default]
    Best,
    /// One that saves power.
    LowPower,
    /// One that draws in software, whose pixels are the same on every machine.
    Software,
}

/// An open graphics device.
#[derive(Debug)]
pub struct Gpu {
    /// Where it comes from.
    pub adapter: wgpu::Adapter,
    /// Makes resources.
    pub device: wgpu::Device,
    /// Takes work.
    pub queue: wgpu::Queue,
    lost: Arc<Mutex<Option<String>>>,
    name: String,
}

/// The instance that adapters come from: Vulkan, Metal, Direct3D 12 and OpenGL, cut by `WGPU_BACKEND` when that is
/// set.
pub fn instance() -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env())
}

impl Gpu {
    /// Opens an adapter without a window.
    ///
    /// # Errors
    /// When there is none, or it cannot be opened.
    pub fn headless(choice: AdapterChoice) -> Result<Gpu, GpuError> {
        Self::open(&instance(), choice, None)
    }

    /// Opens an adapter that can show pictures on `surface`.
    ///
    /// # Errors
    /// As [`Gpu::headless`].
    pub fn for_surface(
        instance: &wgpu::Instance,
        surface: &wgpu::Surface<'_>,
        choice: AdapterChoice,
    ) -> Result<Gpu, GpuError> {
        Self::open(instance, choice, Some(surface))
    }

    fn open(
        instance: &wgpu::Instance,
        choice: AdapterChoice,
        surface: Option<&wgpu::Surface<'_>>,
    ) -> Result<Gpu, GpuError> {
        let options = wgpu::RequestAdapterOptions {
            power_preference: match choice {
                AdapterChoice::LowPower => wgpu::PowerPreference::LowPower,
                _ => wgpu::PowerPreference::HighPerformance,
            },
            force_fallback_adapter: choice == AdapterChoice::Software,
            compatible_surface: surface,
            apply_limit_buckets: false,
        };
        let adapter = pollster::block_on(instance.request_adapter(&options))
            .map_err(|e| GpuError::NoAdapter(e.to_string()))?;
        let name = describe(&adapter.get_info());
        // A longer side than WebGL2 promises is used where it is there: windows may be larger.
        let limits = wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits());
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("vestibule"),
            required_features: wgpu::Features::empty(),
            required_limits: limits,
            ..Default::default()
        };
        let opened = pollster::block_on(adapter.request_device(&descriptor));
        let (device, queue) = opened.map_err(|e| GpuError::Device {
            adapter: name.clone(),
            reason: e.to_string(),
        })?;
        let lost = Arc::new(Mutex::new(None));
        let report = lost.clone();
        device.set_device_lost_callback(move |reason, message| {
            *report.lock().unwrap_or_else(PoisonError::into_inner) = Some(format!("{reason:?}: {message}"));
        });
        let report = lost.clone();
        // Without a handler a driver's complaint would end the program.
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let mut slot = report.lock().unwrap_or_else(PoisonError::into_inner);
            slot.get_or_insert_with(|| error.to_string());
        }));
        Ok(Gpu {
            adapter,
            device,
            queue,
            lost,
            name,
        })
    }

    /// Name of the adapter, what draws for it, and its driver.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it draws in software.
    pub fn is_software(&self) -> bool {
        self.adapter.get_info().device_type == wgpu::DeviceType::Cpu
    }

    /// Why the device is no longer usable.
    pub fn lost(&self) -> Option<String> {
        self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Nothing, or the error that tells that the device is no longer usable. A device that is gone takes commands all
    /// the same and says so only while it is polled: poll [`Gpu::device`] once a frame.
    ///
    /// # Errors
    /// When it was lost or refused something.
    pub fn check(&self) -> Result<(), GpuError> {
        match self.lost() {
            Some(reason) => Err(GpuError::Lost(reason)),
            None => Ok(()),
        }
    }

    /// Longest side of a picture, pixels.
    pub fn longest_side(&self) -> u32 {
        self.device
            .limits()
            .max_texture_dimension_2d
            .min(vestibule_render::MAX_SIDE)
    }
}

fn describe(info: &wgpu::AdapterInfo) -> String {
    let driver = [info.driver.as_str(), info.driver_info.as_str()];
    let driver: Vec<&str> = driver.into_iter().filter(|s| !s.is_empty()).collect();
    format!("{} ({:?}, {})", info.name, info.backend, driver.join(" "))
}
