//! All parameters of a component: those of its author, followed by the integrator's if it has
//! continuous states.

use crate::author::{Component, Count, Declarations, Field, Member, Reader, Variables, Writer};

use super::integrator::Integrator;

/// Parameters of the author and of the kernel, one group of variables.
pub(crate) struct Parameters<C: Component> {
    pub(crate) author: C::Parameters,
    pub(crate) integrator: Integrator,
}

impl<C: Component> Parameters<C> {
    const INTEGRATES: bool = C::States::COUNT.reals > 0;

    /// The author's, with the default integrator.
    pub(crate) fn with(author: C::Parameters) -> Self {
        Self { author, integrator: Integrator::of(&C::INFO) }
    }
}

impl<C: Component> Variables for Parameters<C> {
    const COUNT: Count = if Self::INTEGRATES {
        C::Parameters::COUNT.plus(Integrator::COUNT)
    } else {
        C::Parameters::COUNT
    };

    fn declare(&self, at: &Field, into: &mut Declarations) {
        self.author.declare(at, into);
        if Self::INTEGRATES {
            let group = Member {
                name: "integrator",
                description: "Integrator of the co-simulation",
                ..Member::default()
            };
            self.integrator.declare(&at.member(&group), into);
        }
    }

    fn load(from: &mut Reader<'_>) -> Self {
        let mut parameters = Self::with(C::Parameters::load(from));
        if Self::INTEGRATES {
            parameters.integrator = Integrator::load(from);
        }
        parameters
    }

    fn store(&self, into: &mut Writer<'_>) {
        self.author.store(into);
        if Self::INTEGRATES {
            self.integrator.store(into);
        }
    }

    fn zip_reals(&mut self, other: &Self, f: &mut impl FnMut(&mut f64, f64)) {
        self.author.zip_reals(&other.author, f);
        if Self::INTEGRATES {
            self.integrator.zip_reals(&other.integrator, f);
        }
    }
}
