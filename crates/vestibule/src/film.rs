//! Pictures of a tour: a strip of every threshold, and a film.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use glam::Vec2;
use vestibule_render::{Image, RenderError};
use vestibule_view::retail_fov_y;
use vestibule_world::{CellId, Frame, Position};

use crate::studio::{Studio, StudioError};
use crate::tour::{Guide, TourRecord, facing};
use crate::walker::TICK;

/// Thresholds that a strip shows at most.
pub const MAX_THRESHOLDS: usize = 56;
/// Size of a strip's pictures, pixels.
const STRIP_SIZE: (u32, u32) = (200, 150);
/// Ticks before a threshold that its first picture shows.
const BEFORE: usize = 20;
/// Ticks after a threshold within which the camera should have followed.
const FOLLOW: usize = 240;
/// Ticks before and after a threshold that a film shows.
const FILM_REACH: usize = 24;
/// Ticks from one picture of a film to the next.
const FILM_STEP: usize = 6;
/// Time a picture of a film shows, milliseconds.
pub const FILM_DELAY_MS: u16 = 120;
/// Space between pictures, pixels.
const GAP: u32 = 6;
/// Height of a line of letters, pixels.
const LINE: u32 = 16;
const PAPER: [u8; 4] = [24, 24, 28, 255];
const INK: [u8; 4] = [230, 230, 220, 255];
const BRIGHT: [u8; 4] = [255, 208, 112, 255];

/// A place where the player went from one cell into another for the first time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Threshold {
    /// The first tick in the new cell.
    pub tick: usize,
    /// The cell before.
    pub from: CellId,
    /// The cell after.
    pub to: CellId,
    /// The tick at which the camera's cell was the new one too; `None` when the player had turned back before.
    pub followed: Option<usize>,
    /// The last tick before the player left the new cell, or the camera had enough time to follow.
    pub last: usize,
}

/// The thresholds of a tour in the order they were crossed, each pair of cells once; borders between land cells are
/// none.
pub fn thresholds(record: &TourRecord) -> Vec<Threshold> {
    let mut met = BTreeSet::new();
    let mut out = Vec::new();
    for (i, pair) in record.trail.windows(2).enumerate() {
        let [before, now] = pair else { continue };
        let (from, to) = (before.cell, now.cell);
        let crossed = from != to && !now.teleported && (from.is_indoor() || to.is_indoor());
        if !crossed || !met.insert(if from < to { (from, to) } else { (to, from) }) {
            continue;
        }
        let tick = i + 1;
        let stays = record
            .trail
            .iter()
            .skip(tick)
            .take(FOLLOW)
            .take_while(|step| step.cell == to && !step.teleported);
        let last = tick + stays.count().saturating_sub(1);
        let looks = record.eyes.iter().enumerate().take(last + 1).skip(tick);
        let followed = looks
            .filter(|(_, eye)| eye.cell == Some(to))
            .map(|(tick, _)| tick)
            .next();
        out.push(Threshold {
            tick,
            from,
            to,
            followed,
            last,
        });
    }
    out
}

/// A camera at a tick of a tour, drawn.
fn picture(
    studio: &Studio<'_>,
    record: &TourRecord,
    tick: usize,
    size: (u32, u32),
) -> Result<Image, StudioError> {
    let size = Vec2::new(size.0 as f32, size.1 as f32);
    let fov = retail_fov_y(core::f32::consts::FRAC_PI_2, size.x / size.y);
    let (Some(step), Some(eye)) = (record.trail.get(tick), record.eyes.get(tick)) else {
        return Err(StudioError::Render(RenderError::Frames));
    };
    let player = Position {
        cell: step.cell,
        frame: Frame::new(step.pos, facing(eye.heading)),
    };
    let shot = studio.shot_behind(&player, &eye.position, eye.cell, fov, size)?;
    Ok(studio.picture(&shot)?)
}

/// Pictures of ticks, made on all processors; `done` is told how many there are so far.
fn pictures(
    studio: &Studio<'_>,
    record: &TourRecord,
    ticks: &[usize],
    size: (u32, u32),
    done: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Image>, StudioError> {
    let threads = std::thread::available_parallelism()
        .map_or(1, usize::from)
        .min(ticks.len().max(1));
    let (next, ready) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let slots: Vec<Mutex<Option<Result<Image, StudioError>>>> =
        ticks.iter().map(|_| Mutex::new(None)).collect();
    let work = || {
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let (Some(&tick), Some(slot)) = (ticks.get(i), slots.get(i)) else {
                break;
            };
            let made = picture(studio, record, tick, size);
            *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(made);
            done(ready.fetch_add(1, Ordering::Relaxed) + 1);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
    let missing = || Err(StudioError::Render(RenderError::Frames));
    slots
        .into_iter()
        .map(|slot| {
            slot.into_inner()
                .unwrap_or_else(PoisonError::into_inner)
                .unwrap_or_else(missing)
        })
        .collect()
}

/// What a cell is called on a picture.
fn name(guide: Option<&Guide>, id: CellId) -> String {
    match guide.and_then(|guide| guide.names.get(&id)) {
        Some(name) => name.clone(),
        None if !id.is_indoor() => format!("land {:04X}", id.0 & 0xFFFF),
        None => format!("{:08X}", id.0),
    }
}

/// Three pictures of each threshold: shortly before, as the player crosses, and as the camera has followed.
///
/// # Errors
/// There is no threshold, or the tour did not look.
pub fn strip(
    studio: &Studio<'_>,
    record: &TourRecord,
    guide: Option<&Guide>,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Image, StudioError> {
    let mut all = thresholds(record);
    all.truncate(MAX_THRESHOLDS);
    let ticks: Vec<[usize; 3]> = all
        .iter()
        .map(|t| {
            [
                t.tick.saturating_sub(BEFORE),
                t.tick,
                t.followed.map_or(t.last, |tick| (tick + 6).min(t.last)),
            ]
        })
        .collect();
    let (width, height) = STRIP_SIZE;
    let images = pictures(studio, record, ticks.as_flattened(), STRIP_SIZE, done)?;
    let group = 3 * (width + GAP) + 2 * GAP;
    let row = 2 * LINE + height + 2 * GAP;
    let columns = 2u32.min(all.len() as u32).max(1);
    let rows = (all.len() as u32).div_ceil(columns).max(1);
    let mut out = Image::new(columns * group + GAP, rows * row + LINE + 2 * GAP, PAPER)?;
    let title =
        "every threshold: before - the player crosses - the camera follows (player's cell / eye's cell)";
    out.draw_text(title, GAP, GAP, INK, columns * group);
    for (k, (threshold, three)) in (0u32..).zip(all.iter().zip(images.chunks(3))) {
        let (left, top) = (GAP + k % columns * group, LINE + 2 * GAP + k / columns * row);
        let head = format!("{} > {}", name(guide, threshold.from), name(guide, threshold.to));
        out.draw_text(&head, left, top, BRIGHT, group - 2 * GAP);
        let Some(ticks) = ticks.get(k as usize) else {
            continue;
        };
        for (j, (image, &tick)) in (0u32..).zip(three.iter().zip(ticks)) {
            let x = left + j * (width + GAP);
            let low =
                |id: Option<CellId>| id.map_or("none".to_owned(), |id| format!("{:04X}", id.0 & 0xFFFF));
            let player = record.trail.get(tick).map(|step| step.cell);
            let eye = record.eyes.get(tick).and_then(|eye| eye.cell);
            let label = format!("{:.1} s  {} / {}", tick as f32 * TICK, low(player), low(eye));
            out.draw_text(&label, x, top + LINE, INK, width);
            out.blit(image, x, top + 2 * LINE);
        }
    }
    Ok(out)
}

/// The ticks that a film of a tour shows: around every threshold, and all that was run into; not the waiting.
pub fn film_ticks(record: &TourRecord) -> Vec<usize> {
    let mut out = BTreeSet::new();
    for threshold in thresholds(record) {
        let (first, last) = (threshold.tick.saturating_sub(FILM_REACH), threshold.tick);
        out.extend((first..=last).step_by(FILM_STEP));
        if let Some(followed) = threshold.followed {
            let first = followed.saturating_sub(FILM_REACH / 2).max(last);
            out.extend((first..(followed + FILM_REACH).min(threshold.last)).step_by(FILM_STEP));
        }
    }
    for trial in &record.summary.trials {
        let last = (trial.t / TICK) as usize;
        let walked = record
            .trail
            .iter()
            .take(last + 1)
            .rev()
            .take(200)
            .take_while(|step| !step.teleported)
            .count();
        out.extend((last.saturating_sub(walked)..=last).step_by(FILM_STEP));
    }
    out.retain(|&tick| tick < record.eyes.len());
    out.into_iter().collect()
}

/// The pictures of a film, each with a line that says when and where.
///
/// # Errors
/// The tour did not look, or `size` is out of range.
pub fn film(
    studio: &Studio<'_>,
    record: &TourRecord,
    guide: Option<&Guide>,
    size: (u32, u32),
    done: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Image>, StudioError> {
    let ticks = film_ticks(record);
    let images = pictures(studio, record, &ticks, size, done)?;
    let labelled = images.iter().zip(&ticks).map(|(image, &tick)| {
        let mut out = Image::new(size.0, size.1 + LINE, PAPER)?;
        let place = record
            .trail
            .get(tick)
            .map_or(String::new(), |step| name(guide, step.cell));
        let trial = record.summary.trials.iter().find(|trial| {
            let last = (trial.t / TICK) as usize;
            tick <= last
                && last - tick < 200
                && record
                    .trail
                    .iter()
                    .take(last)
                    .skip(tick + 1)
                    .all(|s| !s.teleported)
        });
        let what = trial.map_or(String::new(), |trial| format!("  {}", trial.trial));
        out.draw_text(
            &format!("{:.1} s  {place}{what}", tick as f32 * TICK),
            2,
            3,
            INK,
            size.0 - 2,
        );
        out.blit(image, 0, LINE);
        Ok(out)
    });
    labelled.collect()
}
