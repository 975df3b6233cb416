//! Motions whichever way states follow from one another.

use super::keyframes::sequence;
use ocp::{Integrator, Planner, Settings};

#[test]
fn boxes_are_put_down_whatever_the_integrator() {
    let (scene, phases, settings) = sequence("tasks/stack.toml");
    let planner = Planner::new(&scene).expect("a model");
    let keyframes = planner.keyframes(&phases, &settings);
    assert!(keyframes.possible, "{:?}", keyframes.worst);
    for integrator in [
        Integrator::Euler,
        Integrator::SemiImplicitEuler,
        Integrator::ConstantAcceleration,
    ] {
        let settings = Settings {
            integrator,
            ..settings.clone()
        };
        let motion = planner.motion(&phases, &settings, &keyframes.nodes, &mut |_| true);
        assert!(motion.feasible, "{integrator:?}: {:?}", motion.worst);
    }
}
