//! Plans a scene without the command: `plan_scene SCENE OUT.json`.

use locotamp::{Event, Request};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let scene = match scene::Scene::builtin(&arguments[1]) {
        Ok(scene) => scene,
        Err(_) => scene::Scene::load(std::path::Path::new(&arguments[1]))?,
    };
    let outcome = locotamp::plan(&scene, &Request::default(), &mut |event| {
        match event {
            Event::Iteration {
                iteration,
                violation,
                objective,
                ..
            } => {
                if std::env::var("VERBOSE").is_ok() {
                    println!("{iteration:4} {objective:10.4} {violation:.2e}");
                }
            }
            other => println!("{other:?}"),
        }
        true
    })?;
    println!("{}, {:.1} s", outcome.ended, outcome.seconds);
    if let Some(found) = outcome.best {
        println!("{:#?}", found.summary);
        found.plan.write(std::path::Path::new(&arguments[2]))?;
    }
    Ok(())
}
