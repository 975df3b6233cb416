//! What the search asks of whoever knows the geometry.

use crate::contact::ContactState;

/// Answer of an [`Oracle`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing known against it.
    Accept,
    /// Impossible, with the reason in words.
    Reject(String),
    /// Impossible because these contacts can never occur together, with the reason in words.
    ///
    /// From now on every state that contains them counts as rejected.
    RejectContacts(ContactState, String),
}

/// What becomes of a beginning that is impossible if feet are set anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anew {
    /// It is possible: steps may help.
    Possible {
        /// Position of the state in which the feet were set anew.
        at: usize,
        /// How many swings that takes at least.
        swings: usize,
    },
    /// It is impossible as far as is known, but by little.
    Near,
    /// It is impossible, by far: no step helps.
    Far,
}

/// Judges contact states, transitions and beginnings of sequences; every method accepts by default.
///
/// A rejection must not depend on anything but the arguments: it is remembered and never asked again.
pub trait Oracle {
    /// Is there a configuration with these contacts? A rejected state is never entered again.
    fn state(&mut self, _state: &ContactState) -> Verdict {
        Verdict::Accept
    }

    /// The same while objects are where they are at the start, not having been moved yet. Asked for states that are accepted.
    fn unmoved(&mut self, _state: &ContactState, _objects: &[usize]) -> Verdict {
        Verdict::Accept
    }

    /// Can the one follow the other? Asked for states that are accepted.
    fn transition(&mut self, _from: &ContactState, _to: &ContactState) -> Verdict {
        Verdict::Accept
    }

    /// Can a sequence begin with s_1 … s_k? Asked before it is extended or returned; s_1 … s_{k−1} is accepted.
    fn prefix(&mut self, _states: &[&ContactState]) -> Verdict {
        Verdict::Accept
    }

    /// Could a sequence that is rejected as a whole begin with s_1 … s_k if the feet were set anew, on the same surfaces, in
    /// one of the states of these positions? `None` if nothing is known of that.
    fn set_anew(&mut self, _states: &[&ContactState], _at: &[usize]) -> Option<Anew> {
        None
    }

    /// True to have the search return without a sequence where it would begin to look in another place: what was asked since the last
    /// sequence has taken long. It can be resumed.
    fn pause(&mut self) -> bool {
        false
    }

    /// True to end the search at once (time limit, interrupt); it can be resumed.
    fn stop(&mut self) -> bool {
        false
    }
}

/// Accepts everything.
#[derive(Debug, Clone, Copy, Default)]
pub struct AcceptAll;

impl Oracle for AcceptAll {}
