//! Rows of numbers whose joints are in an order of their own, as in a file, to and from the order of a model.
//!
//! A row of configurations is the base (position, quaternion x y z w) and then one number per name; one of velocities is the
//! base's twist and then one number per name. Joints of the model without a name stay at zero.

use crate::{JointKind, Model};

/// Which entry of a row belongs to which joint of a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JointOrder {
    /// Per joint of the model.
    places: Vec<Place>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Base,
    Name(usize),
    Nowhere,
}

impl JointOrder {
    /// The order in which `names` come.
    ///
    /// # Errors
    /// The index of the first name that is no joint of one degree of freedom of the model.
    pub fn new(model: &Model, names: &[String]) -> Result<Self, usize> {
        let base = |kind: &JointKind| match kind {
            JointKind::FreeFlyer => Place::Base,
            _ => Place::Nowhere,
        };
        let mut places: Vec<_> = model.joints.iter().map(|x| base(&x.kind)).collect();
        for (index, name) in names.iter().enumerate() {
            let found = model.joint_id(name);
            let joint = found.filter(|id| model.joints[*id].kind.nq() == 1);
            places[joint.ok_or(index)?] = Place::Name(index);
        }
        Ok(Self { places })
    }

    /// Per joint of the model its first column in a row of configurations; `None`: it has none.
    pub fn columns(&self) -> impl Iterator<Item = Option<usize>> {
        self.places.iter().map(|place| place.column(7))
    }

    /// The configuration (length nq) of a row of `7 + names` numbers.
    ///
    /// # Panics
    /// If the row is too short.
    pub fn configuration(&self, model: &Model, row: &[f64]) -> Vec<f64> {
        let mut q = model.neutral();
        for (joint, place) in model.joints.iter().zip(&self.places) {
            if let Some(column) = place.column(7) {
                let n = joint.kind.nq();
                q[joint.idx_q..joint.idx_q + n].copy_from_slice(&row[column..column + n]);
            }
        }
        q
    }

    /// The velocity (length nv) of a row of `6 + names` numbers.
    ///
    /// # Panics
    /// If the row is too short.
    pub fn velocity(&self, model: &Model, row: &[f64]) -> Vec<f64> {
        let mut v = vec![0.0; model.nv];
        for (joint, place) in model.joints.iter().zip(&self.places) {
            if let Some(column) = place.column(6) {
                let n = joint.kind.nv();
                v[joint.idx_v..joint.idx_v + n].copy_from_slice(&row[column..column + n]);
            }
        }
        v
    }
}

impl Place {
    /// First column in a row that has `base` numbers for the base.
    fn column(self, base: usize) -> Option<usize> {
        match self {
            Self::Base => Some(0),
            Self::Name(index) => Some(base + index),
            Self::Nowhere => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Root;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|x| (*x).to_owned()).collect()
    }

    #[test]
    fn rows_are_sorted_by_name_and_what_has_none_stays_at_zero() {
        let model = Model::random(3, Root::Floating, 3);
        let order = JointOrder::new(&model, &names(&["joint_2", "joint_0"])).unwrap();
        let id = |name| &model.joints[model.joint_id(name).unwrap()];
        let q = order.configuration(&model, &[1.0, 2.0, 3.0, 0.6, 0.0, 0.0, 0.8, 0.2, 0.3]);
        assert_eq!(q[..7], [1.0, 2.0, 3.0, 0.6, 0.0, 0.0, 0.8]);
        let at = |name| q[id(name).idx_q];
        assert_eq!(
            [at("joint_0"), at("joint_1"), at("joint_2")],
            [0.3, 0.0, 0.2]
        );
        let v = order.velocity(&model, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        assert_eq!(v[..6], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let at = |name| v[id(name).idx_v];
        assert_eq!(
            [at("joint_0"), at("joint_1"), at("joint_2")],
            [8.0, 0.0, 7.0]
        );
        assert_eq!(order.columns().next(), Some(Some(0)));
    }

    #[test]
    fn a_name_that_is_no_joint_of_one_degree_is_told_by_its_index() {
        let model = Model::random(3, Root::Floating, 3);
        for bad in ["knee", "base"] {
            let order = JointOrder::new(&model, &names(&["joint_1", bad]));
            assert_eq!(order, Err(1), "{bad}");
        }
    }
}
