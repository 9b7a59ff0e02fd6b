//! Walks, runs, turns and jumps a player: `walk_a_player DAT_FOLDER "0xA9B40031 [155.4 20 94]"`.

use std::error::Error;

use vestibule_dat::DatSet;
use vestibule_physics::{Body, Locomotion, Motion, Placement, Population, Scratch};
use vestibule_world::World;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let (Some(folder), Some(start)) = (args.next(), args.next()) else {
        println!("usage: walk_a_player DAT_FOLDER POSITION");
        return Ok(());
    };
    let world = World::open(DatSet::open(folder)?)?;
    let mut population = Population::new();
    let mut scratch = Scratch::new();

    let mut body = Body::player();
    body.locomotion = Some(Locomotion::with_skills(200.0, 300.0));
    let player = population.add(body);
    let placed = population.set_position(&world, &mut scratch, player, &Placement::at(start.parse()?))?;
    println!("placed: {placed:?}");

    // What the player presses, and for how many frames of a thirtieth of a second.
    let script = [
        (
            Motion {
                forward: 1.0,
                ..Motion::default()
            },
            60,
        ),
        (
            Motion {
                forward: 1.0,
                turn: 1.0,
                run: true,
                ..Motion::default()
            },
            30,
        ),
        (
            Motion {
                sidestep: -1.0,
                ..Motion::default()
            },
            30,
        ),
    ];
    let mut frame = 0;
    for (motion, frames) in script {
        for _ in 0..frames {
            frame += 1;
            let now = f64::from(frame) * 0.034;
            if let Some(body) = population.body_mut(player) {
                body.set_motion(motion);
                if frame == 75 {
                    body.jump(1.0, now);
                }
            }
            population.update(&world, &mut scratch, player, now)?;
            for event in scratch.events() {
                println!("frame {frame}: {event:?}");
            }
        }
        if let Some(body) = population.body(player) {
            println!("frame {frame}: {}", body.position());
        }
    }
    Ok(())
}
