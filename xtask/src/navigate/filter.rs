//! The filters of `examples/baseline.ssd`.

/// A filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Filter {
    ModelAided,
    Dynamic,
    Inertial,
    ConstantAcceleration,
    PaperDynamic,
    PaperKinematic,
}

impl Filter {
    /// All of them.
    pub(crate) const ALL: [Self; 6] = [
        Self::ModelAided,
        Self::Dynamic,
        Self::Inertial,
        Self::ConstantAcceleration,
        Self::PaperDynamic,
        Self::PaperKinematic,
    ];
    /// Those that should reach the bound.
    pub(crate) const BEST: [Self; 3] = [Self::ModelAided, Self::Dynamic, Self::Inertial];

    /// The component in the system.
    pub(crate) fn component(self) -> &'static str {
        match self {
            Self::ModelAided => "filter",
            Self::Dynamic => "dynamic",
            Self::Inertial => "inertial",
            Self::ConstantAcceleration => "constant_acceleration",
            Self::PaperDynamic => "ekf_dynamic",
            Self::PaperKinematic => "ekf_kinematic",
        }
    }

    /// The FMU, whose name tables use for the filter.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::ModelAided => "NavModelAided",
            Self::Dynamic => "NavDynamic",
            Self::Inertial => "NavInertial",
            Self::ConstantAcceleration => "NavConstantAcceleration",
            Self::PaperDynamic => "EkfDynamic",
            Self::PaperKinematic => "EkfKinematic",
        }
    }

    /// Whether it is one of the paper's, which have no grades of inertial units.
    pub(crate) fn is_paper(self) -> bool {
        matches!(self, Self::PaperDynamic | Self::PaperKinematic)
    }
}
