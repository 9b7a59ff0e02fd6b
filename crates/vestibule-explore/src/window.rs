//! The window: events in, frames out.

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::Instant;

use glam::Vec2;
use vestibule_gpu::AdapterChoice;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Window, WindowId};

use crate::cpu_screen::CpuScreen;
use crate::error::ExploreError;
use crate::explorer::Explorer;
use crate::gpu_screen::GpuScreen;
use crate::keys::{self, Held};
use crate::loading::{self, Open, Progress};
use crate::panels::{self, FrameTimes};

/// Movement of a pressed mouse that still is a click, pixels.
const CLICK: f64 = 4.0;
/// A device that was lost more often than this within a few seconds is not opened again.
const MOST_LOSSES: usize = 3;
/// A few seconds.
const FEW_SECONDS: f32 = 20.0;

/// How the window is opened.
pub struct Options {
    /// Opens the world; runs on a thread of its own.
    pub open: Open,
    /// Title of the window.
    pub title: String,
    /// Width and height of the window, points.
    pub size: (u32, u32),
    /// Which adapter to take.
    pub adapter: AdapterChoice,
    /// Draw with the CPU even if there is an adapter.
    pub cpu: bool,
    /// Where pictures are saved.
    pub pictures: PathBuf,
    /// Is shown the state after every frame.
    pub watch: Option<Watch>,
    /// Seconds after which the graphics device is destroyed, to try out what happens then; several times if it is to be
    /// lost again.
    pub lose_device: Vec<f32>,
}

/// Looks on after every frame. An error is told in the window, and ends the looking on.
pub type Watch = Box<dyn FnMut(&Explorer) -> Result<(), String>>;

/// What the window system says, without the place in its own source that it begins with.
fn plain(said: &str) -> String {
    let says = said
        .strip_prefix("os error at ")
        .and_then(|rest| rest.split_once(": "));
    says.map_or(said, |(_, says)| says).to_owned()
}

/// Opens the window and runs until it is closed.
///
/// # Errors
/// When there is no display, or nothing can be drawn into the window. What goes wrong with the world is shown in the
/// window first, and is the error once it is closed.
pub fn run(options: Options) -> Result<(), ExploreError> {
    let event_loop = EventLoop::new().map_err(|e| ExploreError::NoDisplay(plain(&e.to_string())))?;
    event_loop.set_control_flow(ControlFlow::Poll);
    let mut app = App {
        phase: Phase::Loading(loading::start(options.open), "opening the world".to_owned(), 0.0),
        title: options.title,
        size: options.size,
        adapter: options.adapter,
        cpu: options.cpu.then(|| "as asked".to_owned()),
        pictures: options.pictures,
        watch: options.watch,
        to_lose: options.lose_device,
        notice: None,
        begun: Instant::now(),
        losses: Vec::new(),
        open: None,
        failed: None,
        held: Held::default(),
        times: FrameTimes::default(),
        cursor: Vec2::ZERO,
        drag: None,
        last: Instant::now(),
    };
    event_loop.run_app(&mut app)?;
    match (app.failed, app.phase) {
        (Some(error), _) => Err(error),
        (None, Phase::Failed(why)) => Err(ExploreError::World(why)),
        (None, _) => Ok(()),
    }
}

enum Phase {
    Loading(Receiver<Progress>, String, f32),
    Exploring(Box<Explorer>),
    Failed(String),
}

enum Screen {
    Gpu(Box<GpuScreen>),
    Cpu(CpuScreen),
}

struct Opened {
    window: Arc<Window>,
    screen: Screen,
    context: egui::Context,
    input: egui_winit::State,
}

impl Opened {
    fn new(window: Arc<Window>, screen: Screen) -> Self {
        let context = egui::Context::default();
        panels::style(&context);
        let longest = match &screen {
            Screen::Gpu(gpu) => gpu.longest_side() as usize,
            Screen::Cpu(_) => 4096,
        };
        let root = egui::ViewportId::ROOT;
        let input = egui_winit::State::new(
            context.clone(),
            root,
            &window,
            None,
            window.theme(),
            Some(longest),
        );
        Opened {
            window,
            screen,
            context,
            input,
        }
    }
}

struct App {
    phase: Phase,
    title: String,
    size: (u32, u32),
    adapter: AdapterChoice,
    /// Why the CPU is to draw, if it is.
    cpu: Option<String>,
    pictures: PathBuf,
    watch: Option<Watch>,
    /// Seconds since `begun` when the device is to be destroyed.
    to_lose: Vec<f32>,
    /// Why there is no adapter.
    notice: Option<String>,
    begun: Instant,
    /// When devices were lost.
    losses: Vec<Instant>,
    open: Option<Opened>,
    failed: Option<ExploreError>,
    held: Held,
    times: FrameTimes,
    cursor: Vec2,
    /// Where the mouse was pressed, and whether it moved since.
    drag: Option<(Vec2, bool)>,
    last: Instant,
}

/// A screen for a window: on the adapter, or in pixels with a notice why.
fn screen(
    event_loop: &ActiveEventLoop,
    window: &Arc<Window>,
    adapter: AdapterChoice,
    cpu: Option<&str>,
) -> Result<(Screen, Option<String>), ExploreError> {
    let why = if let Some(why) = cpu {
        why.to_owned()
    } else {
        let display = Box::new(event_loop.owned_display_handle());
        match GpuScreen::new(window.clone(), display, adapter) {
            Ok(screen) => return Ok((Screen::Gpu(Box::new(screen)), None)),
            Err(error) => error.to_string(),
        }
    };
    let notice = format!("The CPU draws, slowly: {why}");
    Ok((Screen::Cpu(CpuScreen::new(window.clone())?), Some(notice)))
}

impl App {
    fn fail(&mut self, event_loop: &ActiveEventLoop, error: ExploreError) {
        self.failed = Some(error);
        event_loop.exit();
    }

    fn make(&mut self, event_loop: &ActiveEventLoop) -> Result<Opened, ExploreError> {
        let attributes = Window::default_attributes()
            .with_title(&self.title)
            .with_inner_size(winit::dpi::LogicalSize::new(self.size.0, self.size.1));
        let window = event_loop
            .create_window(attributes)
            .map_err(|e| ExploreError::NoDisplay(plain(&e.to_string())))?;
        let window = Arc::new(window);
        let (screen, notice) = screen(event_loop, &window, self.adapter, self.cpu.as_deref())?;
        self.note(&screen, notice);
        Ok(Opened::new(window, screen))
    }

    fn note(&mut self, screen: &Screen, notice: Option<String>) {
        self.times.adapter = match screen {
            Screen::Gpu(gpu) => gpu.name().to_owned(),
            Screen::Cpu(_) => "CPU renderer".to_owned(),
        };
        if let Some(notice) = notice {
            // Who closed stderr does not want to know.
            let _ = writeln!(std::io::stderr(), "{notice}");
            self.times.adapter.clone_from(&notice);
            self.notice = Some(notice);
        }
    }

    fn load(&mut self) {
        let Phase::Loading(told, what, share) = &mut self.phase else {
            return;
        };
        loop {
            match told.try_recv() {
                Ok(Progress::At(now, done)) => (*what, *share) = (now, done),
                Ok(Progress::Done(mut explorer)) => {
                    explorer.tell(match &self.notice {
                        Some(notice) => format!("{notice}\nH shows the keys"),
                        None => "H shows the keys".to_owned(),
                    });
                    self.phase = Phase::Exploring(explorer);
                    return;
                }
                Ok(Progress::Failed(why)) => {
                    self.phase = Phase::Failed(why);
                    return;
                }
                Err(std::sync::mpsc::TryRecvError::Empty) => return,
                Err(std::sync::mpsc::TryRecvError::Disconnected) => {
                    self.phase = Phase::Failed("loading ended early".to_owned());
                    return;
                }
            }
        }
    }

    fn redraw(&mut self, event_loop: &ActiveEventLoop) {
        self.load();
        let now = Instant::now();
        let dt = (now - self.last).as_secs_f32();
        self.last = now;
        let lose = self
            .to_lose
            .first()
            .is_some_and(|at| (now - self.begun).as_secs_f32() > *at);
        let Some(open) = &mut self.open else { return };
        if lose && let Screen::Gpu(gpu) = &open.screen {
            self.to_lose.remove(0);
            gpu.destroy();
        }
        let size = open.window.inner_size();
        if size.width == 0 || size.height == 0 {
            // Minimised: nothing to draw, and no hurry.
            std::thread::sleep(std::time::Duration::from_millis(30));
            open.window.request_redraw();
            return;
        }
        self.times.push(dt);
        let picture = match &open.screen {
            Screen::Gpu(gpu) => gpu.picture_size(size.width, size.height),
            Screen::Cpu(_) => CpuScreen::picture_size(size.width, size.height),
        };
        if let Phase::Exploring(explorer) = &mut self.phase {
            let begin = Instant::now();
            let viewport = Vec2::new(picture.0 as f32, picture.1 as f32);
            explorer.tick(&self.held, dt, viewport);
            self.times.decide = begin.elapsed().as_secs_f32();
            if let Some(watch) = &mut self.watch
                && let Err(why) = watch(explorer)
            {
                explorer.tell(why);
                self.watch = None;
            }
        }
        let input = open.input.take_egui_input(&open.window);
        let (phase, times) = (&mut self.phase, &self.times);
        let mut output = open.context.clone().run_ui(input, |ui| {
            let context = ui.ctx().clone();
            match phase {
                Phase::Loading(_, what, share) => panels::loading(&context, what, *share),
                Phase::Exploring(explorer) => panels::show(&context, explorer, times),
                Phase::Failed(why) => panels::failed(&context, why),
            }
        });
        open.input
            .handle_platform_output(&open.window, output.platform_output);
        let points = output.pixels_per_point;
        let list = open.context.tessellate(output.shapes, points);
        let explorer = match &self.phase {
            Phase::Exploring(explorer) => Some(&**explorer),
            _ => None,
        };
        let window_size = (size.width, size.height);
        let delta = &output.textures_delta;
        let times = &mut self.times;
        let drawn = match &mut open.screen {
            Screen::Gpu(gpu) => gpu
                .draw(window_size, explorer, &list, delta, points, times)
                .map_err(|e| e.to_string()),
            Screen::Cpu(cpu) => cpu
                .draw(window_size, explorer, &list, delta, points, times)
                .map_err(|e| e.to_string()),
        };
        // Taken over, or given up together with the screen.
        output.textures_delta.clear();
        if let Err(why) = drawn {
            self.recover(event_loop, &why);
            return;
        }
        self.after_frame(event_loop);
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }

    /// A new screen in place of one that failed.
    fn recover(&mut self, event_loop: &ActiveEventLoop, why: &str) {
        let Some(open) = self.open.take() else { return };
        if matches!(open.screen, Screen::Cpu(_)) {
            self.fail(event_loop, ExploreError::NoScreen(why.to_owned()));
            return;
        }
        // The window stays; what belongs to the lost device goes first.
        let window = open.window.clone();
        drop(open.screen);
        let now = Instant::now();
        self.losses.push(now);
        self.losses
            .retain(|then| (now - *then).as_secs_f32() < FEW_SECONDS);
        // What is lost again and again is of no use.
        if self.losses.len() > MOST_LOSSES {
            self.cpu = Some("the graphics device was lost again and again".to_owned());
        }
        match screen(event_loop, &window, self.adapter, self.cpu.as_deref()) {
            Ok((screen, notice)) => {
                let on_gpu = matches!(screen, Screen::Gpu(_));
                self.note(&screen, notice);
                window.request_redraw();
                self.open = Some(Opened::new(window, screen));
                let what = if on_gpu {
                    "opened anew"
                } else {
                    "the CPU draws now"
                };
                let text = format!("{}; {what}", why.trim_end_matches([':', ' ']));
                // Who closed stderr does not want to know.
                let _ = writeln!(std::io::stderr(), "{text}");
                if let Phase::Exploring(explorer) = &mut self.phase {
                    explorer.tell(text);
                }
            }
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn after_frame(&mut self, event_loop: &ActiveEventLoop) {
        let Phase::Exploring(explorer) = &mut self.phase else {
            return;
        };
        if explorer.wants_to_leave {
            event_loop.exit();
        }
        if core::mem::take(&mut explorer.wants_screenshot) {
            let image = self.open.as_ref().and_then(|o| match &o.screen {
                Screen::Gpu(gpu) => gpu.image(),
                Screen::Cpu(cpu) => cpu.image(),
            });
            let path = free_name(&self.pictures);
            let saved = image.map(|i| i.save_png(&path));
            explorer.tell(match saved {
                Some(Ok(())) => format!("saved {}", path.display()),
                Some(Err(error)) => format!("cannot save {}: {error}", path.display()),
                None => "no picture to save".to_owned(),
            });
        }
    }

    fn key(&mut self, event_loop: &ActiveEventLoop, event: &winit::event::KeyEvent) {
        let name = match &event.logical_key {
            Key::Character(text) => text.to_lowercase(),
            Key::Named(NamedKey::Space) => "Space".to_owned(),
            Key::Named(named) => format!("{named:?}"),
            _ => return,
        };
        let down = event.state == ElementState::Pressed;
        let Phase::Exploring(explorer) = &mut self.phase else {
            if down && name == "Escape" {
                event_loop.exit();
            }
            return;
        };
        if let Some(typed) = &mut explorer.typing {
            self.held = Held::default();
            // Keys that are faster than the panel that is to take them.
            let taken = self
                .open
                .as_ref()
                .is_some_and(|o| o.context.egui_wants_keyboard_input());
            if !taken && down {
                match (&event.text, name.as_str()) {
                    (_, "Enter") => {
                        let typed = core::mem::take(typed);
                        explorer.typing = None;
                        explorer.teleport(&typed);
                    }
                    (Some(text), _) if !text.chars().any(char::is_control) => typed.push_str(text),
                    _ => {}
                }
            }
            return;
        }
        if down && !event.repeat {
            let mut tapped = Held::default();
            tapped.set(&name, true);
            explorer.tap(tapped);
        }
        if !self.held.set(&name, down)
            && down
            && !event.repeat
            && let Some(action) = keys::action(&name)
        {
            explorer.act(action);
        }
    }

    fn mouse(&mut self, button: MouseButton, state: ElementState, over_panel: bool) {
        if !matches!(button, MouseButton::Left | MouseButton::Right) {
            return;
        }
        match state {
            ElementState::Pressed if !over_panel => self.drag = Some((self.cursor, false)),
            ElementState::Pressed => {}
            ElementState::Released => {
                let clicked = self.drag.take().is_some_and(|(_, moved)| !moved);
                if clicked
                    && button == MouseButton::Left
                    && let (Phase::Exploring(explorer), Some(open)) = (&mut self.phase, &self.open)
                {
                    let size = open.window.inner_size();
                    let window = Vec2::new(size.width.max(1) as f32, size.height.max(1) as f32);
                    let viewport = explorer.camera().map_or(window, |c| c.viewport());
                    explorer.pick(self.cursor / window * viewport);
                }
            }
        }
    }
}

/// A name for a picture that is not taken.
fn free_name(folder: &std::path::Path) -> PathBuf {
    let name = |k: u32| folder.join(format!("vestibule-{k:03}.png"));
    (1..1000)
        .map(name)
        .find(|p| !p.exists())
        .unwrap_or_else(|| name(0))
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        match self.make(event_loop) {
            Ok(open) => {
                open.window.request_redraw();
                self.open = Some(open);
            }
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        let taken = open.input.on_window_event(&open.window, &event).consumed;
        let over_panel = taken || open.context.egui_wants_pointer_input();
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::RedrawRequested => self.redraw(event_loop),
            WindowEvent::KeyboardInput { event, .. } => self.key(event_loop, &event),
            WindowEvent::Focused(false) => self.held = Held::default(),
            WindowEvent::CursorMoved { position, .. } => {
                let now = Vec2::new(position.x as f32, position.y as f32);
                let step = now - self.cursor;
                self.cursor = now;
                if let Some((from, moved)) = &mut self.drag {
                    *moved |= f64::from((now - *from).length()) > CLICK;
                    if *moved && let Phase::Exploring(explorer) = &mut self.phase {
                        explorer.look(step);
                    }
                }
            }
            WindowEvent::MouseInput { state, button, .. } => self.mouse(button, state, over_panel),
            WindowEvent::MouseWheel { delta, .. } if !over_panel => {
                let steps = match delta {
                    MouseScrollDelta::LineDelta(_, y) => y,
                    MouseScrollDelta::PixelDelta(p) => p.y as f32 / 40.0,
                };
                if let Phase::Exploring(explorer) = &mut self.phase {
                    explorer.zoom(steps);
                }
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_the_window_system_says_is_without_its_source() {
        let said = "os error at /winit/src/mod.rs:765: neither DISPLAY nor WAYLAND_DISPLAY is set.";
        assert_eq!(super::plain(said), "neither DISPLAY nor WAYLAND_DISPLAY is set.");
        let said = r"os error at C:\winit\mod.rs:1: no";
        assert_eq!(super::plain(said), "no");
        assert_eq!(super::plain("something: else"), "something: else");
    }
}
