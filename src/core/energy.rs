//! The energy ledger: the discrete balance (56) with the works (57) and (58), step by step.
//!
//! For constant M, C, K the θ-step satisfies, whatever the percussions,
//!
//! ```text
//!   E_{k+1} − E_k = W_ext + W_damp + W_presc + (½−θ)(‖v_{k+1}−v_k‖²_M + ‖q_{k+1}−q_k‖²_K) + Σ_α u_{k+θ}·p      (56)
//!   W_ext  =  h v_{k+θ}·F_{k+θ}                                                                     (57)
//!   W_damp = −h v_{k+θ}·C v_{k+θ}                                                                   (58)
//!   W_presc = v_{k+θ}·R, with the impulses R that move the prescribed degrees of freedom
//! ```
//!
//! with E = ½ v·Mv + ½ q·Kq. What is left over, the imbalance, is round-off; anything more is an error of the
//! scheme. A contact work that is positive is an error of the law, or of the solver.

use crate::scalar::Scalar;

/// Energies of a state (J).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energies<T> {
    /// ½ v·Mv.
    pub kinetic: T,
    /// ½ q·Kq, and the energy of springs in the rows of the joints.
    pub elastic: T,
    /// −F₀·q, the potential of the constant forces; they are external in the balance (56).
    pub potential: T,
}

impl<T: Scalar> Energies<T> {
    /// The mechanical energy E of (56), kinetic and elastic.
    pub fn mechanical(&self) -> T {
        self.kinetic + self.elastic
    }

    /// E with the potential of the constant forces.
    pub fn total(&self) -> T {
        self.mechanical() + self.potential
    }
}

/// The terms of (56) over one step, or summed over many (J).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balance<T> {
    /// E_{k+1} − E_k, kinetic part.
    pub kinetic_change: T,
    /// E_{k+1} − E_k, elastic part.
    pub elastic_change: T,
    /// W_ext (57), and the work of motors in joints.
    pub external_work: T,
    /// W_damp (58), and the work of dampers and dry friction in joints.
    pub damping_work: T,
    /// v_{k+θ}·R, work of the impulses R that move the prescribed degrees of freedom.
    pub prescribed_work: T,
    /// (½−θ)(‖v_{k+1}−v_k‖²_M + ‖q_{k+1}−q_k‖²_K).
    pub numerical_dissipation: T,
    /// Σ_α u_{N,k+θ} p_N.
    pub normal_contact_work: T,
    /// Σ_α u_{T,k+θ}·p_T.
    pub tangential_contact_work: T,
    /// −F·Δq of what moves bodies beside h v_{k+θ}: the opening of overlaps of lasting contacts, and the way on from where fast
    /// bodies met within the step. It is potential energy, and stands beside (56).
    pub position_work: T,
    /// What (56) leaves over.
    pub imbalance: T,
}

impl<T: Scalar> Default for Balance<T> {
    fn default() -> Self {
        let zero = T::zero();
        Self {
            kinetic_change: zero,
            elastic_change: zero,
            external_work: zero,
            damping_work: zero,
            prescribed_work: zero,
            numerical_dissipation: zero,
            normal_contact_work: zero,
            tangential_contact_work: zero,
            position_work: zero,
            imbalance: zero,
        }
    }
}

impl<T: Scalar> Balance<T> {
    /// Fills in the imbalance from the other terms.
    pub(crate) fn close(&mut self) {
        let change = self.kinetic_change + self.elastic_change;
        let work = self.external_work + self.damping_work + self.prescribed_work + self.numerical_dissipation;
        self.imbalance = change - (work + self.normal_contact_work + self.tangential_contact_work);
    }

    /// Adds the terms of a step.
    pub fn accumulate(&mut self, step: &Self) {
        self.kinetic_change += step.kinetic_change;
        self.elastic_change += step.elastic_change;
        self.external_work += step.external_work;
        self.damping_work += step.damping_work;
        self.prescribed_work += step.prescribed_work;
        self.numerical_dissipation += step.numerical_dissipation;
        self.normal_contact_work += step.normal_contact_work;
        self.tangential_contact_work += step.tangential_contact_work;
        self.position_work += step.position_work;
        self.imbalance += step.imbalance;
    }
}
