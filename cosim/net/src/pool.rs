//! What a worker reports about itself, and the orders it takes.

use serde::{Deserialize, Serialize};

/// A worker.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkerInfo {
    /// Its name.
    pub name: String,
    /// The machine's name.
    pub host: String,
    /// Version of cosim.
    pub version: String,
    /// Of the protocol.
    pub protocol: u8,
    /// Operating system and processor, as in FMI 2.0.4 platform tuples.
    pub platform: String,
    /// Processor features that matter for floating-point results.
    pub cpu: Vec<String>,
    /// The C library that its FMUs call, with the hash of its math functions.
    pub library: String,
    /// Process id of the supervisor.
    pub process: u32,
    /// What confines its FMUs.
    pub confined: String,
}

/// An order to start or stop an incarnation of a group.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Order {
    /// The run.
    pub run: String,
    /// The group.
    pub group: usize,
    /// Generation of the incarnation.
    pub generation: u32,
}

impl WorkerInfo {
    /// What results may depend on.
    pub fn computes(&self) -> String {
        let Self { platform, library, version, .. } = self;
        format!("{platform}, {}, {library}, cosim {version}", self.cpu.join(" "))
    }

    /// Its FMUs are not confined, although confinement was not switched off.
    pub(crate) fn is_loose(&self) -> bool {
        self.confined == cosim_confine::LOOSE
    }

    /// For this process.
    pub fn of_this(name: &str, confined: bool) -> Self {
        Self {
            name: name.to_owned(),
            host: host(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            protocol: super::wire::VERSION,
            platform: format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS),
            cpu: cpu(),
            library: super::library::describe(),
            process: std::process::id(),
            confined: cosim_confine::describe(confined),
        }
    }
}

/// The default name of a worker: the host name and the process id.
pub fn default_name() -> String {
    format!("{}-{}", host(), std::process::id())
}

fn host() -> String {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    name.trim().to_owned()
}

#[cfg(target_arch = "x86_64")]
fn cpu() -> Vec<String> {
    let present = [
        ("fma", std::arch::is_x86_feature_detected!("fma")),
        ("avx2", std::arch::is_x86_feature_detected!("avx2")),
        ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
    ];
    present.into_iter().filter(|(_, has)| *has).map(|(name, _)| name.to_owned()).collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn cpu() -> Vec<String> {
    Vec::new()
}
