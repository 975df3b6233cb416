//! No algorithm allocates after its workspace is made.

use multibody::{
    CenterOfMass, Centroidal, CentroidalDerivatives, Crba, Kinematics, Model, Rnea,
    RneaDerivatives, RneaHessian, Root,
};
use nalgebra::{DMatrix, Matrix6xX, Vector3, Vector6};
use spatial::Wrench;

#[track_caller]
fn assert_no_allocation(what: &str, run: impl FnOnce()) {
    let info = allocation_counter::measure(run);
    assert_eq!(
        info.count_total, 0,
        "{what} allocated {} bytes",
        info.bytes_total
    );
}

#[test]
fn the_counter_counts() {
    assert_eq!(
        allocation_counter::measure(|| drop(std::hint::black_box(vec![1.0; 8]))).count_total,
        1
    );
}

#[test]
fn algorithms_do_not_allocate() {
    let model = Model::random(1, Root::Floating, 20);
    let (nv, q) = (model.nv, model.random_configuration(1));
    let (v, a, w) = (vec![0.1; nv], vec![0.2; nv], vec![0.3; nv]);
    let mut moved = q.clone();
    let mut kinematics = Kinematics::new(&model);
    assert_no_allocation("integrate_into", || {
        model.integrate_into(&q, &v, &mut moved);
    });
    assert_no_allocation("Kinematics", || kinematics.update(&model, &q));
    let kinematics = kinematics;

    let (mut jacobian, mut hessian) = (Matrix6xX::zeros(nv), DMatrix::zeros(nv, nv));
    let y = Wrench::from_vector(&Vector6::repeat(1.0));
    assert_no_allocation("frame Jacobian", || {
        kinematics.frame_jacobian_in_frame(&model, 9, &mut jacobian);
    });
    assert_no_allocation("frame curvature", || {
        kinematics.add_frame_curvature(&model, 9, &y, &mut hessian);
    });

    let mut rnea = Rnea::new(&model);
    assert_no_allocation("Rnea", || {
        rnea.compute(&model, &kinematics, &v, &a);
    });
    let mut crba = Crba::new(&model);
    assert_no_allocation("Crba", || {
        crba.compute(&model, &kinematics);
    });
    let mut com = CenterOfMass::new(&model);
    assert_no_allocation("CenterOfMass", || {
        com.compute(&model, &kinematics);
        com.hessian(&model, &kinematics, &Vector3::z());
    });
    let mut centroidal = Centroidal::new(&model);
    assert_no_allocation("Centroidal", || {
        centroidal.compute(&model, &kinematics);
        centroidal.momentum(&v);
    });
    let mut derivatives = RneaDerivatives::new(&model);
    assert_no_allocation("RneaDerivatives", || {
        derivatives.compute(&model, &kinematics, &v, &a);
    });
    let mut second = RneaHessian::new(&model);
    assert_no_allocation("RneaHessian", || {
        second.compute(&model, &kinematics, &v, &a, &w);
    });
    let mut momentum = CentroidalDerivatives::new(&model);
    assert_no_allocation("CentroidalDerivatives", || {
        momentum.compute(&model, &kinematics, &v);
        momentum.compute_hessian(&model, &Vector6::repeat(1.0));
    });
}

#[test]
fn every_entry_is_written() {
    // scratch starts as NaN, so what is not written shows
    let model = Model::random(2, Root::Floating, 10);
    let (v, a, w) = (
        vec![0.1; model.nv],
        vec![0.2; model.nv],
        vec![0.3; model.nv],
    );
    let mut kinematics = Kinematics::new(&model);
    kinematics.update(&model, &model.random_configuration(2));
    let mut all: Vec<f64> = kinematics
        .column_in_world
        .iter()
        .flat_map(|column| column.iter().copied())
        .collect();
    let mut derivatives = RneaDerivatives::new(&model);
    derivatives.compute(&model, &kinematics, &v, &a);
    let mut hessian = RneaHessian::new(&model);
    hessian.compute(&model, &kinematics, &v, &a, &w);
    let mut momentum = CentroidalDerivatives::new(&model);
    momentum.compute(&model, &kinematics, &v);
    momentum.compute_hessian(&model, &Vector6::repeat(1.0));
    let mut com = CenterOfMass::new(&model);
    all.extend(com.compute(&model, &kinematics).1.iter());
    all.extend(com.hessian(&model, &kinematics, &Vector3::z()).iter());
    all.extend(Crba::new(&model).compute(&model, &kinematics).iter());
    let squares = [
        derivatives.dtau_dq(),
        derivatives.dtau_dv(),
        derivatives.dtau_da(),
        hessian.hessian_qq(),
        hessian.hessian_qv(),
        hessian.hessian_vv(),
        hessian.hessian_qa(),
        momentum.hessian_qq(),
        momentum.hessian_qv(),
    ];
    all.extend(squares.iter().flat_map(|matrix| matrix.iter()));
    all.extend(momentum.dh_dq().iter().chain(momentum.dh_dv().iter()));
    all.extend(
        hessian
            .gradient_q()
            .iter()
            .chain(hessian.gradient_v())
            .chain(hessian.gradient_a()),
    );
    assert!(all.iter().all(|x| x.is_finite()));
}
