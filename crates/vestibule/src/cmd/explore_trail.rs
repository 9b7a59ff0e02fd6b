//! `vestibule explore --trail`: what the window shows, as JSON lines.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use anyhow::Context as _;
use serde::Serialize;
use vestibule::view::FramePath;
use vestibule_explore::{Explorer, TrailStep, Watch};

/// A line. `t`, `cell` and `pos` are those of every trail; the rest is told once a frame, with its last step.
#[derive(Serialize)]
struct Row<'a> {
    /// Seconds.
    t: f64,
    cell: String,
    pos: [f32; 3],
    /// Where the player faces, degrees clockwise from north.
    heading: f32,
    #[serde(skip_serializing_if = "is_false")]
    teleport: bool,
    #[serde(flatten)]
    frame: Option<Frame<'a>>,
}

#[derive(Serialize)]
struct Frame<'a> {
    /// Name of the player's cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    /// The cell of the eye.
    #[serde(skip_serializing_if = "Option::is_none")]
    viewer: Option<String>,
    /// Where the frame begins: `outdoors`, `sees_out` or `sealed`.
    path: &'static str,
    /// Rooms that the traversal listed.
    rooms: usize,
    /// The eye of the camera that flies, in the frame of the viewer's landblock, while the traversal is held.
    #[serde(skip_serializing_if = "Option::is_none")]
    held: Option<[f32; 3]>,
    /// The message on the screen.
    #[serde(skip_serializing_if = "Option::is_none")]
    says: Option<&'a str>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "as serde wants it")]
fn is_false(value: &bool) -> bool {
    !*value
}

fn frame(explorer: &Explorer) -> Frame<'_> {
    Frame {
        name: explorer.name_of(explorer.player_cell()),
        viewer: explorer.viewer().and_then(|v| v.cell).map(|c| c.0.to_string()),
        path: match explorer.frame().path() {
            FramePath::Outdoors => "outdoors",
            FramePath::SeesOut => "sees_out",
            FramePath::Sealed => "sealed",
            _ => "nothing",
        },
        rooms: explorer.frame().floods().iter().map(|f| f.cells().len()).sum(),
        held: explorer.flying_at().map(|p| p.origin().into()),
        says: explorer.message(),
    }
}

/// Writes the steps since the frame before, and what is said if it is new.
fn write(out: &mut dyn Write, explorer: &Explorer, said: &mut Option<String>) -> std::io::Result<()> {
    let told = explorer.message().map(str::to_owned);
    let news = told.is_some() && told != *said;
    let mut steps = explorer.trail().to_vec();
    if steps.is_empty()
        && (news || explorer.is_frozen())
        && let Some(body) = explorer.body()
    {
        // Nobody moves while the traversal is held, but there is something to see.
        steps.push(TrailStep {
            seconds: explorer.clock(),
            cell: explorer.player_cell(),
            position: *body.position(),
            teleported: false,
        });
    }
    if !steps.is_empty() {
        *said = told;
    }
    let last = steps.len().saturating_sub(1);
    for (k, step) in steps.iter().enumerate() {
        let ahead = step.position.frame.local_to_global_vec(glam::Vec3::Y);
        let row = Row {
            t: step.seconds,
            cell: step.cell.to_string(),
            pos: step.position.origin().into(),
            heading: libm::atan2f(ahead.x, ahead.y).to_degrees().rem_euclid(360.0),
            teleport: step.teleported,
            frame: (k == last).then(|| frame(explorer)),
        };
        serde_json::to_writer(&mut *out, &row)?;
        writeln!(out)?;
    }
    out.flush()
}

/// What writes the trail to a file, or to standard output for `-`.
pub(super) fn watch(path: &Path) -> anyhow::Result<Watch> {
    let mut out: Box<dyn Write> = if path == Path::new("-") {
        Box::new(std::io::stdout())
    } else {
        let file = File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
        Box::new(BufWriter::new(file))
    };
    let mut said = None;
    Ok(Box::new(move |explorer| {
        write(&mut *out, explorer, &mut said).map_err(|e| format!("the trail ends here: {e}"))
    }))
}
