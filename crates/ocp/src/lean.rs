//! How far a robot leans at the phase boundaries of a sequence: what its strides demand that cannot be done slowly.

use crate::collision::{Clearances, Watched};
use crate::motion::Planner;
use crate::program::{Grid, Phase};
use crate::settings::{Preset, Settings, Weights};
use multibody::{CenterOfMass, Kinematics};
use scene::{Owner, Role};
use symbolic::Contact;

impl Planner<'_> {
    /// How far the robot with what it carries leans over the feet that stay in contact at every phase boundary behind the first
    /// configuration: horizontal distance of the centre of mass from the middle of these feet, in its height above them. 0 where
    /// no foot stays, where a hand has hold of something fixed, and without gravity.
    ///
    /// `nodes` are keyframes of these phases.
    pub fn leans(&self, phases: &[Phase], nodes: &[Vec<f64>]) -> Vec<f64> {
        let settings = Settings::new(Preset::Default, &self.scene.optimiser);
        let settings = Settings {
            weights: Weights {
                balance: 1.0,
                ..settings.weights.clone()
            },
            ..settings
        };
        let nothing = Watched::new();
        let program = self.program(
            phases,
            &settings,
            Grid::OpenKeyframes,
            Clearances::Watched(&nothing),
        );
        let model = &program.system.model;
        let mut scratch = CenterOfMass::new(model);
        let mut kinematics = Kinematics::new(model);
        let holds = |c: Contact| {
            let [a, b] = [c.a, c.b].map(|i| &self.scene.interfaces[i.0]);
            let robot = matches!(a.owner, Owner::Robot { .. });
            robot && a.role != Role::Foot && matches!(b.owner, Owner::Static(_))
        };
        let lean = |t: usize| {
            let around = &phases[t - 1..phases.len().min(t + 1)];
            let is_held = around.iter().all(|phase| phase.state.iter().any(holds));
            let balance = program.nodes[t].balance.as_ref().filter(|_| !is_held);
            balance.map_or(0.0, |balance| {
                kinematics.update(model, &nodes[t]);
                balance.lean(model, &kinematics, &mut scratch)
            })
        };
        (1..=phases.len()).map(lean).collect()
    }
}
