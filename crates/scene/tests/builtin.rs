//! The scenes that are part of the program.

use scene::Scene;

#[test]
fn every_builtin_scene_loads() {
    for name in Scene::builtin_names() {
        let scene = Scene::builtin(name).unwrap_or_else(|error| panic!("{}", error.render()));
        assert_eq!(scene.name, name);
        println!("{:?}\n{:?}", scene.start, scene.start_contacts);
    }
}
