//! Moves a creature by displacements, as a server does that decides each step itself:
//! `move_a_creature DAT_FOLDER POSITION`.

use std::error::Error;

use glam::Vec3;
use vestibule_dat::DatSet;
use vestibule_physics::{Body, Locomotion, Placement, Population, Scratch};
use vestibule_world::{Sphere, World};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let (Some(folder), Some(start)) = (args.next(), args.next()) else {
        println!("usage: move_a_creature DAT_FOLDER POSITION");
        return Ok(());
    };
    let world = World::open(DatSet::open(folder)?)?;
    let mut population = Population::new();
    let mut scratch = Scratch::new();

    let spheres = [
        Sphere::new(Vec3::new(0.0, 0.0, 0.3), 0.3),
        Sphere::new(Vec3::new(0.0, 0.0, 0.6), 0.3),
    ];
    let drudge = population.add(Body::creature(&spheres, Locomotion::default())?);
    population
        .set_position(&world, &mut scratch, drudge, &Placement::at(start.parse()?))?
        .ok();

    for step in 0..20 {
        let Some(body) = population.body(drudge) else {
            break;
        };
        let mut to = *body.position();
        to.frame.origin += Vec3::new(0.2, 0.1, 0.0);
        let swept = population.move_to(&world, &mut scratch, drudge, &to)?;
        println!("{step}: {} hit {:?}", swept.position, swept.collision_normal);
        for touch in scratch.touched() {
            println!("    ran into {:?}", touch.object);
        }
    }
    Ok(())
}
