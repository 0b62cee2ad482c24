//! What a component declares about itself as a whole.

/// Name, description and default experiment of a component.
///
/// ```
/// # use fmu_kit::Info;
/// const INFO: Info = Info { stop_time_s: 60.0, ..Info::new("Winch", "A winch with a drum brake") };
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Info {
    /// Model name and identifier: a C identifier, also the name of the FMU's library file.
    pub name: &'static str,
    /// One line for lists and menus.
    pub description: &'static str,
    /// Who wrote it.
    pub author: &'static str,
    /// Version of the component.
    pub version: &'static str,
    /// Who holds the copyright, and since when.
    pub copyright: &'static str,
    /// Terms of use.
    pub license: &'static str,
    /// Stop time of the default experiment in seconds (it starts at 0).
    pub stop_time_s: f64,
    /// Communication step of the default experiment in seconds.
    pub step_s: f64,
    /// Longest step of the co-simulation integrator in seconds; a communication step is divided
    /// into equal steps no longer than this.
    pub integrator_step_s: f64,
    /// The same while inputs change, if they limit the step more: a component that provides its own
    /// step for held inputs is then integrated by the classical Runge-Kutta method.
    pub moving_step_s: f64,
    /// Whether outputs change only at events (a sampled component); they are then declared
    /// `discrete`.
    pub sampled: bool,
    /// Whether the model-exchange interface is offered besides co-simulation.
    pub model_exchange: bool,
}

impl Info {
    /// A continuous component offering both interfaces, with a default experiment of 10 s in
    /// steps of 10 ms and an integrator step of 10 ms.
    #[must_use]
    pub const fn new(name: &'static str, description: &'static str) -> Self {
        Self {
            name,
            description,
            author: "",
            version: "",
            copyright: "",
            license: "",
            stop_time_s: 10.0,
            step_s: 0.01,
            integrator_step_s: 0.01,
            moving_step_s: f64::INFINITY,
            sampled: false,
            model_exchange: true,
        }
    }
}
