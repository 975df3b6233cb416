use super::*;

fn row(balls: Vec<Ball>, obstacle: Obstacle, pose: &Pose) -> f64 {
    let term = Distance::new(balls, obstacle, Pose::identity(), 0.0);
    let mut out = [f64::NAN];
    term.values(pose, &mut out);
    out[0]
}

#[test]
fn a_ball_over_the_middle_of_a_box_reads_its_gap() {
    let half = Vector3::new(0.3, 0.2, 0.1);
    let ball = vec![(Vector3::zeros(), 0.05)];
    let d = row(
        ball,
        Obstacle::Box(half),
        &Pose::from_translation(0.0, 0.0, 0.2),
    );
    assert!((d - 0.05).abs() < 1e-9, "{d}");
}

#[test]
fn balls_equally_near_read_a_little_less_and_far_ones_nothing() {
    let at = |x: f64| (Vector3::new(x, 0.0, 0.0), 0.05);
    let high = Pose::from_translation(0.0, 0.0, 0.1);
    let two = row(vec![at(-0.1), at(0.1)], Obstacle::HalfSpace, &high);
    assert!((two - (0.05 - EVENNESS * 2.0_f64.ln())).abs() < 1e-12);
    let away = row(
        vec![at(0.0)],
        Obstacle::HalfSpace,
        &Pose::from_translation(0.0, 0.0, 5.0),
    );
    assert!((away - 0.09).abs() < 1e-12, "levelled out: {away}");
    let far = (Vector3::new(0.0, 0.0, 0.5), 0.05);
    let one = row(vec![at(0.0), far], Obstacle::HalfSpace, &high);
    assert!((one - 0.05).abs() < 1e-12);
}

/// Against second differences of f(X exp(ξ)).
fn assert_hessian(balls: Vec<Ball>, obstacle: Obstacle, pose: &Pose) {
    let term = Distance::new(balls, obstacle, Pose::identity(), 0.0);
    let hessian = term.hessian(pose, &[1.0]);
    let h = 2e-5;
    let f = |xi: &Vector6<f64>| {
        let mut out = [f64::NAN];
        term.values(&(*pose * Pose::exp(xi)), &mut out);
        out[0]
    };
    let e = |i: usize, s: f64| Vector6::from_fn(|k, _| if k == i { s * h } else { 0.0 });
    for i in 0..6 {
        for j in 0..6 {
            let at = |s: f64, t: f64| f(&(e(i, s) + e(j, t)));
            let found =
                (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * h * h);
            let off = (hessian[(i, j)] - found).abs();
            assert!(
                off < 1e-5 / EVENNESS,
                "{i} {j}: {} {found}",
                hessian[(i, j)]
            );
        }
    }
}

#[test]
fn second_derivatives_are_those_of_the_value() {
    let half = Vector3::new(0.1, 0.08, 0.03);
    let balls = || {
        vec![
            (Vector3::new(0.02, -0.03, 0.05), 0.02),
            (Vector3::new(0.025, 0.03, 0.05), 0.02),
            (Vector3::new(-0.02, 0.0, 0.05), 0.02),
        ]
    };
    let tilted = Pose::exp(&Vector6::new(0.0, 0.0, 0.0, 0.1, -0.2, 0.3));
    let over = |x: f64, y: f64, z: f64| Pose::from_translation(x, y, z) * tilted;
    assert_hessian(balls(), Obstacle::HalfSpace, &over(0.0, 0.0, -0.02));
    assert_hessian(balls(), Obstacle::Box(half), &over(0.01, 0.0, 0.01));
    assert_hessian(balls(), Obstacle::Box(half), &over(0.1, 0.07, 0.01));
    let parts = || {
        vec![
            Part::Ball(Vector3::new(0.01, 0.0, 0.02), 0.03),
            Part::Box(
                Pose::exp(&Vector6::new(0.01, 0.0, 0.0, 0.3, 0.1, 0.0)),
                half,
            ),
        ]
    };
    assert_hessian(balls(), Obstacle::Parts(parts()), &over(0.1, 0.07, 0.01));
    assert_hessian(
        balls(),
        Obstacle::Parts(vec![Part::Ball(Vector3::new(0.01, 0.0, 0.02), 0.03)]),
        &over(0.02, 0.03, 0.03),
    );
}
