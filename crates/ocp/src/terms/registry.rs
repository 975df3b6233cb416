//! One example of every term, for the derivative test that walks them all.

use super::distance::{Distance, Obstacle, Part};
use super::{
    ForceTerm, PoseTerm,
    alignment::{Alignment, Tilted},
    approach::Approach,
    bounds::Bounds,
    friction::Friction,
    grasp::Grasp,
    half_space::HalfSpace,
    heading::Heading,
    height::{Beyond, Height},
    inverse::Inverse,
    place::Place,
    point_friction::PointFriction,
    pressure::Pressure,
    region::Region,
    sigmoid::Sigmoid,
    support_pressure::SupportPressure,
    tilt::Tilt,
    tilt_limit::TiltLimit,
    torsion::Torsion,
};
use nalgebra::Vector3;
use spatial::Pose;

/// Every kind of pose term once.
pub fn pose_terms() -> Vec<Box<dyn PoseTerm>> {
    let balls = vec![
        (Vector3::new(0.1, -0.2, 0.05), 0.04),
        (Vector3::new(-0.3, 0.0, 0.1), 0.02),
    ];
    let distance = |obstacle| Distance::new(balls.clone(), obstacle, Pose::random(4), 0.01);
    let half = Vector3::new(0.3, 0.2, 0.4);
    let sigmoid = |obstacle| Sigmoid {
        points: balls.clone(),
        obstacle,
        obstacle_from_b: Pose::random(4),
        slope: 15.0,
    };
    vec![
        Box::new(Height),
        Box::new(Inverse(distance(Obstacle::Box(half)))),
        Box::new(Beyond {
            points: vec![Vector3::new(0.1, -0.05, 0.0), Vector3::zeros()],
        }),
        Box::new(Alignment),
        Box::new(Tilted(0.2)),
        Box::new(Place { yaw: true }),
        Box::new(Place { yaw: false }),
        Box::new(Bounds {
            half_a: [0.1, 0.05],
            half_b: [0.3, 0.2],
        }),
        Box::new(HalfSpace {
            limb: Vector3::new(0.6, 0.0, -0.8),
        }),
        Box::new(Region {
            lower: Vector3::repeat(-1.0),
            upper: Vector3::repeat(1.0),
        }),
        Box::new(Tilt),
        Box::new(distance(Obstacle::Box(half))),
        Box::new(distance(Obstacle::HalfSpace)),
        Box::new(distance(Obstacle::Parts(vec![
            Part::Ball(Vector3::new(0.0, 0.1, 0.0), 0.05),
            Part::Box(Pose::random(8), half),
        ]))),
        Box::new(sigmoid(Obstacle::Box(half))),
        Box::new(sigmoid(Obstacle::HalfSpace)),
        Box::new(Approach {
            distance: 0.06,
            above: Some([0.02, -0.03]),
        }),
        Box::new(Approach {
            distance: 3.0,
            above: None,
        }),
        Box::new(Heading { half_width: 0.4 }),
        Box::new(TiltLimit { max: 0.3 }),
    ]
}

/// Every kind of force term once.
pub fn force_terms() -> Vec<Box<dyn ForceTerm>> {
    vec![
        Box::new(Friction {
            mu: 0.7,
            epsilon: 0.5,
            scale: 100.0,
        }),
        Box::new(PointFriction {
            mu: 0.6,
            epsilon: 0.5,
            scale: 10.0,
        }),
        Box::new(Pressure::new([0.03, -0.01], [0.085, 0.03], 3.0, 25.0)),
        Box::new(Torsion::new(0.03, 3.0)),
        Box::new(Grasp {
            max_force: 60.0,
            max_moment: Some(5.0),
        }),
        Box::new(Grasp {
            max_force: 60.0,
            max_moment: None,
        }),
        Box::new(SupportPressure {
            half_size: [0.2, 0.1],
            scale: 3.0,
        }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::ForceHessian;
    use nalgebra::{DMatrix, Matrix6, Vector6};
    use spatial::Random;

    const STEP: f64 = 1e-5;

    /// Aligned-ish relative poses, so that terms with a branch are tested on theirs.
    fn pose(seed: u64) -> Pose {
        let flip = Pose::exp(&Vector6::new(0.0, 0.0, 0.0, std::f64::consts::PI, 0.0, 0.0));
        let mut random = Random::new(seed);
        let xi = Vector6::from_fn(|i, _| random.uniform(-1.0, 1.0) * if i < 3 { 0.3 } else { 0.5 });
        flip.plus(&xi)
    }

    fn close(name: &str, what: &str, analytic: f64, numeric: f64, scale: f64) {
        let error = (analytic - numeric).abs();
        assert!(
            error < 2e-7 * scale.max(1.0),
            "{name}, {what}: {analytic} analytic, {numeric} by differences"
        );
    }

    #[test]
    fn pose_terms_match_central_differences() {
        for (number, term) in pose_terms().iter().enumerate() {
            for seed in 0..10 {
                let x = pose(seed + 100 * number as u64);
                let n = term.bounds().len();
                let values = |xi: &Vector6<f64>| {
                    let mut out = vec![0.0; n];
                    term.values(&x.plus(xi), &mut out);
                    out
                };
                let mut gradients = vec![Vector6::zeros(); n];
                term.gradients(&x, &mut gradients);
                let weights: Vec<f64> = (0..n).map(|i| 1.0 + 0.3 * i as f64).collect();
                let hessian = term.hessian(&x, &weights);
                let weighted = |xi: &Vector6<f64>| -> f64 {
                    values(xi).iter().zip(&weights).map(|(v, w)| v * w).sum()
                };
                for j in 0..6 {
                    let apart = |h: f64| -> Vec<f64> {
                        let (up, down) =
                            (values(&Vector6::ith(j, h)), values(&Vector6::ith(j, -h)));
                        up.iter().zip(&down).map(|(u, d)| u - d).collect()
                    };
                    let (one, two) = (apart(STEP), apart(2.0 * STEP));
                    for r in 0..n {
                        // Fourth order: the sharp distance has large third derivatives.
                        let numeric = (8.0 * one[r] - two[r]) / (12.0 * STEP);
                        close(term.name(), "gradient", gradients[r][j], numeric, 1.0);
                    }
                    for i in 0..6 {
                        let second = |h: f64| {
                            let (ei, ej) = (Vector6::ith(i, h), Vector6::ith(j, h));
                            (weighted(&(ei + ej)) - weighted(&(ei - ej)) - weighted(&(ej - ei))
                                + weighted(&(-ei - ej)))
                                / (4.0 * h * h)
                        };
                        // Richardson: the sharp distance has large fourth derivatives.
                        let numeric = (4.0 * second(3e-5) - second(6e-5)) / 3.0;
                        let scale = 200.0 * (1.0 + hessian.amax());
                        close(term.name(), "Hessian", hessian[(i, j)], numeric, scale);
                    }
                }
            }
        }
    }

    #[test]
    fn force_terms_match_central_differences() {
        for (number, term) in force_terms().iter().enumerate() {
            for seed in 0..10 {
                let x = pose(seed + 100 * number as u64);
                let mut random = Random::new(seed + 7);
                let w = Vector6::from_fn(|i, _| {
                    if i == 2 {
                        random.uniform(-40.0, -5.0)
                    } else {
                        random.uniform(-4.0, 4.0)
                    }
                });
                let n = term.bounds().len();
                let values = |z: &nalgebra::SVector<f64, 12>| {
                    let mut out = vec![0.0; n];
                    let xi = z.fixed_rows::<6>(0).into_owned();
                    term.values(&x.plus(&xi), &(w + z.fixed_rows::<6>(6)), &mut out);
                    out
                };
                let mut gradients = vec![(Vector6::zeros(), Vector6::zeros()); n];
                term.gradients(&x, &w, &mut gradients);
                let weights: Vec<f64> = (0..n).map(|i| 1.0 + 0.3 * i as f64).collect();
                let analytic = full(&term.hessian(&x, &w, &weights));
                let weighted =
                    |z: &_| -> f64 { values(z).iter().zip(&weights).map(|(v, w)| v * w).sum() };
                for j in 0..12 {
                    let e = nalgebra::SVector::<f64, 12>::ith(j, STEP);
                    let (up, down) = (values(&e), values(&-e));
                    for r in 0..n {
                        let g = if j < 6 {
                            gradients[r].0[j]
                        } else {
                            gradients[r].1[j - 6]
                        };
                        close(
                            term.name(),
                            "gradient",
                            g,
                            (up[r] - down[r]) / (2.0 * STEP),
                            1.0,
                        );
                    }
                    for i in 0..12 {
                        let h = 1e-3;
                        let ei = nalgebra::SVector::<f64, 12>::ith(i, h);
                        let ej = nalgebra::SVector::<f64, 12>::ith(j, h);
                        let numeric =
                            (weighted(&(ei + ej)) - weighted(&(ei - ej)) - weighted(&(ej - ei))
                                + weighted(&(-ei - ej)))
                                / (4.0 * h * h);
                        close(
                            term.name(),
                            "Hessian",
                            analytic[(i, j)],
                            numeric,
                            50.0 * (1.0 + analytic.amax()),
                        );
                    }
                }
            }
        }
    }

    fn full(h: &ForceHessian) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(12, 12);
        let copy = |m: &Matrix6<f64>| *m;
        out.view_mut((0, 0), (6, 6)).copy_from(&copy(&h.pose));
        out.view_mut((0, 6), (6, 6)).copy_from(&h.mixed);
        out.view_mut((6, 0), (6, 6)).copy_from(&h.mixed.transpose());
        out.view_mut((6, 6), (6, 6)).copy_from(&h.wrench);
        out
    }
}
